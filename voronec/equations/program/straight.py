"""From a first-order form to one straight-line program."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property, lru_cache
from itertools import count
from typing import TYPE_CHECKING, Any

import symengine as se

from voronec.algebra.brackets import nest_sums
from voronec.algebra.cardinal import loses_quotients
from voronec.algebra.generators import distance_powers
from voronec.algebra.graphs import is_atom, nodes
from voronec.algebra.normal import shortest
from voronec.algebra.numeric_functions import formula
from voronec.algebra.stable import stable_all
from voronec.algebra.stages import needed_stages
from voronec.algebra.terms import atoms, summands
from voronec.equations.program.choices import choose_sides, holds_choices, holds_switches
from voronec.equations.program.low_rank import (
    MassElimination,
    coupled_rows,
    eliminations,
    names_into,
)
from voronec.equations.program.switches import is_rough, plain_roots, write_roots_out
from voronec.equations.program.weight import evaluation_weight, operation_count, taylor_weight
from voronec.errors import DefinitionError, EngineLimit

if TYPE_CHECKING:
    from voronec.equations.derivation import FirstOrderForm

LONGEST_TO_NEST = 1_000
"""Above this many operations sums stay as they are: to try both forms would take too long."""


@dataclass(frozen=True)
class Block:
    """Assignments in order, then results; every name is assigned before it is used."""

    assignments: tuple[tuple[Any, Any], ...]
    results: tuple[Any, ...]

    @property
    def expressions(self) -> list[Any]:
        """Right sides and results, all that is computed."""
        return [e for _, e in self.assignments] + list(self.results)

    @property
    def operations(self) -> int:
        """How many operations one evaluation costs."""
        return int(se.count_ops(*self.expressions))

    def weight(self, constants: Iterable[Any]) -> float:
        """What it costs Taylor's method, in products of moving quantities."""
        return taylor_weight(self.assignments, self.results, constants)

    def is_rough(
        self, still: Iterable[Any], velocities: Iterable[Any] = (), steep: bool = True
    ) -> bool:
        """Whether something in it may not be smooth, roots of ``velocities`` among it, or, where
        asked for, is ``steep``; ``still`` are symbols that do not move."""
        return is_rough(self.assignments, self.results, still, velocities, steep)

    def movers(self, symbols: Iterable[Any]) -> set[Any]:
        """Some symbols, and the names that move with them."""
        moving = set(symbols)
        for name, expr in self.assignments:
            if expr.free_symbols & moving:
                moving.add(name)
        return moving

    def has_roots(self, moving: Iterable[Any]) -> bool:
        """Whether it holds a root, or another power whose exponent is no whole number, of something
        that moves with some symbols."""
        movers = self.movers(moving)
        plain = (formula(node) or node for node in nodes(self.expressions))
        return any(
            isinstance(node, se.Pow)
            and not isinstance(node.args[1], se.Integer)
            and bool(node.args[0].free_symbols & movers)
            for node in plain
        )

    @cached_property
    def symbols(self) -> frozenset[Any]:
        """All symbols that occur, assigned names included."""
        return frozenset().union(*(e.free_symbols for e in self.expressions))


