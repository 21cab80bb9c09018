"""The class of a trace: what kind of curve a contact draws on a sphere, decided exactly.

x runs between two neighbouring roots of f = (dx/dt)^2, so that the contact runs between two
parallels of the sphere; the *upper* one has the larger cosine.  The longitude's rate is
phi(x)/(1 - cosine^2): where phi vanishes, the curve touches a meridian
[DragovicGajicJovanovic2020, Section 4.5].  The letters are those of [Demchenko1924]; his figures
were not at hand, so that the digits after C, D and E are fixed here.

==========  ===============================================================================
``A``       phi has no root strictly between the ends: the longitude only grows or only falls
``B``       one simple root: it grows along one parallel and falls along the other (loops)
``C1, C2``  two: it grows along both parallels and falls between them, or the other way round;
            over a period it has grown (C1) or fallen (C2); plain ``C`` where the drift is smaller
            than 2^-200
``A|C``     a double root, the boundary of A and C: the curve touches a meridian and goes on
``D1``      phi vanishes at the end on the upper parallel: the contact stops there, in a cusp
``D2``      the same on the lower parallel; ``D3`` on both
``E1``      the curve passes through the pole at cosine = 1; ``E2`` at -1; ``E1+E2`` through both
==========  ===============================================================================

Combinations are joined by ``+``: ``E1+D2``; with D or E the roots strictly between the ends are
added as ``+B``, ``+A|C`` or ``+C``: ``D1+B`` is a cusp above and a loop below.  At a pole phi
vanishes by itself; that root counts for nothing else.

Limits.  ``parallel``: x rests, or the cosine does not depend on it.  ``point``: the contact rests
on the sphere.  ``asymptotic to the upper parallel`` (``lower parallel``, ``both parallels``,
``upper pole``, ``lower pole``, ``a point of the upper parallel``): the end is a multiple root of f,
never reached; what the rest of the curve is follows in brackets where it is not A.

Where the sphere is that of a vector constant in space, the classes are those about its direction.

Where the roots of phi lie among the ends is decided exactly: balls of growing precision tell
numbers apart.  Where they do not, algebra says whether the numbers are equal: whether f and phi
have a root in common is read off the remainder of f by phi, and whether an end is a pole of the
sphere off the value of f there.

The traces of a declared motion are polynomials in its variable x,

    (dx/dtau)^2 = f(x),   cosine = offset + slope x,   d(longitude)/dtau = phi(x)/(1 - cosine^2),

and everything about the class of a trace is in the roots of f and of phi.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache, cached_property
from typing import Any

import sympy as sp

from voronec.algebra.memo import Memo
from voronec.algebra.normal import canonical
from voronec.algebra.precision import FIRST, GENERIC, SHARP
from voronec.algebra.symbols import plain_name
from voronec.algebra.sympy_bridge import SymPyBridge
from voronec.algebra.text import as_expression
from voronec.closed.arithmetic import precise
from voronec.closed.compiled_motion import motion_of, prepare
from voronec.closed.fractions import ascending_coefficients
from voronec.closed.inverted_motion import DIGITS, InvertedMotion, turns_of
from voronec.closed.problem import InversionProblem
from voronec.declaration.quadratures import Quadratures, Trace
from voronec.declaration.system import System
from voronec.errors import DefinitionError, EngineLimit

LABELS = ("A", "B", "C1", "C2", "D1", "D2", "D3", "E1", "E2")
"""The classes of the paper's figures, 4 to 12 in this order."""
REVERSALS = ("A", "B", "C")
BITS = (FIRST, GENERIC, SHARP)
"""Bits at which the sign of a drift is looked for."""
SHARPNESS = 2.0**-53
"""A double's last digit: so sharp a ball tells as much as any double."""


