"""Charts: the same motion in other coordinates, where those of a system are singular.

Declarations only; ``voronec check`` proves them, and a run changes to them near a singularity.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import sympy as sp

from voronec.algebra.arguments import takes_fields
from voronec.algebra.symbols import plain_name, velocity
from voronec.declaration.derivatives import derivative
from voronec.declaration.reading import expression, fixed_mapping, quote, several
from voronec.errors import DefinitionError

CHART_PARTS = ("lagrangian", "constraints", "forces", "frame", "relations")
"""What may read differently in another chart."""


class Variables(Protocol):
    """Whatever has coordinates and velocities, as systems do."""

    @property
    def coordinates(self) -> tuple[sp.Expr, ...]:
        """The symbols of the coordinates, base and fibre."""

    @property
    def velocities(self) -> tuple[sp.Expr, ...]:
        """The symbols of the velocities of the equations."""


@takes_fields
@dataclass(frozen=True)
class Chart:
    """Other coordinates of a system; they bear the names of its own, and mean something else.

    state
        variable -> its value in the chart, as a function of the system's coordinates, velocities
        and parameters.  A variable that is not named has the same value in both; the velocity of
        a coordinate follows that of the coordinate.  Write angles as ``atan2(y, x)``, which is
        accurate everywhere.
    singular
        a function of the coordinates that vanishes where those of the system are singular, and
        whose factors are positive elsewhere, in the range of the coordinates: sin(u) sin(u1).
    changes
        what the system declares differently in the chart, by name: ``lagrangian``,
        ``constraints``, ``forces``, ``frame``, ``relations``.  Nothing, for a symmetry of the
        system.
    back
        the inverse of ``state``, each variable of the system as a function of those of the chart;
        by default ``state`` itself, a map that is its own inverse.
    singular_there
        the same as ``singular`` for the chart; by default the same function of its coordinates.
    double_cover
        other values of the system's variables for the same state, a map for each way in which they
        cover states twice, as Euler's angles do: {phi: phi + pi, theta: -theta, psi: psi - pi}.
    near
        values of coordinates in the chart, where the system's own are singular: there the
        constraints, solved for the chart, should be defined.
    """

    state: Mapping[Any, Any]
    singular: Any
    changes: Mapping[str, Any] = field(default_factory=dict)
    back: Mapping[Any, Any] = field(default_factory=dict)
    singular_there: Any = None
    double_cover: Sequence[Mapping[Any, Any]] = ()
    near: Mapping[Any, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        def store(name: str, value: Any) -> None:
            object.__setattr__(self, name, value)

        for part in ("state", "back", "near"):
            store(part, _named_values(getattr(self, part), part))
        double_cover = several(self.double_cover, "double_cover", "{variable: expression}", Mapping)
        store("double_cover", tuple(_named_values(sheet, "a sheet") for sheet in double_cover))
        if not self.state:
            raise DefinitionError("a chart maps nothing; write state={variable: expression}")
        if not self.back:
            store("back", self.state)
        store("singular", expression(self.singular, "singular"))
        there = self.singular if self.singular_there is None else self.singular_there
        store("singular_there", expression(there, "singular_there"))
        changes = fixed_mapping(self.changes, "changes of a chart", "'lagrangian': expression")
        store("changes", changes)
        for name in changes:
            if name not in CHART_PARTS:
                raise DefinitionError(
                    f"a chart changes '{quote(name)}'; it may change {', '.join(CHART_PARTS)}"
                )

    def values(self, system: Variables, part: str = "state") -> dict[sp.Expr, sp.Expr]:
        """Every variable of the chart as a function of the system's; with ``back`` the other way
        round."""
        return self._values(system, getattr(self, part))

    def sheet_values(self, system: Variables) -> list[dict[sp.Expr, sp.Expr]]:
        """Every variable of the system as a function of its variables, on each other sheet."""
        return [self._values(system, sheet) for sheet in self.double_cover]

    @staticmethod
    def _values(system: Variables, given: Mapping[Any, Any]) -> dict[sp.Expr, sp.Expr]:
        dots = {velocity(q): q for q in system.coordinates}
        images = {}
        for x in (*system.coordinates, *system.velocities):
            name = plain_name(x)
            if name not in given and plain_name(dots.get(x, x)) in given:
                moved = given[plain_name(dots[x])]
                pairs = [(q, dot) for dot, q in dots.items()]
                images[x] = sp.Add(*[derivative(moved, q) * dot for q, dot in pairs])
            else:
                images[x] = given.get(name, x)
        return images


def _named_values(values: Any, part: str) -> Mapping[str, sp.Expr]:
    given = fixed_mapping(values, f"{part} of a chart", "variable: expression")
    read = {plain_name(k): expression(e, f"'{quote(k)}'") for k, e in given.items()}
    return fixed_mapping(read, part, "variable: expression")