@dataclass(frozen=True)
class Program:
    """The right-hand side of a system, and what else is computed from a state.

    The state is ``coordinates`` then ``velocities``; ``derivative`` computes its time derivative,
    ``extras`` the quantities called ``names``; ``inputs`` stand for functions of the time and their
    rates, which whoever calls it must give.  All symbols are symengine's.
    """

    time: Any
    coordinates: tuple[Any, ...]
    velocities: tuple[Any, ...]
    parameters: tuple[Any, ...]
    derivative: Block
    names: tuple[str, ...]
    extras: Block
    inputs: tuple[Any, ...] = ()

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        """Of all expressions, once: every run looks up what is compiled of its programs."""
        return hash(tuple(getattr(self, f.name) for f in fields(self)))

    def __getstate__(self) -> dict[str, Any]:
        """Without the hash, which other processes have otherwise."""
        return {name: x for name, x in self.__dict__.items() if name != "_hash"}

    def only(self, places: Sequence[int]) -> Program:
        """The program with some of the extra quantities alone."""
        extras = prune(self.extras.assignments, [self.extras.results[i] for i in places])
        return replace(self, names=tuple(self.names[i] for i in places), extras=extras)

    @classmethod
    def of(
        cls,
        form: FirstOrderForm,
        extras: Mapping[str, Any] | None = None,
    ) -> Program:
        """The program of ``qdot = rates, mass * vdot = force``, with extra quantities.

        ``extras`` maps names to symengine expressions in q, v, t, the parameters and the
        velocities of all coordinates, for which the rates are put in.  Raises ``DefinitionError``
        for an unknown function or symbol, and for a matrix without a pivot.
        """
        wanted = {name: se.sympify(e) for name, e in (extras or {}).items()}
        return _program(form, tuple(wanted.items()))

    @classmethod
    def of_extras(cls, form: FirstOrderForm, extras: Mapping[str, Any]) -> Program:
        """The program of extra quantities alone: nothing moves in it."""
        wanted = {name: se.sympify(e) for name, e in extras.items()}
        return _program(form, tuple(wanted.items()), moves=False)

    @classmethod
    def of_block(
        cls, time: Any, state: Sequence[Any], block: Block, parameters: Sequence[Any] = ()
    ) -> Program:
        """The program of the results of a block, as extra quantities; nothing moves in it."""
        names = tuple(f"entry {i}" for i in range(len(block.results)))
        still = Block((), (se.Integer(0),) * len(state))
        return cls(time, tuple(state), (), tuple(parameters), still, names, block)

    @property
    def state(self) -> tuple[Any, ...]:
        """Coordinates, then velocities."""
        return self.coordinates + self.velocities

    def rate(self, function: Any) -> Any:
        """How fast a function of state and time changes along the motion, in the symbols that the
        derivative assigns."""
        pairs = zip(self.state, self.derivative.results, strict=True)
        return function.diff(self.time) + se.Add(*[function.diff(x) * f for x, f in pairs])

    def beside(self, block: Block, what: str) -> Program:
        """The program with further states behind its own, called after ``what`` they are: the
        results of a block, whose assignments hold those of the derivative, are their rates."""
        more = tuple(se.Symbol(f"{what} {i}") for i in range(len(block.results)))
        rates = (*self.derivative.results, *block.results)
        wide = Block(block.assignments, rates)
        return replace(self, velocities=(*self.velocities, *more), derivative=wide)

    @cached_property
    def operations(self) -> int:
        """How many operations one evaluation of the right-hand side costs."""
        return self.derivative.operations

    @cached_property
    def has_moving_roots(self) -> bool:
        """Whether the right side holds roots, or other broken powers, of what moves."""
        return self.derivative.has_roots((*self.state, self.time))

    @cached_property
    def is_rough(self) -> bool:
        """Whether the rates of the state may not be smooth, or are steep."""
        return self.derivative.is_rough(self.parameters, self.velocities)

    @cached_property
    def has_corners(self) -> bool:
        """Whether the rates of the state may not be smooth."""
        return self.derivative.is_rough(self.parameters, self.velocities, steep=False)

    @cached_property
    def is_rough_beside(self) -> bool:
        """Whether extra quantities may not be smooth."""
        return self.extras.is_rough(self.parameters)

    @cached_property
    def weight(self) -> float:
        """What a step of Taylor's method costs, in products of moving quantities."""
        return self.derivative.weight(self.parameters)

    @cached_property
    def evaluation_weight(self) -> int:
        """What one evaluation costs, in additions; functions and quotients count for several."""
        return evaluation_weight(self.derivative.expressions)


