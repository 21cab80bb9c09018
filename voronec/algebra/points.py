"""Generic points at which expressions are tried, also on the zero set of declared relations."""

from __future__ import annotations

import random
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import flint
import symengine as se

from voronec.algebra.conditions import Domain, domain_of, split_hypotheses
from voronec.algebra.precision import GENERIC
from voronec.algebra.tape import Tape
from voronec.errors import EngineLimit

DRAWS = 40
"""How many points are drawn, at most, for one at which conditions hold."""
SEEDS = 12
"""How many seeds are tried for a point."""
PATIENCE = 25
"""After so many steps without a smaller residual no solution is expected: of 1 244 that were found
for claims of the catalogue's systems none took more than 24, and half of all searches find none."""


def sample_point(
    atoms: Sequence[Any], relations: Sequence[Any] = (), seed: int = 0, bits: int = GENERIC
) -> dict[Any, Any]:
    """Random values for atoms: rationals, and where relations bind them, balls around a solution.

    Even seeds give positive values, odd ones either sign.  Each ball is proved to contain a
    solution of the relations (Krawczyk's test), and conditions among them hold there;
    ``EngineLimit`` where no such point is found.
    """
    point = _sample(tuple(atoms), tuple(relations), seed, bits)
    if isinstance(point, str):
        raise EngineLimit(point)
    return dict(point)


@lru_cache(maxsize=4096)
def _sample(
    atoms: tuple[Any, ...], relations: tuple[Any, ...], seed: int, bits: int
) -> dict[Any, Any] | str:
    """The point, or why there is none: proofs ask for most of them several times."""
    source = random.Random(f"voronec {seed}")
    equations, conditions = split_hypotheses(relations)
    domain = domain_of(tuple(conditions))
    bound = [*atoms, *(a for a in Tape(equations).atoms if a not in atoms)]
    try:
        for _ in range(DRAWS if conditions else 1):
            point: dict[Any, Any] = {}
            for atom in [*bound, *domain.linked_symbols(bound)]:
                value = flint.fmpq(source.randint(120, 1400), 1009) * (1 if seed < 6 else 9)
                point[atom] = -value if seed % 2 and source.random() < 0.5 else value
            lifted = _lift(point, equations, domain, bits)
            if lifted is not None:
                return lifted
    except EngineLimit as error:
        return str(error)
    return _BEYOND


def lift_point(point: dict[Any, Any], relations: Sequence[Any], bits: int) -> dict[Any, Any]:
    """The point itself, or balls around a solution of relations near it, with numbers brought
    into their ranges; ``EngineLimit`` where none is found, or conditions do not hold there."""
    equations, conditions = split_hypotheses(relations)
    lifted = _lift(point, equations, domain_of(tuple(conditions)), bits)
    if lifted is None:
        raise EngineLimit(_BEYOND)
    return lifted


_BEYOND = "no point was found at which the conditions on its coordinates hold"


def _lift(
    point: dict[Any, Any], equations: Sequence[Any], domain: Domain, bits: int
) -> dict[Any, Any] | None:
    moved = domain.clip(point)
    lifted = _onto_relations(moved, equations, bits) if equations else moved
    return lifted if domain.admits(lifted, bits) else None


def is_possible(conditions: Sequence[Any]) -> bool:
    """Whether a point is found at which conditions hold."""
    atoms = sorted(set[Any]().union(*(c.free_symbols for c in conditions)), key=str)
    for seed in range(SEEDS):
        try:
            sample_point(atoms, conditions, seed)
            return True
        except EngineLimit:
            continue
    return not conditions


def _onto_relations(point: dict[Any, Any], relations: Sequence[Any], bits: int) -> dict[Any, Any]:
    atoms = Tape(relations).atoms
    functions = [a for a in atoms if not isinstance(a, se.Symbol)]
    if functions:
        return _with_values_of(functions, point, relations, bits)
    if not atoms:
        raise EngineLimit("the relations hold no variable, so no point can be found on them")
    near = tuple(float(flint.arb(point[a])) for a in atoms)  # balls cannot be looked up
    solution = _solution(tuple(relations), near, bits)
    if isinstance(solution, str):
        raise EngineLimit(solution)
    return {**point, **solution}


