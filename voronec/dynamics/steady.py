"""Steady motions: relative equilibria, permanent rotations, uniform rollings, rest.

In the smallest formulation, cyclic coordinates left out, they are the points at which nothing
changes.  Newton's method finds them from many starts with the exact Jacobian of the program, whose
rank tells of how many dimensions the family is to which each belongs.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import flint
import mpmath as mp
import numpy as np
import symengine as se

from voronec.algebra.arguments import COUNT, FLAG, SEVERAL, VALUES, accepts
from voronec.algebra.memo import Memo
from voronec.algebra.symbols import plain_name
from voronec.declaration.reading import expression, quote, several
from voronec.declaration.system import System, require_system
from voronec.dynamics.angles import are_angles
from voronec.dynamics.charts import SteadyChart, chart
from voronec.dynamics.enclosure import BITS, enclosed_on_right
from voronec.dynamics.energy_casimir import proved_stable
from voronec.dynamics.exact_families import ExactFamily, exact_families
from voronec.dynamics.families import SteadyFamily, steady_family
from voronec.dynamics.kinds import kind_of
from voronec.dynamics.newton import null_space, pivots, polish, solve, solve_across
from voronec.dynamics.poles import regular_at_poles
from voronec.dynamics.spectrum import (
    SMALL,
    Deflation,
    to_mpf,
    unstable_count,
)
from voronec.dynamics.steady_equations import (
    SteadyEquations,
    check_parameters,
    constants_of,
    read_quantity,
    require_values,
    steady_equations,
    steady_formulation,
)
from voronec.equations.motions import Motions
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError, EngineLimit, VoronecError, did_you_mean
from voronec.motion.inputs import drive
from voronec.motion.request import number

NEAR = 1e-5
"""Entries below this, in their units, are tried as zero: Newton's method comes no nearer to
solutions at which the Jacobian loses its rank."""
NEARBY = 1e-2
"""A step, in the units, that tells a family from a degenerate point."""
STEEP = 1e10
"""Slopes that have grown by so much since the start, or have no value, tell of a divisor that
vanishes: the coordinates are singular there."""
WRONG = 1e-4
"""A rate above this part of its slopes is not zero."""
FAR = 1e3
"""Solutions beyond so many units are not told of: many functions vanish at infinity."""
HALF = se.Rational(1, 2)


@dataclass(frozen=True, eq=False, repr=False)
class SteadyMotion:
    """One steady motion, or one of a family: ``y`` (n,) are the values of the unknowns of its
    ``equations``, whose usual sizes are ``units`` (n,)."""

    motions: Motions = field(repr=False)
    equations: SteadyEquations = field(repr=False)
    y: np.ndarray = field(repr=False)
    units: np.ndarray = field(repr=False)
    memo: Memo = field(default_factory=Memo, init=False, repr=False)

    @property
    def system(self) -> System:
        """The system."""
        return self.equations.system

    @property
    def point(self) -> dict[str, float]:
        """The values of the variables by name."""
        return dict(zip(self.equations.names, map(float, self.y), strict=True))

    @cached_property
    def kernel(self) -> np.ndarray:
        """Directions (n, d) in which the equations hold to first order."""
        return null_space(self.equations.at(self.y)[1], self.units)

    @cached_property
    def tangents(self) -> np.ndarray:
        """Directions of the family (n, dimension); where families meet, those of one of them.

        Solutions are looked for in planes across steps along the kernel.  On a family all are
        where the steps lead, up to their squares; else there are none, or they tell the directions,
        by what is left of the kernel there, or by how few they lie in themselves.
        """
        if not self.kernel.size:
            return self.kernel
        count = self.kernel.shape[1]
        random = np.random.default_rng(0).normal(size=(count, count))
        steps = (NEARBY * self.kernel @ np.linalg.qr(random)[0]).T
        ends = (solve_across(self.equations.at, self.y + step, step, self.units) for step in steps)
        pairs = [(step, z) for step, z in zip(steps, ends, strict=True) if z is not None]
        if not pairs:
            return self.kernel[:, :0]
        off = [np.linalg.norm((z - self.y - step) / self.units) for step, z in pairs]
        if len(pairs) == count and max(off) < NEARBY / 10:
            return self.kernel
        spaces = (null_space(self.equations.at(z)[1], self.units) for _, z in pairs)
        space = min(spaces, key=lambda directions: directions.shape[1])
        _, sizes, right = np.linalg.svd(np.array([(z - self.y) / self.units for _, z in pairs]))
        rank = int((sizes > NEARBY / 10).sum())
        return space if space.shape[1] <= rank else self.units[:, None] * right[:rank].T

    @property
    def dimension(self) -> int:
        """Of how many dimensions the family is."""
        return self.tangents.shape[1]

    @property
    def is_singular(self) -> bool:
        """Whether families meet there, or the equations are degenerate: more eigenvalues vanish
        than for its neighbours."""
        return self.kernel.shape[1] > self.dimension

    @cached_property
    def free(self) -> tuple[str, ...]:
        """Variables by which the members of the family are told apart."""
        return tuple(self.equations.names[i] for i in pivots(self.tangents / self.units[:, None]))

    @cached_property
    def zero(self) -> tuple[str, ...]:
        """Variables that vanish along the family."""
        still = np.abs(self.tangents / self.units[:, None]).max(axis=1, initial=0.0) < NEARBY / 10
        names = zip(self.equations.names, self.y, still, strict=True)
        return tuple(name for name, x, rests in names if x == 0 and rests)

    @property
    def is_rest(self) -> bool:
        """Whether nothing moves at all."""
        equations = self.equations
        still = {n: equations.values[n] for n in map(str, constants_of(equations.formulation))}
        moving = {plain_name(v) for v in equations.formulation.system.velocities}
        moving |= {str(v) for v in equations.formulation.velocities}
        return all(x == 0 for n, x in {**still, **self.point}.items() if n in moving)

    @cached_property
    def kind(self) -> str:
        """``rest``, ``permanent rotation``, ``uniform rolling`` or ``steady motion``."""
        return kind_of(self)

    @cached_property
    def matrix(self) -> np.ndarray:
        """A (n, n) of dx' = A dx, in the variables of the smallest formulation."""
        return self.equations.matrix(self.y)

    @cached_property
    def deflation(self) -> Deflation:
        """How many eigenvalues vanish for all motions of the family."""
        return Deflation.of(self.matrix)

    @cached_property
    def spectrum(self) -> np.ndarray:
        """The eigenvalues (n - k,) that do not vanish for all motions of the family, complex, by
        real part, then imaginary part."""
        return self.deflation.eigenvalues(self.matrix)

    @property
    def zeros(self) -> int:
        """How many further eigenvalues vanish: directions of the family, and what relations,
        integrals and cyclic variables hold."""
        return self.deflation.zeros

    def in_digits(self, digits: int) -> dict[str, mp.mpf]:
        """The point to so many digits, in which constants are exact as they were given.

        ``EngineLimit`` where the equations are degenerate there, or have no evaluation in balls.
        """
        point = self._exact_point(int(3.33 * digits) + 40)
        with mp.workdps(digits):
            return {n: +to_mpf(x) for n, x in zip(self.equations.names, point, strict=True)}

    def _exact_point(self, bits: int) -> list[Any]:
        """The point in balls; what is held may touch the family, and then its nearest point."""
        try:
            return polish(self.equations, self.y, bits)
        except EngineLimit:
            return polish(self.equations.only_leaves(), self.y, bits)

    def eigenvalues(self, digits: int = 40) -> list[mp.mpc]:
        """All eigenvalues, zeros among them, to so many digits, by real and imaginary part."""
        n = self.equations.size
        # an eigenvalue of a chain of n loses so many digits
        bits = int(3.33 * (digits + 10)) * (max(self.deflation.counts, default=1) + 2) + 64
        y = self._exact_point(bits)
        slopes = self.equations.slopes_in_balls(y, bits)
        with flint.ctx.workprec(bits):
            block = [flint.acb(slopes[i, j].mid()) for i in range(n) for j in range(n)]
            spectrum = flint.acb_mat(n, n, block).eig(algorithm="approx")
            size = max(1.0, max(float(abs(e)) for e in spectrum)) if spectrum else 1.0
            pairs = [(to_mpf(e.real.mid()), to_mpf(e.imag.mid())) for e in spectrum]
        small = mp.mpf(10) ** -(digits + 2) * size
        with mp.workdps(digits):
            parts = [mp.mpc(*(x if abs(x) > small else 0 for x in pair)) for pair in pairs]
            return sorted((+e for e in parts), key=lambda e: (float(e.real), float(e.imag)))

    @cached_property
    def verdict(self) -> StabilityVerdict:
        """What the linearisation says, in the words of mathematics."""
        return judge(self)

    def stability(
        self, over: Any = None, between: Any = None, hold: Any = (), count: int = 100
    ) -> StabilityVerdict | SteadyFamily:
        """The ``verdict``; with ``over`` the family over that quantity, with its critical values,
        as ``along`` gives it."""
        return self.verdict if over is None else self.along(over, between, hold, count)

    def along(
        self, over: Any, between: Sequence[Any], hold: Any = (), count: int = 100
    ) -> SteadyFamily:
        """The family in which a quantity ``over`` - a parameter, an input, a variable, an integral
        or a formula in them - goes from one value to another, in some ``count`` steps.

        What ``at`` gave to ``steady`` is held where ``hold`` names it; where the family has more
        dimensions than one, variables are held besides, such as are zero first.  Functions of
        integrable constraints are always held.  ``DefinitionError`` where the quantity is
        constant along the family, or the family does not reach the span.
        """
        return steady_family(self, over, between, hold, count)

    def chart(self, x: Any, y: Any, count: int = 40, hold: Any = ()) -> SteadyChart:
        """How many eigenvalues lie on the right over two quantities, ``(name, low, high)`` each, at
        ``count`` values of both."""
        return chart(self, x, y, count, hold)

    def __repr__(self) -> str:
        values = ", ".join(f"{n}={x:.6g}" for n, x in self.point.items())
        return f"SteadyMotion({self.system.name!r}, {self.kind}, {values})"

    def as_dict(self) -> dict[str, Any]:
        """What JSON can hold of it."""
        return {
            "kind": self.kind,
            "point": self.point,
            "dimension": self.dimension,
            "free": list(self.free),
            "zero": list(self.zero),
            "eigenvalues": [[float(e.real), float(e.imag)] for e in self.spectrum],
            "zeros": self.zeros,
            "stability": str(self.verdict),
            "proved": self.verdict.proved,
        }


