"""Initial conditions, read and met, of one motion or many: states that fit the constraints.

Data off the constraints are refused with their residual, or, on request, moved onto them.
What is said of velocities are conditions that they must meet.

Many starts are read at once by the steps of ``start_of`` on arrays.  What needs more than numbers -
texts and expressions, starts that give different things, redundant coordinates - and starts that do
not fit are left to ``start_of``, one by one, which says what is wrong with them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy as sp

from voronec.algebra.symbols import names_in, plain_name
from voronec.declaration.reading import quote
from voronec.declaration.system import require_possible
from voronec.equations.program import Program, compile_program
from voronec.errors import DefinitionError
from voronec.motion.request import Namespace, Starts, kept_while_same, name_values, number
from voronec.motion.tolerances import UNIT

if TYPE_CHECKING:
    from voronec.equations.derivation import FirstOrderForm

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
    """r(q) = 0 at given parameters and time: ``evaluate(q)`` gives r (m,) and dr/dq (m, n), for one
    q (n,) or for each of several (n, k)."""

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
            numbers = np.array([np.broadcast_to(x, q.shape[1:]) for x in flat], dtype=float)
            return numbers[:m], numbers[m:].reshape(m, n, *q.shape[1:])

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
            point = self._iterate(q, damping)
            if point is not None and np.abs(self.residuals(point)).max() < accuracy:
                return point
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
    wanted = {str(i): e for i, e in enumerate([*form.relations, *slopes])}
    program = Program.of_extras(form, wanted)
    return program.parameters, compile_program(program)[1]


def parameter_values(
    namespace: Namespace, given: Mapping[str, Any], needed: set[str]
) -> dict[str, float]:
    """Every parameter's value: as given, else its default; checked against its range.

    One that is not among ``needed`` may lack a value and is left out.
    """
    system = namespace.equations.system
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
    namespace: Namespace,
    scene: Mapping[str, Any],
    given: Mapping[str, Any],
    parameters: Mapping[str, float],
    rates: Rates,
    time: float = 0.0,
    project: bool = False,
) -> Start:
    """Coordinates, then velocities v, at the start; what nobody names is zero.

    ``given`` overrides ``scene`` entry by entry.  Coordinates must satisfy the relations between
    redundant ones.  Other velocities are conditions on v, rates(q, v) = value, that must be
    consistent and must determine the v they involve.  ``DefinitionError`` with the residual
    where data do not fit; with ``project`` the nearest coordinates on the relations are taken, and
    the v that meet all conditions best (least squares).
    """
    system = namespace.equations.system
    coordinates = [plain_name(q) for q in system.coordinates]
    old, new = (
        kept_while_same(namespace, f"numbers of {what}", (part, parameters),
                        partial(numbers_of, namespace, part, parameters))
        for what, part in (("a scene", scene), ("a start", given))
    )  # fmt: skip
    q, notes = coordinates_of(namespace, {**old, **new}, parameters, time, project)
    v = np.zeros(len(system.velocities))
    for values in (old, new):
        conditions = {k: x for k, x in values.items() if k not in coordinates}
        v, moved = meet_conditions(namespace, q, v, conditions, rates, project)
        notes += moved
    return Start(np.concatenate([q, v]), tuple(notes))


def coordinates_of(
    namespace: Namespace,
    values: Mapping[str, float],
    parameters: Mapping[str, float],
    time: float,
    project: bool,
) -> tuple[np.ndarray, list[str]]:
    """The coordinates, checked; or the nearest on the relations, and how far they were moved."""
    system = namespace.equations.system
    q = np.array([values.get(plain_name(x), 0.0) for x in system.coordinates])
    if not system.fibration.relations:
        return q, []
    relations = Relations.of(namespace.equations.form, parameters, time)
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
    namespace: Namespace, values: Mapping[str, Any], parameters: Mapping[str, float]
) -> dict[str, float]:
    """Initial values as numbers; they may be expressions in the parameters."""
    result = {}
    for name, value in values.items():
        if isinstance(value, sp.Expr) and not value.is_number:
            held = {s: plain_name(s) for s in names_in(value)}
            value = value.xreplace(
                {s: sp.Float(parameters[n], 17) for s, n in held.items() if n in parameters}
            )
        place = f"system '{namespace.equations.system.name}': initial value '{name}'"
        lacking = sorted(map(str, value.free_symbols)) if isinstance(value, sp.Expr) else []
        if lacking:
            raise DefinitionError(
                f"{place} = {quote(value)} is not a real number, since '{lacking[0]}' has no value"
            )
        result[name] = number(value, place)
    return result


CONSISTENT = 1e-9
"""How far initial data may lie off the constraints, relative to their size."""
ROUNDING = 1e-13
"""A smaller relative change is none."""
NO_VELOCITIES = "system '{}': the velocities are no frame at the initial point; start beside it"


class NoFrame(DefinitionError):
    """The velocities v of the equations determine nothing at the initial point."""


Rates = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Coordinates (n,) and velocities (m, k) to the velocities of ``Namespace.rate_names`` (l, k)."""


