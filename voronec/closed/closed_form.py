"""One motion in closed form: a value that knows the state at any time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from voronec.algebra.arguments import COUNT, FLAG, require
from voronec.algebra.symbols import plain_name
from voronec.algebra.typeset import html_table
from voronec.closed.balls import enclose_state
from voronec.closed.grid import sample_coordinates
from voronec.closed.inverted_motion import InvertedMotion, Turn, turns_of
from voronec.closed.problem import exact_instant
from voronec.declaration.reading import several
from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from voronec.closed.classes.trace_classes import TraceClass

__all__ = ["ClosedForm"]


@dataclass(frozen=True, eq=False, repr=False)
class ClosedForm(InvertedMotion):
    """A motion in closed form, from ``voronec.closed_form``.

    ``at`` and ``modulo`` give doubles on a grid of times, ``enclose`` balls of any precision at
    one time; the cost of both does not depend on the time.  The time counts from the start.
    """

    def __repr__(self) -> str:
        return f"ClosedForm({self.system.name!r}, period {self.period:.6g}, {self.kind})"

    def _repr_html_(self) -> str:
        """For notebooks: the constants, and what kind of motion it is."""
        rows = [(name, f"{value:.10g}") for name, value in self.constants.items()]
        low, high = self.ends
        rows.append((plain_name(self.quadratures.x), f"between {low:.10g} and {high:.10g}"))
        rows += [(f"trace {where}", f"class {c.label}") for where, c in self.classes.items()]
        return html_table(repr(self), rows)

    def __copy__(self) -> ClosedForm:
        return self  # nothing of it can change

    def __deepcopy__(self, _: Any) -> ClosedForm:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        """What was inverted is inverted again where it arrives."""
        return ClosedForm, (self.problem,)

    # -- what there is to know -------------------------------------------------------------

    @cached_property
    def turns(self) -> Mapping[str, Turn]:
        """What each angle grows by in a period, and the fraction of a whole turn that this is."""
        return MappingProxyType(turns_of(self))

    @cached_property
    def classes(self) -> Mapping[str, TraceClass]:
        """The class of the trace on each sphere, by its title."""
        from voronec.closed.classes.trace_classes import classify

        return MappingProxyType(classify(self))

    # -- the motion ------------------------------------------------------------------------

    def at(self, times: Any, names: Sequence[Any] = ()) -> dict[str, np.ndarray]:
        """Coordinates and velocities at times since the start, arrays of doubles by name.

        Angles are continuous from the start, whatever the other times are.  ``EngineLimit`` names
        the instant at which a pole of coordinates in space is passed: beyond it an angle has no
        number of turns.
        """
        return sample_coordinates(self, times, self._names(names), whole=True)

    def modulo(self, times: Any, names: Sequence[Any] = ()) -> dict[str, np.ndarray]:
        """The same with angles in (-pi, pi], as accurate however late."""
        return sample_coordinates(self, times, self._names(names), whole=False)

    def enclose(self, t: Any, digits: int = 50, whole: bool = True) -> dict[str, Any]:
        """Coordinates and velocities at one time (an int, a double, a Fraction, a decimal as text,
        a ball), as flint's balls with radii below 10^-digits that contain the truth.

        Angles are continuous from the start.  Raises ``EngineLimit`` where so many digits cannot be
        had, and where an angle has no number of turns.
        """
        require("enclose", "digits", digits, COUNT)
        require("enclose", "whole", whole, FLAG)
        return enclose_state(self, exact_instant(t), digits, whole)

    def _names(self, names: Sequence[Any]) -> tuple[str, ...]:
        known = [plain_name(q) for q in (*self.system.coordinates, *self.system.velocities)]
        given = several(names, "names", "name")
        asked = [n if isinstance(n, str) else plain_name(n) for n in given]
        asked = asked or known
        for name in asked:
            if name not in known:
                raise DefinitionError(
                    f"the closed form gives {', '.join(known)}; '{name}' is none of these"
                )
        return tuple(asked)
