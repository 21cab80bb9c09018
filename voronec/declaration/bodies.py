"""Rigid bodies of a mechanism, with what acts on them: what Newton's and Euler's laws speak of."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import sympy as sp

from voronec.algebra.arguments import takes_fields
from voronec.declaration.reading import expression, several
from voronec.errors import DefinitionError, quote


@takes_fields
@dataclass(frozen=True)
class Body:
    """A rigid body, or a particle, or a place without mass at which a force acts.

    mass
        of the body; zero for a place, or where the mass centre is at rest.
    velocity
        that of the mass centre along axes at rest, three expressions of coordinates, their
        velocities, parameters and the time.
    inertia, omega
        about the mass centre, three principal moments or a symmetric 3 x 3 matrix, and the angular
        velocity, both along the same right-handed axes.
    turning
        the angular velocity of these axes, along themselves; ``omega`` where they are fixed in the
        body, which they are unless it is said.
    force, torque
        what acts besides the reactions of the constraints: the force along axes at rest, at the
        mass centre, and the torque about it along the axes of ``omega``.
    title
        what it is called.

    Its kinetic energy, m v^2/2 + omega . I omega/2, belongs to the Lagrangian of the system, and
    the work of what acts on it to the forces or the potential: ``voronec methods`` proves whether
    they fit.  Raises ``DefinitionError`` for what is no expression, for lists that are not of
    three, and for a torque on what does not turn.
    """

    mass: Any
    velocity: tuple[Any, ...] = (0, 0, 0)
    inertia: Any = (0, 0, 0)
    omega: tuple[Any, ...] = (0, 0, 0)
    force: tuple[Any, ...] = (0, 0, 0)
    torque: tuple[Any, ...] = (0, 0, 0)
    turning: tuple[Any, ...] | None = None
    title: str = "body"

    def __post_init__(self) -> None:
        if not isinstance(self.title, str):
            raise DefinitionError(f"the title of a body is '{quote(self.title)}'; give a text")
        place = f"of the body '{quote(self.title)}'"
        object.__setattr__(self, "mass", expression(self.mass, f"the mass {place}"))
        object.__setattr__(self, "inertia", inertia_tensor(self.inertia))
        if self.turning is None:
            object.__setattr__(self, "turning", self.omega)
        for name in ("velocity", "omega", "force", "torque", "turning"):
            parts = several(getattr(self, name), f"the {name} {place}", "expression")
            if len(parts) != 3:
                raise DefinitionError(f"the {name} {place} has {len(parts)} components; give three")
            read = tuple(expression(e, f"the {name} {place}") for e in parts)
            object.__setattr__(self, name, read)
        if any(self.torque) and not any(self.omega):
            raise DefinitionError(
                f"the torque {place} turns nothing, for its omega is 0; give the omega of the "
                "body, or leave the torque out"
            )

    @property
    def expressions(self) -> tuple[sp.Expr, ...]:
        """All that is declared of it."""
        vectors = (self.velocity, self.omega, self.force, self.torque, self.turning or ())
        return (self.mass, *self.inertia, *(e for vector in vectors for e in vector))


def inertia_tensor(inertia: Any) -> sp.ImmutableMatrix:
    """The inertia tensor out of three principal moments, nested rows or a matrix."""
    if not isinstance(inertia, sp.MatrixBase):
        rows = list(inertia) if isinstance(inertia, Iterable) else []
        square = all(isinstance(row, (list, tuple)) for row in rows)
        place = "an entry of the inertia"
        try:
            if square:
                inertia = sp.Matrix([[expression(e, place) for e in row] for row in rows])
            else:
                inertia = sp.diag(*[expression(entry, place) for entry in rows])
        except ValueError:
            raise DefinitionError("the rows of the inertia matrix differ in length") from None
    if inertia.shape != (3, 3):
        raise DefinitionError("inertia takes three principal moments, or a 3 x 3 matrix")
    if inertia != inertia.T:
        raise DefinitionError("the inertia matrix is not symmetric; give I_ij = I_ji")
    return sp.ImmutableMatrix(inertia)
