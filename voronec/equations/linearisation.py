"""Equations of motion to first order about a point or a motion, exactly.

    qdot = R(q, v, t, w),   M(q) vdot = F(q, v, t, w)

    d(dq)/dt = R_q dq + R_v dv + R_w dw
    M d(dv)/dt = (F_q - M_q a) dq + F_v dv + F_w dw,     M a = F at the point

w are the inputs.  Where relations bind the coordinates, dq = C dx with the independent ones x.

Expressions go to first order node by node, value and slopes together: at a point most of what a
derivation writes is zero or a number, so that no derivative of the whole is ever written out.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from itertools import islice, product
from math import log
from typing import Any

import mpmath as mp
import symengine as se
import sympy as sp

from voronec.algebra.arguments import VALUES, Kind, accepts
from voronec.algebra.cardinal import cardinal_all
from voronec.algebra.elimination import solve_linear
from voronec.algebra.graphs import is_atom, is_flat
from voronec.algebra.normal import shortest
from voronec.algebra.numeric_functions import QUOTIENTS, formula, numeric_name
from voronec.algebra.points import sample_evaluable
from voronec.algebra.precision import GENERIC
from voronec.algebra.rank import independent_rows
from voronec.algebra.symbols import plain_name, time
from voronec.algebra.tape import Tape, middle
from voronec.algebra.terms import atoms, expand_short, is_exponential, subexpressions
from voronec.algebra.typeset import plain_text
from voronec.declaration.reading import expression, quote
from voronec.equations.derivation import Derivation
from voronec.equations.derived_equations import DerivedEquations
from voronec.equations.evaluation import jets
from voronec.equations.program.jacobian import weighted_sum
from voronec.errors import DefinitionError, EngineLimit, did_you_mean

FirstOrder = tuple[Any, dict[int, Any]]
"""The value, and the slopes along the variables by their positions where they do not vanish."""

CHOP = 10
"""Digits below those asked for, from which on a part of an eigenvalue is taken for zero."""
LONG = 50
"""A number of so many parts is long."""
_NOT_FINITE = (se.zoo, se.nan, se.oo)
_STEPS = (se.sign, se.floor)


def expand(
    exprs: Sequence[Any], variables: Sequence[Any], point: Mapping[Any, Any]
) -> list[FirstOrder]:
    """Each expression to first order in the variables, at a point {atom: expression}.

    Raises ``EngineLimit`` where an expression has no finite value there.
    """
    known: dict[Any, FirstOrder] = {}
    for k, x in enumerate(variables):
        known[x] = (point.get(x, x), {k: se.Integer(1)})
    return [_expand(se.sympify(e), known, point) for e in exprs]


def _expand(expr: Any, known: dict[Any, FirstOrder], point: Mapping[Any, Any]) -> FirstOrder:
    expansion = known.get(expr)
    if expansion is None:
        expansion = _first_order(expr, known, point)
        if any(part in _NOT_FINITE for part in (expansion[0], *expansion[0].args)):
            raise EngineLimit(f"'{expr}' has no finite value at the point")
        known[expr] = expansion
    return expansion


def _first_order(expr: Any, known: dict[Any, FirstOrder], point: Mapping[Any, Any]) -> FirstOrder:
    if is_atom(expr):
        return point.get(expr, expr), {}
    if is_flat(expr) or not expr.args:
        return (se.Integer(0) if is_flat(expr) else expr), {}
    if isinstance(expr, se.Mul):
        return _product_of(expr.args, known, point)
    parts = [_expand(a, known, point) for a in expr.args]
    if isinstance(expr, se.Add):
        return se.Add(*[v for v, _ in parts]), weighted_sum([(se.Integer(1), s) for _, s in parts])
    values = [v for v, _ in parts]
    if numeric_name(expr) is not None:
        return _quotient(expr, parts[0], known, point)
    value = expr.func(*values)
    root = isinstance(expr, se.Pow) and values[0] == 0 and values[1].is_Number and values[1] < 1
    edge = isinstance(expr, (se.asin, se.acos, se.acosh)) and abs(values[0]) == 1
    moves = any(known[s][1] for s in expr.args[0].free_symbols if s in known)
    if moves and (root or edge or _is_on_step(expr, values)):
        words = "has no value" if root and values[1] < 0 else "has a corner or a step"
        raise EngineLimit(f"'{expr}' {words} there")
    moving = [i for i, (_, slopes) in enumerate(parts) if slopes]
    if not moving or isinstance(expr, _STEPS):
        return value, {}
    names = [se.Symbol(f"argument {i}") for i in range(len(parts))]
    form, at = expr.func(*names), dict(zip(names, values, strict=True))
    if isinstance(expr, se.Pow) and moving == [0]:
        form = names[0] ** values[1]
    return value, weighted_sum([(form.diff(names[i]).xreplace(at), parts[i][1]) for i in moving])


def _quotient(
    expr: Any, inner: FirstOrder, known: dict[Any, FirstOrder], point: Mapping[Any, Any]
) -> FirstOrder:
    """A quotient such as sin(w)/w by its series at w = 0, which is even; elsewhere by its
    formula."""
    name = numeric_name(expr)
    if inner[0] != 0 or name not in QUOTIENTS:
        return _expand(formula(expr), known, point)
    p, q = QUOTIENTS[name].coefficient(0)
    return se.Integer(p) / q, {}


def _is_on_step(expr: Any, values: Sequence[Any]) -> bool:
    """Whether a function jumps where its first argument moves, slowly or not: from one whole number
    to another, or, an angle, by a turn or by half of one."""
    if isinstance(expr, se.atan2):
        return bool(values[0] == 0 and values[1].is_negative)
    if isinstance(expr, se.floor):
        return bool(values[0].is_Number and float(values[0]).is_integer())
    return isinstance(expr, se.sign | se.acot) and bool(values[0] == 0)


def _product_of(
    factors: Sequence[Any], known: dict[Any, FirstOrder], point: Mapping[Any, Any]
) -> FirstOrder:
    """A product; one factor may have a corner where the others vanish: f |g| with f = 0, as in
    drag by v |v|, has the slope f' |g|.  Where f' vanishes, too, factors may jump: v^2 sign(v)."""
    parts, corner, reason = list[FirstOrder](), list[Any](), None
    for factor in factors:
        try:
            parts.append(_expand(factor, known, point))
        except EngineLimit as limit:
            corner.append(factor)
            reason = limit
    value, slopes = _product(parts)
    if reason is None:
        return value, slopes
    flat = value == 0 and not any(slope != 0 for slope in slopes.values())
    if flat and all(_is_bounded(factor, known, point) for factor in corner):
        return value, {}
    height = _height(corner[0], known, point) if len(corner) == 1 and value == 0 else None
    if height is None:
        raise reason
    return value, weighted_sum([(height, slopes)])


def _height(expr: Any, known: dict[Any, FirstOrder], point: Mapping[Any, Any]) -> Any:
    """The value of what is continuous at the point, corner or not; None of all else."""
    with suppress(EngineLimit):
        return _expand(expr, known, point)[0]
    root = isinstance(expr, se.Pow) and expr.args[1].is_Number and expr.args[1] > 0
    if not (root or isinstance(expr, (se.Add, se.Mul))):
        return None
    heights = [_height(a, known, point) for a in expr.args]
    height = None if any(h is None for h in heights) else expr.func(*heights)
    return None if height in _NOT_FINITE else height


def _is_bounded(expr: Any, known: dict[Any, Any], point: Mapping[Any, Any]) -> bool:
    """Whether an expression stays finite near the point, where it may jump."""
    if isinstance(expr, (se.sign, se.atan2, se.acot)) or _height(expr, known, point) is not None:
        return True
    power = isinstance(expr, se.Pow) and expr.args[1].is_Number and expr.args[1] > 0
    if not (power or isinstance(expr, (se.Add, se.Mul, se.floor))):
        return False
    return all(_is_bounded(a, known, point) for a in expr.args)


def _product(parts: Sequence[FirstOrder]) -> FirstOrder:
    total: FirstOrder = (se.Integer(1), {})
    for value, slopes in parts:
        total = total[0] * value, weighted_sum([(value, total[1]), (total[0], slopes)])
    return total


@dataclass(frozen=True, repr=False)
class Linearisation:
    """dx/dt = A dx + B dw about ``point``, to first order, in SymPy's matrices.

    ``state`` are the variables x, independent coordinates before velocities, N of them, ``inputs``
    those of w, m of them.  ``A`` is N x N, ``B`` N x m; ``rates``, N x 1, is dx/dt of the point
    itself.  Entries hold what the point leaves open, parameters above all.
    """

    equations: DerivedEquations
    point: Mapping[str, sp.Expr]
    state: tuple[sp.Expr, ...]
    inputs: tuple[sp.Expr, ...]
    A: sp.ImmutableMatrix
    B: sp.ImmutableMatrix
    rates: sp.ImmutableMatrix

    def __repr__(self) -> str:
        names = (", ".join(map(plain_name, part)) for part in (self.state, self.inputs))
        return "Linearisation({!r}, state=({}), inputs=({}))".format(
            self.equations.system.name, *names
        )

    def of(self, *variables: Any) -> Linearisation:
        """That of some of the variables, symbols or names, where the others do not act on them.

        Raises ``DefinitionError``, which names one that does.
        """
        names = [plain_name(x) for x in self.state]
        for x in map(plain_name, variables):
            if x not in names:
                wrong = f"'{quote(x)}' is no variable of the linearisation"
                raise DefinitionError(wrong + did_you_mean(x, names))
        kept = [names.index(plain_name(x)) for x in variables]
        for j in set(range(len(names))) - {*kept}:
            for i in kept:
                if self.A[i, j] != 0:
                    raise DefinitionError(
                        f"the rate of '{names[i]}' depends on '{names[j]}', which is not among "
                        "the variables; add it"
                    )
        return Linearisation(
            self.equations,
            self.point,
            tuple(self.state[i] for i in kept),
            self.inputs,
            self.A.extract(kept, kept),
            self.B.extract(kept, [*range(self.B.cols)]),
            self.rates.extract(kept, [0]),
        )

    def eigenvalues(self, values: Mapping[Any, Any] | None = None, digits: int = 15) -> list[Any]:
        """The eigenvalues of A as mpmath's complex numbers, by real part, then imaginary part.

        Real and imaginary parts below 10^-(digits + 10) are taken for zero: take more digits for
        eigenvalues as small as that.

        ``values`` give numbers, by symbol or name, to what A holds; parameters have their default
        values.  Raises ``DefinitionError`` for an unknown name, and where A holds what has no
        value.
        """
        system = self.equations.system
        given = {p.name: p.value for p in system.parameters if p.value is not None}
        given |= {plain_name(k): v for k, v in (values or {}).items()}
        held = {str(a) for a in self._tape.atoms}
        named = [*map(plain_name, (*system.coordinates, *system.velocities, *system.inputs)), *held]
        named += [p.name for p in system.parameters]
        for name in given.keys() - {*named, plain_name(time)}:
            raise DefinitionError(
                f"system '{system.name}': '{quote(name)}' is nothing that the matrix A could hold"
                f"{did_you_mean(name, named)}"
            )
        missing = [str(a) for a in self._tape.atoms if str(a) not in given]
        if missing:
            raise DefinitionError(
                f"the matrix A of system '{system.name}' holds '{missing[0]}', which has no "
                f"value; write eigenvalues({{'{missing[0]}': number}})"
            )
        size = self.A.rows
        largest = max((float(abs(e).log()) for e in self._tape.arb(given, GENERIC) if e != 0),
                      default=0.0)  # fmt: skip
        # an eigenvalue may be as many-fold as the matrix has rows, and then loses so many digits
        exact = 3.33 * (digits + CHOP) + max(0.0, largest / log(2))
        bits = GENERIC + int(max(size, 1) * exact)
        with mp.workprec(bits):
            balls = self._tape.arb(given, bits)
            if not all(ball.is_finite() for ball in balls):
                at = ", ".join(f"{a} = {quote(given[str(a)])}" for a in self._tape.atoms)
                raise DefinitionError(
                    f"the matrix A of system '{system.name}' has no finite value at {at}; give "
                    "other values"
                )
            matrix = mp.matrix(size, size)
            for k, ball in enumerate(balls):
                matrix[k // size, k % size] = middle(ball)
            spectrum = mp.eig(matrix, left=False, right=False)
            spectrum = [mp.mpc(mp.chop(e, mp.mpf(10) ** -(digits + CHOP))) for e in spectrum]
        with mp.workdps(digits):
            return sorted((+e for e in spectrum), key=lambda e: (e.real, e.imag))

    @cached_property
    def _tape(self) -> Tape:
        return Tape(self.equations.bridge.inward_all([*self.A]))


@accepts(
    equations=Kind(
        "the equations that voronec.derive gives", lambda x: isinstance(x, DerivedEquations)
    ),
    at=VALUES,
)
def linearise(equations: DerivedEquations, at: Mapping[Any, Any] | None = None) -> Linearisation:
    """The equations of motion to first order about a point or a motion: exact A and B.

    ``at`` gives, by symbol or name, values of coordinates, velocities of the equations, parameters,
    inputs and the time: numbers, or formulas in parameters, in ``vo.time`` (a motion) and in
    whatever is left open.  What is given no value stays a symbol, default values of parameters too.
    Relations between redundant coordinates are kept to first order: of them as many go as relations
    bind, so that the state is minimal.

    Raises ``DefinitionError`` where a name is unknown, where the equations are not defined at the
    point, where it is off a relation, or the mass matrix is singular there.
    """
    inside, read = _point(equations, at or {})
    reason, derivations = "", (equations.raw, equations.best)
    # quotients that have a value at the point are written as such at last
    writers: tuple[Callable[[Sequence[Any]], list[Any]], ...] = (list, cardinal_all)
    for write, angles_last, derivation in product(writers, (True, False), derivations):
        try:
            return _about(equations, derivation, inside, read, write, angles_last)
        except EngineLimit as limit:
            reason = reason or str(limit)
    raise DefinitionError(
        f"system '{equations.system.name}' has no linearisation at the point: {reason}; choose "
        "another point, or other coordinates"
    )


def _point(
    equations: DerivedEquations, at: Mapping[Any, Any]
) -> tuple[dict[Any, Any], dict[str, sp.Expr]]:
    """Values in the engine's symbols by what they replace there, and as they were read."""
    system, d = equations.system, equations.definition
    clock = se.Symbol(plain_name(time))
    atoms = {str(x): x for x in (*d.coordinates, *d.velocities, *d.parameters, clock)}
    atoms |= jets(system)
    inside, read = {}, {}
    for key, value in at.items():
        name = plain_name(key)
        if name not in atoms:
            raise DefinitionError(
                f"system '{system.name}': '{quote(name)}' at the point is no coordinate, velocity, "
                f"parameter, input or time{did_you_mean(name, [*atoms])}"
            )
        read[name] = expression(value, f"the value of '{name}'")
        inside[atoms[name]] = equations.bridge.inward(read[name])
    now = {clock: inside[clock]} if clock in inside else {}
    return {x: value.xreplace(now) for x, value in inside.items()}, read


