"""Motions in closed form against integrations in many digits, and what is refused."""

import dataclasses
import math
import pickle
from fractions import Fraction

import mpmath
import numpy as np
import pytest
import sympy as sp
from flint import arb

import voronec as vo

R = sp.Rational
NAMES = ("u", "v", "theta", "u1", "v1", "s", "tau", "n")
ANGLES = frozenset(NAMES[:5])
START = {
    "u": R(1), "v": R(3, 10), "theta": R(7, 10), "u1": R(6, 5), "v1": -R(2, 5),
    "s": R(1, 5), "tau": R(3, 10), "n": R(3, 2),
}  # fmt: skip
MOMENT = R(7, 5)  # P of the ball with default parameters
UPWARD = {
    "u": R(1), "u1": sp.acos(-R(3, 5)), "theta": sp.pi / 2, "s": (4 + 3 * sp.sin(1)) / MOMENT,
    "tau": 0, "n": (3 - 3 * sp.cos(1)) / R(2, 5),
}  # fmt: skip
"""The momentum is 5 along the third axis: its parts are 4 along e_u, 3 along n."""


@pytest.fixture(scope="module")
def ball():
    return vo.load("demchenko")


def apart(name, ball, number):
    """How far an enclosure is from mpmath's number; of angles modulo 2 pi."""
    with mpmath.workdps(40):
        middle = mpmath.mpf(ball.str(40, radius=False)) - number
        if name in ANGLES:
            middle -= 2 * mpmath.pi * mpmath.nint(middle / (2 * mpmath.pi))
        return abs(float(middle))


