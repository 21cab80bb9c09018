"""Motion by quadratures proved: what a system declares of its motion follows from its equations.

Integrals of coordinates in space hold on upright data, where the vector of ``Space`` lies along the
third axis: there m = G E^T e_3, which is solved for the velocities.  The variable, the integrals
and the clock have the rates of [Theory, eq. (23)].
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import flint
import symengine as se
import sympy as sp

from voronec.algebra.angles import Angles
from voronec.algebra.elimination import solve_linear
from voronec.algebra.matrices import dot
from voronec.algebra.normal import quotient
from voronec.algebra.points import sample_evaluable
from voronec.algebra.precision import GENERIC
from voronec.algebra.symbols import plain_name
from voronec.algebra.tape import Tape
from voronec.algebra.verdicts import Verdict, witness_at
from voronec.declaration.quadratures import Plane, Quadratures, Space, Trace
from voronec.declaration.reading import quote
from voronec.equations.motions import Motions
from voronec.equations.vector_field import VectorField
from voronec.errors import EngineLimit
from voronec.proof.branch_cuts import across_cuts, not_vacuous
from voronec.proof.claims import Claim
from voronec.proof.decision import all_zero, verdict_of

LENGTH = se.Symbol("length of the vector")

Residuals = list[tuple[str, Any]]


@dataclass(frozen=True)
class QuadratureGround:
    """A declaration, and the field on the coordinates from which it has to follow."""

    field: VectorField
    motion: Quadratures

    @cached_property
    def level(self) -> dict[Any, Any]:
        """The variable and the constants as functions of the state."""
        read, bridge = self.field.read, self.field.bridge
        given = (*self.motion.variable.items(), *self.motion.constants.items())
        return {bridge.inward(symbol): read(meaning) for symbol, meaning in given}

    def on_level(self, expr: sp.Expr) -> Any:
        """A function of the variable, constants and parameters as one of the state."""
        return self.at_level(self.field.bridge.inward(expr))

    def at_level(self, expr: Any) -> Any:
        """A function on the level, of an expression in the engine's symbols."""
        return self.field.express(expr.xreplace(self.level))

    @cached_property
    def pace(self) -> Any:
        """dt/dtau as a function of the state."""
        return self.on_level(self.motion.clock)

    @cached_property
    def run(self) -> Any:
        """dx/dtau as a function of the state."""
        return self.field.derivative(self.field.read(self.motion.meaning)) * self.pace

    def data_for(self, q: sp.Expr) -> Callable[[Any], Any]:
        """How functions of the state are read in a claim about a coordinate: as they are, or, for
        one in space, on upright data."""
        space = self.motion.space
        if space is None or q not in space.coordinates:
            return lambda expr: expr
        return self.upright

    @cached_property
    def angles(self) -> Angles:
        """Where the colatitudes of traces are between their poles, and the vector has a length."""
        sines = [se.sin(self.field.read(t.colatitude)) for t in self.motion.traces]
        return Angles(self.field.relations, (LENGTH, *sines))

    @cached_property
    def _upright(self) -> dict[Any, Any]:
        """The velocities on upright data."""
        space, field = self.motion.space, self.field
        assert space is not None
        vector = [field.read(e) for e in space.vector]
        third = [field.read(e) for e in space.frame.row(2)]
        rest = dict.fromkeys(field.velocities, se.Integer(0))
        matrix = [[m.diff(v) for v in field.velocities] for m in vector]
        right = [[LENGTH * e - m.xreplace(rest)] for e, m in zip(third, vector, strict=True)]
        solution = solve_linear(matrix, right, field.hypotheses)
        if solution.free or len(field.velocities) != len(vector):
            raise EngineLimit("the vector of the space does not determine the velocities")
        values = [row[0] for row in solution.values]
        return dict(zip(field.velocities, values, strict=True))

    def upright(self, expr: Any) -> Any:
        """A function of the state on upright data."""
        return self.angles.resolve(expr.xreplace(self._upright))

    def zero(self, residuals: Residuals) -> Verdict:
        """Whether all residuals vanish."""
        return all_zero(residuals, self.field.hypotheses)