@dataclass(frozen=True)
class TraceClass:
    """The class of one trace.

    label
        as the head of this module says.
    reversals
        cosines at which the longitude turns back, ascending; touchings are none.
    lower, upper
        cosines of the two parallels.
    period
        infinite where the motion has none.
    drift
        what the longitude grows by in a period; None where there is no period.
    fraction
        what drift/(2 pi) agrees with to 50 digits, where that is rational: likely the curve closes
        after ``fraction.denominator`` periods; no proof.
    note
        a sentence on what is special.
    """

    label: str
    reversals: tuple[float, ...] = ()
    lower: float = float("nan")
    upper: float = float("nan")
    period: float = float("inf")
    drift: float | None = None
    fraction: Fraction | None = None
    note: str = ""

    def __str__(self) -> str:
        return self.label


def classify(closed: InvertedMotion) -> dict[str, TraceClass]:
    """The class of every trace of a motion, by the trace's title.

    Signs and equalities are proved; ``EngineLimit`` where a number cannot be told from zero.
    """
    known = declared_traces(closed.system)
    counted = {c.title: (c, tally(closed.problem, c)) for c in known.curves}
    classes: dict[str, TraceClass] = {}
    for name, (curve, counts) in counted.items():
        if counts is not None:
            classes[name] = _classify(closed, curve, counts)
    for name, (_, counts) in counted.items():
        if counts is None:
            # without an axis there is no colatitude; of two traces of one contact both rest or none
            resting = any(c.label == "point" for c in classes.values())
            note = "its axis has no direction: the vector that gives it vanishes"
            classes[name] = TraceClass("point" if resting else "parallel", note=note)
    return {name: classes[name] for name in counted}


def _classify(closed: InvertedMotion, curve: Curve, counts: Tally) -> TraceClass:
    lower, upper = sorted(counts.ends)
    turns = sorted(cosine for cosine, times in counts.inner if times % 2)
    name = plain_name(curve.trace.longitude)
    turn = None if counts.at_rest else turns_of(closed).get(name)
    return TraceClass(
        label=label_trace(closed, curve, counts),
        reversals=tuple(turns),
        lower=lower,
        upper=upper,
        period=closed.period,
        drift=None if turn is None else turn.advance,
        fraction=None if turn is None else turn.fraction,
        note=_note(turn),
    )


def _note(turn: Any) -> str:
    if turn is None or turn.fraction is None:
        return ""
    count = turn.fraction.denominator
    word = "period" if count == 1 else "periods"
    turns = f"{count} {word}, {turn.fraction} of a turn each"
    return f"likely a closed curve: {turns} to {DIGITS} digits (no proof)"


def label_trace(closed: InvertedMotion, curve: Curve, counts: Tally) -> str:
    """The label of a trace; the drift is looked at where it matters."""
    label = label_of(counts, 0)
    if "C" in label and not counts.at_rest:
        return label_of(counts, _drift_sign(closed, curve))
    return label


def _drift_sign(closed: InvertedMotion, curve: Curve) -> int:
    """The sign of what the longitude grows by in a period; 0 where it cannot be told from zero,
    and where there is no period."""
    index = closed.quadratures.angles.index(curve.trace.longitude)
    for bits in BITS:
        advances = closed.solution.constants(bits).advances
        if advances is None:
            return 0
        if advances[index] > 0:
            return 1
        if advances[index] < 0:
            return -1
    return 0


def label_of(counts: Tally, drift: int) -> str:
    """The label of a trace, from what is counted and the sign of the drift."""
    if counts.at_rest or counts.flat:
        return "point" if counts.still else "parallel"
    order = (0, 1) if counts.tilt > 0 else (1, 0)
    limits, met, poles = (
        tuple(pair[i] for i in order) for pair in (counts.limits, counts.contacts, counts.poles)
    )
    usual = _usual(counts, limits, met, poles, drift)
    if not any(limits):
        return usual
    towards = _towards(limits, met, poles)
    return f"asymptotic to {towards}" + (f" ({usual})" if usual != "A" else "")


