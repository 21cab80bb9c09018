"""The integral map of a system: its proved integrals on the reduced phase space.

    x -> (F_1(x), ..., F_k(x)),    R_1(x) = ... = R_r(x) = 0

x are invariants (or coordinates) and velocities, R the relations between them.  A velocity that a
constraint gives with a divisor, omega3 = -(omega1 gamma1 + omega2 gamma2)/gamma3, becomes a
variable, and gamma3 omega3 + omega1 gamma1 + omega2 gamma2 = 0 a relation: nothing is infinite
where gamma3 = 0.

Where a velocity w is a factor of rates, x' = w Y(x), and Y holds no variables but these x, they
move on the curves of Y, and their values at one place of these are integrals.  Of a rolling disc
Legendre functions give them, of bodies of revolution hypergeometric ones [Appell1900,
Chaplygin1897]; here they are computed, by steps along Y.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import symengine as se
import sympy as sp

from voronec.algebra.normal import canonical
from voronec.algebra.symbols import plain_name
from voronec.declaration.claims import right_of
from voronec.dynamics.angles import are_angles
from voronec.dynamics.natural_integrals import is_long
from voronec.dynamics.phase_space import PhaseSpace
from voronec.equations.motions import Motions
from voronec.equations.program import Program, compile_program
from voronec.equations.program.jacobian import joint_block
from voronec.equations.program.straight import fresh_names, share_subexpressions
from voronec.equations.reduction import in_invariants
from voronec.equations.vector_field import VectorField
from voronec.errors import DefinitionError, VoronecError
from voronec.motion.request import number

STEPS = 6
"""Steps of Dormand and Prince's method of order 8 along Y: nine digits, less near its poles."""
EXACT = 1e-3
"""The largest error of the embedded method of order 5, in the units of the variables."""
NUDGE = 1e-5
"""The step of central differences, whose error is about its square."""
ITERATIONS = 25
"""Steps of Newton's method towards a level."""
CLOSE = 1e-10
"""A point lies on a level where its integrals are met to this, in their sizes."""
GENERIC = 1e-8
"""Gradients at random points depend on one another where a singular value is below this."""


