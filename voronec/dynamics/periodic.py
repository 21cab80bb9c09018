"""Periodic orbits, alone and in families, with their Floquet multipliers.

    phi_T(x) = x + w,     M = D phi_T(x)

w are whole turns of angles.  Newton's method on the states at the ends of m parts of the period, by
the variational equations (multiple shooting [StoerBulirsch2002, sec. 7.3.5]): closure, a condition
that keeps the phase, and the constants of the motion that are held; these are more equations than
unknowns, but consistent, and where they leave a choice the nearest orbit is taken.
``continuation`` follows families.

A constant of the motion c has dc M = dc, the rates f have M f = f.  In an orthonormal basis of f,
the rest of the kernel of all dc, and what is left, M is block triangular:

        | 1  *  * |
    M = | 0  B  * |
        | 0  0  I |

So the trivial multipliers are those of the outer blocks, the others those of B: they are never told
apart by their size, and those at 1 keep their digits, which the Jordan blocks of M would halve.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial, reduce
from itertools import pairwise
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from voronec.algebra.arguments import (
    CALLABLE,
    COUNT,
    OPTIONAL_COUNT,
    OPTIONAL_REAL,
    OPTIONAL_TEXT,
    SEVERAL,
    TOLERANCE,
    VALUES,
    accepts,
)
from voronec.declaration.reading import several
from voronec.declaration.system import System
from voronec.dynamics.continuation import COMPLETE, follow, root_between
from voronec.dynamics.newton import null_space, solve, solve_across
from voronec.dynamics.orbits import MARGIN, Bifurcation, OrbitFamily, PeriodicOrbit
from voronec.dynamics.phase_space import PhaseSpace
from voronec.dynamics.steady_equations import check_parameters
from voronec.dynamics.variational import VariationalFlow
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError, VoronecError, did_you_mean

CLOSURE = 1e-10
"""An orbit closes to this part of the sizes of its variables."""
SINGULAR = 1e-7
"""Directions that the equations tell apart by less than this part are free."""
WIDE = 1e4
"""Parts of the period in which variations grow more are halved."""
MOST_SEGMENTS = 64
STILL = 1e-6
"""A state whose rates are no more than this part of the norm of the Jacobian is an equilibrium."""
SEARCH = 20_000
"""Steps within which a motion is to come back near its start, where no period is given."""
NEAR = 0.3
"""It has come back where it is nearer than this part of the farthest it went."""
POINTS = 201
"""So many points of an orbit are kept."""
RECENT = 8
"""The flow along so many orbits is kept: equations, tangents and multipliers ask for it again."""
COARSE = 1e-9
"""The tolerance with which guesses and pictures are computed."""


@accepts(
    initial=VALUES, period=OPTIONAL_REAL, parameters=VALUES, inputs=VALUES, variables=SEVERAL,
    hold=SEVERAL, along=OPTIONAL_TEXT, to=OPTIONAL_REAL, points=COUNT, segments=OPTIONAL_COUNT,
    tol=TOLERANCE, progress=CALLABLE,
)  # fmt: skip
def periodic(
    system: System | VoronecEquations,
    scene: Any = None,
    initial: Mapping[Any, Any] | None = None,
    period: float | None = None,
    parameters: Mapping[Any, Any] | None = None,
    variables: Sequence[Any] = (),
    hold: Sequence[str] = (),
    along: str | None = None,
    to: float | None = None,
    points: int = 21,
    segments: int | None = None,
    tol: float = 1e-13,
    inputs: Mapping[Any, Any] | None = None,
    progress: Callable[[float], Any] | None = None,
) -> OrbitFamily:
    """The periodic orbit near a start, or the family to which it belongs.

    scene, initial, parameters, inputs
        a guess, as for ``integrate``.
    period
        a guess of the period; by default when the motion comes back next to its start.  Where the
        time stands in the equations it is the period itself, and must be given.
    variables
        the quantities that come back; what they depend on does too.  By default the velocities of
        the equations.
    hold
        names of integrals whose values the orbit must have from the start.  By default none: of all
        orbits the nearest is taken, and families go where what they are followed along grows most.
    along, to
        an integral or a parameter, and the value up to which the family is followed; then the
        family has about ``points`` orbits, evenly spaced in it, and twice as many at most.
    segments
        parts of the period in multiple shooting; by default as many as the growth of variations
        asks for.
    tol
        the tolerance of a step.

    Returns an ``OrbitFamily``; without ``along`` it has a single orbit.  Raises ``DefinitionError``
    where the guess leads to no periodic orbit, and for input that makes no sense.
    """
    began = perf_counter()
    space = PhaseSpace.of(system, scene, initial or None, parameters, inputs, variables)
    if len(space.motions) > 1:
        raise DefinitionError("periodic: give one start; families are followed by along=, to=")
    if (along is None) != (to is None):
        raise DefinitionError("periodic: give along and to, both or none")
    if points < 2:
        raise DefinitionError(f"periodic: points={points}: give 2 orbits or more")
    known = [n for n in space.constants if not n.startswith("relation ")]
    if along is not None and along not in known:
        check_parameters(space.system, (along, to))
        space, known = space.with_variable(along), [*known, along]
    names = several(hold, "hold", "'energy'")
    for name in names:
        if name not in known:
            raise DefinitionError(f"hold: there is no proved integral '{name}' here"
                                  + did_you_mean(name, known))  # fmt: skip
    curve = _OrbitEquations.of(space, tuple(names), along, period, segments, tol)
    unknowns, ended = [curve.solve_from_guess()], "alone"
    bifurcations = list[Bifurcation]()
    if along is not None and to is not None:
        curve = curve.without_target()
        more, ended = curve.follow(unknowns[0], to, points, progress)
        unknowns += more
    orbits = tuple(map(curve.orbit, unknowns))
    for ends in pairwise(zip(unknowns, orbits, strict=True)):
        bifurcations += curve.bifurcations(*ends)
    return OrbitFamily(along or "period", orbits, tuple(bifurcations), ended,
                       perf_counter() - began)  # fmt: skip


class _Arc(NamedTuple):
    """The motion over one part of the period: where it ends (n,), and the slopes of that by where
    it begins (n, n)."""

    end: np.ndarray
    slopes: np.ndarray


@dataclass(eq=False)
class _OrbitEquations:
    """The equations of a periodic orbit, whose solutions are a ``ContinuationCurve``.

    Unknowns are the states at the beginnings of the parts of the period, in ``state_units``, and
    the period in units of its guess, ``span``.
    """

    space: PhaseSpace
    flow: VariationalFlow
    values: np.ndarray
    state_units: np.ndarray
    held: np.ndarray
    targets: np.ndarray
    along: int | None
    segments: int
    span: float
    turning: np.ndarray
    guess: np.ndarray
    anchor: tuple[np.ndarray, np.ndarray]
    tol: float
    recent: dict[Any, tuple[_Arc, ...]] = field(default_factory=dict)

    @classmethod
    def of(
        cls, space: PhaseSpace, hold: tuple[str, ...], along: str | None, period: float | None,
        segments: int | None, tol: float,
    ) -> _OrbitEquations:  # fmt: skip
        x, values, units = space.motions.states[0], space.motions.values[0], space.units(0)
        flow, names = space.flow(), [*space.constants]
        rates, matrix = flow.rates(x, values)
        if not (np.abs(rates) > 1e-12 * np.linalg.norm(matrix, 2) * units).any():
            raise DefinitionError("periodic: the start is an equilibrium; start beside it")
        if period is None and space.is_driven:
            raise DefinitionError("periodic: the time stands in the equations: give the period")
        if period is not None and not period > 0:
            raise DefinitionError(f"periodic: period={period}: give a time above 0")
        held = [i for i, n in enumerate(names)
                if n in hold or n in space.moving or n.startswith("relation ")]  # fmt: skip
        constants, _ = space.constants_at(x, values)
        place = None if along is None else names.index(along)
        made = cls(
            space, flow, values, units, np.array(held, dtype=int), constants[held], place, 1, 0.0,
            space.angles(), np.array([]), (x, rates), tol,
        )  # fmt: skip
        span = period or made._return_time()
        made = replace(made, span=span if space.is_driven else made._nearest_time(span))
        if segments is not None:
            if not 1 <= segments <= MOST_SEGMENTS:
                raise DefinitionError(f"periodic: segments={segments}: give 1 to {MOST_SEGMENTS}")
            return made.in_parts(segments)
        count = 1
        while count < MOST_SEGMENTS:
            trial = made.in_parts(count)
            slopes = [arc.slopes / units[:, None] * units for arc in trial.arcs(trial.guess)]
            if max(np.linalg.norm(s, 2) for s in slopes) < WIDE:
                break
            count *= 2
        return made.in_parts(count)

    def _gap(self, end: np.ndarray) -> np.ndarray:
        """From the start to another state (n,), in units, angles up to whole turns."""
        off = end - self.anchor[0]
        off[self.turning] -= 2 * np.pi * np.round(off[self.turning] / (2 * np.pi))
        return np.asarray(off / self.state_units)

    def _return_time(self) -> float:
        """When the motion from the start comes back next to it, roughly."""
        x, units = self.anchor[0], self.state_units
        state, gaps, farthest = self.flow.start(x, units=units), [0.0], 0.0
        _, matrix = self.flow.rates(x, self.values)
        step = 0.1 / (float(np.linalg.norm(matrix * units / units[:, None], 2)) or 1.0)
        for i in range(1, SEARCH):
            self.flow.go(state, i * step, self.values, COARSE, 1)
            gaps.append(float(np.linalg.norm(self._gap(state.x))))
            farthest = max(farthest, gaps[-1])
            if len(gaps) > 2 and gaps[-3] > gaps[-2] < gaps[-1] and gaps[-2] < NEAR * farthest:
                return float(state.time - step)
        raise DefinitionError(
            "periodic: the motion does not come back next to its start within "
            f"t = {state.time:.6g}; give a period"
        )

    def _nearest_time(self, time: float) -> float:
        """When, next to a time, the motion is nearest to its start: (x(t) - x) . x'(t) = 0."""
        nearest = time
        for _ in range(5):
            state = self.flow.start(self.anchor[0], units=self.state_units)
            self.flow.go(state, nearest, self.values, COARSE, 1)
            rates = self._rates(state.x) / self.state_units
            nearest -= float(self._gap(state.x) @ rates / (rates @ rates))
            if not 0.5 * time < nearest < 2 * time:
                return time
        return nearest

    def in_parts(self, count: int) -> _OrbitEquations:
        """With so many parts, the guess along the motion from the start."""
        rows, state = [self.anchor[0]], self.flow.start(self.anchor[0], units=self.state_units)
        for i in range(1, count):
            self.flow.go(state, self.span * i / count, self.values, self.tol, 1)
            rows.append(state.x.copy())
        guess = np.append((np.array(rows) / self.state_units).ravel(), 1.0)
        return replace(self, segments=count, guess=guess)

    def states(self, unknowns: np.ndarray) -> np.ndarray:
        """The states (m, n) of unknowns."""
        return unknowns[:-1].reshape(self.segments, -1) * self.state_units

    def period(self, unknowns: np.ndarray) -> float:
        """The period of unknowns."""
        return float(unknowns[-1] * self.span)

    def arcs(self, unknowns: np.ndarray) -> tuple[_Arc, ...]:
        """The motion over the parts of the period."""
        key = self.segments, unknowns.tobytes()
        if key not in self.recent:
            if len(self.recent) >= RECENT:
                self.recent.clear()
            self.recent[key] = tuple(self._integrate(unknowns))
        return self.recent[key]

    def _integrate(self, unknowns: np.ndarray) -> Iterator[_Arc]:
        n, part = len(self.state_units), self.period(unknowns) / self.segments
        for i, x in enumerate(self.states(unknowns)):
            state = self.flow.start(x, time=i * part * self.space.is_driven, columns=np.eye(n))
            self.flow.go(state, state.time + part, self.values, self.tol)
            yield _Arc(state.x.copy(), state.columns.copy())

    def function(self, unknowns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What the equations are off (e,), and the slopes of that (e, u); not finite where the
        motion cannot be followed."""
        if 0.01 < unknowns[-1] < 100:
            try:
                parts = self._closing(unknowns), self._conditions(unknowns)
                return np.concatenate([p[0] for p in parts]), np.concatenate([p[1] for p in parts])
            except VoronecError:
                pass
        count = len(unknowns) + len(self.held)
        return np.full(count, np.nan), np.full((count, len(unknowns)), np.nan)

    def _closing(self, unknowns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """By what the ends of the parts miss the next beginnings; the slopes."""
        n, m, units, x = (
            len(self.state_units),
            self.segments,
            self.state_units,
            self.states(unknowns),
        )
        off, slopes = np.zeros((m, n)), np.zeros((m, n, len(unknowns)))
        arcs = self.arcs(unknowns)
        for i, (end, columns) in enumerate(arcs):
            j = (i + 1) % m
            off[i] = (end - x[j]) / units
            slopes[i, :, i * n : (i + 1) * n] += columns * units / units[:, None]
            slopes[i, :, j * n : (j + 1) * n] -= np.eye(n)
            if not self.space.is_driven:
                slopes[i, :, -1] = self._rates(end) * self.span / m / units
        off[-1] -= self.turns(unknowns) * 2 * np.pi / units
        return off.ravel(), slopes.reshape(m * n, -1)

    def _rates(self, x: np.ndarray) -> np.ndarray:
        return self.flow.rates(x, self.values)[0]

    def _conditions(self, unknowns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What constants are off their values, and a point of the orbit its place; the slopes."""
        x, n, held = self.states(unknowns)[0], len(self.state_units), self.held
        constants, gradients = self.space.constants_at(x, self.values)
        sizes = np.linalg.norm(gradients * self.state_units, axis=1)[held]
        sizes[sizes == 0] = 1.0
        off, slopes = np.zeros(len(held) + 1), np.zeros((len(held) + 1, len(unknowns)))
        off[:-1] = (constants[held] - self.targets) / sizes
        slopes[:-1, :n] = gradients[held] * self.state_units / sizes[:, None]
        if self.space.is_driven:  # then the period is known
            off[-1], slopes[-1, -1] = unknowns[-1] - 1.0, 1.0
        else:  # of all its points the orbit is told by one
            place, rates = self.anchor
            slopes[-1, :n] = rates / self.state_units / np.linalg.norm(rates / self.state_units)
            off[-1] = slopes[-1, :n] @ ((x - place) / self.state_units)
        return off, slopes

    def turns(self, unknowns: np.ndarray) -> np.ndarray:
        """By how many whole turns angles have grown."""
        grown = (self.arcs(unknowns)[-1].end - self.states(unknowns)[0]) / (2 * np.pi)
        return np.where(self.turning, np.round(grown), 0.0)

    def solve_from_guess(self) -> np.ndarray:
        """The unknowns of the orbit to which the guess leads; ``DefinitionError`` if to none."""
        solution = solve(self.function, self.guess, self.units, CLOSURE, SINGULAR)
        if solution is None or not self._closes(solution):
            error = np.abs(self.function(self.guess)[0]).max()
            raise DefinitionError(
                f"no periodic orbit is found near the start, which fails to close by {error:.1e} "
                f"after t = {self.span:.6g}; give another start or period"
                + (", or hold fewer integrals" if len(self.held) else "")
            )
        if self._is_still(solution):
            raise DefinitionError("the guess leads to an equilibrium; start farther away from it")
        return solution

    def _closes(self, unknowns: np.ndarray) -> bool:
        return bool(np.abs(self.function(unknowns)[0]).max() <= CLOSURE)

    def _is_still(self, unknowns: np.ndarray) -> bool:
        rates, matrix = self.flow.rates(self.states(unknowns)[0], self.values)
        units = self.state_units
        pace = np.linalg.norm(matrix * units / units[:, None], 2)
        return bool(np.abs(rates / units).max() < STILL * pace)

    def multipliers(self, unknowns: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The monodromy, trivial and other multipliers."""
        x = self.states(unknowns)[0]
        monodromy = reduce(
            lambda before, arc: arc.slopes @ before, self.arcs(unknowns), np.eye(len(x))
        )
        rates = None if self.space.is_driven else self._rates(x)
        gradients = self.space.constants_at(x, self.values)[1]
        return monodromy, *_split_multipliers(monodromy, rates, gradients, self.state_units)

    def orbit(self, unknowns: np.ndarray) -> PeriodicOrbit:
        """The orbit of unknowns that solve the equations."""
        space, values = self.space, self.values
        x, period = self.states(unknowns)[0], self.period(unknowns)
        monodromy, trivial, others = self.multipliers(unknowns)
        closure = float(np.abs(self.with_phase_of(unknowns).function(unknowns)[0]).max())
        constants = space.constants_at(x, values)[0].tolist()
        path, state = [x], self.flow.start(x)
        for t in np.linspace(0, period, POINTS)[1:]:
            self.flow.go(state, t, values, COARSE, 1)
            path.append(state.x.copy())
        parameters = map(str, space.motions.program.parameters)
        return PeriodicOrbit(
            space.system, space.names, x, period, self.turns(unknowns).astype(int),
            monodromy, trivial, others, dict(zip(space.constants, constants, strict=True)),
            dict(zip(parameters, values.tolist(), strict=True)), closure, np.array(path),
        )  # fmt: skip

    def follow(
        self, unknowns: np.ndarray, to: float, points: int, progress: Callable[[float], Any] | None
    ) -> tuple[list[np.ndarray], str]:
        """The family up to the value ``to`` of what it is followed along, and why it ends."""
        begin = self.value(unknowns)
        if begin == to:
            return [], COMPLETE
        sign, step = float(np.sign(to - begin)), abs(to - begin) / (points - 1)
        span = (-np.inf, to) if to > begin else (to, np.inf)
        tell = None if progress is None else lambda x: progress((x - begin) / (to - begin))
        return follow(self, unknowns, sign, span, step, 2 * points, progress=tell)

    def without_target(self) -> _OrbitEquations:
        """Without holding what the family is followed along."""
        free = self.held != self.along
        return replace(self, held=self.held[free], targets=self.targets[free])

    def with_phase_of(self, unknowns: np.ndarray) -> _OrbitEquations:
        """With the phase of the orbit of unknowns."""
        x = self.states(unknowns)[0]
        return replace(self, anchor=(x, self._rates(x)))

    @property
    def units(self) -> np.ndarray:
        """The sizes of the unknowns."""
        return np.ones(self.segments * len(self.state_units) + 1)

    def value(self, y: np.ndarray) -> float:
        """What the family is followed along."""
        assert self.along is not None
        return float(self.space.constants_at(self.states(y)[0], self.values)[0][self.along])

    def slope(self, y: np.ndarray) -> np.ndarray:
        """The slope of that by the unknowns."""
        _, gradients = self.space.constants_at(self.states(y)[0], self.values)
        row = np.zeros(len(y))
        row[: len(self.state_units)] = gradients[self.along] * self.state_units
        return row

    def tangent(self, y: np.ndarray, ahead: np.ndarray) -> np.ndarray | None:
        """The direction of the family on the side of ``ahead``, of length one: where the family has
        more dimensions, that in which what it is followed along changes most."""
        free = null_space(self.with_phase_of(y).function(y)[1], self.units)
        guide = self.slope(y) if free.shape[1] > 1 else ahead
        direction = free @ (free.T @ guide)
        size = np.linalg.norm(direction)
        if not size > SINGULAR * np.linalg.norm(guide):
            return None
        return np.asarray(direction / size if direction @ ahead >= 0 else -direction / size)

    def onto(self, y: np.ndarray, across: np.ndarray) -> np.ndarray | None:
        """The orbit in the plane through unknowns across a direction."""
        function = self.with_phase_of(y).function
        return self._sound(
            solve_across(function, y, across, self.units, close=CLOSURE, singular=SINGULAR)
        )

    def at_value(self, value: float, near: np.ndarray) -> np.ndarray | None:
        """The orbit with a value of what the family is followed along, near another."""
        assert self.along is not None
        held, targets = np.append(self.held, self.along), np.append(self.targets, value)
        function = replace(self.with_phase_of(near), held=held, targets=targets).function
        return self._sound(solve(function, near, self.units, CLOSURE, SINGULAR))

    def _sound(self, unknowns: np.ndarray | None) -> np.ndarray | None:
        """Unknowns of an orbit that closes, and moves."""
        if unknowns is None or self._is_still(unknowns):
            return None
        return unknowns if self.with_phase_of(unknowns)._closes(unknowns) else None

    def bifurcations(
        self, begin: tuple[np.ndarray, PeriodicOrbit], end: tuple[np.ndarray, PeriodicOrbit]
    ) -> Iterator[Bifurcation]:
        """Where multipliers pass -1 or 1 between two orbits of a family."""
        for at in (-1, 1):
            ends = [float(np.prod(orbit.multipliers - at).real) for _, orbit in (begin, end)]
            if min(map(abs, ends)) < MARGIN:
                continue
            crossing = root_between(self, begin[0], end[0], partial(self._distance, at))
            if crossing is not None:
                yield Bifurcation(at, self.value(crossing), self.orbit(crossing))

    def _distance(self, at: int, unknowns: np.ndarray) -> float:
        """The product of all distances of multipliers from 1 or -1."""
        return float(np.prod(self.multipliers(unknowns)[2] - at).real)


def _split_multipliers(
    monodromy: np.ndarray, rates: np.ndarray | None, gradients: np.ndarray, units: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The multipliers of the flow and of the constants of the motion, and all others, by the blocks
    of the module; ``rates`` are None where the time stands in the equations."""
    matrix = monodromy * units / units[:, None]
    rows = gradients * units
    sizes = np.linalg.norm(rows, axis=1)
    rows = rows[sizes > 0] / sizes[sizes > 0, None]
    _, values, basis = np.linalg.svd(rows) if len(rows) else (0, np.zeros(0), np.eye(len(units)))
    rank = int((values > 1e-9).sum())
    across, inside = basis[:rank], basis[rank:]
    trivial = [np.linalg.eigvals(across @ matrix @ across.T)]
    if rates is not None:
        along = rates / units / np.linalg.norm(rates / units)
        trivial.append(np.array([along @ matrix @ along]))
        inside = np.linalg.svd((inside @ along)[None])[2][1:] @ inside
    others = np.linalg.eigvals(inside @ matrix @ inside.T) if len(inside) else np.array([])
    return np.concatenate(trivial), others[np.argsort(-np.abs(others), kind="stable")]
