"""Sweeps: the numbers of single motions, in folders that whoever is killed leaves whole."""

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import voronec as vo
from voronec.sweeps.plan import SweepPlan

pytest.importorskip("zarr")
pytestmark = pytest.mark.slow

SLEIGH = vo.load("sleigh")
GRID = {"a": [0.1, 0.2, 0.3]}
DRAWS = vo.Draws(8, {"v": (-1, 1), "w": (0.1, 1)})
RECORD = ("final", "drift", "time(x=0.1)", "section(w=0.5)")
SMALL = {"grid": GRID, "starts": DRAWS, "record": RECORD, "times": 3, "chunk": 4, "jobs": 1}


def contents(folder):
    """The bytes of all that a sweep recorded; the header names the command that made it."""
    files = [p for p in Path(folder).rglob("*") if p.is_file() and p.name != "lock"]
    return {str(p.relative_to(folder)): p.read_bytes() for p in files if p.parent != Path(folder)}


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    return vo.sweep(SLEIGH, **SMALL, out=tmp_path_factory.mktemp("sweep") / "small.zarr")


def test_numbers_are_those_of_single_motions(small):
    data = small.to_xarray()
    assert data["final(x)"].dims == ("a", "start") and small.counts()["finished"] == 24
    points = small.points("section(w=0.5)")
    for i, j in ((0, 0), (1, 5), (2, 7)):
        initial = {name: float(data[name][j]) for name in ("v", "w")}
        one = vo.integrate(
            SLEIGH, times=[0, 3], initial=initial, parameters={"a": GRID["a"][i]},
            events=(vo.Event("x - 1/10", name="there"), vo.Event("w - 1/2", "up", direction=1)),
        )  # fmt: skip
        assert float(data["final(x)"][i, j]) == pytest.approx(one["x"][-1], abs=1e-11)
        assert float(data["drift(energy)"][i, j]) < 1e-12
        there = one.events["there"].t[:1] if len(one.events["there"]) else [np.nan]
        assert data["time(x=0.1)"].values[i, j] == pytest.approx(there[0], abs=1e-10, nan_ok=True)
        mine = points[points["row"] == 8 * i + j]
        assert mine["t"].to_numpy() == pytest.approx(one.events["up"].t, abs=1e-10)


def test_extremes_functions_and_names_of_ones_own(tmp_path):
    record = {"far": "max(x)", "near": "min(x)", "mean": np_mean, "end": "x**2"}
    found = vo.sweep(SLEIGH, starts={"v": [1, 2], "w": 0.5}, record=record, times=[0, 1, 2], jobs=1,
                     out=tmp_path / "a.zarr").to_xarray()  # fmt: skip
    one = vo.ensemble(SLEIGH, {"v": [1, 2], "w": 0.5}, times=[0, 1, 2], outputs=("x",))["x"]
    assert np.allclose(found["far"], one.max(axis=1)) and np.allclose(
        found["mean"], one.mean(axis=1)
    )
    assert np.allclose(found["near"], one.min(axis=1)) and np.allclose(
        found["end"], one[:, -1] ** 2
    )


def np_mean(run):
    return run["x"].mean()


def test_classes_of_traces_are_recorded_as_words(tmp_path):
    system = vo.load("demchenko")
    parameters = [*system.parameter_names]
    found = vo.sweep(system, record="class", out=tmp_path / "a.zarr", jobs=1).to_xarray()
    known = vo.closed_form(system).classes
    assert parameters and {f"class({title})" for title in known} <= {*found.data_vars}
    for title, label in known.items():
        assert found[f"class({title})"].values.tolist() == [str(label)]