@dataclass(frozen=True, eq=False)
class IntegralMap:
    """The integrals of a system as functions of the ``variables`` of its reduced phase space.

    ``constants`` are the names of the relations, then of the integrals, in the order of the
    columns of ``jet``; ``start`` (n,) is that of the scene, ``units`` (n,) usual sizes.
    ``carried`` are integrals that are computed along Y, by the name of the variable.
    """

    phase: PhaseSpace
    flow: VectorField
    variables: tuple[str, ...]
    constants: tuple[str, ...]
    relations: int
    formulas: tuple[Any, ...]
    carried: CarriedIntegrals | None
    start: np.ndarray
    units: np.ndarray

    @property
    def integrals(self) -> tuple[str, ...]:
        """The names of the integrals."""
        return self.constants[self.relations :]

    def places(self, names: Sequence[str]) -> list[int]:
        """Which columns of ``jet`` these are."""
        return [self.constants.index(name) for name in names]

    @cached_property
    def _programs(self) -> list[tuple[Program, list[tuple[int, ...]]]]:
        """What computes the formulas, then their slopes, then the slopes of these, and where they
        stand."""
        symbols, time = tuple(map(se.Symbol, self.variables)), se.Symbol("t")
        block = share_subexpressions(self.formulas, fresh_names(symbols))
        places: list[tuple[int, ...]] = [(i,) for i in range(len(self.formulas))]
        made = []
        for order in range(3):
            program = Program.of_block(time, symbols, block)
            made.append((program, [*places]))
            if order < 2:
                block, more = joint_block(program, block, symbols)
                places += [(*places[i], j) for i, j in more]
        return made

    def jet(self, x: np.ndarray, order: int = 1) -> list[np.ndarray]:
        """The constants (m, c) at points (m, n), their gradients (m, c, n) and second derivatives
        (m, c, n, n), up to an order."""
        m, n = x.shape
        program, places = self._programs[order]
        with np.errstate(all="ignore"):
            entries = compile_program(program)[1](np.float64(0.0), [*x.T], [])
        jets = [np.zeros((m, len(self.constants), *(n,) * k)) for k in range(order + 1)]
        for place, value in zip(places, entries, strict=True):
            index: Any = (slice(None), *place)
            jets[len(place) - 1][index] = value
        if self.carried is not None:
            carried = self.carried.jet(x, order)
            for k, values in enumerate(carried):
                jets[k][:, len(self.formulas) :] = values
        return jets

    def rank(self, rows: Sequence[int]) -> int:
        """How many of the constants are independent at random points."""
        x = self.project(self.random_points(8), range(self.relations), ())
        values, slopes = (part[:, [*rows]] for part in self.jet(x))
        told = np.isfinite(values).all(axis=1) & np.isfinite(slopes).all(axis=(1, 2))
        slopes = slopes[told] * self.units
        sizes = np.linalg.norm(slopes, axis=2, keepdims=True)
        slopes = np.divide(slopes, sizes, out=np.zeros_like(slopes), where=sizes > 0)
        # errors of integrals that are computed, large at some points, make ranks larger
        return min(
            (int((np.linalg.svd(s, compute_uv=False) > GENERIC).sum()) for s in slopes), default=0
        )

    @cached_property
    def angles(self) -> np.ndarray:
        """Which variables (n,) are angles: a whole turn of them changes no constant."""
        points = np.random.default_rng(1).normal(size=(8, len(self.units))) * self.units
        return are_angles(lambda x: self.jet(x, 0)[0], points, len(self.units))

    @cached_property
    def has_poles(self) -> bool:
        """Whether variables have poles, as polar angles do; where they have, levels may be covered
        more than once."""
        from scipy.optimize import minimize

        if self._volume is None:
            return False
        points = self.random_points(60)
        points = points[np.argsort([self._volume(x) for x in points])][:3]
        return any(self.is_pole(minimize(self._volume, x).x) for x in points)

    def is_pole(self, x: np.ndarray) -> bool:
        """Whether coordinates are singular at x (n,), where the mass matrix has no inverse:
        constants are critical there that are not."""
        return self._volume is not None and self._volume(x) < GENERIC

    @cached_property
    def _volume(self) -> Callable[[np.ndarray], float] | None:
        """The determinant of the mass matrix by its usual size, where coordinates are variables and
        it depends on them."""
        known = {se.Symbol(n): float(v[0]) for n, v in self.phase.motions.parameters.items()}
        entries = [e.xreplace(known) for row in self.flow.mass for e in row]
        symbols, size = [*map(se.Symbol, self.variables)], len(self.flow.mass)
        held = {s for e in entries for s in e.free_symbols}
        if self.flow.level != "coordinates" or not held or not held <= {*symbols}:
            return None
        mass = se.Lambdify(symbols, entries)

        def volume(x: np.ndarray) -> float:
            return abs(float(np.linalg.det(np.reshape(mass(x), (size, size)))))

        usual = float(np.median([volume(x) for x in self.random_points(60)]))
        return lambda x: volume(x) / usual

    def random_points(
        self, count: int, seed: int = 1, sizes: np.ndarray | None = None
    ) -> np.ndarray:
        """Points (count, n) of the usual sizes, which lie on no level; angles anywhere."""
        random, units = np.random.default_rng(seed), self.units if sizes is None else sizes
        x = random.normal(size=(count, len(units))) * units
        x[:, self.angles] = random.uniform(-np.pi, np.pi, size=(count, int(self.angles.sum())))
        return x

    def difference(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        """The shortest ways (..., n) from a to b, by less than half a turn of angles."""
        way = b - a
        way[..., self.angles] = (way[..., self.angles] + np.pi) % (2 * np.pi) - np.pi
        return way

    def spread(self, x: np.ndarray, sizes: np.ndarray) -> np.ndarray:
        """Points (m, n) in units of sizes, angles by cosine and sine, so that near is near."""
        turned = x[:, self.angles]
        plain = x[:, ~self.angles] / sizes[~self.angles]
        return np.hstack([plain, np.cos(turned), np.sin(turned)])

    def project(self, x: np.ndarray, rows: Sequence[int], targets: Any) -> np.ndarray:
        """The points (m', n) of a level to which those of x (m, n) lead by Newton's method, in the
        least steps; those that lead to none are left out.  The last of the ``rows`` have the values
        of ``targets``, those before them, relations, are zero."""
        points, met = self.settle(x, rows, targets)
        return points[met]

    def settle(
        self, x: np.ndarray, rows: Sequence[int], targets: Any
    ) -> tuple[np.ndarray, np.ndarray]:
        """The points (m, n) to which Newton's method leads, and which of them (m,) lie on the
        level."""
        rows, x = [*rows], x.copy()
        values = np.array([0.0] * (len(rows) - len(targets)) + [*targets])
        met, todo = np.zeros(len(x), dtype=bool), np.arange(len(x))
        for _ in range(ITERATIONS):
            value, slopes = (part[:, rows] for part in self.jet(x[todo]))
            off, matrix = value - values, slopes * self.units
            sizes = np.linalg.norm(matrix, axis=2)
            longest = sizes.max(axis=1, keepdims=True, initial=0.0)
            sizes = np.maximum(sizes, 1e-3 * longest + 1e-300)
            off, matrix = off / sizes, matrix / sizes[..., None]
            finite = np.isfinite(off).all(axis=1) & np.isfinite(matrix).all(axis=(1, 2))
            near = finite & (np.abs(off).max(axis=1, initial=0.0) < CLOSE)
            met[todo[near]] = True
            goes_on = finite & ~near
            todo, off, matrix = todo[goes_on], off[goes_on], matrix[goes_on]
            if not len(todo):
                break
            square = matrix @ matrix.transpose(0, 2, 1) + 1e-12 * np.eye(len(rows))
            step = (matrix.transpose(0, 2, 1) @ np.linalg.solve(square, off[..., None]))[..., 0]
            length = np.linalg.norm(step, axis=1, keepdims=True)
            x[todo] -= self.units * step / np.maximum(length, 1.0)
        return x, met

    def home(self, x: np.ndarray) -> dict[str, float]:
        """A start of the system, coordinates and velocities by name, at a point (n,)."""
        from scipy.optimize import least_squares

        state = dict(zip(self.variables, x.tolist(), strict=True))
        velocities = {str(v): state[str(v)] for v in self.flow.velocities}
        system = self.phase.system
        begin = self.phase.motions.full[0][: len(system.coordinates)]
        names = [plain_name(q) for q in system.coordinates]
        if self.flow.level == "coordinates":
            given = {n: state.get(n, b) for n, b in zip(names, begin.tolist(), strict=True)}
            return {**given, **velocities}
        definitions = Motions.of(self.phase.motions.namespace.equations).reduction.definitions
        function = sp.lambdify(system.coordinates, definitions, "numpy")
        aim = np.array([state[str(g)] for g in self.flow.positions])
        random = np.random.default_rng(1)
        for k in range(20):
            near = begin + (k > 0) * random.normal(size=len(begin))
            fit = least_squares(lambda q: np.array(function(*q), float) - aim, near, xtol=1e-15)
            if np.abs(fit.fun).max() < 1e-9:
                return {**dict(zip(names, fit.x.tolist(), strict=True)), **velocities}
        raise DefinitionError(
            f"system '{system.name}': its coordinates are singular at this point of the level; "
            "take another one"
        )


@dataclass(frozen=True, eq=False)
class CarriedIntegrals:
    """Values of ``names`` where the variable ``along`` has the value ``place`` on the curves of Y.

    ``program`` computes the slopes of the variables in the places ``own`` by ``along``, and behind
    them what they divide by; beyond a zero of that, and so near it that the steps are not
    accurate, the integrals are no numbers.
    """

    names: tuple[str, ...]
    own: tuple[int, ...]
    along: int
    place: float
    carried: tuple[int, ...]
    program: Program

    def values(self, x: np.ndarray) -> np.ndarray:
        """The integrals (..., k) at points (..., n), which may be complex."""
        from scipy.integrate import DOP853

        slope, here = compile_program(self.program)[1], x[..., [*self.own]]
        place = self.own.index(self.along)
        with np.errstate(all="ignore"):
            step, width = (self.place - here[..., place]) / STEPS, len(self.own)
            signs: list[Any] = []
            error = np.zeros(step.shape)

            def field(z: np.ndarray) -> np.ndarray:
                parts = slope(np.float64(0.0), [z[..., i] for i in range(width)], [])
                entries = np.stack([np.broadcast_to(f, step.shape) for f in parts], axis=-1)
                signs.append(np.sign(entries[..., width:].real))
                return step[..., None] * entries[..., :width]

            def weighted_sum(row: np.ndarray, stages: list[Any]) -> Any:
                return sum(a * k for a, k in zip(row, stages, strict=False) if a)

            for _ in range(STEPS):
                stages: list[Any] = []
                for row in DOP853.A[: DOP853.n_stages]:
                    stages.append(field(here + weighted_sum(row, stages)))
                here = here + weighted_sum(DOP853.B, stages)
                wrong = np.abs(weighted_sum(DOP853.E5, stages))
                error = np.maximum(error, wrong.max(axis=-1))
        beyond = np.any([s != signs[-1] for s in signs], axis=(0, -1)) | ~(error < EXACT)
        return np.where(beyond[..., None], np.nan, here[..., [*map(self.own.index, self.carried)]])

    def jet(self, x: np.ndarray, order: int) -> list[np.ndarray]:
        """Values, gradients by steps into the complex plane, and differences of these."""
        n = x.shape[1]
        if order == 0:
            return [self.values(x)]
        nudges = [np.zeros((1, n)), *((NUDGE * np.eye(n), -NUDGE * np.eye(n)) if order > 1 else ())]
        points = x[:, None] + np.concatenate(nudges)
        values = self.values(points[:, :, None] + 1e-30j * np.eye(n))
        slopes = values.imag.transpose(0, 1, 3, 2) / 1e-30
        jets = [values[:, 0, 0].real, slopes[:, 0]]
        if order > 1:
            second = (slopes[:, 1 : n + 1] - slopes[:, n + 1 :]) / (2 * NUDGE)
            jets.append(second.transpose(0, 2, 3, 1))
        return jets


def integral_map_of(
    system: Any, scene: Any, parameters: Mapping[Any, Any], moving: Sequence[str] = ()
) -> IntegralMap:
    """The integral map of a system with the values of a scene and of ``parameters``; parameters
    that are ``moving`` are variables, and integrals of themselves.

    ``DefinitionError`` where the system depends on the time, where its right side is not smooth,
    and where no integral is proved, so that the map is constant.
    """
    phase = PhaseSpace.of(system, scene, None, parameters, None, ())
    if phase.is_driven:
        raise DefinitionError(
            f"system '{phase.system.name}' depends on the time: its integrals have no levels"
        )
    equations = phase.motions.namespace.equations
    motions, model = Motions.of(equations), equations.system
    functions = {n: right_of(model.integrals[n]) for n in phase.constants if n in model.integrals}
    try:
        flow = motions.on_invariants if model.invariants else motions.on_coordinates
        read = {name: flow.read(f) for name, f in functions.items()}
    except VoronecError:
        flow = motions.on_coordinates
        read = {name: flow.read(f) for name, f in functions.items()}
        read = dict(zip(read, canonical([*read.values()], flow.relations), strict=True))
    known = [p.name for p in model.parameters]
    kept = _variables_of(flow, [*read.values()])
    relations, formulas, more = _lift(motions, flow, [*read.values()])
    numbers = {n: float(v[0]) for n, v in phase.motions.parameters.items() if n in known}
    values = {se.Symbol(n): _exact(model, n, x) for n, x in numbers.items() if n not in moving}
    states = (*kept, *more, *map(se.Symbol, moving))
    start = _start(phase, kept, more, motions, [numbers[n] for n in moving])
    carried = None if moving or is_long(equations) else _carry(flow, states, values, start)
    relations = [r for r in relations if r.free_symbols & {*kept}]
    exprs = [e.xreplace(values) for e in (*relations, *formulas, *map(se.Symbol, moving))]
    names = (*(f"relation {i + 1}" for i in range(len(relations))), *read, *moving)
    if not read and carried is None:
        raise DefinitionError(
            f"system '{model.name}': none of its integrals is proved to be one, so that the "
            "integral map is constant; declare integrals, or search for them: voronec search "
            "integrals"
        )
    size = max((abs(x) for x, s in zip(start, states, strict=True) if s in flow.velocities),
               default=1.0) or 1.0  # fmt: skip
    units = [size if s in (*flow.velocities, *more) else abs(numbers.get(str(s), 1.0)) or 1.0
             for s in states]  # fmt: skip
    bare = IntegralMap(
        phase, flow, tuple(map(str, states)), names, len(relations), tuple(exprs), None, start,
        np.array(units),
    )  # fmt: skip
    if carried is None:
        return bare
    full = replace(bare, constants=(*names, *carried.names), carried=carried)
    return full if full.rank(range(len(full.constants))) > bare.rank(range(len(names))) else bare


def _exact(system: Any, name: str, value: float) -> Any:
    """A parameter's value, as it was declared, else the fraction that the double is."""
    declared = next(p.value for p in system.parameters if p.name == name)
    same = declared is not None and number(declared, name) == value
    return se.sympify(declared if same else sp.Rational(value))


def _variables_of(flow: VectorField, formulas: Sequence[Any]) -> tuple[Any, ...]:
    """The variables of which integrals, accelerations and relations are functions."""
    rates = dict(zip(flow.positions, flow.rates, strict=True))
    kept = {*flow.velocities}.union(*(e.free_symbols for e in (*formulas, *flow.accelerations)))
    while True:
        more = kept.union(*(rates[x].free_symbols for x in kept if x in rates))
        if more == kept:
            return tuple(x for x in flow.variables if x in kept)
        kept = more


def _lift(
    motions: Motions, flow: VectorField, formulas: list[Any]
) -> tuple[list[Any], list[Any], list[Any]]:
    """The relations, the formulas and further variables, where velocities that have divisors are
    variables."""
    relations, more = [*flow.independent_relations], list[Any]()
    frame = motions.system.frame
    for name, meaning in (frame.beside if frame and flow.level == "invariants" else {}).items():
        try:
            on_home = motions.on_coordinates.read(meaning)
            image = in_invariants(motions.equations, [on_home])[0]
        except VoronecError:
            continue
        if image is None:
            continue
        below = {p.args[0] for p in _powers(se.expand(image))}
        if not below:
            continue
        divisor, w = se.Mul(*below), se.Symbol(plain_name(name))
        above = se.expand(image * divisor)
        lifted = [f.xreplace({above: divisor * w, -above: -divisor * w}) for f in formulas]
        if any(p.args[0] in below for f in lifted for p in _powers(f)):
            continue
        formulas, more = lifted, [*more, w]
        relations.append(divisor * w - above)
    return relations, formulas, more


def _is_singular(field: Sequence[Any], at: Mapping[Any, Any]) -> bool:
    return any(p.args[0].xreplace(at) == 0 for e in field for p in _powers(e, se.Basic))


def _powers(expr: Any, kind: Any = se.Symbol) -> list[Any]:
    """Powers with negative exponents of what is of a kind, wherever they stand."""
    powers, todo = [], [expr]
    while todo:
        e = todo.pop()
        todo += e.args
        if isinstance(e, se.Pow) and isinstance(e.args[0], kind) and e.args[1].is_negative:
            powers.append(e)
    return powers


def _start(
    phase: PhaseSpace, kept: Sequence[Any], more: Sequence[Any],
    motions: Motions, moving: Sequence[float],
) -> np.ndarray:  # fmt: skip
    """The start of the scene as a point."""
    many, system = phase.motions, motions.system
    home = [*map(plain_name, system.coordinates), *map(plain_name, system.velocities)]
    full = dict(zip(home, many.full[0].tolist(), strict=True))
    known = {se.Symbol(n): x for n, x in full.items()}
    known |= {se.Symbol(n): float(v[0]) for n, v in many.parameters.items()}
    frame = system.frame.beside if system.frame else {}
    spelled = {plain_name(w): motions.on_coordinates.read(e) for w, e in frame.items()}
    spelled |= {n: motions.equations.bridge.inward(e) for n, e in system.invariants.items()}
    exprs = [spelled.get(str(x), x) for x in (*kept, *more)]
    return np.array([float(se.sympify(e).xreplace(known)) for e in exprs] + [*moving])


def _carry(
    flow: VectorField, states: Sequence[Any], values: Mapping[Any, Any], start: np.ndarray
) -> CarriedIntegrals | None:
    """Integrals along Y; None where there are none."""
    components = dict(zip(flow.variables, flow.components, strict=True))
    order = {x: i for i, x in enumerate(states)}
    for w in flow.velocities:
        chosen = [x for x in states if x in components and x != w]
        pace = {x: se.expand(components[x]).xreplace({w: se.Integer(0)}) for x in chosen}
        chosen = [x for x in chosen if canonical([pace[x]], flow.relations)[0] == 0]
        slopes = dict(zip(chosen, canonical([components[x] / w for x in chosen], flow.relations),
                          strict=True))  # fmt: skip
        while True:
            inside = {*chosen, *flow.parameters}
            closed = [x for x in chosen if slopes[x].free_symbols <= inside]
            if len(closed) == len(chosen):
                break
            chosen = closed
        carried = [x for x in chosen if x in flow.velocities and slopes[x] != 0]
        places = [x for x in chosen if x in flow.positions and slopes[x] != 0]
        for along in places if carried else ():
            field = [(slopes[x] / slopes[along]).xreplace(values) for x in chosen]
            place = next(x for x in (0, start[order[along]]) if not _is_singular(field, {along: x}))
            below = {p.args[0] for e in field for p in _powers(e, se.Basic)}
            results = [*field, *sorted(below, key=str)]
            block = share_subexpressions(results, fresh_names(chosen))
            program = Program.of_block(se.Symbol("t"), chosen, block)
            names = tuple(f"{x} where {along} = {place:g}" for x in carried)
            return CarriedIntegrals(names, tuple(order[x] for x in chosen), order[along], place,
                                    tuple(order[x] for x in carried), program)  # fmt: skip
    return None
