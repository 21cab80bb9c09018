"""Bifurcation diagrams: eight, with the time of each, and 300 random places of each seen again.

python tools/bench.py diagrams [NAME ...] [--places 300]

Demchenko's curves besides are compared with the formulas of his regular precessions.

What a diagram says of a place - no motions, so many tori - is compared with motions.  Starts with
these values are sought in coordinates, from the declared integrals, by scipy's least squares; the
motions of all are integrated by ``vo.ensemble`` and belong to one torus where they come near each
other.  Of the disc, whose further integrals have no formula, the linear equations of q and s are
solved by scipy, and closed orbits are the stretches of the lean on which the rate of the lean is
real.  Nothing of this is shared with how the diagram counts.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import numpy as np
import sympy as sp
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

import voronec as vo
from voronec.equations.motions import Motions

SYSTEMS: dict[str, dict[str, Any]] = {
    "chaplygin-ball": {},
    "gyroscopic-ball-on-plane": {
        "between": {"energy": (-0.05, 1.2), "momentum squared": (-0.3, 5)}
    },
    "borisov-fedorov-ball": {},
    "veselova": {},
    "rubber-ball-on-plane": {},
    "rubber-ball-eps-minus-one": {},
    "falling-disc": {
        "at": {"s where theta = 0": 0.4},
        "between": {"energy": (0.9, 2), "q where theta = 0": (-1.5, 1.5)},
    },
    "bobylev-ball": {},
}
STARTS, PACES, INSTANTS = 12, 150, 700
"""Motions from each place, how many times the unit of the velocities they go, and instants."""
LONGER = 30
"""Motions that fill more tori than are told are followed so many times as long: they can only
come nearer to each other."""
CHUNK = 40
"""Places whose motions are held in memory together."""
NEAR = 0.05
"""Motions nearer than this part of the sizes of variables lie on one torus: near resonances they
are closed curves, and come no nearer."""
AWAY = 0.01
"""Places nearer than this part of the window to a curve are not looked at."""


def main() -> int:
    """Print a row for each diagram; 1 where a place disagrees."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*")
    parser.add_argument("--places", type=int, default=300)
    given = parser.parse_args()
    wrong = 0
    if not given.names or "demchenko" in given.names:
        print(f"demchenko: {_precessions()}", flush=True)
    for name in [n for n in given.names or SYSTEMS if n in SYSTEMS]:
        began, used = time.perf_counter(), time.process_time()
        diagram = vo.bifurcation_diagram(vo.load(name), **SYSTEMS[name])
        seconds, cpu = time.perf_counter() - began, time.process_time() - used
        places, told = _places(diagram, given.places)
        found = (_closed_orbits if name == "falling-disc" else _tori)(diagram, places, told)
        off = [(p, t, f) for p, t, f in zip(places.tolist(), told, found, strict=True) if t != f]
        counts = {n: told.count(n) for n in sorted({*told}, key=str)}
        print(
            f"{name}: {seconds:.1f} s ({cpu:.1f} s of CPU), {len(diagram.curves)} curves; "
            f"{len(places)} places, components told: {counts}; {len(places) - len(off)} agree",
            flush=True,
        )
        for place, said, seen in off[:12]:
            print(f"  ({place[0]:.6g}, {place[1]:.6g}): told {said}, found {seen}", flush=True)
        wrong += len(off)
    return 1 if wrong else 0


def _precessions() -> str:
    """By how much the points of Demchenko's curves miss the formulas of regular precessions,
    n = mu w x (P w - k)/(k - b1 w) with s = mu w sin u and tau = 0, which ``vo.precessions``
    derives from the quartic."""
    diagram = vo.bifurcation_diagram(vo.load("demchenko"), starts=25)
    inner, R2, mass, A, k = (float(p.value) for p in diagram.system.parameters)
    points = np.vstack([c.points for c in diagram.curves])
    u, s, tau, n = points.T
    mu, inertia = 1 + R2 / inner, mass * R2**2
    w, P, b1 = s / (mu * np.sin(u)), inertia + A, inertia * mu + A
    miss = np.abs(n * (k - b1 * w) - mu * w * np.cos(u) * (P * w - k)) / np.abs(k)
    return f"{len(points)} points miss the formulas by {max(miss.max(), np.abs(tau).max()):.1e}"


def _places(diagram: Any, count: int) -> tuple[np.ndarray, list[Any]]:
    """Random places away from curves, a half of them where there are motions; and what is told."""
    random, low = np.random.default_rng(7), diagram.window[:, 0]
    size = np.ptp(diagram.window, axis=1)
    on = np.vstack([
        (1 - s) * a + s * b
        for c in diagram.curves for a, b in zip(c.values[:-1], c.values[1:], strict=True)
        for s in np.linspace(0, 1, 20)
    ])  # fmt: skip
    tree = cKDTree((on - low) / size)
    places, told, empty = list[np.ndarray](), list[Any](), 0
    while len(places) < count:
        share = random.uniform(size=2)
        place = low + share * size
        number = diagram.raster.at(place)
        if number < 0 or tree.query(share)[0] < AWAY:
            continue
        components = diagram.regions[number].components
        empty += components == 0
        if components == 0 and empty > count // 2:
            continue
        places.append(place)
        told.append(components)
    return np.array(places), told