FREE = se.Symbol("variable")
HIGHEST = 2
"""The degree of the polynomial that is left of a rate without its poles."""
SAMPLES = 12
"""At how many states the sign of the clock is looked at."""


def _decide_residues(ground: QuadratureGround, rate: sp.Expr) -> Verdict:
    """A rate has simple poles where they are declared, with residues w, -w or 0, and no others.

    The denominator has as many roots as its degree, all of them declared; and the fraction grows
    no faster than the square of the variable.
    """
    bridge, motion = ground.field.bridge, ground.motion
    fraction = quotient(bridge.inward(rate).xreplace({bridge.inward(motion.x): FREE}))
    top, bottom = map(_degree, fraction)
    if top > bottom + HIGHEST:
        return Verdict("undecided", f"the rate grows with '{motion.x}' beyond its square")
    if bottom == 0:
        return Verdict("proved", "the rate is a polynomial")
    given = [*motion.poles.items(), *((c, None) for c in motion.others)]
    poles = [
        _FractionAtPole.of(bridge.inward(c), None if w is None else bridge.inward(w), fraction)
        for c, w in given
    ]
    shares = _shares(ground, poles)
    if len(shares) != bottom:
        told = f"the rate has {bottom} poles, of which {len(shares)} are declared"
        return Verdict("undecided", told)
    residuals = [(f"pole {quote(pole.place)}", pole.bottom) for pole in shares]
    residuals += [(f"residue at {quote(p.place)}", p.excess(n)) for p, n in shares.items()]
    verdict = ground.zero(residuals)  # for any values of the constants, as if nothing bound them
    if verdict.proved:
        return verdict
    return ground.zero([(label, ground.at_level(e)) for label, e in residuals])


@dataclass(frozen=True)
class _FractionAtPole:
    """A fraction top/bottom at a declared pole: both, and the slope of the bottom, there.

    Without a weight the residue may be any.
    """

    place: Any
    weight: Any
    top: Any
    bottom: Any
    slope: Any

    @classmethod
    def of(cls, place: Any, weight: Any, fraction: tuple[Any, Any]) -> _FractionAtPole:
        """The values at a place."""
        values = (e.xreplace({FREE: place}) for e in (*fraction, fraction[1].diff(FREE)))
        return cls(place, weight, *values)

    @property
    def share(self) -> Any:
        """The residue in units of the weight."""
        if self.weight is None:
            return se.Integer(0)
        return self.top / (self.slope * self.weight)

    def excess(self, share: int) -> Any:
        """What vanishes where the residue is so many weights."""
        if self.weight is None:
            return se.Integer(0)
        return self.top - share * self.weight * self.slope


def _shares(
    ground: QuadratureGround, poles: Sequence[_FractionAtPole]
) -> dict[_FractionAtPole, int]:
    """The poles at which the fraction has one, each place once; and how many weights the residue
    is there, -1, 0 or 1, as numbers suggest."""
    seen = [ground.at_level(e) for p in poles for e in (p.place, p.bottom, p.share)]
    for _, values in sample_evaluable(Tape(seen), ground.field.hypotheses, GENERIC, count=1):
        shares: dict[_FractionAtPole, int] = {}
        places: list[Any] = []
        for i, pole in enumerate(poles):
            place, bottom, share = values[3 * i : 3 * i + 3]
            if bottom.contains(0) and not any(place.overlaps(c) for c in places):
                shares[pole] = max(-1, min(1, round(float(share.mid()))))
                places.append(place)
        return shares
    raise EngineLimit("no point was found at which the residues can be read off")


def _degree(polynomial: Any) -> int:
    """The degree in the variable of an expanded polynomial."""
    degree = -1
    while polynomial != 0:
        polynomial, degree = se.expand(polynomial.diff(FREE)), degree + 1
    return degree