@lru_cache(maxsize=128)  # starts, tolerances and methods change, what is asked of a form does not
def _program(
    form: FirstOrderForm, extras: tuple[tuple[str, Any], ...], moves: bool = True
) -> Program:
    form, wanted, inputs = _replace_functions(form, dict(extras))
    known = [form.time, *form.coordinates, *form.velocities, *form.parameters, *inputs]
    rates = form.rates_by_velocity
    observed = [e.xreplace(rates) for e in wanted.values()]
    matrix = [e for row in form.mass for e in row]
    names = [name for name, _ in form.stages]
    inner = [e for _, e in form.stages]
    moving = [*inner, *form.rates, *matrix, *form.force] if moves else inner
    _check("the equations of motion", moving, [*known, *names])
    for name, expr in zip(wanted, observed, strict=True):
        _check(f"'{name}'", [expr], [*known, *names])
    rest = Block((), (se.Integer(0),) * (len(form.coordinates) + len(form.velocities)))
    derivative = _derivative(form, tuple(known)) if moves else rest
    extra = share_subexpressions(observed, fresh_names(known), form.stages)
    if derivative.is_rough(form.parameters):
        form = with_plain_roots(form)
        derivative = _derivative(form, tuple(known))
    if extra.is_rough(form.parameters):
        form, still = with_plain_roots(form), frozenset(form.parameters)
        plain = [plain_roots(e, still) for e in observed]
        extra = share_subexpressions(plain, fresh_names(known), form.stages)
    return Program(
        time=form.time,
        coordinates=tuple(form.coordinates),
        velocities=tuple(form.velocities),
        parameters=tuple(form.parameters),
        derivative=derivative,
        names=tuple(wanted),
        extras=extra,
        inputs=inputs,
    )


def _replace_functions(
    form: FirstOrderForm, extras: dict[str, Any]
) -> tuple[FirstOrderForm, dict[str, Any], tuple[Any, ...]]:
    """A form with plain symbols, also returned, for functions of the time and their rates."""
    if not form.inputs:
        return form, extras, ()
    rows = (*form.mass, form.rates, form.force, form.definitions, (*extras.values(),))
    held = [e for row in rows for e in row] + [e for _, e in (*form.stages, *form.dependent)]
    functions = atoms(held, se.FunctionSymbol, se.Derivative)
    symbols: dict[Any, Any] = {}
    for function in form.inputs:
        name = function.get_name()
        rates = [d for d in functions if isinstance(d, se.Derivative) and d.args[0] == function]
        for node in (function, *sorted(rates, key=lambda d: len(d.args))):
            if node in functions or node == function:  # declared inputs are arguments, used or not
                symbols[node] = se.Symbol(name + "dot" * (len(node.args) - 1))

    def on(exprs: Iterable[Any]) -> tuple[Any, ...]:
        # derivatives first: in them, too, the function stands
        rates = {node: s for node, s in symbols.items() if isinstance(node, se.Derivative)}
        return tuple(se.sympify(e).xreplace(rates).xreplace(symbols) for e in exprs)

    changed = replace(
        form,
        parameters=tuple(p for p in form.parameters if p not in form.inputs),
        mass=tuple(map(on, form.mass)),
        rates=on(form.rates),
        force=on(form.force),
        definitions=on(form.definitions),
        stages=tuple(zip((n for n, _ in form.stages), on(e for _, e in form.stages), strict=True)),
        dependent=tuple(
            zip((n for n, _ in form.dependent), on(e for _, e in form.dependent), strict=True)
        ),
        inputs=(),
    )
    spelled = dict(zip(extras, on(extras.values()), strict=True))
    return changed, spelled, tuple(symbols.values())


@lru_cache(maxsize=128)  # a form is weighed first, and written with its extra quantities then
def _derivative(form: FirstOrderForm, known: tuple[Any, ...]) -> Block:
    """The cheaper of two ways to write it: expressions as they are, and with factors nested."""
    mass = form.mass
    single = {
        i: force / mass[i][i] if force != 0 else force
        for i, force in enumerate(form.force)
        if i not in coupled_rows(mass) and mass[i][i] != 0
    }
    left = [i for i in range(len(form.force)) if i not in single]
    rows = [[mass[i][j] for j in left] for i in left]
    blocks = eliminations(rows, form.parameters, form.relations, form.positive)
    exprs = [*form.rates, *single.values(), *(form.force[i] for i in left)]
    exprs += [e for block in blocks for e in block.expressions]
    # before sums are bracketed: what cancels in them is seen in their powers
    exprs, inner = stable_all(exprs), stable_all(e for _, e in form.stages)

    def write(change: Callable[[Any], Any]) -> Block:
        fresh = fresh_names(known)
        stages = [(name, change(e)) for (name, _), e in zip(form.stages, inner, strict=True)]
        common = share_subexpressions([change(e) for e in exprs], fresh, stages)
        return _eliminate(form, single, left, blocks, common, fresh)

    plain = write(se.sympify)
    if plain.operations > LONGEST_TO_NEST:
        return plain
    bracketed = write(lambda e: nest_sums(e, form.parameters))
    return min(plain, bracketed, key=lambda block: block.weight(form.parameters))


