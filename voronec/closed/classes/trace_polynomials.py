"""The traces of a declared motion as polynomials in its variable x.

    (dx/dtau)^2 = f(x),   cosine = offset + slope x,   d(longitude)/dtau = phi(x)/(1 - cosine^2)

Everything about the class of a trace is in the roots of f and of phi.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import sympy as sp

from voronec.algebra.door import Door
from voronec.algebra.normal import canonical
from voronec.algebra.symbols import plain_name
from voronec.algebra.text import as_expression
from voronec.closed.compiled_motion import motion_of, prepare
from voronec.closed.fractions import ascending_coefficients
from voronec.declaration.quadratures import Quadratures, Trace
from voronec.declaration.system import System
from voronec.errors import DefinitionError

__all__ = ["Curve", "DeclaredTraces", "declared_traces", "title"]

DEGREE = 4


@dataclass(frozen=True)
class Curve:
    """One trace: coefficients, ascending, functions of a level (constants and parameters).

    ``phi`` is the longitude's rate times 1 - cosine^2; ``above`` the same without a denominator,
    which has no roots and is all that counts where only roots do; ``cosine`` is (offset, slope).
    """

    trace: Trace
    phi: tuple[Any, ...]
    above: tuple[Any, ...]
    cosine: tuple[Any, Any]

    @property
    def title(self) -> str:
        """What the trace is called."""
        return title(self.trace)

    def above_at(self, x: Any) -> Any:
        """``above`` at a place: 0 where phi vanishes."""
        return sum((c * x**i for i, c in enumerate(self.above)), sp.Integer(0))


@dataclass(frozen=True, eq=False)
class DeclaredTraces:
    """A system's motion, read for its traces.

    inputs
        symbols of a start: coordinates, velocities, parameters.
    level
        symbols of a level: parameters, constants.
    starting
        the constants, then x and dx/dtau, as functions of the inputs.
    quartic
        coefficients of f, ascending.
    """

    system: System
    inputs: tuple[Any, ...]
    level: tuple[Any, ...]
    starting: tuple[Any, ...]
    quartic: tuple[Any, ...]
    curves: tuple[Curve, ...]

    @property
    def motion(self) -> Quadratures:
        """The declaration."""
        return motion_of(self.system)

    @property
    def place(self) -> Any:
        """The variable as a function of a start."""
        return self.starting[-2]

    @property
    def rate(self) -> Any:
        """Its rate as a function of a start."""
        return self.starting[-1]

    def curve(self, name: str | None) -> Curve:
        """The trace of a title, or of a coordinate; the first unless told."""
        from voronec.errors import did_you_mean

        if name is None:
            return self.curves[0]
        for curve in self.curves:
            trace = curve.trace
            if name in (curve.title, plain_name(trace.colatitude), plain_name(trace.longitude)):
                return curve
        known = [c.title for c in self.curves]
        raise DefinitionError(
            f"system '{self.system.name}' has no trace '{name}'{did_you_mean(name, known)}"
        )

    def at_start(self, value: Any) -> Any:
        """A function of a level and of x, as a function of the start."""
        meaning = dict(zip(self.motion.constants, self.starting[:-2], strict=True))
        return as_expression(value).xreplace({**meaning, self.motion.x: self.place})


def title(trace: Trace) -> str:
    """What a trace is called: its title in the system's drawing, else by its coordinates."""
    return trace.title or f"({plain_name(trace.colatitude)}, {plain_name(trace.longitude)})"


def declared_traces(system: System) -> DeclaredTraces:
    """The traces of a system; ``DefinitionError`` where it declares no motion, or no trace."""
    motion = motion_of(system)
    return motion.memo.once("traces", lambda: _read(system, motion))


def _read(system: System, motion: Quadratures) -> DeclaredTraces:
    if not motion.traces:
        raise DefinitionError(
            f"system '{system.name}': its motion declares no traces; write "
            "traces=(Trace(u, v, cosine),)"
        )
    own = tuple(p.symbol for p in system.parameters)
    inputs = (*system.coordinates, *system.velocities, *own)
    starting = (*motion.constants.values(), motion.meaning, prepare(system, {}).rate)
    quartic = ascending_coefficients(motion.quartic, motion.x, DEGREE)
    curves = tuple(_curve(motion, trace) for trace in motion.traces)
    return DeclaredTraces(system, inputs, (*own, *motion.constants), starting, quartic, curves)


def _curve(motion: Quadratures, trace: Trace) -> Curve:
    x = motion.x
    if trace.longitude not in motion.integrals:
        raise DefinitionError(
            f"the longitude '{plain_name(trace.longitude)}' of a trace has no rate; "
            "add it to the integrals of the motion"
        )
    door = Door()
    raw = motion.integrals[trace.longitude] * (1 - trace.cosine**2)
    value = door.outward(canonical([door.inward(raw)], ())[0])
    above, below = sp.fraction(sp.together(value))
    if below.has(x):
        raise DefinitionError(
            f"the rate of '{plain_name(trace.longitude)}' is no polynomial over 1 - cosine^2 of "
            "its trace; such a trace is not classified"
        )
    rows = ascending_coefficients(above, x, DEGREE)
    while len(rows) > 1 and rows[-1] == 0:
        rows = rows[:-1]
    offset, slope = ascending_coefficients(trace.cosine, x, 1)
    return Curve(trace, tuple(c / below for c in rows), rows, (offset, slope))
