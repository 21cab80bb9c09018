"""A point at which equations are evaluated, by plain names: what engine and referee both read."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Set
from typing import Any

import sympy as sp

from voronec.algebra.symbols import plain_name
from voronec.declaration.reading import quote
from voronec.declaration.system import System
from voronec.errors import DefinitionError


def named_point(
    system: System,
    point: Mapping[Any, Any],
    others: Set[str],
    number: Callable[[System, str, Any], Any],
) -> dict[str, Any]:
    """A point by plain names, completed by the parameters' default values.

    Keys are symbols or names, of the system or among ``others``; ``number`` takes the system, a
    name and its value, and returns it as it is to be used.  Raises ``DefinitionError`` for a name
    that the system lacks, for one that is named twice or has no value, and for what ``number``
    refuses.
    """
    if not isinstance(point, Mapping):
        raise DefinitionError(
            f"system '{system.name}': the point is '{quote(point)}'; give {{symbol: number, ...}}"
        )
    constants = [p for p in system.parameters if isinstance(p.symbol, sp.Symbol)]
    needed = [*system.coordinates, *system.velocities, *(p.symbol for p in constants)]
    names = [plain_name(s) for s in needed]
    given: dict[str, Any] = {}
    for key, value in point.items():
        name = _name(system, key)
        if name not in names and name not in others:
            raise DefinitionError(
                f"'{name}' is not a coordinate, velocity or parameter of system '{system.name}'; "
                f"it has {', '.join(names)}"
            )
        if name in given:
            raise DefinitionError(
                f"system '{system.name}': the point gives '{name}' twice; give it once"
            )
        given[name] = number(system, name, value)
    for parameter in constants:
        if parameter.value is not None and parameter.name not in given:
            given[parameter.name] = number(system, parameter.name, parameter.value)
    missing = [name for name in names if name not in given]
    if missing:
        raise DefinitionError(
            f"the point gives no value for {', '.join(repr(m) for m in missing)} of system "
            f"'{system.name}'; add it to the point"
        )
    return given


def _name(system: System, key: Any) -> str:
    if isinstance(key, str):
        return key
    try:
        return plain_name(key)
    except DefinitionError:
        raise DefinitionError(
            f"system '{system.name}': the point has the key '{quote(key)}', which is neither a "
            "symbol nor a name; give {symbol: number, ...}"
        ) from None
