"""Many motions of one system: one program, and a state and parameter values for each of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
import sympy as sp

from voronec.declaration.scene import Parameter, Scene
from voronec.equations.attitudes import euler_angles
from voronec.equations.motions import Motions
from voronec.equations.program import Program, compile_program
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError, IntegrationError, VoronecError
from voronec.motion.constraint_geometry import ConstraintGeometry
from voronec.motion.formulation import SmallestModels
from voronec.motion.initial_conditions import parameter_values, start_of, starts_in_arrays
from voronec.motion.motion_start import require_inertia
from voronec.motion.observables import size_of_terms
from voronec.motion.request import Namespace, Starts, name_values
from voronec.motion.singular_coordinates import CoordinatePole
from voronec.motion.singular_denominators import NEAR, SingularDenominator
from voronec.motion.state_probe import (
    at_each,
    changes,
    quantities,
    quiet,
    rates_along,
    rates_program,
)
from voronec.motion.term_sizes import CANCELLATION, SMALL, term_slopes
from voronec.motion.tolerances import LOOSE, UNIT

FASTEST = 1e-3
"""A divisor below this part of its usual size makes velocities of coordinates so many times larger
than those that are given."""


@dataclass(frozen=True)
class WorkingEquations:
    """The equations in which motions run, and what is looked at, all in the engine's symbols.

    ``formulation`` says in which variables they stand; ``start`` is what each of them is in
    coordinates and velocities, and ``frozen`` what constants of the motion among the parameters
    are; ``quantities`` and ``integrals`` are in the form's variables.
    """

    formulation: str
    form: Any
    start: tuple[Any, ...]
    frozen: Mapping[str, Any]
    quantities: Mapping[str, Any]
    integrals: Mapping[str, Any]


def ground(
    namespace: Namespace, wanted: Mapping[str, sp.Expr], by_integrals: bool = True
) -> WorkingEquations:
    """The smallest model that holds for all starts, where it has everything wanted as it is; else
    all coordinates and velocities.  Integrals stand in for equations only where that is asked."""
    equations = namespace.equations
    form = equations.form
    integrals = {name: namespace.claims[name] for name in equations.system.integrals}
    model = None
    if wanted and not namespace.holds_reactions(wanted.values()):
        models = SmallestModels.of(Motions.of(equations), wanted, integrals)
        model = models.general if by_integrals else models.without_integrals
    # an angle that is read off needs its branch followed along the motion
    if model is not None and model.start and wanted.keys() <= model.outputs.keys():
        return WorkingEquations(
            formulation=model.formulation,
            form=model.form,
            start=tuple(model.start.values()),
            frozen={str(symbol): e for symbol, e in model.frozen.items()},
            quantities=model.outputs,
            integrals=model.integrals,
        )
    return WorkingEquations(
        formulation="coordinates",
        form=form,
        start=(*form.coordinates, *form.velocities),
        frozen={},
        quantities={name: namespace.inward(e) for name, e in wanted.items()},
        integrals={name: namespace.inward(e) for name, e in integrals.items()},
    )


@dataclass(frozen=True, eq=False)
class Many:
    """Motions to run: ``states`` (s, n) and ``values`` (s, p) in the order of the program.

    ``full`` (s, all coordinates and velocities) are the same starts on the coordinates;
    ``parameters`` holds an array (s,) for each.  ``wrong`` has the error of each start from which
    no motion can go; its state is not used.
    """

    namespace: Namespace
    ground: WorkingEquations
    program: Program
    states: np.ndarray
    full: np.ndarray
    values: np.ndarray
    parameters: Mapping[str, np.ndarray]
    time: float
    wrong: dict[int, VoronecError]

    def __len__(self) -> int:
        return len(self.states)

    @cached_property
    def divisors(self) -> tuple[SingularDenominator, ...]:
        """What the equations divide by and what may vanish while the motion goes on, as it is found
        around the first sound start."""
        if not self.sound:
            return ()
        equations, ground, i = self.namespace.equations, self.ground, self.sound[0]
        named = zip(self.program.state, ground.start, strict=True)
        below = {f"start {x}": e for x, e in named}
        below |= {f"frozen {name}": e for name, e in ground.frozen.items()}
        constants = {name: float(x[i]) for name, x in self.parameters.items()}
        places = ConstraintGeometry(equations, constants, self.time)
        program = quantities(equations.raw.form, below)
        rough = self.program.is_rough
        return tuple(places.watch_divisors(ground.form, program, self.full[i], rough))

    def divisor_watch(
        self, values: np.ndarray, level: float = NEAR
    ) -> Callable[[np.ndarray, np.ndarray], bool] | None:
        """Whether a motion with parameters (p,) brings a divisor below a level, in units of its
        usual size, or across zero, as far as times (s,) and states (s, n) tell; None where no
        divisor vanishes."""
        if not self.divisors:
            return None
        sizes_at = self._divisor_sizes

        def passes(times: np.ndarray, states: np.ndarray) -> bool:
            sizes = sizes_at(times, states, np.broadcast_to(values, (len(times), len(values))))
            near = np.abs(sizes) < level
            return bool(near.any() or (np.diff(np.sign(sizes), axis=1) != 0).any())

        return passes

    @cached_property
    def _divisor_sizes(self) -> Callable[[Any, np.ndarray, np.ndarray], np.ndarray]:
        """What the divisors are (d, s), in units of their usual sizes, at times, states (s, n) and
        parameters (s, p)."""
        names = [str(i) for i in range(len(self.divisors))]
        functions = [d.function for d in self.divisors]
        program = quantities(self.ground.form, dict(zip(names, functions, strict=True)))
        evaluate = compile_program(program)[1]
        order = [self.program.parameters.index(p) for p in program.parameters]
        scales = np.array([d.scale for d in self.divisors])[:, None]

        def sizes(times: Any, states: np.ndarray, values: np.ndarray) -> np.ndarray:
            series = at_each(evaluate, program.names, times, states, values[:, order])
            return np.stack([series[name] for name in names]) / scales

        return sizes

    @property
    def near_divisors(self) -> np.ndarray:
        """Which motions (s,) start so near to where a divisor vanishes that velocities given there
        may ask for a thousand times their speed."""
        if not self.divisors:
            return np.zeros(len(self), dtype=bool)
        sizes = self._divisor_sizes(self.time, self.states, self.values)
        return np.asarray((np.abs(sizes) < FASTEST).any(axis=0))

    @cached_property
    def poles(self) -> tuple[CoordinatePole, ...]:
        """The poles of coordinates that the equations hold, where turns about them are wanted."""
        equations, state = self.namespace.equations, {*self.program.state}
        angles = CoordinatePole.of_attitudes(euler_angles(equations))
        held = [*angles, *CoordinatePole.of_charts(equations)]
        coordinates = {*equations.definition.coordinates}
        turning = any(coordinates & {*e.free_symbols} for e in self.ground.quantities.values())
        return tuple(p for p in held if p.angle in state) if turning else ()

    def across_poles(self, rows: np.ndarray) -> np.ndarray:
        """Which motions (m,) with states (m, k, n) pass a pole of coordinates between instants: in
        a plane that holds it, at which the equations are regular."""
        if not self.poles:
            return np.zeros(len(rows), dtype=bool)
        names = [f"pole {i}" for i in range(len(self.poles))]
        distances = dict(zip(names, (p.distance for p in self.poles), strict=True))
        program = quantities(self.ground.form, distances)
        none = np.zeros((*rows.shape[:2], len(program.parameters)))
        sizes = at_each(compile_program(program)[1], names, 0.0, rows, none)
        sides = [np.sign(size) for size in sizes.values()]
        return np.any([(s[:, 1:] * s[:, :-1] < 0).any(axis=1) for s in sides], axis=0)

    @property
    def may_go_on(self) -> bool:
        """Whether a motion whose equations fail may go on in a chart, or in all velocities."""
        equations = self.namespace.equations
        return bool(equations.system.charts or euler_angles(equations) or self.divisors)

    def one(self, i: int) -> Many:
        """Motion i as if there were no other."""
        constants = {name: x[i : i + 1] for name, x in self.parameters.items()}
        return replace(
            self, states=self.states[i : i + 1], full=self.full[i : i + 1],
            values=self.values[i : i + 1], parameters=constants, wrong={},
        )  # fmt: skip

    @property
    def extras(self) -> Callable[[Any, Any, Any], list[Any]]:
        """``extras(t, columns, values)`` computes what ``program.names`` says."""
        return compile_program(self.program)[1]

    def quantities_along(
        self, t: np.ndarray, states: np.ndarray, values: np.ndarray
    ) -> dict[str, np.ndarray]:
        """Outputs and integrals (m, k) at instants (k,) of motions with states (m, k, n) and
        parameters (m, p)."""
        each = np.broadcast_to(values[:, None, :], (*states.shape[:2], values.shape[-1]))
        return at_each(self.extras, self.program.names, t, states, each)

    @property
    def sound(self) -> list[int]:
        """Positions of the starts from which a motion goes."""
        every = range(len(self))
        return [i for i in every if i not in self.wrong] if self.wrong else [*every]

    @cached_property
    def paces(self) -> np.ndarray:
        """The length of velocities and rates at the starts (s,): motions that are alike in it take
        about as many steps."""
        names = [f"rate {i}" for i in range(self.states.shape[1])]
        rhs = compile_program(self.program)[0]
        slopes = at_each(rhs, names, self.time, self.states, self.values).values()
        speeds = self.full[:, len(self.namespace.equations.definition.coordinates) :]
        with np.errstate(all="ignore"):
            return np.linalg.norm(np.column_stack([*slopes, speeds]), axis=1)

    def start_values(self, i: int) -> dict[sp.Expr, float]:
        """The coordinates and velocities with which motion i starts."""
        system = self.namespace.equations.system
        variables = [*system.coordinates, *system.velocities]
        return dict(zip(variables, self.full[i].tolist(), strict=True))

    def error(self, i: int, what: str, mend: str, time: Any, state: Any) -> IntegrationError:
        """The error of motion i: what went wrong, what mends it, and where it was last good."""
        name = self.namespace.equations.system.name
        return IntegrationError(
            f"system '{name}', start {i}: {what}; {mend}, or use another chart", time, state
        )

    @property
    def moving_lanes(self) -> tuple[np.ndarray, np.ndarray]:
        """States and parameters of these."""
        return self.states[self.sound], self.values[self.sound]


def many(
    equations: VoronecEquations,
    scene: Scene | None,
    starts: Starts,
    parameters: Mapping[Any, Any],
    wanted: Mapping[str, sp.Expr],
    time: float,
    by_integrals: bool = True,
) -> Many:
    """The starts in numbers.  ``parameters`` may hold arrays, one value for each start."""
    namespace = Namespace.of(equations)
    basis = ground(namespace, wanted, by_integrals)
    looked = {**basis.quantities, **{f"integral {n}": e for n, e in basis.integrals.items()}}
    program = Program.of(basis.form, looked)
    if program.is_rough and namespace.holds_reactions(wanted.values()):
        raise DefinitionError(
            f"system '{equations.system.name}': reactions are not known while friction holds a "
            "motion on a switching surface; ask for them of single motions, by integrate"
        )
    below = _below(equations, basis)
    needed = {str(s) for p in (program, below) for b in (p.derivative, p.extras) for s in b.symbols}
    constants, wrong = _constants(namespace, scene, parameters, len(starts), needed)
    initial = name_values(namespace, scene.initial if scene else {}, "initial value")
    table = _table(constants, below.parameters, len(starts))
    full = _states(namespace, initial, starts, constants, table, time, wrong)
    states, frozen = _place_on_ground(below, compile_program(below)[1], full, constants, time)
    values = _table({**constants, **frozen}, program.parameters, len(starts))
    if not program.derivative.is_rough(program.parameters):
        # a case that does not hold may have no value, and yet the motion has
        _mark_undefined_states(namespace, compile_program(program)[0], states, values, time, wrong)
    return Many(namespace, basis, program, states, full, values, constants, time, wrong)


def _states(
    namespace: Namespace, initial: Mapping[str, Any], starts: Starts,
    constants: Mapping[str, np.ndarray], table: np.ndarray, time: float,
    wrong: dict[int, VoronecError],
) -> np.ndarray:  # fmt: skip
    """The states (s, n) of the starts on the coordinates, all at once, and one by one where that
    says too little; those from which no motion goes join the ``wrong`` ones."""
    equations = namespace.equations
    program = rates_program(equations.form, equations.definition.fibre_velocities)
    follow = compile_program(program)[1]
    rates_of_many = partial(rates_in_arrays, follow, table, time)
    full = starts_in_arrays(namespace, initial, starts, constants, rates_of_many)
    full[[*wrong]] = np.nan
    zero = np.zeros(len(starts), dtype=bool)
    for parameter in equations.system.parameters:
        zero |= constants.get(parameter.name, np.ones(1)) == 0
    for i in map(int, np.flatnonzero(zero | np.isnan(full).any(axis=1))):
        if i in wrong:
            continue
        given = starts[i]
        parameters = {name: float(x[i]) for name, x in constants.items()}
        try:
            if np.isnan(full[i]).any():
                rates = partial(rates_along, quiet(follow, table[i].tolist()), time)
                data = name_values(namespace, given, "initial value")
                full[i] = start_of(namespace, initial, data, parameters, rates, time).state
            require_inertia(equations, parameters, full[i], time)
        except VoronecError as error:
            wrong[i] = error
    return full


def rates_in_arrays(
    function: Any, values: np.ndarray, time: float, q: np.ndarray, v: np.ndarray
) -> np.ndarray:
    """The quantities (s, l, k) of a function at several q (s, n), with parameters (s, p), and, at
    each, several v (m, k)."""
    shape = (len(q), v.shape[1])
    columns = [*np.repeat(q.T[:, :, None], shape[1], axis=2)]
    columns += [np.broadcast_to(row, shape) for row in v]
    with np.errstate(all="ignore"):
        rates = function(np.float64(time), columns, [x[:, None] for x in values.T])
    rows = [np.broadcast_to(r, shape) for r in rates]
    return np.stack(rows, axis=1).astype(float)


def _below(equations: VoronecEquations, basis: WorkingEquations) -> Program:
    """The program on the coordinates: where a start is on the ground."""
    start = {f"start {i}": e for i, e in enumerate(basis.start)}
    start |= {f"frozen {name}": e for name, e in basis.frozen.items()}
    return Program.of(equations.form, start)


def _constants(
    namespace: Namespace,
    scene: Scene | None,
    parameters: Mapping[Any, Any],
    count: int,
    needed: set[str],
) -> tuple[dict[str, np.ndarray], dict[int, VoronecError]]:
    """Values of the parameters, (s,) each; and the starts whose value is out of range."""
    given = name_values(namespace, scene.parameters if scene else {}, "parameter")
    given |= name_values(namespace, parameters, "parameter")
    arrays = {k: x for k, x in given.items() if isinstance(x, list | tuple | np.ndarray)}
    series = {k: np.asarray(x) for k, x in arrays.items() if np.ndim(x) > 0}
    first = given | {k: x[0].item() for k, x in series.items()}
    wrong: dict[int, VoronecError] = {}
    single = parameter_values(namespace, _inside(namespace, first, series), needed)
    single |= {k: float(x[0]) for k, x in series.items()}
    values = {name: np.full(count, x) for name, x in single.items()}
    declared = {p.name: p for p in namespace.equations.system.parameters}
    for name, x in series.items():
        values[name] = x.astype(float)
        for i, one in _beyond(declared[name], values[name]):
            try:
                declared[name].check(one)
            except VoronecError as error:
                wrong.setdefault(i, error)
    return values, wrong


def _beyond(parameter: Parameter, values: np.ndarray) -> Iterable[tuple[int, float]]:
    """The values that may be out of range, with their positions: none where the least and the
    largest are allowed, since ranges are intervals."""
    try:
        for end in (float(values.min()), float(values.max())):
            parameter.check(end)
    except VoronecError:
        return enumerate(values.tolist())
    return ()


def _inside(namespace: Namespace, first: dict[str, Any], series: Iterable[str]) -> dict[str, Any]:
    """Values of one start in which a parameter of many values has one that its range allows."""
    system = namespace.equations.system
    allowed = {p.name: p.value for p in system.parameters if p.value is not None}
    return {k: allowed.get(k, x) if k in set(series) else x for k, x in first.items()}


def _place_on_ground(
    below: Program, extras: Any, full: np.ndarray, constants: Mapping[str, np.ndarray], time: Any
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """The states and the frozen quantities on the ground."""
    values = _table(constants, below.parameters, len(full))
    series = at_each(extras, below.names, time, full, values)
    columns = [x for n, x in series.items() if n.startswith("start ")]
    frozen = {n.removeprefix("frozen "): x for n, x in series.items() if n.startswith("frozen ")}
    return np.stack(columns, axis=-1), frozen


def _mark_undefined_states(
    namespace: Namespace,
    rhs: Any,
    states: np.ndarray,
    values: np.ndarray,
    time: float,
    wrong: dict[int, VoronecError],
) -> None:
    """Mark the starts at which the equations are not defined."""
    names = [f"rate {i}" for i in range(states.shape[1])]
    slopes = np.stack([*at_each(rhs, names, time, states, values).values()], axis=-1)
    finite = np.isfinite(states).all(axis=1) & np.isfinite(slopes).all(axis=1)
    for i in np.nonzero(~finite)[0].tolist():
        refusal = IntegrationError(
            f"system '{namespace.equations.system.name}': the equations are not defined at start "
            f"{i}; start elsewhere or use another chart",
            time,
            states[i],
        )
        wrong.setdefault(i, refusal)


def _table(constants: Mapping[str, np.ndarray], symbols: Sequence[Any], count: int) -> np.ndarray:
    """Parameter values (s, p), in the order of the symbols."""
    missing = np.full(count, np.nan)
    columns = [constants.get(str(p), missing) for p in symbols]
    return np.stack(columns, axis=-1) if columns else np.empty((count, 0))


@dataclass(frozen=True)
class Drifts:
    """How much integrals change along motions, as ``Trajectory`` tells it: relative to where they
    start, or to their terms, beside which that is next to nothing, or to the slopes of these."""

    motions: Many
    tol: float

    @cached_property
    def program(self) -> Program:
        """A program for how large the terms of integrals are, by name."""
        ground = self.motions.ground
        sizes = {name: size_of_terms(e) for name, e in ground.integrals.items()}
        return Program.of(ground.form, sizes)

    def along(
        self, t: np.ndarray, states: np.ndarray, values: np.ndarray, found: Mapping[str, np.ndarray]
    ) -> dict[str, np.ndarray]:
        """How much each integral drifts (m,) along motions with states (m, k, n) at t (k,) and
        parameters (m, p), where extra quantities (m, k) are ``found``."""
        drift = dict[str, np.ndarray]()
        for name in self.motions.ground.integrals:
            series = found[f"integral {name}"]
            # a motion that failed has numbers up to there, if any
            change = np.fmax.reduce(changes(series, series[:, :1]), axis=1)
            drift[name] = self._relative(name, change, series[:, 0], t, states, values)
        return drift

    def _relative(
        self, name: str, change: np.ndarray, start: np.ndarray, t: np.ndarray,
        states: np.ndarray, values: np.ndarray,
    ) -> np.ndarray:  # fmt: skip
        """The changes (m,) of an integral from where it starts (m,), along motions with states
        (m, k, n) at t (k,) and parameters (m, p)."""
        scale = np.abs(start)
        with np.errstate(all="ignore"):
            for find in (self._terms, self._slopes):
                which = change > SMALL * scale
                if which.any():
                    scale[which] = find(name, scale[which], t, states[which], values[which])
            return np.where(change == 0, 0.0, change / scale)

    def _values(self, values: np.ndarray, count: int) -> np.ndarray:
        order = [self.motions.program.parameters.index(p) for p in self.program.parameters]
        each = values[:, None, order]
        return np.broadcast_to(each, (len(each), count, len(order)))

    def _terms(
        self, name: str, scale: np.ndarray, t: np.ndarray, states: np.ndarray, values: np.ndarray
    ) -> np.ndarray:
        each = self._values(values, len(t))
        series = at_each(compile_program(self.program)[1], self.program.names, t, states, each)
        size = np.fmax.reduce(series[name], axis=1)
        return np.where(scale > CANCELLATION * size, scale, size)

    def _slopes(
        self, name: str, scale: np.ndarray, t: np.ndarray, states: np.ndarray, values: np.ndarray
    ) -> np.ndarray:
        each = self._values(values, len(t))
        slopes = term_slopes(self.program, [name], t, states, each)[name]
        return np.where(scale <= LOOSE * max(self.tol, UNIT) * slopes, slopes, scale)