def _eliminate(
    form: FirstOrderForm, single: Mapping[int, Any], left: Sequence[int],
    blocks: Sequence[MassElimination], common: Block, fresh: Iterator[Any],
) -> Block:  # fmt: skip
    """Shared subexpressions first; then the elimination, on their names."""
    results, assignments = list(common.results), list(common.assignments)
    name = names_into(assignments, fresh)
    rates = [results.pop(0) for _ in form.rates]
    vdot = {i: results.pop(0) for i in single}
    force = [results.pop(0) for _ in left]
    for block in blocks:
        entries = [name(results.pop(0)) for _ in block.expressions]
        values = block.solve(entries, [force[i] for i in block.rows], name)
        vdot |= zip((left[i] for i in block.rows), values, strict=True)
    return prune(assignments, [*rates, *(vdot[i] for i in range(len(form.force)))])


def fresh_names(known: Iterable[Any], prefix: str = "c") -> Iterator[Any]:
    """Symbols c0, c1, ...; the prefix is repeated as long as a known name is of that form."""
    taken, letters = {str(s) for s in known}, prefix
    while any(n.startswith(prefix) and n[len(prefix) :].isdigit() for n in taken):
        prefix += letters
    return (se.Symbol(f"{prefix}{i}") for i in count())


def share_subexpressions(
    exprs: Sequence[Any], fresh: Iterator[Any], stages: Sequence[tuple[Any, Any]] = ()
) -> Block:
    """Common subexpressions of several expressions and of the stages they need, freshly named."""
    stages = prune(stages, exprs).assignments
    if not exprs:
        return Block((), ())
    replacements, reduced = se.cse(stable_all([*(e for _, e in stages), *exprs]))
    inner = [name for name, _ in stages]
    pending = dict([*replacements, *zip(inner, reduced, strict=False)])
    results = reduced[len(stages) :]
    names: dict[Any, Any] = {}
    assignments = []
    for old in needed_stages(pending, [*inner, *results]):
        expr = _rename(pending[old], names)
        if expr.args:
            names[old] = next(fresh)
            assignments.append((names[old], expr))
        else:
            names[old] = expr
    return Block(tuple(assignments), tuple(_rename(e, names) for e in results))


def _rename(expr: Any, names: Mapping[Any, Any]) -> Any:
    """An expression with its own symbols renamed: to hand over all names takes longer, in programs
    of many lines."""
    expr = se.sympify(expr)
    return expr.xreplace({s: names[s] for s in expr.free_symbols if s in names})


def prune(assignments: Sequence[tuple[Any, Any]], results: Sequence[Any]) -> Block:
    """Only what the results need."""
    needed = set().union(*(se.sympify(r).free_symbols for r in results)) if results else set()
    kept = []
    for name, expr in reversed(assignments):
        if name in needed:
            kept.append((name, expr))
            needed |= expr.free_symbols
    return Block(tuple(reversed(kept)), tuple(results))


def _check(place: str, exprs: Iterable[Any], known: Iterable[Any]) -> None:
    """Raise ``DefinitionError`` for what has no value: unknown functions and symbols."""
    allowed = {k for k in known if isinstance(k, se.Symbol)}
    for node in nodes(map(se.sympify, exprs)):
        if node in allowed:
            continue
        if isinstance(node, se.Symbol):
            raise DefinitionError(
                f"{place}: '{node}' is neither a coordinate, a velocity, a parameter nor the time; "
                "it has no value along a motion"
            )
        if is_atom(node):
            raise DefinitionError(
                f"{place}: the function '{node}' is unknown; put an expression in its place "
                "before evaluating numerically"
            )


