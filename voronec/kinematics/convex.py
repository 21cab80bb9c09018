"""A convex body that rolls: what is seen along axes fixed in it, by the normal at the contact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import sympy as sp

from voronec.declaration.reading import expression
from voronec.kinematics.bodies import momentum_about_point, momentum_rate_about_point
from voronec.kinematics.vectors import apply_matrix, column, cross, three


@dataclass(frozen=True)
class ConvexBody:
    """A convex body with its origin O inside, touched at M where its inner normal is gamma.

    normal
        gamma, a unit vector: from the contact into the body, the normal of what it rolls on.
    height
        the distance of O from the tangent plane, the support function.
    arm
        r = OM, a function of gamma and the height; r . gamma = -height.
    radii
        H with dr = -H dgamma: symmetric, H gamma = 0, and its other eigenvalues are the principal
        radii of curvature.

    Vectors are along the axes of the body.  The body rolls without slipping, so that the velocity
    of O is -omega x r.
    """

    normal: sp.ImmutableMatrix
    height: sp.Expr
    arm: sp.ImmutableMatrix
    radii: sp.ImmutableMatrix

    @classmethod
    def ellipsoid(cls, axes: Sequence[Any], normal: Sequence[Any], height: Any) -> ConvexBody:
        """An ellipsoid about O: with S = diag(a^2, b^2, c^2), height^2 = gamma . S gamma.

        r = -S gamma/height and H = S/height - S gamma gamma^T S/height^3.  ``height`` is that
        square root, or a symbol for it.
        """
        gamma = three(normal, "a normal")
        squares = [x**2 for x in three(axes, "the semi-axes of an ellipsoid")]
        h = expression(height, "a height")
        reach = [s * g for s, g in zip(squares, gamma, strict=True)]

        def radius(i: int, j: int) -> sp.Expr:
            diagonal = squares[i] / h if i == j else sp.Integer(0)
            return diagonal - reach[i] * reach[j] / h**3

        arm = column([-x / h for x in reach])
        return cls(column(gamma), h, arm, sp.ImmutableMatrix(3, 3, radius))

    def rolling_rate(self, omega: Sequence[Any], sphere: Any = None) -> sp.ImmutableMatrix:
        """dgamma/dt of the rolling body: gamma x omega on a plane.

        On a fixed ``sphere`` of that signed radius R1 it is R1 (R1 + H)^-1 (gamma x omega), where
        on vectors that are normal to gamma (R1 + H)^-1 = (R1 + k - H)/(R1^2 + R1 k + l), k the sum
        and l the product of the principal radii.
        """
        turning = column(cross(self.normal, three(omega, "an angular velocity")))
        if sphere is None:
            return sp.ImmutableMatrix(turning)
        radius = expression(sphere, "the radius of a sphere")
        bent = sp.Matrix(apply_matrix(self.radii, turning))
        taken = (radius + self.radii.trace()) * turning - bent
        return sp.ImmutableMatrix(radius * taken / self.curvature_product(radius))

    def curvature_product(self, radius: Any) -> sp.Expr:
        """(R1 + r1) (R1 + r2) with the principal radii of curvature r1, r2."""
        return radius**2 + radius * self.radii.trace() + _second(self.radii)

    def arm_rate(self, normal_rate: Any) -> sp.ImmutableMatrix:
        """dr/dt = -H dgamma/dt."""
        return sp.ImmutableMatrix(apply_matrix(-self.radii, sp.Matrix(normal_rate)))

    def momentum(self, mass: Any, inertia: Sequence[Any], omega: Any) -> sp.ImmutableMatrix:
        """G = I omega + m r x (omega x r): about the contact, the centre of mass being O.

        ``inertia`` are the principal moments about O, along the axes of the body.
        """
        spin, moments = three(omega, "an angular velocity"), three(inertia, "the moments of a body")
        return momentum_about_point(mass, moments, spin, self.arm)

    def momentum_rate(
        self, whole: Any, mass: Any, omega: Any, normal_rate: Any, weight: Any = 0
    ) -> sp.ImmutableMatrix:
        """dG/dt = (G + kappa) x omega + m dr/dt x (omega x r) + weight r x gamma.

        ``whole`` is G + kappa, with the momentum of a gyroscope; the middle term is there because
        the contact moves over the body; ``weight`` is a force along -gamma at O.
        """
        spin = three(omega, "an angular velocity")
        rate = momentum_rate_about_point(whole, mass, spin, self.arm, self.arm_rate(normal_rate))
        return rate + column(cross(self.arm, self.normal)) * weight


def _second(matrix: sp.ImmutableMatrix) -> sp.Expr:
    """The sum of the principal minors of order two."""
    pairs = ((0, 1), (0, 2), (1, 2))
    return sp.Add(*[matrix[i, i] * matrix[j, j] - matrix[i, j] * matrix[j, i] for i, j in pairs])