def meet_conditions(
    namespace: Namespace,
    q: np.ndarray,
    v: np.ndarray,
    conditions: Mapping[str, float],
    rates: Rates,
    project: bool,
) -> tuple[np.ndarray, list[str]]:
    """The velocities that meet the conditions, and what is to be said of them; those that no
    condition involves stay."""
    if not conditions:
        return v, []
    velocities = [plain_name(x) for x in namespace.equations.system.velocities]
    if conditions.keys() <= {*velocities}:  # each says what one of them is
        return np.array(
            [conditions.get(name, x) for name, x in zip(velocities, v, strict=True)]
        ), []
    order, rows, right = _pose_conditions(namespace, q, conditions, rates)
    chosen = independent(rows)
    involved = np.abs(rows).max(axis=0) > CONSISTENT * np.abs(rows).max(initial=0.0)
    if len(chosen) > involved.sum():  # beside rates that are as good as infinite
        raise NoFrame(NO_VELOCITIES.format(namespace.equations.system.name))
    if len(chosen) < involved.sum():
        names = [name for name, i in zip(velocities, involved, strict=True) if i]
        raise DefinitionError(
            f"system '{namespace.equations.system.name}': the initial velocities do not determine "
            f"{', '.join(names)}; give more velocities, or these themselves"
        )
    result = v.copy()
    result[involved] = np.linalg.solve(rows[chosen][:, involved], right[chosen])
    for name in set(velocities) & set(order):
        result[velocities.index(name)] = conditions[name]
    excess, usual = rows @ result - right, 1.0 + max(map(abs, conditions.values()))
    size = np.abs(rows) @ np.abs(result) + np.abs(right)
    if UNIT * size.max() > CONSISTENT * usual:  # what is given is rounding beside such rates
        raise NoFrame(NO_VELOCITIES.format(namespace.equations.system.name))
    if np.abs(excess).max() <= CONSISTENT * usual:
        return result, []
    if not project:
        raise _inconsistent(namespace, order, conditions, excess)
    result[involved] = np.linalg.lstsq(rows[:, involved], right, rcond=None)[0]
    for name in set(velocities) & set(order):  # what was met but for rounding is met
        if abs(result[velocities.index(name)] - conditions[name]) <= ROUNDING * abs(
            conditions[name]
        ):
            result[velocities.index(name)] = conditions[name]
    wanted, excess = np.array([conditions[name] for name in order]), rows @ result - right
    return result, [note_of_velocities(order, wanted, wanted + excess)]


def note_of_velocities(names: Sequence[str], old: np.ndarray, new: np.ndarray) -> str:
    """What is to be said of velocities that were moved on request."""
    far = np.linalg.norm(new - old)
    return (
        f"the initial velocities were moved by {far:.3g} onto the constraints "
        f"({changes(names, old, new)})"
    )


def _pose_conditions(
    namespace: Namespace, q: np.ndarray, conditions: Mapping[str, float], rates: Rates
) -> tuple[list[str], np.ndarray, np.ndarray]:
    """The conditions in order: their names, and rows @ v = right."""

    def rates_of_one(_: np.ndarray, v: np.ndarray) -> np.ndarray:
        return rates(q, v)[None]

    each = {name: np.array([x]) for name, x in conditions.items()}
    order, rows, right = _pose_conditions_of_many(namespace, q[None], each, rates_of_one)
    if np.isnan(right).any():
        raise NoFrame(NO_VELOCITIES.format(namespace.equations.system.name))
    return order, rows[0], right[0]


