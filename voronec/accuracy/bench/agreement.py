"""A motion of proved accuracy: two independent high-precision runs that agree.

One run is made on the coordinates, one on the invariants where the outputs have a meaning there:
equations derived apart, with other cancellations.  Where it can be, the two are also different
integrators.  Their difference is the accuracy that is stated.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import symengine as se

from voronec.accuracy.problem import ProblemLevel, ReferenceProblem, level
from voronec.accuracy.reference import UNIT, ReferenceSolution, difference
from voronec.equations.program import mpmath_source, taylor_system
from voronec.errors import DefinitionError, EngineLimit, IntegrationError, VoronecError
from voronec.motion import integrate
from voronec.motion.steppers.heyoka_stepper import heyoka

__all__ = [
    "ACCURACY",
    "agreed_reference",
    "ball_solution",
    "closed_form_reference",
    "flint_routes",
    "heyoka_route",
    "levels_of",
    "precise_outputs",
    "reference",
    "two_routes",
    "why_not",
]

QUADRUPLE = 33
"""Up to so many digits quadruple precision does; it is faster than arbitrary precision."""
GUARD = 5
"""Digits kept beyond those asked for."""


def why_not(level: ProblemLevel) -> str | None:
    """Why heyoka cannot run this exactly, or None where it can.

    Its expressions hold constants as doubles, so a fraction such as 1/3 would be rounded.
    """
    try:
        heyoka()
    except ImportError:
        return "heyoka is not installed"
    for expr in level.program.derivative.expressions:
        for number in _numbers(expr):
            p, q = int(number.p), int(number.q)
            if q & (q - 1) or abs(p) > 2**53:
                return f"the equations hold the constant {number}, which is no double"
    return None


def _numbers(expr: Any) -> set[Any]:
    if isinstance(expr, se.Rational):
        return {expr}
    return set().union(*(_numbers(a) for a in expr.args)) if expr.args else set()


def precise_outputs(level: ProblemLevel, grid: np.ndarray, digits: int) -> dict[str, np.ndarray]:
    """The outputs on the grid, arrays of mpmath numbers, evaluated in as many digits."""
    import mpmath

    states = precise_states(level, grid, digits)
    namespace: dict[str, Any] = {}
    exec(compile(mpmath_source(level.program), "<voronec reference>", "exec"), namespace)
    with mpmath.workdps(digits + GUARD):
        constants = [mpmath.mpf(x) for x in level.constants]
        rows = [
            namespace["extras"](mpmath.mpf(float(t)), [mpmath.mpf(x) for x in state], constants)
            for t, state in zip(grid, states, strict=True)
        ]
        place = {name: i for i, name in enumerate(level.program.names)}
        # inside, where a number is not rounded to a double on the way
        return {n: np.array([mpmath.mpf(r[place[n]]) for r in rows]) for n in level.problem.outputs}


def precise_states(level: ProblemLevel, grid: np.ndarray, digits: int) -> list[list[str]]:
    """States on the grid as decimal texts, one list for each instant."""
    import heyoka as hy
    import mpmath

    bits = int((digits + GUARD) * 3.33) + 8
    quadruple = digits <= QUADRUPLE and hasattr(hy, "real128")
    with mpmath.workdps(digits + 2 * GUARD):
        texts = [mpmath.nstr(x, digits + 2 * GUARD) for x in level.start]

    def own(text: Any) -> Any:
        """A number of heyoka's, from a text or a double."""
        if quadruple:
            return hy.real128(text)
        return hy.real(text, bits)

    used = [i for i, p in enumerate(level.program.parameters)
            if p in level.program.derivative.symbols]  # fmt: skip
    integrator = hy.taylor_adaptive(
        taylor_system(level.program),
        np.array([own(t) for t in texts]),
        pars=np.array([own(x) for x in level.constants[: max(used, default=-1) + 1]]),
        time=own(float(grid[0])),
        fp_type=hy.real128 if quadruple else hy.real,
        tol=own(f"1e-{digits}"),
        compact_mode=True,
        **({} if quadruple else {"prec": bits}),
    )
    outcome, *_, rows = integrator.propagate_grid(np.array([own(float(t)) for t in grid]))
    if len(rows) < len(grid):
        raise IntegrationError(
            f"system '{level.problem.system.name}': the run of {digits} digits for the reference "
            f"stopped at t = {float(integrator.time):g} ({outcome}); end the motion before that"
        )
    return [[str(x) for x in row] for row in rows]


ACCURACY = 1e-13
"""The accuracy that a reference must have, relative to the size of each output."""
DIGITS = (24, 32, 50)
"""The digits of the runs; the next number is tried where one does not suffice."""
CROSS_SPAN = 60.0
"""Over so many units of time a closed form is held against an integration."""
CROSS_INSTANTS = 41
"""At so many instants."""
LONG = 60.0
"""Beyond this span, in units of time, flint is left out where heyoka can run both routes."""

Route = tuple[str, Callable[[], Mapping[str, np.ndarray]]]
"""What a run is called, and the run: output to values on the grid."""


def reference(question: ReferenceProblem, needed: float = ACCURACY) -> ReferenceSolution:
    """The motion of a question, to ``needed`` or better on the part of its grid that is returned.

    Where the system declares its motion in closed form, that is the reference, on any grid, and
    another run of many digits agrees with it over the first ``CROSS_SPAN`` units of time.  Raises
    ``EngineLimit`` where no two independent runs can be made, and ``IntegrationError`` where
    two agree on no part of the grid.
    """
    found = closed_form_reference(question, needed)
    if found is not None:
        return found
    best: ReferenceSolution | None = None
    for digits in DIGITS:
        first, second = two_routes(question, digits)
        found = agreed_reference(question, [(n, run()) for n, run in (first, second)], needed)
        if found is not None and (best is None or len(found.t) > len(best.t)):
            best = found
        if best is not None and len(best.t) == len(question.grid):
            return best
    if best is None:
        raise IntegrationError(
            f"system '{question.system.name}': two runs of {DIGITS[-1]} digits agree to {needed:g} "
            "on no part of the grid, so there is no reference; take a shorter time"
        )
    return best


