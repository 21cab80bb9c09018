"""What a system claims of its motions: declarations only, proved or refuted by ``analysis``.

Every expression here is a function of the state: of coordinates, velocities of the equations and
parameters, or of the system's invariants, whose names stand for them as plain symbols.  A claim
that holds no coordinate is decided on the reduced equations.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from types import MappingProxyType
from typing import Any, NamedTuple

import sympy as sp

from voronec.algebra.arguments import takes_fields
from voronec.algebra.symbols import plain_name
from voronec.declaration.reading import expression, fixed_mapping, quote, several
from voronec.errors import DefinitionError

ASSERTION, EQUATION = "Assertion(kind, expressions, decide)", "Equation(function, rate)"
THEOREMS = ("Euler-Jacobi",)
"""What ``integrable`` may name."""


@takes_fields
@dataclass(frozen=True)
class Equation:
    """d(function)/dt = rate along every motion; vectors of one length, entry by entry."""

    function: tuple[sp.Expr, ...]
    rate: tuple[sp.Expr, ...]

    def __post_init__(self) -> None:
        for part in ("function", "rate"):
            place = f"the {part} of an equation"
            given = getattr(self, part)
            given = tuple(given) if isinstance(given, sp.MatrixBase) else given
            entries = several(given, place, "expression", (int, float))
            read = tuple(expression(e, place) for e in entries)
            object.__setattr__(self, part, read)
        if len(self.function) != len(self.rate):
            raise DefinitionError(
                f"an equation has {len(self.function)} functions and {len(self.rate)} rates; "
                "give as many of the one as of the other"
            )


@takes_fields
@dataclass(frozen=True)
class Measure:
    """``density`` times the volume of ``variables`` is invariant: div(density f) = 0.

    ``variables`` are the coordinates and the velocities of the equations, or the invariants and
    these velocities, or some of either whose rates depend on nothing else; where none are given,
    the coordinates and the velocities.  Where relations R bind the variables, the volume is the one
    whose product with dR is that of all variables taken as independent.
    """

    density: sp.Expr
    variables: tuple[sp.Expr, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "density", expression(self.density, "the measure"))
        given = _variables(self.variables, "variables of a measure")
        object.__setattr__(self, "variables", given)


@takes_fields
@dataclass(frozen=True)
class Poisson:
    """dx/dt = clock {x, hamiltonian} with a bracket that is skew and satisfies Jacobi's identity.

    ``variables`` name new symbols with their meaning, functions of the state that determine it; a
    variable of the state that is taken as it is stands for itself, ``{x: x}``.  ``bracket`` gives
    {a, b} by pairs of these symbols, one order of each pair, zero where nothing is given; entries,
    the Hamiltonian and the clock may hold the new symbols and the state.
    """

    variables: Mapping[Any, Any]
    bracket: Mapping[tuple[Any, Any], Any]
    hamiltonian: Any
    clock: Any = sp.Integer(1)

    def __post_init__(self) -> None:
        variables = fixed_mapping(self.variables, "variables", "symbol: function")
        bracket = fixed_mapping(self.bracket, "bracket", "(a, b): expression")
        for pair in bracket:
            if not isinstance(pair, tuple) or len(pair) != 2 or not {*pair} <= {*variables}:
                raise DefinitionError(
                    f"the bracket of '{quote(pair)}' is no pair of its variables; "
                    "write {(a, b): expression}"
                )
        for a, b in bracket:
            if a == b or (b, a) in bracket:
                raise DefinitionError(
                    f"the bracket of '{quote((a, b))}' vanishes or is given twice; give one order "
                    "of each pair of different variables"
                )
        read = {k: expression(v, f"the meaning of '{quote(k)}'") for k, v in variables.items()}
        entries = {k: expression(v, f"the bracket of {quote(k)}") for k, v in bracket.items()}
        object.__setattr__(self, "variables", MappingProxyType(read))
        object.__setattr__(self, "bracket", MappingProxyType(entries))
        for part in ("hamiltonian", "clock"):
            object.__setattr__(self, part, expression(getattr(self, part), f"the {part}"))


@takes_fields
@dataclass(frozen=True)
class Assertion:
    """A claim of a kind of one's own: what it is about, and how it is decided.

    kind
        what tables call it, a word of letters.
    expressions
        functions of the state, as in every claim.
    decide
        a function of the motions, ``voronec.equations.motions.Motions``, and of the
        expressions, that returns a ``Verdict``.  ``motions.field_for(expressions)`` is the vector
        field on which they are decided.
    """

    kind: str
    expressions: tuple[Any, ...]
    decide: Callable[[Any, tuple[Any, ...]], Any]

    def __post_init__(self) -> None:
        taken = {*(kind.name for kind in KINDS), "descent", "case", "chart", "motion"}
        if not isinstance(self.kind, str) or not self.kind.isidentifier() or self.kind in taken:
            raise DefinitionError(
                f"the kind of an assertion is '{quote(self.kind)}'; give a word of letters that is "
                f"none of {', '.join(sorted(taken))}"
            )
        if not callable(self.decide):
            raise DefinitionError(
                f"an assertion is decided by '{quote(self.decide)}'; give a function of the "
                "motions and the expressions"
            )
        place = f"'{self.kind}'"
        given = several(self.expressions, f"expressions of {place}", "expression", (int, float))
        read = tuple(expression(e, place) for e in given)
        object.__setattr__(self, "expressions", read)


@takes_fields
@dataclass(frozen=True)
class Corrected:
    """A claim that is false as ``printed`` in ``source``, with the one that is true.

    Both are of the kind that stands in its place: an integral, an ``Equation``, an ``Assertion``, a
    measure.  ``source`` is a key of the bibliography.  A check demands that
    the printed one is refuted and the other proved.
    """

    right: Any
    printed: Any
    source: str


@takes_fields
@dataclass(frozen=True)
class Case:
    """Claims that hold where some parameters take special values, or inputs that are held.

    ``parameters`` gives them as numbers or functions of the other parameters; the claims are
    those of ``System``.  For ``integrable`` the integrals of the system count too, and its measure
    where the case has none.
    """

    parameters: Mapping[Any, Any]
    integrals: Mapping[str, Any] = field(default_factory=dict)
    equations: Mapping[str, Any] = field(default_factory=dict)
    measure: Any = None
    integrable: str = ""
    note: str = ""
    multiplier: Any = None
    assertions: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        given = fixed_mapping(self.parameters, "parameters", "parameter: value")
        object.__setattr__(self, "parameters", given)
        for part, value in read_claims(self).items():
            object.__setattr__(self, part, value)


def _theorem(value: Any, place: str) -> str:
    """The name of a theorem as it is given; whether it is known is the system's to say."""
    if not isinstance(value, str):
        raise DefinitionError(f"{place} is '{quote(value)}', which names no theorem; write a text")
    return value


