"""One problem by six methods, each by its own way, each proved equal to the next.

Newton-Euler      dp/dt = F + R, dK/dt = M + N of each body, J^T (R, N) = 0
d'Alembert        M qddot + gamma = F + A^T lambda, lambda from A M^-1 A^T: for want of bodies
Lagrange          d/dt dL/dqdot - dL/dq = Q + A^T lambda, lambda from the fibre's equations
Kane              F_r + F*_r = 0, along the partial velocities
Gibbs-Appell      dS/dvdot_r = Pi_r
Voronec           d/dt dTheta/drdot - ... = K_nu (A_ij^nu rdot_j + A_i^nu)   [Theory, eq. (9)]
Hamel             d/dt dL/domega - X(L) + gamma dL/domega omega = Pi, all forms, constraints last

The record of all methods is their text, and data.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from time import process_time
from types import MappingProxyType
from typing import Any

import symengine as se

from voronec.algebra.elimination import solve_linear
from voronec.algebra.matrices import dot
from voronec.algebra.typeset import html_table
from voronec.algebra.verdicts import Verdict
from voronec.audit.lessons.newton_euler import FreeBodies
from voronec.audit.lessons.statement import Statement, Vector
from voronec.declaration.system import System
from voronec.equations.readable import equation_rows
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.errors import DefinitionError, EngineLimit
from voronec.proof.decision import all_zero


def first_principles(problem: Statement) -> MethodEquations:
    """Newton's and Euler's laws of the declared bodies; without them d'Alembert's balances."""
    return newton_euler(problem) if problem.equations.system.bodies else dalembert(problem)


def newton_euler(problem: Statement) -> MethodEquations:
    """Momentum balances of free bodies; the reactions are eliminated."""
    bodies = FreeBodies(problem)
    rows = zip(bodies.names, bodies.inertias, bodies.active, bodies.reactions, strict=True)
    return MethodEquations(
        "Newton and Euler, with reactions",
        (
            Step(
                "Of each body free of the others the momentum changes by forces, and the moment "
                "about the mass centre by torques; N1, N2, ... are the reactions, which do no work "
                "in any motion that the constraints admit:",
                tuple((name, (a, f + r)) for name, a, f, r in rows),
            ),
            Step(
                "As many of these balances as there are reactions give these; put into the others, "
                "and along the velocities in use:"
                if bodies.bound
                else "There are no reactions; along the velocities in use:"
            ),
        ),
        tuple(bodies.residual),
    )


def dalembert(problem: Statement) -> MethodEquations:
    """Inertia forces against forces and reactions, coordinate by coordinate, solved for both."""
    mass, rest = inertia(problem)
    active = _active(problem)
    rows = [list(row) for row in problem.constraint_rows]
    pushed = [f - g for f, g in zip(active, rest, strict=True)]
    columns = [[pushed[a], *(row[a] for row in rows)] for a in range(len(problem.q))]
    solved = _matrix(problem, _solve_mass(problem, mass, columns))
    free, swung = [row[0] for row in solved], [row[1:] for row in solved]
    lambdas = _reactions(problem, free, swung)
    accelerations = [
        f.xreplace(problem.rates) + dot(row, lambdas).xreplace(problem.rates)
        for f, row in zip(free, swung, strict=True)
    ]
    turned = dict(zip(problem.qdd, accelerations, strict=True))
    rates = [
        problem.free_rate(_form(problem, row, offset)).xreplace(turned).xreplace(problem.rates)
        for row, offset in zip(problem.frame_rows, problem.frame_offsets, strict=True)
    ]
    inertias = [dot(row, problem.qdd) + g for row, g in zip(mass, rest, strict=True)]
    return MethodEquations(
        "d'Alembert, with reactions",
        (
            Step(
                "Along each coordinate the force of inertia, from the kinetic energy's matrix and "
                "its Christoffel symbols, balances what is left of the forces and the reactions:",
                _balance(problem, inertias, active),
            ),
            Step(
                "The accelerations must keep the constraints; that determines the reactions:",
                _name_rows("lambda", [e.xreplace(problem.rates) for e in lambdas]),
            ),
            Step("With these, the accelerations are", _pairs(problem.vd, rates)),
        ),
        solved=tuple(rates),
    )


def _reactions(problem: Statement, free: Vector, swung: list[Vector]) -> Vector:
    """The multipliers with which the accelerations free + swung lambda keep the constraints."""
    rows, offsets = problem.constraint_rows, problem.constraint_offsets
    if not rows:
        return []
    still = dict.fromkeys(problem.qdd, se.Integer(0))
    drift = [
        problem.free_rate(_form(problem, row, offset)).xreplace(still)
        for row, offset in zip(rows, offsets, strict=True)
    ]
    columns = [[line[k] for line in swung] for k in range(len(rows))]
    gram = [[dot(row, column) for column in columns] for row in rows]
    right = [[-dot(row, free) - d] for row, d in zip(rows, drift, strict=True)]
    return problem.tidy([row[0] for row in solve_linear(gram, right).values])


def lagrange(problem: Statement) -> MethodEquations:
    """Lagrange's equations of the first kind; the multipliers are eliminated."""
    sides = _euler_lagrange(problem)
    rows, fibre = problem.constraint_rows, problem.fibre
    lambdas: Vector = []
    if rows:
        transposed = [[row[a] for row in rows] for a in fibre]
        lambdas = [r[0] for r in solve_linear(transposed, [[sides[a]] for a in fibre]).values]
    reduced = [
        sides[b] - se.Add(*[row[b] * x for row, x in zip(rows, lambdas, strict=True)])
        for b in problem.base
    ]
    names = [se.Symbol(f"lambda{k + 1}") for k in range(len(rows))]
    balance = [
        (str(q), (sides[a], se.Add(*[r[a] * x for r, x in zip(rows, names, strict=True)])))
        for a, q in enumerate(problem.q)
    ]
    return MethodEquations(
        "Lagrange, with multipliers",
        (
            Step(
                "For each coordinate d/dt dL/dqdot - dL/dq - Q is the reaction, a multiplier for "
                "each constraint:",
                tuple(balance),
            ),
            *_multipliers(lambdas),
        ),
        tuple(problem.in_velocities(r) for r in _onto(problem, reduced)),
    )


