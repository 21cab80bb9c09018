"""The declaration of a motion by quadratures: what is read, and what is refused in one line."""

from __future__ import annotations

from dataclasses import replace

import pytest
import sympy as sp

import voronec as vo

x, y, q, w, c = sp.symbols("x y q w c")
z, E0 = sp.symbols("z E0")


def motion(**changes):
    """A point on a line, z = x and a direction q that turns with it."""
    given = {
        "variable": {z: x},
        "constants": {E0: vo.velocity(x) ** 2 + c * x**2},
        "quartic": E0 - c * z**2,
        "integrals": {q: 1 / (z - 2)},
        "poles": {2: sp.sqrt(4 * c - E0) / 2},
    }
    return vo.Quadratures(**{**given, **changes})


def system(**changes):
    """The system of that motion; q turns at a rate that depends on the place."""
    given = {
        "name": "swing",
        "fibration": vo.Fibration(base=(x,), fibre=(q,)),
        "lagrangian": vo.velocity(x) ** 2 / 2 - c * x**2 / 2,
        "constraints": (vo.velocity(q) * (x - 2) - vo.velocity(x),),
        "parameters": (vo.Parameter(c, 1),),
        "motion": motion(),
    }
    return vo.System(**{**given, **changes})


def test_everything_is_read_into_expressions():
    found = motion(poles={"2": "1/2"}, clock="1 + z**2")
    assert found.poles == {sp.Integer(2): sp.Rational(1, 2)}
    assert found.clock == 1 + z**2
    assert found.x == z and found.meaning == x and found.angles == (q,)


def test_a_pole_may_have_no_weight():
    found = motion(others=(3, "sqrt(c)"))
    assert found.others == (sp.Integer(3), sp.sqrt(c))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"variable": {z: x, y: x}}, "is not one symbol"),
        ({"variable": {sp.sin(z): x}}, "is not one symbol"),
        ({"constants": [E0]}, "constants = "),
        ({"quartic": z**5}, "the quartic is"),
        ({"quartic": 1 / z}, "the quartic is"),
        ({"quartic": (z**2 + 1) ** 2 * z}, "degree 4 or less"),
        ({"integrals": {q: sp.sqrt(z)}}, "the rate of 'q' is"),
        ({"poles": {z: 1}}, "holds the variable 'z'"),
        ({"poles": {1: z}}, "holds the variable 'z'"),
        ({"clock": sp.sqrt(z)}, "the clock is"),
        ({"traces": (q,)}, "a trace is 'q'"),
        ({"traces": (vo.Trace(x, q, sp.sin(z)),)}, "the cosine of 'x'"),
        ({"space": 3}, "space is '3'"),
        ({"plane": 3}, "plane is '3'"),
    ],
)
def test_what_is_no_quadrature_is_refused(changes, words):
    with pytest.raises(vo.DefinitionError, match=words.replace("(", r"\(")):
        motion(**changes)


def space(**changes):
    entries = sp.Matrix(3, 3, sp.symbols("e:9"))
    given = {
        "frame": sp.eye(3),
        "vector": sp.Matrix([0, 0, 1]),
        "coordinates": {q: sp.atan2(entries[0, 1], entries[0, 0])},
        "entries": entries,
    }
    return vo.Space(**{**given, **changes})


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"frame": sp.eye(2)}, "frame of a space"),
        ({"vector": (0, 0, 1)}, "vector of a space"),
        ({"entries": sp.eye(3)}, "write 9 symbols"),
        ({"coordinates": {q: x}}, "the coordinate 'q' in space holds 'x'"),
    ],
)
def test_what_is_no_frame_in_space_is_refused(changes, words):
    assert space().coordinates
    with pytest.raises(vo.DefinitionError, match=words):
        space(**changes)


def test_a_plane_has_two_of_everything():
    assert vo.Plane((x, y), (1, 0), 1).slopes == (0, 0)
    with pytest.raises(vo.DefinitionError, match="place of a plane holds 1 entries"):
        vo.Plane((x,), (1, 0), 1)


def test_a_trace_has_the_title_of_its_drawing():
    trace = vo.Trace(x, q, z)
    drawn = motion(traces=(trace,)).with_titles({"above": ("x", "q")})
    assert drawn.traces[0].title == "above"
    assert motion(traces=(trace,)).with_titles(None).traces[0].title == ""


def test_a_system_needs_a_value_for_every_coordinate():
    assert system().motion is not None
    with pytest.raises(vo.DefinitionError, match="gives no value to the coordinate 'x'"):
        system(motion=motion(variable={z: sp.sin(x)}))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"constants": {c: 1}}, "the name 'c' is used twice"),
        ({"quartic": y * z}, "the quartic contains 'y'"),
        ({"quartic": x * z}, "the quartic contains 'x'"),
        ({"constants": {E0: z}}, "the meaning of 'E0' contains 'z'"),
        ({"integrals": {y: z, q: z}}, "gives a rate to 'y', which is no coordinate"),
        ({"velocities": {y: z}}, "gives a value to 'y'"),
        ({"integrals": {}}, "no rate to the longitude 'q'"),
        ({"traces": (vo.Trace(x, y, z),)}, "the longitude 'y' of a trace"),
    ],
)
def test_a_motion_that_does_not_fit_the_system_is_refused(changes, words):
    good = {"traces": (vo.Trace(x, q, z),)}
    assert system(motion=motion(**good)).motion is not None
    with pytest.raises(vo.DefinitionError, match=words):
        system(motion=motion(**{**good, **changes}))


def test_a_velocity_is_not_read_off_a_place_that_may_be_turned():
    # the rates of longitudes in space hold for upright data alone
    demchenko = vo.load("demchenko")
    v1, speed = sp.Symbol("v1"), demchenko.velocities[0]
    wrong = {**demchenko.motion.velocities, speed: vo.velocity(v1)}
    with pytest.raises(vo.DefinitionError, match="holds 'v1' or its rate, a place in space"):
        replace(demchenko, motion=replace(demchenko.motion, velocities=wrong))


def test_a_motion_is_of_the_right_kind():
    with pytest.raises(vo.DefinitionError, match="motion is '3'; write Quadratures"):
        system(motion=3)


def test_an_invariant_and_the_variable_may_share_a_name_with_one_meaning():
    demchenko = vo.load("demchenko")
    assert demchenko.motion.x in demchenko.invariant_symbols
    with pytest.raises(vo.DefinitionError, match="the name 'x' is used twice"):
        replace(demchenko, invariants={"x": sp.sin(sp.Symbol("u")), "y": sp.cos(sp.Symbol("u"))},
                cases={})  # fmt: skip


def test_a_claim_of_the_motion_may_be_declared_undecided():
    demchenko = vo.load("demchenko")
    named = replace(demchenko, undecided={"rate of v": "for a test"})
    assert "rate of v" in named.undecided
    with pytest.raises(vo.DefinitionError, match="undecided holds 'rate of w'"):
        replace(demchenko, undecided={"rate of w": "for a test"})
