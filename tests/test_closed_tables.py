"""Very many times at once: by tables of one period, as good as one by one."""

from copy import copy

import numpy as np
import pytest
import sympy as sp
from test_closed_form import ANGLES, CASES, NAMES, START, UPWARD, apart

import voronec as vo
from voronec.closed.closed_form import BLOCK, MANY
from voronec.elliptic.panels import Panels

R = sp.Rational
PERIODIC = {
    "any direction in space": {},
    "upright": UPWARD,
    "upright, whole turns at the start": {**UPWARD, "v": 40, "theta": sp.pi / 2 + 6 * sp.pi},
    "colatitudes beyond their range": CASES["colatitudes beyond their range"][0],
    "momentum along the normal": CASES["momentum along the normal"][0],
}


@pytest.fixture
def ball():
    """A system that keeps no motion of another test."""
    return copy(vo.load("demchenko"))


@pytest.fixture
def made(monkeypatch):
    """The tables that are made meanwhile."""
    found, make = [], Panels.of

    def note(*arguments):
        found.append(make(*arguments))
        return found[-1]

    monkeypatch.setattr(Panels, "of", note)
    return found


@pytest.mark.slow
@pytest.mark.parametrize("late", [0, 10**6])
@pytest.mark.parametrize("case", PERIODIC)
def test_many_times_give_what_few_give(ball, case, late, made):
    form = vo.closed_form(ball, initial={**START, **PERIODIC[case]})
    times = form.period * (late + np.linspace(0, 30, MANY + 1))
    many, part = form.at(times), form.modulo(times, NAMES[:5])
    assert made
    some = slice(None, None, MANY // 40)
    few, little = form.at(times[some]), form.modulo(times[some], NAMES[:5])
    for name in NAMES:
        found = many[name][some]
        if name in ANGLES:
            assert np.abs(part[name]).max() <= np.pi
            assert np.abs(np.exp(1j * part[name][some]) - np.exp(1j * little[name])).max() < 5e-14
            spacing = np.spacing(np.abs(found)).max()
            assert np.abs(np.exp(1j * found) - np.exp(1j * few[name])).max() < 5e-14 + 4 * spacing
        else:
            scale = np.abs(many[name]).max()
            assert np.abs(found - few[name]).max() < 1e-14 * scale, name
    for name in ("u", "v") if not form.attitude.upright else NAMES[:5]:
        spacing = np.spacing(np.abs(few[name]))
        assert (np.abs(many[name][some] - few[name]) < 5e-14 + 2 * spacing).all(), name


def test_continuous_angles_are_those_modulo_a_turn_and_never_jump(ball):
    form = vo.closed_form(ball, initial=START)
    assert not form.attitude.upright
    times = np.linspace(0, 200, 4 * BLOCK + 3)
    whole, part = form.at(times, NAMES[:5]), form.modulo(times, NAMES[:5])
    for name in NAMES[:5]:
        assert np.abs(np.diff(whole[name])).max() < 0.5, name
        assert np.abs(np.exp(1j * whole[name]) - np.exp(1j * part[name])).max() < 1e-12, name
    assert np.abs(whole["v1"]).max() > 2 * np.pi or np.abs(whole["theta"]).max() > 2 * np.pi


@pytest.mark.slow
def test_longitudes_are_right_where_a_turned_motion_passes_near_a_pole(ball):
    """Doubles tell them by an angle of the size of the colatitude's sine."""
    form = vo.closed_form(ball, initial={**START, "u1": R(1, 20000), "tau": 0})
    assert not form.attitude.upright
    step = form.period / 2**12
    times = step * np.arange(-MANY // 2, MANY // 2)
    found = form.modulo(times, ("u1", "v1", "theta"))
    sine = np.sin(found["u1"])
    assert sine.min() < 6e-5
    rising = np.argsort(np.abs(sine - 0.0105))[:4]
    for place in (MANY // 2, MANY // 2 + 1, MANY // 2 - 2, *map(int, rising)):
        exact = form.enclose(float(times[place]), 25)
        for name in found:
            assert apart(name, exact[name], found[name][place].item()) < 1e-13, name


def test_a_fast_angle_and_a_place_on_a_plane_do_without_tables(ball, made):
    fast = vo.closed_form(ball, initial={**START, **UPWARD, "n": R(10**6)})
    assert np.isfinite(fast.at(np.linspace(0, 1, MANY), ["theta"])["theta"]).all()
    made.clear()
    sphere = vo.closed_form(vo.load("zhukovsky-ball"))
    names = [str(q) for q in sphere.quadratures.plane.place]
    times = np.linspace(0, 30, MANY)
    many, few = sphere.at(times, names), sphere.at(times[::500], names)
    assert not made
    for name in names:
        assert np.array_equal(many[name][::500], few[name])