def _usual(counts: Tally, limits: Any, met: Any, poles: Any, drift: int) -> str:
    """The label by poles, cusps and reversals."""
    through = [not limit and pole != 0 for limit, pole in zip(limits, poles, strict=True)]
    cusps = [
        hit and not limit and pole == 0 for hit, limit, pole in zip(met, limits, poles, strict=True)
    ]
    parts = [name for name, at in (("E1", through[1]), ("E2", through[0])) if at]
    if any(cusps):
        parts.append("D3" if all(cusps) else "D1" if cusps[1] else "D2")
    loops = _loops(counts.inner, drift)
    return "+".join([*parts, *([loops] if loops != "A" or not parts else [])])


def _loops(inner: Any, drift: int) -> str:
    simple = sum(times % 2 for _, times in inner)
    if simple == 0 and inner:
        return "A|C"
    if simple < len(REVERSALS):
        letter = REVERSALS[simple]
        return letter + {1: "1", -1: "2", 0: ""}[drift] if letter == "C" else letter
    return f"{simple} reversals"


def _towards(limits: Any, met: Any, poles: Any) -> str:
    if all(limits):
        return "both parallels"
    end = 1 if limits[1] else 0
    name = ("lower", "upper")[end]
    if poles[end]:
        return f"the {name} pole"
    return f"a point of the {name} parallel" if met[end] else f"the {name} parallel"


@dataclass(frozen=True)
class Tally:
    """What is counted of one trace; pairs are (lower end of x, upper end of x).

    at_rest, flat, still
        x stays where it is; the cosine does not depend on x; phi vanishes, at x where that is at
        rest, identically otherwise.
    inner
        (cosine, multiplicity) of the roots of phi strictly between the ends.
    ends
        cosines at the ends.
    contacts
        whether phi vanishes at the end.
    poles
        the cosine there, 1 or -1; 0 where it is neither.
    limits
        whether the end is a multiple root of f.
    tilt
        sign of the cosine's slope.
    """

    at_rest: bool = False
    flat: bool = False
    still: bool = False
    inner: tuple[tuple[float, int], ...] = ()
    ends: tuple[float, float] = (float("nan"), float("nan"))
    contacts: tuple[bool, bool] = (False, False)
    poles: tuple[int, int] = (0, 0)
    limits: tuple[bool, bool] = (False, False)
    tilt: int = 1


def tally(problem: InversionProblem, curve: Curve) -> Tally | None:
    """The counts of a trace; None where its cosine has no value on this level."""
    for c in curve.cosine:
        if not problem.exact(c)(FIRST).is_finite() and problem.sign(sp.denom(sp.together(c))) == 0:
            return None
    search = _RootSearch(problem, curve)
    if problem.rests:
        return search.at_rest()
    return search.between()