@dataclass(frozen=True)
class InSpace:
    """What is stated of a frame in space, a matrix of functions of the state."""

    ground: QuadratureGround
    space: Space

    @cached_property
    def frame(self) -> list[list[Any]]:
        """The rows of the frame."""
        read = self.ground.field.read
        return [[read(self.space.frame[i, j]) for j in range(3)] for i in range(3)]

    @cached_property
    def vector(self) -> list[Any]:
        """The components of the vector along the frame."""
        return [self.ground.field.read(e) for e in self.space.vector]

    def orthogonal(self) -> Verdict:
        """E^T E = 1, and the columns are right-handed."""
        a, b, c = zip(*self.frame, strict=True)
        residuals = [("lengths", dot(e, e) - 1) for e in (a, b)]
        residuals.append(("right angle", dot(a, b)))
        crossed = [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]
        residuals += [("third column", x - y) for x, y in zip(crossed, c, strict=True)]
        return self.ground.zero(residuals)

    def constant(self) -> Verdict:
        """d(E m)/dt = 0."""
        rates = self.ground.field.derivatives([dot(row, self.vector) for row in self.frame])
        verdict = self.ground.zero([(f"component {i + 1}", r) for i, r in enumerate(rates)])
        parts = [(f"component {i + 1}", dot(row, self.vector)) for i, row in enumerate(self.frame)]
        return across_cuts(verdict, self.ground.field, parts, constant=True)

    def free(self) -> Verdict:
        """Nothing else, nor how the frame turns along itself, depends on coordinates in space."""
        field = self.ground.field
        coordinates = [field.read(q) for q in self.space.coordinates]
        pairs = zip(field.variables, field.components, strict=True)
        rest = [(f"the rate of {q}", rate) for q, rate in pairs if q not in coordinates]
        rest += [(f"the vector, {i + 1}", m) for i, m in enumerate(self.vector)]
        rest += [(f"{s}", e) for s, e in self.ground.level.items()]
        rest += [(f"the turning, {i + 1}", e) for i, e in enumerate(self._rotation_entries())]
        residuals = [
            (f"{what} by {q}", e.diff(q))
            for what, e in rest
            for q in coordinates
            if q in e.free_symbols
        ]
        return self.ground.zero(residuals)

    def _rotation_entries(self) -> list[Any]:
        """The three entries of E^T dE/dt."""
        field = self.ground.field
        a, b, c = zip(*self.frame, strict=True)
        pairs = ((a, b), (b, c), (c, a))
        return [dot(x, [field.derivative(e) for e in y]) for x, y in pairs]

    def inverse(self) -> Verdict:
        """The coordinates read off the frame are themselves, up to whole turns."""
        field, angles = self.ground.field, self.ground.angles
        entries = {
            field.bridge.inward(self.space.entries[i, j]): self.frame[i][j]
            for i in range(3) for j in range(3)
        }  # fmt: skip
        residuals: Residuals = []
        for q, value in self.space.coordinates.items():
            off = field.bridge.inward(value).xreplace(entries) - field.read(q)
            residuals += [
                (f"sin({plain_name(q)})", angles.resolve(se.sin(off))),
                (f"cos({plain_name(q)})", angles.resolve(se.cos(off)) - 1),
            ]
        return self.ground.zero(residuals)


def check_motion(motions: Motions) -> Iterator[Claim]:
    """A claim of kind ``motion`` for everything that the quadratures of a system state."""
    system = motions.system
    if system.motion is None:
        return
    for name, decide in statements(QuadratureGround(motions.on_coordinates, system.motion)):
        begin = clock.perf_counter()
        verdict = not_vacuous(verdict_of(decide), motions.on_coordinates)
        seconds, reason = clock.perf_counter() - begin, system.undecided.get(name, "")
        yield Claim("motion", name, verdict, "coordinates", seconds, reason=reason)


def statements(ground: QuadratureGround) -> Iterator[tuple[str, Callable[[], Verdict]]]:
    """The name of each claim, which ``Quadratures.claims`` lists too, and how it is decided."""
    motion = ground.motion
    ways: list[Callable[[], Verdict]] = [partial(_constant, ground, c) for c in motion.constants]
    ways.append(partial(_quartic, ground))
    ways += [partial(_rate, ground, q) for q in motion.integrals]
    ways += [partial(_pole, ground, c) for c in motion.poles]
    ways += [partial(_decide_residues, ground, rate) for rate in motion.rates.values()]
    ways += [partial(_trace, ground, t) for t in motion.traces]
    ways += [partial(_velocity, ground, v) for v in motion.velocities]
    if motion.space is not None:
        space = InSpace(ground, motion.space)
        ways += [space.orthogonal, space.constant, space.free, space.inverse]
    if motion.plane is not None:
        ways += [
            partial(_direction, ground, motion.plane),
            partial(_along, ground, motion.plane),
        ]
    return zip(motion.claims, ways, strict=True)


