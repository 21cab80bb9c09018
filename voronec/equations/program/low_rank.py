"""Mass matrices that are diagonal plus one product, and how such equations are solved.

The mass of a body that rolls is mostly Lambda + s u u^T with constant Lambda: a ball's about its
contact is J - D gamma gamma^T.  Then, by Sherman and Morrison,

    x = Lambda^-1 (f + k u),   k = - s (u, Lambda^-1 f) / (1 + s (u, Lambda^-1 u)),

[Theory, eq. (22)],
which takes a product for each row where the elimination L D L^T takes one for each entry.

Nothing is inverted symbolically: the symmetric elimination M = L D L^T runs on names: what it
computes becomes assignments.  Pivots are chosen by structure (fewest neighbours first), so a
diagonal matrix costs nothing, independent blocks stay apart and a matrix of numbers folds into
numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations, count
from typing import Any

import symengine as se

from voronec.algebra.normal import canonical, quotient
from voronec.algebra.roots import known_sign
from voronec.algebra.terms import factors_of
from voronec.equations.program.weight import taylor_weight
from voronec.errors import DefinitionError, VoronecError

MOST = 12
"""Larger blocks, and blocks of longer entries than the next, are not looked at."""
LONGEST = 200
"""Operations in all entries; longer ones are no product of a few vectors in practice."""
ONE = se.Integer(1)


@dataclass(frozen=True)
class LowRank:
    """diag(``diagonal``) + ``scale`` u u^T, u ``column``; ``pivot`` is 1 + s (u, Lambda^-1 u)."""

    diagonal: tuple[Any, ...]
    scale: Any
    column: tuple[Any, ...]
    pivot: Any

    @property
    def expressions(self) -> tuple[Any, ...]:
        """All that the solution needs to know."""
        return (*self.diagonal, self.scale, *self.column, self.pivot)

    def solve(self, known: Sequence[Any], right: Sequence[Any], name: Name) -> list[Any]:
        """The solution for a right side, with names in the place of the expressions."""
        size = len(self.column)
        diagonal, scale, column, pivot = (
            known[:size], known[size], known[size + 1 : -1], known[-1],
        )  # fmt: skip
        right = [name(r) for r in right]
        rows = list(zip(diagonal, column, right, strict=True))
        above = name(se.Add(*[-scale / d * u * f for d, u, f in rows]))
        share = name(above / pivot)
        return [name(f / d + share * u / d) for d, u, f in rows]


@dataclass(frozen=True)
class MassElimination:
    """How some rows of mass * x = right are solved: ``solve(known, right, name)`` takes names for
    ``expressions`` and the right sides of ``rows``, and gives x of these rows."""

    rows: tuple[int, ...]
    expressions: tuple[Any, ...]
    solve: Callable[[Sequence[Any], Sequence[Any], Name], list[Any]]


def solve_mass(
    mass: Sequence[Sequence[Any]], right: Sequence[Any], name: Name,
    constants: Iterable[Any] = (), relations: Sequence[Any] = (), positive: Iterable[Any] = (),
) -> list[Any]:  # fmt: skip
    """The solution x of mass * x = right as names, by the cheapest stable elimination.

    ``constants`` are the symbols that do not move, ``positive`` those that are positive;
    ``relations`` vanish.  Raises ``DefinitionError`` for a matrix that is visibly singular.
    """
    solution: dict[int, Any] = {}
    for block in eliminations(mass, constants, relations, positive):
        known = [name(e) for e in block.expressions]
        values = block.solve(known, [right[i] for i in block.rows], name)
        solution.update(zip(block.rows, values, strict=True))
    return [solution[i] for i in range(len(right))]


def eliminations(
    mass: Sequence[Sequence[Any]],
    constants: Iterable[Any] = (), relations: Sequence[Any] = (), positive: Iterable[Any] = (),
) -> list[MassElimination]:  # fmt: skip
    """How the rows of a symmetric positive matrix are solved: blocks that are diagonal plus a
    product one by one, where that is cheaper and stable; the rest together by L D L^T."""
    constants, positive = list(constants), list(positive)
    blocks, left = [], [*range(len(mass))]
    for rows in _components(mass):
        block = tuple(tuple(mass[i][j] for j in rows) for i in rows)
        split = _stable(block, tuple(relations), tuple(positive))
        if split is None:
            continue
        low = MassElimination(rows, split.expressions, split.solve)
        if _weight(low, constants) < _weight(_triangular(block, range(len(rows))), constants):
            blocks.append(low)
            left = [i for i in left if i not in rows]
    return [*blocks, _triangular(mass, left)] if left else blocks


@lru_cache(maxsize=64)  # the same matrix comes back whenever its system is written as a program
def _stable(
    matrix: tuple[tuple[Any, ...], ...], relations: tuple[Any, ...], positive: tuple[Any, ...]
) -> LowRank | None:
    """The split of a matrix, where there is one and elimination by it is stable."""
    split = low_rank(matrix, relations)
    return split if split is not None and _is_stable(split, positive) else None


def low_rank(matrix: Sequence[Sequence[Any]], relations: Sequence[Any] = ()) -> LowRank | None:
    """A symmetric matrix with no zero entry as Lambda + s u u^T, exactly; None where it is not.

    The entries of u are without common factors or denominators; whether the parts off the diagonal
    agree is decided by normal forms.
    """
    size = len(matrix)
    if not 3 <= size <= MOST or any(matrix[i][j] == 0 for i, j in combinations(range(size), 2)):
        return None
    if int(se.count_ops(*[e for row in matrix for e in row])) > LONGEST:
        return None
    try:
        column = _column(matrix, relations)
        scale = canonical([matrix[0][1] / column[0] / column[1]], relations)[0]
        scale, column = _without_root(scale, column, relations)
        pairs = list(combinations(range(size), 2))
        gaps = [matrix[i][j] - scale * column[i] * column[j] for i, j in pairs]
        if any(gap != 0 for gap in canonical(gaps, relations)):
            return None
        squares = [matrix[i][i] - scale * u**2 for i, u in enumerate(column)]
        diagonal = canonical(squares, relations)
        if any(d == 0 for d in diagonal):
            return None
        pivot = ONE + se.Add(*[scale / d * u**2 for d, u in zip(diagonal, column, strict=True)])
        short = canonical([pivot], relations)[0]
    except VoronecError:
        return None
    return LowRank(tuple(diagonal), scale, tuple(column), _lighter(short, pivot, column))


def _column(matrix: Sequence[Sequence[Any]], relations: Sequence[Any]) -> Sequence[Any]:
    """u up to a factor: its ratios are those of the rows, its entries made whole and coprime."""
    last = len(matrix) - 1
    ratios = [ONE, *(matrix[i][last] / matrix[0][last] for i in range(1, last))]
    ratios.append(matrix[last][1] / matrix[0][1])
    for _ in range(len(matrix)):
        ratios = canonical(ratios, relations)
        below = [quotient(r, relations)[1] for r in ratios]
        fraction = next((b for b in below if b.free_symbols), None)
        if fraction is None:
            break
        ratios = [r * fraction for r in ratios]
    return ratios


def _without_root(
    scale: Any, column: Sequence[Any], relations: Sequence[Any]
) -> tuple[Any, Sequence[Any]]:
    """A square under s, such as sin(a)^2, goes into u where u stays whole: sines of an angle and
    its cosines have common factors that only their relation shows."""
    powers = [f.args for f in factors_of(scale) if isinstance(f, se.Pow)]
    below = [(b, e) for b, e in powers if e.is_Number and e < 0 and b.free_symbols]
    if not below or any(not isinstance(e, se.Integer) or int(e) % 2 for _, e in below):
        return scale, column
    root = se.Mul(*[se.Pow(b, -e / 2) for b, e in below])
    shorter = canonical([u / root for u in column], relations)
    if any(quotient(u, relations)[1].free_symbols for u in shorter):
        return scale, column
    return canonical([scale * root**2], relations)[0], shorter


def _lighter(short: Any, long: Any, column: Iterable[Any]) -> Any:
    """The form of the pivot with fewer products of what moves; the first where they tie."""
    moving = set().union(*(u.free_symbols for u in column))
    still = (short.free_symbols | long.free_symbols) - moving
    weights = [taylor_weight((), [e], still) for e in (short, long)]
    return long if weights[1] <= weights[0] and short.free_symbols & moving else short


def _is_stable(split: LowRank, positive: Iterable[Any]) -> bool:
    """Whether Lambda is proved positive, and s has one sign.

    For s <= 0 the pivot lies between 0 and 1, and is small only where the whole matrix is nearly
    singular; for s >= 0 it is a sum of positive terms.
    """
    known = [p > 0 for p in positive]
    return all(known_sign(d, known, strict=True) > 0 for d in split.diagonal) and bool(
        known_sign(split.scale, known)
    )


def _triangular(mass: Sequence[Sequence[Any]], rows: Iterable[int]) -> MassElimination:
    """L D L^T of the rows of a matrix."""
    chosen = tuple(rows)
    places = [(i, j) for a, i in enumerate(chosen) for j in chosen[: a + 1]]

    def solve(known: Sequence[Any], right: Sequence[Any], name: Name) -> list[Any]:
        half = dict(zip(places, known, strict=True))
        matrix = [[half[max(i, j), min(i, j)] for j in chosen] for i in chosen]
        return solve_symmetric(matrix, right, name)

    return MassElimination(chosen, tuple(mass[i][j] for i, j in places), solve)


def names_into(assignments: list[tuple[Any, Any]], fresh: Iterator[Any]) -> Name:
    """What names expressions: one that is more than a symbol or a number becomes an assignment."""

    def name(expr: Any) -> Any:
        if not expr.args:
            return expr
        assignments.append((next(fresh), expr))
        return assignments[-1][0]

    return name


def _weight(block: MassElimination, constants: Sequence[Any]) -> float:
    """The cost of an elimination for Taylor's method, for a right side that moves."""
    assignments: list[tuple[Any, Any]] = []
    name = names_into(assignments, (se.Symbol(f"_{i}") for i in count()))
    right = [se.Symbol(f"_f{i}") for i in block.rows]
    results = block.solve([name(e) for e in block.expressions], right, name)
    return taylor_weight(assignments, results, constants)


