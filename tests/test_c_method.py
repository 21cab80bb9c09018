"""The method ``c``: motions as by scipy, libraries that are kept, compilers that fail."""

from __future__ import annotations

import os
import shutil
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp

import voronec as vo
from voronec.declaration.whole_files import user_cache
from voronec.errors import DefinitionError, EngineLimit
from voronec.motion.steppers import choice
from voronec.motion.steppers.c_stepper import c_loop

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler here")

x, tau = sp.symbols("x tau")
DX = vo.velocity(x)
PENDULUM = vo.System(
    name="pendulum", fibration=vo.Fibration((x,), ()), lagrangian=DX**2 / 2 + sp.cos(x),
    forces={x: tau}, inputs=(tau,),
)  # fmt: skip
TIMES = np.linspace(0, 30, 301)
EVENTS = (vo.Event(x, "middle"), vo.Event(DX - 1, "fast", 1), vo.Event(x - 1, "far"))


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("XDG_CACHE_HOME", "LOCALAPPDATA", "HOME"):
        monkeypatch.setenv(name, str(tmp_path))
    c_loop.cache_clear()


def moved(method: str, inputs: Any = 0, **options: Any) -> vo.Trajectory:
    return vo.integrate(
        PENDULUM, initial={x: 1, DX: "0.3"}, inputs={tau: inputs}, method=method,
        **{"times": TIMES, "tol": 1e-11} | options,
    )  # fmt: skip


@pytest.mark.parametrize("events", [(), EVENTS, EVENTS[2:]], ids=["plain", "events", "one"])
def test_steps_are_those_of_scipy_and_states_too(events: Any) -> None:
    here, there = (moved(m, dense=True, events=events) for m in ("c", "scipy"))
    assert here.cost.method == "c" and here.cost.steps == there.cost.steps > 50
    within = np.sort(np.random.default_rng(5).uniform(0, 30, 200))
    for name in ("x", "xdot"):
        assert np.abs(here[name] - there[name]).max() < 1e-12
        assert np.abs(here.at(within)[name] - there.at(within)[name]).max() < 1e-12
    for event in events:
        times = (m.events[event.name].t for m in (here, there))
        np.testing.assert_allclose(*times, atol=1e-11)


def test_a_run_goes_backwards_and_agrees_with_taylor_series() -> None:
    here = moved("c", tol=1e-14, times=[0, 15, 30])
    assert np.abs(here["x"] - np.array(moved("flint", tol=1e-18, times=[0, 15, 30])["x"], float)
                  ).max() < 1e-12  # fmt: skip
    end = {x: here["x"][-1], DX: here["xdot"][-1]}
    back = vo.integrate(
        PENDULUM, times=[30, 15, 0], initial=end, inputs={tau: 0}, method="c", tol=1e-14
    )
    assert abs(back["x"][-1] - 1) < 1e-11 and abs(back["xdot"][-1] - 0.3) < 1e-11


def test_an_event_ends_a_run_and_a_table_changes_it() -> None:
    stop = (vo.Event(x, "middle", stop=True),)
    table = vo.Table([0, 10, 30], [0, 0.2, 0.1])
    for options in ({"events": stop}, {"inputs": table}):
        here, there = (moved(m, **options) for m in ("c", "scipy"))
        assert len(here.t) == len(there.t) and np.abs(here["x"] - there["x"]).max() < 1e-10
    with pytest.raises(DefinitionError, match="function of Python's"):
        moved("c", lambda t: 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rattleback", "bicycle", "demchenko", "falling-disc"])
def test_systems_of_the_catalogue_move_as_by_scipy(name: str) -> None:
    here, there = (vo.integrate(vo.load(name), method=m, tol=1e-11) for m in ("c", "scipy"))
    assert here.cost.method == "c"
    for output in here.outputs:
        assert np.abs(here[output] - there[output]).max() < 1e-8, output


def test_many_motions_and_sections_go_by_it_as_by_scipy() -> None:
    starts = {"x": np.linspace(0.2, 1, 5), "xdot": 0.3}
    here, there = (
        vo.ensemble(PENDULUM, starts, times=TIMES, method=m, tol=1e-11, inputs={tau: 0})
        for m in ("c", "scipy")
    )
    assert here.cost.method == "c" and here.cost.steps == there.cost.steps
    assert np.abs(here["x"] - there["x"]).max() < 1e-11
    cut, other = (
        vo.section(PENDULUM, x, crossings=20, starts=starts, method=m, tol=1e-11, inputs={tau: 0})
        for m in ("c", "scipy")
    )
    assert len(cut.t) == len(other.t) >= 100 and np.abs(cut.t - other.t).max() < 1e-9


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


def test_what_cannot_be_kept_runs_all_the_same(tmp_path: Path) -> None:
    first = moved("c")["x"]
    c_loop.cache_clear()
    shutil.rmtree(user_cache("code"))
    user_cache("code").write_text("a file where the folder would be")
    assert (moved("c")["x"] == first).all()


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


def test_auto_takes_it_where_neither_heyoka_nor_numba_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if sys.platform != "linux":
        pytest.skip("elsewhere it is not chosen")
    for name in ("heyoka", "numba"):
        monkeypatch.setitem(sys.modules, name, None)
    assert moved("auto").cost.method == "python", "a short run"
    monkeypatch.setattr(choice, "LOAD_OPERATIONS", 0)
    monkeypatch.setattr(choice, "COMPILATION", 1000)
    found = moved("auto")
    assert found.cost.method == "c" and "heyoka is not installed" in found.cost.reason
    # a compiler that fails leaves the run to scipy
    (tmp_path / "cc").write_text("#!/bin/sh\nexit 1\n")
    (tmp_path / "cc").chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    c_loop.cache_clear()
    found = moved("auto")
    assert found.cost.method == "scipy" and "cc" in found.cost.reason