def _multipliers(lambdas: Vector) -> tuple[Step, ...]:
    """What is done with them, where there are any."""
    if not lambdas:
        return (Step("There are no multipliers; along the velocities in use:"),)
    return (
        Step(
            "The equations of the fibre coordinates give the multipliers:",
            _name_rows("lambda", lambdas),
        ),
        Step("Put into the others, and along the velocities in use:"),
    )


def kane(problem: Statement) -> MethodEquations:
    """Active forces and forces of inertia, along the partial velocities."""
    matrix, _ = problem.inverse
    slopes = [problem.lagrangian.diff(d).xreplace(problem.rates) for d in problem.qd]
    place = [e.xreplace(problem.rates) for e in _kinetic_slopes(problem)]
    inertia_forces = [place[a] - problem.rate(p) for a, p in enumerate(slopes)]
    active = [f.xreplace(problem.rates) for f in _active(problem)]
    pushed = [problem.along(r, active) for r in problem.base]
    swung = [problem.along(r, inertia_forces) for r in problem.base]
    partial = tuple(
        (f"d{d}/d{v}", matrix[a][r])
        for r, v in enumerate(problem.v)
        for a, d in enumerate(problem.qd)
        if matrix[a][r] != 0
    )
    return MethodEquations(
        "Kane",
        (
            Step("The partial velocities, which are not zero, are", partial),
            Step("Along them the active forces are", _each("F", problem, pushed)),
            Step("and the forces of inertia", _each("F*", problem, swung)),
            Step("Their sums F + F* vanish:"),
        ),
        tuple(-(f + s) for f, s in zip(pushed, swung, strict=True)),
    )


