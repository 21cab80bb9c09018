"""Balls and bodies in R^n, n = 3, 4, 5: claims, the independent route, motions, n = 3."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest
import sympy as sp

import voronec as vo
from voronec.declaration.catalogue import entry_of, members, names
from voronec.declaration.claims import declared_claims
from voronec.equations.motions import Motions
from voronec.proof.relations.decision import check_relation

pytestmark = pytest.mark.slow

Q = sp.Rational
FAMILIES = {
    "chaplygin-ball-in-rn": "chaplygin-ball",
    "ball-on-sphere-in-rn": "ball-on-sphere",
    "rubber-ball-in-rn": "rubber-ball-on-plane",
    "rubber-ball-on-sphere-in-rn": "rubber-ball-on-sphere",
    "veselova-in-rn": "veselova",
}
LARGEST = [f"{family}@5" for family in FAMILIES]
UNIT = {3: (2, 3, 6), 4: (1, -1, 1, 1), 5: (1, 1, -1, 2, 3)}  # of length 7, 2, 4


@cache
def motions(name):
    return Motions.of(vo.load(name))


def point_of(system):
    """A point on the sphere, with velocities."""
    lengths = UNIT[len(system.coordinates)]
    size = sp.sqrt(sum(k**2 for k in lengths))
    point = {g: k / size for g, k in zip(system.coordinates, lengths, strict=True)}
    return point | {v: Q((-1) ** i * (3 + i), 5) for i, v in enumerate(system.velocities)}


@pytest.mark.parametrize("name", LARGEST)
def test_claims_of_every_kind_are_made_and_none_is_left_open(name):
    """They are proved with all other systems."""
    system = vo.load(name)
    reducible = {"multiplier"} if name.startswith(("rubber", "veselova")) else set()
    kinds = {c.kind for s in (system, *system.cases.values()) for c in declared_claims(s)}
    assert {"integral", "equation", "measure"} | reducible == kinds and not system.undecided


@pytest.mark.parametrize("name", LARGEST)
def test_both_routes_agree_to_forty_digits(name):
    system = vo.load(name)
    point = point_of(system)
    found = motions(name).equations.acceleration(point, 45)
    referee = vo.multiplier_acceleration(system, point, 45)
    assert list(found) == list(referee) and len(found) > len(system.coordinates)
    assert all(abs(found[x] - referee[x]) < Q(10) ** -40 for x in found)
    assert any(abs(found[v]) > Q(1, 100) for v in system.velocities)


@pytest.mark.parametrize("family", ["chaplygin-ball-in-rn", "rubber-ball-on-sphere-in-rn"])
def test_three_dimensions_give_the_known_system(family):
    relation = next(r for r in entry_of(family).load_relations()[0] if r.target == FAMILIES[family])
    assert relation.source == f"{family}@3"
    checked = check_relation(relation, motions)
    assert checked.verdict.proved
    assert checked.pulled and all(c.verdict.proved for c in checked.pulled)


@pytest.mark.parametrize("family", ["chaplygin-ball-in-rn", "veselova-in-rn"])
def test_three_dimensions_lie_in_four(family):
    relation = next(r for r in entry_of(family).load_relations()[0] if r.target == family)
    assert relation.source == f"{family}@3"
    checked = check_relation(relation, motions)
    assert checked.verdict.proved and {"specialisation", "embedding"} <= {*checked.kinds}
    assert checked.pulled and all(c.verdict.proved for c in checked.pulled)


@pytest.mark.parametrize(
    ("family", "moment"), [("chaplygin-ball-in-rn", "I12"), ("veselova-in-rn", "J14")]
)
def test_in_four_dimensions_the_moments_are_those_of_three(family, moment):
    relation = next(r for r in entry_of(family).load_relations()[0] if r.target == family)
    wrong = replace(relation, parameters={**relation.parameters, moment: 7})
    assert check_relation(wrong, motions).verdict.refuted


@pytest.mark.parametrize("name", ["ball-on-sphere-in-rn@5", "veselova-in-rn@5"])
def test_the_scene_runs_and_keeps_the_integrals(name):
    traj = vo.integrate(motions(name).equations)
    assert max(traj.drift.values()) < 1e-10 and max(traj.residuals.values()) < 1e-10
    assert not traj.interrupted


@pytest.mark.parametrize("family", FAMILIES)
def test_a_family_is_listed_once_and_its_members_are_told(family):
    assert family in names() and not any("@" in name for name in names())
    assert members(family) == ["3", "4", "5"]
    assert vo.load(family).name == family and vo.load(f"{family}@5").name == f"{family}@5"
    with pytest.raises(vo.DefinitionError, match=f"no system '{family}@7'; did you mean"):
        vo.load(f"{family}@7")


def test_a_system_that_is_no_family_has_no_members():
    assert members("sleigh") == []
    with pytest.raises(vo.DefinitionError, match="no system 'sleigh@3'"):
        vo.load("sleigh@3")


def test_the_kinds_and_growth_of_the_ball_in_four_dimensions():
    eqs = motions("chaplygin-ball-in-rn").equations
    # Nine of the ten dimensions of SE(4): the height of the centre does not change.
    assert (eqs.kind, eqs.growth, eqs.distribution.dimension) == ("chaplygin", (6, 9), 10)
    rubber = motions("rubber-ball-in-rn").equations
    assert (rubber.kind, rubber.growth) == ("voronec", (3, 6, 9))


def test_another_power_in_the_measure_of_the_rubber_ball_is_refuted():
    """1/(2 epsilon) belongs to the sphere; the power of the plane fails there."""
    from voronec.proof.measures import decide_measure

    at = motions("rubber-ball-on-sphere-in-rn@4")
    wrong = vo.Measure(sp.sqrt(sp.Symbol("Delta")))
    assert decide_measure(at, wrong).verdict.refuted


@pytest.mark.parametrize("power", [-1, Q(1, 2), 0])
def test_another_reducing_multiplier_of_veselova_is_refuted(power):
    """(gamma, A gamma)^(-1/2) is one; other powers are none."""
    from voronec.proof.claims import case_of
    from voronec.proof.hamiltonian_form import decide_multiplier

    system = vo.load("veselova-in-rn")
    special = case_of(system, system.cases["J = a a"])
    at = Motions.of(special)
    assert decide_multiplier(at, special.multiplier).verdict.proved
    assert decide_multiplier(at, special.multiplier ** (-2 * power)).verdict.refuted


def test_a_multiplier_asks_for_as_many_velocities_as_the_coordinates_have_dimensions():
    from voronec.proof.hamiltonian_form import decide_multiplier

    verdict = decide_multiplier(motions("chaplygin-ball-in-rn@3"), sp.Integer(1)).verdict
    assert verdict.undecided and "as a frame of their space" in verdict.method
