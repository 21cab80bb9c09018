"""Proof that a steady motion exists near a point, and that an eigenvalue of it lies on the right.

Variables that vanish are put in as zeros, and rates that then vanish identically are done with.  Of
the other equations as many as the rank allows are solved by Krawczyk's method, for as many
variables, all others being fixed numbers; what is then left over must be a relation's or an
integral's doing: sum_j (dI/dx_j) f_j = 0 along with f_i = 0 gives the others, where the block of
dI/dx_j is regular.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import flint
import numpy as np
import symengine as se

from voronec.dynamics.joint_function import JointFunction
from voronec.dynamics.natural_integrals import keeps_energy
from voronec.dynamics.newton import RANK, polish
from voronec.dynamics.spectrum import characteristic, root_on_right
from voronec.dynamics.steady_equations import SteadyEquations, as_symengine
from voronec.equations.motions import Motions
from voronec.errors import EngineLimit

BITS = 160
"""Bits of the balls: 48 digits."""


def enclosed_on_right(
    motions: Motions, equations: SteadyEquations, y: np.ndarray, near: complex
) -> str | None:
    """An eigenvalue enclosed right of the imaginary axis, of a steady motion whose existence is
    proved, as text; None where the proof does not succeed."""
    try:
        with flint.ctx.workprec(BITS):
            equations = equations.only_leaves()
            box = enclose(motions, equations, y)
            if box is None:
                return None
            slopes = equations.slopes_in_balls(box, BITS)
            coefficients = characteristic(slopes, equations.size, 0)
            root = root_on_right(coefficients, near, BITS)
            if root is not None:
                return f"an eigenvalue is {root.str(12)}"
            # with no root on the right all coefficients would have the sign of the first; this
            # proves eigenvalues that are double
            below = next((k for k, c in enumerate(coefficients) if c < 0), None)
            if below is None:
                return None
            factor = coefficients[below].str(12)
            return f"lambda^{below} in the characteristic polynomial has the factor {factor}"
    except EngineLimit:
        return None


def enclose(motions: Motions, equations: SteadyEquations, y: np.ndarray) -> list[Any] | None:
    """Balls that hold a steady motion, by proof; None where there is none.

    Zeros that leave more equations than unknowns are enclosed like other values: those that what
    is held depends on most, then all.
    """
    zero = [i for i, x in enumerate(y) if x == 0]
    slopes = equations.at(y)[1]
    held = [*range(len(slopes) - len(equations.held), len(slopes))]
    bound = regular_block(slopes, held, [*range(len(y))])[1]
    tries = (
        _enclose(motions, equations, y, some)
        for some in (zero, [i for i in zero if i not in bound], [])
    )
    return next((box for box in tries if box is not None), None)


def _enclose(
    motions: Motions, equations: SteadyEquations, y: np.ndarray, zero: Sequence[int]
) -> list[Any] | None:
    middle = polish(equations, y, BITS)
    middle = [flint.arb(0) if i in zero else x for i, x in enumerate(middle)]
    rows = [i for i, gone in enumerate(identical_zeros(equations, zero)) if not gone]
    columns = [i for i in range(len(y)) if i not in zero]
    slopes = equations.at(y)[1]
    chosen, bound = regular_block(slopes, rows, columns)
    box = krawczyk(equations, middle, chosen, bound)
    left = [i for i in rows if i not in chosen]
    if box is None or (left and not _follow(motions, equations, box, left)):
        return None
    return box


def identical_zeros(equations: SteadyEquations, zero: Sequence[int]) -> list[bool]:
    """Which of the rates, relations and held expressions vanish identically with these unknowns."""
    values: dict[Any, Any] = {equations.unknowns[i]: se.Integer(0) for i in zero}

    def on(expr: Any) -> Any:
        expr = se.sympify(expr)
        return expr.xreplace({s: values[s] for s in expr.free_symbols if s in values})

    derivative = equations.rates.derivative
    for name, expr in derivative.assignments:
        reduced = on(expr)
        if not reduced.args:
            values[name] = reduced
    rates = [on(e) == 0 for e in derivative.results]
    relations = [se.expand(on(e)) == 0 for e in equations.formulation.relations]
    known = {se.Symbol(n): as_symengine(x) for n, x in equations.values.items() if x is not None}
    held = [se.expand(on(e).xreplace(known) - as_symengine(equations.targets[n])) == 0
            for n, e in equations.held]  # fmt: skip
    return [*rates, *relations, *held]


def regular_block(
    slopes: np.ndarray, rows: Sequence[int], columns: Sequence[int]
) -> tuple[list[int], list[int]]:
    """Rows and columns of a regular block that is as large as the rank, by complete pivoting."""
    work = slopes[np.ix_(rows, columns)].copy()
    if not work.size:
        return [], []
    largest, chosen, bound = np.abs(work).max(), list[int](), list[int]()
    while np.abs(work).max(initial=0.0) > RANK * largest > 0:
        i, j = (int(k) for k in np.unravel_index(np.abs(work).argmax(), work.shape))
        chosen.append(rows[i])
        bound.append(columns[j])
        work -= np.outer(work[:, j], work[i]) / work[i, j]
        work[i], work[:, j] = 0.0, 0.0
    return chosen, bound


def krawczyk(
    equations: SteadyEquations | JointFunction, middle: Sequence[Any], rows: Sequence[int],
    columns: Sequence[int],
) -> list[Any] | None:  # fmt: skip
    """Balls about ``middle`` in which the chosen equations have a solution in the chosen variables:
    K(X) = m - C F(m) + (1 - C F'(X)) (X - m) lies inside X [Krawczyk1969]."""
    if not rows:
        return [*middle]
    n = len(rows)
    values, slopes = equations.balls(middle, BITS), equations.slopes_in_balls(middle, BITS)
    inverse = _block(slopes, rows, columns).mid().inv().mid()
    step = inverse * flint.arb_mat(n, 1, [values[i] for i in rows])
    reach = [4 * float(abs(e).upper()) + 2.0 ** (-BITS // 2) for e in step.entries()]
    box = [*middle]
    for j, r in zip(columns, reach, strict=True):
        box[j] = middle[j] + flint.arb(0, r)
    around = _block(equations.slopes_in_balls(box, BITS), rows, columns)
    unit = flint.arb_mat(n, n, [int(i == j) for i in range(n) for j in range(n)])
    off = flint.arb_mat(n, 1, [box[j] - middle[j] for j in columns])
    moved = (unit - inverse * around) * off - step
    solution = [*middle]
    for j, m, before in zip(columns, moved.entries(), off.entries(), strict=True):
        if not before.contains_interior(m):
            return None
        solution[j] = middle[j] + m
    return solution


def _block(slopes: Any, rows: Sequence[int], columns: Sequence[int]) -> Any:
    entries = [slopes[i, j] for i in rows for j in columns]
    return flint.arb_mat(len(rows), len(columns), entries)


def _follow(
    motions: Motions, equations: SteadyEquations, box: Sequence[Any], left: Sequence[int]
) -> bool:
    """Whether the equations left over, all of them rates, follow from relations, which the rates
    keep, and from integrals that are proved."""
    n, m = equations.size, len(equations.formulation.relations)
    if any(i >= n for i in left):
        return False
    if len(left) == 1 and left[0] >= len(equations.formulation.positions):
        power = _energy_slope(motions, equations, left[0])
        if power is not None:
            held = replace(equations, held=()).fix({"power": (power, 0)})
            return not held.balls(box, BITS)[-1].contains(0)
    proved = equations.proved_integrals(motions.equations)
    known = {name: (e, 0) for name, e in proved.items()}
    bare = replace(equations, held=())
    slopes = bare.fix(known).slopes_in_balls(box, BITS)
    count = m + len(known)
    block = np.array([[float(slopes[n + k, j].mid()) for j in left] for k in range(count)])
    chosen = regular_block(block, [*range(count)], [*range(len(left))])[0] if count else []
    if len(chosen) < len(left):
        return False
    return not _block(slopes, [n + k for k in chosen], left).det().contains(0)


def _energy_slope(motions: Motions, equations: SteadyEquations, j: int) -> Any | None:
    """dE/dv_j = sum_i v_i M_ij of the energy, where that is constant by the form of the system,
    and its potential holds no other coordinates than the variables: where these and all other
    velocities are at rest, dE/dv_j dv_j/dt = 0.  Else, and where L is not quadratic in the
    velocities, None."""
    d, form = motions.equations.definition, equations.formulation
    potential = d.lagrangian.subs(dict.fromkeys(d.dots, se.Integer(0)))
    known = {*form.variables, *form.parameters}
    squares = (d.lagrangian.diff(v).diff(w) for v in d.dots for w in d.dots)
    if form.inertia or any({*d.dots} & e.free_symbols for e in squares):
        return None
    if not keeps_energy(motions.equations) or potential.free_symbols - known:
        return None
    i = j - len(form.positions)
    return se.Add(*[v * row[i] for v, row in zip(form.velocities, form.mass, strict=True)])
