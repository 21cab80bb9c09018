"""Control-affine form x' = f(x) + sum_i g_i(x) u_i, and what its Lie brackets say.

Accessible: the Lie algebra of f and g_i has full rank (the rank condition
[SussmannJurdjevic1972]).  Small-time locally controllable at an equilibrium: the rank is full there
and every bad bracket, of odd degree in f and even degree in every g_i, is a combination of brackets
of lower degree [Sussmann1987, th. 7.3].  With one input it is not, where [g, [f, g]] is no
combination of g, [f, g], [f, [f, g]], ... [Sussmann1983, prop. 6.3].

Flat outputs are sought by dynamic extension.  Each output y_j is differentiated until inputs
appear, y_j^(r_j) = b_j + A_j u.  Where A has full rank and r_1 + r_2 + ... is the dimension of the
state, the state is a function of the outputs and their rates, and so are the inputs.  Where the
rank is smaller, the highest rates of as many outputs as are independent become inputs w = b + A u,
and then, one integrator more, coordinates of a larger state: the algorithm of [Isidori1995, sect.
5.4], which ends where the outputs are flat.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.branches import Branches, has_branches
from voronec.algebra.elimination import solve_linear
from voronec.algebra.graphs import nodes
from voronec.algebra.jets import Expansion, FieldJet, Span
from voronec.algebra.matrices import change_entries, determinant
from voronec.algebra.normal import canonical
from voronec.algebra.precision import BRACKETS
from voronec.algebra.rank import generic_rows
from voronec.algebra.symbols import plain_name
from voronec.algebra.tape import Tape
from voronec.algebra.text import as_expression
from voronec.algebra.typeset import plain_text
from voronec.algebra.verdicts import Verdict, decide_zero
from voronec.equations.connection import AffineForms
from voronec.equations.definition import read
from voronec.equations.derivation import Derivation
from voronec.equations.derived_equations import DerivedEquations
from voronec.equations.distribution import along, close_under_brackets
from voronec.equations.flags import flag
from voronec.equations.vector_field import VectorField, on_coordinates
from voronec.errors import DefinitionError, EngineLimit, did_you_mean

Vector = tuple[Any, ...]
DEGREES = 4, 6, 8, 10, 12
"""Brackets of these degrees are made at a point, one after the other, until they suffice."""
LONGEST = 400
"""Determinants of more operations are not factored."""


@dataclass(frozen=True)
class Accessibility:
    """The dimensions of g_i, of these with their brackets with f and g_i, and so on, at a generic
    point, of the ``dimension`` of the state; ``verdict`` on strong accessibility there, for almost
    all parameters.  Where it is proved, it holds wherever none of the ``exceptions`` vanishes: the
    factors of one determinant, so that other brackets may help there."""

    growth: tuple[int, ...]
    dimension: int
    verdict: Verdict
    exceptions: tuple[sp.Expr, ...] = ()


@dataclass(frozen=True, repr=False)
class Control:
    """x' = f + sum_i g_i u_i in the user's symbols: ``state`` are coordinates, then velocities;
    ``drift`` is f (n x 1), the columns of ``fields`` (n x m) are g_i."""

    system_field: VectorField
    inputs: tuple[sp.Expr, ...]
    inner_drift: Vector
    inner_fields: tuple[Vector, ...]
    equations: DerivedEquations

    @property
    def state(self) -> tuple[sp.Expr, ...]:
        """Coordinates, then velocities."""
        system = self.system_field.system
        return (*system.coordinates, *system.velocities)

    @cached_property
    def drift(self) -> sp.ImmutableMatrix:
        """f: the rates without inputs, n x 1."""
        return self._outward([[e] for e in self.inner_drift])

    @cached_property
    def fields(self) -> sp.ImmutableMatrix:
        """g_i, the rates by inputs: n x m."""
        return self._outward([list(row) for row in zip(*self.inner_fields, strict=True)])

    def _outward(self, rows: list[list[Any]]) -> sp.ImmutableMatrix:
        return self.system_field.bridge.outward_matrix(rows)

    def __repr__(self) -> str:
        names = (", ".join(map(plain_name, part)) for part in (self.state, self.inputs))
        name = self.system_field.system.name
        return "Control({!r}, state=({}), inputs=({}))".format(name, *names)

    @cached_property
    def underactuation(self) -> int:
        """How many velocities the inputs do not reach: n_v less the rank of g_i at a generic
        point."""
        first = len(self.system_field.positions)
        rows = [g[first:] for g in self.inner_fields]
        return len(self.system_field.velocities) - len(self._independent(rows))

    @cached_property
    def accessibility(self) -> Accessibility:
        """Strong accessibility at a generic point: reachable sets at one time have inner points.

        A full rank is proved by balls at one point, or modulo a prime where brackets are too large,
        and so holds on an open dense set, or near the point where signs and roots in the fields may
        turn; a smaller one by normal forms.
        """
        self._require_still()
        drift, fields = self._after_feedback
        dimension = self.system_field.dimension
        closure = close_under_brackets(
            (drift, *fields), fields, self._bracket, self._independent, dimension
        )
        frame, growth = closure.frame, closure.growth
        if not frame:
            nothing = Verdict("refuted", "the inputs move nothing, in normal form")
            return Accessibility(growth, dimension, nothing)
        shown, why = "in ball arithmetic", "brackets are too large"
        if closure.made is None and not self.system_field.relations:
            variables = self.system_field.variables
            with suppress(EngineLimit):
                growth = flag((drift, *fields), fields, self._bracket, tuple, variables, dimension)
                shown, why = "modulo a prime", "brackets span no more at a random point"
        if growth[-1] < dimension:
            words = f"{why} after dimension {growth[-1]} of {dimension}"
            otherwise = partial(Verdict, "undecided", words)
            if closure.made is not None:
                otherwise = partial(self._closure, frame, closure.made)
            return Accessibility(growth, dimension, self._on_leaves(otherwise))
        words = f"the brackets span all {dimension} dimensions at a point, {shown}, and so"
        where = (
            "near it" if self._has_switches else "on an open dense set, for almost all parameters"
        )
        proof = Verdict("proved", f"{words} {where}")
        exceptions = self._exceptions(frame)
        if closure.made is not None and fields is not self.inner_fields:
            # where the inputs do not reach, nor does the feedback
            first = len(self.system_field.positions)
            exceptions += self._exceptions([g[first:] for g in self.inner_fields])
        return Accessibility(growth, dimension, proof, tuple(dict.fromkeys(exceptions)))

    @cached_property
    def _has_switches(self) -> bool:
        """Whether signs, floors and roots in the fields may turn: what holds on one side of a
        switching surface need not hold on the other."""
        exprs = [e for field in (self.inner_drift, *self.inner_fields) for e in field]
        moving = frozenset(s for e in exprs for s in e.free_symbols)
        for e in exprs:
            if has_branches([e], moving):
                branches = Branches(e, moving, meets_poles=False)
                if any(True for _ in branches.branch_cuts()) or branches.unclear:
                    return True
        return False

    def _exceptions(self, frame: Sequence[Vector]) -> tuple[sp.Expr, ...]:
        """The factors of the determinant of as many fields as there are dimensions; none where it
        is beyond the budget, or relations bind the state."""
        if len(frame) != len(frame[0]):
            return ()
        try:
            volume = self.system_field.bridge.outward(canonical([determinant(frame)])[0])
        except EngineLimit:
            return ()
        above = sp.fraction(sp.together(volume))[0]
        if sp.count_ops(above) > LONGEST:
            return (above,)
        return tuple(f for f, _ in sp.factor_list(above)[1] if not f.is_number)

    def _on_leaves(self, otherwise: Callable[[], Verdict]) -> Verdict:
        """Refuted, where the constraints alone keep motions from most places, whatever moves them:
        a few small fields, where those of the state may be too large; else what is said of these.
        """
        holds, count = self.equations.distribution, 0
        with suppress(EngineLimit):
            count = len(self.equations.integrable)
        if holds.timed or not count:
            return otherwise()
        places = f"{holds.dimension - count} of their {holds.dimension} dimensions, in normal form"
        return Verdict("refuted", f"the constraints keep coordinates on surfaces of {places}")

    def _closure(self, frame: Sequence[Vector], brackets: Sequence[Vector]) -> Verdict:
        """That brackets lie in a span which is not everything."""
        words = f"the brackets span {len(frame)} dimensions of {self.system_field.dimension}"
        rows, right = [list(r) for r in zip(*frame, strict=True)], [[se.Integer(0)]] * len(frame[0])
        if brackets:
            right = [list(r) for r in zip(*brackets, strict=True)]
        try:
            solved = solve_linear(rows, right, self.system_field.hypotheses)
        except EngineLimit as limit:
            return Verdict("undecided", f"{words} at a generic point ({limit})")
        if solved.contradictory:
            return Verdict("undecided", f"{words} at a generic point, in numbers")
        where = (
            "off the switching surfaces where signs turn"
            if self._has_switches
            else "on the whole domain"
        )
        return Verdict("refuted", f"{words} {where}: they are closed, in normal form")

    def controllability(self, point: Mapping[Any, Any] | None = None) -> Verdict:
        """Small-time local controllability at an equilibrium, proved by Sussmann's condition.

        ``point`` gives coordinates, velocities, parameters and inputs by symbol or name: zero, and
        the defaults of the parameters, where nothing is said.  With inputs w that hold it there, f
        is f + sum_i g_i w_i and the others are small changes of them.  It is ``refuted`` where the
        system has one input and [g, [f, g]] obstructs, or where brackets are closed, so that states
        stay on surfaces; ``undecided`` names what is lacking.  ``DefinitionError`` where the point
        is no equilibrium; ``EngineLimit`` where values there are not rational.
        """
        self._require_still()
        at, held = self._point(point or {})
        form = self if self._has_values(at) else self._derive_near(at)
        control = form._with_inputs(held)
        control._require_equilibrium(at)
        words = f"brackets up to degree {DEGREES[-1]} do not span all dimensions at the point"
        verdict: Verdict | None = None
        for degree in DEGREES:
            verdict = _Brackets(control, at, degree).verdict
            if verdict is not None:
                break
        if (verdict is None or verdict.undecided) and self.accessibility.verdict.refuted:
            return self.accessibility.verdict
        return Verdict("undecided", words) if verdict is None else verdict

    def _has_values(self, at: Mapping[Any, Any]) -> bool:
        """Whether drift and fields are defined at a point as they are written."""
        exprs = [e for field in (self.inner_drift, *self.inner_fields) for e in field]
        values = (as_expression(se.sympify(e).xreplace(dict(at))) for e in exprs)
        return not any(value.has(sp.nan, sp.zoo, sp.oo) for value in values)

    def _derive_near(self, at: Mapping[Any, Any]) -> Control:
        """The form whose elimination has pivots that do not vanish at a point, where it can."""
        definition = read(self.equations.system, {str(s): as_expression(x) for s, x in at.items()})
        raw, exact = (Derivation(definition, tidy) for tidy in (False, True))
        return control_form(replace(self.equations, definition=definition, raw=raw, exact=exact))

    def _with_inputs(self, values: Sequence[Any]) -> Control:
        """The control form with inputs that are counted from these values."""
        if all(w == 0 for w in values):
            return self
        drift = list(self.inner_drift)
        for w, g in zip(values, self.inner_fields, strict=True):
            drift = [f + w * e for f, e in zip(drift, g, strict=True)]
        return replace(self, inner_drift=tuple(drift))

    def flat(self, outputs: Sequence[Any]) -> Verdict:
        """Whether state and inputs are functions of ``outputs`` and finitely many of their rates,
        near a generic point; as many outputs as inputs, functions of the state.

        Proved by dynamic extension; ``refuted`` where the outputs can be steered at will, and the
        state still has dimensions that they do not see.
        """
        self._require_still()
        read = [self.system_field.read(as_expression(y)) for y in outputs]
        if len(read) != len(self.inputs):
            raise DefinitionError(
                f"{len(read)} flat outputs for {len(self.inputs)} inputs; name as many"
            )
        field = self.system_field
        redundant = len(field.independent_relations)
        try:
            return flatness(
                field.variables, *self._after_feedback, read, field.hypotheses, redundant,
                self._independent,
            )  # fmt: skip
        except EngineLimit as limit:
            return Verdict("undecided", str(limit))

    # -- what these are made of -----------------------------------------------------------

    @cached_property
    def _after_feedback(self) -> tuple[Vector, tuple[Vector, ...]]:
        """f and g_i after the feedback v' = u, where the inputs reach all velocities: it changes
        neither property; as they are where they do not."""
        if self.underactuation:
            return self.inner_drift, self.inner_fields
        first, size = len(self.system_field.positions), len(self.system_field.velocities)
        zero = se.Integer(0)
        drift = (*self.inner_drift[:first], *[zero] * size)
        unit = [[se.Integer(int(i == j)) for j in range(size)] for i in range(size)]
        moved = any(e != 0 for g in self.inner_fields for e in g[:first])
        if moved or len(self.inner_fields) != size:
            return self.inner_drift, self.inner_fields
        return drift, tuple((*[zero] * first, *row) for row in unit)

    def _bracket(self, x: Vector, y: Vector) -> Vector:
        """[X, Y] = X_j d_j Y - Y_j d_j X."""
        at = self.system_field.variables
        return tuple(along(x, b, at) - along(y, a, at) for a, b in zip(x, y, strict=True))

    def _independent(self, rows: Sequence[Vector]) -> list[int]:
        """The rows that enlarge the span of those before them at a generic point, in balls."""
        return generic_rows(rows, self.system_field.hypotheses, BRACKETS)

    def _require_still(self) -> None:
        clock = self.system_field.time
        if any(clock in e.free_symbols for v in (self.inner_drift, *self.inner_fields) for e in v):
            raise EngineLimit(
                f"system '{self.system_field.system.name}' depends on the time; make the time a "
                "coordinate to ask what is controllable"
            )

    def _point(self, point: Mapping[Any, Any]) -> tuple[dict[Any, Any], list[Any]]:
        """Exact numbers for all symbols in the engine's symbols, and for the inputs."""
        field = self.system_field
        system = field.system
        values: dict[Any, Any] = dict.fromkeys(field.variables, sp.Integer(0))
        names = {plain_name(q): s for q, s in zip(self.state, field.variables, strict=True)}
        pushes = {plain_name(u): se.Symbol(f"input {i}") for i, u in enumerate(self.inputs)}
        values |= dict.fromkeys(pushes.values(), sp.Integer(0))
        names |= pushes
        for parameter, inner in zip(system.parameters, field.parameters, strict=True):
            names[parameter.name] = inner
            if parameter.value is not None:
                values[inner] = parameter.value
        for key, value in point.items():
            name = key if isinstance(key, str) else plain_name(key)
            if name not in names:
                raise DefinitionError(
                    f"the point gives '{name}', which system '{system.name}' does not have"
                    f"{did_you_mean(name, names)}"
                )
            values[names[name]] = value
        missing = [name for name, s in names.items() if s not in values]
        if missing:
            raise DefinitionError(
                f"the point gives no value to '{missing[0]}' of system '{system.name}'; add it"
            )
        exact = {s: as_expression(x) for s, x in values.items()}
        numbers = {s: se.sympify(sp.nsimplify(x, rational=True) if x.is_Float else x)
                 for s, x in exact.items()}  # fmt: skip
        held = [numbers.pop(s) for s in pushes.values()]
        return numbers, held

    def _require_equilibrium(self, at: Mapping[Any, Any]) -> None:
        place = f"system '{self.system_field.system.name}'"
        for relation in self.system_field.relations:
            value = as_expression(relation.xreplace(dict(at)))
            if not value.equals(0):
                shown = plain_text(self.system_field.bridge.outward(relation))
                raise DefinitionError(
                    f"{place}: the point is off the relation {shown} = 0 between the coordinates; "
                    "give one on it"
                )
        for s, rate in zip(self.state, self.inner_drift, strict=True):
            value = as_expression(rate.xreplace(dict(at)))
            if value.has(sp.nan, sp.zoo, sp.oo):
                raise DefinitionError(
                    f"{place}: d{plain_name(s)}/dt has no value at the point; give another"
                )
            if not value.equals(0):
                raise DefinitionError(
                    f"{place}: the point is no equilibrium with these inputs, "
                    f"d{plain_name(s)}/dt = {value} there; give one where it rests"
                )