def _tori(diagram: Any, places: np.ndarray, told: list[Any]) -> list[int]:
    """How many tori the motions from each place fill."""
    system = diagram.system
    equations = vo.derive(system)
    motions, bridge = Motions.of(equations), equations.bridge
    field, values = motions.on_coordinates, {
        p.symbol: sp.nsimplify(p.value) for p in system.parameters
    }  # fmt: skip
    state = [*system.coordinates, *system.velocities]
    names = [*diagram.held, *diagram.axes]
    claims = [bridge.outward(field.read(system.integrals[n])).subs(values) for n in names]
    jacobian = sp.Matrix(claims).jacobian(state)
    value, slope = (sp.lambdify(state, f, "numpy", cse=True) for f in (claims, jacobian))
    random, owners, starts = np.random.default_rng(3), [], []
    width = len(system.coordinates)
    for k, place in enumerate(places):
        target, met = np.array([*diagram.held.values(), *place]), 0
        pace = np.sqrt(abs(place[0]) + 0.1) * 2
        for _ in range(3 * STARTS):
            begin = random.normal(size=len(state)) * np.repeat(
                [2.0, pace], [width, len(state) - width]
            )
            with np.errstate(all="ignore"):
                try:
                    end = least_squares(
                        lambda z, t=target: np.array(value(*z), float) - t, begin,
                        jac=lambda z: np.array(slope(*z), float), max_nfev=60, xtol=1e-15,
                        ftol=1e-15, gtol=1e-15,
                    )  # fmt: skip
                except ValueError:
                    continue
            if np.abs(end.fun).max() < 1e-9 * max(1, np.abs(target).max()):
                owners.append(k)
                starts.append(end.x)
                met += 1
            if met == STARTS or (not met and _ > 2 * STARTS):
                break
    found, longer = [0] * len(places), list[int]()
    for first in range(0, len(places), CHUNK):
        chosen = [i for i, k in enumerate(owners) if first <= k < first + CHUNK]
        for k, count in _count(diagram, state, starts, owners, chosen, 1).items():
            found[k] = count
            longer += [k] * (count > told[k])
    # the nearer motions are to a resonance, the longer they take to come near each other
    chosen = [i for i, k in enumerate(owners) if k in longer]
    for k, count in _count(diagram, state, starts, owners, chosen, LONGER).items():
        found[k] = count
    return found


def _count(
    diagram: Any, state: list[Any], starts: list[Any], owners: list[int], chosen: list[int],
    times: int,
) -> dict[int, int]:  # fmt: skip
    """How many tori the chosen motions of each place fill, followed so many times as long."""
    if not chosen:
        return {}
    system = diagram.system
    known = {*system.invariants, *map(str, system.velocities)}
    # (omega, gamma) = 0 of bodies that do not twist
    watched = [
        n if n in known else "-(omega1*gamma1 + omega2*gamma2)/gamma3"
        for n in diagram.map.variables
    ]
    until = times * PACES / float(np.abs(diagram.map.units[-1]))
    columns = np.array([starts[i] for i in chosen]).T
    run = vo.ensemble(
        system, dict(zip(map(str, state), columns, strict=True)), outputs=watched,
        times=np.linspace(0, until, times * INSTANTS), tol=1e-10,
    )  # fmt: skip
    paths = np.stack([run[name] for name in watched], axis=-1)
    found = {}
    for k in {owners[i] for i in chosen}:
        own = [p for i, p in zip(chosen, paths, strict=True)
               if owners[i] == k and np.isfinite(p).all()]  # fmt: skip
        found[k] = _clusters(own)
    return found


def _clusters(paths: list[np.ndarray]) -> int:
    """Motions that come as near to each other as to themselves belong together."""
    sizes = np.sqrt(np.mean([(p**2).mean(axis=0) for p in paths], axis=0)) + 1e-12
    trees = [cKDTree(p / sizes) for p in paths]
    graph = np.zeros((len(paths), len(paths)))
    spacing = [np.percentile(t.query(t.data, 2)[0][:, 1], 50) for t in trees]
    for i in range(len(paths)):
        for j in range(i):
            gap = trees[i].query(trees[j].data)[0].min()
            graph[i, j] = gap < max(NEAR, 2 * spacing[i], 2 * spacing[j])
    return int(connected_components(graph, directed=False)[0])


def _closed_orbits(diagram: Any, places: np.ndarray, _told: Any) -> list[int]:
    """How many stretches of the lean there are on which its rate is real."""
    m, R, A, C, g = (float(p.value) for p in diagram.system.parameters)
    (s,) = diagram.held.values()
    grid = np.linspace(0, np.pi / 2 - 1e-4, 20001)

    def slopes(theta: float, z: np.ndarray) -> list[float]:
        q, spin = z[:2]
        return [np.tan(theta) * q + C / A * spin, m * R**2 / (C + m * R**2) * q]

    found = []
    for energy, q in places:
        sides = [
            solve_ivp(slopes, (0, end[-1]), (q, s), t_eval=end, rtol=1e-10, atol=1e-12,
                      method="LSODA").y
            for end in (grid, -grid)
        ]  # fmt: skip
        z = np.hstack([sides[1][:, :0:-1], sides[0]])
        theta = np.concatenate([-grid[:0:-1], grid])
        rest = energy - (A * z[0] ** 2 + (C + m * R**2) * z[1] ** 2) / 2 - m * g * R * np.cos(theta)
        real = np.concatenate([[False], rest > 0, [False]])
        found.append(int((np.diff(real.astype(int)) == 1).sum()))
    return found
