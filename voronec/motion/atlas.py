"""The charts of a system in numbers: maps, distances from singularities, integrators."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
import symengine as se

from voronec.algebra.angles import Angles, holds_angles
from voronec.algebra.symbols import velocity
from voronec.declaration.scene import Scene
from voronec.declaration.system import system_in
from voronec.equations.program import Program, compile_program
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.motion.methods import choose
from voronec.motion.request import Guard
from voronec.motion.solve import Progress
from voronec.motion.state_probe import quantities
from voronec.motion.steppers import Integrator, Problem, Run, natural_units, restart

if TYPE_CHECKING:
    from voronec.equations.derivation import FirstOrderForm


@dataclass(frozen=True)
class KeptChart:
    """One chart on the variables that are kept.

    ``there`` and ``back`` map every variable, of the chart and of the system; ``double_cover``
    gives other values for the same state of the system, where there are some; ``singular`` is a
    function in the chart.  ``factors`` vanish where the system's own coordinates are singular.
    """

    name: str
    equations: VoronecEquations
    kept: FirstOrderForm
    there: Mapping[Any, Any]
    back: Mapping[Any, Any]
    double_cover: tuple[Mapping[Any, Any], ...]
    singular: Any
    factors: tuple[Any, ...]

    @cached_property
    def form(self) -> FirstOrderForm:
        """The equations in the chart, of what is kept."""
        equations = _equations_in(self.equations, self.name)
        # pivots of straight-line forms may vanish at a pole; normal forms hold what is needed
        exact = self.equations.system.charts[self.name].near and equations.in_normal_form
        form = equations.exact.form if exact else equations.form
        rows = {q: i for i, q in enumerate(form.coordinates)}
        order = [rows[q] for q in self.kept.coordinates]
        dropped = [i for i in range(len(rows)) if i not in order]
        # what a function of the motion says of velocities holds for those that are dropped, too
        others = [(form.velocity_symbols[i], form.rates[i]) for i in dropped]
        return replace(
            form,
            coordinates=self.kept.coordinates,
            rates=tuple(form.rates[i] for i in order),
            velocity_symbols=tuple(form.velocity_symbols[i] for i in order),
            dependent=(*form.dependent, *others),
        )

    @cached_property
    def angles(self) -> set[Any]:
        """Variables that are angles, known up to whole turns."""
        return {x for x, e in self.back.items() if holds_angles([Angles().resolve(e)])}

    @cached_property
    def sides(self) -> tuple[Any, ...]:
        """Functions in the chart that change sign wherever an angle of the system comes from one
        quadrant into another: y and x of each atan2(y, x) in ``back``."""
        parts: dict[Any, None] = {}
        for e in self.back.values():
            for angle in sorted(Angles().resolve(e).atoms(se.atan2), key=str):
                # a root is never negative: its angle stays where it is
                parts |= {part: None for part in angle.args if not _is_root(part)}
        return tuple(parts)

    def pull_back(self, function: Any) -> Any:
        """A function of the system's state as one of the state in the chart."""
        bridge, system = self.equations.bridge, self.equations.system
        dots = {bridge.inward(q): bridge.inward(velocity(q)) for q in system.coordinates}
        rates = {
            rate: se.Add(*[self.back[q].diff(x) * dot for x, dot in dots.items()])
            for q, rate in dots.items()
            if q in self.back
        }
        return Angles().resolve(se.sympify(function).xreplace({**rates, **self.back}))


def kept_charts(equations: VoronecEquations, form: FirstOrderForm) -> tuple[KeptChart, ...]:
    """The charts that map the variables of a form among themselves, each map once.

    There is none where the form has other velocities than the system's, or other variables.
    """
    system, bridge = equations.system, equations.bridge
    names = {bridge.inward(x): x for x in (*system.coordinates, *system.velocities)}
    state = (*form.coordinates, *form.velocities)
    if not {*state} <= {*names} or len(form.velocities) != len(system.velocities):
        return ()
    dots = {bridge.inward(velocity(q)) for q in system.coordinates}
    # a coordinate that a model holds fast is a parameter of its form, but not of the chart's
    closed = {*state, *dots, *(bridge.inward(p.symbol) for p in system.parameters)}
    charts: dict[Any, KeptChart] = {}
    for name, chart in system.charts.items():
        maps = [chart.values(system), chart.values(system, "back"), *chart.sheet_values(system)]
        there, back, *sheets = ({x: bridge.inward(e[names[x]]) for x in state} for e in maps)
        images = [*there.values(), *back.values(), *(e for sheet in sheets for e in sheet.values())]
        factors, others = (
            tuple(f for f in _factors(bridge.inward(e)) if f.free_symbols <= closed)
            for e in (chart.singular, chart.singular_there)
        )
        moves = any(x != e for x, e in there.items())
        if factors and moves and all(e.free_symbols <= closed for e in images):
            kept = KeptChart(
                name, equations, form, there, back, (*sheets,), se.Mul(*others), factors
            )
            charts.setdefault(tuple(there.values()), kept)
    return tuple(charts.values())