def _about(
    equations: DerivedEquations,
    d: Derivation,
    point: dict[Any, Any],
    read: dict[str, sp.Expr],
    write: Callable[[Sequence[Any]], list[Any]],
    angles_last: bool,
) -> Linearisation:
    definition, form = d.definition, d.form
    inputs = [
        u for u in jets(equations.system).values() if u in definition.inputs or _holds(form, u)
    ]
    variables = [*definition.coordinates, *definition.velocities, *inputs]
    mass = [e for row in form.mass for e in row]
    exprs = write([*form.rates, *form.force, *mass, *definition.relations])
    late = _late(definition.parameters, _angles(exprs) if angles_last else (), point)
    point = {x: value for x, value in point.items() if x not in late}
    if late:  # corners and infinite values are seen by the values alone
        expand(exprs, variables, {**point, **late})
        exprs = _beside_steps(exprs, {**point, **late})
    rows = expand(exprs, variables, point)
    k, n, width = len(definition.coordinates), len(definition.velocities), len(variables)
    table = [rows[k + n + i * n : k + n + (i + 1) * n] for i in range(n)]
    _require_relations(equations, [value.xreplace(late) for value, _ in rows[k + n + n * n :]])
    kept, spread = _independent(rows[k + n + n * n :], k)
    vdot, slopes = _accelerations(table, rows[k : k + n], width)
    chained = [_chain_slopes(_row(rows[i], width), spread, k) for i in kept]
    chained += [_chain_slopes(row, spread, k) for row in slopes]
    values = [*(rows[i][0] for i in kept), *vdot]
    flat = _tidy([e for row in chained for e in row] + values, point, definition.relations, late)
    if any(part in _NOT_FINITE for e in flat for part in (e, *e.args)) or _divides_by_zero(flat):
        raise EngineLimit("the mass matrix is singular there, or a formula divides by zero")
    out = [equations.bridge.outward(e) for e in flat]
    size = len(values)
    full = sp.Matrix(size, size + len(inputs), out[: len(out) - size])
    return Linearisation(
        equations=equations,
        point=read,
        state=tuple(equations.bridge.outward(variables[i]) for i in (*kept, *range(k, k + n))),
        inputs=tuple(equations.bridge.outward(u) for u in inputs),
        A=sp.ImmutableMatrix(full[:, :size]),
        B=sp.ImmutableMatrix(full[:, size:]),
        rates=sp.ImmutableMatrix(size, 1, out[len(out) - size :]),
    )


