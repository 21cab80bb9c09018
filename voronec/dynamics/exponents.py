"""Lyapunov exponents: how fast motions that start next to each other part.

    x' = f(x),  Y' = J(x) Y,     lambda_j = lim (1/t) log R_jj(t),   Y = Q R

with the columns made orthonormal on the way [BenettinEtAl1980; ShimadaNagashima1979].  Of a time T
the last half is taken for the value; its sixteenths tell how much the stretches differ, and the
quarter before it how much the value still moves:

    bar = 2 s / sqrt(16) + max(|lambda(T/2, T) - lambda(T/4, T/2)|, log 2/(T/2))

For a regular motion Y grows like a power of t, lambda(a, b) like log(b/a)/(b - a): the second term
is then as large as the value, so that zero lies within the bar; the last is what linear growth
gives, than which nothing is told better from zero in the time T.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from voronec.algebra.arguments import (
    CALLABLE,
    OPTIONAL_COUNT,
    OPTIONAL_REAL,
    SEVERAL,
    TOLERANCE,
    VALUES,
    accepts,
)
from voronec.algebra.typeset import html_table
from voronec.declaration.system import System
from voronec.dynamics.phase_space import PhaseSpace
from voronec.dynamics.variational import EVERY, VariationalFlow, VariationalState
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError, VoronecError

if TYPE_CHECKING:
    from voronec.motion.storage import NamedArrays

STRETCH = 100
"""Steps of the stretch whose length all others have."""
LONGEST_STRETCH = 1000
"""A stretch that takes so many times more steps comes to a singularity of the equations."""
FIRST_LOOK, LATER = 64, 1.25
"""After so many stretches the exponents are looked at first, and then after so many times more."""
PARTS = 16
"""Parts of the last half whose spread is taken."""
SHARE = 1e-3
"""The bar asked for where none is given, in units of how fast variations change at the start."""
LONGEST = 3e5
"""So long a motion is followed at most where nothing is said, in units of that time."""


@dataclass(frozen=True, eq=False, repr=False)
class Exponents:
    """Lyapunov exponents of one or more motions.

    values, bars
        (s, k), from the largest exponent downwards, for motions s, per unit of time: value and
        error bar (see the module).
    is_settled
        (s,): whether all bars are as small as was asked.
    least_zeros
        (s,): so many exponents vanish at least: one along the flow of a motion that does not come
        to rest, one for each independent constant of the motion.
    divergence
        (s,): the mean of tr J, which the sum of all exponents equals.
    drift
        (s,): the largest change of a constant of the motion, relative to gradient and state.
    reversal
        the signs of ``variables`` that reverse the motions, or None: exponents of a motion that is
        its own mirror image, or comes near to it again and again, then come in pairs.
    time
        (s,): how long the motions were followed.
    errors
        by position why a motion has no exponents; its numbers are no numbers.
    """

    system: System
    variables: tuple[str, ...]
    constants: tuple[str, ...]
    values: np.ndarray
    bars: np.ndarray
    is_settled: np.ndarray
    least_zeros: np.ndarray
    divergence: np.ndarray
    drift: np.ndarray
    reversal: tuple[int, ...] | None
    time: np.ndarray
    errors: Mapping[int, VoronecError]
    bar: float
    seconds: float
    interrupted: bool = False

    def __len__(self) -> int:
        return len(self.values)

    @property
    def zeros(self) -> np.ndarray:
        """How many exponents of each motion are not told from zero (s,)."""
        return np.asarray((np.abs(self.values) <= self.bars).sum(axis=1))

    @property
    def is_whole(self) -> bool:
        """Whether these are all exponents, as many as there are variables."""
        return self.values.shape[1] == len(self.variables)

    @property
    def sum_defects(self) -> np.ndarray:
        """What the sums of all exponents are off the mean divergence (s,): rounding and errors of
        integration alone; no numbers where some exponents were left out."""
        off = np.abs(self.values.sum(axis=1) - self.divergence)
        return np.where(self.is_whole, off, np.nan)

    @property
    def pair_defects(self) -> np.ndarray:
        """How far exponents are from coming in pairs, max |lambda_j + lambda_(n+1-j)| (s,)."""
        off = np.abs(self.values + self.values[:, ::-1]).max(axis=1)
        return np.where(self.is_whole, off, np.nan)

    def lines(self, i: int) -> list[str]:
        """What there is to say of motion i, in words."""
        if i in self.errors:
            return [str(self.errors[i])]
        digits = max(0, min(12, 1 - int(np.floor(np.log10(max(self.bars[i].min(), 1e-12))))))
        rows = [
            f"{x:+.{digits}f} +- {b:.1g}{'  zero' if abs(x) <= b else ''}"
            for x, b in zip(self.values[i], self.bars[i], strict=True)
        ]
        told = [f"followed over a time of {self.time[i]:.6g}"]
        if not self.is_settled[i]:
            told[0] += f"; not settled: bars up to {self.bars[i].max():.2g}, {self.bar:.2g} asked"
        if self.is_whole:
            known = " and ".join(
                ["the flow", *([", ".join(self.constants)] * bool(self.constants))]
            )
            told.append(f"{self.zeros[i]} zeros; at least {self.least_zeros[i]} by {known}")
            told.append(f"sum {self.values[i].sum():.3g}, mean divergence {self.divergence[i]:.3g}")
        if self.is_whole and self.reversal is not None:
            flipped = [n for n, s in zip(self.variables, self.reversal, strict=True) if s < 0]
            told.append(f"reversed by the signs of {', '.join(flipped)}; in pairs to "
                        f"{self.pair_defects[i]:.2g}")  # fmt: skip
        return rows + told

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the exponents to ``path``, as ``Trajectory.save`` does."""
        return self._arrays().save(path)

    def to_xarray(self) -> Any:
        """The exponents as an ``xarray.Dataset``, the header as attributes."""
        return self._arrays().to_xarray()

    def to_pandas(self) -> Any:
        """The exponents as a ``pandas.DataFrame``, a row for each motion and exponent."""
        return self._arrays().to_pandas()

    def _arrays(self) -> NamedArrays:
        from voronec.motion.storage import NamedArrays, of_motions, variables_of

        arrays: dict[str, Any] = {
            "exponent": (("motion", "place"), self.values),
            "bar": (("motion", "place"), self.bars),
            "settled": (("motion",), self.is_settled),
            "divergence": (("motion",), self.divergence),
        }
        each = of_motions(len(self), self.errors, {}, drift={})
        return NamedArrays.of(
            self.system, "Exponents", variables_of(arrays, each), ("motion", "place"),
            ("motion", "place", "exponent", "bar"), interrupted=self.interrupted,
        )  # fmt: skip

    def __repr__(self) -> str:
        if len(self) == 1 and not self.errors:
            shown = ", ".join(f"{x:.4g}" for x in self.values[0])
            return f"Exponents({self.system.name!r}, {shown}; bars to {self.bars.max():.1g})"
        return f"Exponents({self.system.name!r}, {len(self)} motions)"

    def _repr_html_(self) -> str:
        """For notebooks: the exponents of the first motions with their bars."""
        rows = [(f"motion {i}", "; ".join(self.lines(i))) for i in range(min(len(self), 20))]
        return html_table(repr(self), rows)


