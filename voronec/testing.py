"""The tests that every system passes, for the packages of others too.

    from voronec.testing import conformance

    test_conformance = conformance("my-system")

makes a pytest test for each system and each statement of ``STATEMENTS``.  The statements can be
called by themselves, too: each takes the name of a system, or its file, and raises
``AssertionError`` where it does not hold.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any

import sympy as sp

from voronec.algebra.symbols import plain_name, time, velocity
from voronec.algebra.text import as_expression
from voronec.declaration.bibliography import bibtex
from voronec.declaration.catalogue import Entry, entry_of, file_entry, is_file
from voronec.declaration.claims import declared_claims
from voronec.declaration.scene import Scene
from voronec.declaration.system import System
from voronec.equations.referee import multiplier_acceleration
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.errors import did_you_mean
from voronec.motion import integrate
from voronec.proof.check import Inventory, Result
from voronec.proof.check.catalogue_check import trouble_result
from voronec.proof.check.report import failure_line
from voronec.proof.check.unit import Unit, units_of
from voronec.proof.check.work import Derivations, examine
from voronec.proof.comparison import is_general, random_point

__all__ = [
    "STATEMENTS",
    "claims_hold",
    "conformance",
    "names_are_fine",
    "references_are_known",
    "relations_hold",
    "routes_agree_at_random_points",
    "routes_agree_where_scenes_start",
    "scenes_run",
]

DIGITS = 40
"""To how many digits the equations agree with those with multipliers."""
SEEDS = 3
"""At how many random points."""
DRIFT = 1e-7
"""How much an integral may change along a scene, relative to its size."""


def conformance(*names: str, statements: Mapping[str, Callable[[str], None]] | None = None) -> Any:
    """A pytest test of all statements about systems, given by their names or files; with
    ``statements``, of these alone, in words."""
    import pytest

    chosen = STATEMENTS if statements is None else statements
    cases = [
        pytest.param(name, hold, id=f"{name}-{what.replace(' ', '-')}")
        for name in names
        for what, hold in chosen.items()
    ]

    @pytest.mark.parametrize(("name", "holds"), cases)
    def test(name: str, holds: Callable[[str], None]) -> None:
        holds(name)

    return test


def names_are_fine(name: str) -> None:
    """The system loads, under its name, with a title, a scene to look at, and meanings of what it
    has; so do neighbours."""
    system = _entry(name).load()
    shape = "lower-case letters, digits and single hyphens, a letter first"
    assert re.fullmatch(r"[a-z][a-z0-9]*(-[a-z0-9]+)*(@\w+)?", system.name), (
        f"'{system.name}' is not {shape}"
    )
    assert system.title, f"'{name}' has no title"
    assert "default" in system.scenes or is_general(system), (
        f"'{name}' has no scene 'default' for 'voronec run'"
    )
    frame = system.frame.ambient if system.frame is not None else ()
    things = (*system.coordinates, *map(velocity, system.coordinates), *frame, *system.inputs)
    known = {*map(plain_name, things), *system.integrals, *system.invariants}
    for said in system.meanings:
        assert said in known, (
            f"'{name}': meanings explain '{said}', which is no coordinate, velocity, integral, "
            f"invariant or input{did_you_mean(said, known)}"
        )
    _entry(name).load_relations()


def references_are_known(name: str) -> None:
    """Every reference has an entry, in ``references.bib`` beside the system or in the project's."""
    entry = _entry(name)
    bibtex(entry.load().references, None if entry.origin is None else entry.origin.parent)


def claims_hold(name: str) -> None:
    """Every claim is proved, or listed as undecided with a reason; there is at least one, and none
    is left out."""
    results = _results(name, "system")
    _pass(results)
    assert any(r.findings for r in results), f"'{name}' claims nothing"
    system = _entry(name).load()
    holders = (system, *system.cases.values())
    declared = Counter(claim.kind for holder in holders for claim in declared_claims(holder))
    missing = declared - Counter(f.kind for r in results for f in r.findings)
    assert not missing, f"'{name}': claims that nothing decided: {dict(missing)}"


def relations_hold(name: str) -> None:
    """So is every relation in which the system stands, what it carries, and every square."""
    _pass(_results(name, "relation", "square"))


def routes_agree_at_random_points(name: str) -> None:
    """The equations give the accelerations that the equations with multipliers give, at three
    points to 40 digits relative to the largest.

    A system with unknown functions has no accelerations in numbers.
    """
    if is_general(_equations_of(name).system):
        return
    for seed in range(SEEDS):
        _routes_agree(_equations_of(name), random_point(_equations_of(name).system, seed))