def _spread(expr: Any) -> Any:
    """A long number as a quotient of sums: where terms cancel SymPy evaluates them again, with more
    digits, so that the time that it takes for nested ones doubles from level to level."""
    if expr.free_symbols or sum(1 for _ in islice(subexpressions([expr]), LONG)) < LONG:
        return expr
    above, below = expr.as_numer_denom()
    return expand_short(above) / expand_short(below)


def _divides_by_zero(exprs: Sequence[Any]) -> bool:
    """Whether a number in a denominator is zero, however it is written."""
    powers = atoms(exprs, se.Pow)
    below = [p.args[0] for p in powers if p.args[1].is_negative and not p.args[0].free_symbols]
    return any(ball.contains(0) for ball in Tape(below).arb({}, GENERIC))


def _require_relations(equations: DerivedEquations, values: Sequence[Any]) -> None:
    """Raise where a relation between the coordinates is not met at the point."""
    system = equations.system
    for relation, inner in zip(system.fibration.relations, values, strict=False):
        value = equations.bridge.outward(inner)
        if value.is_number and value.equals(0) is False:
            raise DefinitionError(
                f"system '{system.name}': the point does not lie on the relation "
                f"{plain_text(relation)} = 0, whose left side is {plain_text(value)} there; give "
                "coordinates that meet it"
            )


