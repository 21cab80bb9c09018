"""Runs through singular splits of the velocities while something else moves: inputs, the time in a
constraint, switching surfaces of other coordinates, numbers of many digits.

All truths are closed formulas for a blade that turns evenly: its heading is known, its speed a
polynomial of the time, and its place the integral of their product.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any

import mpmath
import numpy as np
import pytest
import sympy as sp

import voronec as vo
from voronec import velocity

pytestmark = pytest.mark.slow

x, y, phi, slide, u = sp.symbols("x y phi slide u")
Dx, Dy, Dphi = velocity(x), velocity(y), velocity(phi)
FIRST, SPIN = 0.25, 2.0
START = {"phi": FIRST, "xdot": np.cos(FIRST), "phidot": SPIN}
TOLERANCE = 1e-11


@cache
def skate(push: Any = 0, angle: Any = phi, inputs: Any = ()) -> vo.System:
    """A blade of unit mass and inertia, pushed along its ``angle``; its split, by x', is singular
    where it heads along y."""
    c, s = sp.cos(angle), sp.sin(angle)
    return vo.System(
        name="skate",
        fibration=vo.Fibration(base=(x, phi), fibre=(y,)),
        lagrangian=(Dx**2 + Dy**2 + Dphi**2) / 2,
        constraints=(Dx * s - Dy * c,),
        forces={x: push * c, y: push * s},
        inputs=inputs,
    )


def along(push: float, v: float, begin: float, end: float, spin: float = SPIN) -> complex:
    """The way x + iy of a blade with heading FIRST + spin t, from the speed v on."""

    def way(t: float) -> complex:
        heading = np.exp(1j * (FIRST + spin * t))
        return complex(heading * ((v + push * (t - begin)) / (1j * spin) + push / spin**2))

    return way(end) - way(begin)


def pushed(knots: Any, values: Any, end: float) -> complex:
    """The same where the push is held from knot to knot."""
    v, place = 1.0, 0j
    inside = [t for t in knots if min(0, end) < t < max(0, end)]
    times = sorted([0.0, end, *inside], reverse=end < 0)
    for a, b in pairwise(times):
        push = values[np.searchsorted(knots, (a + b) / 2) - 1]
        place, v = place + along(push, v, a, b), v + push * (b - a)
    return place


KNOTS, VALUES = [-6, 0.5, 1.25, 3], [1, -0.5, 0.75, -0.25]


@pytest.mark.parametrize("method", ["heyoka", "scipy", "c", "lsoda", "flint"])
@pytest.mark.parametrize("end", [6.0, -4.0])
def test_a_table_pushes_a_skate_through_its_singular_heading(method: str, end: float) -> None:
    run = vo.integrate(
        skate(u, inputs=(u,)), initial=START, times=[0, end], method=method,
        tol=1e-20 if method == "flint" else 1e-13,
        inputs={u: vo.Table(KNOTS, VALUES, "held")}, outputs=("x", "y", "u"), dense=True,
    )  # fmt: skip
    place = complex(run["x"][-1], run["y"][-1])
    assert abs(place - pushed(KNOTS, VALUES, end)) < TOLERANCE
    inside = run.at([end / 3])
    place = complex(inside["x"][0], inside["y"][0])
    assert abs(place - pushed(KNOTS, VALUES, end / 3)) < TOLERANCE
    assert float(inside["u"][0]) == VALUES[np.searchsorted(KNOTS, end / 3) - 1]


@pytest.mark.parametrize("value", [vo.Table([0, 1], [1, -1], "held"), lambda t: 1 - 2 * (t >= 1)])
def test_an_input_moves_a_skate_that_starts_where_its_split_is_singular(value: Any) -> None:
    run = vo.integrate(
        skate(u, inputs=(u,)), initial={phi: sp.pi / 2, Dy: 1, Dphi: SPIN}, times=[0, 1, 3],
        inputs={u: value}, method="scipy",
    )  # fmt: skip
    late = 1j * np.exp(-1j * FIRST)  # begins with the heading pi/2
    place = (along(1, 1, 0, 1) + along(-1, 2, 1, 3)) * late
    assert abs(complex(run["x"][-1], run["y"][-1]) - place) < TOLERANCE


@pytest.mark.parametrize("method", ["heyoka", "scipy", "flint"])
def test_a_blade_is_steered_by_a_table(method: str) -> None:
    """Its divisor, cos(u), is no function of the state."""
    steered = vo.System(
        name="steered",
        fibration=vo.Fibration(base=(x,), fibre=(y,)),
        lagrangian=(Dx**2 + Dy**2) / 2,
        constraints=(Dx * sp.sin(u) - Dy * sp.cos(u),),
        inputs=(u,),
    )
    run = vo.integrate(
        steered, initial={Dx: np.cos(FIRST)}, times=[0, 4], method=method,
        tol=1e-20 if method == "flint" else 1e-13, inputs={u: ([0, 4], [FIRST, FIRST + 4 * SPIN])},
    )  # fmt: skip
    assert abs(complex(run["x"][-1], run["y"][-1]) - along(0, 1, 0, 4)) < TOLERANCE


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
@pytest.mark.parametrize("turn", [1.5, 0.0])
@pytest.mark.parametrize("mu", [0, 0.125])
def test_the_time_turns_a_blade(method: str, turn: float, mu: float) -> None:
    """The constraint holds the time, and it alone where the body does not turn."""
    angle = (phi if turn else sp.Rational(1, 4)) + vo.time / 2
    speed = Dx * sp.cos(angle) + Dy * sp.sin(angle)
    for end in (7.0, -5.0):
        run = vo.integrate(
            skate(-mu * sp.sign(speed), angle), method=method, times=[0, end],
            initial={phi: FIRST, Dx: np.cos(FIRST), Dphi: turn},
        )  # fmt: skip
        place = along(-mu, 1, 0, end, turn + 0.5)
        assert abs(complex(run["x"][-1], run["y"][-1]) - place) < TOLERANCE


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
def test_steps_of_the_time_beside_a_constant_of_the_motion(method: str) -> None:
    """phi' is a constant, and with it a parameter of the smallest model."""
    run = vo.integrate(skate(sp.floor(vo.time)), initial=START, times=[0, 2.5], method=method)
    place = pushed([-1, 0, 1, 2], [-1, 0, 1, 2], 2.5)
    assert abs(complex(run["x"][-1], run["y"][-1]) - place) < TOLERANCE


