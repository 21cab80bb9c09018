"""What a system claims of its motions: declarations only, proved or refuted by ``analysis``.

Every expression here is a function of the state: of coordinates, velocities of the equations and
parameters, or of the system's invariants, whose names stand for them as plain symbols.  A claim
that holds no coordinate is decided on the reduced equations.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import sympy as sp

from voronec.declaration.reading import expression, mapping, several, shown
from voronec.errors import DefinitionError

__all__ = [
    "THEOREMS",
    "Case",
    "Corrected",
    "Equation",
    "Measure",
    "Poisson",
    "claim_names",
    "expressions_of",
    "read_claims",
    "replaced",
    "right_of",
]

THEOREMS = ("Euler-Jacobi",)
"""What ``integrable`` may name."""


@dataclass(frozen=True)
class Equation:
    """``function`` changes at the rate ``rate`` along every motion; vectors entry by entry."""

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
        given = several(self.variables, "variables of a measure", "symbol")
        object.__setattr__(self, "variables", given)


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
        variables = mapping(self.variables, "variables", "symbol: function")
        bracket = mapping(self.bracket, "bracket", "(a, b): expression")
        for pair in bracket:
            if not isinstance(pair, tuple) or len(pair) != 2 or not {*pair} <= {*variables}:
                raise DefinitionError(
                    f"the bracket of '{shown(pair)}' is no pair of its variables; "
                    "write {(a, b): expression}"
                )
        for a, b in bracket:
            if a == b or (b, a) in bracket:
                raise DefinitionError(
                    f"the bracket of '{shown((a, b))}' vanishes or is given twice; give one order "
                    "of each pair of different variables"
                )
        read = {k: expression(v, f"the meaning of '{shown(k)}'") for k, v in variables.items()}
        entries = {k: expression(v, f"the bracket of {shown(k)}") for k, v in bracket.items()}
        object.__setattr__(self, "variables", MappingProxyType(read))
        object.__setattr__(self, "bracket", MappingProxyType(entries))
        for part in ("hamiltonian", "clock"):
            object.__setattr__(self, part, expression(getattr(self, part), f"the {part}"))


@dataclass(frozen=True)
class Corrected:
    """A claim that is false as ``printed`` in ``source``, with the one that is true.

    Both are of the kind that stands in its place: an integral, an ``Equation``, a measure.  The
    printed one must be refuted and the other proved.
    """

    right: Any
    printed: Any
    source: str


@dataclass(frozen=True)
class Case:
    """Claims that hold where some parameters take special values.

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

    def __post_init__(self) -> None:
        if self.multiplier is not None:
            read = expression(self.multiplier, "the multiplier of a case")
            object.__setattr__(self, "multiplier", read)
        for part, entry in (("parameters", "parameter: value"),):
            object.__setattr__(self, part, mapping(getattr(self, part), part, entry))
        for part, value in read_claims(self).items():
            object.__setattr__(self, part, value)


def read_claims(holder: Any) -> dict[str, Any]:
    """The integrals, equations and measure of a system or a case in their final form."""
    found: dict[str, Any] = {}
    for part, one, entry, read in (
        ("integrals", "integral", "'name': expression", expression),
        ("equations", "equation", "'name': Equation(function, rate)", _equation),
    ):
        values = mapping(getattr(holder, part), part, entry)
        read_values = {k: _claimed(v, f"{one} '{shown(k)}'", read) for k, v in values.items()}
        found[part] = mapping(read_values, part, entry)
    if holder.measure is not None:
        found["measure"] = _claimed(holder.measure, "the measure", _measure)
    return found


def expressions_of(claim: Any) -> Iterator[sp.Expr]:
    """Every expression that a claim is made of."""
    if isinstance(claim, Corrected):
        yield from expressions_of(claim.right)
        yield from expressions_of(claim.printed)
    elif isinstance(claim, Equation):
        yield from (*claim.function, *claim.rate)
    elif isinstance(claim, Measure):
        yield from (claim.density, *claim.variables)
    elif isinstance(claim, Poisson):
        values = (*claim.variables.values(), *claim.bracket.values())
        yield from (*values, claim.hamiltonian, claim.clock)
    else:
        yield claim


def replaced(claim: Any, at: Mapping[Any, Any]) -> Any:
    """An integral, an equation or a measure with symbols replaced."""
    if isinstance(claim, Corrected):
        return Corrected(replaced(claim.right, at), replaced(claim.printed, at), claim.source)
    if isinstance(claim, Equation):
        function, rate = (
            tuple(e.xreplace(at) for e in part) for part in (claim.function, claim.rate)
        )
        return Equation(function, rate)
    if isinstance(claim, Measure):
        return Measure(claim.density.xreplace(at), claim.variables)
    return claim.xreplace(at)


def claim_names(system: Any) -> Iterator[str]:
    """Each claim of a system by the name it has; those without one by their kind."""
    holders: list[tuple[str, Any]] = [("", system)]
    for label, holder in holders + [(f"{n}: ", c) for n, c in system.cases.items()]:
        yield from (f"{label}{name}" for name in (*holder.integrals, *holder.equations))
        if holder.measure is not None:
            yield f"{label}measure"
        if holder.integrable:
            yield f"{label}integrable"
    for kind in ("multiplier", "poisson", "essential"):
        if getattr(system, kind):
            yield kind
    if system.invariants:
        yield "descent"
    yield from system.charts


def right_of(claim: Any) -> Any:
    """The claim itself; of a corrected one, the one that is true."""
    return claim.right if isinstance(claim, Corrected) else claim


def _claimed(value: Any, place: str, read: Callable[[Any, str], Any]) -> Any:
    if isinstance(value, Corrected):
        right, printed = read(value.right, place), read(value.printed, f"{place} as printed")
        return Corrected(right, printed, value.source)
    return read(value, place)


def _equation(value: Any, place: str) -> Equation:
    if isinstance(value, Equation):
        return value
    raise DefinitionError(f"{place} is '{shown(value)}'; write Equation(function, rate)")


def _measure(value: Any, place: str) -> Measure:
    return value if isinstance(value, Measure) else Measure(expression(value, place))