@dataclass(frozen=True)
class StabilityVerdict:
    """``unstable``: an eigenvalue lies right of the imaginary axis, ``proved`` where it is enclosed
    there, ``witness`` then the enclosure as text; ``spectrally stable``: none lies there in
    numbers, which does not prove stability; ``linearly attracting``: all that do not vanish for the
    whole family lie left of it."""

    word: str
    proved: bool
    unstable: int
    witness: str = ""

    def __str__(self) -> str:
        return f"{self.word}, proved: {self.witness}" if self.proved else f"{self.word}, in numbers"


def judge(motion: SteadyMotion) -> StabilityVerdict:
    """The verdict on one steady motion."""
    values, count = motion.spectrum, unstable_count(motion.spectrum)
    if count:
        witness = enclosed_on_right(motion.motions, motion.equations, motion.y, complex(values[-1]))
        return StabilityVerdict("unstable", witness is not None, count, witness or "")
    size = float(np.abs(values).max(initial=0.0))
    if (np.abs(values.real) <= SMALL * size).all():  # else no integral is definite
        witness = proved_stable(motion.motions, motion.equations, motion.y, motion.units)
        if witness is not None:
            return StabilityVerdict("stable", True, 0, witness)
    left = len(values) and bool((values.real < -SMALL * size).all())
    # what is held must not hide that an eigenvalue vanishes for this motion alone
    left = left and not replace(motion, equations=motion.equations.only_leaves()).is_singular
    return StabilityVerdict("linearly attracting" if left else "spectrally stable", False, 0)