def changes(names: Iterable[str], old: np.ndarray, new: np.ndarray) -> str:
    """What was moved, from where to where."""
    triples = zip(names, old.tolist(), new.tolist(), strict=True)
    return ", ".join(
        f"{name} from {a:.6g} to {b:.6g}"
        for name, a, b in triples
        if abs(a - b) > ROUNDING * (abs(a) + abs(b))
    )


def independent(rows: np.ndarray) -> list[int]:
    """Positions of the first rows that are linearly independent."""
    chosen: list[int] = []
    for i in range(len(rows)):
        scaled = [rows[j] / (np.linalg.norm(rows[j]) or 1.0) for j in (*chosen, i)]
        if np.linalg.matrix_rank(np.array(scaled), tol=CONSISTENT) == len(scaled):
            chosen.append(i)
    return chosen


def _inconsistent(
    namespace: Namespace, order: list[str], conditions: Mapping[str, float], excess: np.ndarray
) -> DefinitionError:
    worst = int(np.argmax(np.abs(excess)))
    name = order[worst]
    value = float(conditions[name])
    return DefinitionError(
        f"system '{namespace.equations.system.name}': the initial velocities are off the "
        f"constraints: '{name}' = {value:.12g}, where the others give {value + excess[worst]:.12g} "
        f"(residual {abs(excess[worst]):.3g}); correct '{name}' or leave it out, or give "
        "project=True"
    )


