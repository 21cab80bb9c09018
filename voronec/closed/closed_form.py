"""One motion in closed form: a value that knows the state at any time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy as sp

from voronec.algebra.arguments import COUNT, FLAG, require
from voronec.algebra.precision import GENERIC
from voronec.algebra.symbols import plain_name
from voronec.algebra.text import sympified
from voronec.algebra.typeset import html_table
from voronec.closed.arithmetic import ball, precise
from voronec.closed.balls import enclosed, polynomials
from voronec.closed.clock import Clock
from voronec.closed.compiled_motion import ascending
from voronec.closed.expressions import reading
from voronec.closed.grid import sampled
from voronec.closed.planar_rotation import velocities
from voronec.closed.problem import InversionProblem
from voronec.closed.request import exact_instant
from voronec.closed.rotation_numbers import Turn, turns_of
from voronec.closed.rounded_constants import RoundedConstants
from voronec.closed.space import Attitude
from voronec.closed.winding import Winding
from voronec.declaration.quadratures import Quadratures
from voronec.declaration.reading import several
from voronec.declaration.system import System
from voronec.errors import DefinitionError, EngineLimit

if TYPE_CHECKING:
    from voronec.closed.classes.trace_classes import TraceClass

__all__ = ["ClosedForm"]


@dataclass(frozen=True, eq=False, repr=False)
class ClosedForm:
    """A motion in closed form, from ``voronec.closed_form``.

    ``at`` and ``modulo`` give doubles on a grid of times, ``enclose`` balls of any precision at
    one time; the cost of both does not depend on the time.  The time counts from the start.
    """

    problem: InversionProblem

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

    @property
    def system(self) -> System:
        """The system that moves."""
        return self.problem.prepared.system

    @property
    def quadratures(self) -> Quadratures:
        """The declaration of the motion."""
        return self.problem.prepared.motion

    @property
    def rests(self) -> bool:
        """Whether the variable stays at a multiple root: a regular precession."""
        return self.problem.rests

    @cached_property
    def solution(self) -> Any:
        """The inverted elliptic integral, ``voronec.elliptic.Solution``."""
        from voronec.elliptic import invert

        return invert(self.problem.source)

    @cached_property
    def clock(self) -> Clock:
        """The time, where the quartic is in another one."""
        return Clock(self)

    @cached_property
    def attitude(self) -> Attitude | None:
        """How the motion lies in space; None where the system declares no space."""
        space = self.quadratures.space
        return None if space is None else Attitude(self.problem, space)

    @cached_property
    def winding(self) -> Winding:
        """The whole turns of coordinates in space, where the constant vector is not upright."""
        return Winding(self)

    # -- what there is to know -------------------------------------------------------------

    @cached_property
    def constants(self) -> Mapping[str, float]:
        """The constants of the motion by name."""
        level = self.problem.level(GENERIC)[len(self.system.parameters) :]
        names = map(plain_name, self.quadratures.constants)
        return MappingProxyType(dict(zip(names, map(float, level), strict=True)))

    @property
    def kind(self) -> str:
        """What the functions are: ``trigonometric``, ``hyperbolic``, ``rational``,
        ``exponential``, or ``rest``."""
        return "rest" if self.rests else str(self.solution.constants(GENERIC).kind)

    @property
    def period(self) -> float:
        """The time from one turning point of the variable to the next alike; infinite where it
        tends to a limit, and where it rests."""
        if self.rests:
            return float("inf")
        if self.quadratures.clock == 1:
            return float(self.solution.period)
        advances = self.solution.constants(GENERIC).advances
        return float("inf") if advances is None else float(advances[self.clock.number])

    @property
    def ends(self) -> tuple[float, float]:
        """The least and the greatest value of the variable, or their limits."""
        if self.rests:
            x = float(self.problem.place(GENERIC))
            return x, x
        low, high = self.solution.ends
        return low, high

    @property
    def roots(self) -> tuple[complex, ...]:
        """The finite roots of the quartic, each as often as it is repeated; none where it vanishes
        for every x."""
        if self._flat:
            return ()
        return tuple(self.solution.roots)

    @property
    def invariants(self) -> tuple[float, float, float]:
        """Weierstrass' g2 and g3, and the discriminant g2^3 - 27 g3^2."""
        if self._flat:
            return 0.0, 0.0, 0.0
        g2, g3, discriminant = self.solution.invariants
        return g2, g3, discriminant

    @property
    def arguments(self) -> Mapping[str, complex | None]:
        """The complex times at which the variable reaches each pole, from the turning point at
        one end; by the place of the pole.  None where it adds no angle."""
        names = [str(c) for c, _ in self.problem.prepared.poles]
        if self.rests:
            return MappingProxyType(dict.fromkeys(names))
        return MappingProxyType(dict(zip(names, self.solution.arguments, strict=True)))

    @cached_property
    def _flat(self) -> bool:
        return self.rests and not self.problem.source(GENERIC).factors

    @cached_property
    def turns(self) -> Mapping[str, Turn]:
        """What each angle grows by in a period, and the fraction of a whole turn that this is."""
        return MappingProxyType(turns_of(self))

    @cached_property
    def classes(self) -> Mapping[str, TraceClass]:
        """The class of the trace on each sphere, by its title."""
        from voronec.closed.classes.trace_classes import classify

        return MappingProxyType(classify(self))

    # -- decisions -------------------------------------------------------------------------

    def exact(self, expr: Any) -> Callable[[int], Any]:
        """An expression in constants and parameters at any number of bits, as a ball."""
        return self.problem.exact(sympified(expr))

    def sign(self, expr: Any) -> int:
        """-1, 0 or 1, decided exactly; ``EngineLimit`` where no proof is found."""
        return self.problem.sign(expr)

    def polynomial(self, expr: Any) -> tuple[sp.Expr, ...]:
        """The coefficients of a polynomial in the variable, ascending, as expressions."""
        degree = sp.degree(sympified(expr), self.quadratures.x) if expr else 0
        return ascending(expr, self.quadratures.x, int(max(degree, 0)))

    # -- the motion ------------------------------------------------------------------------

    def at(self, times: Any, names: Sequence[Any] = ()) -> dict[str, np.ndarray]:
        """Coordinates and velocities at times since the start, arrays of doubles by name.

        Angles are continuous from the start, whatever the other times are.  ``EngineLimit`` names
        the instant at which a pole of coordinates in space is passed: beyond it an angle has no
        number of turns.
        """
        return sampled(self, times, self._names(names), whole=True)

    def modulo(self, times: Any, names: Sequence[Any] = ()) -> dict[str, np.ndarray]:
        """The same with angles in (-pi, pi], as accurate however late."""
        return sampled(self, times, self._names(names), whole=False)

    def enclose(self, t: Any, digits: int = 50, whole: bool = True) -> dict[str, Any]:
        """Coordinates and velocities at one time (an int, a double, a Fraction, a decimal as text,
        a ball), as flint's balls with radii below 10^-digits that contain the truth.

        Angles are continuous from the start.  Raises ``EngineLimit`` where so many digits cannot be
        had, and where an angle has no number of turns.
        """
        require("enclose", "digits", digits, COUNT)
        require("enclose", "whole", whole, FLAG)
        return enclosed(self, exact_instant(t), digits, whole)

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

    # -- parts -----------------------------------------------------------------------------

    def begin(self, bits: int) -> list[Any]:
        """The angles at the start, in the order of the integrals; of the motion turned upright."""
        problem = self.problem
        given = dict(zip(problem.prepared.inputs, problem.given(bits), strict=True))
        if self.attitude is not None and not self.attitude.upright and not self.rests:
            own = self.attitude
            given |= dict(zip(own.coordinates, own.begin(bits), strict=True))
        return [given[q] for q in self.quadratures.angles]

    def branch(self, i: int) -> tuple[int, int]:
        """Of the colatitude of trace i: (sign, turns), colatitude = sign (0..pi) + 2 pi turns."""
        trace = self.quadratures.traces[i].colatitude
        turned = self.attitude is not None and not self.attitude.upright
        if turned and self.attitude is not None and trace in self.attitude.coordinates:
            return 1, 0
        with precise(GENERIC):
            halves = self.problem.exact(trace)(GENERIC) / ball(1).pi()
            whole = int(np.floor(float(halves)))
        return (1, whole // 2) if whole % 2 == 0 else (-1, (whole + 1) // 2)

    def steady(self, bits: int) -> list[Any]:
        """The velocities of all coordinates at rest of the variable; of a motion that is turned in
        space, without those of its coordinates in space.  Constant, but for a place on a plane
        that goes round (``wheels``)."""
        own, coordinates = self.attitude, self.system.coordinates
        if own is not None:
            rates = own.rates(bits)
            return [ball(0) if q in own.coordinates and not own.upright else r
                    for q, r in zip(coordinates, rates, strict=True)]  # fmt: skip
        if self.wheels:
            return velocities(self.problem, bits)
        return [self.problem.exact(e)(bits) for e in self._resting]

    def resting(self, moved: Mapping[Any, Any], bits: int) -> list[Any]:
        """Values of the symbols of a ``Reading`` where the variable rests, with coordinates that
        have moved."""
        own, x = self.problem.prepared, self.problem.place(bits)
        read, values = reading(own), [*self.problem.level(bits), x]
        rates = dict(zip(self.system.coordinates, self.steady(bits), strict=True))
        with precise(bits):
            for trace in self.quadratures.traces:
                colatitude = self.exact(trace.colatitude)(bits)
                values += [colatitude.sin(), colatitude.cos(), ball(0)]
            values += [rates[q] for q in self.quadratures.angles]
            values += [moved[q] for q in read.coordinates]
            return values + polynomials(self, x, bits)

    @cached_property
    def wheels(self) -> bool:
        """Whether the variable rests and the vector in the plane vanishes: nothing singles out a
        direction then, and the place goes round evenly."""
        plane = self.quadratures.plane
        if plane is None or not self.rests:
            return False
        return all(self.sign(e) == 0 for e in plane.direction)

    @cached_property
    def _resting(self) -> list[Any]:
        motion, rates = self.quadratures, self.problem.prepared.rates
        found = dict(zip(motion.angles, rates, strict=False))
        if motion.plane is not None:
            a, b = (e / motion.plane.length for e in motion.plane.direction)
            along, across = rates[len(motion.angles) : len(motion.angles) + 2]
            x, y = motion.plane.place
            found |= {x: a * along - b * across, y: b * along + a * across}
        meaning = {motion.x: motion.meaning}
        return [
            (found.get(q, sp.Integer(0)) / motion.clock).xreplace(meaning)
            for q in self.system.coordinates
        ]

    def direction(self, bits: int) -> tuple[Any, Any]:
        """The unit vector along which a place on a plane is counted."""
        plane = self.quadratures.plane
        assert plane is not None
        if self.sign(plane.length) == 0:
            raise EngineLimit(
                f"system '{self.system.name}': the vector in the plane vanishes, so that no "
                "direction tells the place; use another method"
            )
        with precise(bits):
            size = self.exact(plane.length)(bits)
            first, second = (self.exact(e)(bits) / size for e in plane.direction)
            return first, second

    @cached_property
    def ready(self) -> RoundedConstants:
        """The numbers of an evaluation in doubles."""
        return RoundedConstants(self)
