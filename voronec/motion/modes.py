"""Right-hand sides that are not smooth, mode by mode: on given sides of their switching surfaces,
or along them.

On either side of a switching surface g = 0 the field is smooth, f+ and f-.  Where both lead to the
switching surface the motion stays on it [Filippov1988]: it follows f = (f+ + f-)/2 + a (f+ - f-)/2
with -1 < a < 1 such that g stays zero, and of several switching surfaces with one such a for each,
where the field is affine in them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from itertools import combinations
from typing import Any

import symengine as se

from voronec.algebra.graphs import bases, nodes
from voronec.algebra.memo import remember
from voronec.algebra.normal import canonical, canonical_for_numbers, quotient
from voronec.algebra.numeric_functions import HYPOT, numeric_name
from voronec.algebra.signs import prove_inequality
from voronec.algebra.stable import stable_all
from voronec.algebra.sympy_bridge import SymPyBridge
from voronec.algebra.terms import factors_of
from voronec.equations.program import Block, Program
from voronec.equations.program.python import compiled_digits
from voronec.equations.program.straight import prune, with_plain_roots, without_stages
from voronec.equations.program.switches import (
    SATURATION,
    Sides,
    Switch,
    has_switches,
    plain_roots,
    radicands,
)
from voronec.errors import EngineLimit
from voronec.motion.state_probe import quantities

STEEP = (se.log, se.asin, se.acos, se.acosh, se.atan2)
"""Functions whose slopes have no bound."""

MOST_IDLE = 4
"""So many switching surfaces are left out of a mode at most: all their sides are compared."""

LONG = 2_000
"""Pushes of more operations, spelled out, are divided by as they are."""


@dataclass(frozen=True)
class LevelSurface:
    """A switching surface where its function is a ``level``: zero, or of a floor any whole
    number."""

    switch: Switch
    level: int = 0

    @property
    def function(self) -> Any:
        """Vanishes on the surface, is positive above."""
        return self.switch.function - self.level

    def value(self, side: int) -> int:
        """What stands for the switching surface above (1) and below (-1): the sign, or the
        floor."""
        if not self.switch.whole:
            return side
        return self.level if side > 0 else self.level - 1

    def __str__(self) -> str:
        return f"{self.switch.function} = {self.level}"


@dataclass(frozen=True, eq=False)
class SmoothBranch:
    """The equations on one side of every switching surface; floors are parameters of the
    ``program``.

    ``signs`` are the sides that were asked for, ``switches`` all that were met,
    ``functions`` those of events.  ``rims`` are radicands of roots that velocities may bring to
    zero, all at once.
    """

    form: Any
    program: Program
    functions: Mapping[str, Any]
    signs: Mapping[Switch, int]
    switches: tuple[Switch, ...]
    rims: tuple[Any, ...]


@dataclass
class Modes:
    """All modes of a form; ``functions`` are those of events by name, in the engine's symbols.

    ``cusps`` are radicands that vanish on switching surfaces, as in |x|^(3/2): such a root has no
    Taylor series there, and beyond it is taken of the absolute value, so that a step may look
    across.  ``conditions`` are functions that vanish along every motion.
    """

    form: Any
    functions: Mapping[str, Any]
    cusps: frozenset[Any] = frozenset()
    saturated: Any = SATURATION
    conditions: tuple[Any, ...] = ()
    _corners: list[SmoothBranch] = field(default_factory=list)
    _floors: dict[Switch, Any] = field(default_factory=dict)
    _gauges: dict[Switch, Callable[..., Any]] = field(default_factory=dict)
    _held: dict[Any, bool] = field(default_factory=dict)

    @classmethod
    def of(
        cls, form: Any, functions: Mapping[str, Any], saturated: Any = SATURATION,
        conditions: Sequence[Any] = (),
    ) -> Modes | None:  # fmt: skip
        """The modes of a form; None where it is smooth.  tanh w counts as flat to the rounding in
        force where |w| is greater than ``saturated``."""
        form, functions = without_stages(with_plain_roots(form), functions)
        still = frozenset(form.parameters)
        known = form.rates_by_velocity
        functions = {
            name: plain_roots(se.sympify(e).xreplace(known), still) for name, e in functions.items()
        }
        exprs = form.expressions
        if not has_switches([*exprs, *functions.values()], still) and not rims(form, exprs):
            return None
        return cls(form, functions, _cusps(form, exprs), saturated, tuple(conditions))

    def floor(self, switch: Switch) -> Any:
        """The parameter that stands for a floor."""
        return self._floors.setdefault(switch, se.Symbol(f"floor {len(self._floors) + 1}"))

    def inner_switches(self, switch: Switch) -> list[Switch]:
        """The switching surfaces of the floors in the function of a switching surface, inner ones
        first."""
        switches = [w for w, symbol in self._floors.items() if symbol in switch.floors]
        return [inner for w in switches for inner in (*self.inner_switches(w), w)]

    def corner(self, side: Callable[[Switch], int]) -> SmoothBranch:
        """The equations on given sides of the switching surfaces."""
        for known in self._corners:
            if all(side(switch) == sign for switch, sign in known.signs.items()):
                return known
        form = self.form
        asked: dict[Switch, int] = {}

        def answer(switch: Switch) -> int:
            return asked.setdefault(switch, side(switch))

        still = frozenset(form.parameters)
        change = Sides(answer, self.floor, still, self.cusps, self.saturated)
        made = replace(
            form,
            rates=tuple(self._entry_on_sides(e, change) for e in form.rates),
            force=tuple(self._entry_on_sides(e, change) for e in form.force),
            mass=tuple(tuple(self._entry_on_sides(e, change) for e in row) for row in form.mass),
        )
        functions = {name: change(e) for name, e in self.functions.items()}
        idle = self._idle_switches(change, asked)
        signs = {switch: side for switch, side in asked.items() if switch not in idle}
        floors = [self.floor(switch) for switch in change.switches if switch.whole]
        made = replace(made, parameters=(*form.parameters, *floors))
        exprs = made.expressions
        branch = SmoothBranch(
            made, Program.of(made), functions, signs,
            tuple(switch for switch in change.switches if switch not in idle), rims(form, exprs),
        )  # fmt: skip
        self._corners.append(branch)
        return branch

    def _idle_switches(self, change: Sides, asked: Mapping[Switch, int]) -> list[Switch]:
        """The switching surfaces of signs on both sides of which everything is the same, as it is
        at that of friction while there is no load: they hold nothing, and nothing is to be decided
        there."""
        if len(asked) < 2:  # a switching surface is idle beside others alone
            return []
        exprs = [*self.form.expressions, *self.functions.values()]
        changed = [change(se.sympify(e)) for e in exprs]
        again = replace(change, switches={}, _known={})
        for expr in changed:
            again(expr)  # what only keeps a step from going over it is met once more
        met = (n.args[0] for n in nodes(map(se.sympify, exprs)) if isinstance(n, se.sign | se.Abs))
        signs = {f for g in met for f in (g, *factors_of(g))}
        idle: list[Switch] = []
        alone = (w for w in asked if not (w.fixed or w in again.switches))
        loose = [w for w in alone if {w.function, -w.function} & signs]
        for switch in loose:
            turned = [
                {switch, *kept} for n in range(len(idle) + 1) for kept in combinations(idle, n)
            ]
            if len(idle) < MOST_IDLE and all(
                self._is_same(exprs, changed, change, asked, switches) for switches in turned
            ):
                idle.append(switch)
        return idle

    @staticmethod
    def _is_same(
        exprs: Sequence[Any], found: Sequence[Any], change: Sides, asked: Mapping[Switch, int],
        switches: Set[Switch],
    ) -> bool:  # fmt: skip
        """Whether expressions are those ``found`` on the other side of some switching surfaces,
        too."""

        def side(switch: Switch) -> int:
            return -asked[switch] if switch in switches else asked[switch]

        other = replace(change, side=side, switches={}, _known={})
        try:
            return all(other(se.sympify(e)) == f for e, f in zip(exprs, found, strict=True))
        except KeyError:  # there are other switching surfaces there
            return False

    def _entry_on_sides(self, expr: Any, change: Sides) -> Any:
        """An entry on the sides, without the factors that vanish on a switching surface both above
        and below."""
        expr = se.sympify(expr)
        changed = change(expr)
        if changed == expr:
            return expr
        try:
            return canonical_for_numbers([changed], self.form)[0]
        except EngineLimit:
            return changed

    @remember("_gauges")
    def gauge(self, switch: Switch) -> Callable[..., Any]:
        """Of (time, state, values by name): a switching surface's function, and its derivatives by
        the time and by the state, in any precision."""
        g = switch.function
        floors = tuple(s for s in self._floors.values() if s in g.free_symbols)
        form = replace(self.form, parameters=(*self.form.parameters, *floors))
        slots = [form.time, *form.coordinates, *form.velocities]
        wanted = {"switching surface": g} | {f"slope by {x}": plain_roots(g.diff(x)) for x in slots}
        program = quantities(form, wanted)
        extras = compiled_digits(program)[1]

        def measure(time: Any, state: Any, values: Mapping[str, Any]) -> list[Any]:
            return list(extras(time, list(state), [values[str(p)] for p in program.parameters]))

        return measure

    def is_held(self, switch: Switch, along: tuple[LevelSurface, ...]) -> bool:
        """Whether a motion along surfaces stays on a switching surface, too, as one that is held by
        two wheels does on that of a third."""
        return switch in {s.switch for s in along} or self.stays_zero(switch.function, along)

    def stays_zero(self, function: Any, along: tuple[LevelSurface, ...]) -> bool:
        """Whether a function vanishes all along some surfaces."""
        key = function, along
        if key not in self._held:
            functions = [*self.conditions, *(s.function for s in along)]
            still = frozenset(self.form.parameters)
            self._held[key] = bool(along) and _vanishes(function, functions, still)
        return self._held[key]

    @cached_property
    def state(self) -> tuple[Any, ...]:
        """Coordinates, then velocities."""
        return (*self.form.coordinates, *self.form.velocities)


def _cusps(form: Any, exprs: Sequence[Any]) -> frozenset[Any]:
    """The radicands in expressions that vanish on a switching surface."""
    still = frozenset(form.parameters)
    bases = radicands(exprs, frozenset((*form.coordinates, *form.velocities, form.time)))
    cusps = set()
    for change in (Sides(lambda _: 1, _zero, still), Sides(lambda _: -1, _zero, still)):
        for expr in exprs if bases else ():
            change(expr)
        for base in bases:
            if any(_vanishes(change(base), [switch.function], still) for switch in change.switches):
                cusps.add(base)
    return frozenset(cusps)


def _zero(_switch: Switch) -> Any:
    return se.Integer(0)


def _vanishes(expr: Any, functions: Sequence[Any], still: frozenset[Any]) -> bool:
    """Whether an expression vanishes where functions do, each linear in one of its symbols, or seen
    in the expression as a whole."""
    left = list(functions)
    while left:
        function = left.pop()
        slopes = ((x, function.diff(x)) for x in sorted(function.free_symbols - still, key=str))
        linear = ((x, a) for x, a in slopes if a != 0 and x not in a.free_symbols)
        x, slope = next(linear, (None, None))
        if x is None:
            there = expr.xreplace({function: se.Integer(0)})
            if there == expr or _is_positive(function, frozenset()):
                return False
            expr = there
            continue
        there = {x: x - function / slope}
        expr, left = expr.xreplace(there), [f.xreplace(there) for f in left]
    try:
        return bool(canonical([expr])[0] == 0)
    except EngineLimit:
        return False


def rims(form: Any, exprs: Sequence[Any]) -> tuple[Any, ...]:
    """The radicands in expressions that hold velocities and are not known to be positive.

    Such a root is not smooth where its radicand vanishes, as the speed of a body that comes to rest
    while friction acts against its velocity.  A length that only multiplies, as the speed in the
    drag k v |v| of the air, has a bounded slope and is none: the motion goes on.
    """
    moving, positive = frozenset(form.velocities), frozenset(form.positive)
    candidates = [b for b in radicands(exprs, moving) if not _is_positive(b, positive)]
    steep = [b for b in _steep(exprs) if not _is_positive(b, positive)] if candidates else []
    held = moving.intersection({x for b in steep for x in b.free_symbols})
    return tuple(b for b in candidates if b.free_symbols & held or not is_length(se.sqrt(b)))


def is_length(root: Any) -> bool:
    """Whether a root is that of a sum of squares."""
    return bool(numeric_name(stable_all([root])[0]) == HYPOT)


def _steep(exprs: Sequence[Any]) -> Iterator[Any]:
    """What has no bounded slope where it vanishes, or its function none: divisors, radicands of
    higher roots, arguments of logarithms and of angles."""
    yield from bases(exprs)
    for node in nodes(map(se.sympify, exprs)):
        if isinstance(node, se.Pow):
            exponent = node.args[1]
            if not (exponent.is_Number and exponent * 2 == int(exponent * 2)):
                yield node.args[0]
        elif isinstance(node, STEEP):
            yield se.Add(*[a**2 for a in node.args])


@lru_cache(maxsize=64)
def _is_positive(base: Any, positive: frozenset[Any]) -> bool:
    bridge = SymPyBridge()
    above = [bridge.outward(s) for s in base.free_symbols & positive]
    return prove_inequality(bridge.outward(base), ">", 0, positive=above).proved


def motion_along_surfaces(
    corners: Sequence[SmoothBranch], surfaces: Sequence[LevelSurface]
) -> tuple[Program, Block] | None:
    """The motion along surfaces, and the block that computes their weights a, and how far the push
    of each leads back to its own; None where the sides do not differ in where they lead.

    The first corner lies above all surfaces, the others below one each.
    """
    lines: list[tuple[Any, Any]] = []
    fields = [_relabel(c.program.derivative, k, lines) for k, c in enumerate(corners)]
    program, above = corners[0].program, fields[0]
    halves = [
        [(a - b) / 2 if a != b else se.Integer(0) for a, b in zip(above, other, strict=True)]
        for other in fields[1:]
    ]

    def name(expr: Any) -> Any:
        if expr.is_Number or expr.is_Symbol:
            return expr
        lines.append((se.Symbol(f"along {len(lines)}"), expr))
        return lines[-1][0]

    slopes = [[s.function.diff(x) for x in program.state] for s in surfaces]
    pushes = [
        [name(se.Add(*[g * f for g, f in zip(row, half, strict=True)])) for half in halves]
        for row in slopes
    ]
    wanted = [
        -se.Add(s.function.diff(program.time), *[g * f for g, f in zip(row, above, strict=True)])
        for s, row in zip(surfaces, slopes, strict=True)
    ]
    shares = _share_of_lever(pushes, wanted, lines) or _eliminate(pushes, wanted, name)
    if shares is None:
        return None
    rates = [
        f + se.Add(*[share * half[m] for share, half in zip(shares, halves, strict=True)])
        for m, f in enumerate(above)
    ]
    if all(g.is_Number for row in slopes for g in row):
        _hold(rates, slopes, [-s.function.diff(program.time) for s in surfaces])
    weights = tuple(1 + share for share in shares)
    returns = tuple(pushes[i][i] for i in range(len(surfaces)))
    made = replace(program, derivative=prune(lines, rates))
    return made, Block(tuple(lines), (*weights, *returns))


def _share_of_lever(
    pushes: list[list[Any]], wanted: list[Any], lines: Sequence[tuple[Any, Any]]
) -> list[Any] | None:
    """The share along one surface without what vanishes in its push and in what is wanted alike, as
    the lever of friction does; None where nothing does."""
    if len(wanted) > 1 or pushes[0][0].is_Number:
        return None
    (push,), (need,) = pushes[0], wanted
    spelled = dict[Any, Any]()
    for symbol, expr in lines:
        spelled[symbol] = expr.xreplace(spelled)
    push, need = push.xreplace(spelled), need.xreplace(spelled)
    if max(se.count_ops(push), se.count_ops(need)) > LONG:
        return None
    try:
        above, below = quotient(need / push)
        whole = quotient(push)[0]
        lever = quotient(whole / below)[0]
    except (EngineLimit, ZeroDivisionError):
        return None
    return None if lever.is_Number else [above / below]


def _hold(rates: list[Any], slopes: list[list[Any]], wanted: list[Any]) -> None:
    """Let rates satisfy slopes * rates = wanted exactly, not to rounding: some follow from others.

    The slopes are numbers.
    """
    rows = [[*row, w] for row, w in zip(slopes, wanted, strict=True)]
    pivots: list[int] = []
    for i, row in enumerate(rows):
        pivot = next((m for m, g in enumerate(row[:-1]) if g != 0), None)
        if pivot is None:
            return
        rows[i] = row = [g / row[pivot] for g in row]
        for k, other in enumerate(rows):
            if k != i and other[pivot] != 0:
                rows[k] = [a - other[pivot] * b for a, b in zip(other, row, strict=True)]
        pivots.append(pivot)
    for pivot, row in zip(pivots, rows, strict=True):
        rest = [g * rates[m] for m, g in enumerate(row[:-1]) if m not in pivots]
        rates[pivot] = row[-1] - se.Add(*rest)


def _relabel(block: Block, k: int, lines: list[tuple[Any, Any]]) -> list[Any]:
    """The results of a block whose lines are added under names of their own, but for those that
    are there: what is the same on two sides is to vanish from their difference."""
    names: dict[Any, Any] = {}
    known = {expr: name for name, expr in lines}
    for old, expr in block.assignments:
        moved = expr.xreplace({x: y for x, y in names.items() if x != old})
        names[old] = known.get(moved, se.Symbol(f"side {k} {old}"))
        if moved not in known:
            lines.append((names[old], moved))
    return [se.sympify(r).xreplace(names) for r in block.results]


def _eliminate(
    matrix: list[list[Any]], right: list[Any], name: Callable[[Any], Any]
) -> list[Any] | None:
    """The solution of few linear equations, pivot after pivot; None where one is zero."""
    rows, values, n = [list(row) for row in matrix], [name(r) for r in right], len(right)
    for i in range(n):
        if rows[i][i] == 0:
            return None
        for j in range(i + 1, n):
            factor = name(rows[j][i] / rows[i][i])
            for m in range(i + 1, n):
                rows[j][m] = name(rows[j][m] - factor * rows[i][m])
            values[j] = name(values[j] - factor * values[i])
    solution: list[Any] = [None] * n
    for i in reversed(range(n)):
        rest = se.Add(*[rows[i][m] * solution[m] for m in range(i + 1, n)])
        solution[i] = name((values[i] - rest) / rows[i][i])
    return solution
