"""Arguments of public functions, of the right kind before anything is done with them."""

from __future__ import annotations

import inspect
import math
import numbers
import os
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from fractions import Fraction
from functools import wraps
from typing import Any, TypeVar, cast

from voronec.errors import DefinitionError, VoronecError, did_you_mean, quote

Function = TypeVar("Function", bound=Callable[..., Any])
Class = TypeVar("Class", bound=type)


@dataclass(frozen=True)
class Kind:
    """A kind of argument in words, and whether something is of it; ``None`` is where it may be."""

    words: str
    fits: Callable[[Any], bool]
    optional: bool = False

    def holds(self, value: Any) -> bool:
        """Whether a value is of this kind; somebody's own class may fail to say so."""
        try:
            return (value is None and self.optional) or bool(self.fits(value))
        except Exception:
            return False


MOST_DIGITS = 10_000
"""Digits of accelerations and reactions: more is work without end."""


def _is_count(value: Any) -> bool:
    # SymPy's integers are registered as such
    return (
        not isinstance(value, bool)
        and isinstance(value, numbers.Integral)
        and abs(int(value)) < 2**63
    )


HIGH = 1e6
"""Powers of higher exponents are no doubles, unless their bases are next to one."""


def in_float(value: Any) -> float:
    """A real number as the double that integrators take: of Python, numpy or SymPy, or a text such
    as ``1e-10``; ``TypeError`` for any other, ``OverflowError`` beyond doubles."""
    import sympy as sp  # names of systems are listed without it

    from voronec.algebra.text import exact_number

    if isinstance(value, str):
        value = exact_number(value, "a number")
    known = isinstance(value, int | float | Fraction) or type(value).__module__ == "numpy"
    exact = isinstance(value, sp.Expr) and bool(value.is_number) and bool(value.is_real)
    if isinstance(value, bool | complex) or not (known or exact):
        raise TypeError
    for node in sp.postorder_traversal(value) if exact and value.args else ():
        # SymPy works out all digits of exp(exp(exp(9)))
        if isinstance(node, sp.Pow | sp.exp) and abs(float(node.as_base_exp()[1])) > HIGH:
            raise OverflowError
    return float(value)


TEXT = Kind("a text", lambda x: isinstance(x, str))
FLAG = Kind("True or False", lambda x: type(x).__name__ in ("bool", "bool_"))
COUNT = Kind("a whole number", _is_count)
REAL = Kind("a finite real number", lambda x: math.isfinite(in_float(x)))
TOLERANCE = Kind("a number between 0 and 1, such as 1e-13", lambda x: 0 < in_float(x) < 1)
OPTIONAL_TEXT, OPTIONAL_COUNT, OPTIONAL_REAL = (
    replace(kind, optional=True) for kind in (TEXT, COUNT, REAL)
)
CALLABLE = Kind("a function", callable, optional=True)
VALUES = Kind("a mapping of values by name", lambda x: isinstance(x, Mapping), optional=True)
POINT = Kind("a mapping of values by name", lambda x: isinstance(x, Mapping))
SEVERAL = Kind(
    "a tuple",
    lambda x: (
        (hasattr(type(x), "free_symbols") and not isinstance(x, type))
        or (not isinstance(x, Mapping | bytes | bytearray) and iter(x) is not None)
    ),
)
SEQUENCE = Kind(
    "a sequence",
    lambda x: not isinstance(x, Mapping | str | bytes | bytearray) and iter(x) is not None,
)
MATRIX = Kind("a square SymPy matrix", lambda x: len({*x.shape}) == 1 and hasattr(x, "rows"))
PATH = Kind("the name of a file", lambda x: isinstance(x, str | os.PathLike) and "\0" not in str(x))


def instance(*classes: type) -> Kind:
    """Values of some classes."""
    words = " or ".join(f"a {cls.__name__}" for cls in classes)
    return Kind(words, lambda x: isinstance(x, classes))