class _Brackets:
    """All brackets up to a degree at one point: how far they span, and whether one obstructs."""

    def __init__(self, control: Control, at: Mapping[Any, Any], degree: int) -> None:
        variables = control.system_field.variables
        expansion = Expansion(at, variables, degree - 1)
        fields = (control.inner_drift, *control.inner_fields)
        simple = (control._after_feedback[0], *control._after_feedback[1])
        if simple != fields and _regular(control, expansion) and _is_smooth(fields[0], at):
            fields = simple
        self._basis = [expansion.field(f) for f in fields]
        self._degree = degree
        self._dimension = control.system_field.dimension
        self._inputs = control.inputs

    @cached_property
    def verdict(self) -> Verdict | None:
        """Sussmann's condition; None where brackets of higher degree may decide."""
        if len(self._inputs) == 1 and self._is_obstructed():
            words = "with one input, [g, [f, g]] is no combination of g, [f, g], [f, [f, g]], ..."
            return Verdict("refuted", f"{words} at the point")
        span = Span()
        for degree, level in enumerate(self._levels(), start=1):
            for kind, fields in level.items():
                bad = kind[0] % 2 == 1 and all(n % 2 == 0 for n in kind[1:])
                if bad and any(span.remainder(field.value) for field in fields):
                    count = ", ".join(f"{n} times g{i}" for i, n in enumerate(kind) if i and n)
                    return Verdict(
                        "undecided",
                        f"a bracket of {kind[0]} times f{', ' + count if count else ''} is no "
                        "combination of brackets of lower degree: Sussmann's condition fails",
                    )
            for fields in level.values():
                for field in fields:
                    span.add(field.value)
            if len(span) == self._dimension:
                words = f"brackets up to degree {degree} span all {self._dimension} dimensions"
                return Verdict("proved", f"{words}, and no bad one obstructs [Sussmann1987]")
        return None

    def _is_obstructed(self) -> bool:
        """Whether [g, [f, g]] leaves the span of g, [f, g], [f, [f, g]], ... at the point.

        f vanishes there, so that these are g, A g, A^2 g, ... up to signs, A the linear part of f.
        """
        drift, push = self._basis
        linear = [parts[1] for parts in drift.components]
        along, vector = Span(), push.value
        while along.add(vector):
            vector = _apply_matrix(linear, vector)
        return bool(along.remainder(push.bracket(drift.bracket(push)).value))

    def _levels(self) -> Iterator[dict[tuple[int, ...], list[FieldJet]]]:
        """Brackets by degree, and there by how often each field occurs: a basis of the jets."""
        size = len(self._basis)
        units = [tuple(int(i == j) for j in range(size)) for i in range(size)]
        level = {unit: [field] for unit, field in zip(units, self._basis, strict=True)}
        for degree in range(1, self._degree + 1):
            yield level
            if degree == self._degree:
                return
            spans: dict[tuple[int, ...], Span] = {}
            longer: dict[tuple[int, ...], list[FieldJet]] = {}
            for i, first in enumerate(self._basis):
                for kind, fields in level.items():
                    counts = tuple(n + int(i == j) for j, n in enumerate(kind))
                    for field in fields:
                        made = first.bracket(field)
                        if spans.setdefault(counts, Span()).add(made.coefficients):
                            longer.setdefault(counts, []).append(made)
            level = longer