RatesOfMany = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Coordinates (s, n) and velocities (m, k) to the same velocities (s, l, k)."""


def starts_in_arrays(
    namespace: Namespace,
    scene: Mapping[str, Any],
    starts: Starts,
    parameters: Mapping[str, np.ndarray],
    rates: RatesOfMany,
) -> np.ndarray:
    """Coordinates, then velocities v, of each start (s, n + m); rows of nan where it is left over.

    ``scene`` has initial values by plain name, ``parameters`` arrays (s,).
    """
    system = namespace.equations.system
    names = [plain_name(q) for q in system.coordinates]
    left = np.full((len(starts), len(names) + len(system.velocities)), np.nan)
    if system.fibration.relations or not starts:
        return left
    still = {name: float(x[0]) for name, x in parameters.items() if (x == x[0]).all()}
    try:
        known = name_values(namespace, starts[0], "initial value")
        columns = dict(zip(known, _columns(starts), strict=True))
        single = {k: known[k] for k, x in columns.items() if x is None}
        before = numbers_of(namespace, scene, still)
        single = numbers_of(namespace, single, still)
    except (DefinitionError, ValueError, TypeError, OverflowError):
        return left
    old = {name: np.full(len(starts), x) for name, x in before.items()}
    columns |= {name: np.full(len(starts), x) for name, x in single.items()}
    nothing = np.zeros(len(starts))
    q = np.stack([{**old, **columns}.get(name, nothing) for name in names], axis=-1)
    v = np.zeros((len(starts), len(system.velocities)))
    good = np.isfinite(q).all(axis=1)
    for part in (old, columns):
        conditions = {name: x for name, x in part.items() if name not in names}
        if conditions and good.any():
            v = _meet_conditions(namespace, q, v, conditions, rates, good)
    left[good] = np.hstack([q, v])[good]
    return left


def _columns(starts: Starts) -> list[Any]:
    """What starts give, key by key: arrays (s,), or None for a value that stands for all;
    ``ValueError`` where that are not the same numbers."""
    if starts.rows is None:
        return [x.astype(float) if isinstance(x, np.ndarray) else None
                for x in starts.columns.values()]  # fmt: skip
    keys = list(starts[0])
    if any(list(given) != keys for given in starts.rows):
        raise ValueError
    rows = [[given[key] for given in starts.rows] for key in keys]
    if not all(isinstance(x, float | int) for row in rows for x in row):
        raise ValueError
    return [np.array(row, dtype=float) for row in rows]


def _meet_conditions(
    namespace: Namespace,
    q: np.ndarray,
    v: np.ndarray,
    conditions: Mapping[str, np.ndarray],
    rates: RatesOfMany,
    good: np.ndarray,
) -> np.ndarray:
    """Velocities (s, m) that meet conditions, as ``met`` finds them; starts for which it would do
    something else than for the first, or refuse them, are no longer ``good``."""
    velocities = [plain_name(x) for x in namespace.equations.system.velocities]
    order, rows, right = _pose_conditions_of_many(namespace, q, conditions, rates)
    good &= np.isfinite(rows).all(axis=(1, 2)) & np.isfinite(right).all(axis=1)
    if not good.any():
        return v
    right, first = np.where(good[:, None], right, 0.0), int(np.argmax(good))
    # conditions on the velocities v themselves are the same for all
    rows = rows[:1] if not rows.strides[0] else np.where(good[:, None, None], rows, 0.0)
    chosen = independent(rows[first % len(rows)])
    good &= _as_independent(rows, chosen)
    sizes = np.abs(rows).max(axis=1)
    involved = sizes > CONSISTENT * sizes.max(axis=1, keepdims=True, initial=0.0)
    which = involved[first % len(rows)]
    good &= (involved == which).all(axis=1)
    if len(chosen) != which.sum():
        good[:] = False
        return v
    solution, at = v.copy(), np.flatnonzero(good)
    square = (rows if len(rows) == 1 else rows[at])[:, chosen][:, :, which]
    solved = np.linalg.solve(square, right[at][:, chosen, None])[..., 0]
    solution[np.ix_(at, which)] = solved
    for name in set(velocities) & set(order):
        solution[:, velocities.index(name)] = conditions[name]
    excess = np.abs((rows @ solution[:, :, None])[..., 0] - right).max(axis=1)
    size = 1.0 + np.max([np.abs(x) for x in conditions.values()], axis=0)
    good &= excess <= CONSISTENT * size
    return solution


def _as_independent(rows: np.ndarray, chosen: list[int]) -> np.ndarray:
    """For which of some sets of rows (s, k, n) the same ones are chosen as independent."""
    lengths = np.linalg.norm(rows, axis=2, keepdims=True)
    scaled = rows / np.where(lengths == 0, 1.0, lengths)
    if len(chosen) == rows.shape[1]:  # then those before each one are independent, too
        return np.asarray(np.linalg.matrix_rank(scaled, tol=CONSISTENT) == len(chosen))
    same = np.ones(len(rows), dtype=bool)
    for i in range(rows.shape[1]):
        before = [j for j in chosen if j < i]
        rank = np.linalg.matrix_rank(scaled[:, [*before, i]], tol=CONSISTENT)
        same &= (rank == len(before) + 1) == (i in chosen)
    return same


def _pose_conditions_of_many(
    namespace: Namespace,
    q: np.ndarray,
    conditions: Mapping[str, np.ndarray],
    rates: RatesOfMany,
) -> tuple[list[str], np.ndarray, np.ndarray]:
    """The conditions in order: their names, and rows (s, k, n) @ v = right (s, k)."""
    system = namespace.equations.system
    velocities = [plain_name(x) for x in system.velocities]
    dots = namespace.rate_names
    order = list(dict.fromkeys(name for name in (*velocities, *dots) if name in conditions))
    unit, right = np.eye(len(velocities)), np.stack([conditions[k] for k in order], axis=-1)
    if set(order) <= set(velocities):
        rows = unit[[velocities.index(k) for k in order]]
        return order, np.broadcast_to(rows, (len(q), *rows.shape)), right
    values = rates(q, np.hstack([np.zeros((len(velocities), 1)), unit]))
    linear, offset = values[:, :, 1:] - values[:, :, :1], values[:, :, 0]
    posed = [
        np.broadcast_to(unit[velocities.index(k)], (len(q), len(velocities)))
        if k in velocities
        else linear[:, dots.index(k)]
        for k in order
    ]
    for i, k in enumerate(order):
        if k not in velocities:
            right[:, i] -= offset[:, dots.index(k)]
    # a rate that has no value spoils the start, whether it is asked for or not
    right[~np.isfinite(values).all(axis=(1, 2))] = np.nan
    return order, np.stack(posed, axis=1), right
