"""Sweeps: their cost beside heyoka's lanes by hand, their memory, and kills on a cluster of Dask.

    python tools/bench.py sweep [--motions 100000] [--kills 30] [--only cost|processes|open|kills]

Orbits of Chaplygin's ball to T = 10 at the tolerance 1e-9 from random spins and tilts, of which the
end, in the components of the vertical and of the angular velocity, and the drift of the integrals
are recorded; by hand the same components and the energy.  Every line is measured in processes of
its own: CPU-seconds with those of children, and the largest resident set.  Kills come at random
moments of one seed, to a worker, or to the whole process that sweeps, which is then started again;
at the end all bytes are compared with those of a sweep that nobody disturbed.
"""

from __future__ import annotations

import argparse
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

import voronec as vo
from figures.hand_programs import BY_HAND
from figures.table import markdown

END, TOLERANCE, SEED = 10.0, 1e-9, 1
STATE = ("gamma1", "gamma2", "gamma3", "omega1", "omega2", "omega3")
RANGES = {"omega1": (-1, 1), "omega2": (-1, 1), "omega3": (-1, 1), "theta": (0.5, 2.5)}
SMALL = 20_000
"""Motions of a sweep that is killed, in chunks of a hundred."""
PATIENCE = 30.0
"""Seconds within which a cluster starts a worker anew."""


def draws(count: int) -> vo.Draws:
    """The starts."""
    return vo.Draws(count, RANGES)


def sweep(count: int, out: str, jobs: int = 1, record: tuple[str, ...] = STATE) -> None:
    """The sweep, which says when its first progress came."""
    began, first = time.perf_counter(), list[float]()

    def progress(share: float) -> None:
        if share > 0 and not first:
            first.append(time.perf_counter() - began)

    vo.sweep(
        vo.load("chaplygin-ball"), starts=draws(count), record=(*record, "drift"), out=out,
        times=END, tol=TOLERANCE, jobs=jobs, seed=SEED, progress=progress,
    )  # fmt: skip
    print(f"first {first[0]:.2f}", flush=True)


