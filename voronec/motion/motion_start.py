"""The start of one motion from its initial conditions, in doubles and any precision.

Where the declared velocities need not be a frame,

    A w + a = 0,    F w + f = v,    w_k = what is given of it

is solved for all velocities w, in doubles and, by refinement, in any precision.

Parameters and initial data that are given exactly are used exactly.  Doubles stay the doubles they
are.  The velocities start from those found in doubles, and are moved until the conditions on them
hold to the last digit.

A parameter that is zero may leave a velocity without inertia, whose acceleration is then 0/0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NoReturn

import mpmath
import numpy as np
import sympy as sp

from voronec.algebra.memo import Memo
from voronec.algebra.symbols import plain_name, velocity
from voronec.algebra.text import as_expression
from voronec.equations.attitudes import with_attitude_charts
from voronec.equations.program import Program
from voronec.equations.program.python import compiled_digits
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError, EngineLimit, IntegrationError
from voronec.motion.constraint_geometry import ConstraintGeometry
from voronec.motion.formulation import ModelCache
from voronec.motion.initial_conditions import (
    CONSISTENT,
    NO_VELOCITIES,
    NoFrame,
    Rates,
    Start,
    coordinates_of,
    note_of_velocities,
    numbers_of,
    parameter_values,
    start_of,
)
from voronec.motion.request import Namespace, StartData, kept_while_same
from voronec.motion.singular_coordinates import (
    POLE,
    blind_directions,
    carried_directions,
    charted_directions,
    idle_directions,
    open_beyond,
    polar_directions,
)
from voronec.motion.singular_denominators import NEAR
from voronec.motion.state_probe import StateProbe, quantities, rates_program
from voronec.motion.steppers import Signals


def rates_at(
    equations: VoronecEquations, form: Any, constants: Mapping[str, float], time: float
) -> Rates:
    """The velocities that follow by a form of the equations, or, where that has a pole or loses all
    digits, by their normal form; not a number where that does, too."""
    ground = ConstraintGeometry(equations, constants, time)

    def rates(q: np.ndarray, v: np.ndarray) -> np.ndarray:
        slopes = v
        for normal in (False, True):  # that is derived where it is needed alone
            chosen = equations.form if normal else form
            values = [constants.get(str(p), np.nan) for p in chosen.parameters]
            program = _rates_program(equations, chosen)
            slopes = StateProbe(equations.system.name, chosen, program, values, time).rates(q, v)
            if np.isfinite(slopes).all() and _are_rates(ground, q, v, slopes):
                return slopes
        return np.full_like(slopes, np.nan)

    return rates


def _rates_program(equations: VoronecEquations, form: Any) -> Program:
    """The ``rates_program`` of a form of the equations, kept with them and on disk."""
    kind = "raw" if form is equations.raw.form else "short"

    def make() -> Program:
        d = equations.definition
        model_cache = ModelCache(equations.system, ["rates", kind, d.near])
        program = model_cache.once("program", lambda: rates_program(form, d.fibre_velocities))
        model_cache.keep()
        return program

    return equations.memo.once(("rates", kind), make)


def _are_rates(ground: ConstraintGeometry, q: np.ndarray, v: np.ndarray, w: np.ndarray) -> bool:
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


def _numbers_and_place(
    namespace: Namespace, ground: ConstraintGeometry, given: StartData, project: bool
) -> tuple[dict[str, float], dict[str, float], np.ndarray, list[str]]:
    """What the scene says and what is given besides, the coordinates, and what was moved."""
    old, new = (
        numbers_of(namespace, part, ground.constants)
        for part in (given.scene_initial, given.initial)
    )
    place = coordinates_of(namespace, {**old, **new}, ground.constants, ground.time, project)
    return old, new, *place


def _is_frame(ground: ConstraintGeometry, wide: np.ndarray) -> bool:
    """Whether the velocities of the equations are a frame at the start, as well as it matters."""
    try:
        return ground.frame_quality(ground.time, wide) > NEAR
    except np.linalg.LinAlgError:
        return True


def _require_frame(ground: ConstraintGeometry, state: np.ndarray) -> None:
    """Refuse a start on coordinates and velocities v that are no frame there, but for poles."""
    d = ground.home.definition
    wide = np.concatenate([state[: len(d.coordinates)], np.zeros(len(d.dots))])
    if not blind_directions(ground, wide).shape[1] and not _is_frame(ground, wide):
        raise NoFrame(NO_VELOCITIES.format(ground.home.system.name))


def _only_angles_fail(ground: ConstraintGeometry, wide: np.ndarray) -> bool:
    """Whether a wide state is where angles are singular and charts lead on, and the velocities v
    leave nothing open there but what is no motion."""
    blind = blind_directions(ground, wide)
    if not blind.shape[1] or not (
        charted_directions(ground, wide).shape[1]
        or carried_directions(ground, wide).shape[1]
        or with_attitude_charts(ground.home) is not None
    ):
        return False
    rows = np.vstack(ground.rows(ground.time, wide))[:, :-1]
    return bool(np.abs(open_beyond(rows, blind)).max(initial=0.0) < POLE)


@dataclass(frozen=True)
class InitialState:
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
    memo: Memo = field(default_factory=Memo, repr=False, compare=False)

    @cached_property
    def constants_key(self) -> bytes:
        """Equal for the same constants, to the last bit."""
        return np.array([*self.constants.values()], dtype=float).tobytes()

    def is_at_pole(self, equations: VoronecEquations) -> bool:
        """Whether it is at a pole of Euler's angles."""
        return bool(polar_directions(equations, self.state).shape[1])

    def ground(self, equations: VoronecEquations, time: float) -> ConstraintGeometry:
        """The constraints, the frame and the inertia of the motion that starts here."""
        return ConstraintGeometry(equations, self.constants, time, changing=self.changing)

    @property
    def steady(self) -> dict[str, float]:
        """The constants, those that change without a value: no model may rest on it."""
        changing = self.changing.names if self.changing is not None else ()
        return {**self.constants, **dict.fromkeys(changing, np.nan)}

    @classmethod
    def of(
        cls,
        namespace: Namespace,
        given: StartData,
        time: float,
        project: bool,
        changing: Signals | None = None,
    ) -> InitialState:
        """Read what is given, and look whether a motion starts there.

        The last of the equations is kept, with what was computed of it.
        """
        if changing is not None or namespace.inputs:
            return cls._read(namespace, given, time, project, changing)

        def read() -> InitialState:
            outset = cls._read(namespace, given, time, project, None)
            outset.state.flags.writeable = False
            return outset

        said = given.parameters, given.scene_initial, given.initial
        asked = {"time": time, "project": int(project)}
        return kept_while_same(namespace, "last start", (*said, asked), read)

    @classmethod
    def _read(
        cls,
        namespace: Namespace,
        given: StartData,
        time: float,
        project: bool,
        changing: Signals | None,
    ) -> InitialState:
        equations = namespace.equations
        constants = kept_while_same(
            namespace, "parameters", (given.parameters,),
            lambda: parameter_values(namespace, given.parameters, set()),
        )  # fmt: skip
        form = equations.raw.form  # made in no time
        if not {*equations.system.parameter_names} <= constants.keys():
            form = equations.form
            needed = {str(s) for s in Program.of(form).derivative.symbols}
            constants = parameter_values(namespace, given.parameters, needed)
        rates = rates_at(equations, form, constants, time)
        start, framed = None, True
        try:
            start = start_of(
                namespace, given.scene_initial, given.initial, constants, rates, time, project
            )
            require_inertia(equations, constants, start.state, time)
            if start.notes:  # velocities that are no frame lie off what they are, and were "moved"
                _require_frame(ConstraintGeometry(equations, constants, time), start.state)
        except (DefinitionError, IntegrationError) as error:
            ground = ConstraintGeometry(equations, constants, time)
            _, _, q, _ = _numbers_and_place(namespace, ground, given, True)
            rest = np.concatenate([q, np.zeros(len(equations.definition.dots))])
            # rates of angles are no numbers at their poles, whatever rounding makes of them
            known = start is not None or not blind_directions(ground, rest).shape[1]
            if known and not isinstance(error, NoFrame) and _is_frame(ground, rest):
                raise
            wide = WideStart.of(namespace, ground, given, project)
            start, framed = Start(wide.home, wide.notes), _only_angles_fail(ground, wide.wide)
        exactly = Exactly(
            namespace, _rates_program(equations, form), time, given, start.state,
            bool(start.notes),
        )  # fmt: skip
        return cls(start.state, constants, start.notes, exactly, changing, framed)