def _apply_matrix(linear: Sequence[Any], vector: Mapping[int, Any]) -> dict[int, Any]:
    """A matrix, its rows given as linear forms, times a vector."""
    product = {}
    for i, form in enumerate(linear):
        total = sum(c * vector.get(m.index(1), 0) for m, c in form.to_dict().items())
        if total != 0:
            product[i] = total
    return product


def _regular(control: Control, expansion: Expansion) -> bool:
    """Whether the inputs reach all velocities at the point itself."""
    first, span = len(control.system_field.positions), Span()
    values = [expansion.field(g[first:]).value for g in control.inner_fields]
    return sum(span.add(value) for value in values) == len(values)


def _is_smooth(drift: Vector, at: Mapping[Any, Any]) -> bool:
    """Whether no sign and no floor in the drift may jump at the point: inputs that are small cannot
    undo a jump."""
    jumps = [n for n in nodes(drift) if isinstance(n, (se.sign, se.floor))]
    near = [n.args[0].xreplace(dict(at)) for n in jumps]
    return all(
        a.is_Number and a != 0 and isinstance(n, se.sign) for n, a in zip(jumps, near, strict=True)
    )


def control_form(equations: DerivedEquations) -> Control:
    """The control-affine form of a system's equations.

    Raises ``DefinitionError`` where the system has no inputs, where one enters otherwise than
    linearly, and where the equations hold the rate of one.
    """
    system, definition = equations.system, equations.definition
    if not system.inputs:
        raise DefinitionError(f"system '{system.name}' has no inputs; declare inputs=(u,)")
    for name in equations.orders:
        raise DefinitionError(
            f"system '{system.name}': the equations hold '{name}dot', the rate of the input "
            f"'{name}'; make '{name}' a coordinate, whose velocity an input drives"
        )
    field = on_coordinates(equations)
    letters = {u: se.Symbol(f"input {i}") for i, u in enumerate(definition.inputs)}
    exprs = [se.sympify(e).xreplace(letters) for e in (*field.rates, *field.force)]
    held = set().union(*(se.sympify(e).xreplace(letters).free_symbols
                         for row in field.mass for e in row))  # fmt: skip
    forms = AffineForms.of(exprs, [*letters.values()])
    if isinstance(forms, int) or held & {*letters.values()}:
        symbols = held if not isinstance(forms, int) else exprs[forms].free_symbols
        name = next(plain_name(u) for u, s in zip(system.inputs, letters.values(), strict=True)
                    if s in symbols)  # fmt: skip
        raise DefinitionError(
            f"system '{system.name}': the input '{name}' enters nonlinearly, so there is no "
            "control-affine form; take what stands there as the input"
        )
    first = len(field.rates)
    columns = [(*row, o) for row, o in zip(forms.matrix[first:], forms.offset[first:], strict=True)]
    near = definition.near
    solved = (
        solve_linear(field.mass, columns, field.hypotheses, near=near).values if columns else []
    )
    with suppress(EngineLimit):
        solved = change_entries(equations.exact.polish, solved)
    fields = tuple(
        (*(row[k] for row in forms.matrix[:first]), *(row[k] for row in solved))
        for k in range(len(letters))
    )
    drift = (*forms.offset[:first], *(row[-1] for row in solved))
    return Control(field, system.inputs, drift, fields, equations)