def by_hand(count: int) -> None:
    """heyoka's lanes, one load after another, and what is read off at both ends."""
    import heyoka as hy

    ball = vo.load("chaplygin-ball")
    constants = {p.name: float(p.value) for p in ball.parameters}
    program, drawn = BY_HAND["chaplygin-ball"](constants), draws(count).values(SEED)
    tilt = drawn["theta"]
    known = {"gamma1": 0 * tilt, "gamma2": np.sin(tilt), "gamma3": np.cos(tilt), **drawn}
    rows = np.array([program.start({n: x[i] for n, x in known.items()}) for i in range(count)])
    width = hy.recommended_simd_size()
    states = np.resize(rows, (-(-count // width) * width, 6))
    batch = hy.taylor_adaptive_batch(program.equations, states[:width].T.copy(), tol=TOLERANCE)
    ends = np.empty_like(states)
    for place in range(0, len(states), width):
        batch.set_time(0.0)
        batch.state[:] = states[place : place + width].T
        batch.propagate_until(END)
        ends[place : place + width] = batch.state.T
    energies = [_energy(program.back(s), constants) for s in (states, ends)]
    print(f"first 0 drift {np.abs(energies[1] / energies[0] - 1).max():.1e}")


def _energy(found: Mapping[str, np.ndarray], p: Mapping[str, float]) -> np.ndarray:
    w, g = (np.stack([found[f"{n}{i}"] for i in (1, 2, 3)]) for n in ("omega", "gamma"))
    inertia = np.array([p["I1"], p["I2"], p["I3"]])[:, None]
    across = (w * w).sum(0) - (w * g).sum(0) ** 2
    return np.asarray(((inertia * w * w).sum(0) + p["m"] * p["R"] ** 2 * across) / 2)


def read(out: str) -> None:
    """Open a sweep and draw it."""
    began = time.perf_counter()
    data = vo.open(out)
    float(data["final(omega1)"].mean())
    opened = time.perf_counter() - began
    vo.Sweep(Path(out)).plot().savefig(os.devnull, format="png")
    print(f"open {opened:.2f} plot {time.perf_counter() - began - opened:.2f}")


def sweep_on_cluster(out: str, address: str) -> None:
    """A small sweep on a cluster."""
    from distributed import Client

    with Client(address, set_as_default=False) as client:
        vo.sweep(
            vo.load("chaplygin-ball"), starts=draws(SMALL), record=(*STATE, "drift"), out=out,
            times=END, tol=TOLERANCE, seed=SEED, chunk=100, executor=client.get_executor(),
        )  # fmt: skip


def measure(call: str, *words: Any) -> tuple[float, float, float, str]:
    """CPU-seconds, seconds, megabytes of a call of this module in a new process, what it said."""
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    code = f"from figures.sweeps import {call}; {call}(*{words!r})"
    code += "; import resource as r; print('memory', r.getrusage(r.RUSAGE_SELF).ru_maxrss)"
    done = subprocess.run([sys.executable, "-c", code], cwd=Path(__file__).parents[1],
                          capture_output=True, text=True, check=True)  # fmt: skip
    after, said = resource.getrusage(resource.RUSAGE_CHILDREN), done.stdout.split()
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    memory = int(said[said.index("memory") + 1]) / 1e3
    return cpu, time.perf_counter() - began, memory, " ".join(said[: said.index("memory")])


def cost(folder: Path, motions: int) -> list[list[str]]:
    """One process beside lanes by hand: the whole, and without the set-up, that of a small one."""
    rows, taken = list[list[str]](), dict[str, float]()
    for name, call, words in (
        ("sweep, one process", "sweep", lambda n, to: (n, to)),
        ("sweep with the place and Euler's angles", "sweep", lambda n, to: (n, to, 1, ("final",))),
        ("heyoka's lanes by hand", "by_hand", lambda n, to: (n,)),
    ):
        least = measure(call, *words(64, str(folder / f"{len(rows)}-few.zarr")))
        cpu, wall, memory, said = measure(call, *words(motions, str(folder / f"{len(rows)}.zarr")))
        taken[name] = (cpu - least[0]) / motions
        rows.append([name, f"{cpu:.1f}", f"{1e6 * taken[name]:.1f}", f"{wall:.1f}", f"{memory:.0f}",
                     said])  # fmt: skip
    return [*rows, ["ratio, set-up aside", "", *[
        f"{taken['sweep, one process'] / taken[rows[2][0]]:.2f}"], "", "", ""]]  # fmt: skip


def processes(folder: Path, motions: int) -> list[list[str]]:
    """Two processes beside one."""
    rows = []
    for jobs in (1, 2):
        cpu, wall, _, said = measure("sweep", motions, str(folder / f"p{jobs}.zarr"), jobs)
        rows.append([f"{jobs} processes", f"{cpu:.1f}", "", f"{wall:.1f}", "", said])
    return [*rows, ["load of the machine", f"{os.getloadavg()[0]:.1f}", "", "", "", ""]]


def opening(folder: Path, motions: int) -> list[list[str]]:
    """Opening and drawing."""
    out = folder / "open.zarr"
    sweep(motions, str(out))
    cpu, wall, memory, said = measure("read", str(out))
    return [["open and plot", f"{cpu:.1f}", "", f"{wall:.1f}", f"{memory:.0f}", said]]


def kills(folder: Path, count: int) -> list[list[str]]:
    """Kills at random moments; every file of the log and of the arrays is compared at the end."""
    chance, hit = random.Random(SEED), {"worker": 0, "sweep": 0}
    whole, out, rounds = folder / "whole.zarr", folder / "killed.zarr", 0
    with _cluster() as cluster:
        sweep_on_cluster(str(whole), cluster.scheduler_address)
    while sum(hit.values()) < count:
        rounds += 1
        shutil.rmtree(out, ignore_errors=True)
        with _cluster() as cluster:
            while _chunks(out) * 100 < SMALL and sum(hit.values()) < count:
                if not _one_kill(out, cluster, chance, hit):
                    break
        with _cluster() as cluster:
            sweep_on_cluster(str(out), cluster.scheduler_address)
        print(f"{hit}, in {rounds} sweeps", file=sys.stderr, flush=True)
        if _bytes(out) != _bytes(whole):
            return [["kills", f"{hit}: bytes differ", "", "", "", ""]]
    return [["kills", f"{sum(hit.values())}", f"{hit}, in {rounds} sweeps: the same bytes", "", "",
             ""]]  # fmt: skip


def _cluster() -> Any:
    from distributed import LocalCluster

    return LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs=50
    )  # fmt: skip


def _one_kill(out: Path, cluster: Any, chance: random.Random, hit: dict[str, int]) -> bool:
    """Whether the cluster has both its workers: Dask gives up one that is killed at birth."""
    given = str(out), cluster.scheduler_address
    code = f"from figures.sweeps import sweep_on_cluster as go; go{given!r}"
    process = subprocess.Popen([sys.executable, "-c", code], cwd=Path(__file__).parents[1],
                               stderr=subprocess.DEVNULL)  # fmt: skip
    before = _chunks(out)
    while process.poll() is None and _chunks(out) == before:
        time.sleep(0.02)
    time.sleep(chance.random())
    limit = time.perf_counter() + PATIENCE
    while len(cluster.scheduler_info["workers"]) < 2 and time.perf_counter() < limit:
        time.sleep(0.1)
    both = len(cluster.scheduler_info["workers"]) == 2
    what = chance.choice(["worker", "sweep"])
    if process.poll() is None:
        targets = [w.pid for w in cluster.workers.values() if w.pid]
        target = process.pid if what == "sweep" or not targets else chance.choice(targets)
        hit["sweep" if target == process.pid else "worker"] += 1
        os.kill(target, signal.SIGKILL)
        time.sleep(2 * chance.random())
        process.kill()
        hit["sweep"] += what == "worker"
    process.wait()
    return both


def _chunks(out: Path) -> int:
    return len([*out.glob("log/[0-9]*.json")])


def _bytes(folder: Path) -> dict[str, bytes]:
    files = [p for p in folder.rglob("*") if p.is_file() and p.name != "lock"]
    return {str(p.relative_to(folder)): p.read_bytes() for p in files if p.parent != folder}


PARTS: Mapping[str, Callable[[Path, int], list[list[str]]]] = {
    "cost": cost, "processes": processes, "open": opening, "kills": kills,
}  # fmt: skip


def main() -> int:
    """Measure, and print a table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--motions", type=int, default=100_000)
    parser.add_argument("--kills", type=int, default=30)
    parser.add_argument("--only", choices=[*PARTS], action="append")
    chosen = parser.parse_args()
    head = ["what", "CPU s", "us a motion", "s", "MB", "said"]
    with tempfile.TemporaryDirectory() as made:
        for name in chosen.only or PARTS:
            number = chosen.kills if name == "kills" else chosen.motions
            print(markdown(head, PARTS[name](Path(made), number)), flush=True)
    return 0