@accepts(
    initial=VALUES, parameters=VALUES, inputs=VALUES, variables=SEVERAL, count=OPTIONAL_COUNT,
    bar=OPTIONAL_REAL, until=OPTIONAL_REAL, tol=TOLERANCE, progress=CALLABLE,
)  # fmt: skip
def exponents(
    system: System | VoronecEquations,
    scene: Any = None,
    initial: Mapping[Any, Any] | None = None,
    parameters: Mapping[Any, Any] | None = None,
    starts: Mapping[Any, Any] | Sequence[Mapping[Any, Any]] | None = None,
    variables: Sequence[Any] = (),
    count: int | None = None,
    bar: float | None = None,
    until: float | None = None,
    tol: float = 1e-9,
    inputs: Mapping[Any, Any] | None = None,
    progress: Callable[[float], Any] | None = None,
) -> Exponents:
    """The Lyapunov exponents of a motion, or of many.

    scene, initial, parameters, inputs
        as for ``integrate``; ``starts``, and parameters that are arrays, give many motions, as for
        ``ensemble``.
    variables
        the quantities whose smallest closed equations are taken for the phase space, by default the
        velocities of the equations: coordinates that nothing depends on have zeros of their own,
        and are left out.  Each relation between the variables, as gamma^2 = 1, adds a zero.
    count
        how many exponents, the largest ones; by default all.
    bar
        the error bar at which to stop, per unit of time; by default a thousandth of the norm of the
        Jacobian at the start.
    until
        how long a motion is followed at most; what has not settled by then is said to have not.
    tol
        the tolerance of a step, for the state and for its variations.
    progress
        is called with the finished fraction.

    Ctrl-C keeps what is known.  Raises ``DefinitionError`` for input that makes no sense and a
    right side that is not smooth, and the error of the motion where there is a single one.
    """
    began = perf_counter()
    if starts is not None and initial:
        raise DefinitionError("exponents: give initial, or starts, not both")
    space = PhaseSpace.of(system, scene, initial or starts, parameters, inputs, variables)
    n = len(space.names)
    for name, value, good in (
        ("count", count, count is None or 1 <= count <= n), ("bar", bar, bar is None or bar > 0),
        ("until", until, until is None or until > 0),
    ):  # fmt: skip
        if not good:
            raise DefinitionError(f"exponents: {name}={value}: give a number above 0"
                                  + (f", up to {n}" if name == "count" else ""))  # fmt: skip
    spectra, flow = _blank(space, count or n), space.flow(count)
    errors, asked, interrupted = dict(space.motions.wrong), 0.0, False
    for i in space.motions.sound:
        try:
            asked = _fill(spectra, i, space, flow, bar, until, tol)
        except VoronecError as error:
            errors[i] = error
        except KeyboardInterrupt:
            interrupted = True
            break
        if progress is not None:
            progress((i + 1) / len(space.motions))
    if len(space.motions) == 1 and errors:
        raise errors[0]
    return replace(spectra, errors=errors, bar=asked, seconds=perf_counter() - began,
                   interrupted=interrupted)  # fmt: skip


