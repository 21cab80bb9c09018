"""The method ``numba``: the same motions as by scipy and heyoka, and code that is kept on disk."""

from __future__ import annotations

import os
import subprocess
import sys
import warnings

import numpy as np
import pytest
import symengine as se
import sympy as sp

import voronec as vo
from voronec.algebra.numeric_functions import EXPM1, HYPOT, LOG1P, QUOTIENTS, SIZE
from voronec.equations.program import Block, Program, compile_program
from voronec.equations.program.dialect import FUNCTIONS
from voronec.errors import DefinitionError, IntegrationError
from voronec.motion.steppers import choice, kept_code, numba_stepper
from voronec.motion.steppers.dop853_source import kernel_source

pytest.importorskip("numba")

WORDS_OF_ONE = (*QUOTIENTS, EXPM1, LOG1P, SIZE)

x, y, tau = sp.symbols("x y tau")
DX = vo.velocity(x)
PENDULUM = vo.System(
    name="pendulum", fibration=vo.Fibration((x,), ()), lagrangian=DX**2 / 2 + sp.cos(x),
    forces={x: tau}, inputs=(tau,),
)  # fmt: skip
START = {x: 1, DX: "0.3"}
TIMES = np.linspace(0, 30, 301)
EVENTS = (vo.Event(x, "middle"), vo.Event(DX - 1, "fast", 1))


@pytest.fixture(scope="module", autouse=True)
def cache(tmp_path_factory):
    """A cache of our own for all tests here, since to compile takes seconds."""
    place = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(place))
        patch.setenv("LOCALAPPDATA", str(place))
        patch.setenv("HOME", str(place))
        numba_stepper.compiled_loop.cache_clear()
        yield


def moved(method, inputs=0, **options):
    return vo.integrate(
        PENDULUM, initial=START, inputs={tau: inputs}, method=method,
        **{"times": TIMES, "tol": 1e-11} | options,
    )  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("events", [(), EVENTS], ids=["plain", "events"])
def test_steps_are_those_of_scipy_and_states_too(events):
    here, there = (moved(m, dense=True, events=events) for m in ("numba", "scipy"))
    assert here.cost.method == "numba" and here.cost.steps == there.cost.steps > 50
    within = np.sort(np.random.default_rng(5).uniform(0, 30, 200))
    for name in ("x", "xdot"):
        assert np.abs(here[name] - there[name]).max() < 1e-11
        assert np.abs(here.at(within)[name] - there.at(within)[name]).max() < 1e-11
    for event in events:
        one, other = here.events[event.name], there.events[event.name]
        assert len(one.t) == len(other.t) > 3
        assert np.abs(one.t - other.t).max() < 1e-11


@pytest.mark.slow
def test_it_agrees_with_taylor_series_and_runs_backwards():
    fine = moved("flint", tol=1e-22, times=[0, 15, 30])
    here = moved("numba", tol=1e-14, times=[0, 15, 30])
    assert np.abs(here["x"] - fine["x"].astype(float)).max() < 1e-12
    end = {x: float(here["x"][-1]), DX: float(here["xdot"][-1])}
    back = vo.integrate(
        PENDULUM, times=[30, 15, 0], initial=end, inputs={tau: 0}, method="numba", tol=1e-14
    )
    assert abs(back["x"][-1] - 1) < 1e-12


@pytest.mark.slow
def test_an_event_ends_a_run_and_a_table_changes_it():
    stop = (vo.Event(x, "middle", stop=True), EVENTS[1])
    here, there = (moved(m, events=stop) for m in ("numba", "scipy"))
    assert here.stopped == "middle" and len(here) == len(there) < len(TIMES)
    assert abs(here.t[-1] - there.t[-1]) < 1e-11 and abs(here["x"][-1]) < 1e-11
    table = vo.Table(np.linspace(0, 30, 7), [0, 0.2, -0.1, 0.3, 0, -0.4, 0.1], "held")
    here, there = (moved(m, table) for m in ("numba", "scipy"))
    assert np.abs(here["x"] - there["x"]).max() < 1e-10
    with pytest.raises(DefinitionError, match="method='scipy'"):
        moved("numba", lambda t: 0.0)


@pytest.mark.slow
def test_where_the_motion_ends_it_says_so():
    system = vo.System(
        name="runaway", fibration=vo.Fibration((y,), ()), lagrangian=vo.velocity(y) ** 2 / 2,
        forces={y: 2 * y**3},
    )  # fmt: skip
    with pytest.raises(IntegrationError) as caught:
        vo.integrate(
            system, times=[0, 0.5, 2], initial={y: 1, vo.velocity(y): 1}, method="numba", tol=1e-9
        )
    assert 0.99 < caught.value.time < 1.001


KEPT = r"""
import sys
from voronec.motion.steppers.kept_code import kept_function

MUCH = "".join(f"    y += sin(x + {i}) * cos(y - {i})\n" for i in range(200))
SOURCE = (
    "from math import cos, sin\n\n@jit\ndef inner(x):\n    y = 0.0\n" + MUCH
    + "    return %s + 0.0*y\n\n@jit\ndef drive(x):\n    return inner(x) + 0.0*inner(2*x)\n"
)
for text in sys.argv[1:]:
    print(kept_function("drive", "float64(float64)", text, lambda: SOURCE % text)(2.0))
"""