LEAST_SINGULAR_VALUE = 1e-9
"""Conditions whose least singular value is below this part of the largest leave w open."""
ROUNDS = 40
"""Each round of refinement gains the digits of a double, where conditions are not too bad."""


@dataclass(frozen=True)
class WideStart:
    """The start of a motion on the coordinates and all their velocities.

    ``targets`` are the names of velocities that have the values given.  ``framed`` (n,) is a start
    on coordinates and velocities v that no finite w have, as at poles; w is not a number then.
    ``notes`` say what was moved on request.
    """

    namespace: Namespace
    ground: ConstraintGeometry
    start_data: StartData
    wide: np.ndarray
    targets: tuple[str, ...]
    framed: np.ndarray | None = None
    notes: tuple[str, ...] = ()

    @classmethod
    def of(
        cls,
        namespace: Namespace,
        ground: ConstraintGeometry,
        given: StartData,
        project: bool,
        framed: np.ndarray | None = None,
    ) -> WideStart:
        """Solve what is given; ``DefinitionError`` where it determines nothing, or contradicts.
        Where velocities v that are given belong to no w it is ``framed``, if that is known."""
        old, new, q, notes = _numbers_and_place(namespace, ground, given, project)
        system = ground.home.system
        names = {plain_name(x) for x in system.coordinates}
        later = {k: x for k, x in new.items() if k not in names}
        earlier = {k: x for k, x in old.items() if k not in names and k not in later}
        velocities = {plain_name(v): 0.0 for v in system.velocities}
        earlier = {**{k: x for k, x in velocities.items() if k not in later}, **earlier}
        posed = _Conditions.at(ground, q)
        posed.require_motion(ground, q)
        if posed.is_open(later, earlier):
            w = _sharp_velocities(namespace, ground, given, q, later, earlier)
        else:
            w = posed.solve(later, earlier)
        missed = [k for k, x in later.items() if not posed.holds(k, x, w)]
        if missed and not project and posed.blind.shape[1] and missed[0] in velocities:
            if framed is not None:
                return cls(namespace, ground, given, np.append(q, np.nan * w), (), framed)
            raise DefinitionError(
                f"system '{system.name}': no velocities of the coordinates have '{missed[0]}' = "
                f"{later[missed[0]]:.12g}, since these are singular at the initial point; start "
                "beside it"
            )
        if missed and not project:
            raise DefinitionError(
                f"system '{system.name}': the initial velocities are off the constraints: "
                f"'{missed[0]}' = {later[missed[0]]:.12g} (residual "
                f"{posed.residual(missed[0], later[missed[0]], w):.3g}); correct '{missed[0]}' "
                "or leave it out, or give project=True"
            )
        if missed:
            w, wanted = posed.nearest(later), np.array([*later.values()])
            moved = wanted + [posed.excess(k, x, w) for k, x in later.items()]
            notes.append(note_of_velocities([*later], wanted, moved))
            w = posed.solve(dict(zip(later, moved.tolist(), strict=True)), earlier)
        all_given = {**old, **later}
        held = tuple(k for k in all_given if k not in names and posed.holds(k, all_given[k], w))
        wide = np.concatenate([q, w])
        spare = tuple(k for k in velocities if k not in held and posed.holds(k, 0.0, w))
        return cls(namespace, ground, given, wide, (*held, *spare), notes=tuple(notes))

    @property
    def home(self) -> np.ndarray:
        """Coordinates and the declared velocities v, which are functions of w everywhere."""
        if self.framed is not None:
            return self.framed
        count = len(self.ground.home.definition.coordinates)
        q, w = self.wide[:count], self.wide[count:]
        posed = _Conditions.at(self.ground, q)
        return np.concatenate([q, posed.frame[:, :-1] @ w + posed.frame[:, -1]])

    def exact(self, bits: int) -> tuple[np.ndarray, Mapping[str, Any]]:
        """State and parameters, these by name, as mpmath's numbers."""
        with mpmath.workprec(bits):
            constants, given, q = _exact_place(self.namespace, self.ground, self.start_data, bits)
            w = [mpmath.mpf(float(x)) for x in self.wide[len(q) :]]
            posed = _Conditions.at(self.ground, q, constants)
            return np.array([*q, *posed.refine(w, self.targets, given)], dtype=object), constants