@dataclass(frozen=True, eq=False, repr=False)
class SteadyMotions(Sequence[SteadyMotion]):
    """The steady motions that were found: isolated ones, and one of each family, by which variables
    vanish along it and by its dimension.  ``starts`` and ``solved`` tell of how many searches;
    ``families`` are exact, where they were asked for, ``limit`` tells why there are none."""

    system: System
    motions: tuple[SteadyMotion, ...]
    starts: int
    solved: int
    families: tuple[ExactFamily, ...] = ()
    limit: str = ""

    def __len__(self) -> int:
        return len(self.motions)

    def __getitem__(self, i: Any) -> Any:
        return self.motions[i]

    def __repr__(self) -> str:
        return f"SteadyMotions({self.system.name!r}, {len(self)} found)"

    def as_dict(self) -> dict[str, Any]:
        """What JSON can hold of it."""
        return {
            "system": self.system.name,
            "starts": self.starts,
            "solved": self.solved,
            "motions": [m.as_dict() for m in self.motions],
            "families": [
                {"equations": [*map(str, f.equations)], "dimension": f.dimension}
                for f in self.families
            ],
            "limit": self.limit,
        }


@accepts(at=VALUES, parameters=VALUES, free=SEVERAL, starts=COUNT, seed=COUNT, exact=FLAG)
def steady(
    system: System | VoronecEquations,
    at: Mapping[Any, Any] | None = None,
    parameters: Mapping[Any, Any] | None = None,
    free: Any = (),
    starts: int = 100,
    seed: int = 1,
    exact: bool = False,
) -> SteadyMotions:
    """The steady motions of a system, in numbers, from many starts.

    ``at`` gives values of variables of the smallest formulation, of integrals, or of formulas in
    them, that are to be met; ``parameters`` those of parameters and inputs, over their default
    values; ``free`` names parameters or inputs that are to be found, as in the trim of a driven
    system.  Functions that integrable constraints hold keep the values of the default scene.

    With ``exact`` all ``families`` for general parameters besides, by elimination, where it is
    within its budget; else ``limit`` tells why not.

    Raises ``DefinitionError`` for unknown names, a parameter without a value, a system that depends
    on the time, and where no start leads to a steady motion.
    """
    model = system.system if isinstance(system, VoronecEquations) else require_system(system)
    equations = drive(system, unknown=True).equations
    given = {f"{plain_name(u)}dot": 0 for u in model.inputs if _holds_rate(equations, u)}
    given |= {plain_name(k): x for k, x in (parameters or {}).items()}
    unknown = [plain_name(k) for k in several(free, "free", "name")]
    said, values = _scene_values(model), dict(at or {})
    wrong, searches, home = [], list[SteadyMotions](), None
    try:
        home = _with_values(equations, said, given, unknown, values)
        searches.append(_search(Motions.of(equations), home, said, starts, seed))
    except DefinitionError as error:
        wrong.append(error)
    positions = steady_formulation(equations).positions
    regular, poles = regular_at_poles(equations, positions) or (equations, ())
    for polar in poles:
        there = {**values, **dict.fromkeys(polar, 0)}
        with suppress(VoronecError):
            beside = _with_values(regular, {}, given, unknown, there)
            searches.append(_search(Motions.of(regular), beside, {}, starts, seed))
    if not searches:
        raise wrong[0]
    all_found = replace(
        searches[0], system=model, motions=tuple(m for each in searches for m in each)
    )
    if not exact or home is None:
        return all_found
    try:
        return replace(all_found, families=exact_families(home))
    except EngineLimit as limit:
        return replace(all_found, limit=str(limit))