def gibbs_appell(problem: Statement) -> MethodEquations:
    """The energy of the accelerations, differentiated by the accelerations in use."""
    mass, rest = inertia(problem)
    values = [problem.accelerations[a] for a in problem.qdd]
    half = se.Rational(1, 2)
    energy = se.Add(
        *[half * x * y * mass[a][b] for a, x in enumerate(values) for b, y in enumerate(values)],
        *[x * g for x, g in zip(values, rest, strict=True)],
    ).xreplace(problem.rates)
    forces = [f.xreplace(problem.rates) for f in _active(problem)]
    pushed = [problem.along(r, forces) for r in problem.base]
    zero = dict.fromkeys(problem.vd, se.Integer(0))
    shown = problem.tidy([energy - energy.xreplace(zero)])[0]
    slopes = [energy.diff(a) for a in problem.vd]
    return MethodEquations(
        "Gibbs and Appell",
        (
            Step(
                "The energy of the accelerations, without what holds none of the accelerations:",
                (("S", shown),),
            ),
            Step("The forces along the velocities are", _each("Pi", problem, pushed)),
            Step("The derivatives of S by the accelerations are these forces:"),
        ),
        tuple(s - f for s, f in zip(slopes, pushed, strict=True)),
    )


def voronec(problem: Statement) -> MethodEquations:
    """The equations that the engine derives in the velocities of the base, by the curvature."""
    eqs = derive(_in_base(problem))
    inward = problem.bridge.inward
    base = [*problem.base]
    mass = [[inward(eqs.mass[i, j]) for j in base] for i in base]
    values = [
        se.Add(*[mass[i][j] * problem.qdd[j] for j in base], -inward(eqs.force[i, 0])) for i in base
    ]
    names, fibres = eqs.definition.split
    momenta = [(f"K_{s}", inward(eqs.momenta[k, 0])) for k, s in enumerate(fibres)]
    return MethodEquations(
        "Chaplygin" if eqs.kind == "chaplygin" else "Voronec",
        (
            Step(
                "On the constraints the Lagrangian and the momenta of the fibre are",
                (("Theta", inward(eqs.theta)), *momenta),
            ),
            Step(
                "The constraints cannot be integrated as far as their curvature does not vanish:",
                _curvature(problem, eqs),
            ),
            Step(
                "d/dt dTheta/drdot_i - dTheta/dr_i - a_i dTheta/ds = K_nu (A_ij rdot_j + A_i) + Q:",
                tuple(
                    (f"{q}", (value, se.Integer(0))) for q, value in zip(names, values, strict=True)
                ),
            ),
            Step("Along the velocities in use:"),
        ),
        tuple(problem.in_velocities(r) for r in _onto(problem, values)),
    )


def _curvature(problem: Statement, eqs: VoronecEquations) -> Rows:
    """The components A_ij^nu and A_i^nu that do not vanish."""
    names, fibres = eqs.definition.split
    components = []
    for k, s in enumerate(fibres):
        for i in problem.base:
            components += [
                (f"A^{s}[{names[i]}, {names[j]}]", eqs.curvature[k, i, j])
                for j in problem.base
                if i < j
            ]
            components.append((f"A^{s}[{names[i]}]", eqs.curvature.time[k, i]))
    return tuple((name, problem.bridge.inward(e)) for name, e in components if e != 0)


