"""Classes of traces: decided exactly, alike by every route, and found by themselves."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import sympy as sp

import voronec as vo
from voronec.closed import ClosedForm
from voronec.closed.classes.error_bounds import BoundedNumber, compile_with_bounds
from voronec.closed.classes.search import exact_closed_form, find
from voronec.closed.classes.survey import classify_many, degrees, discs, survey
from voronec.closed.classes.trace_classes import (
    LABELS,
    Tally,
    classify,
    declared_traces,
    label_of,
    tally,
)
from voronec.motion.closed_form import closed_form

pytestmark = pytest.mark.slow

R = sp.Rational
BALL, SPHERE = "on the ball", "on the sphere"
THREE_FIFTHS = sp.acos(R(3, 5))


@pytest.fixture(scope="module")
def ball() -> Any:
    return vo.load("demchenko")


def motion(system: Any, parameters: Any = (), **start: Any) -> ClosedForm:
    return closed_form(system, parameters=dict(parameters), initial={"u1": 1, **start})


def labels(closed: ClosedForm) -> tuple[str, str]:
    found = classify(closed)
    return found[BALL].label, found[SPHERE].label


# -- exactly ------------------------------------------------------------------------------


def test_a_start_without_velocity_of_the_contact_is_a_cusp_on_both_spheres(ball: Any) -> None:
    assert labels(motion(ball, u=THREE_FIFTHS, n=R(3, 2))) == ("D2+B", "D2")
    assert labels(motion(ball, u=THREE_FIFTHS, n=-R(3, 2))) == ("D1", "D1+B")


@pytest.mark.parametrize(("s", "expected"), [("0", "D1"), ("1e-30", "A"), ("-1e-30", "B")])
def test_a_cusp_is_told_from_a_round_turn_and_from_a_tiny_loop(
    ball: Any, s: str, expected: str
) -> None:
    found = motion(ball, u=THREE_FIFTHS, n=-R(3, 2), s=R(s))
    assert labels(found)[0] == expected


@pytest.mark.parametrize("power", [3, 12, 40])
def test_a_momentum_that_all_but_vanishes_is_an_axis_all_the_same(ball: Any, power: int) -> None:
    spin = {"s": 3 * R(4, 5) / R(7, 5) + R(1, 10**power), "n": -3 * R(3, 5) / R(2, 5)}
    found = classify(motion(ball, u=THREE_FIFTHS, **spin))[SPHERE]
    assert found.label == "B"
    # the limit: a nutation of the precession whose momentum vanishes
    assert found.lower == pytest.approx(0, abs=1e-15)
    assert found.upper == pytest.approx(0.306191369606, abs=10.0 ** (1 - power) + 1e-12)


def test_cusps_on_both_parallels_ask_for_no_axial_momentum(ball: Any) -> None:
    spin = -R(9, 2) * R(3, 5) / R(2, 5)
    found = classify(motion(ball, u=THREE_FIFTHS, n=spin))
    assert (found[BALL].label, found[SPHERE].label) == ("D3", "D3")
    assert found[BALL].lower == pytest.approx(-0.6) and found[BALL].upper == pytest.approx(0.6)
    assert labels(motion(ball, u=THREE_FIFTHS, n=spin + R(1, 10**12)))[0] in ("D1+B", "D1")


def test_a_pole_is_passed_exactly_or_not_at_all(ball: Any) -> None:
    start = {"u": sp.acos(R(4, 5)), "n": R(1, 2)}
    level = declared_traces(ball)
    phi = level.at_start(sum(level.curve(BALL).above))
    spin = next(v for v in ball.velocities if str(v) == "s")
    known = {p.symbol: sp.nsimplify(p.value) for p in ball.parameters}
    named = {q: start.get(str(q), 0) for q in (*ball.coordinates, *ball.velocities) if q != spin}
    (s,) = sp.solve(phi.xreplace({**known, **named}), spin)
    assert labels(motion(ball, **start, s=s))[0] == "E1"
    assert labels(motion(ball, **start, s=s + R(1, 10**30)))[0] in ("A", "B")


def test_passing_a_pole_on_the_ball_leaves_no_mark_on_the_sphere(ball: Any) -> None:
    found = classify(closed_form(ball, find(ball, "E2", BALL)))
    assert found[BALL].lower == -1 and found[BALL].label == "E2"
    assert found[SPHERE].label in ("A", "B", "C1", "C2")


def test_rest_is_a_parallel_or_a_point(ball: Any) -> None:
    assert labels(motion(ball, u=THREE_FIFTHS)) == ("point", "point")
    k, mu, A, M = 3, R(3, 2), R(2, 5), 1
    u, s = THREE_FIFTHS, R(1, 3)
    # a regular precession: f and its slope vanish, which is linear in n
    c, d, n = R(3, 5), R(4, 5), sp.Symbol("n")
    P = M + A
    slope = -2 * c * (s**2 * P + 0) + d**2 * 2 * k * mu * n
    pull = (
        2 * s * d * (-k * mu * (M * mu + 2 * A) / A * c + (M * mu + A) * (A * n + k * mu * c) / A)
    )
    (spin,) = sp.solve(slope - pull, n)
    found = classify(motion(ball, u=u, s=s, n=spin))
    assert (found[BALL].label, found[SPHERE].label) == ("parallel", "parallel")
    assert found[BALL].drift is None and found[BALL].lower == found[BALL].upper == 0.6


def test_without_gyroscope_the_sphere_has_a_parallel(ball: Any) -> None:
    found = classify(motion(ball, {"k": 0}, u=0.7, s=0.3, tau=0.2, n=1.5))
    assert (found[BALL].label, found[SPHERE].label) == ("B", "parallel")
    assert found[BALL].fraction == Fraction(0) and "likely a closed curve" in found[BALL].note
    assert "no proof" in found[BALL].note  # digits alone prove nothing


def asymptotic() -> dict[str, Any]:
    """A start on the level on which x = 4/5 is a double root of f, below it."""
    axial, level, twice = R(54446, 17235), -R(29719, 17235), R(700532500, 83172663)
    k, mu, A, P, x, d = 3, R(3, 2), R(2, 5), R(7, 5), R(3, 5), R(4, 5)
    n = (axial - k * mu * x) / A
    s = (level + (mu + A) * axial / A * x - k * mu * (mu + 2 * A) / (2 * A) * x**2) / (P * d)
    return {"u": THREE_FIFTHS, "s": s, "n": n, "tau": sp.sqrt((twice - A * n**2) / P - s**2)}


def test_a_double_root_at_an_end_is_approached_for_ever(ball: Any) -> None:
    closed = motion(ball, **asymptotic())
    found = classify(closed)
    assert found[BALL].label == "asymptotic to the upper parallel"
    assert found[BALL].upper == pytest.approx(0.8) and found[BALL].period == np.inf
    assert found[BALL].drift is None


def test_a_start_a_little_off_the_separatrix_has_a_class_of_its_own(ball: Any) -> None:
    start = asymptotic()
    near = motion(ball, **{**start, "n": start["n"] + R(1, 10**12)})
    assert labels(near)[0] in ("A", "B", "C1", "C2")


# -- labels -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("counts", "drift", "expected"),
    [
        (Tally(), 0, "A"),
        (Tally(inner=((0.1, 1),)), 0, "B"),
        (Tally(inner=((0.1, 1), (0.2, 1))), 1, "C1"),
        (Tally(inner=((0.1, 1), (0.2, 1))), -1, "C2"),
        (Tally(inner=((0.1, 1), (0.2, 1))), 0, "C"),
        (Tally(inner=((0.1, 2),)), 1, "A|C"),
        (Tally(contacts=(False, True)), 0, "D1"),
        (Tally(contacts=(False, True), tilt=-1), 0, "D2"),
        (Tally(contacts=(True, True)), 0, "D3"),
        (Tally(contacts=(True, True), poles=(0, 1)), 0, "E1+D2"),
        (Tally(contacts=(True, False), poles=(-1, 0), inner=((0.1, 1),)), 0, "E2+B"),
        (Tally(contacts=(True, True), poles=(-1, 1)), 0, "E1+E2"),
        (Tally(limits=(True, True)), 0, "asymptotic to both parallels"),
        (Tally(limits=(True, False), poles=(-1, 0)), 0, "asymptotic to the lower pole"),
        (Tally(limits=(True, False), contacts=(True, True)), 0,
         "asymptotic to a point of the lower parallel (D1)"),
        (Tally(flat=True), 0, "parallel"),
        (Tally(at_rest=True, still=True), 0, "point"),
    ],
)  # fmt: skip
def test_labels_follow_from_counts(counts: Tally, drift: int, expected: str) -> None:
    assert label_of(counts, drift) == expected


# -- many ---------------------------------------------------------------------------------


def drawn(count: int) -> tuple[dict[str, Any], dict[str, Any]]:
    dice = np.random.default_rng(3)
    radius = dice.choice([-3.0, -0.5, 2.0], count)
    moment = np.where(radius == -0.5, 0.7, 0.4)  # a shell is hollow
    parameters = {"R1": radius, "A": moment, "k": dice.normal(size=count) * 3}
    start = {"u": dice.uniform(0.1, 3, count)}
    return parameters, start | {v: dice.normal(size=count) * 2 for v in ("s", "tau", "n")}


@pytest.mark.parametrize("trace", [BALL, SPHERE])
def test_bounded_doubles_and_exact_counting_agree(ball: Any, trace: str) -> None:
    parameters, start = drawn(400)
    found = survey(ball, parameters, start, trace)
    assert len(found.open) < 20
    for i in range(0, 400, 16):
        if found.labels[i]:
            own = motion(ball, {k: v[i].item() for k, v in parameters.items()},
                         **{k: v[i].item() for k, v in start.items()})  # fmt: skip
            assert classify(own)[trace].label == found.labels[i]


def test_every_one_of_many_motions_gets_a_class(ball: Any) -> None:
    parameters, start = drawn(300)
    for name in ("s", "tau"):
        start[name][::100] = 0.0  # the contact at rest: a cusp, exactly
    start["u"][::100] = 1.0, 0.5, 2.25
    found = classify_many(ball, parameters, start, BALL)
    assert not len(found.open) and {*found.labels} >= {"A", "B", "C1", "C2"}
    assert all("D" in found.labels[i] for i in range(0, 300, 100))


def test_drift_and_period_of_a_survey_are_those_of_the_closed_form(ball: Any) -> None:
    parameters, start = drawn(40)
    found = survey(ball, parameters, start, BALL, every_drift=True)
    for i in range(0, 40, 8):
        own = motion(ball, {k: v[i].item() for k, v in parameters.items()},
                     **{k: v[i].item() for k, v in start.items()})  # fmt: skip
        assert found.period[i] == pytest.approx(own.period, rel=1e-6)
        assert found.drift[i] == pytest.approx(own.turns["v"].advance, rel=1e-6, abs=1e-6)


def test_bounds_hold_the_truth_and_are_tight() -> None:
    x, y = sp.symbols("x y")
    value = (sp.sqrt(x) + sp.cos(y) ** 3 - R(1, 3)) / (x - y**2)
    dice = np.random.default_rng(5)
    points = dice.uniform(0.1, 3, (2, 50))
    (found,) = compile_with_bounds((x, y), (value,))(*points)
    for i in range(50):
        exact = value.subs({x: R(points[0, i]), y: R(points[1, i])}).evalf(40)
        assert abs(exact - R(found.mid[i])) <= R(found.err[i])
    assert np.median(found.err / np.abs(found.mid)) < 1e-14


def test_exact_zeros_stay_exact() -> None:
    zero, wide = BoundedNumber.of(np.zeros(2)), BoundedNumber(np.ones(2), np.full(2, 0.5))
    assert (zero * wide).zero.all() and (zero / wide + 0).zero.all()
    assert not (wide - wide).zero.any()


def test_discs_hold_one_root_each_or_say_that_they_do_not() -> None:
    rows = np.array([np.poly(r)[::-1] for r in ([1, 2, 3, 4], [0.5, 0.5, 1, 2])] +
                    [np.poly([1j, -1j, 0.5, 0.25])[::-1].real])  # fmt: skip
    own = [BoundedNumber.of(c) for c in rows.T]
    assert degrees(own).tolist() == [4, 4, 4]
    found = discs(own)
    assert found.known.tolist() == [True, False, True]
    assert sorted(np.round(found.real[0], 9)) == [1, 2, 3, 4]
    assert np.sum(found.kind[2] == 1) == 2 and np.sum(found.kind[2] == -1) == 2


# -- found --------------------------------------------------------------------------------


@pytest.mark.parametrize("label", LABELS)
def test_a_motion_of_every_class_is_found_on_the_ball(ball: Any, label: str) -> None:
    scene = find(ball, label, BALL)
    closed = closed_form(ball, scene)
    assert classify(closed)[BALL].label == label
    assert closed.attitude is not None and closed.attitude.upright


@pytest.mark.parametrize("label", ["D3", "E1"])
def test_and_on_the_sphere_inside_too(ball: Any, label: str) -> None:
    scene = find(ball, label, SPHERE, {"R1": -3})
    assert scene.parameters[ball.parameters[0].symbol] == -3
    assert labels(closed_form(ball, scene))[1] == label


def test_a_class_that_cannot_be_says_why(ball: Any) -> None:
    for label, words in (("D3", "needs a phi with 2 roots"), ("D1", "leaves only 'point'")):
        with pytest.raises(vo.DefinitionError, match=words):
            find(ball, label, BALL, {"k": 0})
    with pytest.raises(vo.DefinitionError, match="the trace is a parallel"):
        find(ball, "A", SPHERE, {"k": 0})
    with pytest.raises(vo.DefinitionError, match="no trace 'on the bal'; did you mean"):
        find(ball, "A", "on the bal")


def test_another_system_with_a_declared_motion_is_classified_alike() -> None:
    system = vo.load("zhukovsky-ball")
    known = declared_traces(system)
    scene = find(system, "B")
    closed = closed_form(system, scene)
    assert tally(closed.problem, known.curves[0]) is not None
    assert classify(closed)[known.curves[0].title].label == "B"


def test_a_bare_value_makes_a_closed_form(ball: Any) -> None:
    values = {p.symbol: p.value for p in ball.parameters}
    values |= dict.fromkeys((*ball.coordinates, *ball.velocities), sp.Integer(0))
    values[ball.coordinates[0]] = THREE_FIFTHS
    assert labels(exact_closed_form(ball, values)) == ("point", "point")