@pytest.mark.parametrize("framed", [True, False])
@pytest.mark.parametrize("method", ["heyoka", "scipy"])
def test_events_of_velocities_that_friction_holds_are_found_in_any_frame(
    method: str, framed: bool
) -> None:
    """At rest xdot is zero but for rounding, whose sign means nothing, in whatever frame."""
    v, w = sp.symbols("v w")
    speed = Dx * sp.cos(phi) + Dy * sp.sin(phi)
    mu, blade = 0.3125, skate(-0.3125 * sp.sign(speed))
    if framed:
        blade = replace(blade, frame=vo.Frame.quasi({v: speed, w: Dphi}))
    run = vo.integrate(blade, initial=START, times=[0, 6], method=method, events=(Dx, Dy))
    stop = 1 / mu
    for name, first in (("xdot", np.pi / 2), ("ydot", np.pi)):
        turns = (first + np.pi * np.arange(3) - FIRST) / SPIN
        expected = [*turns[turns < stop], stop]
        assert run.events[name].t == pytest.approx(expected, abs=TOLERANCE)


@cache
def with_slider() -> vo.System:
    """A blade, and beside it a slider with dry friction that goes to and fro."""
    bare = skate()
    return vo.System(
        name="slider",
        fibration=vo.Fibration(base=(x, phi, slide), fibre=(y,)),
        lagrangian=bare.lagrangian + velocity(slide) ** 2 / 2,
        constraints=bare.constraints,
        forces={slide: 2 * sp.sin(phi) - sp.sign(velocity(slide))},
    )


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
def test_many_motions_with_switches_go_on_in_other_splits(method: str) -> None:
    headings = np.array([FIRST, 0.75, 1.5, 1.5703125])
    many = vo.ensemble(
        with_slider(), starts={"phi": headings, "xdot": np.cos(headings), "phidot": SPIN},
        times=[0, 4.5], outputs=("x", "y", "slide"), method=method,
    )  # fmt: skip
    places = along(0, 1, 0, 4.5) * np.exp(1j * (headings - FIRST))
    assert not many.errors
    assert np.abs(many["x"][:, -1] + 1j * many["y"][:, -1] - places).max() < TOLERANCE
    section = vo.section(
        with_slider(), sp.sin(phi - FIRST - 1), starts=[START], crossings=4, until=30,
        outputs=("x", "y", "slide"), method=method,
    )  # fmt: skip
    times = (1 + 2 * np.pi * np.arange(4)) / SPIN
    assert section.t == pytest.approx(times, abs=TOLERANCE) and not section.errors
    places = np.array([along(0, 1, 0, t) for t in times])
    assert np.abs(section["x"] + 1j * section["y"] - places).max() < TOLERANCE