def _components(matrix: Sequence[Sequence[Any]]) -> Iterator[tuple[int, ...]]:
    """Sets of three and more rows that are coupled to each other and to nothing else."""
    left = coupled_rows(matrix)
    while left:
        reached, stack = set(), [min(left)]
        while stack:
            i = stack.pop()
            if i not in reached:
                reached.add(i)
                stack += [j for j in left if matrix[i][j] != 0]
        left -= reached
        if len(reached) > 2:
            yield tuple(sorted(reached))


Name = Callable[[Any], Any]
"""Gives an expression a name (an assignment) and returns the name; numbers pass unchanged."""


def coupled_rows(matrix: Sequence[Sequence[Any]]) -> set[int]:
    """Rows of a symmetric matrix that hold an entry off the diagonal."""
    size = len(matrix)
    return {i for i in range(size) for j in range(size) if i != j and matrix[i][j] != 0}


def solve_symmetric(matrix: Sequence[Sequence[Any]], right: Sequence[Any], name: Name) -> list[Any]:
    """The solution x of matrix * x = right, as names, by L D L^T.

    The matrix is symmetric and positive definite (any order of pivots is then stable), but for rows
    with a visible zero on the diagonal, as those of multipliers: these come last, where
    -a M^-1 a^T stands for the zeros, or else by pivots of size two.  Raises ``DefinitionError``
    where a row has nothing left to be solved for.
    """
    size = len(right)
    entries = {(i, j): matrix[i][j] for i in range(size) for j in range(i + 1) if matrix[i][j] != 0}
    rest, active = [name(r) for r in right], set(range(size))
    late = {i for i in active if matrix[i][i] == 0}
    steps: list[tuple[tuple[int, ...], dict[Any, Any], dict[Any, Any]]] = []
    while active:
        pivot = _pivot(entries, active - late or active)
        active -= set(pivot)
        inverse = _inverse(entries, pivot, name)
        lower = {
            (j, p): name(se.Add(*[_at(entries, j, k) * inverse[k, p] for k in pivot]))
            for j in sorted(active)
            for p in pivot
            if any(_at(entries, j, k) != 0 for k in pivot)
        }
        _reduce(entries, rest, pivot, lower, name)
        steps.append((pivot, inverse, lower))
    solution: dict[int, Any] = {}
    for pivot, inverse, lower in reversed(steps):
        for p in pivot:
            terms = [inverse[p, k] * rest[k] for k in pivot]
            terms += [-factor * solution[j] for (j, k), factor in lower.items() if k == p]
            solution[p] = name(se.Add(*terms))
    return [solution[i] for i in range(size)]