def _constant(ground: QuadratureGround, symbol: sp.Symbol) -> Verdict:
    function = ground.level[ground.field.bridge.inward(symbol)]
    verdict = ground.zero([("", ground.field.derivative(function))])
    return across_cuts(verdict, ground.field, [("", function)], constant=True)


def _quartic(ground: QuadratureGround) -> Verdict:
    verdict = ground.zero([("", ground.run**2 - ground.on_level(ground.motion.quartic))])
    # what bounces, as |cos(u)| does, obeys the quartic on both sides, and the closed form goes on
    variable = [
        ("the variable", ground.field.read(ground.motion.meaning)),
        ("its rate", ground.run),
    ]
    back = _where_time_runs_back(ground) if verdict.proved else None
    if back is not None:
        return back
    return across_cuts(verdict, ground.field, variable, periods=False)


def _where_time_runs_back(ground: QuadratureGround) -> Verdict | None:
    """A refutation where dt/dtau is not positive at a state; that it is so on all the way of a
    motion is seen when the motion is computed."""
    if ground.motion.clock == 1:
        return None
    samples = sample_evaluable(Tape([ground.pace]), ground.field.hypotheses, count=SAMPLES)
    for point, (pace,) in samples:
        if pace <= 0:
            witness = witness_at(point, pace, flint.arb(0))
            return Verdict("refuted", f"the clock '{ground.motion.clock}' is not positive", witness)
    return None


def _rate(ground: QuadratureGround, q: sp.Expr) -> Verdict:
    there = ground.data_for(q)
    rate = there(ground.field.derivative(ground.field.read(q)) * ground.pace)
    return ground.zero([("", rate - there(ground.on_level(ground.motion.integrals[q])))])


def _pole(ground: QuadratureGround, place: sp.Expr) -> Verdict:
    """f(c) + 4 w^2 = 0 [Theory, eq. (26)]."""
    motion = ground.motion
    f = motion.quartic.xreplace({motion.x: place})
    return ground.zero([("", ground.on_level(f + 4 * motion.poles[place] ** 2))])


def _trace(ground: QuadratureGround, trace: Trace) -> Verdict:
    there = ground.data_for(trace.colatitude)
    cosine = there(se.cos(ground.field.read(trace.colatitude)))
    return ground.zero([("", cosine - there(ground.on_level(trace.cosine)))])


def _velocity(ground: QuadratureGround, v: sp.Expr) -> Verdict:
    claimed = ground.on_level(ground.motion.velocities[v])
    return ground.zero([("", ground.field.read(v) - claimed)])


def _direction(ground: QuadratureGround, plane: Plane) -> Verdict:
    """The vector in the plane is constant, and as long as is said."""
    a, b = (ground.field.read(e) for e in plane.direction)
    residuals = [
        (f"the rate of {quote(e)}", rate)
        for e, rate in zip(plane.direction, ground.field.derivatives([a, b]), strict=True)
    ]
    residuals.append(("the length", a**2 + b**2 - ground.on_level(plane.length) ** 2))
    parts = [(quote(e), part) for e, part in zip(plane.direction, (a, b), strict=True)]
    return across_cuts(ground.zero(residuals), ground.field, parts, constant=True)


def _along(ground: QuadratureGround, plane: Plane) -> Verdict:
    """length d(x + i y)/dtau = (a + i b)(rates + slopes dz/dtau)."""
    field = ground.field
    a, b = (field.read(e) for e in plane.direction)
    along, across = (
        ground.on_level(rate) + ground.on_level(slope) * ground.run
        for rate, slope in zip(plane.rates, plane.slopes, strict=True)
    )
    length = ground.on_level(plane.length)
    expected = (a * along - b * across, b * along + a * across)
    moved = [length * field.derivative(field.read(q)) * ground.pace for q in plane.place]
    pairs = zip(plane.place, moved, expected, strict=True)
    return ground.zero([(plain_name(q), rate - e) for q, rate, e in pairs])