@settings(deadline=None)
@given(
    st.lists(st.integers(1, 7), min_size=0, max_size=3), st.integers(0, 9), st.integers(1, 40)
)  # fmt: skip
def test_chunks_are_all_motions_once_and_in_order(lengths, starts, size):
    axes = {f"p{i}": np.arange(float(n)) for i, n in enumerate(lengths)}
    plan = SweepPlan(axes, {"q": np.arange(float(starts))} if starts else {}, size)
    rows = [plan.rows(n) for n in range(plan.chunks)]
    assert np.array_equal(np.concatenate(rows), np.arange(len(plan)))
    assert all(len(r) <= size for r in rows) and len(plan.dimensions) == len(plan.shape)
    mesh = np.meshgrid(*axes.values(), *([plan.starts["q"]] if starts else []), indexing="ij")
    for name, whole in zip((*axes, *plan.starts), mesh, strict=True):
        parts = [plan.columns(n)[name] for n in range(plan.chunks)]
        assert np.array_equal(np.concatenate(parts), whole.reshape(-1))


def test_draws_fill_their_ranges_and_follow_the_seed():
    draws = vo.Draws(256, {"v": (2, 3), "w": (-1, 1)})
    v = draws.values(7)["v"]
    assert np.array_equal(v, draws.values(7)["v"]) and not np.array_equal(v, draws.values(8)["v"])
    assert (np.histogram(v, 16, (2, 3))[0] == 16).all(), "points of Sobol' are even"
    uniform = vo.Draws(256, {"v": (2, 3)}, "uniform").values(7)["v"]
    assert 2 <= uniform.min() < 2.1 and 2.9 < uniform.max() < 3


def test_starts_on_one_level_share_the_integrals(tmp_path):
    ball = vo.load("chaplygin-ball")
    draws, record = vo.Draws(6, method="level"), ("energy", "momentum squared")
    found = vo.sweep(ball, starts=draws, record=record, times=1, out=tmp_path / "a.zarr", jobs=1)
    level = found.to_xarray()
    for name in ("final(energy)", "final(momentum squared)"):
        assert np.ptp(level[name].values) < 1e-10 * abs(float(level[name][0]))
    assert np.ptp(level["omega1"].values) > 0.1


def test_motions_that_fail_are_rows_with_reasons(tmp_path):
    masses = [-1.0, 1.0, -2.0, -3.0]  # the last chunk has no motion at all
    found = vo.sweep(SLEIGH, {"m": masses}, record=("final", "time(x=-0.1)"), times=1, chunk=2,
                     jobs=1, out=tmp_path / "a.zarr")  # fmt: skip
    data = found.to_xarray()
    assert data["finished"].values.tolist() == [False, True, False, False]
    assert [("m" in str(r)) for r in data["reason"].values] == [True, False, True, True]
    assert np.isnan(data["final(x)"].values).tolist() == [True, False, True, True]
    assert found.counts() == {"motions": 4, "finished": 1, "failed": 3}
    assert np.isfinite(data["time(x=-0.1)"].values).tolist() == [False, True, False, False]


@pytest.mark.parametrize("engine", ["threads", "processes"])
def test_whoever_computes_writes_the_same_bytes(small, engine, tmp_path):
    out = tmp_path / "a.zarr"
    if engine == "threads":
        with ThreadPoolExecutor(2) as pool:
            vo.sweep(SLEIGH, **SMALL, executor=pool, out=out)
    else:
        vo.sweep(SLEIGH, **{**SMALL, "jobs": 2}, out=out)
    assert contents(out) == contents(small.path)


def test_a_sweep_goes_on_where_it_was_stopped(small, tmp_path):
    out, shares = tmp_path / "a.zarr", []

    def stop(share):
        if share > 0.4:
            raise KeyboardInterrupt

    stopped = vo.sweep(SLEIGH, **SMALL, out=out, progress=stop)
    assert stopped.interrupted and 0 < stopped.counts()["finished"] < 24
    again = vo.sweep(SLEIGH, **SMALL, out=out, resume=True, progress=shares.append)
    assert 0 < shares[0] < 0.6 and shares == sorted(shares) and shares[-1] == 1
    assert not again.interrupted and contents(out) == contents(small.path)
    before = {p: p.stat().st_mtime_ns for p in out.rglob("*.json")}
    vo.sweep(SLEIGH, **SMALL, out=out)  # nothing is left to do
    assert before == {p: p.stat().st_mtime_ns for p in out.rglob("*.json")}