@pytest.mark.slow
def test_kept_codes_of_several_processes_are_not_taken_for_one_another(tmp_path):
    env = {**os.environ, "XDG_CACHE_HOME": str(tmp_path)}

    def values(*texts):
        command = [sys.executable, "-c", KEPT, *texts]
        found = subprocess.run(command, env=env, capture_output=True, text=True, check=True)
        return [float(x) for x in found.stdout.split()]

    assert values("x + 1") == [3]
    assert values("x*10") == [20]
    assert values("x + 1", "x*10") == [3, 20]
    assert values("x*10", "x + 1") == [20, 3]


@pytest.mark.slow
def test_kept_code_is_read_and_damaged_code_is_named_and_made_anew(monkeypatch):
    first, read, folders = moved("numba"), kept_code._sound_source, []
    monkeypatch.setattr(kept_code, "_sound_source", lambda f: folders.append(f) or read(f))
    numba_stepper.compiled_loop.cache_clear()
    with monkeypatch.context() as patch, warnings.catch_warnings():
        warnings.simplefilter("error")
        patch.setattr(numba_stepper, "kernel_source", None)  # nothing is written anew
        assert (moved("numba")["x"] == first["x"]).all()
    files = [p for p in folders[0].rglob("*.nbc") if p.stat().st_size > 1000]
    assert len(folders) == 1 and files and (folders[0] / kept_code.SOURCE).exists()
    for file in files:
        content = bytearray(file.read_bytes())
        content[len(content) // 2] ^= 1
        file.write_bytes(content)
    numba_stepper.compiled_loop.cache_clear()
    with pytest.warns(UserWarning, match="is damaged; it is made anew"):
        assert (moved("numba")["x"] == first["x"]).all()
    numba_stepper.compiled_loop.cache_clear()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert (moved("numba")["x"] == first["x"]).all()


@pytest.mark.slow
def test_auto_takes_it_for_long_runs_where_heyoka_is_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "heyoka", None)
    assert moved("auto").cost.method == "python", "a short run"
    monkeypatch.setattr(choice, "LOAD_OPERATIONS", 0)
    assert moved("auto").cost.method == "scipy", "not long enough to compile for"
    monkeypatch.setattr(choice, "COMPILATION", 1000)
    found = moved("auto")
    assert found.cost.method == "numba" and "heyoka is not installed" in found.cost.reason
    monkeypatch.setitem(sys.modules, "numba", None)
    monkeypatch.setenv("PATH", "")  # and no C compiler
    assert moved("auto").cost.method == "scipy"
    with pytest.raises(DefinitionError, match="pip install numba"):
        moved("numba", events=(vo.Event(x - 1),))


@pytest.mark.slow
def test_many_motions_and_sections_go_by_it_as_by_scipy():
    starts = {"x": np.linspace(0.2, 1, 5), "xdot": 0.3}
    both = [
        vo.ensemble(PENDULUM, starts, times=TIMES, method=m, tol=1e-11, inputs={tau: 0})
        for m in ("numba", "scipy")
    ]
    assert [e.cost.method for e in both] == ["numba", "scipy"] and both[0].finished.all()
    assert both[0].cost.steps == both[1].cost.steps
    assert np.abs(both[0]["x"] - both[1]["x"]).max() < 1e-11
    here, there = (
        vo.section(PENDULUM, x, crossings=20, starts=starts, method=m, tol=1e-11, inputs={tau: 0})
        for m in ("numba", "scipy")
    )
    assert here.cost.method == "numba" and len(here.t) == len(there.t) >= 100
    assert np.abs(here.t - there.t).max() < 1e-9


@pytest.mark.slow
def test_ensembles_take_it_where_heyoka_is_missing_and_motions_are_many(monkeypatch):
    from voronec.motion import batches

    monkeypatch.setitem(sys.modules, "heyoka", None)
    given = {"times": TIMES, "tol": 1e-11, "inputs": {tau: 0}}
    assert vo.ensemble(PENDULUM, {"x": [0.1, 0.2]}, **given).cost.method == "scipy"
    monkeypatch.setattr(batches, "COMPILATION", 1000)
    assert vo.ensemble(PENDULUM, {"x": [0.1, 0.2]}, **given).cost.method == "numba"
    monkeypatch.setitem(sys.modules, "numba", None)
    monkeypatch.setenv("PATH", "")  # and no C compiler
    assert vo.ensemble(PENDULUM, {"x": [0.1, 0.2]}, **given).cost.method == "scipy"
    with pytest.raises(DefinitionError, match="pip install numba"):
        vo.ensemble(PENDULUM, {"x": [0.1, 0.2]}, method="numba", **given, outputs=("xdot",))


def test_every_function_of_programs_is_known_to_numba():
    import numba

    a, b = se.symbols("a b")
    plain = [getattr(se, f)(a) for f in FUNCTIONS if f not in ("acosh", "atan2", "power")]
    plain += [se.acosh(1 + a), se.atan2(a, b), a**b, a**5, a ** se.Rational(3, 2), se.pi / 3]
    ours = [se.function_symbol(f, a) for f in WORDS_OF_ONE] + [se.function_symbol(HYPOT, a, b)]
    results = tuple(map(se.sympify, [*plain, *ours]))
    names = tuple(map(str, range(len(results))))
    program = Program(se.Symbol("t"), (a, b), (), (), Block((), (a, b)), names, Block((), results))
    namespace = {"np": np, "jit": numba.njit(error_model="numpy")}
    exec(kernel_source(program, program), namespace)
    found = namespace["extras"](0.0, 0.3, 0.7, np.zeros(0))
    expected = compile_program(program, scalar=True)[1](0.0, [0.3, 0.7], [])
    assert len(found) == len(results) > 30
    assert np.abs(np.array(found) - expected).max() < 1e-15