def hamel(problem: Statement) -> MethodEquations:
    """All forms as quasi-velocities, those of the constraints last; they vanish at the end."""
    last = tuple(se.Symbol(f"constraint {k + 1}") for k in range(len(problem.constraint_rows)))
    omega = (*problem.v, *last)
    matrix, offset = problem.inverse
    dots = {
        d: se.Add(offset[a], *[matrix[a][c] * w for c, w in enumerate(omega)])
        for a, d in enumerate(problem.qd)
    }
    whole = problem.lagrangian.xreplace(dots)
    kept = dict.fromkeys(last, se.Integer(0))
    slopes = [whole.diff(w).xreplace(kept) for w in omega]
    structure = _structure(problem)
    labels = [*map(str, problem.v), *(f"C{k + 1}" for k in range(len(last)))]
    behind = [*map(str, problem.v), "t"]
    brackets = tuple(
        (f"gamma^{labels[c]}[{problem.v[i]}, {behind[j]}]", entry)
        for (i, j), entries in structure.items()
        for c, entry in enumerate(entries)
        if i < j and entry != 0
    )
    return MethodEquations(
        "Hamel",
        (
            Step(
                "The velocities in use and the constraints are quasi-velocities omega; their "
                "fields have the brackets",
                brackets,
            ),
            Step(
                "With L written in omega the momenta, on the constraints, are",
                tuple((f"dL/d{name}", p) for name, p in zip(labels, slopes, strict=True)),
            ),
            Step("d/dt dL/domega_i - X_i(L) + gamma^c[i, j] dL/domega_c omega_j = Pi_i:"),
        ),
        tuple(_hamel_equations(problem, whole.xreplace(kept), slopes, structure)),
    )


def _hamel_equations(
    problem: Statement, whole: Any, slopes: Vector, structure: dict[tuple[int, int], Vector]
) -> Iterator[Any]:
    """d/dt dL/domega_i - X_i(L) + gamma^c_ij dL/domega_c omega_j - Pi_i, with omega_t = 1."""
    pushed = [
        whole.diff(q) + f.xreplace(problem.rates)
        for q, f in zip(problem.q, problem.forces, strict=True)
    ]
    omega = (*problem.v, se.Integer(1))
    for i in problem.base:
        turned = [dot(structure[i, j], slopes) * w for j, w in enumerate(omega)]
        yield problem.rate(slopes[i]) - problem.along(i, pushed) + se.Add(*turned)


METHODS: tuple[Callable[[Statement], MethodEquations], ...] = (
    first_principles,
    lagrange,
    kane,
    gibbs_appell,
    voronec,
    hamel,
)
"""The methods in the order in which they are taught."""


def by_methods(system: System | VoronecEquations) -> MethodComparison:
    """Solve one problem by every method, and prove that the equations are the same.

    Each method goes its own way from Lagrangian, forces and constraints to equations for the
    velocities in use; only the engine's own, Voronec's, uses the curvature.  The equations of
    each are compared with the next ones, as functions of coordinates, velocities and accelerations;
    accelerations that a method gives solved must satisfy the equations of the next.

    Raises ``DefinitionError`` for redundant coordinates, groups and forces that hold accelerations,
    ``EngineLimit`` for systems too large to be written out by any, such as the bicycle; a method
    that is alone in this is named among the ``limits``, and those beside it are compared.
    """
    begun = process_time()
    problem = Statement.of(system)
    methods: list[MethodEquations] = []
    limits: dict[str, str] = {}
    for method in METHODS:
        try:
            methods.append(method(problem))
        except EngineLimit as error:
            limits[_title(method)] = str(error)
    if not methods:
        name, reason = problem.equations.system.name, next(iter(limits.values()))
        raise EngineLimit(
            f"system '{name}': no method done; the next step is too large to be written out "
            f"({reason}); 'voronec derive {name}' has the equations, and "
            "vo.multiplier_acceleration those with multipliers, to be compared in numbers"
        )
    equalities = tuple(compare_sides(problem, a, b) for a, b in pairwise(methods))
    return MethodComparison(
        problem, tuple(methods), equalities, process_time() - begun, MappingProxyType(limits)
    )


def _title(method: Callable[[Statement], MethodEquations]) -> str:
    """What a method is called that did not come to its end."""
    return method.__name__.replace("_", " ")


def compare_sides(problem: Statement, left: MethodEquations, right: MethodEquations) -> Equality:
    """Whether two methods give the same equations: the right ones hold with the accelerations of
    the left ones, or their residuals are equal."""
    begun = process_time()
    if left.solved:
        places = dict(zip(problem.vd, left.solved, strict=True))
        differences = [r.xreplace(places) for r in right.residuals]
    else:
        differences = [a - b for a, b in zip(left.residuals, right.residuals, strict=True)]
    labelled = [(str(v), d) for v, d in zip(problem.v, differences, strict=True)]
    verdict = all_zero(labelled, problem.hypotheses)
    return Equality(left.name, right.name, verdict, process_time() - begun)