class ClaimKind(NamedTuple):
    """A kind of claim: the field that holds it, in a system or a case, and how it is read.

    ``entry`` shows what a field holds that has claims by their names.  A claim that stands alone
    has a ``title``, and a ``place`` for messages; its field is ``empty`` where there is none.
    """

    name: str
    field: str
    read: Callable[[Any, str], Any]
    entry: str = ""
    title: Callable[[Any], str] = str
    place: str = ""
    empty: Any = None


class DeclaredClaim(NamedTuple):
    """A claim as it is declared; ``place`` is what messages call it, ``key`` what ``undecided``
    does."""

    kind: str
    name: str
    place: str
    key: str
    value: Any


def declared_claims(holder: Any) -> Iterator[DeclaredClaim]:
    """The claims of a system or a case, in the order of ``KINDS``; the descent is none of them."""
    for kind in KINDS:
        held: Any = getattr(holder, kind.field, None)
        if kind.entry:
            for name, claim in held.items():
                right = right_of(claim)
                label = right.kind if isinstance(right, Assertion) else kind.name
                yield DeclaredClaim(label, name, f"{label} '{name}'", name, claim)
        elif held not in (None, (), ""):
            yield DeclaredClaim(kind.name, kind.title(held), kind.place, kind.name, held)


def without_claims() -> dict[str, Any]:
    """The fields of a system that claims nothing of its motions, and says no words of them."""
    empty: dict[str, Any] = {"cases": {}, "undecided": {}, "meanings": {}}
    return {k.field: {} if k.entry else k.empty for k in KINDS} | empty


def read_claims(holder: Any) -> dict[str, Any]:
    """The claims of a system or a case in their final form, by fields."""
    claims: dict[str, Any] = {}
    for kind in KINDS:
        held = getattr(holder, kind.field, None)
        if kind.entry:
            values = fixed_mapping(held, kind.field, kind.entry)
            read = {
                k: _read_claim(v, f"{kind.name} '{quote(k)}'", kind.read) for k, v in values.items()
            }
            claims[kind.field] = fixed_mapping(read, kind.field, kind.entry)
        elif held is not None:
            claims[kind.field] = kind.read(held, kind.place)
    return claims


