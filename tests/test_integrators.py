"""What every method of integration does, on scenes that differ in kind, whose motions are known.

``numba`` compiles for seconds: that its steps are those of scipy is in ``test_compiled_methods``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from shutil import which
from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.special import ellipj, ellipk

import voronec as vo

x, y, phi, v, w, a, k = sp.symbols("x y phi v w a k")
Dx, Dy, Dphi = map(vo.velocity, (x, y, phi))
ABSENT = {"heyoka": find_spec("heyoka") is None, "c": which("cc") is None}
METHODS = "heyoka", "scipy", "lsoda", "c", "flint"
BOUND = {"heyoka": 1e-12, "lsoda": 5e-10}
"""How far a motion may be off; of other methods 1e-11.  Drifts are a tenth of it at most."""


def bound(method: str) -> float:
    return BOUND.get(method, 1e-11)


@dataclass(frozen=True)
class Known:
    """A scene and what is known of it: a grid, outputs in closed form, where an event is."""

    system: vo.System
    initial: dict[Any, Any]
    grid: np.ndarray
    truth: Callable[[np.ndarray], dict[str, np.ndarray]]
    event: sp.Expr
    passages: Callable[[float], np.ndarray]  # up to a time
    way: int = 1


def pendulum() -> Known:
    """phi'' = -sin phi from rest at 2.5: an elliptic function of the time."""
    energy = Dphi**2 / 2 - sp.cos(phi)
    system = vo.System(
        name="pendulum", fibration=vo.Fibration(base=(phi,)),
        lagrangian=Dphi**2 / 2 + sp.cos(phi), integrals={"energy": energy},
    )  # fmt: skip
    quarter, modulus = float(ellipk(np.sin(1.25) ** 2)), np.sin(1.25)

    def truth(t: np.ndarray) -> dict[str, np.ndarray]:
        return {"phi": 2 * np.arcsin(modulus * ellipj(t + quarter, modulus**2)[0])}

    def passages(end: float) -> np.ndarray:
        return quarter * np.arange(3, end / quarter, 4)

    return Known(system, {phi: 2.5}, np.linspace(0, 30, 61), truth, phi, passages)


def driven() -> Known:
    """x'' = -4 x + cos 3t, from t = 0.4 on: the time stands in the equations."""
    system = vo.System(
        name="driven", fibration=vo.Fibration(base=(x,)), lagrangian=Dx**2 / 2 - k * x**2 / 2,
        forces={x: sp.cos(3 * vo.time)}, parameters=(vo.Parameter(k, 4),),
    )  # fmt: skip
    initial = {x: -sp.cos(sp.Rational(6, 5)) / 5, Dx: 3 * sp.sin(sp.Rational(6, 5)) / 5}

    def truth(t: np.ndarray) -> dict[str, np.ndarray]:
        return {"x": -np.cos(3 * t) / 5, "xdot": 3 * np.sin(3 * t) / 5}

    def passages(end: float) -> np.ndarray:
        return np.pi / 3 * np.arange(0.5, 3 * end / np.pi, 2)

    grid = 0.4 + np.array([0, 0.01, 3, 10])
    return Known(system, initial, grid, truth, x, passages)


def skate() -> Known:
    """A blade whose centre of mass lies above it goes round a circle: one coordinate of the fibre,
    velocities of a frame, parameters."""
    system = vo.System(
        name="skate", fibration=vo.Fibration(base=(x, phi), fibre=(y,)),
        frame=vo.Frame.quasi({v: Dx * sp.cos(phi) + Dy * sp.sin(phi), w: Dphi}),
        lagrangian=(Dx**2 + Dy**2 + a * Dphi**2) / 2, parameters=(vo.Parameter(a, 0.3),),
        constraints=(Dy * sp.cos(phi) - Dx * sp.sin(phi),),
        integrals={"energy": (v**2 + a * w**2) / 2, "spin": w},
    )  # fmt: skip

    def truth(t: np.ndarray) -> dict[str, np.ndarray]:
        # phi = -2 t, speed 3: the circle of radius 3/2
        return {"x": 1.5 * np.sin(2 * t), "y": 1.5 * np.cos(2 * t) - 1.5, "phi": -2 * t}

    def passages(end: float) -> np.ndarray:
        return np.pi / 2 * np.arange(1.5, 2 * end / np.pi, 2)

    initial = {x: 0, y: 0, phi: 0, v: 3, w: -2}
    return Known(system, initial, np.linspace(0, 7, 15), truth, y + 1.5, passages)


def runaway() -> Known:
    """x'' = x + x'/2 beside y'' = -y: one grows by e^9 where the other stays."""
    system = vo.System(
        name="runaway", fibration=vo.Fibration(base=(x, y)),
        lagrangian=(Dx**2 + x**2 + Dy**2 - y**2) / 2,
    )  # fmt: skip

    def truth(t: np.ndarray) -> dict[str, np.ndarray]:
        return {"x/cosh": np.ones_like(t), "y": np.sin(t)}

    def passages(end: float) -> np.ndarray:
        return np.pi * np.arange(2, end / np.pi, 2)

    return Known(system, {x: 1, Dy: 1}, np.linspace(0, 9, 10), truth, y, passages)