def without_stages(
    form: FirstOrderForm, exprs: Mapping[str, Any]
) -> tuple[FirstOrderForm, dict[str, Any]]:
    """A form, and expressions on it, without stages."""
    known: dict[Any, Any] = {}
    for name, expr in form.stages:
        known[name] = expr.xreplace(known)

    def change(expr: Any) -> Any:
        return se.sympify(expr).xreplace(known)

    return _change_form(replace(form, stages=()), change), {n: change(e) for n, e in exprs.items()}


def with_plain_roots(form: FirstOrderForm, still: frozenset[Any] | None = None) -> FirstOrderForm:
    """A form without roots of squares and derivatives of signs; the same one where it has none.

    Squares of ``still`` symbols stay, of all parameters where it is not given.
    """
    exprs = [*form.expressions, *(e for _, e in form.stages)]
    known: dict[Any, Any] = {}
    still = frozenset(form.parameters) if still is None else still
    if spelled := write_roots_out(exprs, dict(form.stages), still):
        form = _change_form(form, lambda e: se.sympify(e).xreplace(spelled))
    elif all(plain_roots(e, still, known) == e for e in map(se.sympify, exprs)):
        return form
    return _change_form(form, lambda e: plain_roots(se.sympify(e), still, known))


def with_choices(form: FirstOrderForm, given: FirstOrderForm) -> FirstOrderForm:
    """A form that chooses between the sides of its switching surfaces; the same one where it has
    none.

    ``given`` is the same form as it was written, in which cases stand apart: over one denominator
    a case that is not in force divides the others by zero.
    """
    plain = with_plain_roots(form)
    exprs = [*plain.expressions, *(e for _, e in plain.stages)]
    if not any(map(holds_switches, exprs)):
        return form
    if plain.stages and evaluation_weight(given.expressions) <= 2 * evaluation_weight(exprs):
        plain = with_plain_roots(given)
    if not plain.stages:
        # with |k x| of a parameter k in two parts Max(0, k x) would not be seen to vanish
        return _choose_entries(plain, with_plain_roots(given, frozenset()))
    return _change_form(plain, choose_sides)


def _choose_entries(form: FirstOrderForm, given: FirstOrderForm) -> FirstOrderForm:
    """A form without stages with choices in its entries, made in those of the form as it was given
    wherever these hold switching surfaces; what holds none stands beside them in its shortest
    form."""
    sources = dict(zip(form.expressions, given.expressions, strict=True))
    moving = (form.time, *form.coordinates, *form.velocities)

    def short(expr: Any) -> Any:
        if distance_powers([expr], moving):
            return expr
        try:
            shortened = shortest([expr], form.relations)
        except EngineLimit:
            return expr
        return expr if loses_quotients([expr], lambda: shortened) else shortened[0]

    def settle(expr: Any) -> Any:
        if not holds_switches(expr) and not holds_choices(expr):
            return min(expr, short(expr), key=lambda e: operation_count([e]))
        return expr.func(*map(settle, expr.args)) if holds_choices(expr) else expr

    def change(entry: Any) -> Any:
        if not holds_switches(entry):
            return entry
        terms = summands(choose_sides(sources[entry]))
        chosen = [t for t in terms if holds_choices(t)]
        smooth = se.Add(*[t for t in terms if t not in chosen])
        if not chosen:
            return entry
        return se.Add(short(smooth), *map(settle, chosen))

    return _change_form(form, change)


def _change_form(form: FirstOrderForm, change: Callable[[Any], Any]) -> FirstOrderForm:
    return replace(
        form,
        rates=tuple(map(change, form.rates)),
        force=tuple(map(change, form.force)),
        mass=tuple(tuple(map(change, row)) for row in form.mass),
        stages=tuple((name, change(e)) for name, e in form.stages),
    )
