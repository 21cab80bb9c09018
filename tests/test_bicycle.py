"""The bicycle, against the published linearised motion and against its own symmetries."""

from __future__ import annotations

import importlib.util
from functools import cache
from pathlib import Path
from typing import Any

import mpmath
import pytest
import sympy as sp

import voronec as vo

pytestmark = pytest.mark.slow

DIGITS = 40
# [Meijaard2007, table 2], to the digits printed there.
PUBLISHED = {
    5: (-14.07838969279822, -0.77534188219585 + 4.46486771378823j, -0.32286642900409),
    10: (-24.62459635017404, -3.72016840437287 + 10.9068113947629j, 0.16105338653172),
}


@cache
def bicycle() -> vo.System:
    path = Path(__file__).parents[1] / "systems" / "bicycle.py"
    spec = importlib.util.spec_from_file_location("bicycle_under_test", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.SYSTEM


@cache
def equations() -> vo.VoronecEquations:
    return vo.derive(bicycle())


def at(**values: Any) -> dict[str, Any]:
    """A point: the given values, zero for the rest."""
    system = bicycle()
    names = [str(s) for s in (*system.coordinates, *system.velocities)]
    return dict.fromkeys(names, 0) | values


def acceleration(point: dict[str, Any]) -> dict[str, sp.Float]:
    values = equations().acceleration(point, digits=DIGITS)
    return {str(q): value for q, value in values.items()}


def linearised(speed: int) -> mpmath.matrix:
    """The matrix of (roll, steer, roll rate, steer rate) about upright straight motion."""
    step = sp.Rational(1, 10**12)
    matrix = mpmath.zeros(4, 4)
    matrix[0, 2] = matrix[1, 3] = 1
    for column, name in enumerate(("phi", "delta", "roll_rate", "steer_rate")):
        plus, minus = (acceleration(at(speed=speed, **{name: sign * step})) for sign in (1, -1))
        for row, q in enumerate(("phi", "delta")):
            slope = (plus[q] - minus[q]) / (2 * step)
            matrix[2 + row, column] = mpmath.mpf(str(slope))
    return matrix


@pytest.mark.parametrize("speed", PUBLISHED)
def test_the_eigenvalues_of_upright_motion_are_the_published_ones(speed: int) -> None:
    with mpmath.workdps(DIGITS):
        found = [complex(e) for e in mpmath.eig(linearised(speed))[0]]
    upper = sorted((e for e in found if e.imag > -1e-9), key=lambda e: e.real)
    expected = sorted(map(complex, PUBLISHED[speed]), key=lambda e: e.real)
    assert upper == pytest.approx(expected, abs=5e-13)


def test_the_upright_bicycle_rolls_straight_on() -> None:
    still = acceleration(at(speed=6))
    assert all(abs(value) < 1e-30 for value in still.values())


def leaning(**changes: Any) -> dict[str, Any]:
    numbers = {"phi": "0.3", "delta": "-0.4", "theta": "0.07", "psi": "0.9"}
    numbers |= {"roll_rate": "0.5", "steer_rate": "-0.8", "speed": "3.9"}
    return at(**{k: sp.Rational(v) for k, v in numbers.items()} | changes)


def test_a_mirror_image_moves_as_the_mirror_image() -> None:
    right = leaning()
    odd = {"phi", "delta", "psi", "y"}
    flipped = odd | {"roll_rate", "steer_rate"}
    left = {name: -value if name in flipped else value for name, value in right.items()}
    there, here = acceleration(right), acceleration(left)
    for q, value in there.items():
        assert here[q] == pytest.approx(-value if q in odd else value, abs=1e-35)


def test_where_it_stands_and_how_far_the_wheels_have_turned_does_not_matter() -> None:
    shape = ("phi", "delta", "theta", "z", "psi", "beta_R", "beta_F")
    here = acceleration(leaning())
    there = acceleration(leaning(x=7, y=-5, beta_R=11, beta_F=-3))
    turned = acceleration(leaning(psi=sp.pi / 2))
    for q in shape:
        assert there[q] == pytest.approx(here[q], abs=1e-35)
        assert turned[q] == pytest.approx(here[q], abs=1e-35)


def test_the_multiplier_route_agrees_to_forty_digits() -> None:
    point = leaning()
    other = vo.multiplier_acceleration(bicycle(), point, digits=50)
    for q, value in equations().acceleration(point, digits=50).items():
        assert abs(value - other[q]) < 1e-40 * (1 + abs(value))


def on_constraints(point: dict[str, Any]) -> dict[sp.Expr, sp.Expr]:
    """All values at a point; coordinate velocities from the constraints and the frame itself."""
    system = bicycle()
    values = {p.symbol: p.value for p in system.parameters}
    values |= {s: point[str(s)] for s in (*system.coordinates, *system.velocities)}
    unknown = [vo.velocity(s) for s in system.coordinates]
    assert system.frame is not None
    frame = zip(system.frame.expressions, system.frame.velocities, strict=True)
    vanishing = [*system.constraints, *(e - v for e, v in frame)]
    numeric = [sp.expand(sp.N(c.xreplace(values), DIGITS + 10)) for c in vanishing]
    matrix = sp.Matrix([[c.coeff(s) for s in unknown] for c in numeric])
    rest = sp.Matrix([c.xreplace(dict.fromkeys(unknown, 0)) for c in numeric])
    return values | dict(zip(unknown, matrix.LUsolve(-rest), strict=True))


def test_the_claimed_integrals_do_not_change() -> None:
    """Energy and the heights of both contacts, differentiated along the motion."""
    system, point = bicycle(), leaning()
    second, values = acceleration(point), on_constraints(point)
    for name, integral in system.integrals.items():
        terms = [
            integral.diff(q) * vo.velocity(q) + integral.diff(vo.velocity(q)) * second[str(q)]
            for q in system.coordinates
        ]
        change = sum(sp.N(term.xreplace(values), DIGITS) for term in terms)
        assert abs(change) < 1e-30, name


@pytest.mark.parametrize("scene", ["default", "weave"])
def test_both_wheels_touch_the_ground_at_the_start_of_every_scene(scene: str) -> None:
    system = bicycle()
    start = {sp.sympify(k): v for k, v in system.scenes[scene].initial.items()}
    values = {p.symbol: p.value for p in system.parameters}
    values |= {s: start.get(s, 0) for s in system.coordinates}
    for name in ("rear contact", "front contact"):
        assert abs(sp.N(system.integrals[name].xreplace(values), DIGITS)) < 1e-30


@pytest.mark.parametrize("side", [1, -1])
def test_a_bicycle_on_its_side_has_no_motion(side: int) -> None:
    flat = {"phi": float(side * sp.pi / 2), "speed": 1.0}
    with pytest.raises(vo.DefinitionError, match="no motion exists"):
        vo.integrate(vo.load("bicycle"), initial=flat, times=[0, 0.1], project=True)