def test_a_section_with_friction_goes_on_where_its_switch_and_its_split_meet() -> None:
    speed = Dx * sp.cos(phi) + Dy * sp.sin(phi)
    section = vo.section(
        skate(-sp.sign(speed) / 8), sp.sin(phi - FIRST - 1), starts=[START], crossings=2, until=7,
        outputs=("x", "y"),
    )  # fmt: skip
    times = (1 + 2 * np.pi * np.arange(2)) / SPIN
    places = np.array([along(-0.125, 1, 0, t) for t in times])
    assert not section.errors
    assert np.abs(section["x"] + 1j * section["y"] - places).max() < TOLERANCE


def test_all_digits_between_the_instants_of_a_run_through_splits() -> None:
    start = {phi: sp.Rational(1, 4), Dx: sp.cos(sp.Rational(1, 4)), Dphi: 2}
    run = vo.integrate(skate(), initial=start, times=[0, 4], tol=1e-30, dense=True)
    with mpmath.workdps(40):
        third = mpmath.mpf(10) / 3
        found = run.at([third])
        heading = mpmath.mpf(1) / 4 + 2 * third
        assert abs(found["phi"][0] - heading) < 1e-28
        place = (mpmath.sin(heading) - mpmath.sin(mpmath.mpf(1) / 4)) / 2
        assert abs(found["x"][0] - place) < 1e-28


@pytest.mark.parametrize("spin", [1e-8, 1e-9])
def test_a_rate_that_is_nothing_in_one_chart_and_large_in_another(spin: float) -> None:
    """A pendulum on a sphere that passes its poles: the unit of phi' is that of the start."""
    theta = sp.Symbol("theta")
    pendulum = vo.System(
        name="pendulum",
        fibration=vo.Fibration(base=(theta, phi)),
        lagrangian=(velocity(theta) ** 2 + sp.sin(theta) ** 2 * Dphi**2) / 2 - sp.cos(theta),
    )
    start = {theta: 1, velocity(theta): 1.5, Dphi: spin}
    run = vo.integrate(pendulum, initial=start, times=[0, 2, 4, 6], method="heyoka")
    energy = (run["thetadot"] ** 2 + (np.sin(run["theta"]) * run["phidot"]) ** 2) / 2
    energy += np.cos(run["theta"])
    assert np.abs(energy - energy[0]).max() < 1e-12
    plane = vo.System(
        name="plane pendulum",
        fibration=vo.Fibration(base=(theta,)),
        lagrangian=velocity(theta) ** 2 / 2 - sp.cos(theta),
    )
    flat = vo.integrate(
        plane, initial={theta: 1, velocity(theta): 1.5}, times=[0, 2, 4, 6], method="scipy"
    )
    assert np.abs(np.cos(run["theta"]) - np.cos(flat["theta"])).max() < 1e-10
