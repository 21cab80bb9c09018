"""Constants of a system, and motions of it to look at: declarations only."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import sympy as sp

from voronec.algebra.arguments import FLAG, TEXT, require, takes_fields
from voronec.algebra.symbols import is_symbolic_name, plain_name
from voronec.algebra.text import as_expression
from voronec.declaration.reading import (
    fixed_mapping,
    quote,
    real_number,
    real_text,
    several,
    texts_read,
)
from voronec.errors import DefinitionError


@takes_fields
@dataclass(frozen=True)
class Parameter:
    """A constant of a system: its symbol, a default value, the range it may take.

    ``lower`` and ``upper`` are bounds that a value must not pass; ``positive`` asks for a value
    above zero, as ``sympy.Symbol(name, positive=True)`` does.  Claims are proved, and refuted, for
    such values only.  ``meaning`` says in words what the constant is.  An unknown function of the
    time, ``f(t)``, is a parameter too: it is carried along exactly, and has no value.
    """

    symbol: sp.Expr
    value: Any = None
    positive: bool = False
    lower: Any = None
    upper: Any = None
    meaning: str = ""

    def __post_init__(self) -> None:
        if not is_symbolic_name(self.symbol):
            raise DefinitionError(
                f"parameter '{quote(self.symbol)}' is not a symbol; use sympy.Symbol"
            )
        if self.symbol.is_real is False:
            raise DefinitionError(f"parameter '{self.name}' is not real for SymPy; use a real one")
        require("parameter", "positive", self.positive, FLAG)
        if self.positive and self.symbol.is_positive is False:
            raise DefinitionError(
                f"parameter '{self.name}' is declared positive, and its symbol is not; declare it "
                "once"
            )
        for bound in ("lower", "upper"):
            if getattr(self, bound) is not None:
                real_number(getattr(self, bound), f"parameter '{self.name}': {bound}")
        require("parameter", "meaning", self.meaning, TEXT)
        for field_name in ("value", "lower", "upper"):
            if isinstance(getattr(self, field_name), str):
                place = f"parameter '{self.name}'" + f": {field_name}" * (field_name != "value")
                number = real_text(getattr(self, field_name), place)
                object.__setattr__(self, field_name, number)
        if self.value is not None:
            self.check(self.value)

    @classmethod
    def each(
        cls, symbols: Iterable[sp.Expr], values: Iterable[Any], **said: Any
    ) -> tuple[Parameter, ...]:
        """One parameter for each symbol, with its value, of which the same is ``said``."""
        named, given = tuple(symbols), tuple(values)
        if len(named) != len(given):
            raise DefinitionError(
                f"{len(given)} values are given for {len(named)} parameters, beginning with "
                f"'{quote(named[:1])}'; give one for each"
            )
        return tuple(cls(s, value, **said) for s, value in zip(named, given, strict=True))

    @property
    def name(self) -> str:
        """The parameter's name."""
        return plain_name(self.symbol)

    @property
    def is_positive(self) -> bool:
        """Whether it is declared positive, here or with its symbol."""
        return self.positive or bool(self.symbol.is_positive)

    @property
    def conditions(self) -> tuple[Any, ...]:
        """The declared range as relations of SymPy's; of what these know already nothing is left.

        What SymPy knows of the symbol itself is not among them.
        """
        relations = [self.symbol > 0] if self.positive else []
        relations += [] if self.lower is None else [self.symbol >= as_expression(self.lower)]
        relations += [] if self.upper is None else [self.symbol <= as_expression(self.upper)]
        return tuple(c for c in relations if c != sp.true)

    def check(self, value: Any) -> None:
        """Raise ``DefinitionError`` where ``value`` lies outside the declared range."""
        number = real_number(value, f"parameter '{self.name}'")
        if self.is_positive and not number > 0:
            raise DefinitionError(f"parameter '{self.name}' = {value} must be positive")
        if self.lower is not None and number < as_expression(self.lower):
            raise DefinitionError(f"parameter '{self.name}' = {value} is below {self.lower}")
        if self.upper is not None and number > as_expression(self.upper):
            raise DefinitionError(f"parameter '{self.name}' = {value} is above {self.upper}")


@takes_fields
@dataclass(frozen=True)
class Scene:
    """One motion to look at: initial data, a time span, and what is wanted from it.

    ``initial`` gives coordinates and velocities (quasi-velocities of the frame, or velocities of
    coordinates, which must agree with the constraints) by symbol or name; what is not named starts
    at zero.  ``parameters`` overrides defaults; ``inputs`` gives the values of inputs, as
    ``integrate`` takes them.  ``times`` is ``(start, end)``; the end may come first.

    ``outputs`` are what is wanted, and nothing else need be computed: coordinates, velocities,
    invariants, integrals by name, expressions in the first three, ``configuration`` (all
    coordinates), the title of a contact's trace in the drawing, ``reaction k`` (the multiplier of
    constraint k, from 1; in expressions ``reaction_k``).  Empty means all coordinates and
    velocities.  ``caption`` says in a sentence what there is to see.
    """

    initial: Mapping[Any, Any]
    times: tuple[float, float] = (0.0, 10.0)
    parameters: Mapping[Any, Any] = field(default_factory=dict)
    outputs: tuple[Any, ...] = ()
    caption: str = ""
    inputs: Mapping[Any, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        fixed_mapping(self.inputs, "inputs", "input: value")
        initial = fixed_mapping(self.initial, "initial", "coordinate or velocity: value")
        constants = fixed_mapping(self.parameters, "parameters", "parameter: value")
        if texts_read(initial, "initial value") is not initial:
            object.__setattr__(self, "initial", texts_read(initial, "initial value"))
        if texts_read(constants, "parameter") is not constants:
            object.__setattr__(self, "parameters", texts_read(constants, "parameter"))
        require("scene", "caption", self.caption, TEXT)
        object.__setattr__(self, "times", _span(self.times))
        object.__setattr__(self, "outputs", several(self.outputs, "outputs", "name"))


def _span(times: Any) -> tuple[Any, Any]:
    """Start and end of a motion, two finite numbers."""
    # an array without dimensions is iterable by its type alone
    several_times = isinstance(times, Iterable) and getattr(times, "ndim", 1) > 0
    if isinstance(times, str) or not several_times or len(span := [*times]) != 2:
        raise DefinitionError(
            f"times = {quote(times)} is no pair of numbers; write times=(start, end)"
        )
    start, end = (real_text(x, "times") if isinstance(x, str) else x for x in span)
    for end_of_span in (start, end):
        real_number(end_of_span, "times")
    if start == end:
        raise DefinitionError(f"times = {quote(times)}: start and end are the same")
    return start, end