def _with_values(
    equations: VoronecEquations, said: Mapping[str, Any], given: Mapping[str, Any],
    unknown: Sequence[str], at: Mapping[Any, Any],
) -> SteadyEquations:  # fmt: skip
    """The equations with the values of parameters, and of what is held."""
    problem = steady_equations(equations, given, said)
    _require_constants(problem, given)
    check_parameters(equations.system, *given.items())
    _require_constants(problem, unknown)
    problem = problem.with_unknowns(unknown)
    require_values(problem)
    held = {}
    for key, value in at.items():
        name, expr = read_quantity(problem, Motions.of(equations), key)
        held[name] = (expr, expression(value, f"the value of '{name}'"))
    still = {*map(str, constants_of(problem.formulation))}
    frozen = {n: x for n, x in problem.values.items() if n in still}
    frozen |= {n: held.pop(n)[1] for n in frozen.keys() & held.keys()}
    return replace(problem, values={**problem.values, **frozen}).fix(held)


def _holds_rate(equations: VoronecEquations, u: Any) -> bool:
    """Whether the rate of an input is a parameter; it is zero in a steady motion."""
    return f"{plain_name(u)}dot" in equations.system.parameter_names


def _scene_values(system: System) -> dict[str, Any]:
    scene = system.scenes.get("default")
    return {plain_name(k): x for k, x in scene.initial.items()} if scene else {}