def _exact_place(
    namespace: Namespace, ground: ConstraintGeometry, given: StartData, bits: int
) -> tuple[dict[str, Any], dict[str, Any], np.ndarray]:
    """The parameters and all that is given by name, and the coordinates, as mpmath's numbers."""
    constants = {name: mpmath.mpf(x) for name, x in ground.constants.items()}
    constants |= _exact_constants(namespace, given, bits)
    values = _exact_values(
        namespace, {**given.scene_initial, **given.initial}, constants, bits
    )  # fmt: skip
    names = [plain_name(x) for x in ground.home.system.coordinates]
    q = np.array([values.get(name, mpmath.mpf(0)) for name in names], dtype=object)
    return constants, values, q


SHARP = 300
"""Bits in which velocities are told near a place where they are no frame."""
ULPS = 1e-15
"""Nearer to such a place than this the doubles of the coordinates are rounding alone."""
FAST = 1e3
"""A start beside such a place that moves so much faster than what is given, or than one a unit of
time, is a slip: velocities of a moderate motion, rounded elsewhere, ask for no such speed."""


def _sharp_velocities(
    namespace: Namespace,
    ground: ConstraintGeometry,
    given: StartData,
    q: np.ndarray,
    later: Mapping[str, float],
    earlier: Mapping[str, float],
) -> np.ndarray:
    """The w that meet the constraints and what is given, ``later`` before ``earlier``, in so many
    digits that velocities beside a place where they are no frame determine it."""
    with mpmath.workprec(SHARP):
        constants, values, place = _exact_place(namespace, ground, given, SHARP)
        if np.abs(place.astype(float) - q).max(initial=0.0) > ULPS * (1 + np.abs(q).max()):
            place = np.array([mpmath.mpf(x) for x in q], dtype=object)  # moved on request
        posed = _Conditions.at(ground, place, constants)
        w = posed.sharp([*later, *earlier], values)
    most = int(np.argmax(np.abs(w)))
    if abs(w[most]) > FAST * max(1.0, *(abs(x) for x in [*later.values(), *earlier.values()])):
        raise DefinitionError(
            f"system '{posed.system.name}': the velocities {', '.join(posed.own)} are almost no "
            f"frame at the initial point, where those given ask for '{posed.dots[most]}' = "
            f"{w[most]:.3g}; give '{posed.dots[most]}', or start farther from that point"
        )
    return w


