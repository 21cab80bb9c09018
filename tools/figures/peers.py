"""What others would do, in the same process: equations as they would write them, and integrators.

A peer is a formulation of the equations with an integrator.  Formulations are programs by hand,
and what a user of SymPy makes of our equations: ``lambdify`` of mass matrix and force, solved by
numpy at each evaluation, as of ``KanesMethod``; accelerations written out for plain ``math``, as a
good hand does, an order of magnitude faster; the same as ``lambdify`` writes it with nothing else
said; source for a compiler.  No peer is needed to install or to test the package.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import sympy as sp

from figures.hand_programs import BY_HAND, HandProgram
from figures.mujoco_ball import MUJOCO, SETTINGS, STEPS, ball_run
from figures.numba_dop853 import compiled_dop853
from voronec.accuracy.bench import Contender, NotHere, Outcome, ReferenceProblem, time_fastest
from voronec.accuracy.bench.contender import Run
from voronec.accuracy.problem import ProblemFormulation, formulation, lowest
from voronec.algebra.text import as_expression
from voronec.equations.program import hoist, scalar_source
from voronec.errors import VoronecError

LONGEST = 20_000
"""Characters of a right-hand side beyond which no hand writes it out."""
FINEST = 1e-16
TOLERANCES = (1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14)
"""To where rounding ends all gain of DOP853."""

RightSide = Callable[[float, np.ndarray], Any]
Source = tuple[Callable[..., Any], np.ndarray]
"""A function of (t, y_0, y_1, ..., parameters) for a compiler, and the values of the parameters."""
Rows = Callable[[float], tuple[int, int, np.ndarray]]
"""A run at a tolerance: steps, evaluations and states (k, n)."""


@dataclass(frozen=True)
class Formulation:
    """Equations of a problem as somebody writes them down.

    ``start`` takes values of our variables by name to a state (n,), ``back`` states (k, n) to such
    values; ``right`` makes the right-hand side for scipy, ``source`` the one for a compiler, and
    ``taylor`` are the equations of heyoka.
    """

    at: ProblemFormulation
    start: Callable[[Mapping[str, float]], np.ndarray]
    back: Callable[[np.ndarray], dict[str, np.ndarray]]
    right: Callable[[], RightSide]
    source: Callable[[], Source]
    taylor: list[tuple[Any, Any]]

    @property
    def values(self) -> dict[str, float]:
        """Coordinates, velocities and the variables of the formulation at the start, by name."""
        named = dict(zip(map(str, self.at.field.variables), self.at.state.tolist(), strict=True))
        return {**self.at.problem.initial, **named}

    def outcome(self, rows: np.ndarray, seconds: float, evaluations: int, steps: int) -> Outcome:
        """What a run gave: our outputs, and the drift of integrals where all variables are known.

        Raises ``NotHere`` for a run that did not reach the end.
        """
        problem = self.at.problem
        if len(rows) < len(problem.grid) or not np.isfinite(rows).all():
            raise NotHere("the integration stopped short")
        known, variables = self.back(rows), [str(s) for s in self.at.field.variables]
        if not {*variables} <= {*known}:
            values = {n: known[n] for n in problem.outputs}
            return Outcome(values, seconds, evaluations, steps)
        states = np.column_stack([known[n] for n in variables])
        values, drift = self.at.outputs_and_drift(problem.grid, states)
        return Outcome(values, seconds, evaluations, steps, drift)


def by_hand(problem: ReferenceProblem) -> Formulation:
    """The program that somebody wrote by hand for a system."""
    name = problem.system.name
    if name not in BY_HAND:
        raise NotHere("nobody has written this system by hand")
    program = _with_package("heyoka", lambda: BY_HAND[name](problem.parameters))
    _require_outputs(problem, program.outputs)
    return Formulation(
        lowest(problem), program.start, program.back, partial(_hand_right_side, program),
        partial(_hand_source, program), program.equations,
    )  # fmt: skip


def _in_sympy(program: HandProgram) -> tuple[list[Any], list[Any]]:
    """Variables and rates."""
    import heyoka as hy

    pairs = [(hy.to_sympy(x), hy.to_sympy(rate)) for x, rate in program.equations]
    return [x for x, _ in pairs], [rate for _, rate in pairs]


def _hand_right_side(program: HandProgram) -> RightSide:
    """As a good hand gives it to scipy: ``lambdify`` to ``math`` with ``cse``."""
    variables, rates = _in_sympy(program)
    function = sp.lambdify([variables], rates, modules="math", cse=True)
    return lambda _t, state: function(state.tolist())


def _hand_source(program: HandProgram) -> Source:
    variables, rates = _in_sympy(program)
    arguments = [sp.Symbol("t"), *variables, sp.Symbol("parameters")]
    return sp.lambdify(arguments, tuple(rates), modules="math", cse=True), np.empty(0)


def reduction(problem: ReferenceProblem, name: str = "", kind: str = "written out") -> Formulation:
    """Our equations in a formulation, the lowest there is unless told, with one of
    ``RIGHT_SIDES``."""
    try:
        at = formulation(problem, name) if name else lowest(problem)
    except VoronecError as refusal:
        raise NotHere(str(refusal)) from None
    names = [str(s) for s in at.field.variables]
    source = _program_source if kind == "program" else sympy_source
    return Formulation(
        at,
        lambda values: np.array([values[n] for n in names]),
        lambda rows: dict(zip(names, rows.T, strict=True)),
        partial(sympy_right_side, at, kind), partial(source, at), [],
    )  # fmt: skip


def sympy_right_side(at: ProblemFormulation, kind: str) -> RightSide:
    """What ``lambdify`` makes of the equations in a formulation.

    ``solved``: rates, mass and force by one call, accelerations by ``numpy.linalg.solve``; so is
    what is too long to write out.  ``written out``: all derivatives by one call on floats.
    ``plain``: the same as it comes, in numpy's functions, common parts computed again.
    """
    derivatives, constants = at.field.components, at.constants
    if kind == "solved" or sum(len(str(e)) for e in derivatives) > LONGEST:
        return _solve_by_numpy(at)
    plain = kind == "plain"
    symbols, exprs = _plain_symbols(at, derivatives)
    function = sp.lambdify(symbols, exprs, "numpy" if plain else "math", cse=not plain)
    return lambda t, y: function(t, *(y if plain else y.tolist()), *constants)


def _solve_by_numpy(at: ProblemFormulation) -> RightSide:
    n, k, constants = len(at.field.velocities), len(at.field.rates), at.constants
    function = sp.lambdify(*_plain_symbols(at, _rates_mass_force(at)), "numpy", cse=True)

    def right(t: float, y: np.ndarray) -> np.ndarray:
        flat = np.array(function(t, *y, *constants), dtype=float)
        solved = np.linalg.solve(flat[k : k + n * n].reshape(n, n), flat[k + n * n :])
        return np.concatenate([flat[:k], solved])

    return right


def _rates_mass_force(at: ProblemFormulation) -> list[Any]:
    return [*at.field.rates, *(e for row in at.field.mass for e in row), *at.field.force]


def _plain_symbols(at: ProblemFormulation, exprs: Any) -> tuple[list[sp.Symbol], list[sp.Expr]]:
    """Time, variables and parameters as plain symbols, and expressions in them."""
    symbols = [at.field.time, *at.field.variables, *at.field.parameters]
    names = {as_expression(s): sp.Symbol(f"z{i}") for i, s in enumerate(symbols)}
    return [*names.values()], [as_expression(e).xreplace(names) for e in exprs]


def sympy_source(at: ProblemFormulation) -> Source:
    """As a good hand makes it: SymPy's ``cse`` of rates, mass matrix and force, printed as Python,
    and an elimination written out for the accelerations."""
    symbols, exprs = _plain_symbols(at, _rates_mass_force(at))
    if sum(len(str(e)) for e in exprs) > LONGEST:
        raise NotHere("the equations are too long for SymPy")
    n, k, count = len(at.field.velocities), len(at.field.rates), len(at.field.parameters)
    shared, found = sp.cse(exprs)
    first = len(symbols) - count
    rows = [f"{s} = parameters[{i}]" for i, s in enumerate(symbols[first:])]
    names = [f"f_{i}" for i in range(k)] + [f"m_{i}_{j}" for i in range(n) for j in range(n)]
    names += [f"f_{k + i}" for i in range(n)]
    pairs = [*shared, *zip(names, found, strict=True)]
    rows += [f"{x} = {sp.pycode(e, fully_qualified_modules=False)}" for x, e in pairs]
    rows += _elimination_lines(k, n)
    rows.append(f"return ({''.join(f'f_{i}, ' for i in range(k + n))})")
    head = f"def rhs({', '.join(map(str, symbols[:first]))}, parameters):"
    return _function("\n    ".join([head, *rows])), np.array(at.constants)


def _elimination_lines(k: int, n: int) -> list[str]:
    """Lines that solve m x = f[k:] by elimination, x in place of the right side."""
    rows = []
    for p in range(n):
        for i in range(p + 1, n):
            rows.append(f"q = m_{i}_{p}/m_{p}_{p}")
            rows += [f"m_{i}_{j} -= q*m_{p}_{j}" for j in range(p + 1, n)]
            rows.append(f"f_{k + i} -= q*f_{k + p}")
    for p in reversed(range(n)):
        rows += [f"f_{k + p} -= m_{p}_{j}*f_{k + j}" for j in range(p + 1, n)]
        rows.append(f"f_{k + p} /= m_{p}_{p}")
    return rows


def _program_source(at: ProblemFormulation) -> Source:
    """Our straight-line program, what depends on parameters alone computed before."""
    raised = hoist(at.program)
    return _function(scalar_source(raised.program)), np.array(raised.values([*at.constants]))


def _function(source: str) -> Callable[..., Any]:
    namespace: dict[str, Any] = dict(vars(math))
    exec(compile(source, "<right-hand side>", "exec"), namespace)
    function: Callable[..., Any] = namespace["rhs"]
    return function


def _taylor(form: Formulation, grid: np.ndarray) -> Rows:
    """heyoka; what is compiled for a tolerance is kept."""
    import heyoka as hy

    made: dict[float, Any] = {}
    start = form.start(form.values)

    def rows(tol: float) -> tuple[int, int, np.ndarray]:
        if tol not in made:
            made[tol] = hy.taylor_adaptive(form.taylor, start.tolist(), tol=tol)
        integrator = made[tol]
        integrator.time, integrator.state[:] = float(grid[0]), start
        _, _, _, steps, _, found = integrator.propagate_grid(grid)
        return steps, steps, found

    return rows


def _scipy(form: Formulation, grid: np.ndarray, method: str = "DOP853") -> Rows:
    from scipy.integrate import solve_ivp

    right, start = form.right(), form.start(form.values)

    def rows(tol: float) -> tuple[int, int, np.ndarray]:
        span, options = (grid[0], grid[-1]), {"t_eval": grid, "rtol": tol, "atol": tol}
        found = solve_ivp(right, span, start, method, **options)
        return 0, int(found.nfev), found.y.T

    return rows


def _numba(form: Formulation, grid: np.ndarray, fast: bool = False) -> Rows:
    """DOP853 and the right-hand side compiled together."""
    right, constants = form.source()
    start = form.start(form.values)
    advance = _with_package("numba", lambda: compiled_dop853(right, len(start), fast))

    def rows(tol: float) -> tuple[int, int, np.ndarray]:
        states = np.empty((len(grid), len(start)))
        return (*advance(grid, start, constants, tol, states), states)

    rows(1e-3)
    return rows


def _with_package(package: str, make: Callable[[], Any]) -> Any:
    """What takes a package; ``NotHere`` without it."""
    try:
        return make()
    except ImportError:
        raise NotHere(f"not installed: {package}") from None


def _require_outputs(problem: ReferenceProblem, offered: tuple[str, ...]) -> None:
    absent = [name for name in problem.outputs if name not in offered]
    if absent:
        raise NotHere(f"does not compute {', '.join(absent)}")


def _prepare(
    problem: ReferenceProblem,
    formulate: Callable[[ReferenceProblem], Formulation],
    integrator: Callable[[Formulation, np.ndarray], Rows],
) -> Run:
    form = formulate(problem)
    rows_at = integrator(form, problem.grid)

    def run(tol: float) -> Outcome:
        (steps, evaluations, rows), seconds = time_fastest(lambda: rows_at(tol))
        return form.outcome(rows, seconds, evaluations, steps)

    return run


def _peer(
    name: str,
    about: str,
    formulate: Callable[[ReferenceProblem], Formulation],
    integrator: Callable[[Formulation, np.ndarray], Rows],
    tolerances: tuple[float, ...] = TOLERANCES,
) -> Contender:
    prepare = partial(_prepare, formulate=formulate, integrator=integrator)
    return Contender(name, about, tolerances, prepare)


def _prepare_mujoco(problem: ReferenceProblem, setting: str) -> Run:
    if problem.system.name not in MUJOCO:
        raise NotHere(f"only for a ball on a plane: {', '.join(MUJOCO)}")
    form = reduction(problem, "invariants")
    _require_outputs(problem, tuple(map(str, form.at.field.variables)))
    if problem.grid[0] != 0 or problem.grid[-1] < 0:
        raise NotHere("runs forward from time 0 only")
    rows_at = _with_package("mujoco", lambda: ball_run(form.values, problem, SETTINGS[setting]))

    def run(step: float) -> Outcome:
        (steps, evaluations, known), seconds = rows_at(step)
        rows = np.column_stack([known[str(s)] for s in form.at.field.variables])
        return form.outcome(rows, seconds, evaluations, steps)

    return run


def _mujoco(setting: str) -> Contender:
    about = f"MuJoCo with its {setting} settings; it solves a more general problem"
    prepare = partial(_prepare_mujoco, setting=setting)
    return Contender(f"mujoco-{setting}", about, STEPS, prepare, knob="step")


ON_COORDINATES = partial(reduction, name="coordinates", kind="solved")
ON_INVARIANTS = partial(reduction, name="invariants")
PLAIN = partial(reduction, name="invariants", kind="plain")
LSODA = partial(_scipy, method="LSODA")
GOOD = "scipy {} with a good lambdify of the equations on the {}"
PEERS = (
    _peer(
        "heyoka-by-hand", "a heyoka program written by hand, in momentum and normal",
        by_hand, _taylor, (*TOLERANCES, FINEST),
    ),
    _peer(
        "dop853-by-hand", "the same program for scipy's DOP853, on plain numbers",
        by_hand, _scipy, TOLERANCES[:-1],
    ),
    _peer(
        "dop853-numba-by-hand", "the same program and DOP853 compiled by numba", by_hand, _numba
    ),
    _peer(
        "dop853-numba-fastmath", "the same with fast-math", by_hand, partial(_numba, fast=True)
    ),
    _peer("dop853-numba", "DOP853 compiled by numba, right-hand side by SymPy", reduction, _numba),
    _peer(
        "dop853-numba-ours", "DOP853 compiled by numba, right-hand side by our program",
        partial(reduction, kind="program"), _numba,
    ),
    _peer(
        "dop853-lambdify-invariants", GOOD.format("DOP853", "invariants"), ON_INVARIANTS, _scipy,
        TOLERANCES[:-1],
    ),
    _peer(
        "dop853-lambdify-invariants-plain",
        "scipy DOP853 with plain lambdify of the equations on the invariants", PLAIN, _scipy,
        TOLERANCES[:-1],
    ),
    _peer(
        "dop853-lambdify-coordinates", GOOD.format("DOP853", "coordinates"), ON_COORDINATES,
        _scipy, TOLERANCES[:-1],
    ),
    _peer(
        "lsoda-lambdify-invariants", GOOD.format("LSODA", "invariants"), ON_INVARIANTS, LSODA,
        TOLERANCES[:-1],
    ),
    _peer(
        "lsoda-lambdify-coordinates", GOOD.format("LSODA", "coordinates"), ON_COORDINATES, LSODA,
        TOLERANCES[:-1],
    ),
    _mujoco("best"),
    _mujoco("default"),
)  # fmt: skip
"""Every peer, fastest kind first."""