def closed_form_reference(question: ReferenceProblem, needed: float) -> ReferenceSolution | None:
    """The enclosed motion, where there is one and an independent run agrees with it."""
    if question.system.motion is None:
        return None
    start, end = float(question.grid[0]), float(question.grid[-1])
    crossed = question
    if question.span > CROSS_SPAN:
        last = start + CROSS_SPAN * (1 if end > start else -1)
        crossed = replace(question, grid=np.linspace(start, last, CROSS_INSTANTS))
    try:
        name, run = two_routes(crossed, DIGITS[0])[0]
        said = f"the closed form, enclosed to {DIGITS[0] + 5} digits"
        found = agreed_reference(crossed, [(said, ball_solution(crossed)), (name, run())], needed)
        if found is None or len(found.t) < len(crossed.grid):
            return None
        if crossed is question:
            return found
        values = {n: np.asarray(x, dtype=float) for n, x in ball_solution(question).items()}
    except (DefinitionError, EngineLimit, IntegrationError):
        return None
    note = f"the two agree up to t = {last:g}; later there is the closed form alone, enclosed"
    return replace(found, t=question.grid, values=values, note=note)


def ball_solution(question: ReferenceProblem) -> Mapping[str, np.ndarray]:
    """The outputs as the declared motion gives them, enclosed to more digits than doubles hold."""
    return _solution(question, "closed-form", DIGITS[0] + 5)


def _solution(
    question: ReferenceProblem, method: str, digits: int, besides: Sequence[str] = ()
) -> Mapping[str, np.ndarray]:
    """The outputs by a method of ours to so many digits, in a model that has others ``besides``."""
    trajectory = integrate(
        question.equations, question.bare, times=question.grid, method=method,
        outputs=[*(question.expressions[n] for n in question.outputs), *besides],
        tol=10.0**-digits,
    )  # fmt: skip
    if trajectory.interrupted:
        raise KeyboardInterrupt
    return {n: trajectory[n] for n in question.outputs}


def agreed_reference(
    question: ReferenceProblem, runs: Sequence[tuple[str, Mapping[str, np.ndarray]]], needed: float
) -> ReferenceSolution | None:
    """The reference that two runs make, cut where they part; None where they part at once."""
    (first, one), (second, two) = runs
    apart = np.max(
        [difference(one[n], two[n], n in question.angles) for n in question.outputs], axis=0
    )
    wrong = np.nonzero(~(apart <= needed))[0]
    good = int(wrong[0]) if len(wrong) else len(apart)
    if good < 2:
        return None
    note = ""
    if good < len(apart):
        note = (
            f"the two runs agree to {needed:g} up to t = {question.grid[good - 1]:g} only; "
            "the rest is not measured"
        )
    return ReferenceSolution(
        t=question.grid[:good],
        values={n: np.asarray(one[n][:good], dtype=float) for n in question.outputs},
        accuracy=max(float(apart[:good].max()), UNIT),
        how=(first, second),
        note=note,
    )


def two_routes(question: ReferenceProblem, digits: int) -> tuple[Route, Route]:
    """The two most different runs there are."""
    levels = levels_of(question)
    own = [heyoka_route(at, question, digits) for at in levels]
    fast = [route for route in own if route is not None]
    exact = flint_routes(question, digits)
    if exact and fast and question.span <= LONG:
        return exact[-1], fast[0]
    if len(fast) == 2:
        return fast[0], fast[1]
    if exact and fast:
        return exact[-1], fast[0]
    if len(exact) == 2:
        return exact[0], exact[1]
    raise EngineLimit(
        f"system '{question.system.name}': no two independent high-precision runs are possible "
        "here, so there is no reference; install heyoka, or give outputs on the invariants"
    )


def levels_of(question: ReferenceProblem) -> list[ProblemLevel]:
    """The equations on coordinates, and on invariants where they close."""
    found = [level(question, "coordinates")]
    with suppress(VoronecError):
        found.append(level(question, "invariants"))
    return found


def heyoka_route(at: ProblemLevel, question: ReferenceProblem, digits: int) -> Route | None:
    """A name and a run by heyoka in so many digits; None where it cannot run the level exactly."""
    if why_not(at) is not None:
        return None
    name = f"heyoka's Taylor method with {digits} digits, on the {at.name}"
    return name, lambda: precise_outputs(at, question.grid, digits)


def flint_routes(question: ReferenceProblem, digits: int) -> list[Route]:
    """Runs by our own arbitrary-precision integrator: of the smallest model, of the full one."""
    try:
        probe = replace(question, grid=question.grid[:1])
        integrate(probe.equations, probe.bare, times=probe.grid, method="flint", tol=1e-20)
    except (DefinitionError, EngineLimit):
        return []
    say, state = "our Taylor method 'flint' with {} digits, on the {}", tuple(question.initial)
    full = partial(_solution, question, "flint", digits, state)
    small = partial(_solution, question, "flint", digits + 5)
    return [
        (say.format(digits, "coordinates"), full),
        (say.format(digits + 5, "smallest model"), small),
    ]