def routes_agree_where_scenes_start(name: str) -> None:
    """The two routes agree at the initial data of every scene, where these are given in numbers;
    with inputs of any value, as at random points."""
    eqs = _equations_of(name)
    for scene in eqs.system.scenes.values():
        point = _start(eqs.system, scene)
        if point is not None:
            _routes_agree(eqs, {**random_point(eqs.system), **point})


def scenes_run(name: str) -> None:
    """Every scene starts on the constraints and runs to its end; integrals stay what they are, to
    1e-7 of their size, by ``scipy`` with ``tol=1e-11``."""
    eqs = _equations_of(name)
    for title, scene in eqs.system.scenes.items():
        begin, end = map(float, scene.times)
        times = [begin, (begin + end) / 2, end]
        run = integrate(eqs, scene=title, times=times, method="scipy", tol=1e-11)
        assert len(run) == 3, f"scene '{title}' of '{name}' stopped at t = {run.t[-1]:g}"
        loose = {k: d for k, d in run.drift.items() if not d < DRIFT}
        assert not loose, f"scene '{title}' of '{name}': integrals drift: {loose}"


STATEMENTS: dict[str, Callable[[str], None]] = {
    "names are fine": names_are_fine,
    "references are known": references_are_known,
    "claims hold": claims_hold,
    "relations hold": relations_hold,
    "routes agree at random points": routes_agree_at_random_points,
    "routes agree where scenes start": routes_agree_where_scenes_start,
    "scenes run": scenes_run,
}
"""What ``conformance`` tests, by what it says."""


def _entry(name: str) -> Entry:
    return file_entry(name) if is_file(name) else entry_of(name)


@cache
def _equations_of(name: str) -> VoronecEquations:
    return derive(_entry(name).load())


@cache
def _stock(file: str) -> Inventory:
    """One inventory for all; with a file, one of its own."""
    return Inventory.of([file] if file else [])


_BENCH = Derivations()


@cache
def _result(unit: Unit) -> Result:
    """What a check finds of one unit: a relation is decided once, not for each of its systems."""
    return examine(unit, _BENCH)


def _results(name: str, *kinds: str) -> list[Result]:
    """What has to do with a system, and what is wrong beside it at sight."""
    entry = _entry(name)
    stock = _stock(entry.path)
    troubles = [
        trouble_result(t)
        for t in stock.all_troubles
        if entry.name in (t.name, t.owner) and t.kind in kinds
    ]
    units = units_of(stock, [entry.name])
    return [*troubles, *(_result(unit) for unit in units if unit.kind in kinds)]


def _pass(results: Sequence[Result]) -> None:
    failures = [failure_line(r, f) for r in results for f in r.failures]
    assert not failures, "\n".join(failures)


def _routes_agree(eqs: VoronecEquations, point: Mapping[Any, Any]) -> None:
    """Both accelerations to 40 digits, relative to the largest."""
    ours = eqs.acceleration(point, digits=DIGITS + 10)
    theirs = multiplier_acceleration(eqs.system, point, digits=DIGITS + 10)
    size = 1 + max((abs(a) for a in theirs.values()), default=0)
    for q, value in theirs.items():
        off = abs(ours[q] - value)
        assert off <= size * sp.Float(f"1e-{DIGITS}", DIGITS + 10), (
            f"'{eqs.system.name}': the acceleration of {q} is {ours[q]}, with multipliers {value}, "
            f"at {dict(point)}"
        )


def _start(system: System, scene: Scene) -> dict[Any, Any] | None:
    """The initial data of a scene as a point; None where velocities of coordinates are given."""
    given = {
        plain_name(k): as_expression(v) for k, v in {**scene.parameters, **scene.initial}.items()
    }
    state = (*system.coordinates, *system.velocities)
    known = {plain_name(s) for s in (*state, *(p.symbol for p in system.parameters))}
    if not {*given} <= known:
        return None
    point = dict.fromkeys(state, sp.Integer(0)) | {time: sp.Rational(str(scene.times[0]))}
    point |= {p.symbol: as_expression(p.value) for p in system.parameters if p.value is not None}
    point = {s: given.get(plain_name(s), value) for s, value in point.items()}
    numbers = {s: value for s, value in point.items() if not value.free_symbols}
    return {s: value.xreplace(numbers) for s, value in point.items()}