def _chain_slopes(slopes: Sequence[Any], spread: Sequence[Sequence[Any]], k: int) -> list[Any]:
    """Slopes by the independent coordinates in the place of those by all k."""
    columns = zip(*spread, strict=True)
    along = [se.Add(*[s * c for s, c in zip(slopes, column, strict=False)]) for column in columns]
    return [*along, *slopes[k:]]


def _late(
    parameters: Sequence[Any], angles: Collection[Any], point: Mapping[Any, Any]
) -> dict[Any, Any]:
    """Values that are put in at the end.  The sine of pi/10 is no root of rational numbers, that
    of a symbol is easy; sin(1/5) and cos(1/7) would be polynomials in functions of 1/35."""
    late = {p: point[p] for p in parameters if p in point and not _is_rational(point[p])}
    return late | {x: point[x] for x in angles if _is_ratio(point.get(x, 0))}


def _angles(exprs: Sequence[Any]) -> set[Any]:
    """What stands in sines and other smooth functions, and not in unknown ones, as the time in
    inputs."""
    functions = atoms(exprs, se.Function)
    unknown = {f for f in functions if is_atom(f)}
    smooth = functions - unknown | {*filter(is_exponential, atoms(exprs, se.Pow))}
    inside, outside = ({s for f in part for s in f.free_symbols} for part in (smooth, unknown))
    return inside - outside


