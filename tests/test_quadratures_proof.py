"""Motions by quadratures proved from the derived equations; every formula broken is refuted."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest
import sympy as sp

import voronec as vo
from voronec.equations.motions import Motions
from voronec.proof.quadratures import QuadratureGround, statements

pytestmark = pytest.mark.slow

SYSTEMS = ("demchenko", "zhukovsky-ball", "bobylev-ball")
POLES = ["pole", "residues"]
OFF = sp.Rational(1, 7)


@cache
def bare(name):
    """A system with its motion, and no other claims."""
    return replace(
        vo.load(name), charts={}, cases={}, scenes={}, integrals={}, equations={}, measure=None,
        essential=(), integrable="", undecided={},
    )  # fmt: skip


@cache
def field(name):
    return Motions.of(bare(name)).on_coordinates


def verdicts(name, motion=None, only=None):
    """What is decided of a motion of a system; ``only`` the claims that begin with some words."""
    ground = QuadratureGround(field(name), motion or bare(name).motion)
    chosen = only or ground.motion.claims
    return {k: decide() for k, decide in statements(ground) if k.startswith(tuple(chosen))}


def refuted(name, motion, only=None):
    """The claims that are refuted, each with a witness."""
    found = {k: v for k, v in verdicts(name, motion, only).items() if v.refuted}
    assert all(v.witness is not None for v in found.values())
    return set(found)


@pytest.mark.parametrize("name", SYSTEMS)
def test_every_claim_of_a_motion_is_proved(name):
    found = verdicts(name)
    assert tuple(found) == bare(name).motion.claims
    assert {v.status for v in found.values()} == {"proved"}


@pytest.mark.parametrize("name", SYSTEMS)
def test_a_wrong_constant_is_refuted(name):
    motion, off = bare(name).motion, OFF * bare(name).velocities[0]
    for symbol, meaning in motion.constants.items():
        wrong = replace(motion, constants={**motion.constants, symbol: meaning + off})
        assert refuted(name, wrong, [f"{symbol} is"])


@pytest.mark.parametrize("name", SYSTEMS)
def test_a_wrong_quartic_is_refuted(name):
    motion = bare(name).motion
    for power in range(5):
        wrong = replace(motion, quartic=motion.quartic + OFF * motion.x**power)
        assert refuted(name, wrong, [f"rate of {motion.x}"])


@pytest.mark.parametrize(
    "variable", ["cos(x)", "Abs(cos(x))", "sqrt(cos(x)**2)", "Max(cos(x), -cos(x))"]
)
def test_a_variable_that_bounces_is_not_proved(variable):
    """|cos(x)| obeys the quartic of cos(x), and turns back where the closed form goes on."""
    x, y, z, c = sp.symbols("x y z c")
    value = sp.sympify(variable)
    system = vo.System(
        name="bounce", fibration=vo.Fibration(base=(x,), fibre=(y,)),
        lagrangian=vo.velocity(x) ** 2 / 2, constraints=(vo.velocity(y) - value,),
        motion=vo.Quadratures(
            variable={z: value}, constants={c: vo.velocity(x)}, quartic=c**2 * (1 - z**2),
            integrals={x: c, y: z},
        ),
    )  # fmt: skip
    ground = QuadratureGround(Motions.of(system).on_coordinates, system.motion)
    found = dict(statements(ground))["rate of z"]()
    assert found.proved == (variable == "cos(x)"), found.method


@pytest.mark.parametrize("name", SYSTEMS)
def test_a_wrong_rate_is_refuted(name):
    motion = bare(name).motion
    for q, rate in motion.integrals.items():
        wrong = replace(motion, integrals={**motion.integrals, q: rate + OFF * motion.x})
        assert refuted(name, wrong, ["rate"]) == {f"rate of {q}"}


@pytest.mark.parametrize("name", SYSTEMS)
def test_a_wrong_weight_is_refuted_at_its_pole_and_by_the_residues(name):
    motion = bare(name).motion
    for place, weight in motion.poles.items():
        wrong = replace(motion, poles={**motion.poles, place: 2 * weight})
        found = refuted(name, wrong, POLES)
        assert any(k.startswith("pole ") for k in found)
        assert any(k.startswith("residues ") for k in found)
    # f(c) = -4 w^2 does not know the sign, and neither do the residues
    turned = {c: -w for c, w in motion.poles.items()}
    assert not refuted(name, replace(motion, poles=turned), POLES)


@pytest.mark.parametrize("name", SYSTEMS)
def test_a_missing_pole_is_not_passed_over(name):
    motion = bare(name).motion
    for place in motion.poles:
        rest = {c: w for c, w in motion.poles.items() if c != place}
        found = verdicts(name, replace(motion, poles=rest), ["residues"])
        assert any(v.undecided and "declared" in v.method for v in found.values())
    for place in motion.others:
        rest = tuple(c for c in motion.others if c != place)
        found = verdicts(name, replace(motion, others=rest), ["residues"])
        assert found["residues of the clock"].undecided


@pytest.mark.parametrize("name", SYSTEMS)
def test_a_wrong_velocity_cosine_or_clock_is_refuted(name):
    motion = bare(name).motion
    for v, value in motion.velocities.items():
        wrong = replace(motion, velocities={**motion.velocities, v: value + OFF})
        assert refuted(name, wrong, ["velocity"]) == {f"velocity {v}"}
    for i, trace in enumerate(motion.traces):
        traces = list(motion.traces)
        traces[i] = replace(trace, cosine=2 * trace.cosine)
        found = refuted(name, replace(motion, traces=traces), ["cosine"])
        assert found == {f"cosine of {trace.colatitude}"}
    slower = refuted(name, replace(motion, clock=2 * motion.clock), ["rate"])
    assert slower >= {f"rate of {s}" for s in (motion.x, *motion.integrals)}


def in_space(**changes):
    motion = bare("demchenko").motion
    only = ["frame", "vector", "rest", "coordinates"]
    return refuted("demchenko", replace(motion, space=replace(motion.space, **changes)), only)


def test_a_wrong_frame_or_vector_in_space_is_refuted():
    space = bare("demchenko").motion.space
    assert "frame is orthogonal" in in_space(frame=space.frame * sp.diag(1, 1, 2))
    assert "frame is orthogonal" in in_space(frame=space.frame * sp.diag(1, 1, -1))
    moved = in_space(vector=space.vector + sp.Matrix([OFF, 0, 0]))
    assert "vector is constant in space" in moved and "frame is orthogonal" not in moved


def test_wrong_coordinates_in_space_are_refuted():
    space = bare("demchenko").motion.space
    for q, value in space.coordinates.items():
        assert "coordinates in space" in in_space(coordinates={**space.coordinates, q: -value})


def test_what_the_rest_depends_on_is_no_coordinate_in_space():
    space, u = bare("demchenko").motion.space, sp.Symbol("u")
    coordinates = {u: space.coordinates[sp.Symbol("u1")], **space.coordinates}
    assert "rest is free of space" in in_space(coordinates=coordinates)


@pytest.mark.parametrize("name", ["zhukovsky-ball", "bobylev-ball"])
def test_a_wrong_way_over_the_plane_is_refuted(name):
    motion = bare(name).motion
    plane = motion.plane

    def found(**changes):
        only = ["direction", "place"]
        return refuted(name, replace(motion, plane=replace(plane, **changes)), only)

    a, b = plane.direction
    assert "direction in the plane" in found(direction=(2 * a, b))
    assert "direction in the plane" in found(length=2 * plane.length)
    for part in ("rates", "slopes"):
        forward, left = getattr(plane, part)
        assert found(**{part: (forward + OFF, left)}) == {"place in the plane"}
        assert found(**{part: (forward, left + OFF)}) == {"place in the plane"}


SWING = """
import sympy as sp
import voronec as vo

