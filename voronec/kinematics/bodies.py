"""Energies of rigid bodies, and of rotors built into them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import sympy as sp

from voronec.declaration.bodies import inertia_tensor
from voronec.declaration.reading import expression
from voronec.kinematics.vectors import Vector, column, cross, dot, three


def kinetic_energy(
    mass: Any, velocity: Sequence[Any], inertia: Any, omega: Sequence[Any]
) -> sp.Expr:
    """m |w|^2 / 2 + omega . I omega / 2.

    ``velocity`` is that of the centre of mass, along any orthonormal axes; ``omega`` the angular
    velocity in the axes in which ``inertia`` is given: three principal moments or a symmetric
    3 x 3 matrix, about the centre of mass.  Anything else raises ``DefinitionError``.
    """
    w, spin = three(velocity, "the velocity of a body"), three(omega, "an angular velocity")
    tensor = inertia_tensor(inertia)
    entries = [(i, j) for i in range(3) for j in range(3) if tensor[i, j] != 0]
    rotation = sp.Add(*[tensor[i, j] * spin[i] * spin[j] for i, j in entries])
    return expression(mass, "a mass") * dot(w, w) / 2 + rotation / 2


def momentum_about_point(
    mass: Any, inertia: Sequence[Any], omega: Sequence[Any], arm: Sequence[Any]
) -> sp.ImmutableMatrix:
    """G = I omega + m r x (omega x r), about a point that is at rest for an instant.

    ``arm`` = r leads to it from the centre of mass, about which ``inertia`` are the three principal
    moments.
    """
    carried = cross(arm, cross(omega, arm))
    return column([i * w + mass * x for i, w, x in zip(inertia, omega, carried, strict=True)])


def momentum_rate_about_point(
    whole: Any, mass: Any, omega: Sequence[Any], arm: Sequence[Any], arm_rate: Sequence[Any]
) -> sp.ImmutableMatrix:
    """dG/dt = (G + kappa) x omega + m dr/dt x (omega x r), along the axes of the body: of
    ``momentum_about_point`` about a contact that moves over the body, dr/dt = ``arm_rate``.

    ``whole`` is G + kappa, with the momentum of a gyroscope, or G alone; ``omega`` and the two
    others have three components.  No other force than that at the contact acts.
    """
    moved = column(cross(arm_rate, cross(omega, arm)))
    return column(cross(whole, omega)) + mass * moved


def point_velocity(velocity: Sequence[Any], omega: Sequence[Any], arm: Sequence[Any]) -> Vector:
    """velocity + omega x arm: the velocity of the body's point at ``arm`` from another one.

    All three along the same right-handed axes; so for a centre of mass that is not the body's
    origin.  Raises ``DefinitionError`` for what is not of three expressions.
    """
    w = three(velocity, "the velocity of a body")
    turned = cross(three(omega, "an angular velocity"), three(arm, "an arm"))
    return w[0] + turned[0], w[1] + turned[1], w[2] + turned[2]


def axial_rotor(momentum: Any, axis: Sequence[Any], omega: Sequence[Any]) -> sp.Expr:
    """k (axis . omega): what a rotor of constant axial momentum k adds to the Lagrangian.

    The rotor turns by chi about an axis (a unit vector) fixed in the body, without axial torque.
    Its axial energy C (axis . omega + dchi/dt)^2 / 2 makes chi cyclic, so that
    k = C (axis . omega + dchi/dt) is constant, and Routh's function, energy minus k dchi/dt, is
    k (axis . omega) - k^2 / (2 C).  The rotor's mass and its transverse moments of inertia belong
    to the body, its axial moment C does not.  ``axis`` and ``omega`` are given along the same axes;
    ``DefinitionError`` for what is not of three expressions.
    """
    direction = three(axis, "the axis of a rotor")
    return expression(momentum, "a momentum") * dot(direction, three(omega, "an angular velocity"))


def uniform_field_energy(
    mass: Any, position: Sequence[Any], acceleration: Sequence[Any]
) -> sp.Expr:
    """-m (g . r): the potential energy of a mass at r in a field of constant acceleration g.

    ``position`` is that of the centre of mass, in space, as is ``acceleration``; (0, 0, -g) for
    gravity with z upward, and then it is m g z.  Raises ``DefinitionError`` for what is not of
    three expressions.
    """
    g = three(acceleration, "the acceleration of a field")
    return -expression(mass, "a mass") * dot(g, three(position, "a position"))