def _beside_steps(exprs: list[Any], point: Mapping[Any, Any]) -> list[Any]:
    """Expressions with the values of functions that jump elsewhere."""
    flat = {}
    for node in atoms(exprs, *_STEPS):
        values = [a.xreplace(point) for a in node.args]
        if not values[0].free_symbols and not _is_on_step(node, values):
            flat[node] = node.func(*values)
    rest = [e.xreplace(flat) for e in map(se.sympify, exprs)]
    return rest if rest == exprs else _beside_steps(rest, point)


def _holds(form: Any, atom: Any) -> bool:
    return atom in atoms(form.expressions, type(atom))


def _is_ratio(value: Any) -> bool:
    return value != 0 and isinstance(value, se.Rational)


def _is_rational(value: Any) -> bool:
    return isinstance(value, se.Rational) or bool(value.free_symbols)


def _row(entry: FirstOrder, width: int) -> list[Any]:
    return [entry[1].get(j, se.Integer(0)) for j in range(width)]


def _accelerations(
    mass: Sequence[Sequence[FirstOrder]], force: Sequence[FirstOrder], width: int
) -> tuple[list[Any], list[list[Any]]]:
    """vdot at the point, and its slopes."""
    if not force:
        return [], []
    matrix = [[m for m, _ in row] for row in mass]
    first = solve_linear(matrix, [[f] for f, _ in force])
    if first.free:
        raise EngineLimit("the mass matrix is singular there")
    vdot = [row[0] for row in first.values]
    right = []
    for f, row in zip(force, mass, strict=True):
        slopes = _row(f, width)
        for (_, change), a in zip(row, vdot, strict=True):
            for j, slope in change.items():
                slopes[j] = slopes[j] - slope * a
        right.append(slopes)
    return vdot, solve_linear(matrix, right).values