def _equations_in(equations: VoronecEquations, name: str) -> VoronecEquations:
    """The equations in a chart, derived once."""

    def derive_chart() -> VoronecEquations:
        near = equations.system.charts[name].near
        scenes = {"default": Scene(initial=near)} if near else {}
        return derive(replace(system_in(equations.system, name), scenes=scenes))

    return equations.memo.once(("chart", name), derive_chart)


def _own_factors(charts: tuple[KeptChart, ...]) -> tuple[Any, ...]:
    """What vanishes where the own chart is singular: all factors that charts name, each once."""
    return tuple(dict.fromkeys(f for chart in charts for f in chart.factors))


def _own_singular(charts: tuple[KeptChart, ...]) -> Any:
    return se.Mul(*_own_factors(charts))


def _is_root(expr: Any) -> bool:
    return isinstance(expr, se.Pow) and expr.args[1].is_Rational and expr.args[1].q == 2


def _factors(product: Any) -> tuple[Any, ...]:
    return tuple(product.args) if isinstance(product, se.Mul) else (product,)


HOME = ""
"""The name of the system's own chart."""
NEAR, CLEAR = se.Rational(1, 50), se.Rational(1, 25)
"""Below the one a chart is left; above the other the system's own is taken again.  A change costs
as much as about a hundred steps of Taylor's method, and these are what a passage so near takes."""
GOOD = 0.25
"""So far from a singularity a chart that is ready is good enough."""
DIFFERENCE = 1e-5
"""Of coordinates, in slopes of maps between charts."""
BLIND = 1e-4
"""Slopes of a map below this part of the largest are zero."""
APART = 1e-9
"""A state nearer to a singularity is one on it: its angles there are known too badly."""
LEAVE, RETURN = "the chart becomes singular", "the own chart is regular again"
SIDE = "quadrant of an angle "
"""Begins the names of events at which an angle comes from one quadrant into another."""


