"""What is typed on a command line: tolerance, times, NAME=VALUE, and outputs."""

from __future__ import annotations

import math
import re
from argparse import Namespace
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from voronec.algebra.text import name_or_formula
from voronec.cli.subject import resolve
from voronec.errors import DefinitionError, quote

if TYPE_CHECKING:
    from voronec.declaration.system import System

BETWEEN = r",(?![^()]*\))"
"""Commas that are not between the arguments of a function."""


def outputs_of(text: str | None) -> tuple[Any, ...]:
    """Names and expressions separated by commas; empty where there are none."""
    if text is None:
        return ()
    parts = [part.strip() for part in re.split(BETWEEN, text)]
    if not all(parts):
        raise DefinitionError(f"--outputs '{text}': separate names by commas, as in u,v")
    return tuple(name_or_formula(part, "--outputs") for part in parts)


INSTANTS = 1001
"""Of a run whose times give no number: smooth on any screen."""
MOST_INSTANTS = 10_000_000
"""Some gigabytes of states; more are a slip of the pen."""


def finite(text: str, place: str) -> float:
    """A number, which may be a formula; ``DefinitionError`` names the place."""
    from voronec.algebra.text import exact_number

    exact = exact_number(text, place)
    number = float(exact)
    if number == 0 and exact.is_zero is False:
        raise DefinitionError(
            f"{place}: '{quote(text)}' is too small for a double; give a larger one"
        )
    return number


def interval(text: str, place: str, form: str = "A:B, such as 0:10") -> tuple[float, float]:
    """The two ends of A:B; ``form`` says in an error what is to be given."""
    ends = text.split(":")
    if len(ends) != 2:
        raise DefinitionError(f"{place} {text}: give {form}")
    low, high = (finite(end, place) for end in ends)
    return low, high


def names_of(text: str | None) -> tuple[str, ...]:
    """Names and expressions separated by commas, as texts."""
    return tuple(map(str, outputs_of(text)))


def tolerance(text: str | None) -> float:
    """The value of ``--tol``; 1e-13 unless told."""
    if text is None:
        return 1e-13
    tol = finite(text, "--tol")
    if not 0 < tol < 1:
        raise DefinitionError(f"--tol {text}: give a number between 0 and 1, such as 1e-12")
    return tol


def instants(text: str | None) -> Any:
    """The grid that ``[START:]END[:N]`` means; None where nothing is said."""
    if text is None:
        return None
    import numpy as np

    parts = text.split(":")
    if len(parts) > 3:
        raise DefinitionError(f"--times {text}: give [START:]END[:N], such as 0:20:501")
    if len(parts) == 1:
        parts = ["0", *parts]
    start, end = (finite(part, "--times") for part in parts[:2])
    count = parts[2] if len(parts) == 3 else str(INSTANTS)
    if not count.isdecimal():
        raise DefinitionError(f"--times {text}: '{count}' is not a number of instants, such as 501")
    if not 2 <= int(count) <= MOST_INSTANTS:
        raise DefinitionError(f"--times {text}: give from 2 to {MOST_INSTANTS} instants")
    if start == end:
        raise DefinitionError(f"--times {text}: start and end are the same")
    if not math.isfinite(end - start):
        raise DefinitionError(f"--times {text}: no double holds this span; use another unit")
    return np.linspace(start, end, int(count))


def name_and_value(text: str, option: str, form: str) -> tuple[str, str]:
    """The two sides of NAME=VALUE; ``form`` says in an error what is to be given."""
    name, equals, value = (part.strip() for part in text.partition("="))
    if not equals or not name:
        raise DefinitionError(f"{option} {text}: give {form}")
    return name, value


def pair(text: str) -> tuple[str, Any]:
    """NAME=VALUE, the value a number or a formula of numbers, kept exactly."""
    from voronec.algebra.text import exact_number

    name, value = name_and_value(text, "--set", "NAME=VALUE, such as m=2.5 or a=1/3")
    return name, exact_number(value, f"--set {name}")


def split_values(
    system: System, pairs: Iterable[tuple[str, Any]]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """The values of parameters, and those of coordinates and velocities at the start."""
    from voronec.algebra.symbols import plain_name
    from voronec.declaration.catalogue import unknown

    driven = {plain_name(u) + rate for u in system.inputs for rate in ("", "dot")}
    constants = {*system.parameter_names} - driven
    movers = {plain_name(s) for s in system.known_symbols()} - constants - driven - {"t"}
    parameters: dict[str, Any] = {}
    initial: dict[str, Any] = {}
    for name, value in pairs:
        if name in driven:
            raise DefinitionError(
                f"--set {name}: it is an input of system '{system.name}'; give --input {name}=VALUE"
            )
        if name not in constants | movers:
            kind = "parameter, coordinate or velocity"
            raise DefinitionError(
                f"system '{system.name}': {unknown(kind, name, constants | movers)}"
            )
        (parameters if name in constants else initial)[name] = value
    return parameters, initial


def motion_of(arguments: Namespace) -> tuple[System, dict[str, Any]]:
    """The system, and which motion of it the options ``--scene``, ``--set`` and ``--input`` mean,
    as arguments of ``integrate``."""
    pairs, inputs = [pair(text) for text in arguments.set], input_values(arguments.input)
    system, _ = resolve(arguments.system)
    parameters, initial = split_values(system, pairs)
    scene = arguments.scene or system.first_scene
    return system, {
        "scene": scene, "parameters": parameters, "initial": initial, "inputs": inputs,
    }  # fmt: skip


def input_values(texts: Iterable[str]) -> dict[str, Any]:
    """The values of inputs in NAME=VALUE: formulas, as text, and tables out of files."""
    inputs: dict[str, Any] = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not equals or not name or not value:
            raise DefinitionError(f"--input {text}: give NAME=VALUE, such as u=sin(t) or u=u.csv")
        if name in inputs:
            raise DefinitionError(f"--input {text}: '{name}' is given twice; give it once")
        path, colon, kind = value.rpartition(":")
        path, kind = (path, kind) if colon and path.endswith(".csv") else (value, "linear")
        inputs[name] = _table(path, kind, f"--input {name}") if path.endswith(".csv") else value
    return inputs


def _table(path: str, kind: str, place: str) -> Any:
    """The table that a file holds."""
    from voronec.declaration.table_file import read_table
    from voronec.motion.inputs import Table

    times, values = read_table(Path(path), place)
    try:
        return Table(times, values, kind)
    except DefinitionError as error:
        raise DefinitionError(f"{place}: {error}") from None