FLAT_NODES = 30_000
"""Rates of more nodes are not differentiated again."""
Independent = Callable[[Sequence[tuple[Any, ...]]], list[int]]


@dataclass(frozen=True)
class _ExtendedSystem:
    """A system with integrators before some of its inputs: the rates of its ``state`` are ``drift``
    and ``fields``, one for each input."""

    state: tuple[Any, ...]
    drift: tuple[Any, ...]
    fields: tuple[tuple[Any, ...], ...]
    relations: tuple[Any, ...]

    def relative_degree(self, output: Any) -> tuple[int, Any, tuple[Any, ...]] | None:
        """The order r at which inputs appear in the rates of an output, b and A; None where none
        do, or nobody can decide it."""
        for order in range(1, len(self.state) + 1):
            slopes = []
            for field in self.fields:
                slope = along(field, output, self.state)
                verdict = decide_zero(slope, self.relations)
                if verdict.undecided:
                    return None
                slopes.append(se.Integer(0) if verdict.proved else slope)
            output = along(self.drift, output, self.state)
            if any(slope != 0 for slope in slopes):
                return order, output, tuple(slopes)
            if Tape([output]).size > FLAT_NODES:
                return None
        return None

    def prolong(
        self, rows: Sequence[tuple[Any, ...]], offsets: Sequence[Any], independent: Independent
    ) -> _ExtendedSystem:
        """The system whose inputs are the rates of w = b + A u, rows of full rank, and what is left
        of u."""
        columns = independent(list(zip(*rows, strict=True)))
        others = [k for k in range(len(self.fields)) if k not in columns]
        square = [[row[c] for c in columns] for row in rows]
        unit = range(len(rows))
        right = [
            [se.Integer(int(i == k)) for k in unit] + [-offsets[i], *(-row[k] for k in others)]
            for i, row in enumerate(rows)
        ]
        solved = solve_linear(square, right, self.relations).values
        fresh = tuple(se.Symbol(f"rate {len(self.state) + i}") for i in unit)
        drift, moved = list(self.drift), [list(self.fields[k]) for k in others]
        for c, values in zip(columns, solved, strict=True):
            given = se.Add(values[len(unit)], *[values[k] * fresh[k] for k in unit])
            drift = [f + g * given for f, g in zip(drift, self.fields[c], strict=True)]
            for field, share in zip(moved, values[len(unit) + 1 :], strict=True):
                field[:] = [f + g * share for f, g in zip(field, self.fields[c], strict=True)]
        with suppress(EngineLimit):
            drift = canonical(drift, self.relations)
        zero, size = se.Integer(0), len(self.state)
        integrators = [(*[zero] * size, *(se.Integer(int(i == k)) for i in unit)) for k in unit]
        return _ExtendedSystem(
            (*self.state, *fresh),
            (*drift, *[zero for _ in unit]),
            (*integrators, *((*field, *[zero for _ in unit]) for field in moved)),
            self.relations,
        )