def require(place: str, name: str, value: Any, kind: Kind) -> None:
    """Refuse a value that is not of a kind; ``place`` is the function or the object."""
    if not kind.holds(value):
        raise DefinitionError(f"{place}: {name} = {quote(value)} is not {kind.words}; give one")


def require_digits(place: str, digits: Any) -> None:
    """Refuse what is no number of digits that can be worked out."""
    if not isinstance(digits, int) or isinstance(digits, bool) or not 1 <= digits <= MOST_DIGITS:
        raise DefinitionError(
            f"{place}: digits = {quote(digits)}; give a whole number from 1 to {MOST_DIGITS}"
        )


def callback(place: str, name: str, function: Any) -> Callable[..., Any] | None:
    """A user's function, or None, whose errors say that they are its own."""
    require(place, name, function, CALLABLE)
    if function is None:
        return None

    def call(*args: Any) -> Any:
        try:
            return function(*args)
        except Exception as error:
            told = f"{type(error).__name__}: {error}"
            raise DefinitionError(
                f"{place}: the function given as {name} raised {quote(told)}; mend it"
            ) from error

    return call


def require_arguments(place: str, given: Iterable[str], known: Collection[str]) -> None:
    """Refuse an argument that a function does not have: as Python does, but with the nearest."""
    for name in given:
        if name not in known:
            hint = did_you_mean(name, known)
            raise TypeError(f"{place}() got an unexpected argument '{name}'{hint}")


@contextmanager
def _shallow(place: str) -> Iterator[None]:
    """Refuse what is nested more deeply than Python, or SymPy in it, can follow."""
    try:
        yield
    except RecursionError:
        raise DefinitionError(
            f"{place}: an expression is nested too deeply to be read; give its parts names of "
            "their own, or write it shorter"
        ) from None


def takes_fields(cls: Class) -> Class:
    """Let a dataclass refuse arguments that are none of its fields, with those that are near."""
    make, known = cls.__dict__["__init__"], {f.name for f in fields(cls) if f.init}

    @wraps(make)
    def check(self: Any, *args: Any, **options: Any) -> None:
        require_arguments(cls.__name__, options, known)
        with _shallow(cls.__name__):
            make(self, *args, **options)

    setattr(cls, make.__name__, check)
    return cls


def accepts(**kinds: Kind) -> Callable[[Function], Function]:
    """Let a function begin only with arguments that it has, where these are of these kinds."""

    def guard(function: Function) -> Function:
        parameters = inspect.signature(function).parameters
        places = {name: i for i, name in enumerate(parameters)}
        is_open = any(p.kind is p.VAR_KEYWORD for p in parameters.values())

        @wraps(function)
        def check(*args: Any, **options: Any) -> Any:
            require_arguments(function.__name__, () if is_open else options, places)
            given = list(args)
            for name, kind in kinds.items():
                named = name in options
                if not named and places[name] >= len(given):
                    continue
                value = options[name] if named else given[places[name]]
                require(function.__name__, name, value, kind)
                if kind in (REAL, TOLERANCE, OPTIONAL_REAL) and value is not None:
                    value = in_float(value)
                if kind is CALLABLE:
                    value = callback(function.__name__, name, value)
                if named:
                    options[name] = value
                else:
                    given[places[name]] = value
            with _shallow(function.__name__):
                return function(*given, **options)

        return cast(Function, check)

    return guard


def reads(advice: str) -> Callable[[Function], Function]:
    """Let a function that only puts names into words or strokes refuse what it cannot read: in one
    line, with what to give."""

    def guard(function: Function) -> Function:
        @wraps(function)
        def check(*args: Any, **options: Any) -> Any:
            try:
                return function(*args, **options)
            except VoronecError:
                raise
            except (TypeError, ValueError, AttributeError, LookupError, RuntimeError) as error:
                raise DefinitionError(f"{function.__name__}: give {advice} ({error})") from error

        return cast(Function, check)

    return guard