def inertia(problem: Statement) -> tuple[list[Vector], Vector]:
    """The matrix M of the kinetic energy, and gamma: M qddot + gamma is the force of inertia.

    gamma_a = (d_c M_ab - d_a M_bc / 2) qdot_b qdot_c + d_t M_ab qdot_b
              + (d_b b_a - d_a b_b) qdot_b + d_t b_a,     L = M qdot qdot / 2 + b qdot + ...
    """
    still = dict.fromkeys(problem.qd, se.Integer(0))
    size = range(len(problem.q))
    slopes = [problem.lagrangian.diff(d) for d in problem.qd]
    mass = [[slope.diff(d) for d in problem.qd] for slope in slopes]
    bends = [e.diff(d) for row in mass for e in row for d in problem.qd]
    if any(e != 0 for e in problem.tidy([e for e in bends if e != 0])):
        name = problem.equations.system.name
        raise DefinitionError(f"system '{name}': the Lagrangian is not quadratic in the velocities")
    linear = [slope.xreplace(still) for slope in slopes]
    mass = [[e.xreplace(still) for e in row] for row in mass]
    q, d, t = problem.q, problem.qd, problem.time
    rest = []
    for a in size:
        terms = [linear[a].diff(t)]
        for b in size:
            terms.append(d[b] * (mass[a][b].diff(t) + linear[a].diff(q[b]) - linear[b].diff(q[a])))
            terms += [
                d[b] * d[c] * (mass[a][b].diff(q[c]) - mass[b][c].diff(q[a]) / 2) for c in size
            ]
        rest.append(se.Add(*terms))
    return mass, rest


def _active(problem: Statement) -> Vector:
    """Q - dV/dq, with -V the part of L that holds no velocity."""
    potential = problem.lagrangian.xreplace(dict.fromkeys(problem.qd, se.Integer(0)))
    return [f + potential.diff(q) for f, q in zip(problem.forces, problem.q, strict=True)]


def _kinetic_slopes(problem: Statement) -> Vector:
    """d(L + V)/dq."""
    still = dict.fromkeys(problem.qd, se.Integer(0))
    kinetic = problem.lagrangian - problem.lagrangian.xreplace(still)
    return [kinetic.diff(q) for q in problem.q]


def _euler_lagrange(problem: Statement) -> Vector:
    slopes = [problem.lagrangian.diff(d) for d in problem.qd]
    return [
        problem.free_rate(p) - problem.lagrangian.diff(q) - f
        for p, q, f in zip(slopes, problem.q, problem.forces, strict=True)
    ]


def _onto(problem: Statement, values: Sequence[Any]) -> Vector:
    """What stands along the base coordinates, along the velocities in use."""
    matrix, _ = problem.inverse
    return [se.Add(*[matrix[b][r] * values[b] for b in problem.base]) for r in problem.base]


def _in_base(problem: Statement) -> System:
    """The system with the velocities of the base in use, and no claims."""
    declared = problem.equations.system
    outward = problem.bridge.outward
    rows = zip(problem.constraint_rows, problem.constraint_offsets, strict=True)
    return System(
        name=declared.name,
        fibration=declared.fibration,
        lagrangian=outward(problem.lagrangian),
        constraints=tuple(outward(_form(problem, row, offset)) for row, offset in rows),
        parameters=declared.parameters,
        forces={q: outward(f) for q, f in zip(declared.coordinates, problem.forces, strict=True)},
        inputs=declared.inputs,
    )