@dataclass(frozen=True, eq=False)
class _RootSearch:
    problem: InversionProblem
    curve: Curve

    @cached_property
    def phi(self) -> tuple[Any, ...]:
        """The coefficients up to the last that is not zero."""
        coefficients = list(self.curve.above)
        while coefficients and self.problem.sign(coefficients[-1]) == 0:
            coefficients.pop()
        return tuple(coefficients)

    @cached_property
    def double(self) -> bool:
        """Whether phi, of degree 2, is a square."""
        c, b, a = self.phi
        return self.problem.sign(b**2 - 4 * a * c) == 0

    def at_rest(self) -> Tally:
        """x is a multiple root of f and stays there."""
        from voronec.elliptic.roots import resolve

        motion = self.problem.prepared.motion
        x, (offset, slope) = motion.meaning, self.curve.cosine
        cosine = offset + slope * x
        pole = next((s for s in (1, -1) if self.problem.sign(cosine - s) == 0), 0)
        still = pole != 0 or self.problem.sign(self.curve.above_at(x)) == 0
        end = float(pole) or resolve(lambda bits: _sharp(self._values([cosine], bits)[0]), FIRST)
        return Tally(at_rest=True, still=still, ends=(end, end), poles=(pole, pole),
                     tilt=self.problem.sign(slope) or 1)  # fmt: skip

    def between(self) -> Tally:
        """x runs between two roots of f, or towards them."""
        from voronec.elliptic.roots import ends_of, resolve

        source, slope = self.problem.source, self.curve.cosine[1]
        tilt = self.problem.sign(slope)

        def attempt(bits: int) -> Tally:
            ends = ends_of(source, bits)
            pair = (ends.lower, ends.upper)
            others = [r.value for r in ends.roots if r not in pair and r.real]
            at = self._roots(bits)
            poles = tuple(self._pole(e.value, others, bits) if tilt else 0 for e in pair)
            first, rise = self._values(self.curve.cosine, bits)
            inner, met = [], [False, False]
            for root, times in at:
                where = self._where(root, [e.value for e in pair], others, at, bits)
                if where == "inside":
                    inner.append((_sharp(first + rise * root), times))
                elif where in (0, 1):
                    met[int(where)] = True
            low, high = (
                float(p) or _sharp(first + rise * e.value) for p, e in zip(poles, pair, strict=True)
            )
            return Tally(
                flat=tilt == 0, still=not self.phi, inner=tuple(inner),
                ends=(low, high), contacts=(met[0], met[1]),
                poles=(poles[0], poles[1]), limits=(pair[0].times > 1, pair[1].times > 1),
                tilt=tilt or 1,
            )  # fmt: skip

        return resolve(attempt, FIRST)

    def _values(self, expressions: Sequence[Any], bits: int) -> list[Any]:
        return [self.problem.exact(e)(bits) for e in expressions]

    def _roots(self, bits: int) -> list[tuple[Any, int]]:
        """The real roots of phi, ascending, and their multiplicities."""
        if len(self.phi) < 2:
            return []
        values = self._values(self.phi, bits)
        with precise(bits):
            if len(values) == 2:
                return [(-values[0] / values[1], 1)]
            if len(values) == 3:
                c, b, a = values
                if self.double:
                    return [(-b / (2 * a), 2)]
                if self.problem.sign(self.phi[1] ** 2 - 4 * self.phi[2] * self.phi[0]) < 0:
                    return []
                root = (b * b - 4 * a * c).sqrt()
                pair = [(-b - root) / (2 * a), (-b + root) / (2 * a)]
                return [(r, 1) for r in (pair if a > 0 else pair[::-1])]
            return _isolate_roots(values)

    def _where(
        self, root: Any, ends: list[Any], others: list[Any], all_roots: Any, bits: int
    ) -> Any:
        """``inside``, ``outside``, or the index of the end that the root is."""
        from voronec.elliptic.roots import OpenDecision

        lower, upper = ends
        if root > lower and root < upper:
            return "inside"
        if root < lower or root > upper:
            return "outside"
        index = 0 if root.overlaps(lower) else 1
        alone = not any(root.overlaps(o) for o in (*others, ends[1 - index]))
        if alone and self._is_shared(root, all_roots, bits):
            return index
        raise OpenDecision("a root of phi may be an end of the motion")

    def _is_shared(self, root: Any, all_roots: Any, bits: int) -> bool:
        """Whether a root of phi is surely a root of f, too."""
        if len(self.phi) > 3:
            raise EngineLimit("phi has degree 3 or more; equal roots are decided up to degree 2")
        rest = self.quartic_remainder
        if all(self.problem.sign(e) == 0 for e in rest):
            return True
        if len(rest) == 1 or self.problem.sign(rest[1]) == 0:
            return False
        (p0, p1, p2), (r0, r1) = self.phi, rest
        if self.problem.sign(p2 * r0**2 - p1 * r0 * r1 + p0 * r1**2) != 0:
            return False
        below, above = self._values(rest, bits)
        with precise(bits):
            place = -below / above
            return [place.overlaps(r) for r, _ in all_roots].count(True) == 1 and bool(
                place.overlaps(root)
            )

    @cached_property
    def quartic_remainder(self) -> tuple[Any, ...]:
        """Of f by phi, up to a factor: coefficients as expressions."""
        return remainder(self.problem.prepared.quartic, self.phi)

    def _pole(self, end: Any, others: list[Any], bits: int) -> int:
        """The cosine at an end of the motion, where that is 1 or -1."""
        from voronec.elliptic.roots import OpenDecision

        offset, slope = self.curve.cosine
        x = self.problem.prepared.motion.x
        for side in (1, -1):
            place = (side - offset) / slope
            (value,) = self._values([place], bits)
            if not value.overlaps(end):
                continue
            alone = not any(value.overlaps(o) for o in others)
            at_pole = self.problem.prepared.motion.quartic.xreplace({x: place})
            if alone and self.problem.sign(at_pole) == 0:
                return side
            raise OpenDecision("an end of the motion may be a pole of the sphere")
        return 0