SCENES = {"pendulum": pendulum, "driven": driven, "skate": skate, "runaway": runaway}
TABLE = pytest.mark.parametrize(
    ("method", "scene"),
    [
        pytest.param(
            method, scene, id=f"{method}-{scene}",
            marks=[
                pytest.mark.skipif(ABSENT.get(method, False), reason=f"{method} is absent"),
                *([pytest.mark.slow] if method in ("lsoda", "flint") else ()),
            ],
        )
        for method in METHODS
        for scene in SCENES
    ],
)  # fmt: skip
pytestmark = [pytest.mark.contract, TABLE]


def run(method: str, known: Known, grid: Any = None, **more: Any) -> vo.Trajectory:
    outputs = [name for name in known.truth(known.grid) if "/" not in name]
    if "x/cosh" in known.truth(known.grid):
        outputs.append(x / sp.cosh(vo.time))
    return vo.integrate(
        known.system, times=known.grid if grid is None else grid, method=method,
        **{"initial": known.initial, "outputs": outputs} | more,
    )  # fmt: skip


def off(method: str, known: Known, found: Any, times: Any) -> None:
    """Outputs at times are the known ones."""
    times = np.asarray(times, dtype=float)
    for name, series in known.truth(times).items():
        ours = found[x / sp.cosh(vo.time)] if "/" in name else found[name]
        assert np.abs(np.asarray(ours, dtype=float) - series).max() < bound(method), name


def test_the_motion_is_the_known_one_and_integrals_stay(method: str, scene: str) -> None:
    known = SCENES[scene]()
    found = run(method, known)
    off(method, known, found, known.grid)
    assert found.cost.method == method and found.cost.steps > 0 and found.cost.seconds > 0
    assert set(found.drift) == set(known.system.integrals)
    assert max(found.drift.values(), default=0) < bound(method) / 10


def test_no_grid_changes_it_and_between_its_instants_it_is_known_as_well(
    method: str, scene: str
) -> None:
    known = SCENES[scene]()
    ends = known.grid[[0, -1]]
    found = run(method, known, ends, dense=True)
    off(method, known, found, ends)
    within = np.sort(np.random.default_rng(5).uniform(*ends, 40))
    off(method, known, found.at(within), within)


def test_backwards_it_returns(method: str, scene: str) -> None:
    known = SCENES[scene]()
    there = run(method, known, known.grid[:4], outputs=())
    last = dict(zip(there.names, there.state[-1], strict=True))
    back = run(method, known, known.grid[:4][::-1], initial=last)
    off(method, known, back, known.grid[:4][::-1])


def test_events_are_where_they_are_and_one_ends_the_run(method: str, scene: str) -> None:
    known = SCENES[scene]()
    up = vo.Event(known.event, "up", direction=1)
    found = run(method, known, events=(up, vo.Event(known.event + 100, "never")))
    places = known.passages(known.grid[-1])
    places = places[places > known.grid[0]]
    assert len(places) and len(found.events["up"].t) == len(places)
    assert np.abs(found.events["up"].t.astype(float) - places).max() < bound(method)
    assert not len(found.events["never"].t) and found.stopped == ""
    stopped = run(method, known, events=vo.Event(known.event, "end", direction=1, stop=True))
    assert stopped.stopped == "end" and abs(float(stopped.t[-1]) - places[0]) < bound(method)
    off(method, known, stopped, stopped.t)