x, c, z, E0 = sp.symbols("x c z E0")
SYSTEM = vo.System(
    name="swing",
    fibration=vo.Fibration(base=(x,)),
    lagrangian=(vo.velocity(x) ** 2 - c * x**2) / 2,
    parameters=(vo.Parameter(c, 1),),
    motion=vo.Quadratures(
        variable={z: x},
        constants={E0: vo.velocity(x) ** 2 + c * x**2},
        quartic=QUARTIC,
        integrals={},
    ),
)
"""


def test_check_decides_the_claims_of_a_motion(tmp_path, capsys):
    from voronec.cli import main

    right, wrong = tmp_path / "right.py", tmp_path / "wrong.py"
    right.write_text(SWING.replace("QUARTIC", "E0 - c * z**2"))
    wrong.write_text(SWING.replace("QUARTIC", "E0 - 2 * c * z**2"))
    assert main(["check", str(right), "--jobs", "1"]) == 0
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["proved", *"motion E0 is constant".split()] in lines
    assert ["proved", *"motion rate of z".split()] in lines
    assert main(["check", str(wrong), "--jobs", "1"]) == 1
    text = capsys.readouterr().out
    assert "motion rate of z" in text and "against" in text


def test_show_states_the_motion(capsys):
    from voronec.cli import main

    assert main(["show", "demchenko"]) == 0
    text = capsys.readouterr().out
    assert "(dx/dt)^2 = " in text and "dv1/dt = " in text and "is upright" in text