def _sharp(cosine: Any) -> float:
    """A cosine to the last bits of a double, however large what cancels in it."""
    from voronec.elliptic.roots import OpenDecision

    if not cosine.rad() < SHARPNESS:
        raise OpenDecision("a cosine needs more bits")
    return float(cosine)


def remainder(quartic: Sequence[Any], phi: Sequence[Any]) -> tuple[Any, ...]:
    """Coefficients of the remainder of one polynomial by another, up to a factor."""
    names, formulas = _remainder(len(phi) - 1)
    meaning = dict(zip(names, (*quartic, *phi), strict=True))
    return tuple(e.xreplace(meaning) for e in formulas)


@cache
def _remainder(degree: int) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """Symbols of a quartic and of a polynomial of some degree, and the pseudo-remainder."""
    x = sp.Symbol("x")
    above, below = sp.symbols("f0:5"), sp.symbols(f"p0:{degree + 1}")
    rest = sp.prem(
        sum(c * x**i for i, c in enumerate(above)), sum(c * x**i for i, c in enumerate(below)), x
    )
    poly = sp.Poly(rest, x)
    return (*above, *below), tuple(poly.coeff_monomial(x**i) for i in range(degree))


def _isolate_roots(values: list[Any]) -> list[tuple[Any, int]]:
    """The real roots of a polynomial without multiple ones."""
    from flint import acb_poly

    from voronec.elliptic.roots import OpenDecision

    try:
        roots = acb_poly(values).roots()
    except ValueError:
        raise OpenDecision("phi may have a multiple root") from None
    return [(r.real, 1) for r in roots if r.imag.contains(0)]


DEGREE = 4
"""Of the right side f: elliptic functions invert no more."""


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
    initial_values
        the constants, then x and dx/dtau, as functions of the inputs.
    quartic
        coefficients of f, ascending.
    """

    system: System
    inputs: tuple[Any, ...]
    level: tuple[Any, ...]
    initial_values: tuple[Any, ...]
    quartic: tuple[Any, ...]
    curves: tuple[Curve, ...]
    memo: Memo = field(default_factory=Memo, init=False)

    @property
    def motion(self) -> Quadratures:
        """The declaration."""
        return motion_of(self.system)

    @property
    def place(self) -> Any:
        """The variable as a function of a start."""
        return self.initial_values[-2]

    @property
    def rate(self) -> Any:
        """Its rate as a function of a start."""
        return self.initial_values[-1]

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
        meaning = dict(zip(self.motion.constants, self.initial_values[:-2], strict=True))
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
    parameters = tuple(p.symbol for p in system.parameters)
    inputs = (*system.coordinates, *system.velocities, *parameters)
    starting = (*motion.constants.values(), motion.meaning, prepare(system, {}).rate)
    quartic = ascending_coefficients(motion.quartic, motion.x, DEGREE)
    curves = tuple(_curve(motion, trace) for trace in motion.traces)
    return DeclaredTraces(
        system, inputs, (*parameters, *motion.constants), starting, quartic, curves
    )


def _curve(motion: Quadratures, trace: Trace) -> Curve:
    x = motion.x
    if trace.longitude not in motion.integrals:
        raise DefinitionError(
            f"the longitude '{plain_name(trace.longitude)}' of a trace has no rate; "
            "add it to the integrals of the motion"
        )
    bridge = SymPyBridge()
    raw = motion.integrals[trace.longitude] * (1 - trace.cosine**2)
    value = bridge.outward(canonical([bridge.inward(raw)], ())[0])
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