def _structure(problem: Statement) -> dict[tuple[int, int], Vector]:
    """gamma^c of [X_i, X_j] = gamma^c X_c, for i, j of the velocities in use; the last j is the
    time."""
    matrix, offset = problem.inverse
    size = range(len(problem.q))
    columns = [[matrix[a][c] for a in size] for c in problem.base]
    fields = [*columns, offset]
    structure = {}
    for i, one in enumerate(columns):
        for j, other in enumerate(fields):
            bracket = [
                se.Add(
                    *[one[b] * other[a].diff(problem.q[b]) for b in size],
                    *[-other[b] * one[a].diff(problem.q[b]) for b in size],
                    -one[a].diff(problem.time) if j == len(columns) else se.Integer(0),
                )
                for a in size
            ]
            structure[i, j] = problem.tidy([dot(row, bracket) for row in problem.forms])
    return structure


def _form(problem: Statement, row: Sequence[Any], offset: Any) -> Any:
    return offset + dot(row, problem.qd)


def _matrix(problem: Statement, rows: Sequence[Sequence[Any]]) -> list[Vector]:
    flat = problem.tidy([e for row in rows for e in row])
    width = len(rows[0])
    return [flat[k * width : (k + 1) * width] for k in range(len(rows))]


def _solve_mass(problem: Statement, mass: list[Vector], columns: list[Vector]) -> list[Vector]:
    solution = solve_linear(mass, columns)
    if solution.free:
        name = problem.equations.system.name
        raise DefinitionError(
            f"system '{name}': not every coordinate has inertia of its own, which d'Alembert's "
            "way needs; choose another system"
        )
    return solution.values


def _name_rows(name: str, values: Sequence[Any]) -> Rows:
    return tuple((f"{name}{k + 1}", value) for k, value in enumerate(values))


def _each(name: str, problem: Statement, values: Sequence[Any]) -> Rows:
    return tuple((f"{name}[{v}]", value) for v, value in zip(problem.v, values, strict=True))


def _pairs(names: Sequence[Any], values: Sequence[Any]) -> Rows:
    return tuple((str(name), value) for name, value in zip(names, values, strict=True))


def _balance(problem: Statement, inertias: Sequence[Any], active: Sequence[Any]) -> Rows:
    names = [se.Symbol(f"lambda{k + 1}") for k in range(len(problem.constraint_rows))]
    balances = []
    for a, q in enumerate(problem.q):
        reaction = se.Add(*[r[a] * x for r, x in zip(problem.constraint_rows, names, strict=True)])
        balances.append((str(q), (inertias[a], active[a] + reaction)))
    return tuple(balances)


Rows = tuple[tuple[str, Any], ...]


@dataclass(frozen=True)
class Step:
    """What is done, in a sentence, and what comes out: names, or texts, with formulas."""

    sentence: str
    rows: Rows = ()


@dataclass(frozen=True)
class MethodEquations:
    """The steps of one method; ``residuals`` vanish along the motion: they are written with q, v
    and vdot, and one belongs to each velocity.  Where a method gives accelerations, ``solved`` are
    those of v instead."""

    name: str
    steps: tuple[Step, ...]
    residuals: tuple[Any, ...] = ()
    solved: tuple[Any, ...] = ()


@dataclass(frozen=True)
class Equality:
    """Two methods, and the verdict on whether their equations are the same."""

    left: str
    right: str
    verdict: Verdict
    seconds: float


