"""The methods that compile, ``c`` and ``numba``: they move as scipy and Taylor's series do, keep
their code on disk, and are chosen where heyoka is missing."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import symengine as se
import sympy as sp

import voronec as vo
from voronec.algebra.numeric_functions import EXPM1, HYPOT, LOG1P, QUOTIENTS, SIZE
from voronec.declaration.whole_files import user_cache
from voronec.equations.program import Block, Program, compile_program
from voronec.equations.program.dialect import FUNCTIONS
from voronec.errors import DefinitionError, EngineLimit, IntegrationError
from voronec.motion import methods
from voronec.motion.steppers import kept_code, numba_stepper
from voronec.motion.steppers.c_stepper import c_loop
from voronec.motion.steppers.dop853_source import kernel_source

NO_COMPILER = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler here")
NO_NUMBA = pytest.mark.skipif(importlib.util.find_spec("numba") is None, reason="no numba here")
BY_C = pytest.param("c", marks=NO_COMPILER)
BY_NUMBA = pytest.param("numba", marks=(NO_NUMBA, pytest.mark.slow))
both = pytest.mark.parametrize("method", [BY_C, BY_NUMBA])

WORDS_OF_ONE = (*QUOTIENTS, EXPM1, LOG1P, SIZE)

x, kind, tau = sp.symbols("x kind tau")
DX = vo.velocity(x)
# a pendulum, and of the kind 2 what runs away; both by the same code, which takes long to compile
PENDULUM = vo.System(
    name="pendulum", fibration=vo.Fibration((x,), ()), forces={x: tau}, inputs=(tau,),
    lagrangian=DX**2 / 2 + (2 - kind) * sp.cos(x) + (kind - 1) * x**4 / 2,
    parameters=(vo.Parameter(kind, 1),),
)  # fmt: skip
TIMES = np.linspace(0, 30, 301)
EVENTS = (vo.Event(x, "middle"), vo.Event(DX - 1, "fast", 1), vo.Event(x - 1, "far"))


@pytest.fixture(scope="module", autouse=True)
def cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """A cache of our own for all tests here, since to compile takes seconds."""
    with pytest.MonkeyPatch.context() as patch:
        empty(tmp_path_factory.mktemp("cache"), patch)
        yield


def empty(folder: Path, patch: pytest.MonkeyPatch) -> None:
    """Nothing is kept: neither in memory nor in the cache, which is this folder from now on."""
    for name in ("XDG_CACHE_HOME", "LOCALAPPDATA", "HOME"):
        patch.setenv(name, str(folder))
    c_loop.cache_clear()
    numba_stepper.compiled_loop.cache_clear()


@pytest.fixture
def empty_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    empty(tmp_path, monkeypatch)
    yield
    c_loop.cache_clear()


def moved(method: str, inputs: Any = 0, **options: Any) -> vo.Trajectory:
    return vo.integrate(
        PENDULUM, initial={x: 1, DX: "0.3"}, inputs={tau: inputs}, method=method,
        **{"times": TIMES, "tol": 1e-11} | options,
    )  # fmt: skip


CASES = {"plain": (), "two": EVENTS[:2], "three": EVENTS, "one": EVENTS[2:]}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("method", "events"),
    [pytest.param(*way.values, case, marks=way.marks, id=f"{way.values[0]}-{name}")
     for way, names in ((BY_C, ("plain", "three", "one")), (BY_NUMBA, ("two",)))
     for name in names for case in [CASES[name]]],
)  # fmt: skip
def test_steps_are_those_of_scipy_and_states_too(method: str, events: tuple[vo.Event, ...]) -> None:
    here, there = (moved(m, dense=True, events=events) for m in (method, "scipy"))
    assert here.cost.method == method and here.cost.steps == there.cost.steps > 50
    within = np.sort(np.random.default_rng(5).uniform(0, 30, 200))
    error = {"c": 1e-12, "numba": 1e-11}[method]
    for name in ("x", "xdot"):
        assert np.abs(here[name] - there[name]).max() < error
        assert np.abs(here.at(within)[name] - there.at(within)[name]).max() < error
    for event in events:
        one, other = here.events[event.name], there.events[event.name]
        assert len(one.t) == len(other.t) > 3
        assert np.abs(one.t - other.t).max() < 1e-11


@both
def test_a_run_goes_backwards_and_agrees_with_taylor_series(method: str) -> None:
    fine = moved("flint", tol=1e-22, times=[0, 15, 30])
    here = moved(method, tol=1e-14, times=[0, 15, 30])
    assert np.abs(here["x"] - fine["x"].astype(float)).max() < 1e-12
    end = {x: float(here["x"][-1]), DX: float(here["xdot"][-1])}
    back = vo.integrate(
        PENDULUM, times=[30, 15, 0], initial=end, inputs={tau: 0}, method=method, tol=1e-14
    )
    assert abs(back["x"][-1] - 1) < 1e-12 and abs(back["xdot"][-1] - 0.3) < 1e-11


@pytest.mark.slow
@both
def test_an_event_ends_a_run_and_a_table_changes_it(method: str) -> None:
    stop = (vo.Event(x, "middle", stop=True), EVENTS[1])
    here, there = (moved(m, events=stop) for m in (method, "scipy"))
    assert here.stopped == "middle" and len(here) == len(there) < len(TIMES)
    assert abs(here.t[-1] - there.t[-1]) < 1e-11 and abs(here["x"][-1]) < 1e-11
    assert np.abs(here["x"] - there["x"]).max() < 1e-10
    held = vo.Table(np.linspace(0, 30, 7), [0, 0.2, -0.1, 0.3, 0, -0.4, 0.1], "held")
    linear = vo.Table([0, 10, 30], [0, 0.2, 0.1])
    for table in {"c": (held, linear), "numba": (held,)}[method]:  # each is compiled for itself
        here, there = (moved(m, table) for m in (method, "scipy"))
        assert len(here.t) == len(there.t) and np.abs(here["x"] - there["x"]).max() < 1e-10
    with pytest.raises(DefinitionError, match=r"function of Python's.*method='scipy'"):
        moved(method, lambda t: 0.0)


@pytest.mark.slow
@both
def test_many_motions_and_sections_go_by_it_as_by_scipy(method: str) -> None:
    starts = {"x": np.linspace(0.2, 1, 5), "xdot": 0.3}
    given = {"tol": 1e-11, "inputs": {tau: 0}}
    here, there = (
        vo.ensemble(PENDULUM, starts, times=TIMES, method=m, **given) for m in (method, "scipy")
    )
    assert (here.cost.method, there.cost.method) == (method, "scipy") and here.finished.all()
    assert here.cost.steps == there.cost.steps
    assert np.abs(here["x"] - there["x"]).max() < 1e-11
    cut, other = (
        vo.section(PENDULUM, x, crossings=20, starts=starts, method=m, **given)
        for m in (method, "scipy")
    )
    assert cut.cost.method == method and len(cut.t) == len(other.t) >= 100
    assert np.abs(cut.t - other.t).max() < 1e-9


# -- c ---------------------------------------------------------------------------------------------


@NO_COMPILER
@pytest.mark.slow
@pytest.mark.parametrize("name", ["bicycle", "falling-disc"])
def test_systems_of_the_catalogue_move_as_by_scipy(name: str) -> None:
    here, there = (vo.integrate(vo.load(name), method=m, tol=1e-11) for m in ("c", "scipy"))
    assert here.cost.method == "c"
    for output in here.outputs:
        assert np.abs(here[output] - there[output]).max() < 1e-8, output


@pytest.mark.slow
@NO_COMPILER
@pytest.mark.usefixtures("empty_cache")
def test_a_kept_library_is_read_and_a_damaged_one_is_named_and_made_anew(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    first = moved("c")["x"]
    (library,) = user_cache("code").rglob("*.so")
    with monkeypatch.context() as patch:  # nothing is compiled again
        patch.setattr("subprocess.run", None)
        c_loop.cache_clear()
        assert (moved("c")["x"] == first).all()
    content = bytearray(library.read_bytes())
    content[len(content) // 2] ^= 1
    library.unlink()  # the one that is loaded stays as it is
    library.write_bytes(content)
    c_loop.cache_clear()
    with pytest.warns(UserWarning, match="is damaged; it is made anew"):
        assert (moved("c")["x"] == first).all()
    c_loop.cache_clear()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert (moved("c")["x"] == first).all()


@pytest.mark.slow
@NO_COMPILER
@pytest.mark.usefixtures("empty_cache")
def test_what_cannot_be_kept_runs_all_the_same() -> None:
    first = moved("c")["x"]
    c_loop.cache_clear()
    folder = user_cache("code")
    shutil.rmtree(folder)
    folder.write_text("a file where the folder would be")
    assert (moved("c")["x"] == first).all()


@NO_COMPILER
@pytest.mark.usefixtures("empty_cache")
def test_without_a_compiler_and_with_a_bad_one_one_line_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "bin"
    folder.mkdir()
    monkeypatch.setenv("PATH", str(folder))
    with pytest.raises(DefinitionError, match=r"^there is no C compiler 'cc' here; .*'scipy'$"):
        moved("c")
    bad = folder / "cc"
    bad.write_text("#!/bin/sh\necho 'fatal error: no disk' >&2\nexit 1\n")
    bad.chmod(0o755)
    with pytest.raises(EngineLimit, match=r"'cc' failed: fatal error: no disk; use method='scipy'"):
        moved("c")
    bad.write_text("#!/bin/sh\n: > library.so\n")
    with pytest.raises(EngineLimit, match=r"the C compiler 'cc' failed: .*file too short"):
        moved("c")


@pytest.mark.parametrize("kind", ["ImportError", "OSError"])
def test_a_heyoka_that_cannot_be_imported_counts_as_absent(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "heyoka.py").write_text(f"raise {kind}('libtbb.so.12: no such file')\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "heyoka", raising=False)
    monkeypatch.setattr(methods, "IMPORT_ERRORS", {})
    many = {"times": TIMES, "tol": 1e-11, "inputs": {tau: 0}}
    reason = "heyoka is installed but cannot be imported: libtbb.so.12: no such file"
    with pytest.warns(UserWarning, match=f"{reason}; it counts as absent"):
        found = moved("auto", tol=1e-12)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # it is said once
        several = vo.ensemble(PENDULUM, {"x": [0.1, 0.2]}, **many)
        assert moved("auto", tol=1e-12).cost.reason == found.cost.reason
    for ask in (moved, lambda method: vo.ensemble(PENDULUM, {"x": [0, 1]}, method=method, **many)):
        with pytest.raises(DefinitionError, match=f"{reason}; 'pip install heyoka'"):
            ask("heyoka")
    assert found.cost.method != "heyoka" and reason in found.cost.reason
    assert several.cost.method != "heyoka" and reason in several.cost.reason
    assert reason in methods.METHODS["heyoka"].absence


@pytest.mark.slow
@NO_COMPILER
@pytest.mark.usefixtures("empty_cache")
def test_auto_takes_it_where_heyoka_is_not(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if sys.platform != "linux":
        pytest.skip("elsewhere it is not chosen")
    monkeypatch.setitem(sys.modules, "heyoka", None)
    many = {"times": TIMES, "tol": 1e-11, "inputs": {tau: 0}}
    assert vo.ensemble(PENDULUM, {"x": [0.1, 0.2]}, **many).cost.method == "c"
    found = moved("auto")
    assert found.cost.method == "c" and "heyoka is not installed" in found.cost.reason
    # a compiler that fails leaves the run to scipy
    (tmp_path / "cc").write_text("#!/bin/sh\nexit 1\n")
    (tmp_path / "cc").chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    c_loop.cache_clear()
    found = moved("auto")
    assert found.cost.method == "scipy" and "cc" in found.cost.reason


# -- numba -----------------------------------------------------------------------------------------


@NO_NUMBA
@pytest.mark.slow
def test_where_the_motion_ends_it_says_so() -> None:
    with pytest.raises(IntegrationError) as caught:
        vo.integrate(
            PENDULUM, times=[0, 0.5, 2], initial={x: 1, DX: 1}, parameters={kind: 2},
            inputs={tau: 0}, method="numba", tol=1e-9,
        )  # fmt: skip
    assert 0.99 < caught.value.time < 1.001


KEPT = r"""
import sys
from voronec.motion.steppers.kept_code import kept_function

