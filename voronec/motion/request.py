"""What a user says of motions: scene, outputs, times, parameters, starts."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np
import sympy as sp

from voronec.algebra.arguments import SEQUENCE
from voronec.algebra.symbols import is_symbolic_name, plain_name
from voronec.algebra.text import as_expression
from voronec.declaration.reading import doubles, quote, several
from voronec.declaration.scene import Scene
from voronec.declaration.system import System
from voronec.errors import DefinitionError, did_you_mean
from voronec.motion.initial_state import name_values
from voronec.motion.vocabulary import Vocabulary, label, number

__all__ = ["StartData", "Values", "grid_of", "outputs_of", "quantity", "scene_of", "spread_starts"]

POINTS = 1001
"""How many points a scene's span is seen at."""
Values = Mapping[Any, Any]
"""Values of one motion, by symbol or name."""


@dataclass(frozen=True)
class StartData:
    """What is said of one start, by plain name: ``parameters``, and initial values, those of the
    scene (``scene_initial``) and those over them (``initial``)."""

    parameters: Mapping[str, Any]
    scene_initial: Mapping[str, Any]
    initial: Mapping[str, Any]

    @classmethod
    def of(
        cls,
        vocabulary: Vocabulary,
        scene: Scene | None,
        parameters: Values | None,
        initial: Values | None,
    ) -> StartData:
        """Scene and arguments put together; ``DefinitionError`` for names nobody knows."""
        return cls(
            parameters={
                **name_values(vocabulary, scene.parameters if scene else {}, "parameter"),
                **name_values(vocabulary, parameters or {}, "parameter"),
            },
            scene_initial=name_values(vocabulary, scene.initial if scene else {}, "initial value"),
            initial=name_values(vocabulary, initial or {}, "initial value"),
        )

    @property
    def spelling(self) -> Hashable | None:
        """Equal for data that are the same to the last bit; None where that is not to be told."""
        parts = (self.parameters, self.scene_initial, self.initial)
        spelled = [(name, _spelling(x)) for part in parts for name, x in (*part.items(), ("", ""))]
        return None if any(x is None for _, x in spelled) else tuple(spelled)


def _spelling(value: Any) -> Hashable | None:
    """A number or a formula, told from all others; None for what may change, or is none."""
    if type(value) in (int, float, str, np.float64):
        return type(value).__name__, repr(value)  # zeros differ in sign
    # equal numbers of SymPy may differ in their precision
    exact = isinstance(value, sp.Expr) and not value.has(sp.Float)
    return (type(value).__name__, value) if exact else None


def quantity(vocabulary: Vocabulary, key: Any, role: str = "output") -> tuple[str, sp.Expr]:
    """What a name, a symbol or an expression is called, and what it is.

    The expression holds coordinates, velocities, parameters, the time and invariants by their
    symbols.  ``DefinitionError`` for a name that the system does not know.
    """
    system = vocabulary.equations.system
    known = vocabulary.known
    if isinstance(key, str):
        name = vocabulary.name(key, known, role)
        return name, as_expression(known[name])
    given = as_expression(key)
    expr = given.xreplace(vocabulary.inputs)
    meaning = {}
    for symbol in sorted(expr.free_symbols, key=str):
        if str(symbol) not in known:
            raise DefinitionError(
                f"system '{system.name}': the {role} '{expr}' contains '{symbol}'"
                f"{did_you_mean(str(symbol), known)}"
            )
        meaning[symbol] = known[str(symbol)]
    name = plain_name(given) if is_symbolic_name(given) else label(given)
    return name, expr.xreplace(meaning)