SCRIPT = """
import sys
sys.path.insert(0, {tests!r})
import voronec as vo
from test_sweeps import SLEIGH, SMALL
{call}
"""


def script(folder, call):
    file = folder / "script.py"
    file.write_text(SCRIPT.format(tests=str(Path(__file__).parent), call=call))
    return [sys.executable, str(file)]


def test_killed_at_any_moment_nothing_is_lost_or_doubled(small, tmp_path):
    chance = random.Random(4)
    out = tmp_path / "a.zarr"
    command = script(tmp_path, f"vo.sweep(SLEIGH, **SMALL, out={str(out)!r})")
    for _ in range(3):
        process = subprocess.Popen(command)
        while process.poll() is None and not (out / "log").is_dir():
            time.sleep(0.01)
        time.sleep(chance.random())
        process.send_signal(signal.SIGKILL)
        process.wait()
    vo.sweep(SLEIGH, **SMALL, out=out)
    assert contents(out) == contents(small.path)


def test_workers_that_die_on_a_cluster_cost_nothing(small, tmp_path):
    distributed = pytest.importorskip("distributed")
    chance, ended = random.Random(5), threading.Event()
    quiet = {"dashboard_address": None, "silence_logs": 50}
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, **quiet) as cluster,
        distributed.Client(cluster) as client,
    ):

        def kill():
            while not ended.wait(0.5 + chance.random()):
                # a worker that is killed while it starts is one that Dask gives up
                if len(client.scheduler_info()["workers"]) == 2:
                    os.kill(next(iter(cluster.workers.values())).pid, signal.SIGKILL)

        killer = threading.Thread(target=kill)
        killer.start()
        vo.sweep(SLEIGH, **SMALL, executor=client.get_executor(), out=tmp_path / "a.zarr")
        ended.set()
        killer.join()
    assert contents(tmp_path / "a.zarr") == contents(small.path)


