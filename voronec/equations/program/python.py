"""Python source of a program, and its compiled functions.

They take doubles, or in any precision arrays of mpmath's numbers.
"""

from __future__ import annotations

import keyword
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import mpmath
import numpy as np

from voronec.algebra import numeric_functions as numeric
from voronec.equations.program.dialect import (
    FUNCTIONS,
    QUOTIENTS,
    Dialect,
    decimal,
    execute,
    fits,
    identifiers,
    lines,
    series,
    text,
)
from voronec.equations.program.parts import TITLES, Part, arguments_of, groups_of, parts_of
from voronec.equations.program.straight import Program
from voronec.errors import DefinitionError

Function = Callable[[Any, Any, Any], list[Any]]
"""``f(t, state, parameters)``."""

_ARGUMENTS = ("t", "state", "parameters", "inputs")
_NUMERIC = {name: word for name, (word, _) in QUOTIENTS.items()}
_NUMERIC |= {numeric.EXPM1: "expm1", numeric.LOG1P: "log1p"}
_NUMERIC |= {numeric.HYPOT: "hypot", numeric.SIZE: "fabs"}
_NUMERIC |= {numeric.CHOICE: "choice", numeric.CASE: "case"}
_CHOICES = {"numpy": "where", "jax.numpy": "where", "casadi": "if_else"}
_SIZES = {"numpy": "abs", "jax.numpy": "abs", "casadi": "fabs"}
"""Libraries where both ways of a choice are computed, and how they write it, and |x|."""
_COLUMNS = ("vertsplit", "vertcat", "horzcat", "array")
_HELPERS = ("expm1 where multiply if_else fabs exp sin cos sinh cosh hyp0f1 errstate").split()
_IN_DIGITS = {
    numeric.SINC: "hyp0f1(mpf(3)/2, -x*x/4)",
    numeric.SINC_SLOPE: "hyp0f1(mpf(5)/2, -x*x/4)/3",
}
"""Quotients by hypergeometric functions, which mpmath has in any precision."""
_NUMPY = {f: f.replace("a", "arc", 1) if f[0] == "a" else f for f in FUNCTIONS} | _NUMERIC
_NUMPY |= {"Abs": "absolute", numeric.SIZE: "absolute"}
_PLAIN = {f: f for f in FUNCTIONS} | {"Abs": "fabs"} | _NUMERIC


@dataclass(frozen=True)
class _Flavour:
    """A library to import from, and how numbers and functions are written for it."""

    library: str
    dialect: Dialect
    about: str


def _power(base: str, exponent: int) -> str:
    atomic = re.fullmatch(r"\w+(\([^()]*\))?", base)
    return f"{base}**{exponent}" if atomic else f"({base})**{exponent}"


def _double(words: dict[str, str]) -> Dialect:
    return Dialect(
        number=lambda p: str(p) if fits(p) else decimal(p),
        quotient=lambda p, q: f"{p}/{q}" if fits(p, q) else decimal(p, q),
        power=_power,
        pi="pi",
        words=words,
    )


_ARRAYS = _Flavour("numpy", _double(_NUMPY), "floats or arrays of one shape")
_FLOATS = _Flavour("math", _double(_PLAIN | {"power": "pow"}), "floats")
_DIGITS = _Flavour(
    "mpmath",
    Dialect(
        number=str,
        quotient=lambda p, q: f"mpf({p})/{q}",
        power=_power,
        pi="pi",
        words=_PLAIN,
    ),
    "mpmath numbers, at the precision in force",
)


_FOR_JAX = _Flavour(
    "jax.numpy",
    _double(_NUMPY),
    "JAX's numbers, in one-dimensional arrays; functions are traced, differentiated and mapped",
)
_MATRICES = _Flavour("casadi", _double(_PLAIN), "CasADi's numbers, SX, MX or DM, in columns")


def python_source(program: Program, slopes: bool = False) -> str:
    """Python source of ``rhs(t, state, parameters)``, on numpy.

    ``state`` holds coordinates, then velocities; its entries may be floats or arrays of one shape.
    Where the system has inputs, their values, and those of the rates that occur, are one argument
    more.  The time derivatives come back as a list in the same order.  Where the program has extra
    quantities, ``extras`` of the same arguments computes them; with ``slopes`` ``jacobian``
    computes the derivatives of the rates by state and inputs, as a list of rows.
    """
    return _module(program, _ARRAYS, alike=True, slopes=slopes)