def scene_of(
    system: System, scene: str | Scene | None, needed: bool, instead: str = "initial={...}"
) -> Scene | None:
    """The scene meant by a name; where none is named and one is needed, the one called ``default``.

    ``DefinitionError`` where there is none; ``instead`` is what would do in place of a scene.
    """
    if isinstance(scene, Scene):
        return scene
    if scene is not None and not isinstance(scene, str):
        raise DefinitionError(
            f"system '{system.name}': scene = {quote(scene)} is no scene; give its name, or a "
            "voronec.Scene"
        )
    if scene is None:
        if not needed:
            return None
        if "default" not in system.scenes:
            raise DefinitionError(
                f"system '{system.name}' has no scene 'default'; give {instead}, or scene= one of "
                f"its scenes ({', '.join(system.scenes) or 'there are none'})"
            )
        return system.scenes["default"]
    if scene not in system.scenes:
        raise DefinitionError(
            f"system '{system.name}' has no scene '{scene}'{did_you_mean(scene, system.scenes)}"
        )
    return system.scenes[scene]


def outputs_of(scene: Scene | None, outputs: Any) -> tuple[Any, ...]:
    """The outputs asked for, one alone among them; by default those of the scene."""
    asked = several(outputs, "outputs", "name")
    return asked or (scene.outputs if scene else ())


def spread_starts(
    starts: Values | Sequence[Values] | None, parameters: Values
) -> tuple[list[Values], dict[Any, Any]]:
    """One mapping for each start, and parameters whose arrays are as long as these are many."""
    columns = _columns(parameters, "parameter")
    lengths = {f"parameter '{k}'": x for k, x in columns.items()}
    given = starts if isinstance(starts, Mapping) else {}
    long = _columns(given, "start")
    lengths |= {f"start '{k}'": x for k, x in long.items()}
    if starts is not None and not isinstance(starts, Mapping):
        if not SEQUENCE.holds(starts) or not all(isinstance(s, Mapping) for s in starts):
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
    rows: list[Values] = [{k: (long[k][i].item() if k in long else x) for k, x in given.items()}
            for i in range(count)]  # fmt: skip
    return rows, {**parameters, **columns}


def _columns(given: Values, role: str) -> dict[Any, np.ndarray]:
    """The arrays among some values, in numbers."""
    found = {}
    for key, values in given.items():
        place = f"{role} '{quote(key)}'"
        try:
            column = np.asarray(values)
        except (TypeError, ValueError):  # rows of several lengths
            column = np.empty((0, 0))
        if column.ndim == 0:
            continue
        if column.ndim != 1 or not len(column):
            raise DefinitionError(f"{place}: give a number or a one-dimensional array")
        if column.dtype.kind not in "fiu":
            column = np.array([number(x, place) for x in column])
        found[key] = column
    return found


def grid_of(system: System, scene: Scene | None, times: Any) -> np.ndarray:
    """The grid of times, by default over the span of the scene; it must be strictly monotonic.

    One number is the end of a span that begins where the scene does, or at zero.
    """
    known = scene or system.scenes.get("default")
    if times is None:
        return _span(system, known)
    wrong = DefinitionError(
        "times must be a strictly monotonic, finite, one-dimensional array, such as "
        "numpy.linspace(0, 10, 1001), or one number, the end of a span of some length"
    )
    try:
        grid = doubles(times, "times")
    except DefinitionError:
        raise wrong from None
    if grid.ndim == 0 and np.isfinite(grid):
        begin = 0.0 if known is None else number(known.times[0], "the span's end")
        grid = _even(begin, float(grid))
    if grid.ndim != 1 or grid.size == 0 or not np.isfinite(grid).all():
        raise wrong
    _require_span(float(grid[0]), float(grid[-1]))
    steps = np.diff(grid)
    if not ((steps > 0).all() or (steps < 0).all()):
        raise wrong
    return grid


def _span(system: System, scene: Scene | None) -> np.ndarray:
    if scene is None:
        raise DefinitionError(
            f"system '{system.name}' has no scene to take the span from; give times"
        )
    start, end = (number(x, "the span's end") for x in scene.times)
    return _even(start, end)


def _even(start: float, end: float) -> np.ndarray:
    _require_span(start, end)
    return np.linspace(start, end, POINTS)


def _require_span(start: float, end: float) -> None:
    if not isfinite(end - start):
        raise DefinitionError("times have a span that no double holds; use another unit of time")