MUCH = "".join(f"    y += sin(x + {i}) * cos(y - {i})\n" for i in range(30))
SOURCE = (
    "from math import cos, sin\n\n@jit\ndef inner(x):\n    y = 0.0\n" + MUCH
    + "    return %s + 0.0*y\n\n@jit\ndef drive(x):\n    return inner(x) + 0.0*inner(2*x)\n"
)
for text in sys.argv[1:]:
    print(kept_function("drive", "float64(float64)", text, lambda: SOURCE % text)(2.0))
"""


@NO_NUMBA
@pytest.mark.slow
def test_kept_codes_of_several_processes_are_not_taken_for_one_another(tmp_path: Path) -> None:
    env = {**os.environ, "XDG_CACHE_HOME": str(tmp_path)}

    def values(*texts: str) -> list[float]:
        command = [sys.executable, "-c", KEPT, *texts]
        found = subprocess.run(command, env=env, capture_output=True, text=True, check=True)
        return [float(x) for x in found.stdout.split()]

    assert values("x + 1") == [3]
    assert values("x*10") == [20]
    assert values("x + 1", "x*10") == [3, 20]
    assert values("x*10", "x + 1") == [20, 3]


@NO_NUMBA
@pytest.mark.slow
def test_kept_code_is_read_and_damaged_code_is_named_and_made_anew(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    first, read, folders = moved("numba"), kept_code.sound_source, []
    monkeypatch.setattr(kept_code, "sound_source", lambda f: folders.append(f) or read(f))
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
@NO_COMPILER
@pytest.mark.usefixtures("empty_cache")
def test_auto_takes_it_for_heavy_programs(monkeypatch: pytest.MonkeyPatch) -> None:
    if sys.platform != "linux" or methods.METHODS["heyoka"].absence:
        pytest.skip("elsewhere it is not chosen")
    assert moved("auto", tol=1e-12).cost.method == "heyoka"
    monkeypatch.setattr(methods, "HEAVY", 0)
    assert moved("auto").cost.method == "scipy", "a short run"
    monkeypatch.setattr(methods, "TINY", 0)
    found = moved("auto")
    assert found.cost.method == "c" and found.cost.reason == "auto: a heavy program"
    assert moved("auto", tol=1e-15).cost.method == "heyoka", "finer than it gets"


@pytest.mark.slow
@NO_COMPILER
@pytest.mark.parametrize(("name", "end"), [("chaplygin-ball-in-rn", 5.0), ("falling-disc", 1.0)])
def test_auto_takes_it_where_its_steps_cost_less_at_equal_error(name: str, end: float) -> None:
    if sys.platform != "linux" or methods.METHODS["heyoka"].absence:
        pytest.skip("elsewhere it is not chosen")
    given = {"times": np.linspace(0, end, 11)}
    fine = vo.integrate(vo.load(name), **given)
    assert fine.cost.method == "heyoka", "it comes no nearer than this"
    found = vo.integrate(vo.load(name), **given, tol=1e-9)
    assert found.cost.method == "c" and "cost less" in found.cost.reason
    assert np.abs(found.state - fine.state).max() < 1e-7
    assert vo.integrate(vo.load(name), **given, tol=1e-9).cost.reason == found.cost.reason


def damped(rate: float, tol: float) -> tuple[vo.Trajectory, float]:
    """vdot = -k (v - cos t) from v = 1, and the largest error of x and v."""
    k = sp.Symbol("k")
    system = vo.System(
        name="damped", fibration=vo.Fibration((x,)), lagrangian=DX**2 / 2,
        forces={x: -k * (DX - sp.cos(vo.time))}, parameters=(k,),
    )  # fmt: skip
    run = vo.integrate(system, parameters={k: rate}, initial={DX: 1}, times=np.arange(11), tol=tol)
    slow, quick = rate**2 / (rate**2 + 1), np.exp(-rate * run.t)
    v = slow * (np.cos(run.t) + np.sin(run.t) / rate) + (1 - slow) * quick
    way = slow * (np.sin(run.t) + (1 - np.cos(run.t)) / rate) + (1 - slow) * (1 - quick) / rate
    return run, float(max(np.abs(run["x"] - way).max(), np.abs(run["xdot"] - v).max()))


@pytest.mark.slow
def test_stiff_motions_are_recognised() -> None:
    """A damping that takes explicit methods 1.6 million steps, and one that does not."""
    run, error = damped(1e6, 1e-9)
    assert run.cost.method == "lsoda" and run.cost.steps < 5000 and error < 1e-8
    run, error = damped(10.0, 1e-9)
    assert run.cost.method != "lsoda" and error < 1e-8


@NO_NUMBA
@pytest.mark.slow
def test_auto_takes_it_for_long_runs_where_heyoka_is_missing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(methods, "which", lambda _: None)  # nor is there a C compiler
    monkeypatch.setitem(sys.modules, "heyoka", None)
    assert moved("auto").cost.method == "scipy", "not long enough to compile for"
    monkeypatch.setattr(methods, "COMPILATION", 1000)
    found = moved("auto")
    assert found.cost.method == "numba" and "heyoka is not installed" in found.cost.reason
    monkeypatch.setitem(sys.modules, "numba", None)
    assert moved("auto").cost.method == "scipy"
    with pytest.raises(DefinitionError, match="pip install numba"):
        moved("numba", events=(vo.Event(x - 1),))


@NO_NUMBA
@pytest.mark.slow
def test_ensembles_take_it_where_heyoka_is_missing_and_motions_are_many(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from voronec.motion import batches

    monkeypatch.setattr(methods, "which", lambda _: None)  # nor is there a C compiler
    monkeypatch.setitem(sys.modules, "heyoka", None)
    given = {"times": TIMES, "tol": 1e-11, "inputs": {tau: 0}}
    assert vo.ensemble(PENDULUM, {"x": [0.1, 0.2]}, **given).cost.method == "scipy"
    monkeypatch.setattr(batches, "COMPILATION", 1000)
    assert vo.ensemble(PENDULUM, {"x": [0.1, 0.2]}, **given).cost.method == "numba"
    monkeypatch.setitem(sys.modules, "numba", None)
    assert vo.ensemble(PENDULUM, {"x": [0.1, 0.2]}, **given).cost.method == "scipy"
    with pytest.raises(DefinitionError, match="pip install numba"):
        vo.ensemble(PENDULUM, {"x": [0.1, 0.2]}, method="numba", **given, outputs=("xdot",))


@pytest.mark.slow
@NO_NUMBA
def test_every_function_of_programs_is_known_to_numba() -> None:
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
    assert len(found) == len(results) > 25
    assert np.abs(np.array(found) - expected).max() < 1e-15