def _require_constants(equations: SteadyEquations, names: Iterable[str]) -> None:
    known = equations.constants
    for name in names:
        if name not in known:
            raise DefinitionError(
                f"system '{equations.system.name}': '{quote(name)}' is no parameter and no "
                f"input of the equations{did_you_mean(name, known)}"
            )


def _search(
    motions: Motions, equations: SteadyEquations, said: Mapping[str, Any], starts: int, seed: int
) -> SteadyMotions:
    units = sizes_of(equations, said)
    turning, random = angles_of(equations, units), np.random.default_rng(seed)
    distinct: dict[Any, SteadyMotion] = {}
    solved, usual = 0, np.inf
    for k in range(starts):
        kept = random.integers(0, 2, len(units)) if k % 2 else np.ones(len(units))
        y = random.normal(size=len(units)) * units * kept
        for name, value in equations.targets.items():
            if name in equations.names:
                y[equations.names.index(name)] = float(value)
        y[roots_of(equations)] = np.abs(y[roots_of(equations)])
        steep = float(np.abs(equations.at(y)[1] * units).max(initial=0.0))
        usual = usual if k % 2 else min(usual, steep)
        if steep > STEEP * usual:  # its zeros make coordinates singular: all is small beside slopes
            continue
        motion = settle(motions, equations, y, units, turning)
        if motion is not None:
            solved += 1
            place = () if motion.dimension else tuple(np.round(motion.y / units, 6) + 0.0)
            key = (motion.dimension, motion.is_singular, motion.zero, place)
            distinct.setdefault(key, motion)
    if not distinct:
        constant = ", ".join(f"{x} = {equations.values[str(x)]}"
                             for x in constants_of(equations.formulation))  # fmt: skip
        other = f"; give others than those that the scene has of constants: {constant}"
        raise DefinitionError(
            f"system '{equations.system.name}': none of {starts} starts leads to a steady "
            f"motion; hold fewer values, or take more starts{other if constant else ''}"
        )
    order = sorted(distinct.values(), key=lambda m: (not m.is_rest, -len(m.zero), m.dimension))
    return SteadyMotions(equations.system, tuple(order), starts, solved)


def sizes_of(equations: SteadyEquations, said: Mapping[str, Any]) -> np.ndarray:
    """The usual sizes of the unknowns: what scenes and values say of them, else one."""
    values = {
        k: x for k, x in {**said, **equations.values, **equations.targets}.items() if x is not None
    }
    system = equations.system
    for scene in system.scenes.values():
        for key, value in scene.initial.items():
            name, size = plain_name(key), abs(number(value, "a value of a scene"))
            values[name] = max(abs(number(values.get(name, 0), "a value")), size)
    sizes = [abs(number(values.get(name, 0), "a value")) for name in equations.names]
    return np.array([size or 1.0 for size in sizes])


