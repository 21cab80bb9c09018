"""Forces that are powers of the distance from a place far off.

A motion does not know where the origin is: moved by c it has to be the same, but for the rounding
of its coordinates.  Written out in powers of x, (x - c)^5 loses all digits.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import symengine as se
import sympy as sp

import voronec as vo
from voronec import velocity
from voronec.motion.observables import size_of_terms

x, y, phi, along, turn = sp.symbols("x y phi along turn")
v, t = velocity(x), vo.time
FAR = 5000


def line(force: Any = 0, potential: Any = 0, mass: Any = 1) -> vo.System:
    """A particle on a line."""
    return vo.System(
        name="line",
        fibration=vo.Fibration(base=(x,), fibre=()),
        lagrangian=mass * v**2 / 2 - potential,
        forces={x: force} if force != 0 else {},
    )


def sleigh(potential: Any) -> vo.System:
    """A blade on a plane, with the energy for an integral."""
    kinetic = (v**2 + velocity(y) ** 2 + velocity(phi) ** 2) / 2
    return vo.System(
        name="sleigh",
        fibration=vo.Fibration(base=(x, phi), fibre=(y,)),
        lagrangian=kinetic - potential,
        constraints=(v * sp.sin(phi) - velocity(y) * sp.cos(phi),),
        integrals={"energy": kinetic + potential},
    )


def blade(constraint: Any, **more: Any) -> vo.System:
    """A point on a plane with a wheel, held by a constraint for ydot, in a valley along x = a."""
    a = more.pop("a")
    return vo.System(
        name="blade",
        fibration=vo.Fibration(base=(x, phi), fibre=(y,)),
        lagrangian=(v**2 + velocity(y) ** 2 + velocity(phi) ** 2 - a**2) / 2,
        constraints=(constraint,),
        **more,
    )


def arm(a: Any) -> vo.System:
    """A particle on a plane that turns about a = 0, with a speed beside each place."""
    w = velocity(phi)
    kinetic = (v - y * w) ** 2 + (velocity(y) + a * w) ** 2 + w**2
    return vo.System(
        name="arm",
        fibration=vo.Fibration(base=(x, y, phi), fibre=()),
        lagrangian=kinetic / 2 - y**2 - a / 3,
    )


SYSTEMS: dict[str, Callable[[Any], vo.System]] = {
    "a potential": lambda a: line(potential=a**4 / 4),
    "beside a pull": lambda a: line(-(a**5) - a / 3 - sp.Rational(1, 10)),
    "poles": lambda a: line(12 * ((a + 2) ** -13 - (a + 2) ** -7)),
    "a bump": lambda a: line(30 / (1 + 10**4 * a**4)),
    "two places": lambda a: line(-(a**3) * (a + 1) ** 2),
    "a mass": lambda a: line(mass=1 + a**2, potential=a**4 / 4 + a / 10),
    "a distance": lambda a: line(potential=sp.sqrt(1 + a**2) ** 3 + a / 5),
    "a blade": lambda a: sleigh(a**4 / 4 + phi**2 + a / 10),
    "a blade in a bowl": lambda a: sleigh((a**2 + y**2) ** 2 / 4),
    "a constraint": lambda a: blade(velocity(y) - a**3 * velocity(phi), a=a),
    "a constraint that moves": lambda a: blade(velocity(y) - a**2 * velocity(phi) - a * t, a=a),
    "accelerations": lambda a: line(-(a**4) * velocity(v) - a**3 * v, mass=2),
    "a constraint without poles": lambda a: blade(
        velocity(y) - sp.sqrt(1 + a**2) * velocity(phi) / 9 - sp.log(2 + a**4) * v, a=a
    ),
    "an arm": arm,
    "slopes that divide": lambda a: line(potential=a**2 - sp.atan(a**2)),
}


@pytest.mark.slow
@pytest.mark.parametrize("method", ["auto", "scipy"])
@pytest.mark.parametrize("name", SYSTEMS)
def test_a_motion_far_away_is_that_at_the_origin(name: str, method: str) -> None:
    near, far = SYSTEMS[name](x), SYSTEMS[name](x - FAR)
    turning = {near.velocities[-1]: sp.Rational(1, 2)} if phi in near.coordinates else {}
    start = {near.velocities[0]: sp.Rational(1, 5), **turning}
    # scipy's steps grow as short there as the rounding of x makes them
    end = 0.25 if (name, method) == ("a blade in a bowl", "scipy") else 4
    truth = vo.integrate(near, initial={x: 1, **start}, times=[0, end])
    found = vo.integrate(far, initial={x: FAR + 1, **start}, times=[0, end], method=method)
    for key in truth.outputs:
        moved = FAR if key == "x" else 0
        assert found[key][-1] - moved == pytest.approx(truth[key][-1], abs=3e-10), key
    assert all(drift < 1e-9 for drift in found.drift.values())


def test_time_is_a_place_too() -> None:
    near, far = (line(-((t - late) ** 5) - x) for late in (0, FAR))
    truth = vo.integrate(near, initial={x: 1}, times=[0, 2])
    found = vo.integrate(far, initial={x: 1}, times=[FAR, FAR + 2])
    assert found["x"][-1] == pytest.approx(truth["x"][-1], abs=1e-11)


@pytest.mark.parametrize("power", [3, 5])
def test_a_speed_beside_a_constant_is_no_sum_of_powers(power: int) -> None:
    """The drag of a belt that runs at 300 is that of one at rest, seen from it."""
    belt = 300
    rest = line(-(v**power) - x / 10)
    moved = line(-((v - belt) ** power) - (x - belt * t) / 10)
    truth = vo.integrate(rest, initial={x: 0, v: 1}, times=[0, 5])
    found = vo.integrate(moved, initial={x: 0, v: belt + 1}, times=[0, 5])
    assert found["x"][-1] - 5 * belt == pytest.approx(truth["x"][-1], abs=1e-10)
    assert found["xdot"][-1] - belt == pytest.approx(truth["xdot"][-1], abs=1e-11)


@pytest.mark.parametrize("system", [line(-((x - FAR) ** 5) - x / 3), arm(x - FAR)])
@pytest.mark.parametrize("form", ["python", "c"])
def test_printed_programs_keep_the_distance(form: str, system: vo.System) -> None:
    text = getattr(vo.derive(system), form)()
    assert str(FAR**2) not in text and str(FAR) in text


@pytest.mark.slow
def test_an_energy_that_is_rounding_is_no_integral_that_stays() -> None:
    """Its terms as they stand are 1e-4 of the powers of x."""
    system = sleigh((x - FAR) ** 4 / 4)
    run = vo.integrate(system, initial={x: FAR + 1, velocity(phi): 1}, times=[0, 4])
    series = run.integrals["energy"]
    assert np.ptp(series) / abs(series[0]) < 10 * run.drift["energy"] + 1e-15


def test_a_power_is_as_large_as_its_sum_makes_it() -> None:
    a, b, c = se.symbols("a b c")
    values = {a: 1001.0, b: -1000.0, c: 2.0}

    def size(expr: Any) -> float:
        return float(size_of_terms(expr).subs(values).n(53, real=True))

    assert size((a + b) ** 4) == pytest.approx(2001)
    assert size(c * (a + b) ** 2) == pytest.approx(2 * 2001)
    assert size((a + b) * (a + c)) == pytest.approx(2001 * 1003 + 1003)
    assert size(a - c) == pytest.approx(1003)