Home = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Times (k,) and states (k, n) to states of the own chart."""


@dataclass(frozen=True)
class ChartProblem:
    """One chart, ready to be integrated in.

    ``stepper`` begins at what ``problem.start`` holds when it is called; ``home`` takes times (k,)
    and states (k, n) to states of the own chart, and each of ``double_cover`` takes these to
    others that
    are the same.
    """

    name: str
    problem: Problem
    solver: Integrator
    chosen: Mapping[str, Any]
    home: Home
    double_cover: tuple[Home, ...] = ()

    @property
    def ways_home(self) -> list[Home]:
        """``home``, and then any of the sheets, one after another."""
        ways = [self.home]
        for sheet in self.double_cover:
            ways += [_after(way, sheet) for way in ways]
        return ways

    def run(self, state: np.ndarray, times: np.ndarray) -> Run:
        """The motion from a state on."""
        return restart(self.solver, self.problem)(state, times)


@dataclass
class Atlas:
    """The charts of a system, each derived and compiled when a run first comes to it.

    ``problem`` is the one in the system's own chart, of which ``form`` are the equations and
    ``functions`` those of its events; it is to be integrated on ``grid`` by ``method``.
    ``seconds`` are what each chart took to make ready.
    """

    method: str
    problem: Problem
    grid: np.ndarray
    form: FirstOrderForm
    charts: tuple[KeptChart, ...]
    functions: Mapping[str, Any] = field(default_factory=dict)
    seconds: list[float] = field(default_factory=list)
    _places: dict[str, ChartProblem] = field(default_factory=dict)

    @cached_property
    def angles(self) -> np.ndarray:
        """Which variables are angles."""
        periodic = set().union(*(chart.angles for chart in self.charts))
        return np.array([x in periodic for x in self.problem.program.state])

    def best(self, time: Any, state: np.ndarray) -> tuple[str, np.ndarray]:
        """The chart in which a state of the own chart is far from a singularity, and the state
        there: the own one, else one that is ready, else the one in which it is farthest."""
        images = {HOME: state}
        sizes = {HOME: self._distance(HOME, time, state)}
        if sizes[HOME] > float(CLEAR):
            return HOME, state
        for chart in self.charts:
            images[chart.name] = self._maps[chart.name](time, state)
            sizes[chart.name] = self._distance(chart.name, time, images[chart.name])
        ready = [name for name in self._places if name != HOME and sizes[name] > GOOD]
        chosen = max(ready or sizes, key=sizes.__getitem__)
        return chosen, images[chosen]

    def distances(self, times: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """How far states of the own chart are from the nearest of its poles, (k,)."""
        return np.min(self.distances_apart(times, rows), axis=0)

    def distances_apart(self, times: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """How far states of the own chart are from each of m poles, (m, k)."""
        factors = {f"{HOME} {i}": e for i, e in enumerate(_own_factors(self.charts))}
        program = quantities(self.form, factors)
        with np.errstate(all="ignore"):
            sizes = compile_program(program)[1](times, list(rows.T), self._values(program))
        return np.abs([np.broadcast_to(size, times.shape) for size in sizes])

    def _distance(self, name: str, time: Any, state: np.ndarray) -> float:
        """How far a state in a chart is from its singularity; 0 where that is undefined."""
        size = abs(float(self._distances[name](time, state)[0]))
        return size if np.isfinite(size) else 0.0

    def blind(self, name: str, time: Any, state: np.ndarray) -> np.ndarray:
        """The directions (k, n) in which the own coordinates at their singularity may change while
        a chart sees the same state: null vectors of its map, by differences, k > 1 where several
        bodies are at poles; each is 1 where its largest entry is, and the others are 0 there.
        What is only near a pole is not free: its slopes are as large as that is far."""
        _, sizes, rows = np.linalg.svd(self._slopes(name, time, state))
        poles = self.distances_apart(np.array([time]), state[None, :])
        near = poles[poles >= APART].min(initial=np.inf)
        least = min(BLIND * sizes.max(), max(near / 4, 4 * APART))
        count = max(1, int((sizes < least).sum()))
        return np.where(self.angles, np.round(_reduce_rows(rows[-count:]), 6), 0)

    def idle(self, name: str, time: Any, state: np.ndarray) -> list[str]:
        """The variables, but angles, whose values at a singularity of the own coordinates say
        nothing of the state that a chart sees: a rate of phi where r = 0."""
        sizes = np.abs(self._slopes(name, time, state)).max(axis=0)
        nothing = (sizes < BLIND * sizes.max()) & ~self.angles
        return [str(x) for x, n in zip(self.problem.program.state, nothing, strict=True) if n]

    def _slopes(self, name: str, time: Any, state: np.ndarray) -> np.ndarray:
        """The slopes (n, n) of the map to a chart, by differences."""
        columns = []
        for shift in np.eye(len(state)) * DIFFERENCE:
            ahead, behind = (self._maps[name](time, state + s * shift) for s in (1, -1))
            columns.append(self.without_turns(ahead - behind) / (2 * DIFFERENCE))
        return np.array(columns).T

    def without_turns(self, steps: np.ndarray) -> np.ndarray:
        """Steps (..., n) between states, those of angles without whole turns."""
        return np.where(self.angles, steps - whole_turns(steps), steps)

    def place(self, name: str, state: np.ndarray | None = None) -> ChartProblem:
        """A chart, ready to be integrated in; the ``state`` there is needed where a run first comes
        to another one."""
        if name not in self._places:
            began = perf_counter()
            self._places[name] = self._own() if state is None else self._other(name, state)
            self.seconds.append(perf_counter() - began)
        return self._places[name]

    @cached_property
    def _units(self) -> np.ndarray:
        """The units of states of the own chart: those where the run begins, in a chart that is
        regular there, whose variables bear the same names."""
        return natural_units(self._outset)

    @cached_property
    def _outset(self) -> Problem:
        """The problem where the run begins, in a chart that is regular there."""
        given = self.problem
        name, state = self.best(self.grid[0], given.start)
        if name == HOME:
            return given
        program = Program.of(next(c for c in self.charts if c.name == name).form)
        return replace(given, program=program, start=state, parameters=self._values(program))

    @cached_property
    def progress(self) -> Progress | None:
        """Where progress is reported, if it is."""
        report = self.problem.progress
        return None if report is None else Progress(report)

    def _own(self) -> ChartProblem:
        given = self.problem
        levels = {**self.functions, LEAVE: _beyond(_own_singular(self.charts), NEAR)}
        regular = self._distance(HOME, self.grid[0], given.start) > float(NEAR)
        problem = replace(
            given,
            start=given.start.copy(),
            # masses where the coordinates are singular are no measure of others
            suspect=given.suspect if regular else None,
            events=(*given.events, self._end(LEAVE, -1)),
            levels=quantities(self.form, levels),
            progress=self.progress,
            coarse=frozenset({LEAVE}),
            units=self._units,
        )
        made = choose(self.method, problem, self.grid, None if regular else self._outset)
        return ChartProblem(HOME, problem, *made, lambda _, rows: rows)

    def _other(self, name: str, state: np.ndarray) -> ChartProblem:
        chart, given = next(c for c in self.charts if c.name == name), self.problem
        levels = {event: chart.pull_back(e) for event, e in self.functions.items()}
        levels[LEAVE] = _beyond(chart.singular, NEAR)
        levels[RETURN] = _beyond(chart.pull_back(_own_singular(self.charts)), CLEAR)
        sides = {f"{SIDE}{i}": e for i, e in enumerate(chart.sides)}
        form = _with_parameters(chart.form, self.form, levels.values())
        program = Program.of(form)
        ends = (self._end(LEAVE, -1), self._end(RETURN, 1))
        problem = replace(
            given,
            program=program,
            start=state.copy(),
            parameters=self._values(program),
            events=(*given.events, *ends, *(Guard(name) for name in sides)),
            levels=quantities(form, levels | sides),
            suspect=None,
            progress=self.progress,
            coarse=frozenset({LEAVE, RETURN}),
            units=None,
        )
        # a rate that is next to nothing in one chart is that of a whole turn in another
        problem = replace(problem, units=natural_units(problem))
        made = choose(self.place(HOME).chosen["method"], problem, self.grid)
        sheets = tuple(self._rows(self.form, sheet) for sheet in chart.double_cover)
        return ChartProblem(name, problem, *made, self._rows(chart.form, chart.back), sheets)

    def _end(self, name: str, direction: int) -> Guard:
        """The end of a stretch; the direction is that along the run, which may go backwards."""
        order = 1 if self.grid[-1] >= self.grid[0] else -1
        return Guard(name, direction * order, stop=True)

    def _rows(self, form: FirstOrderForm, images: Mapping[Any, Any]) -> Home:
        """A map to the own chart, for many states of a form."""
        program = quantities(form, {str(x): e for x, e in images.items()})
        values, (_, extras) = self._values(program), compile_program(program)

        def home(times: np.ndarray, rows: np.ndarray) -> np.ndarray:
            with np.errstate(all="ignore"):
                columns = extras(times, list(rows.T), values)
            result = np.empty(rows.shape)
            for i, column in enumerate(columns):
                result[:, i] = column
            return result

        return home

    @cached_property
    def _maps(self) -> dict[str, Callable[[Any, np.ndarray], np.ndarray]]:
        """The ways from the own chart into the others."""
        return {c.name: self._single([*c.there.values()]) for c in self.charts}

    @cached_property
    def _distances(self) -> dict[str, Callable[[Any, np.ndarray], np.ndarray]]:
        """The functions that vanish where a chart is singular, of states there."""
        others = {c.name: self._single([c.singular]) for c in self.charts}
        return {**others, HOME: self._single([_own_singular(self.charts)])}

    def _single(self, wanted: list[Any]) -> Callable[[Any, np.ndarray], np.ndarray]:
        """Functions of single states; not a number where one is undefined."""
        program = quantities(self.form, {str(i): e for i, e in enumerate(wanted)})
        values, (_, extras) = self._values(program), compile_program(program, scalar=True)

        def evaluate(time: Any, state: np.ndarray) -> np.ndarray:
            try:
                return np.array(extras(float(time), state.tolist(), values))
            except (ArithmeticError, ValueError):
                return np.full(len(wanted), np.nan)

        return evaluate

    def _values(self, program: Program) -> list[float]:
        """The parameters of a program."""
        names = map(str, self.problem.program.parameters)
        given = dict(zip(names, self.problem.parameters, strict=True))
        return [float(given[str(p)]) for p in program.parameters]


def _with_parameters(
    form: FirstOrderForm, own: FirstOrderForm, functions: Iterable[Any]
) -> FirstOrderForm:
    """The form of a chart, with those parameters of the own form that functions hold besides."""
    known = {*form.coordinates, *form.velocities, *form.parameters}
    held = set().union(*(e.free_symbols for e in functions)) - known
    besides = (p for p in own.parameters if p in held)
    return replace(form, parameters=(*form.parameters, *besides))


def whole_turns(steps: np.ndarray) -> np.ndarray:
    """The whole turns in steps of angles."""
    return np.asarray(2 * np.pi * np.rint(steps / (2 * np.pi)))


def _reduce_rows(rows: np.ndarray) -> np.ndarray:
    """A basis (k, n) of the same space, by elimination with the largest entries as pivots."""
    rows = rows.copy()
    for i in range(len(rows)):
        left = np.abs(rows[i:])
        row, column = divmod(int(left.argmax()), left.shape[1])
        rows[[i, i + row]] = rows[[i + row, i]]
        rows[i] /= rows[i, column]
        others = np.arange(len(rows)) != i
        rows[others] -= np.outer(rows[others, column], rows[i])
    return rows


def _after(first: Home, second: Home) -> Home:
    return lambda times, rows: second(times, first(times, rows))


def _beyond(function: Any, size: Any) -> Any:
    """Positive where a function is larger than a size."""
    return function**2 - size**2