def casadi_source(program: Program, slopes: bool = False) -> str:
    """Python source of the same functions on CasADi's expressions: columns go in, a column, and of
    the Jacobian a matrix, comes back."""
    return _module(program, _MATRICES, slopes=slopes)


def casadi_function(program: Program) -> Any:
    """``casadi.Function`` of ``t``, ``state``, ``parameters`` and ``inputs``, columns, with the
    result ``derivative``; empty columns stand where a system has no parameters or inputs."""
    try:
        import casadi
    except ImportError:
        raise DefinitionError(
            "CasADi is not installed; install it with: pip install 'voronec[control]'"
        ) from None
    namespace = execute(casadi_source(program), "program for CasADi", {})
    groups = {"state": program.state, "parameters": program.parameters, "inputs": program.inputs}
    given = {name: casadi.SX.sym(name, len(group)) for name, group in groups.items()}
    taken = list(given.values()) if program.inputs else list(given.values())[:-1]
    time = casadi.SX.sym("t")
    derivative = casadi.SX(namespace["rhs"](time, *taken))
    return casadi.Function(
        "rhs", [time, *given.values()], [derivative], ["t", *given], ["derivative"]
    )


def jax_source(program: Program, slopes: bool = False) -> str:
    """Python source of the same functions on JAX: one-dimensional arrays go in, an array, and of
    the Jacobian a matrix, comes back.  ``jit``, ``vmap``, ``grad`` and ``jacfwd`` take them; the
    module switches JAX to doubles."""
    return _module(program, _FOR_JAX, slopes=slopes)


def mpmath_source(program: Program) -> str:
    """Rates and extra quantities on mpmath numbers, at the precision in force when they are
    called."""
    return _module(program, _DIGITS)


def scalar_source(program: Program, extras: bool = False) -> str:
    """Python source for compilers: ``rhs(t, x0, x1, ..., parameters)``, one argument for each entry
    of the state, returns a tuple; so does ``extras``, which stands in its place where asked for."""
    words, dialect = {*_FLOATS.dialect.words.values()}, _FLOATS.dialect
    reserved = {*keyword.kwlist, *_ARGUMENTS, "rhs", "extras", "pi", "jit", *_HELPERS, *words}
    names = identifiers([*program.state, *program.parameters], reserved) | {program.time: "t"}
    title, block = ("extras", program.extras) if extras else ("rhs", program.derivative)
    names |= identifiers([n for n, _ in block.assignments], names.values())
    used = block.symbols
    rows = [f"def {title}({', '.join(['t', *(names[s] for s in program.state)])}, parameters):"]
    held = [(i, p) for i, p in enumerate(program.parameters) if p in used]
    rows += [f"    {names[p]} = parameters[{i}]" for i, p in held]
    rows += [f"    {name} = {value}" for name, value in lines(block, dialect, names)]
    results = [f"float({text(result, dialect, names)})" for result in block.results]
    body = "\n".join([*rows, f"    return ({', '.join(results)},)"]) + "\n"
    return _with_imports([*_helpers(body, "math"), body], _FLOATS)


@lru_cache(maxsize=256)  # a run asks several times for the same functions, of all its splits
def compile_program(program: Program, scalar: bool = False) -> tuple[Function, Function]:
    """The functions ``rhs`` and ``extras`` of ``(t, state, parameters)``, compiled.

    They work on arrays; with ``scalar`` on floats alone, several times faster, and a pole or a
    root of a negative number is then an exception.  Tracebacks show the generated lines.
    """
    source = _module(program, _FLOATS if scalar else _ARRAYS)
    namespace = execute(source, "program", {"sign": _sign})
    return namespace["rhs"], namespace.get("extras", _nothing)


def _sign(x: float) -> float:
    return float(x > 0) - float(x < 0)  # differences of the booleans of NumPy are refused


def _nothing(_t: Any, _state: Any, _parameters: Any) -> list[Any]:
    return []


def _module(program: Program, flavour: _Flavour, alike: bool = False, slopes: bool = False) -> str:
    dialect = flavour.dialect
    reserved = {*keyword.kwlist, *_ARGUMENTS, *TITLES, "mpf", "pi", *_HELPERS, *_COLUMNS}
    reserved |= {*dialect.words.values()}
    names = identifiers(arguments_of(program), reserved) | {program.time: "t"}
    parts = [_function(p, program, names, flavour, alike) for p in parts_of(program, slopes)]
    helpers = _helpers("".join(parts), flavour.library)
    return _header(program, flavour) + _with_imports([*helpers, *parts], flavour)


