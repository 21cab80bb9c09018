"""What a user says about many motions: quantities, scene, starts, times."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import sympy as sp

from voronec.algebra.symbols import is_symbolic_name, plain_name
from voronec.equations import VoronecEquations
from voronec.errors import DefinitionError, did_you_mean
from voronec.flow.vocabulary import Vocabulary, label, number
from voronec.scene import Scene

__all__ = ["Start", "grid_of", "quantity", "scene_of", "spread_starts"]

POINTS = 1001
"""How many points a scene's span is seen at."""
Start = Mapping[Any, Any]
"""Initial values of one motion, by symbol or name."""


def quantity(vocabulary: Vocabulary, key: Any, role: str = "output") -> tuple[str, sp.Expr]:
    """What a name, a symbol or an expression is called, and what it is.

    The expression holds coordinates, velocities, parameters, the time and invariants by their
    symbols.  ``DefinitionError`` for a name that the system does not know.
    """
    system = vocabulary.equations.system
    invariants = dict(zip(system.invariants, system.invariant_symbols, strict=True))
    known = {**vocabulary.claims, **invariants, **vocabulary.symbols}
    if isinstance(key, str):
        name = vocabulary.name(key, known, role)
        return name, sp.sympify(known[name])
    expr = sp.sympify(key)
    meaning = {}
    for symbol in sorted(expr.free_symbols, key=str):
        if str(symbol) not in known:
            raise DefinitionError(
                f"system '{system.name}': the {role} '{expr}' contains '{symbol}'"
                f"{did_you_mean(str(symbol), known)}"
            )
        meaning[symbol] = known[str(symbol)]
    name = plain_name(expr) if is_symbolic_name(expr) else label(expr)
    return name, expr.xreplace(meaning)


def scene_of(equations: VoronecEquations, scene: str | Scene | None, needed: bool) -> Scene | None:
    """The scene meant by a name; ``default`` where none is named and one is needed."""
    system = equations.system
    if scene is None and not needed:
        return None
    if isinstance(scene, Scene):
        return scene
    name = "default" if scene is None else scene
    if name not in system.scenes:
        raise DefinitionError(
            f"system '{system.name}' has no scene '{name}'{did_you_mean(name, system.scenes)}"
        )
    return system.scenes[name]


def spread_starts(
    starts: Mapping[Any, Any] | Sequence[Start] | None, parameters: Mapping[Any, Any]
) -> tuple[list[Start], dict[Any, Any]]:
    """One mapping for each start, and parameters whose arrays are as long as these are many."""
    columns = {k: np.asarray(x) for k, x in parameters.items() if np.ndim(x) > 0}
    lengths = {f"parameter '{k}'": x for k, x in columns.items()}
    given = starts if isinstance(starts, Mapping) else {}
    long = {k: np.asarray(x) for k, x in given.items() if np.ndim(x) > 0}
    lengths |= {f"start '{k}'": x for k, x in long.items()}
    for what, x in lengths.items():
        if x.ndim != 1 or not len(x):
            raise DefinitionError(f"{what}: give a number or a one-dimensional array")
    if starts is not None and not isinstance(starts, Mapping):
        if not all(isinstance(s, Mapping) for s in starts):
            raise DefinitionError(
                "starts: give arrays by name, {'x': [0, 1]}, or a list of mappings, [{'x': 0}]"
            )
        lengths["list of starts"] = np.zeros(len(starts))
    sizes = {what: len(x) for what, x in lengths.items()}
    count = max(sizes.values(), default=1)
    for what, size in sizes.items():
        if size != count or not size:
            raise DefinitionError(f"the {what} has {size} entries, where others have {count}")
    if starts is None:
        return [{} for _ in range(count)], {**parameters, **columns}
    if not isinstance(starts, Mapping):
        return list(starts), {**parameters, **columns}
    rows: list[Start] = [{k: (long[k][i].item() if k in long else x) for k, x in given.items()}
            for i in range(count)]  # fmt: skip
    return rows, {**parameters, **columns}


def grid_of(equations: VoronecEquations, scene: Scene | None, times: Any) -> np.ndarray:
    """The grid of times, by default over the span of the scene; it must be strictly monotonic."""
    if times is None:
        scene = scene or equations.system.scenes.get("default")
        if scene is None:
            raise DefinitionError(
                f"system '{equations.system.name}' has no scene to take the span from; give times"
            )
        start, end = (number(x, "the span's end") for x in scene.times)
        return np.linspace(start, end, POINTS)
    wrong = DefinitionError(
        "times must be a strictly monotonic, finite, one-dimensional array, such as "
        "numpy.linspace(0, 10, 1001)"
    )
    try:
        grid = np.atleast_1d(np.array(times, dtype=float))
    except (TypeError, ValueError):
        raise wrong from None
    steps = np.diff(grid)
    if grid.ndim != 1 or not grid.size or not np.isfinite(grid).all():
        raise wrong
    if not ((steps > 0).all() or (steps < 0).all()):
        raise wrong
    return grid
