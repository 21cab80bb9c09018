"""Where one motion sets out: its start on the coordinates, in doubles and in any precision."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from voronec.equations.attitudes import with_attitude_charts
from voronec.equations.program import Program
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError, IntegrationError
from voronec.motion.all_velocities import WideStart
from voronec.motion.exact_values import Exactly
from voronec.motion.inertia import require_inertia
from voronec.motion.initial_state import (
    Start,
    coordinates_of,
    numbers_of,
    parameter_values,
    start_of,
)
from voronec.motion.request import StartData
from voronec.motion.singular_directions import (
    POLE,
    blind_directions,
    charted_directions,
    open_beyond,
    polar_directions,
)
from voronec.motion.split_models import NEAR, SplitGround
from voronec.motion.state_probe import Probe, quantities
from voronec.motion.steppers.signals import Signals
from voronec.motion.velocity_conditions import CONSISTENT, NoFrame, Rates
from voronec.motion.vocabulary import Vocabulary

__all__ = ["Outset", "rates_at"]


def rates_at(
    equations: VoronecEquations, form: Any, constants: Mapping[str, float], time: float
) -> Rates:
    """The velocities of all coordinates by a form of the equations, or, where that has a pole or
    loses all digits, by their normal form; not a number where that does, too."""
    ground = SplitGround(equations, constants, time)

    def rates(q: np.ndarray, v: np.ndarray) -> np.ndarray:
        found = v
        for own in (form, equations.form):
            values = [constants.get(str(p), np.nan) for p in own.parameters]
            probe = Probe(equations.system.name, own, quantities(own, {}), values, time)
            found = probe.rates(q, v)
            if np.isfinite(found).all() and _are_rates(ground, q, v, found):
                return found
        return np.full_like(found, np.nan)

    return rates


def _are_rates(ground: SplitGround, q: np.ndarray, v: np.ndarray, w: np.ndarray) -> bool:
    """Whether velocities w (n, k) of coordinates meet A w + a = 0 and F w + f = v, for v (m, k):
    where a pivot is rounding alone, quotients by it are finite, and mean nothing."""
    if ground.home.definition.group is not None:
        return True
    conditions, frame = ground.rows(ground.time, np.concatenate([q, np.zeros(len(w))]))
    rows = np.vstack([conditions, frame])
    off = rows[:, :-1] @ w + rows[:, -1:]
    off[len(conditions) :] -= v
    size = 1.0 + np.abs(rows[:, :-1]) @ np.abs(w) + np.abs(rows[:, -1:])
    return bool((np.abs(off) <= CONSISTENT * size).all())


def _at_rest(vocabulary: Vocabulary, ground: SplitGround, given: StartData) -> np.ndarray:
    """The coordinates at the start, with velocities that are zero."""
    values = [
        numbers_of(vocabulary, part, ground.constants)
        for part in (given.scene_initial, given.initial)
    ]
    q, _ = coordinates_of(
        vocabulary, {**values[0], **values[1]}, ground.constants, ground.time, project=True
    )
    return np.concatenate([q, np.zeros(len(ground.home.definition.dots))])


def _is_frame(ground: SplitGround, wide: np.ndarray) -> bool:
    """Whether the velocities of the equations are a frame at the start, as well as it matters."""
    try:
        return ground.geometry(ground.time, wide).quality > NEAR
    except np.linalg.LinAlgError:
        return True


def _only_angles_fail(ground: SplitGround, wide: np.ndarray) -> bool:
    """Whether a wide state is where angles are singular and charts lead on, and the velocities v
    leave nothing open there but what is no motion."""
    blind = blind_directions(ground, wide)
    if not blind.shape[1] or not (
        charted_directions(ground, wide).shape[1] or with_attitude_charts(ground.home) is not None
    ):
        return False
    rows = np.vstack(ground.rows(ground.time, wide))[:, :-1]
    return bool(np.abs(open_beyond(rows, blind)).max(initial=0.0) < POLE)


@dataclass(frozen=True)
class Outset:
    """The start on the coordinates: ``state`` (n,), coordinates, then velocities; ``constants`` by
    name; ``notes``, what was moved on request; and both again ``exactly``, in any precision.
    Constants that are ``changing`` are those of the start; ``framed`` says whether the velocities
    of the equations are a frame there, but for the poles of angles."""

    state: np.ndarray
    constants: Mapping[str, float]
    notes: tuple[str, ...]
    exactly: Exactly
    changing: Signals | None = None
    framed: bool = True

    def is_at_pole(self, equations: VoronecEquations) -> bool:
        """Whether it is at a pole of Euler's angles."""
        return bool(polar_directions(equations, self.state).shape[1])

    @property
    def steady(self) -> dict[str, float]:
        """The constants, those that change without a value: no model may rest on it."""
        changing = self.changing.names if self.changing is not None else ()
        return {**self.constants, **dict.fromkeys(changing, np.nan)}

    @classmethod
    def of(
        cls,
        vocabulary: Vocabulary,
        given: StartData,
        time: float,
        project: bool,
        changing: Signals | None = None,
    ) -> Outset:
        """Read what is given, and look whether a motion starts there."""
        equations = vocabulary.equations
        constants = parameter_values(vocabulary, given.parameters, set())
        form = equations.raw.form  # made in no time
        if any(p.name not in constants for p in equations.system.parameters):
            form = equations.form
            needed = {str(s) for s in Program.of(form).derivative.symbols}
            constants = parameter_values(vocabulary, given.parameters, needed)
        rates = rates_at(equations, form, constants, time)
        start, framed = None, True
        try:
            start = start_of(
                vocabulary, given.scene_initial, given.initial, constants, rates, time, project
            )
            require_inertia(equations, constants, start.state, time)
        except (DefinitionError, IntegrationError) as error:
            ground = SplitGround(equations, constants, time)
            rest = _at_rest(vocabulary, ground, given)
            # rates of angles are no numbers at their poles, whatever rounding makes of them
            known = start is not None or not blind_directions(ground, rest).shape[1]
            if known and not isinstance(error, NoFrame) and _is_frame(ground, rest):
                raise
            wide = WideStart.of(vocabulary, ground, given, project)
            start, framed = Start(wide.home), _only_angles_fail(ground, wide.wide)
        exactly = Exactly(
            vocabulary, quantities(form, {}), time, given.parameters, given.scene_initial,
            given.initial, start.state, bool(start.notes),
        )  # fmt: skip
        return cls(start.state, constants, start.notes, exactly, changing, framed)