def _with_imports(parts: Sequence[str], flavour: _Flavour) -> str:
    """Functions, and before them the imports of what they call."""
    dialect, body = flavour.dialect, "\n\n".join(parts)
    words = {*dialect.words.values(), "mpf", *_HELPERS, *_COLUMNS}
    words -= {"choice", "case", *(word for word, _ in QUOTIENTS.values())}
    used = sorted(words & _called_names(body))
    used += ["pi"] if re.search(r"\bpi\b", body) else []
    used = [w for w in used if (flavour.library, w) != ("math", "sign")]
    imports = f"from {flavour.library} import {', '.join(used)}\n\n\n" if used else "\n"
    return (_DOUBLES if flavour is _FOR_JAX else "") + imports + body


_DOUBLES = 'from jax import config\n\nconfig.update("jax_enable_x64", True)\n'


def _called_names(body: str) -> set[str]:
    """The names that a source calls."""
    return {*re.findall(r"\w+(?=\()", body)}


def _helpers(body: str, library: str) -> list[str]:
    """The functions sin(x)/x and the like that are called, and the choice between sides."""
    rows, called = [], _called_names(body)
    for word, given, between in (("choice", "w, p, n", "(p + n)/2"), ("case", "w, p, z, n", "z")):
        if word in called:
            value = f"p if w > 0 else n if w < 0 else {between} if w == 0 else w"
            if choice := _CHOICES.get(library):
                value = f"{choice}(w == 0, {between}, w)"  # of no number it is none
                value = f"{choice}(w > 0, p, {choice}(w < 0, n, {value}))"
            value += "[()]" if library == "numpy" else ""  # a float is to stay one
            meaning = f"p for w > 0, n for w < 0, {between} for w = 0"
            rows.append(_helper(word, meaning, f"return {value}", given=given))
    for name, (word, above) in QUOTIENTS.items():
        if word in called:
            power, reach = numeric.QUOTIENTS[name].power, numeric.REACH
            quotient = f"({above})/({'*'.join('x' * power)})"
            steps = [f"return {_IN_DIGITS[name]}"]
            if library == "math":
                steps = [f"return {series(name)} if abs(x) < {reach} else {quotient}"]
            elif choice := _CHOICES.get(library):
                steps = [
                    f"near = {_SIZES[library]}(x) < {reach}",
                    f"y = {choice}(near, x, 0.0)",
                    f"far = ({above})/{choice}(near, 1.0, x)**{power}",
                    f"return {choice}(near, {series(name, 'y')}, far)",
                ]
            rows.append(_helper(word, quotient, *steps))
    return rows


def _helper(word: str, meaning: str, *rows: str, given: str = "x") -> str:
    body = "".join(f"    {row}\n" for row in rows)
    return f'def {word}({given}):\n    """{meaning}."""\n{body}'


def _header(program: Program, flavour: _Flavour) -> str:
    def list_names(symbols: Sequence[Any]) -> str:
        return _remark(f"[{', '.join(map(str, symbols))}]")

    return (
        '"""Right-hand side of a nonholonomic system, generated by voronec.\n\n'
        f"state      = {list_names(program.state)}: coordinates, then velocities\n"
        f"parameters = {list_names(program.parameters)}\n"
        + (f"inputs     = {list_names(program.inputs)}: at the time t\n" if program.inputs else "")
        + f"Entries are {flavour.about}.  Angles are in radians; all else is in the\n"
        "units of the parameters, which must be consistent.\n"
        '"""\n\n'
    )


def _remark(text: str) -> str:
    """A text that ends neither a line nor the string in which it stands."""
    printable = "".join(c if c.isprintable() else " " for c in text)
    return printable.replace("\\", "/").replace('"', "'")