def flatness(
    state: Sequence[Any], drift: Sequence[Any], fields: Sequence[Sequence[Any]],
    outputs: Sequence[Any], relations: Sequence[Any], redundant: int, independent: Independent,
) -> Verdict:  # fmt: skip
    """Whether outputs are flat; ``independent`` gives the rows that are so at a generic point, and
    ``redundant`` variables of the state are bound by relations."""
    system = _ExtendedSystem(
        tuple(state), tuple(drift), tuple(map(tuple, fields)), tuple(relations)
    )
    for _ in range(len(system.state)):
        met = [system.relative_degree(y) for y in outputs]
        degrees = [m for m in met if m is not None]
        if len(degrees) < len(met):
            return Verdict("undecided", "an output holds no input, whatever its rates, or too much")
        rows = [row for _, _, row in degrees]
        kept = independent(rows)
        if len(kept) == len(rows):
            total = sum(order for order, _, _ in degrees)
            size = len(system.state) - redundant
            if total == size:
                words = f"the outputs and {max(order for order, _, _ in degrees)} of their rates"
                return Verdict("proved", f"{words} determine state and inputs near generic states")
            words = f"{total} rates of the outputs are independent, and the state has {size}"
            return Verdict("refuted", f"{words} dimensions: a motion is left that they do not see")
        offsets = [degrees[k][1] for k in kept]
        system = system.prolong([rows[k] for k in kept], offsets, independent)
    return Verdict("undecided", f"{len(state)} times as many integrators do not suffice")