def _least_squares(
    left: np.ndarray, right: np.ndarray, further: np.ndarray, wanted: np.ndarray
) -> np.ndarray:
    """The w with left w = right, and, as far as this leaves it open, further w = wanted."""
    solution = np.linalg.pinv(left, LEAST_SINGULAR_VALUE) @ right
    _, sizes, basis = np.linalg.svd(left)
    free_ways = basis[int((sizes > LEAST_SINGULAR_VALUE * sizes.max(initial=0.0)).sum()) :].T
    rest = np.linalg.pinv(further @ free_ways, LEAST_SINGULAR_VALUE) @ (wanted - further @ solution)
    return np.asarray(solution + free_ways @ rest)


@dataclass(frozen=True)
class _Conditions:
    """The conditions at one point: rows of constraints and relations, of the frame, and on a group
    of the coordinates' ``rates``, each with its offset; names of velocities w and v.  ``blind``
    (N, k) are directions that are no motion."""

    system: Any
    conditions: np.ndarray
    frame: np.ndarray
    rates: Mapping[str, np.ndarray]
    dots: list[str]
    own: list[str]
    blind: np.ndarray

    @classmethod
    def at(cls, ground: ConstraintGeometry, q: np.ndarray, constants: Any = None) -> _Conditions:
        """The conditions at coordinates q, of doubles or mpmath's numbers."""
        d, system = ground.home.definition, ground.home.system
        rest = (
            np.array([q[0] * 0] * len(d.dots), dtype=q.dtype) if len(q) else np.zeros(len(d.dots))
        )
        wide = np.concatenate([q, rest])
        conditions, frame = ground.rows(ground.time, wide, constants)
        if not all(mpmath.isfinite(x) for x in (*conditions.ravel(), *frame.ravel())):
            raise DefinitionError(
                f"system '{system.name}': the constraints are not defined at the initial point, "
                "where no motion exists in these coordinates; start elsewhere"
            )
        dots = system.directions if d.group is not None else map(velocity, system.coordinates)
        names = [plain_name(x) for x in dots]
        velocities = [plain_name(v) for v in system.velocities]
        rows = ground.coordinate_rows(ground.time, wide, constants)
        slopes = [plain_name(velocity(x)) for x in system.coordinates]
        rates = dict(zip(slopes, rows, strict=False))
        return cls(
            system, conditions, frame, rates, names, velocities, blind_directions(ground, wide)
        )

    def require_motion(self, ground: ConstraintGeometry, q: np.ndarray) -> None:
        """Refuse a start where coordinates may change though nothing moves, and no chart sees it:
        what happens there they do not tell."""
        idle = idle_directions(ground, np.concatenate([q, np.zeros(len(self.dots))]))
        if idle.shape[1] > self.blind.shape[1]:
            seen = np.abs(idle).max(axis=1) > POLE * np.abs(idle).max()
            names = (name for name, moves in zip(self.dots, seen, strict=True) if moves)
            raise IntegrationError(
                f"system '{self.system.name}': the coordinates are singular at the initial point, "
                f"where {', '.join(names)} may differ though nothing moves, and do not tell what "
                "happens next; start elsewhere",
                ground.time,
                q,
            )

    def row(self, name: str) -> np.ndarray:
        """The row of a velocity by name, with its offset."""
        if name in self.own:
            return np.asarray(self.frame[self.own.index(name)])
        if name in self.rates:
            return self.rates[name]
        unit = np.zeros(len(self.dots) + 1)
        unit[self.dots.index(name)] = 1.0
        return unit

    def is_open(self, *given: Mapping[str, float]) -> bool:
        """Whether the constraints and what is given leave a motion open, as doubles tell."""
        rows = np.vstack([self.conditions, *(self.row(k)[None, :] for part in given for k in part)])
        ways = open_beyond(rows[:, :-1].astype(float), self.blind)
        return bool(np.abs(ways).max(initial=0.0) > POLE)

    def solve(self, given: Mapping[str, float], otherwise: Mapping[str, float]) -> np.ndarray:
        """The w that meet the constraints and what is given, and, as far as these leave it open,
        the rest."""
        left, right = self._pose(self.conditions, given)
        return _least_squares(left, right, *self._pose(self.conditions[:0], otherwise))

    def sharp(self, names: Sequence[str], given: Mapping[str, Any]) -> np.ndarray:
        """The w for conditions of mpmath's numbers, the first ``names`` before others, where
        rows may be dependent but for a hair; velocities that are not given are zero."""
        rows = np.vstack([self.conditions, *(self.row(k)[None, :] for k in names)])
        values = [0] * len(self.conditions) + [given.get(k, 0) for k in names]
        right = np.array(values, dtype=object) - rows[:, -1]
        basis, solution = self.blind.T.astype(object), np.zeros(len(self.dots), dtype=object)
        for row, wanted in zip(rows[:, :-1], right, strict=True):
            new = row - basis.T.dot(basis.dot(row))
            new = new - basis.T.dot(basis.dot(new))  # once more: the first leaves rounding
            size = mpmath.sqrt(new.dot(new))
            if size > ULPS * mpmath.sqrt(row.dot(row)):
                solution = solution + new * ((wanted - row.dot(solution)) / size**2)
                basis = np.vstack([basis, new / size])
        if len(basis) < len(self.dots):
            self._refuse(basis)
        return solution.astype(float)

    def _refuse(self, basis: np.ndarray) -> NoReturn:
        """Say what such directions, which alone are known, leave open."""
        known = basis.astype(float)
        lost = 1.0 - (known**2).sum(axis=0)
        others = "the group" if self.system.on_group else "coordinates"
        raise DefinitionError(
            f"system '{self.system.name}': the velocities {', '.join(self.own)} are no frame "
            "at the initial point, and do not determine the motion; give velocities of "
            f"{others}, such as '{self.dots[int(np.argmax(lost))]}'"
        )

    def nearest(self, given: Mapping[str, float]) -> np.ndarray:
        """The w on the constraints that come nearest to what is given, which contradicts them."""
        left, right = self._pose(self.conditions, {})
        further, wanted = self._pose(self.conditions[:0], given)
        return _least_squares(left, right, further, wanted)

    def _pose(self, first: np.ndarray, given: Mapping[str, float]) -> tuple[np.ndarray, np.ndarray]:
        """Rows of unit length and right sides: left w = right."""
        rows = np.vstack([first, *(self.row(k)[None, :] for k in given)]).astype(float)
        right = np.concatenate([np.zeros(len(first)), [*given.values()]]) - rows[:, -1]
        sizes = np.linalg.norm(rows[:, :-1], axis=1)
        sizes[sizes == 0] = 1.0
        return rows[:, :-1] / sizes[:, None], right / sizes

    def excess(self, name: str, value: float, w: np.ndarray) -> float:
        """How far the velocity of w is beyond a given one."""
        row = self.row(name)
        return float(row[:-1].astype(float) @ w + float(row[-1]) - value)

    def residual(self, name: str, value: float, w: np.ndarray) -> float:
        """The size of that."""
        return abs(self.excess(name, value, w))

    def holds(self, name: str, value: float, w: np.ndarray) -> bool:
        """Whether w has the velocity given."""
        return self.residual(name, value, w) <= CONSISTENT * (1.0 + np.abs(w).max(initial=0.0))

    def refine(self, w: list[Any], names: tuple[str, ...], given: Mapping[str, Any]) -> list[Any]:
        """w moved until the conditions hold to the last digit."""
        rows = np.vstack([self.conditions, *(self.row(k)[None, :] for k in names)])
        wanted = [mpmath.mpf(0)] * len(self.conditions)
        wanted += [given.get(k, mpmath.mpf(0)) for k in names]
        inverse = np.linalg.pinv(rows[:, :-1].astype(float))
        solution = np.array(w, dtype=object)
        for _ in range(ROUNDS):
            gap = np.array(wanted, dtype=object) - rows[:, -1] - rows[:, :-1].dot(solution)
            if max(map(abs, gap), default=0) <= mpmath.eps * 8 * (1 + max(map(abs, solution))):
                break
            solution = solution + inverse.dot(gap)
        return list(solution)


