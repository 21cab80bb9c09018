"""Where a motion starts: parameters, and an initial state on the constraints.

Data off the constraints are refused with their residual, or, on request, moved onto them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy as sp

from voronec.algebra.symbols import names_in, plain_name
from voronec.declaration.reading import fixed_mapping, quote, texts_read
from voronec.declaration.system import require_possible
from voronec.equations.program import Program, compile_program
from voronec.errors import DefinitionError
from voronec.motion.velocity_conditions import CONSISTENT, Rates, changes, meet_conditions
from voronec.motion.vocabulary import Vocabulary, number

if TYPE_CHECKING:
    from voronec.equations.derivation import FirstOrderForm

__all__ = [
    "Relations",
    "Start",
    "coordinates_of",
    "name_values",
    "numbers_of",
    "parameter_values",
    "start_of",
]


STEPS = 500
"""How many steps towards the nearest point are tried."""
DAMPINGS = (1.0, 0.3, 0.1)
"""Parts of a full step: where full steps run back and forth, shorter ones do not."""
STILL = 1e-14
"""A step below this part of the coordinates' size is the last."""
DEPENDENT = 1e-10
"""Gradients whose singular values are below this part of the largest count as dependent."""


@dataclass(frozen=True)
class Relations:
    """r(q) = 0 at given parameters and time: ``evaluate(q)`` gives r (m,) and dr/dq (m, n)."""

    evaluate: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]

    @classmethod
    def of(cls, form: FirstOrderForm, parameters: Mapping[str, float], time: float) -> Relations:
        """The relations of a first-order form."""
        m, n = len(form.relations), len(form.coordinates)
        # the equations of motion play no part: a form that stands still is compiled at once
        symbols, extras = _residuals_and_slopes(replace(
            form, velocities=(), rates=(0,) * n, mass=(), force=(), definitions=(), dependent=(),
            stages=(),
        ))  # fmt: skip
        values = [np.float64(parameters.get(str(p), np.nan)) for p in symbols]

        def evaluate(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            with np.errstate(all="ignore"):
                flat: list[Any] = extras(np.float64(time), list(q), values)
            numbers = np.array(flat, dtype=float)
            return numbers[:m], numbers[m:].reshape(m, n)

        return cls(evaluate)

    def residuals(self, q: np.ndarray) -> np.ndarray:
        """What the relations leave at q, which ought to vanish."""
        return self.evaluate(q)[0]

    def nearest(self, q: np.ndarray, accuracy: float) -> np.ndarray | None:
        """The point on the relations at the least distance from q; None where none is found.

        Gauss and Newton: from p the next point is the nearest to q on the relations made linear
        at p.  Where that stands still, q - p is normal to the relations.
        """
        for damping in DAMPINGS:
            found = self._iterate(q, damping)
            if found is not None and np.abs(self.residuals(found)).max() < accuracy:
                return found
        return None

    def _iterate(self, q: np.ndarray, damping: float) -> np.ndarray | None:
        p = q
        for _ in range(STEPS):
            off, slopes = self.evaluate(p)
            if not (np.isfinite(off).all() and np.isfinite(slopes).all()):
                return None
            away = q - p
            normal = np.linalg.lstsq(slopes, off + slopes @ away, rcond=DEPENDENT)[0]
            step = damping * (away - normal)
            p = p + step
            if np.linalg.norm(step) <= STILL * (1.0 + np.linalg.norm(p)):
                return p
        return None


@lru_cache(maxsize=16)  # each of many starts asks for it
def _residuals_and_slopes(form: FirstOrderForm) -> tuple[tuple[Any, ...], Callable[..., Any]]:
    """The parameters of a function for the relations and then their slopes, row by row; and it."""
    slopes = [r.diff(q) for r in form.relations for q in form.coordinates]
    program = Program.of(form, {str(i): e for i, e in enumerate([*form.relations, *slopes])})
    return program.parameters, compile_program(program)[1]


def name_values(vocabulary: Vocabulary, given: Mapping[Any, Any], role: str) -> dict[str, Any]:
    """Values by plain name; ``role`` is ``parameter`` or ``initial value``."""
    system = vocabulary.equations.system
    if role == "parameter":
        among = [p.name for p in system.parameters]
    else:
        constants = {p.name for p in system.parameters}
        among = [name for name in vocabulary.symbols if name not in constants | {"t"}]
    result: dict[str, Any] = {}
    argument = "parameters" if role == "parameter" else "initial"
    for key, value in texts_read(fixed_mapping(given, argument, "name: value"), role).items():
        name = vocabulary.name(key, among, role)
        if name in result:
            raise DefinitionError(f"system '{system.name}': the {role} '{name}' is given twice")
        result[name] = value
    return result


def parameter_values(
    vocabulary: Vocabulary, given: Mapping[str, Any], needed: set[str]
) -> dict[str, float]:
    """Every parameter's value: as given, else its default; checked against its range.

    One that is not among ``needed`` may lack a value and is left out.
    """
    system = vocabulary.equations.system
    values: dict[str, float] = {}
    missing = []
    for parameter in system.parameters:
        value = given.get(parameter.name, parameter.value)
        if value is None:
            missing += [parameter.name] if parameter.name in needed else []
            continue
        place = f"system '{system.name}': parameter '{parameter.name}'"
        values[parameter.name] = number(value, place)
        try:
            parameter.check(value)
        except DefinitionError as error:
            raise DefinitionError(f"system '{system.name}': {error}") from None
    if missing:
        raise DefinitionError(
            f"system '{system.name}': no value for the parameter(s) {', '.join(missing)}; give "
            f"parameters={{'{missing[0]}': ...}}"
        )
    require_possible(system, given)
    return values


@dataclass(frozen=True)
class Start:
    """Where a motion starts: coordinates, then velocities v.

    ``notes`` say what was moved to meet the constraints, each in one line; nothing is moved unless
    that was asked for.
    """

    state: np.ndarray
    notes: tuple[str, ...] = ()


def start_of(
    vocabulary: Vocabulary,
    scene: Mapping[str, Any],
    given: Mapping[str, Any],
    parameters: Mapping[str, float],
    rates: Rates,
    time: float = 0.0,
    project: bool = False,
) -> Start:
    """Coordinates, then velocities v, at the start; what nobody names is zero.

    ``given`` overrides ``scene`` entry by entry.  Coordinates must satisfy the relations between
    redundant ones.  Velocities of coordinates are conditions on v, rates(q, v) = value, that must
    be consistent and must determine the v they involve.  ``DefinitionError`` with the residual
    where data do not fit; with ``project`` the nearest coordinates on the relations are taken, and
    the v that meet all conditions best (least squares).
    """
    system = vocabulary.equations.system
    coordinates = [plain_name(q) for q in system.coordinates]
    old, new = (numbers_of(vocabulary, part, parameters) for part in (scene, given))
    q, notes = coordinates_of(vocabulary, {**old, **new}, parameters, time, project)
    v = np.zeros(len(system.velocities))
    for values in (old, new):
        conditions = {k: x for k, x in values.items() if k not in coordinates}
        v, moved = meet_conditions(vocabulary, q, v, conditions, rates, project)
        notes += moved
    return Start(np.concatenate([q, v]), tuple(notes))


def coordinates_of(
    vocabulary: Vocabulary,
    values: Mapping[str, float],
    parameters: Mapping[str, float],
    time: float,
    project: bool,
) -> tuple[np.ndarray, list[str]]:
    """The coordinates, checked; or the nearest on the relations, and how far they were moved."""
    system = vocabulary.equations.system
    q = np.array([values.get(plain_name(x), 0.0) for x in system.coordinates])
    if not system.fibration.relations:
        return q, []
    relations = Relations.of(vocabulary.equations.form, parameters, time)
    off = relations.residuals(q)
    worst = int(np.argmax(np.where(np.isnan(off), np.inf, np.abs(off))))
    if abs(off[worst]) < CONSISTENT:
        return q, []
    problem = (
        f"system '{system.name}': the initial point does not satisfy the relation "
        f"{system.fibration.relations[worst]} = 0 (residual {off[worst]:.3g})"
    )
    if not project:
        raise DefinitionError(f"{problem}; correct the coordinates, or give project=True")
    moved = relations.nearest(q, CONSISTENT)
    if moved is None:
        raise DefinitionError(
            f"{problem}, and no point nearby was found that does; correct the coordinates"
        )
    names = (plain_name(x) for x in system.coordinates)
    return moved, [
        f"the initial coordinates were moved by {np.linalg.norm(moved - q):.3g} onto the relations"
        f" ({changes(names, q, moved)})"
    ]


def numbers_of(
    vocabulary: Vocabulary, values: Mapping[str, Any], parameters: Mapping[str, float]
) -> dict[str, float]:
    """Initial values as numbers; they may be expressions in the parameters."""
    result = {}
    for name, value in values.items():
        if isinstance(value, sp.Expr) and not value.is_number:
            held = {s: plain_name(s) for s in names_in(value)}
            value = value.xreplace(
                {s: sp.Float(parameters[n], 17) for s, n in held.items() if n in parameters}
            )
        place = f"system '{vocabulary.equations.system.name}': initial value '{name}'"
        lacking = sorted(map(str, value.free_symbols)) if isinstance(value, sp.Expr) else []
        if lacking:
            raise DefinitionError(
                f"{place} = {quote(value)} is not a real number, since '{lacking[0]}' has no value"
            )
        result[name] = number(value, place)
    return result