def _independent(relations: Sequence[FirstOrder], k: int) -> tuple[list[int], list[list[Any]]]:
    """Which coordinates stay free to first order, and the slopes of all by these."""
    unit = [[se.Integer(int(i == j)) for j in range(k)] for i in range(k)]
    if not relations:
        return [*range(k)], unit
    slopes = [_row(r, k) for r in relations]
    samples = sample_evaluable(Tape([e for row in slopes for e in row]), (), GENERIC, count=1)
    if not samples:
        raise EngineLimit("the relations between the coordinates have no slopes there")
    values = samples[0][1]
    table = [values[i : i + k] for i in range(0, len(values), k)]
    rows = independent_rows(table, GENERIC)
    # coordinates at the end of the list are those of the fibre: they are given up first
    order = [*reversed(range(k))]
    columns = [[table[r][j] for r in rows] for j in order]
    bound = sorted(order[i] for i in independent_rows(columns, GENERIC))
    free = [j for j in range(k) if j not in bound]
    left = [[slopes[r][j] for j in bound] for r in rows]
    right = [[-slopes[r][j] for j in free] for r in rows]
    solution = solve_linear(left, right).values if free else [[] for _ in bound]
    spread = [[unit[i][j] for j in free] for i in range(k)]
    for j, row in zip(bound, solution, strict=True):
        spread[j] = row
    return free, spread


def _tidy(
    exprs: list[Any], point: Mapping[Any, Any], relations: Sequence[Any], late: Mapping[Any, Any]
) -> list[Any]:
    """In the shortest form, where that is within the budget, with the late values in it; relations
    as they are at the point."""
    bound = [r for r in (e.xreplace(dict(point)) for e in relations) if r != 0]
    try:
        return [_spread(se.sympify(e).xreplace(late)) for e in shortest(exprs, bound)]
    except EngineLimit:
        return [se.sympify(e).xreplace(late) for e in exprs]