HOLDS = 1e-8
"""A condition that the start in doubles meets this well is one that it was made to meet."""


def exact_number(value: Any, known: Mapping[Any, Any], bits: int) -> Any:
    """A value as mpmath's number, with ``bits``; ``known`` gives symbols that it may contain."""
    if isinstance(value, mpmath.mpf):
        return value
    if isinstance(value, float | int):
        return mpmath.mpf(value)
    digits = int(bits * 0.302) + 5
    expr = as_expression(value).xreplace({s: sp.Float(x, digits) for s, x in known.items()})
    return mpmath.mp.make_mpf(sp.Float(expr.evalf(digits), digits)._mpf_)


def _exact_constants(namespace: Namespace, given: StartData, bits: int) -> dict[str, Any]:
    """The parameters of a system by name, as far as they are given or have values of their own."""
    parameters = namespace.equations.system.parameters
    values = {p.name: given.parameters.get(p.name, p.value) for p in parameters}
    return {name: exact_number(x, {}, bits) for name, x in values.items() if x is not None}


def _exact_values(
    namespace: Namespace, values: Mapping[str, Any], constants: Mapping[str, Any], bits: int
) -> dict[str, Any]:
    """Initial values by name, which may contain parameters."""
    known = {namespace.symbols[name]: x for name, x in constants.items()}
    return {name: exact_number(value, known, bits) for name, value in values.items()}


