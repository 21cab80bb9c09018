"""The first call of a motion: what it loads, compiles and chooses."""

from __future__ import annotations

import subprocess
import sys
from shutil import which

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import DOP853

import voronec as vo
from voronec.errors import IntegrationError
from voronec.motion import methods
from voronec.motion.request import Namespace
from voronec.motion.steppers.dop853_source import BENDS, FIFTH, STAGE_NODES, STEP, THIRD, WEIGHTS

SLOW = pytest.mark.slow
NO_COMPILER = pytest.mark.skipif(which("cc") is None, reason="there is no C compiler")
CALLS = """
import sys
sys.modules["heyoka"] = None  # as where it is not installed
import voronec as vo
system = vo.load("{name}")
for options in ({options}):
    cost = vo.integrate(system, **({{"times": 10, "tol": 1e-11}} | options)).cost
    print(cost.method, "numba" in sys.modules, "scipy.integrate" in sys.modules)
"""


def in_process(name: str, *options: dict[str, object]) -> list[list[str]]:
    """What a fresh Python says after each of several calls: the method, and what is loaded."""
    code = CALLS.format(name=name, options="".join(f"{o!r}, " for o in options))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return [line.split() for line in done.stdout.splitlines()]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ball-on-sphere", pytest.param("rattleback", marks=SLOW)])
def test_without_heyoka_a_short_motion_loads_neither_numba_nor_scipy(name: str) -> None:
    if sys.platform != "linux" or which("cc") is None:
        pytest.skip("there is no compiler to take")
    assert in_process(name, {}, {}) == [["c", "False", "False"]] * 2


@pytest.mark.slow
def test_the_choice_is_that_of_the_call_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(methods, "HEAVY", 1.0)
    system, given = vo.load("ball-on-sphere"), {"times": 10, "tol": 1e-11}
    for others in ({"times": 1000}, {"tol": 1e-14}):
        assert vo.integrate(system, **given | others).cost.method != "scipy"
    assert vo.integrate(system, **given).cost.method == "scipy"


@pytest.mark.slow
def test_where_heyoka_is_installed_it_integrates() -> None:
    pytest.importorskip("heyoka")
    assert vo.integrate(vo.load("ball-on-sphere"), times=10, tol=1e-11).cost.method == "heyoka"


@pytest.mark.slow
def test_a_short_run_of_a_heavy_program_is_not_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("heyoka")
    monkeypatch.setattr(methods, "HEAVY", 1.0)
    system, given = vo.load("ball-on-sphere"), {"times": 10, "tol": 1e-11}
    cost = vo.integrate(system, **given).cost
    assert cost.method == "scipy" and "compiling for heyoka" in cost.reason
    monkeypatch.setattr(methods, "TINY", 1000)
    monkeypatch.setattr(methods, "compiled_method", str)  # nothing else compiles
    assert vo.integrate(system, **given).cost.method == "heyoka"


def test_outputs_are_read_once() -> None:
    read = Namespace.of(vo.derive(vo.load("ball-on-sphere"))).read_condition
    for key in ("u1", "energy", sp.Symbol("u1") + 1):
        assert read(key) is read(key)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["ball-on-sphere", "demchenko", pytest.param("rattleback", marks=SLOW)]
)
@NO_COMPILER
def test_it_takes_the_steps_of_scipy_and_agrees_with_many_digits(name: str) -> None:
    system = vo.load(name)
    here, there, fine = (
        vo.integrate(system, times=10, method=method, tol=tol)
        for method, tol in (("c", 1e-11), ("scipy", 1e-11), ("flint", 1e-18))
    )
    assert here.cost.method == "c" and "asked for" in here.cost.reason
    # estimates of errors hold some 1e-3 of rounding: the last step may be next to none
    assert abs(here.cost.steps - there.cost.steps) <= 1
    assert abs(here.cost.evaluations - there.cost.evaluations) <= 15
    for output in here.outputs:
        size = max(1.0, float(np.abs(there[output]).max()))
        assert np.abs(here[output] - there[output]).max() < 1e-10 * size
        assert np.abs(here[output] - fine[output].astype(float)).max() < 1e-9 * size


X, Y = sp.symbols("x y")
DX, DY = vo.velocity(X), vo.velocity(Y)
PENDULUM = vo.System(
    name="pendulum", fibration=vo.Fibration((X,), ()), lagrangian=DX**2 / 2 + sp.cos(X)
)


@NO_COMPILER
def test_dense_output_events_and_time_that_runs_backwards() -> None:
    here, there = (
        vo.integrate(
            PENDULUM, times=np.linspace(5, -20, 41), method=m, tol=1e-11, dense=True,
            initial={X: 1, DX: "0.3"}, events=(vo.Event(X, "middle"), vo.Event(DX - 1, "fast", 1)),
        )
        for m in ("c", "scipy")
    )  # fmt: skip
    within = np.random.default_rng(3).uniform(-20, 5, 200)
    for output in ("x", "xdot"):
        assert np.abs(here.at(within)[output] - there.at(within)[output]).max() < 1e-11
    for event in ("middle", "fast"):
        one, other = here.events[event].t, there.events[event].t
        assert len(one) == len(other) > 1 and np.abs(one - other).max() < 1e-11


@NO_COMPILER
@pytest.mark.parametrize("force", [2 * Y**3, sp.sqrt(2 - Y) / 4 + 1], ids=["pole", "root"])
def test_a_motion_that_ends_is_no_arithmetic_error(force: sp.Expr) -> None:
    """y = 1/(1 - t), and a root of what becomes negative."""
    system = vo.System(
        name="end", fibration=vo.Fibration((Y,), ()), lagrangian=DY**2 / 2, forces={Y: force}
    )
    ends = []
    for method in ("c", "scipy"):
        with pytest.raises(IntegrationError) as caught:
            vo.integrate(system, times=[0, 0.5, 2], initial={Y: 1, DY: 1}, method=method, tol=1e-9)
        ends.append(caught.value.time)
    assert 0.5 < ends[0] < 1.001 and abs(ends[0] - ends[1]) < 1e-3


def test_coefficients_are_those_of_scipy() -> None:
    rows = [*DOP853.A, *DOP853.A_EXTRA, DOP853.B, DOP853.E5, DOP853.E3, *DOP853.D]
    for row, known in zip(rows, [*WEIGHTS, STEP, FIFTH, THIRD, *BENDS], strict=True):
        assert known == {i: float(x) for i, x in enumerate(row) if x}
    assert list(STAGE_NODES) == [*DOP853.C, *DOP853.C_EXTRA]


def test_where_nothing_moves_there_are_no_steps() -> None:
    free = vo.System(name="free", fibration=vo.Fibration((X,), ()), lagrangian=DX**2 / 2)
    found = vo.integrate(
        free, times=np.linspace(0, 1, 200), outputs=(DX,), initial={X: 0, DX: 1}, method="c"
    )
    assert "nothing moves" in found.cost.reason and (found["xdot"] == 1).all()


@pytest.mark.slow
def test_a_smooth_motion_loads_nothing_that_it_does_without() -> None:
    code = "; ".join(
        (
            "import sys, voronec as vo",
            "sys.modules['heyoka'] = None",
            "vo.integrate(vo.load('ball-on-sphere'), times=10)",
            "rare = ('voronec.motion.transitions.modes', 'voronec.motion.transitions.splits')",
            "print([n in sys.modules for n in ('importlib.metadata', 'numpy.random', *rare)])",
        )
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split("\n")[0] == "[False, False, False, False]"
