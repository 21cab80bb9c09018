"""The declaration of a motion by quadratures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import sympy as sp

from voronec.algebra.arguments import takes_fields
from voronec.algebra.memo import Memo
from voronec.algebra.symbols import names_in, plain_name
from voronec.declaration.reading import expression, fixed_mapping, quote, several
from voronec.errors import DefinitionError


@takes_fields
@dataclass(frozen=True)
class Trace:
    """The trace of a contact on a sphere: its colatitude and longitude, both coordinates.

    ``cosine`` is that of the colatitude, rational in the variable, affine where the time is that of
    the quartic; ``title`` the key under which the
    system's ``drawing`` has the two coordinates, filled in by the system.
    """

    colatitude: Any
    longitude: Any
    cosine: Any
    title: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "cosine", expression(self.cosine, "the cosine of a trace"))


@takes_fields
@dataclass(frozen=True)
class Space:
    """How a body is turned in space, where only the direction of one vector matters.

    frame
        3 x 3 orthogonal, a function of the state: the columns are a moving frame in space.
    vector
        3 components along that frame; ``frame * vector`` is constant in space.
    coordinates
        coordinate -> its value as a function of ``entries``, those of the frame; written with
        ``atan2``, which is accurate everywhere.  Nothing else depends on these coordinates.
    entries
        3 x 3 symbols.

    Integrals and traces of these coordinates hold where ``frame * vector`` lies along the third
    axis, upwards; any other motion is such a one, turned in space.
    """

    frame: sp.ImmutableMatrix
    vector: sp.ImmutableMatrix
    coordinates: Mapping[Any, Any]
    entries: sp.ImmutableMatrix

    @cached_property
    def memo(self) -> Memo:
        """What is computed of it once."""
        return Memo()

    def __post_init__(self) -> None:
        for name, shape in (("frame", (3, 3)), ("vector", (3, 1)), ("entries", (3, 3))):
            given = getattr(self, name)
            if not isinstance(given, sp.MatrixBase) or given.shape != shape:
                raise DefinitionError(
                    f"{name} of a space is '{quote(given)}'; write a sympy Matrix of shape {shape}"
                )
            object.__setattr__(self, name, sp.ImmutableMatrix(given))
        if not all(isinstance(e, sp.Symbol) for e in self.entries):
            raise DefinitionError("entries of a space hold more than symbols; write 9 symbols")
        store(self, "coordinates", self.coordinates, "a coordinate in space")
        for q, value in self.coordinates.items():
            foreign = sorted(map(str, names_in(value) - {*self.entries}))
            if foreign:
                raise DefinitionError(
                    f"the coordinate '{plain_name(q)}' in space holds '{foreign[0]}'; write it "
                    "with the entries of the frame"
                )


@takes_fields
@dataclass(frozen=True)
class Plane:
    """How a contact runs over a plane, along and across a vector that is constant there.

    place
        (x, y), two coordinates.
    direction
        (a, b), functions of the state, constant along the motion: a vector in the plane.
    length
        its length, a function of constants and parameters.
    rates
        d/dtau of the place along the vector and across it, to its left, as far as they are
        integrals: rational in the variable.
    slopes
        the rest of both by the variable, rational in it: what has come back has moved nothing.

    In complex numbers, with d = (a + i b)/length and the variable z,
    d(x + i y) = d ((rates[0] + i rates[1]) dtau + (slopes[0] + i slopes[1]) dz).
    """

    place: tuple[Any, Any]
    direction: tuple[Any, Any]
    length: Any
    rates: tuple[Any, Any] = (0, 0)
    slopes: tuple[Any, Any] = (0, 0)

    def __post_init__(self) -> None:
        for name in ("place", "direction", "rates", "slopes"):
            given = several(getattr(self, name), name, "one, other")
            if len(given) != 2:
                raise DefinitionError(f"{name} of a plane holds {len(given)} entries; write two")
            read = tuple(expression(e, f"{name} of a plane") for e in given)
            object.__setattr__(self, name, read)
        object.__setattr__(self, "length", expression(self.length, "length of a plane"))

    def at(self, origin: Sequence[Any], direction: Sequence[Any], moved: Sequence[Any]) -> Any:
        """{coordinate: value} of the place: from ``origin`` (x, y), ``moved`` = (p, q) along the
        unit vector ``direction`` = (a, b) and across it, (x + a p - b q, y + b p + a q).

        All are pairs of numbers, of balls, or of arrays of one shape.
        """
        (x, y), (a, b), (along, across) = origin, direction, moved
        return {
            self.place[0]: x + a * along - b * across,
            self.place[1]: y + b * along + a * across,
        }


def store(owner: Any, name: str, given: Any, what: str) -> None:
    """A mapping to expressions in its final form."""
    values = fixed_mapping(given, name, "symbol: expression")
    read = {k: expression(e, f"{what} '{quote(k)}'") for k, e in values.items()}
    object.__setattr__(owner, name, MappingProxyType(read))


MOST = 4
"""The highest degree in the variable of the square of its rate."""


@takes_fields
@dataclass(frozen=True)
class Quadratures:
    """The motion of a system in closed form, as far as formulas go.

    variable
        {x: function of the state}: the variable, and what it is.
    constants
        symbol -> function of the state that is constant along the motion.
    quartic
        (dx/dtau)^2, a polynomial in x of degree four or less; its coefficients, and all that
        follows, are functions of constants and parameters.
    integrals
        coordinate -> its rate d/dtau, rational in x with simple poles.
    poles
        place c -> the signed weight w, f(c) = -4 w^2; where x passes c a rate has the residue w,
        -w or 0.  A place with a denominator that vanishes for some parameters lies at infinity
        then, and is no pole.
    others
        places of further simple poles, where the residues may be any: those of the clock, say.
    traces
        the curves on spheres, each a ``Trace``.
    velocities
        velocity of the equations -> its value, made of coordinates and their velocities, of x,
        constants and parameters.
    space
        ``Space``, where a direction in space is arbitrary.
    plane
        ``Plane``, where the contact runs over one.
    clock
        dt/dtau, a function of x that is positive; 1 where the quartic is in the time itself.
    """

    variable: Mapping[Any, Any]
    constants: Mapping[Any, Any]
    quartic: Any
    integrals: Mapping[Any, Any]
    poles: Mapping[Any, Any] = field(default_factory=dict)
    others: tuple[Any, ...] = ()
    traces: tuple[Trace, ...] = ()
    velocities: Mapping[Any, Any] = field(default_factory=dict)
    space: Space | None = None
    plane: Plane | None = None
    clock: Any = sp.Integer(1)

    def __post_init__(self) -> None:
        for name, what in (
            ("variable", "the variable"),
            ("constants", "the constant"),
            ("integrals", "the rate of"),
            ("velocities", "the velocity"),
        ):
            store(self, name, getattr(self, name), what)
        if len(self.variable) != 1 or not isinstance(self.x, sp.Symbol):
            raise DefinitionError(
                f"variable = {quote(dict(self.variable))} is not one symbol with its meaning; "
                "write variable={x: cos(u)}"
            )
        for name in ("quartic", "clock"):
            object.__setattr__(self, name, expression(getattr(self, name), f"the {name}"))
        given = fixed_mapping(self.poles, "poles", "place: weight").items()
        poles = {expression(c, "a pole"): expression(w, "the weight of a pole") for c, w in given}
        object.__setattr__(self, "poles", MappingProxyType(poles))
        others = several(self.others, "others", "place", (int, float))
        object.__setattr__(self, "others", tuple(expression(c, "a pole") for c in others))
        traces = several(self.traces, "traces", "Trace(u, v, cosine)", Trace)
        object.__setattr__(self, "traces", traces)
        self._check()

    @cached_property
    def memo(self) -> Memo:
        """What is computed of it once."""
        return Memo()

    def _check(self) -> None:
        if not self.quartic.is_polynomial(self.x) or _degree(self.quartic, self.x) > MOST:
            raise DefinitionError(
                f"the quartic is '{quote(self.quartic)}', which is no polynomial in '{self.x}' of "
                f"degree {MOST} or less"
            )
        for q, rate in self.integrals.items():
            _check_rational(rate, self.x, f"the rate of '{plain_name(q)}'")
        _check_rational(self.clock, self.x, "the clock")
        for place, weight in self.poles.items():
            if place.has(self.x) or weight.has(self.x):
                raise DefinitionError(
                    f"the pole '{quote(place)}' or its weight holds the variable '{self.x}'; "
                    "write both with constants and parameters"
                )
        for trace in self.traces:
            if not isinstance(trace, Trace):
                raise DefinitionError(f"a trace is '{quote(trace)}'; write Trace(u, v, cosine)")
            where = f"the cosine of '{plain_name(trace.colatitude)}'"
            _check_rational(trace.cosine, self.x, where)
        if self.plane is not None:
            _kind(self.plane, Plane, "Plane(place, direction, length, rates, slopes)")
            for rate in (*self.plane.rates, *self.plane.slopes):
                _check_rational(rate, self.x, "a rate or a slope of a plane")
        if self.space is not None:
            _kind(self.space, Space, "Space(frame, vector, coordinates, entries)")

    @property
    def x(self) -> sp.Symbol:
        """The variable."""
        return next(iter(self.variable))

    @property
    def meaning(self) -> sp.Expr:
        """The variable as a function of the state."""
        return self.variable[self.x]

    @cached_property
    def angles(self) -> tuple[sp.Expr, ...]:
        """The coordinates that are integrals, in their order."""
        return tuple(self.integrals)

    @property
    def lengths(self) -> frozenset[sp.Expr]:
        """What is no angle of the coordinates: the variable, where it is one, and the place on a
        plane."""
        return frozenset({self.meaning} | ({*self.plane.place} if self.plane else set()))

    @property
    def plain_coordinates(self) -> frozenset[sp.Expr]:
        """The coordinates whose velocities follow from the variable, however the motion lies in
        space."""
        turned = {*self.space.coordinates} if self.space is not None else set()
        return frozenset(
            {self.meaning, *self.integrals, *(t.colatitude for t in self.traces)} - turned
        )

    @property
    def rates(self) -> Mapping[str, sp.Expr]:
        """Everything that is integrated, by name: angles, the clock, the place in a plane."""
        integrands = {plain_name(q): rate for q, rate in self.integrals.items()}
        if self.clock != 1:
            integrands["the clock"] = self.clock
        if self.plane is not None:
            forward, left = self.plane.rates
            integrands |= {"the way along": forward, "the way across": left}
        return integrands

    @property
    def known_coordinates(self) -> frozenset[sp.Expr]:
        """The coordinates that have a value."""
        named = {q for t in self.traces for q in (t.colatitude, t.longitude)}
        turned = {*self.space.coordinates} if self.space is not None else set()
        moved = {*self.plane.place} if self.plane is not None else set()
        return frozenset({self.meaning, *self.integrals} | named | turned | moved)

    def expressions(self) -> Iterator[tuple[str, sp.Expr, str]]:
        """Every expression, what a message calls it, and what it may hold: symbols of the
        ``state``, those of a ``level``, which are the variable, constants and parameters, or
        ``both``."""
        for symbol, e in (*self.variable.items(), *self.constants.items()):
            yield f"the meaning of '{symbol}'", e, "state"
        yield "the quartic", self.quartic, "level"
        yield "the clock", self.clock, "level"
        for q, e in self.integrals.items():
            yield f"the rate of '{plain_name(q)}'", e, "level"
        for place, weight in self.poles.items():
            yield "a pole", place, "level"
            yield "the weight of a pole", weight, "level"
        for place in self.others:
            yield "a pole", place, "level"
        for trace in self.traces:
            yield f"the cosine of '{plain_name(trace.colatitude)}'", trace.cosine, "level"
        for v, e in self.velocities.items():
            yield f"the velocity '{plain_name(v)}'", e, "both"
        if self.space is not None:
            for e in (*self.space.frame, *self.space.vector):
                yield "the frame or the vector in space", e, "state"
        if self.plane is not None:
            for e in (*self.plane.place, *self.plane.direction):
                yield "the place or the direction in a plane", e, "state"
            for e in (self.plane.length, *self.plane.rates, *self.plane.slopes):
                yield "the motion along a plane", e, "level"

    @property
    def claims(self) -> tuple[str, ...]:
        """The name of every claim that this makes, of kind ``motion``."""
        claimed = [f"{symbol} is constant" for symbol in self.constants]
        claimed += [f"rate of {plain_name(q)}" for q in (self.x, *self.integrals)]
        claimed += [f"pole {quote(place)}" for place in self.poles]
        claimed += [f"residues of {what}" for what in self.rates]
        claimed += [f"cosine of {plain_name(t.colatitude)}" for t in self.traces]
        claimed += [f"velocity {plain_name(v)}" for v in self.velocities]
        if self.space is not None:
            claimed += ["frame is orthogonal", "vector is constant in space"]
            claimed += ["rest is free of space", "coordinates in space"]
        if self.plane is not None:
            claimed += ["direction in the plane", "place in the plane"]
        return tuple(claimed)

    def with_titles(self, drawing: Any) -> Quadratures:
        """The quadratures with the titles that a system's ``drawing`` gives to the traces."""
        if not isinstance(drawing, Mapping):
            return self
        titles = {tuple(map(str, pair)): title for title, pair in drawing.items()}
        traces = tuple(replace(t, title=t.title or titles.get(_pair(t), "")) for t in self.traces)
        titled = object.__new__(type(self))  # what is read already is not read again
        for attribute in fields(self):
            object.__setattr__(titled, attribute.name, getattr(self, attribute.name))
        object.__setattr__(titled, "traces", traces)
        return titled


def _pair(trace: Trace) -> tuple[str, str]:
    return plain_name(trace.colatitude), plain_name(trace.longitude)


def _kind(thing: Any, kind: type, entry: str) -> None:
    if not isinstance(thing, kind):
        name = kind.__name__.lower()
        raise DefinitionError(f"{name} is '{quote(thing)}'; write {entry}")


def _degree(value: sp.Expr, x: sp.Symbol) -> int:
    """The degree of a polynomial, if nothing cancels; expanding it could take minutes."""
    if not value.has(x):
        return 0
    if isinstance(value, sp.Add):
        return max(_degree(a, x) for a in value.args)
    if isinstance(value, sp.Mul):
        return sum(_degree(a, x) for a in value.args)
    if isinstance(value, sp.Pow):
        return _degree(value.base, x) * int(value.exp)
    return 1


def _check_rational(value: sp.Expr, x: sp.Symbol, what: str) -> None:
    if not value.is_rational_function(x):
        raise DefinitionError(f"{what} is '{quote(value)}', which is not rational in '{x}'")
