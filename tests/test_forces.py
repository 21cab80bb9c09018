"""Forces along velocities: they do the work that is declared, whatever the coordinates are."""

from __future__ import annotations

from typing import Any

import pytest
import sympy as sp

import voronec as vo
from voronec import Fibration, Frame, System, velocity

x, y, phi, psi, z = sp.symbols("x y phi psi z")
v, omega, push, turn = sp.symbols("v omega push turn")
m, J, a = sp.symbols("m J a", positive=True)
DX, DY, DPHI = map(velocity, (x, y, phi))


def sleigh(forces: Any, **changes: Any) -> System:
    """A sleigh with the centre of mass a ahead of the blade."""
    declared: dict[str, Any] = {
        "fibration": Fibration((x, phi), (y,)),
        "frame": Frame.quasi({v: DX * sp.cos(phi) + DY * sp.sin(phi), omega: DPHI}),
        "lagrangian": m * (DX**2 + DY**2) / 2 + (J + m * a**2) * DPHI**2 / 2
        + m * a * DPHI * (DY * sp.cos(phi) - DX * sp.sin(phi)),
        "constraints": (DX * sp.sin(phi) - DY * sp.cos(phi),),
        "parameters": (m, J, a),
        "inputs": (push, turn),
    }  # fmt: skip
    return System(name="pushed-sleigh", forces=forces, **{**declared, **changes})


def test_forces_along_quasi_velocities_stand_in_their_equations() -> None:
    """m v' = m a omega^2 + push, (J + m a^2) omega' = -m a v omega + turn: by hand."""
    eqs = vo.derive(sleigh({v: push, omega: turn}))
    assert eqs.mass == sp.ImmutableMatrix([[m, 0], [0, J + m * a**2]])
    expected = [m * a * omega**2 + push, -m * a * v * omega + turn]
    for found, by_hand in zip(eqs.force, expected, strict=True):
        assert vo.prove_equal(found, by_hand).proved


@pytest.mark.parametrize("frame", [None, "quasi"])
def test_the_power_of_a_force_is_force_times_velocity(frame: str | None) -> None:
    """dE/dt = push w for any combination w of velocities, in any frame."""
    along = a * DPHI * sp.cos(phi) + DX * sp.sin(phi) - 3 * DY
    changes = {"frame": None} if frame is None else {}
    system = sleigh({along: push}, **changes)
    eqs = vo.derive(system)
    energy = eqs.theta  # kinetic energy alone
    rates = dict(zip(eqs.coordinates, eqs.rates, strict=True))
    power = sum(energy.diff(q) * rate for q, rate in rates.items())
    # dE/dt = dE/dq q' + p v' with p = M v, and M v' = force
    power += sum(w * f for w, f in zip(eqs.velocities, eqs.force, strict=True))
    dots = {velocity(q): rate for q, rate in rates.items()}
    assert vo.prove_equal(power, push * along.xreplace(dots)).proved


def test_forces_on_one_coordinate_add_up() -> None:
    both = sleigh({x: 1, DX: 2, phi: turn, omega: push})
    assert both.forces == {x: 3, phi: turn + push}
    assert sleigh(dict(both.forces)).forces == both.forces


def test_what_a_force_acts_along_may_be_named() -> None:
    by_symbol = sleigh({x: 1, v: push, DPHI: turn, DX - 2 * DY: a})
    assert sleigh({"x": 1, "v": push, "phidot": turn, "xdot - 2*ydot": a}) == by_symbol
    with pytest.raises(vo.DefinitionError, match=r"acts along: 'v \+' is not a formula"):
        sleigh({"v +": push})
    p, q = sp.symbols("p q")
    frame = Frame.group((p, q), {(p, q): {q: 1}})
    options: dict[str, Any] = {"frame": frame, "lagrangian": (p**2 + q**2) / 2}
    on_group = System("named", Fibration(()), forces={"q": -q}, **options)
    assert on_group.forces == {q: -q}
    with pytest.raises(vo.DefinitionError, match="not a velocity of the frame; these are 'p', 'q'"):
        System("named", Fibration(()), forces={"r": -q}, **options)


def test_the_referee_agrees() -> None:
    system = sleigh({v: push * phi, DY: turn})
    point = {x: 1, y: 2, phi: sp.Rational(1, 3), v: 2, omega: -1, m: 2, J: 3, a: sp.Rational(1, 2)}
    point |= {push: 5, turn: sp.Rational(7, 3)}
    found = vo.derive(system).acceleration(point)
    other = vo.multiplier_acceleration(system, point)
    for q, value in found.items():
        assert abs(value - other[q]) < sp.Float(10) ** -25


def test_an_input_of_one_sign_is_refused() -> None:
    """SymPy has written Max(-1, Min(1, u)) as Min(1, u) by then."""
    up = sp.Symbol("up", positive=True)
    with pytest.raises(vo.DefinitionError, match="a symbol of one sign"):
        sleigh({v: sp.Max(-1, sp.Min(1, up))}, inputs=(up,))


@pytest.mark.parametrize("direction", [z, m, DX**2, sp.Integer(1), "speed", velocity(z)])
def test_what_is_no_velocity_is_refused(direction: Any) -> None:
    with pytest.raises(vo.DefinitionError, match="neither a coordinate nor a velocity") as caught:
        sleigh({direction: push})
    assert "'v', 'omega', 'xdot'" in str(caught.value) and "\n" not in str(caught.value)