@dataclass(frozen=True)
class Exactly:
    """What was given, and the start in doubles that came of it."""

    namespace: Namespace
    program: Program
    time: float
    start_data: StartData
    start: np.ndarray
    projected: bool

    def constants(self, bits: int) -> dict[str, Any]:
        """The parameters by name."""
        return _exact_constants(self.namespace, self.start_data, bits)

    def problem(self, bits: int) -> tuple[np.ndarray, list[Any]]:
        """The start (n,), and the values of the program's parameters."""
        with mpmath.workprec(bits):
            constants = self.constants(bits)
            values = [constants.get(str(p), mpmath.nan) for p in self.program.parameters]
            start = np.array([mpmath.mpf(x) for x in self.start], dtype=object)
            if self.projected:
                return start, values
            old, new = (
                _exact_values(self.namespace, part, constants, bits)
                for part in (self.start_data.scene_initial, self.start_data.initial)
            )
            names = [plain_name(q) for q in self.namespace.equations.system.coordinates]
            for i, name in enumerate(names):
                start[i] = {**old, **new}.get(name, mpmath.mpf(0))
            conditions = {k: x for k, x in {**old, **new}.items() if k not in names}
            return self._meet_conditions(start, len(names), conditions, values, {*new}), values

    def _meet_conditions(
        self,
        start: np.ndarray,
        n: int,
        conditions: Mapping[str, Any],
        values: Any,
        strict: set[str],
    ) -> np.ndarray:
        """The start with velocities that meet all conditions which it meets in doubles."""
        system = self.namespace.equations.system
        velocities = [plain_name(x) for x in system.velocities]
        names = self.namespace.rate_names
        _, rates = compiled_digits(self.program)
        asked = not {*conditions} <= {*velocities}  # at poles of angles their rates are infinite

        def residuals(state: np.ndarray) -> list[Any]:
            try:
                slopes = rates(self.time, list(state), values) if asked else ()
            except ZeroDivisionError:
                raise EngineLimit(
                    f"system '{system.name}': velocities of coordinates do not tell the start to "
                    f"many digits at a pole of these; give {', '.join(velocities)}"
                ) from None
            speeds = dict(zip(names, slopes, strict=asked))
            speeds |= zip(velocities, state[n:], strict=True)
            return [speeds[name] for name in conditions]

        wanted = list(conditions.values())
        first = residuals(start)
        scale = 1 + max(map(abs, wanted), default=0)
        held = [
            name in strict or abs(a - b) < HOLDS * scale
            for name, a, b in zip(conditions, first, wanted, strict=True)
        ]
        if not any(held):
            return start
        inverse = np.linalg.pinv(_slopes(residuals, start, n)[held])
        for _ in range(ROUNDS):
            gap = np.array([b - a for a, b in zip(residuals(start), wanted, strict=True)])[held]
            if max(map(abs, gap)) <= scale * mpmath.eps * 8:
                break
            start = start.copy()
            start[n:] += inverse.dot(gap)
        return start