def _blank(space: PhaseSpace, k: int) -> Exponents:
    """What holds no numbers yet, for k exponents of each start."""
    count = len(space.motions)
    wide, row = np.full((count, k), np.nan), np.full(count, np.nan)
    return Exponents(
        space.system, space.names, tuple(space.constants), wide, wide.copy(),
        np.zeros(count, dtype=bool), np.zeros(count, dtype=int), row, row.copy(),
        space.reversal(space.motions.sound[0]), row.copy(), {}, 0.0, 0.0,
    )  # fmt: skip


def _fill(
    found: Exponents, i: int, space: PhaseSpace, flow: VariationalFlow, bar: float | None,
    until: float | None, tol: float,
) -> float:  # fmt: skip
    """Write the exponents of motion i into ``found``; the bar that is asked of them."""
    x, values, units = space.motions.states[i], space.motions.values[i], space.units(i)
    rates, matrix = flow.rates(x, values)
    pace = float(np.linalg.norm(matrix * units / units[:, None], 2))
    pace = pace or float(np.abs(rates / units).max()) or 1.0
    asked, latest = bar or SHARE * pace, until or LONGEST / pace
    state = flow.start(x, units=units)
    stretches = _Stretches.along(flow, state, values, tol, asked, latest)
    order = np.argsort(-stretches.value, kind="stable")
    found.values[i], found.bars[i] = stretches.value[order], stretches.bar[order]
    found.is_settled[i] = bool((stretches.bar <= asked).all())
    rates, _ = flow.rates(state.x, values)  # of a motion that has come to rest there are none
    moves = not space.is_driven and bool((np.abs(rates) > tol * pace * units).any())
    found.least_zeros[i] = space.rank(state.x, values) + moves
    found.divergence[i], found.time[i] = stretches.divergence, state.time
    first, _ = space.constants_at(x, values)
    last, slopes = space.constants_at(state.x, values)
    sizes = np.abs(slopes) @ np.maximum(np.abs(state.x), units)
    off = np.abs(last - first) / np.where(sizes > 0, sizes, 1.0)
    found.drift[i] = off.max(initial=0.0)
    return asked


@dataclass(frozen=True, eq=False)
class _Stretches:
    """Exponents along stretches of one length: value, bar (k,) and mean divergence."""

    value: np.ndarray
    bar: np.ndarray
    divergence: float

    @classmethod
    def along(
        cls, flow: VariationalFlow, state: VariationalState, values: np.ndarray, tol: float,
        asked: float, latest: float,
    ) -> _Stretches:  # fmt: skip
        """Follow a motion stretch by stretch until its bars are as ``asked``, or to ``latest``."""
        flow.go(state, latest / FIRST_LOOK, values, tol, EVERY, STRETCH)
        length, begin = state.time, state.time
        sums, enough = [np.array([*state.logs, state.divergence])], FIRST_LOOK
        while True:
            end = begin + length * len(sums)
            if not flow.go(state, end, values, tol, EVERY, LONGEST_STRETCH * STRETCH):
                raise flow.failure(state)
            sums.append(np.array([*state.logs, state.divergence]))
            if len(sums) > enough or state.time >= latest:
                stretches = cls.of(np.array(sums), length)
                if state.time >= latest or (stretches.bar <= asked).all():
                    return stretches
                enough = int(LATER * enough)

    @classmethod
    def of(cls, sums: np.ndarray, length: float) -> _Stretches:
        """From logarithms and divergence (m + 1, k + 1) at the ends of m stretches."""
        most = PARTS * max((len(sums) - 1) // (2 * PARTS), 1)
        last = sums[-1 - most :: most // PARTS]
        parts = np.diff(last, axis=0) / (length * (most // PARTS))
        quarter = sums[-1 - most] - sums[-1 - most - most // 2]
        mean = parts.mean(axis=0)
        spread = 2 * parts.std(axis=0, ddof=1) / np.sqrt(PARTS)
        moved = np.maximum(np.abs(mean - quarter / (length * (most // 2))),
                           np.log(2) / (length * most))  # fmt: skip
        return cls(mean[:-1], (spread + moved)[:-1], float(mean[-1]))