def roots_of(equations: SteadyEquations) -> list[int]:
    """The positions of states that are square roots, and so never negative."""
    start = equations.formulation.start
    states = enumerate(equations.unknowns[: equations.size])
    return [i for i, x in states if isinstance(e := start.get(x), se.Pow) and e.args[1] == HALF]


def angles_of(equations: SteadyEquations, units: np.ndarray) -> list[int]:
    """The positions of states that are angles: whole turns change no equation at a random point."""
    y = np.random.default_rng(0).normal(size=len(units)) * units
    mask = are_angles(lambda at: equations.at(at)[0], y, equations.size)
    return np.flatnonzero(mask).tolist()


def settle(
    motions: Motions, equations: SteadyEquations, y: np.ndarray, units: np.ndarray,
    turning: Sequence[int],
) -> SteadyMotion | None:  # fmt: skip
    """The steady motion to which Newton's method leads, angles between -pi and pi; None where it
    leads to none."""
    solution = solve(equations.at, y, units)
    if solution is None:
        return None
    whole = np.ceil(solution[turning] / (2 * np.pi) - 0.5 - NEAR)  # -pi is told as pi
    solution[turning] -= 2 * np.pi * whole
    if np.abs(solution / units).max(initial=0.0) > FAR:
        return None
    near = np.where(np.abs(solution) < NEAR * units, 0.0, solution)
    exact = solve(equations.at, near, units)
    solution = exact if exact is not None else solution
    if any(solution[i] < 0 for i in roots_of(equations)):
        return None
    solution = np.where(np.abs(solution) < 1e-12 * units, 0.0, solution)
    there, before = (np.abs(equations.at(x)[1] * units).max(initial=0.0) for x in (solution, y))
    if not there <= STEEP * before or _does_not_vanish(equations, solution, units):
        return None
    return SteadyMotion(motions, equations, solution, units)


def _does_not_vanish(equations: SteadyEquations, y: np.ndarray, units: np.ndarray) -> bool:
    """Whether a rate does not vanish, small as it may be, as exp(-x) is for large x: where it is
    no smaller than its slopes, which are flat, more digits tell."""
    value, slopes = equations.at(y)
    sizes = np.abs(slopes * units).max(axis=1, initial=0.0)
    if (np.abs(value) > WRONG * np.maximum(sizes, 1.0)).any():
        return True  # small beside other slopes alone, where coordinates are singular
    if not ((sizes < sizes.max(initial=0.0) / STEEP) & (np.abs(value) > sizes / 1000)).any():
        return False
    with suppress(EngineLimit):
        left = equations.balls(polish(equations, y, BITS), BITS)
        return max(float(abs(e)) for e in left) > sizes.max() * 2.0 ** (-BITS // 2)
    return False


@accepts(at=VALUES, parameters=VALUES, free=SEVERAL, count=COUNT, starts=COUNT, seed=COUNT)
def stability(
    system: System | VoronecEquations,
    over: Any,
    between: Any,
    at: Mapping[Any, Any] | None = None,
    parameters: Mapping[Any, Any] | None = None,
    free: Any = (),
    hold: Any = (),
    count: int = 100,
    starts: int = 100,
    seed: int = 1,
) -> SteadyFamily:
    """Spectra and critical values of a family of steady motions over a quantity.

    The motion that ``steady`` finds with ``at``, ``parameters`` and ``free`` - one that moves,
    where there is one - is followed over ``over`` as ``SteadyMotion.along`` does; all arguments,
    and what is raised, are those of the two.
    """
    motions = steady(system, at, parameters, free, starts, seed)
    motion = next((m for m in motions if not m.is_rest), motions[0])
    return motion.along(over, between, hold, count)