CASES = {
    "any direction in space": ({}, {}),
    "no gyroscope": ({}, {"k": 0}),
    "hardly a gyroscope": ({}, {"k": R(1, 10**12)}),
    "gyroscope turned round": ({}, {"k": -2}),
    "inside": ({}, {"R1": -3}),
    "shell": ({}, {"R1": -R(1, 2), "A": R(7, 10)}),
    "colatitudes beyond their range": ({"u": -1, "u1": 4}, {}),
    "momentum along the normal": ({"s": 3 * sp.sin(1) / MOMENT, "tau": 0, "n": 2}, {}),
    "no momentum": (
        {"s": 3 * sp.sin(1) / MOMENT, "tau": 0, "n": -3 * sp.cos(1) / R(2, 5)}, {}
    ),
    "at rest": ({"s": 0, "tau": 0, "n": 0}, {}),
    "spinning about the normal": ({"s": 0, "tau": 0, "n": 2}, {"k": 0}),
    "upright": (UPWARD, {}),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_enclosures_contain_an_integration_in_many_digits(ball, case):
    changes, parameters = CASES[case]
    initial = {**START, **changes}
    form = vo.closed_form(ball, parameters=parameters, initial=initial)
    run = vo.integrate(
        ball, times=[0, 2], outputs=NAMES, parameters=parameters, initial=initial,
        method="flint", tol=1e-22,
    )  # fmt: skip
    found = form.enclose(2, 30)
    for name in NAMES:
        assert float(found[name].rad()) < 1e-30
        assert apart(name, found[name], run[name][-1]) < 3e-21, name


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_doubles_agree_with_the_enclosure_near_and_far(ball, case):
    changes, parameters = CASES[case]
    form = vo.closed_form(ball, parameters=parameters, initial={**START, **changes})
    period = form.period if math.isfinite(form.period) else 2.0
    times = np.array([0.3, 1.7, 40.2, 1e6 + 0.1]) * period
    whole, part = form.at(times), form.modulo(times)
    for i, t in enumerate(times):
        exact = form.enclose(float(t), 25)
        for name in NAMES:
            size = max(1.0, abs(float(exact[name]))) if name in "s tau n" else 1.0
            close = 2e-14 if i < 3 else 1e-13
            assert apart(name, exact[name], mpmath.mpf(part[name][i])) < close * size, name
            spacing = np.spacing(abs(whole[name][i]))
            assert apart(name, exact[name], mpmath.mpf(whole[name][i])) < 1e-12 + spacing, name


@pytest.mark.parametrize("turns", [-1, 2])
def test_whole_turns_of_the_start_stay(ball, turns):
    names, times = ("u", "v", "u1"), [0.0, 1.0, 40.0]
    start = {"u": 1.1, "u1": 1.0, "s": 0.3, "n": 0.2}
    away = {**start, "u": 1.1 + 2 * np.pi * turns}
    near, far = (vo.closed_form(ball, initial=i).at(times, names) for i in (start, away))
    assert np.abs(far["u"] - near["u"] - 2 * np.pi * turns).max() < 1e-11
    assert all(np.abs(far[q] - near[q]).max() < 1e-11 for q in ("v", "u1"))


def test_angles_of_an_upright_motion_are_continuous(ball):
    form = vo.closed_form(ball, initial={**START, **UPWARD})
    assert form.attitude.upright
    late = 1000 * form.period
    for name, turn in form.turns.items():
        grown = form.at([late], [name])[name][0] - form.enclose(0, 20)[name]
        assert abs(float(grown) - 1000 * turn.advance) < 1e-9
        assert abs(float(form.enclose(late, 20)[name]) - form.at([late])[name][0]) < 1e-9


def test_doubles_are_continuous_on_a_grid_where_the_momentum_is_not_upright(ball):
    form = vo.closed_form(ball, initial=START)
    assert not form.attitude.upright
    found = form.at(np.linspace(0, 30, 4001))
    for name in ANGLES:
        assert np.abs(np.diff(found[name])).max() < 0.5, name
        assert found[name][0] == pytest.approx(float(START[name]), abs=1e-14)


HARD = {
    "nearly a plane": ({}, {"R1": 10**12}),
    "nearly as large a sphere around": ({}, {"R1": -1 - R(1, 10**12)}),
    "a fast gyroscope": ({}, {"k": 10**8}),
    "inertia of a point": ({}, {"A": R(1, 10**10)}),
    "near a turning point": ({"tau": R(1, 10**12)}, {}),
    "from near a pole of the moving sphere": ({"u": R(1, 10**12), "s": 0, "tau": -1}, {}),
    "from near a pole of the fixed sphere": ({"u1": R(1, 10**6)}, {}),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", HARD)
def test_doubles_keep_their_digits_where_formulas_cancel(ball, case):
    changes, parameters = HARD[case]
    form = vo.closed_form(ball, parameters=parameters, initial={**START, **changes})
    times = np.array([0.21, 0.5, 1.3, 97.123]) * form.period
    found, period = form.modulo(times), form.at(np.linspace(0, form.period, 40))
    for i, t in enumerate(times):
        exact = form.enclose(float(t), 25)
        for name in NAMES:
            near = 2e-14 if name in ANGLES else 2e-15 * np.abs(period[name]).max()
            assert apart(name, exact[name], mpmath.mpf(found[name][i])) < near, name


def test_a_start_at_a_floating_number_is_that_number(ball):
    tenth = vo.closed_form(ball, initial={**START, "s": 0.1}).enclose(3, 40)["v"]
    exact = vo.closed_form(ball, initial={**START, "s": Fraction(0.1)}).enclose(3, 40)["v"]
    near = vo.closed_form(ball, initial={**START, "s": R(1, 10)}).enclose(3, 40)["v"]
    assert tenth.overlaps(exact)
    assert not tenth.overlaps(near)


@pytest.mark.slow
def test_velocities_of_coordinates_are_a_start_too(ball):
    form = vo.closed_form(ball, initial=START)
    rates = {vo.velocity(q): r for q, r in zip(ball.coordinates[:3], (R(1, 3), R(1, 7), -1),
                                               strict=True)}  # fmt: skip
    places = {name: START[name] for name in ANGLES}
    other = vo.closed_form(ball, initial={**places, **rates})
    step = 1e-7
    for q, rate in zip(("u", "v", "theta"), (1 / 3, 1 / 7, -1), strict=True):
        before, after = other.enclose(-step, 25)[q], other.enclose(step, 25)[q]
        assert float(after - before) / (2 * step) == pytest.approx(rate, abs=1e-12)
    assert form.constants != other.constants


def test_an_exact_start_far_from_doubles_keeps_its_digits(ball):
    tiny = vo.closed_form(ball, initial={**START, "tau": R(1, 10**30)})
    none = vo.closed_form(ball, initial={**START, "tau": 0})
    difference = tiny.enclose(1, 60)["u"] - none.enclose(1, 60)["u"]
    assert arb(0) < abs(difference) < arb("1e-29")


@pytest.mark.slow
def test_the_trajectory_of_the_method_holds_what_others_hold(ball):
    wanted = ("u", "v1", "x", "n", "energy", "reaction 1")
    times = np.linspace(0, 6, 121)
    closed = vo.integrate(ball, times=times, outputs=wanted, method="closed-form", dense=True)
    other = vo.integrate(ball, times=times, outputs=wanted, method="scipy", tol=2.3e-14)
    assert closed.cost.method == "closed-form"
    assert closed.cost.steps == 0
    assert max(closed.drift.values()) < 1e-13
    for name in wanted:
        assert np.abs(closed[name] - other[name]).max() < 1e-9, name
    assert closed.at([1.23])["u"][0] == vo.closed_form(ball).at([1.23])["u"][0]


def test_what_nobody_asked_for_is_evaluated_when_it_is_read(ball):
    given = {"times": np.linspace(0, 6, 121), "initial": START, "method": "closed-form"}
    at_once = vo.integrate(ball, **given, outputs=("u", "v"), dense=True)
    for read in (lambda run: run, lambda run: pickle.loads(pickle.dumps(run)), dataclasses.replace):
        late = read(vo.integrate(ball, **given, outputs=("u", "v")))
        assert late.outputs == ("u", "v")
        for name in (*NAMES, *at_once.integrals):
            assert np.array_equal(late[name], at_once[name]), name
        assert np.array_equal(late.state, at_once.state)
        for part in ("drift", "residuals", "notes", "names", "parameters", "events", "stopped"):
            assert getattr(late, part) == getattr(at_once, part), part
    late = vo.integrate(ball, **given, outputs=("u", "v"))
    assert not any(late[name].flags.writeable for name in ("u", "s", "energy"))
    with pytest.raises(vo.DefinitionError, match="the trajectory holds no 'w'"):
        late["w"]
    with pytest.raises(dataclasses.FrozenInstanceError):
        late.notes = ()


def test_a_tolerance_finer_than_doubles_gives_so_many_digits(ball):
    run = vo.integrate(ball, times=[0, 1, 2.5], method="closed-form", tol=1e-40)
    ours = vo.closed_form(ball).enclose(2.5, 50)
    for name in ANGLES:
        assert apart(name, ours[name], run[name][-1]) < 1e-38
    assert max(run.drift.values()) < 1e-40


def test_ctrl_c_keeps_the_instants_that_are_done(ball):
    told = []

    def stop(share):
        told.append(share)
        if share > 0.5:
            raise KeyboardInterrupt

    run = vo.integrate(
        ball, times=np.linspace(0, 1, 61), method="closed-form", tol=1e-20, progress=stop
    )
    assert run.interrupted
    assert 30 < len(run) < 61
    assert len(told) >= 2


def test_a_single_time_is_as_good_as_a_grid(ball):
    form = vo.closed_form(ball, initial=START)
    for name in NAMES:
        assert form.at(1.5)[name] == form.at([1.5])[name][0]


def test_times_that_start_late_count_from_there(ball):
    late = vo.integrate(ball, times=[5, 6], outputs=("v",), method="closed-form")
    assert late["v"][-1] == vo.closed_form(ball).at([1.0])["v"][0]


@pytest.mark.slow
def test_a_place_on_a_plane_follows(ball):
    zhukovsky = vo.load("zhukovsky-ball")
    names = [str(q) for q in (*zhukovsky.coordinates, *zhukovsky.velocities)]
    run = vo.integrate(zhukovsky, times=[0, 3], outputs=names, method="flint", tol=1e-22)
    form = vo.closed_form(zhukovsky)
    found, doubles = form.enclose(3, 30), form.at([3.0])
    for name in names:
        assert apart(name, found[name], run[name][-1]) < 1e-20, name
        assert doubles[name][0] == pytest.approx(float(run[name][-1]), abs=3e-15), name


REFUSED = {
    "a pole of the coordinates": ({"u": 0}, {}),
    "singular for R1 = -1": ({}, {"R1": -1}),
    "must be positive": ({}, {"A": -1}),
    "is not a real number": ({"s": math.nan}, {}),
    "has no initial value 'w'": ({"w": 1}, {}),
}


@pytest.mark.parametrize("why", REFUSED)
def test_input_that_makes_no_sense_is_refused_in_a_line(ball, why):
    changes, parameters = REFUSED[why]
    with pytest.raises(vo.DefinitionError, match=why) as refusal:
        vo.closed_form(ball, parameters=parameters, initial={**START, **changes})
    assert "\n" not in str(refusal.value)


def test_a_system_without_a_motion_names_those_that_have_one(monkeypatch):
    monkeypatch.setattr(vo, "names", lambda: ["sleigh", "demchenko", "snakeboard"])
    with pytest.raises(vo.DefinitionError, match=r"'sleigh' declares no motion.*demchenko"):
        vo.closed_form(vo.load("sleigh"))


def test_events_and_many_motions_are_not_for_the_closed_form(ball):
    with pytest.raises(vo.DefinitionError, match="looks for no events"):
        vo.integrate(ball, method="closed-form", events=("tau",))
    with pytest.raises(vo.DefinitionError, match="closed"):
        vo.ensemble(
            ball, scene="default", starts=[{}, {"v": 1}], times=[0, 1], method="closed-form"
        )


def test_the_last_motion_is_kept_and_no_other_is_taken_for_it(ball):
    first = vo.closed_form(ball, initial=START)
    assert vo.closed_form(ball, initial=START) is first
    other = vo.closed_form(ball, initial={**START, "s": 0.5})
    assert other.at([0.0])["s"][0] == 0.5
    again = vo.closed_form(ball, initial=START)
    assert again is not first and again.at([3.0])["u"][0] == first.at([3.0])["u"][0]
    heavier = vo.closed_form(ball, initial=START, parameters={"M": 3})
    assert heavier.at([3.0])["u"][0] != first.at([3.0])["u"][0]