def test_a_script_without_a_guard_is_told_so_in_one_line(tmp_path):
    call = "open('starts', 'a').write('x'); vo.sweep(SLEIGH, **{**SMALL, 'jobs': 2}, out='a.zarr')"
    done = subprocess.run(script(tmp_path, call), cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 1 and done.stderr.count("__main__':") == 1
    assert len((tmp_path / "starts").read_text()) <= 3  # its own, and one of each process
    assert "Traceback" not in done.stderr.partition("DefinitionError")[2]


def test_a_full_disk_and_a_second_writer_get_one_line(small, tmp_path):
    call = (
        "import resource, signal, sys\n"
        "sys.dont_write_bytecode = True\n"  # which would be cut short too
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "def full(share):\n"
        "    if share > 0.3: resource.setrlimit(resource.RLIMIT_FSIZE, (50, 50))\n"
        "try: vo.sweep(SLEIGH, **SMALL, out='a.zarr', progress=full)\n"
        "except vo.DefinitionError as error: print(error)\n"
    )
    done = subprocess.run(script(tmp_path, call), cwd=tmp_path, capture_output=True, text=True)
    assert "cannot be written: File too large" in done.stdout and done.stdout.count("\n") == 1
    kept = contents(tmp_path / "a.zarr")
    assert any("log/" in name for name in kept) and kept.items() <= contents(small.path).items()

    def second(share):
        if 0 < share < 1:
            with pytest.raises(vo.DefinitionError, match="another process writes"):
                vo.sweep(SLEIGH, **SMALL, out=tmp_path / "a.zarr")

    vo.sweep(SLEIGH, **SMALL, out=tmp_path / "a.zarr", progress=second)
    assert contents(tmp_path / "a.zarr") == contents(small.path)


@pytest.mark.skipif(not hasattr(os, "seteuid"), reason="there are no users")
def test_a_folder_that_cannot_be_written_or_looked_into_gets_one_line(small):
    """What is finished stays whole; root, whom nothing forbids, tries as another user."""
    user = os.geteuid()
    with tempfile.TemporaryDirectory() as made:
        shut, dark = Path(made, "shut"), Path(made, "dark")
        shutil.copytree(small.path, shut / "a.zarr")
        (shut / "a.zarr" / "log" / "000002.json").unlink()
        kept = contents(shut / "a.zarr")
        dark.mkdir()
        for folder, mode in ((made, 0o755), (dark, 0), *((p, 0o555) for p in shut.rglob("*"))):
            os.chmod(folder, mode)
        shut.chmod(0o555)
        try:
            if user == 0:
                os.seteuid(65534)
            for out in (shut / "new.zarr", shut / "a.zarr", dark / "a.zarr"):
                with pytest.raises(vo.DefinitionError, match="cannot be written: Perm") as caught:
                    vo.sweep(SLEIGH, **SMALL, out=out)
                assert "\n" not in str(caught.value)
        finally:
            os.seteuid(user)
            for folder in (shut, dark, *shut.rglob("*")):
                folder.chmod(0o755)
        assert contents(shut / "a.zarr") == kept and len(kept) > 1


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"grid": {"b": [1]}}, "no parameter, coordinate or velocity 'b'"),
        ({"grid": {"a": []}}, "list of finite numbers"),
        ({"grid": {"a": [np.nan]}}, "list of finite numbers"),
        ({"grid": {"a": [1]}, "starts": {"a": [1]}}, "in the grid and in the starts"),
        ({"starts": {"v": [1, 2], "w": [1, 2, 3]}}, "as many values of each"),
        ({"starts": [{"v": 1}, {"w": 1}]}, "all starts one form"),
        ({"starts": "v"}, "give arrays by name"),
        ({"record": "max(z)"}, "no record 'z'"),
        ({"record": "max"}, "say of what"),
        ({"record": "drift(q)"}, "integral 'q' is unknown"),
        ({"record": "class"}, "declares no traces"),
        ({"record": "time()"}, "say where"),
        ({"record": "time(x=y)"}, "record 'time"),
        ({"record": ()}, "name what is to be recorded"),
        ({"record": {"a": "x"}}, "'a' is taken"),
        ({"record": "__import__('os')"}, "not a formula"),
        ({"out": "a.npz"}, r"must end in \.zarr"),
        ({"out": "no/a.zarr"}, "there is no folder"),
        ({"out": "b.zarr", "resume": True}, "no sweep 'b.zarr' to go on with"),
        ({"seed": 2}, "another sweep, which differs in starts, seed;"),
        ({"times": 4, "tol": 1e-9}, "another sweep, which differs in times, tolerance;"),
        ({"method": "magic"}, "magic"),
        ({"grid": {"a": np.ones(10**5), "J": np.ones(10**6)}}, "motions take about"),
        ({"record": lambda run: run.t, "out": "c.zarr"}, "the function failed: TypeError"),
        ({"record": lambda run: 1.0, "jobs": 2, "chunk": 1, "out": "d.zarr"}, "cannot go to other"),
    ],
)
def test_bad_input_is_one_line_and_changes_nothing(change, message, small, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    out = change.get("out") or (small.path if {"seed", "times"} & {*change} else "a.zarr")
    before = contents(small.path)
    with pytest.raises(vo.DefinitionError, match=message) as caught:
        vo.sweep(SLEIGH, **{**SMALL, **change, "out": out})
    assert "\n" not in str(caught.value) and contents(small.path) == before
    assert not (tmp_path / "a.zarr").exists()


def test_what_another_version_computed_is_not_gone_on_with(tmp_path):
    out = vo.sweep(SLEIGH, GRID, record="x", times=1, out=tmp_path / "a.zarr", jobs=1).path
    header = json.loads((out / "zarr.json").read_text())
    header["attributes"]["digests"]["versions"] = header["attributes"]["digest"] = "0"
    (out / "zarr.json").write_text(json.dumps(header))
    with pytest.raises(vo.DefinitionError, match="differs in versions"):
        vo.sweep(SLEIGH, GRID, record="x", times=1, out=out, jobs=1)
    (tmp_path / "b.zarr").mkdir()
    with pytest.raises(vo.DefinitionError, match="is no folder of a sweep"):
        vo.sweep(SLEIGH, GRID, record="x", times=1, out=tmp_path / "b.zarr", jobs=1)


def test_a_sweep_is_saved_opened_and_drawn_like_all_results(small, tmp_path):
    xarray = pytest.importorskip("xarray")
    for suffix in ("npz", "parquet", "zarr"):
        opened = vo.open(small.save(tmp_path / f"copy.{suffix}"))
        xarray.testing.assert_equal(opened, small.to_xarray())
        assert opened.attrs["seed"] == 1 and opened["a"].attrs["long_name"]
    assert len(vo.Sweep(small.path).to_pandas()) == 24
    assert len(small.plot().axes) >= 6  # curves over one parameter
    assert len(small.plot(["section(w=0.5)"]).axes) == 1  # a cloud
    chart = vo.sweep(SLEIGH, {**GRID, "J": [0.4, 0.5]}, record="x", times=1, jobs=1,
                     out=tmp_path / "chart.zarr")  # fmt: skip
    assert len(chart.plot().axes) == 2  # and its bar of colours
    drawn = vo.sweep(SLEIGH, starts=DRAWS, record="x", times=1, out=tmp_path / "d.zarr", jobs=1)
    assert drawn.plot().axes[0].patches  # a histogram
    with pytest.raises(vo.DefinitionError, match="no numbers 'y'"):
        drawn.plot(["y"])


def test_the_command_does_what_the_call_does(call, small, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = ["sweep", "sleigh", "--grid", "a=0.1:0.3:3", "--draws", "8", "--range", "v=-1:1",
             "--range", "w=0.1:1", "--record", ",".join(RECORD), "--times", "3", "--chunk", "4",
             "--jobs", "1", "--out", "a.zarr", "--plot", "a.svg", "--json"]  # fmt: skip
    done = call(*words)
    assert done.status == 0 and json.loads(done.out)["finished"] == 24
    assert Path("a.svg").stat().st_size > 1000
    theirs, ours = vo.open("a.zarr"), small.to_xarray()
    assert np.allclose(theirs["final(x)"], ours["final(x)"], rtol=1e-13)
    assert call(*words, "--resume").status == 0
    Path("starts.csv").write_text("v,w\n1,0.5\n2,1/2\n")
    assert (
        call("sweep", "sleigh", "--starts", "starts.csv", "--times", "1", "--jobs", "1").status == 0
    )
    assert vo.open("sleigh-sweep.zarr")["w"].values.tolist() == [0.5, 0.5]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--grid", "a"], "--grid a: give NAME="),
        (["--grid", "a=1:2"], "give START:END:N"),
        (["--grid", "q=1,2"], "no parameter, coordinate or velocity 'q'"),
        (["--range", "v=0:1"], "--draws N"),
        (["--draws", "2", "--range", "v=1"], "NAME=LOW:HIGH"),
        (["--draws", "2", "--range", "v=1:0"], "must be (low, high)"),
        (["--draws", "2", "--starts", "a.csv"], "not both"),
        (["--starts", "no.csv"], "there is no file"),
        (["--out", "a"], "must end in .zarr"),
        (["--plot", "a.txt"], "--plot a.txt"),
        (["--resume"], "to go on with"),
        (["--scheduler", "tcp://127.0.0.1:9"], "does not answer"),
        (["--scheduler", "nonsense"], "does not answer"),
    ],
)
def test_wrong_words_end_with_status_2_and_one_line(call, words, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("voronec.sweeps.engines.ANSWER", 1)
    done = call("sweep", "sleigh", *words)
    assert done.status == 2 and message in done.err and done.err.count("\n") == 1
    assert not [*tmp_path.iterdir()]