def _at(entries: dict[tuple[int, int], Any], i: int, j: int) -> Any:
    return entries.get((max(i, j), min(i, j)), se.Integer(0))


def _pivot(entries: dict[tuple[int, int], Any], active: set[int]) -> tuple[int, ...]:
    """The row with the fewest neighbours; a pair where every diagonal entry is a plain zero."""
    order = sorted(active)
    degree = {i: sum(_at(entries, i, j) != 0 for j in order if j != i) for i in order}
    single = [i for i in order if _at(entries, i, i) != 0]
    if single:
        return (min(single, key=lambda i: degree[i]),)
    pairs = [p for p in combinations(order, 2) if _at(entries, *p) != 0]
    if not pairs:
        raise DefinitionError(
            "the mass matrix is singular: after elimination nothing is left in row "
            f"{order[0] + 1}; give that velocity inertia, or remove it"
        )
    return min(pairs, key=lambda p: degree[p[0]] + degree[p[1]])


def _inverse(
    entries: dict[tuple[int, int], Any], pivot: tuple[int, ...], name: Name
) -> dict[tuple[int, int], Any]:
    if len(pivot) == 1:
        p = pivot[0]
        return {(p, p): name(1 / entries[p, p])}
    p, q = pivot  # both diagonal entries are zero: the inverse is off the diagonal, too
    reciprocal = name(1 / _at(entries, p, q))
    zero = se.Integer(0)
    return {(p, p): zero, (q, q): zero, (p, q): reciprocal, (q, p): reciprocal}


def _reduce(
    entries: dict[tuple[int, int], Any],
    rest: list[Any],
    pivot: tuple[int, ...],
    lower: dict[tuple[int, int], Any],
    name: Name,
) -> None:
    """The Schur complement and the forward substitution for one pivot."""
    rows = sorted({j for j, _ in lower})
    for j in rows:
        for k in (k for k in rows if k <= j):
            change = se.Add(*[lower[j, p] * _at(entries, k, p) for p in pivot])
            if change != 0:
                entries[j, k] = name(_at(entries, j, k) - change)
        rest[j] = name(rest[j] - se.Add(*[lower[j, p] * rest[p] for p in pivot]))