def _slopes(reached: Callable[[np.ndarray], list[Any]], start: np.ndarray, n: int) -> np.ndarray:
    """Slopes of conditions by the velocities, entries from n on; they are affine in these, so unit
    steps tell them."""
    first, columns = reached(start), []
    for j in range(n, len(start)):
        step = start.copy()
        step[j] += 1
        columns.append([a - b for a, b in zip(reached(step), first, strict=True)])
    return np.array(columns, dtype=float).T


PLACES, AWAY = 3, 0.3
"""At the start and so many places about it, so far apart, the mass matrix is looked at."""
SINGULAR = 1e-12
"""The least eigenvalue of a singular mass matrix, in units of its largest."""


def require_inertia(
    equations: VoronecEquations, constants: Mapping[str, float], state: np.ndarray, time: float
) -> None:
    """Refuse parameters that are zero where they make the mass matrix singular everywhere.

    ``state`` (n,) is the start on the coordinates.  Each of the equations mass * vdot = force may
    then be cancelled before the parameter is put in, or after: the answers differ, so there is
    none.  A matrix that is singular at the start alone is another matter: charts may help.  What
    was found regular stays so, and is kept with the equations.
    """
    zero = [p.name for p in equations.system.parameters if constants.get(p.name) == 0]
    regular = equations.memo.once("regular without", set)
    if not zero or not equations.system.velocities or frozenset(zero) in regular:
        return
    if not _singular(equations, constants, state, time):
        regular.add(frozenset(zero))
        return
    guilty = [
        name for name in zero if not _singular(equations, {**constants, name: 1.0}, state, time)
    ]
    if not guilty and _singular(equations, {**constants, **dict.fromkeys(zero, 1.0)}, state, time):
        return  # that is not their fault
    named = ", ".join(f"{name} = 0" for name in guilty or zero)
    raise DefinitionError(
        f"system '{equations.system.name}': for {named} the mass matrix is singular everywhere, so "
        "the accelerations are 0/0; give other values, or leave out what has no inertia"
    )


def _singular(
    equations: VoronecEquations, constants: Mapping[str, float], state: np.ndarray, time: float
) -> bool:
    """Whether the mass matrix is singular at the start and about it."""
    form = equations.raw.form
    values = [constants.get(str(p), np.nan) for p in form.parameters]
    probe = StateProbe(equations.system.name, form, quantities(form, {}), values, time)
    random = np.random.default_rng(0)  # any numbers will do, the same every time
    about = state + AWAY * random.standard_normal((PLACES, len(state)))
    masses = probe.masses(np.full(PLACES + 1, time), np.vstack([state, about]))
    if not np.isfinite(masses).all():
        return False
    sizes = np.abs(np.linalg.eigvalsh(masses))
    return bool((sizes.min(axis=1) <= SINGULAR * sizes.max(axis=1)).all())