@lru_cache(maxsize=1024)
def _solution(
    relations: tuple[Any, ...], near: tuple[float, ...], bits: int
) -> dict[Any, Any] | str:
    """Balls around a solution near values of the atoms of relations, or why there is none."""
    tape, jacobian = _slopes(relations)
    atoms = tape.atoms
    try:
        start = _nearby_solution(tape, len(relations), near)
        rows, columns = _independent(tape, len(relations), start)
        free = {a: flint.fmpq(round(v * 10**6), 10**6) for a, v in start.items()}
        square = Tape(
            [relations[r] for r in rows] + [jacobian[r][c] for r in rows for c in columns]
        )
        solution = free | _enclose(square, free, [atoms[c] for c in columns], bits)
    except EngineLimit as error:
        return str(error)
    except ZeroDivisionError:
        return "the relations between the coordinates are singular"
    if not all(v.contains(0) for v in tape.arb(solution, bits)[: len(relations)]):
        return "no point was found on all the relations between the coordinates"
    return solution


@lru_cache(maxsize=64)
def _slopes(relations: tuple[Any, ...]) -> tuple[Tape, list[list[Any]]]:
    """Relations with their derivatives by their atoms, and these as a matrix."""
    atoms = Tape(relations).atoms
    jacobian = [[r.diff(a) for a in atoms] for r in relations]
    return Tape([*relations, *(entry for row in jacobian for entry in row)]), jacobian


def _with_values_of(
    functions: Sequence[Any], point: dict[Any, Any], relations: Sequence[Any], bits: int
) -> dict[Any, Any]:
    """Values of relations where functions of other variables, as inputs are of the time, have
    values of their own; derivatives are replaced first, since the function stands in them too."""
    moving = {a for a in Tape(relations).atoms if isinstance(a, se.Symbol)}
    if any(f.free_symbols & moving for f in functions):
        raise EngineLimit("no point is looked for on relations between unknown functions")
    ordered = sorted(functions, key=lambda f: not isinstance(f, se.Derivative))
    letters = {f: se.Symbol(f"value of {f}") for f in ordered}
    for function, letter in letters.items():
        relations = [r.xreplace({function: letter}) for r in relations]
        point = {letter if a == function else a: x for a, x in point.items()}
    solution = _onto_relations(point, relations, bits)
    back = {letter: function for function, letter in letters.items()}
    return {back.get(a, a): x for a, x in solution.items()}


def _values(tape: Tape, point: dict[Any, Any], n: int, bits: int) -> tuple[Any, Any]:
    """Residual and Jacobian as flint matrices."""
    values = tape.arb(point, bits)
    width = (len(values) - n) // n
    return flint.arb_mat(n, 1, values[:n]), flint.arb_mat(n, width, values[n:])


def _nearby_solution(tape: Tape, n: int, near: tuple[float, ...]) -> dict[Any, float]:
    """Gauss-Newton steps of least norm in floating point."""
    import numpy as np

    atoms = tape.atoms
    x, best, since = np.array(near), np.inf, 0
    for _ in range(100):
        residual, matrix = _values(tape, dict(zip(atoms, map(float, x), strict=True)), n, 80)
        g = np.array([float(v.mid()) for v in residual.entries()])
        j = np.array([float(v.mid()) for v in matrix.entries()]).reshape(n, len(atoms))
        size = np.max(np.abs(g))
        best, since = (size, 0) if size < best else (best, since + 1)
        if since > PATIENCE or not np.all(np.isfinite(j)):
            break
        step = np.linalg.lstsq(j, g, rcond=1e-10)[0]
        x = x - step
        if np.max(np.abs(step)) < 1e-13 and size < 1e-9:
            return dict(zip(atoms, map(float, x), strict=True))
    raise EngineLimit("no point was found on the relations between the coordinates")


def _independent(tape: Tape, n: int, start: dict[Any, float]) -> tuple[list[int], list[int]]:
    """Rows and columns of a well-conditioned square block of the Jacobian."""
    import numpy as np

    matrix = np.array([float(v.mid()) for v in _values(tape, start, n, 80)[1].entries()])
    matrix = matrix.reshape(n, len(tape.atoms))
    rows: list[int] = []
    columns: list[int] = []
    scale = np.max(np.abs(matrix))
    while True:
        r, c = np.unravel_index(np.argmax(np.abs(matrix)), matrix.shape)
        if not abs(matrix[r, c]) > 1e-9 * scale:  # nothing at all where the scale is zero
            return rows, columns
        rows.append(int(r))
        columns.append(int(c))
        matrix = matrix - np.outer(matrix[:, c], matrix[r]) / matrix[r, c]