def _function(
    part: Part, program: Program, names: dict[Any, str], flavour: _Flavour, alike: bool
) -> str:
    block, dialect = part.block, flavour.dialect
    columnar = flavour is _MATRICES
    names = names | identifiers([n for n, _ in block.assignments], names.values())
    groups = groups_of(program)
    given = ", ".join(["t", *(argument for argument, _ in groups)])
    rows = [f"def {part.title}({given}):", f'    """{_remark(part.purpose)}"""']
    for argument, group in groups:
        if group:
            unpacked = ", ".join(names[s] for s in group) + ("," if len(group) == 1 else "")
            source = f"vertsplit({argument})" if columnar else argument
            if alike:  # floats of Python stop where they divide by zero or overflow
                source = f"(multiply(1.0, e) for e in {argument})"
            rows.append(f"    {unpacked} = {source}")
    if alike and program.time in block.symbols:
        rows.append("    t = multiply(1.0, t)")
    rows += [f"    {name} = {value}" for name, value in lines(block, dialect, names)]
    values = [text(result, dialect, names) for result in block.results]
    if alike and program.state:  # of the shape of the others
        moving, first = block.movers(program.state), names[program.state[0]]
        still = [not result.free_symbols & moving for result in block.results]
        values = [f"{v} + 0*{first}" if s else v for v, s in zip(values, still, strict=True)]
    opening, closing = _BRACKETS.get(flavour.library, ("[", "]"))
    rows.append(f"    return {opening}")
    ends = ("horzcat(", ")") if columnar else ("[", "]")
    for value, meaning in part.write(values, *ends):
        rows.append(f"        {value},  # {_remark(meaning)}")
    body = "\n".join([*rows, f"    {closing}"]) + "\n"
    silent = flavour is _ARRAYS and not _called_names(body).isdisjoint(("choice", "case"))
    return _SILENCE + body if silent else body


_BRACKETS = {"casadi": ("vertcat(", ")"), "jax.numpy": ("array([", "])")}
_SILENCE = '@errstate(all="ignore")  # cases that are not in force need have no value\n'
SPARE = 16
"""Bits beyond those of the numbers that come in."""


def precision(numbers: Any) -> int:
    """How many bits the longest of some numbers has, at least those of a double."""
    if isinstance(numbers, np.ndarray) and numbers.dtype != object:
        return 53
    flat = np.ravel(np.asarray(numbers, dtype=object))
    return max([53, *(x._mpf_[3] for x in flat if isinstance(x, mpmath.mpf))])


@lru_cache(
    maxsize=64
)  # which way a motion goes at a switching surface is asked of the same few programs
def compiled_digits(program: Program) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """``rhs`` and ``extras`` of ``(t, state, parameters)``, for mpmath's numbers or arrays of them.

    They compute with the precision of time and state, and with that in force where it is finer.
    """
    namespace = execute(mpmath_source(program), "digits", {})
    extras = namespace.get("extras", _nothing)
    return (
        _careful(namespace["rhs"], len(program.derivative.results)),
        _careful(extras, len(program.extras.results)),
    )


def _careful(function: Function, count: int) -> Function:
    """A function with so many results, in the precision of what comes in; at one instant after the
    other, since a number of mpmath's before an array writes the array out before it gives way."""

    def at(t: Any, state: Any, parameters: Any) -> list[Any]:
        return [_real(x) for x in function(mpmath.mpf(t), state, parameters)]

    def compute(t: Any, state: Any, parameters: Any) -> list[Any]:
        columns = [np.asarray(x, dtype=object) for x in (t, *state, *parameters)]
        end = 1 + len(state)  # of inputs the parameters hold values at each instant
        # short numbers, such as 1, say nothing of the precision that they are meant with
        bits = max(precision(np.concatenate([*map(np.ravel, columns[:end])])), mpmath.mp.prec)
        with mpmath.workprec(bits + SPARE):
            if not any(x.ndim for x in columns):
                return at(t, state, parameters)
            shape = np.broadcast_shapes(*(x.shape for x in columns))
            moments = list(zip(*(np.broadcast_to(x, shape) for x in columns), strict=True))
            table = np.empty((len(moments), count), dtype=object)
            for row, values in zip(table, moments, strict=True):
                row[:] = at(values[0], values[1:end], values[end:])
            return list(table.T)

    return compute


def _real(number: Any) -> Any:
    """A result as one of mpmath's real numbers: constants may be integers, and beyond the edge of a
    root or an inverse function mpmath goes on with complex numbers."""
    if isinstance(number, int):
        return mpmath.mpf(number)
    return mpmath.nan if isinstance(number, mpmath.mpc) else number
