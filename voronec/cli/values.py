"""What is typed on a command line: tolerance, times, and NAME=VALUE for parameters and starts."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from voronec.system import System

__all__ = ["finite", "first_scene", "instants", "pair", "split_values", "tolerance"]

INSTANTS = 1001
MOST_INSTANTS = 10_000_000


def finite(text: str, place: str) -> float:
    """A number, which may be a formula; ``DefinitionError`` names the place."""
    from voronec.algebra.text import exact_number

    return float(exact_number(text, place))


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
    if not count.isdecimal() or not 2 <= int(count) <= MOST_INSTANTS:
        raise DefinitionError(f"--times {text}: give from 2 to {MOST_INSTANTS} instants")
    if start == end:
        raise DefinitionError(f"--times {text}: start and end are the same")
    return np.linspace(start, end, int(count))


def first_scene(system: System) -> str | None:
    """The scene where nobody names one: ``default``, else the first; None where there is none."""
    return "default" if "default" in system.scenes else next(iter(system.scenes), None)


def pair(text: str) -> tuple[str, Any]:
    """NAME=VALUE, the value a number or a formula of numbers, kept exactly."""
    from voronec.algebra.text import exact_number

    name, equals, value = (part.strip() for part in text.partition("="))
    if not equals or not name:
        raise DefinitionError(f"--set {text}: give NAME=VALUE, such as m=2.5 or a=1/3")
    return name, exact_number(value, f"--set {name}")


def split_values(
    system: System, pairs: Iterable[tuple[str, Any]]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """The values of parameters, and those of coordinates and velocities at the start."""
    from voronec.algebra.symbols import plain_name
    from voronec.catalogue import unknown

    constants = {p.name for p in system.parameters}
    movers = {plain_name(s) for s in system.known_symbols()} - constants - {"t"}
    parameters: dict[str, Any] = {}
    initial: dict[str, Any] = {}
    for name, value in pairs:
        if name not in constants | movers:
            kind = "parameter, coordinate or velocity"
            raise DefinitionError(
                f"system '{system.name}': {unknown(kind, name, constants | movers)}"
            )
        (parameters if name in constants else initial)[name] = value
    return parameters, initial