@dataclass(frozen=True)
class MethodComparison:
    """One problem by all methods, and the proofs that they agree; ``limits`` says of those that
    cannot be written out why."""

    problem: Statement
    methods: tuple[MethodEquations, ...]
    equalities: tuple[Equality, ...]
    seconds: float
    limits: Mapping[str, str] = field(default_factory=dict)

    def __repr__(self) -> str:
        names = ", ".join(method.name for method in self.methods)
        return f"Comparison({self.problem.equations.system.name!r}, {names}: {self._outcome})"

    def _repr_html_(self) -> str:
        """For notebooks: the verdict on each equality."""
        rows = [(f"{e.left} and {e.right}", e.verdict.status) for e in self.equalities]
        name = self.problem.equations.system.name
        return html_table(f"{name} by {len(self.methods)} methods", rows)

    @property
    def _outcome(self) -> str:
        return "proved to agree" if self.proved else "not proved to agree"

    @property
    def proved(self) -> bool:
        """Whether there are equalities, and every one is proved."""
        return bool(self.equalities) and all(e.verdict.proved for e in self.equalities)

    def lines(self) -> list[str]:
        """What is asked, each method with its steps and equations, and the proofs."""
        problem = self.problem
        system = problem.equations.system
        lines = [f"{system.name}: {system.title}" if system.title else system.name, ""]
        lines += ["asked", f"  The equations of motion for {', '.join(map(str, problem.v))}."]
        lines += equation_rows(_statement_lines(problem))
        for number, method in enumerate(self.methods, 1):
            lines += ["", f"{number}. {method.name}"]
            for step in method.steps:
                lines.append(f"  {step.sentence}")
                lines += [f"  {row}" for row in equation_rows(_texts(problem, step.rows))]
            lines += [f"  {row}" for row in equation_rows(_equations(problem, method))]
        lines += ["", "comes out"]
        for e in self.equalities:
            why = f"{e.verdict.status}, {e.verdict.method}"
            lines.append(f"  {e.left} = {e.right}: {why}")
        lines += [
            f"  {name}: too large to be written out, {why}" for name, why in self.limits.items()
        ]
        if self.proved:
            who = "The other" if self.limits else "All"
            lines.append(f"  {who} methods give the same equations: proved.")
        return lines

    def as_dict(self) -> dict[str, Any]:
        """The methods as data that JSON can hold."""
        problem = self.problem
        return {
            "system": problem.equations.system.name,
            "velocities": [str(v) for v in problem.v],
            "given": dict(_statement_lines(problem)),
            "methods": [
                {
                    "name": method.name,
                    "steps": [
                        {"sentence": s.sentence, "formulas": _texts(problem, s.rows)}
                        for s in method.steps
                    ],
                    "equations": _equations(problem, method),
                }
                for method in self.methods
            ],
            "limits": dict(self.limits),
            "equalities": [
                {
                    "left": e.left,
                    "right": e.right,
                    "verdict": e.verdict.status,
                    "why": e.verdict.method,
                    "seconds": round(e.seconds, 3),
                }
                for e in self.equalities
            ],
            "proved": self.proved,
            "seconds": round(self.seconds, 3),
        }

    def __str__(self) -> str:
        return "\n".join(self.lines())


def _statement_lines(problem: Statement) -> list[tuple[str, str]]:
    """Lagrangian, forces, constraints, velocities."""
    rows = [("L", problem.text(problem.lagrangian))]
    rows += [
        (f"Q[{q}]", problem.text(f))
        for q, f in zip(problem.q, problem.forces, strict=True)
        if f != 0
    ]
    for row, offset in zip(problem.constraint_rows, problem.constraint_offsets, strict=True):
        rows.append(("0", problem.text(_form(problem, row, offset))))
    for v, row, offset in zip(problem.v, problem.frame_rows, problem.frame_offsets, strict=True):
        form = _form(problem, row, offset)
        if form != v:
            rows.append((str(v), problem.text(form)))
    return rows


def _texts(problem: Statement, rows: Any) -> list[tuple[str, str]]:
    """Names, or left sides, with formulas."""
    lines = []
    for name, value in rows:
        if isinstance(value, tuple):
            left, right = problem.texts(value)
            lines.append((f"{name}:  {left}", right))
        else:
            lines.append((name, *problem.texts([value])))
    return lines


def _equations(problem: Statement, method: MethodEquations) -> list[tuple[str, str]]:
    """What a method ends with: the terms with accelerations on the left, the rest on the right."""
    equations = []
    still = dict.fromkeys(problem.vd, se.Integer(0))
    for residual in method.residuals:
        slopes = problem.tidy([residual.diff(a) for a in problem.vd])
        texts = problem.texts([*slopes, -residual.xreplace(still)])
        terms = []
        for slope, text, v in zip(slopes, texts, problem.v, strict=False):
            if slope != 0:
                factor = "" if text == "1" else f"({text})*" if " " in text else f"{text}*"
                terms.append(f"{factor}d{v}/dt")
        equations.append((" + ".join(terms) or "0", texts[-1]))
    return equations