def expressions_of(claim: Any) -> Iterator[sp.Expr]:
    """Every expression that a claim is made of."""
    if isinstance(claim, Corrected):
        yield from expressions_of(claim.right)
        yield from expressions_of(claim.printed)
    elif isinstance(claim, Equation):
        yield from (*claim.function, *claim.rate)
    elif isinstance(claim, Measure):
        yield from (claim.density, *claim.variables)
    elif isinstance(claim, Assertion):
        yield from claim.expressions
    elif isinstance(claim, Poisson):
        ones = dict.fromkeys(claim.variables, sp.Integer(1))
        values = (*claim.variables.values(), *claim.bracket.values())
        yield from (e.xreplace(ones) for e in (*values, claim.hamiltonian, claim.clock))
    elif isinstance(claim, tuple):
        yield from claim
    elif not isinstance(claim, str):
        yield claim


def replace_symbols(declared: Any, at: Mapping[Any, Any]) -> Any:
    """A claim, or any other declaration, with symbols replaced: an expression, or what holds some;
    names stay."""
    if isinstance(declared, sp.Basic):
        return declared.xreplace(at)
    if isinstance(declared, Mapping):
        return {name: replace_symbols(one, at) for name, one in declared.items()}
    if isinstance(declared, tuple):
        return tuple(replace_symbols(one, at) for one in declared)
    if isinstance(declared, Corrected | Equation | Measure | Assertion):
        parts = {f.name: getattr(declared, f.name) for f in fields(declared)}
        return replace(declared, **replace_symbols(parts, at))
    return declared


def claim_names(system: Any) -> Iterator[str]:
    """Each claim of a system, its charts and its motion in closed form among them, by the name it
    has; those without one by their kind."""
    for label, holder in (("", system), *((f"{n}: ", c) for n, c in system.cases.items())):
        yield from (f"{label}{claim.key}" for claim in declared_claims(holder))
    if system.invariants:
        yield "descent"
    yield from system.charts
    yield from system.motion.claims if system.motion is not None else ()


def right_of(claim: Any) -> Any:
    """The claim itself; of a corrected one, the one that is true."""
    return claim.right if isinstance(claim, Corrected) else claim


def _variables(given: Any, place: str) -> tuple[sp.Expr, ...]:
    """Variables of the motion, symbols or derivatives."""
    variables = several(given, place, "symbol")
    for thing in variables:
        if not isinstance(thing, sp.Expr):
            raise DefinitionError(f"{place}: '{quote(thing)}' is no symbol; give the symbol")
    for thing in variables:
        if variables.count(thing) > 1:
            raise DefinitionError(f"{place}: '{quote(thing)}' is named twice; name it once")
    return variables


def _read_claim(value: Any, place: str, read: Callable[[Any, str], Any]) -> Any:
    if isinstance(value, Corrected):
        right, printed = read(value.right, place), read(value.printed, f"{place} as printed")
        return Corrected(right, printed, value.source)
    return read(value, place)


def _reader_of(kind: type, entry: str) -> Callable[[Any, str], Any]:
    """Takes values of one class; ``entry`` shows in messages how one is written."""

    def read(value: Any, place: str) -> Any:
        if isinstance(value, kind):
            return value
        raise DefinitionError(f"{place} is '{quote(value)}'; write {entry}")

    return read


def _measure(value: Any, place: str) -> Measure:
    return value if isinstance(value, Measure) else Measure(expression(value, place))


def _names(things: Iterable[Any]) -> str:
    return ", ".join(map(plain_name, things))


KINDS = (
    ClaimKind("integral", "integrals", expression, "'name': expression"),
    ClaimKind("equation", "equations", _reader_of(Equation, EQUATION), f"'name': {EQUATION}"),
    ClaimKind("assertion", "assertions", _reader_of(Assertion, ASSERTION), f"'name': {ASSERTION}"),
    ClaimKind(
        "measure", "measure", lambda value, place: _read_claim(value, place, _measure),
        title=lambda _: "density", place="the measure",
    ),
    ClaimKind(
        "multiplier", "multiplier", expression,
        title=lambda _: "reducing multiplier", place="the multiplier",
    ),
    ClaimKind(
        "poisson", "poisson", _reader_of(Poisson, "Poisson(variables, bracket, ...)"),
        title=lambda claim: _names(claim.variables), place="poisson",
    ),
    ClaimKind(
        "essential", "essential", _variables, title=_names, place="essential", empty=()
    ),
    ClaimKind("integrable", "integrable", _theorem, place="integrable", empty=""),
)  # fmt: skip
"""Every kind of claim that a system declares, in the order in which they are decided."""
