"""Models on disk: a motion is the same bit for bit, wherever its model came from."""

from __future__ import annotations

import subprocess
import sys
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import voronec as vo
from voronec.declaration import source_digest
from voronec.motion.formulation import model_cache, smallest
from voronec.motion.steppers import heyoka_stepper

BALL = {"u": 1.1, "v": 0.3, "u1": 1, "omega1": 0.7, "omega2": -0.4, "omega3": 0.5}
MOTIONS = [
    ("ball-on-sphere", ("u", "v", "omega1"), {}),
    ("ball-on-sphere", ("u", "v", "omega1"), {"omega3": 0}),  # other zeros, another model
    ("demchenko", ("u", "v"), {}),
    ("demchenko", ("u", "v"), {"n": 0}),
    ("rattleback", ("omega3",), {}),
    ("sleigh", ("x", "y", "phi"), {}),
]


@pytest.fixture
def shelf(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder for models."""
    monkeypatch.setattr(model_cache, "user_cache", lambda part: tmp_path / part)
    monkeypatch.setattr(heyoka_stepper, "IDLE", 0)  # no run takes the integrator of another
    return tmp_path / "models"


def motion(name: str, outputs: tuple[str, ...], initial: dict[str, float], method: str = "heyoka"):
    """A motion of a system that nobody has derived in this process."""
    system = replace(vo.load(name))
    scene = "default" if "default" in system.scenes else next(iter(system.scenes))
    run = vo.integrate(
        system, scene, times=np.linspace(0, 3, 400), outputs=outputs, initial=initial, method=method
    )
    return np.stack([run[name] for name in outputs])


@pytest.fixture
def no_formulations(monkeypatch: pytest.MonkeyPatch):
    """Call it, and formulations can no longer be derived."""

    def refused(*_: object) -> None:
        raise AssertionError("the formulations are derived")

    def forbid() -> None:
        monkeypatch.setattr(smallest, "coordinates_formulation", refused)
        monkeypatch.setattr(smallest, "invariants_formulation", refused)

    return forbid


@pytest.mark.slow
def test_a_motion_from_the_disk_is_the_fresh_one_bit_for_bit(shelf, no_formulations) -> None:
    fresh = []
    for name, outputs, initial in MOTIONS:
        for file in shelf.glob("*"):
            file.unlink()  # nothing went before
        fresh.append(motion(name, outputs, initial))
    again = [motion(*each) for each in MOTIONS]  # the second ball finds the first one's
    no_formulations()
    kept = [motion(*each) for each in MOTIONS]
    for one, two, three in zip(fresh, again, kept, strict=True):
        assert np.array_equal(one, two) and np.array_equal(one, three)


KINDS = {
    "sleigh": [
        ({}, {}, 3.0), ({"w": 0}, {}, 3.0), ({"v": 2, "w": 0.3}, {"a": 0}, 3.0), ({}, {}, -2.0),
        ({"v": 0.5, "xdot": 0.5}, {"m": 3}, 1.0),
    ],
    "demchenko": [({}, {}, 3.0), ({"n": 0}, {}, 3.0), ({"s": 0.3}, {"k": 0}, 2.0)],
    "ball-on-sphere": [({}, {}, 2.0), ({"omega3": 0}, {}, 2.0), ({"omega1": 0}, {"m": 2}, 2.0)],
}  # fmt: skip
"""Starts of different patterns: other zeros, parameters and directions of time."""
ALONE = """
import sys, numpy as np, voronec as vo
name, (initial, parameters, end, tol) = sys.argv[1], eval(sys.argv[2])
run = vo.integrate(vo.load(name), "default", np.linspace(0, end, 120), tol=tol,
                   initial=initial, parameters=parameters)
print(run.state.tobytes().hex(), sorted(run.drift.items()), run.notes)
"""


def alone(*words: str) -> str:
    """What a fresh process prints."""
    done = subprocess.run([sys.executable, "-c", ALONE, *words], capture_output=True, check=True)
    return done.stdout.decode().strip()


def said(run: vo.Trajectory) -> str:
    return f"{run.state.tobytes().hex()} {sorted(run.drift.items())} {run.notes}"


@pytest.mark.slow
@pytest.mark.parametrize("name", KINDS)
def test_prepared_problems_give_each_start_what_a_fresh_process_does_bit_for_bit(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As does a system that nobody has derived in this process, by an integrator of its own."""
    tol = 1e-12 if name == "ball-on-sphere" else 1e-10  # by heyoka and by DOP853
    kinds = [(i, p, np.linspace(0, end, 120)) for i, p, end in KINDS[name]]

    def by_itself(i: Any, p: Any, t: np.ndarray) -> str:
        system = replace(vo.load(name))
        return said(vo.integrate(system, "default", t, initial=i, parameters=p, tol=tol))

    with monkeypatch.context() as unused:
        unused.setattr(heyoka_stepper, "IDLE", 0)
        fresh = [
            said(
                vo.integrate(replace(vo.load(name)), "default", t, initial=i, parameters=p, tol=tol)
            )
            for i, p, t in kinds
        ]
    assert alone(name, repr((*KINDS[name][-1], tol))) == fresh[-1]
    prepared = vo.prepare(vo.load(name), "default", tol=tol)
    for turn in range(2):  # then all that is kept is there
        for (i, p, t), expected in [*zip(kinds, fresh, strict=True)][:: 1 - 2 * turn]:
            assert said(prepared.run(i, p, t)) == expected, (i, p)


def test_a_prepared_problem_runs_as_integrate_does() -> None:
    sleigh, grid = vo.load("sleigh"), np.linspace(0, 4, 41)
    prepared = vo.prepare(sleigh, outputs=("x", "w**2"), events="phi - 1", tol=1e-11, dense=True)
    for initial in (None, {"v": 1, "w": 2}, {"v": 1}):
        run = prepared.run(initial, times=grid)
        same = vo.integrate(
            sleigh, outputs=("x", "w**2"), events="phi - 1", tol=1e-11, dense=True, times=grid,
            initial=initial,
        )  # fmt: skip
        assert all(np.array_equal(run[name], same[name]) for name in ("x", "w**2"))
        assert np.array_equal(run.events["phi - 1"].t, same.events["phi - 1"].t)
        assert np.array_equal(run.at([0.1])["x"], same.at([0.1])["x"])
        assert run.drift == same.drift and run.names == same.names


def test_of_problems_with_reactions_each_gives_its_own() -> None:
    """The equations are written once for what was asked for last, which may be another."""
    sleigh, given = vo.load("sleigh"), {"initial": {"w": 2}, "times": np.linspace(0, 4, 9)}
    asked = [("reaction 1", "x"), ("x", "reaction 1"), ("reaction 1", "phi"), ("reaction 1",)]
    prepared = [vo.prepare(sleigh, outputs=outputs) for outputs in asked]
    for problem in (*prepared, *prepared):
        run = problem.run(**given)
        same = vo.integrate(replace(sleigh), outputs=problem.outputs, **given)
        assert run.outputs == same.outputs == problem.outputs
        assert all(np.array_equal(run[name], same[name]) for name in run.outputs)


@pytest.mark.parametrize(
    ("asked", "run", "word"),
    [
        ({"outputs": ("xx",)}, {}, "xx"),
        ({"scene": "nowhere"}, {}, "no scene 'nowhere'"),
        ({"events": ("q",)}, {}, "'q'"),
        ({"tol": 2}, {}, "tol"),
        ({}, {"initial": {"nobody": 1}}, "nobody"),
        ({}, {"times": [0, 0]}, "monotonic"),
        ({}, {"parameters": {"v": 1}}, "parameter 'v'"),
    ],
)
def test_what_makes_no_sense_is_refused_where_it_is_said(asked, run, word) -> None:
    if not run:
        with pytest.raises(vo.DefinitionError, match=word):
            vo.prepare(vo.load("sleigh"), **asked)
        return
    prepared = vo.prepare(vo.load("sleigh"), **asked)
    with pytest.raises(vo.DefinitionError, match=word):
        prepared.run(**run)


def test_events_and_outputs_have_models_of_their_own(shelf, no_formulations) -> None:
    system = vo.load("sleigh")

    def crossings() -> np.ndarray:
        run = vo.integrate(replace(system), times=10.0, events=[vo.Event("w", name="turn")])
        return run.events["turn"].t

    first = crossings()
    motion("sleigh", ("phi",), {})
    no_formulations()
    assert np.array_equal(crossings(), first)
    with pytest.raises(AssertionError, match="derived"):
        motion("sleigh", ("y",), {})


def test_a_damaged_model_is_named_once_and_replaced(shelf, no_formulations) -> None:
    fresh = motion("sleigh", ("phi",), {})
    for file in [*shelf.iterdir()]:  # what gives rates at the start, and the model
        content = bytearray(file.read_bytes())
        content[len(content) // 2] ^= 1
        file.write_bytes(content)
        with pytest.warns(UserWarning, match="is damaged; it is made anew") as told:
            assert np.array_equal(motion("sleigh", ("phi",), {}), fresh)
        assert len([w for w in told if "damaged" in str(w.message)]) == 1
    no_formulations()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert np.array_equal(motion("sleigh", ("phi",), {}), fresh)


def test_what_another_version_kept_is_ignored(shelf, no_formulations, monkeypatch) -> None:
    motion("sleigh", ("phi",), {})
    monkeypatch.setattr(model_cache, "engine_digest", lambda modules: "another engine")
    no_formulations()
    with pytest.raises(AssertionError, match="derived"):
        motion("sleigh", ("phi",), {})


def test_models_rest_on_their_room_and_on_what_it_imports(tmp_path, monkeypatch) -> None:
    texts = {
        "motion/formulation/model_cache.py": "from voronec.below.one import a",
        "below/one.py": "def a():\n    from voronec.lowest import b",
        "lowest.py": "b = 1",
        "aside/two.py": "from voronec.motion.formulation import model_cache",
    }

    def digest(changed: str) -> str:
        root = tmp_path / f"{len([*tmp_path.iterdir()])}"  # what a folder holds is remembered
        for name, text in texts.items():
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            (root / name).write_text(text + "\nc = 2" * (name == changed))
        monkeypatch.setattr(source_digest, "engine_folder", lambda: root)
        return source_digest.engine_digest.__wrapped__(source_digest.room_modules("motion"))

    assert [digest(name) != digest("") for name in texts] == [True, True, True, False]


def test_another_system_of_the_same_name_has_a_model_of_its_own(shelf, no_formulations) -> None:
    system = vo.load("sleigh")
    vo.integrate(system, times=3.0, outputs=("phi",))
    no_formulations()
    with pytest.raises(AssertionError, match="derived"):
        vo.integrate(replace(system, lagrangian=2 * system.lagrangian), times=3.0, outputs=("phi",))


def test_another_default_scene_has_a_model_of_its_own(shelf, no_formulations) -> None:
    """Where constraints are solved, the point of the default scene says for what."""
    system = vo.load("sleigh")
    vo.integrate(system, times=3.0, outputs=("phi",), initial={"w": 1})
    no_formulations()
    turned = replace(system, scenes={"default": vo.Scene(initial={"phi": 1, "w": 1})})
    with pytest.raises(AssertionError, match="derived"):
        vo.integrate(turned, times=3.0, outputs=("phi",), initial={"w": 1})


def test_those_that_nobody_used_for_longest_give_way(shelf, monkeypatch) -> None:
    monkeypatch.setattr(model_cache, "FILES", 2)
    for outputs in (("x",), ("y",), ("phi",)):
        motion("sleigh", outputs, {})
    assert len([*shelf.iterdir()]) == 2


@pytest.mark.parametrize("method", ["scipy", pytest.param("numba", marks=pytest.mark.slow)])
def test_a_user_without_a_home_has_motions_too(shelf, tmp_path, monkeypatch, method) -> None:
    """A process of a user whom the machine does not know, as containers have them."""
    if method == "numba":
        pytest.importorskip("numba")
    kept = motion("sleigh", ("phi",), {}, method)

    monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    for name in ("HOME", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("os.path.expanduser", lambda path: path)  # it leaves what it does not know
    before = {*tmp_path.iterdir()}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert np.array_equal(motion("sleigh", ("phi",), {}, method), kept)
    assert {*tmp_path.iterdir()} == before