def _enclose(square: Tape, free: dict[Any, Any], bound: list[Any], bits: int) -> dict[Any, Any]:
    """Newton's method, then Krawczyk's proof that a ball around the result holds a solution."""
    n = len(bound)
    if n == 0:
        return {}
    with flint.ctx.workprec(2 * bits):
        middle = flint.arb_mat(n, 1, [flint.arb(free[b]) for b in bound])
        for _ in range(2 * bits):
            at = {**free, **dict(zip(bound, middle.entries(), strict=True))}
            residual, jacobian = _values(square, at, n, 2 * bits)
            step = jacobian.mid().solve(residual)
            middle = (middle - step).mid()
            if all(abs(v) < flint.arb(2) ** (-3 * bits // 2) for v in step.entries()):
                break
        radius = flint.arb(0, flint.arb(2) ** (-bits))
        box = [m + radius for m in middle.entries()]
        at = {**free, **dict(zip(bound, middle.entries(), strict=True))}
        residual, jacobian = _values(square, at, n, 2 * bits)
        inverse = jacobian.mid().inv().mid()
        wide = _values(square, {**free, **dict(zip(bound, box, strict=True))}, n, 2 * bits)[1]
        identity = flint.arb_mat(n, n, [int(i == j) for i in range(n) for j in range(n)])
        spread = flint.arb_mat(n, 1, [radius] * n)
        image = middle - inverse * residual + (identity - inverse * wide) * spread
        if all(b.contains(i) for b, i in zip(box, image.entries(), strict=True)):
            return dict(zip(bound, image.entries(), strict=True))
    raise EngineLimit("no point was proved to lie on the relations between the coordinates")


def sample_evaluable(
    tape: Tape,
    relations: Sequence[Any] = (),
    bits: int = GENERIC,
    tries: int = SEEDS,
    first: int = 0,
    count: int = 3,
) -> list[tuple[dict[Any, Any], list[Any]]]:
    """Up to ``count`` sample points, with the values there, at which every expression is finite."""
    samples: list[tuple[dict[Any, Any], list[Any]]] = []
    for seed in range(first, first + tries):
        try:
            point = sample_point(tape.atoms, relations, seed, bits)
        except EngineLimit:
            continue
        values = tape.arb(point, bits)
        if all(v.is_finite() for v in values) and consistent(tape.atoms, point, bits):
            samples.append((point, values))
        if len(samples) == count:
            break
    return samples


def consistent(atoms: Sequence[Any], point: dict[Any, Any], bits: int) -> bool:
    """Whether the values given to unknown functions are those of some functions.

    f(a) and f(b) were given values of their own, which is right only where a and b differ.
    """
    places: dict[str, list[tuple[Any, ...]]] = {}
    waiting = list(atoms)
    while waiting:
        for name, arguments in _applications(waiting.pop()):
            if arguments not in places.setdefault(name, []):
                places[name].append(arguments)
                waiting += Tape(arguments).atoms  # f(f(a)) takes f at a as well
    for several in places.values():
        if len(several) < 2:
            continue
        needed = [a for arguments in several for a in arguments]
        extra = Tape(needed)
        values = iter(extra.arb({**sample_point(extra.atoms), **point}, bits))
        located = [[next(values) for _ in arguments] for arguments in several]
        for i, here in enumerate(located):
            for there in located[:i]:
                pairs = zip(here, there, strict=False)
                if len(here) == len(there) and all(a.overlaps(b) for a, b in pairs):
                    return False
    return True


def _applications(atom: Any) -> list[tuple[str, tuple[Any, ...]]]:
    """The unknown function in an atom and where it is taken: f(a), f'(a), Subs(f'(xi), xi, a)."""
    if isinstance(atom, se.FunctionSymbol):
        return [(atom.get_name(), atom.args)]
    if isinstance(atom, se.Derivative):
        return _applications(atom.args[0])
    if isinstance(atom, se.Subs):
        at = dict(zip(atom.variables, atom.point, strict=True))
        return [
            (name, tuple(a.xreplace(at) for a in arguments))
            for name, arguments in _applications(atom.expr)
        ]
    return []
