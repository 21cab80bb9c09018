"""Angles that give the attitude of a body, recognised, and a chart beyond their poles.

Where three coordinates are Euler's angles, in any sequence and however they are written, the
kinetic energy is degenerate at the poles of the second one: there the first and the third turn the
body about the same axis.  With c = theta + shift and s = +1 or -1 every such set is

    A Rz(phi) Rx(c) Rz(s psi) B,   A and B constant,

and what is regular as a function of the attitude is a polynomial in the entries of the matrix in
the middle.  So everything that a system declares is rewritten in these, and from these in angles
phi', c', psi' of the attitude with its polar axis laid down: R = Q R', Q the quarter turn about x.
That the rewriting succeeds is the proof that the system is regular at the poles.

A contact that is carried along has such angles too, longitude and colatitude of the normal and the
angle between the lines, in the constraints alone; and two coordinates may tell a direction, the
third column, where the third angle has no effect.  Velocities of a frame that are components along
the lines of theta and phi have no value at the poles, where these lines have none; along lines
that psi does not turn they are regular, and in the chart they are those along its own lines.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, compress, product
from random import Random
from typing import Any

import numpy as np
import symengine as se
import sympy as sp

from voronec.algebra.normal import canonical
from voronec.algebra.rank import generic_rank
from voronec.algebra.rotations import Rotations
from voronec.algebra.symbols import plain_name
from voronec.declaration.charts import Chart
from voronec.declaration.geometry import Frame
from voronec.declaration.system import System, system_in
from voronec.equations.definition import Definition
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.errors import EngineLimit, VoronecError

SEED = 20
"""Of the points at which the kinetic energy is looked at."""
DEGENERATE = 1e-9
"""An eigenvalue of the kinetic energy below this part of the largest is zero."""
ALMOST = DEGENERATE**0.5
"""Below it a part of a unit vector is zero."""
BESIDE = 1e-6
"""So far beside a pole an angle is looked at."""
QUARTER = se.pi / 2


@dataclass(frozen=True)
class EulerAngles:
    """Three coordinates that are Euler's angles: Rz(phi) Rx(theta + shift) Rz(sense psi), up to
    constant turns of space and of the body; or, where ``psi`` is None, two that are longitude and
    colatitude of a direction, the third column.  Symbols are those in the engine's symbols."""

    phi: Any
    theta: Any
    psi: Any
    shift: Any
    sense: int

    @property
    def singular(self) -> Any:
        """Vanishes at the poles."""
        return se.sin(self.theta + self.shift)

    @property
    def symbols(self) -> tuple[Any, ...]:
        """The three, or two."""
        return (self.phi, self.theta) if self.psi is None else (self.phi, self.theta, self.psi)

    @property
    def last(self) -> Any:
        """psi, or what stands for it beside a direction: nothing depends on that."""
        return se.Symbol(f"turn beside {self.theta}") if self.psi is None else self.psi

    @property
    def upright(self) -> tuple[Any, Any, Any]:
        """The three of Rz Rx Rz."""
        return self.phi, self.theta + self.shift, self.sense * self.last

    @property
    def horizontal(self) -> tuple[Any, Any, Any]:
        """The three of Rz Rx Rz where the polar axis is laid down."""
        return self.phi, self.theta, self.last

    @property
    def blind(self) -> dict[Any, Any]:
        """The rates of the coordinates that turn nothing at the poles, as functions of theta."""
        if self.psi is None:
            return {self.phi: se.Integer(1)}
        return {self.phi: se.Integer(1), self.psi: -self.sense * se.cos(self.theta + self.shift)}

    def body_rates(self, dots: Mapping[Any, Any]) -> tuple[Any, ...]:
        """The angular velocity along the axes of the body by the ``dots`` of coordinates; of a
        direction its two parts across it."""
        _, theta, psi = self.upright
        a, b = dots[self.phi], dots[self.theta]
        s, c = se.sin(psi), se.cos(psi)
        across = (a * se.sin(theta) * s + b * c, a * se.sin(theta) * c - b * s)
        if self.psi is None:
            return across
        return (*across, a * se.cos(theta) + self.sense * dots[self.psi])


def euler_angles(equations: VoronecEquations) -> tuple[EulerAngles, ...]:
    """The coordinates that are Euler's angles, by where the kinetic energy is degenerate.

    Found by numbers; that the system is regular at the poles ``with_attitude_charts`` decides.
    """
    return equations.memo.once("Euler angles", lambda: tuple(_recognise(equations.definition)))


def with_attitude_charts(equations: VoronecEquations) -> VoronecEquations | None:
    """The equations with charts that are regular at the poles of Euler's angles, beside those that
    the system declares; None where there are no such angles but those that declared charts turn,
    or where the system is not regular there."""
    return equations.memo.once("attitude charts", lambda: _make_chart(equations))


def angles_without_chart(equations: VoronecEquations) -> tuple[EulerAngles, ...]:
    """Those whose polar axis no chart of the system moves."""
    moved = {name for chart in equations.system.charts.values() for name in chart.state}
    return tuple(t for t in euler_angles(equations) if str(t.theta) not in moved)


def _make_chart(equations: VoronecEquations) -> VoronecEquations | None:
    system, triples = equations.system, angles_without_chart(equations)
    turned: dict[str, Chart] = {}
    for source, count in product(("", *system.charts), range(1, len(triples) + 1)):
        there = equations if not source else derive(system_in(system, source))
        for chosen in combinations(triples, count):
            axes = f"polar axis of {', '.join(str(t.theta) for t in chosen)} turned"
            try:
                chart = _TurnedSystem(there.definition, chosen, triples).chart
            except EngineLimit:
                continue
            declared = system.charts.get(source)
            name = f"{source}, {axes}" if source else axes
            turned[name] = (
                _beside(chart, system) if declared is None else _both(chart, declared, system)
            )
    if not turned:
        return None
    poles = sp.Mul(*[equations.bridge.outward(t.singular) for t in triples])
    kept = {
        name: replace(chart, singular_there=chart.singular_there * poles)
        for name, chart in system.charts.items()
    }
    try:
        return derive(replace(system, charts={**kept, **turned}))
    except VoronecError:
        return None


def _beside(chart: Chart, system: System) -> Chart:
    """A chart of attitudes where declared charts are not used."""
    factors = dict.fromkeys(f for c in system.charts.values() for f in sp.Mul.make_args(c.singular))
    rest = sp.Mul(*factors)
    return replace(
        chart, singular=chart.singular * rest, singular_there=chart.singular_there * rest
    )


def _both(chart: Chart, declared: Chart, system: System) -> Chart:
    """A chart of attitudes, made of a system in a declared chart, after that chart: they move
    different polar axes."""
    first, last = declared.values(system), chart.values(system, "back")
    return Chart(
        state={**declared.state, **{x: e.xreplace(first) for x, e in chart.state.items()}},
        singular=chart.singular * declared.singular,
        changes={**declared.changes, **chart.changes},
        back={**chart.back, **{x: e.xreplace(last) for x, e in declared.back.items()}},
        singular_there=chart.singular_there * declared.singular_there,
        double_cover=(*declared.double_cover, *chart.double_cover),
        near={**chart.near, **declared.near},
    )


def _recognise(d: Definition) -> Iterator[EulerAngles]:
    """Every triple whose two outer rates are one where the middle angle is at its pole, and every
    pair of which one has no effect where the other is at either pole."""
    if d.group is not None or d.inputs:
        return
    metric, taken = _Metric(d), set[Any]()
    for theta in d.coordinates:
        for shift in (se.Integer(0), QUARTER):
            blind = metric.blind_at(theta, -float(shift))
            if blind is None or taken & {theta, *blind} or theta in blind:
                continue
            phi, *others = sorted(blind, key=d.coordinates.index)
            if not others:
                partner = metric.blind_at(theta, np.pi - float(shift)) == blind and (None, 1)
            else:
                ratio = blind[others[0]] / blind[phi]
                partner = abs(abs(ratio) - 1) < ALMOST and (others[0], -1 if ratio > 0 else 1)
            if partner:
                taken |= {theta, *blind}
                yield EulerAngles(phi, theta, partner[0], shift, partner[1])


@dataclass(frozen=True)
class _Metric:
    """Squares of velocities in numbers: the kinetic energy without the constraints, and those parts
    of velocities that constraints and relations know."""

    d: Definition

    @cached_property
    def _entries(self) -> Any:
        """The entries of the kinetic energy, and of the conditions, as one function."""
        d = self.d
        L = d.lagrangian
        entries = [L.diff(a).diff(b) for i, a in enumerate(d.dots) for b in d.dots[: i + 1]]
        rows = [*d.constraints.matrix, *([r.diff(q) for q in d.coordinates] for r in d.relations)]
        entries += [x for row in rows for x in row]
        try:
            # asked a few times: to compile it would take longer than all of them
            return se.Lambdify(list(self._symbols), entries, cse=True, backend="lambda")
        except RuntimeError:  # an unknown function has no numbers
            return lambda _: np.full(len(entries), np.nan)

    def _matrix(self, point: np.ndarray) -> np.ndarray:
        n = len(self.d.dots)
        flat = np.asarray(self._entries(point), dtype=float)
        count = n * (n + 1) // 2
        energy, rows = np.zeros((n, n)), flat[count:].reshape(-1, n)
        energy[np.tril_indices(n)] = flat[:count]
        energy += np.tril(energy, -1).T
        energy /= np.abs(energy).max(initial=0.0) or 1.0
        if not len(rows) or not np.isfinite(flat).all():
            return energy + 0 * flat.sum()
        _, sizes, basis = np.linalg.svd(rows / np.abs(rows).max(axis=1, keepdims=True))
        known = basis[: (sizes > DEGENERATE * sizes.max()).sum()]
        return np.asarray(energy + known.T @ known)

    @property
    def _symbols(self) -> tuple[Any, ...]:
        d = self.d
        return (*d.coordinates, *d.dots, *d.parameters, d.time)

    def blind_at(self, angle: Any, value: float) -> dict[Any, float] | None:
        """The one or two coordinates of the single direction without energy where an angle has a
        value, with rates; None where that is not so.  Beside it, since rates may be infinite
        there."""
        dice, directions = Random(SEED), []
        place = self._symbols.index(angle)
        for _ in range(2):
            point = np.array([dice.uniform(0.3, 1.2) for _ in self._symbols])
            generic = self._matrix(point)
            point[place] = value + BESIDE
            blind = _null_direction(generic, self._matrix(point))
            if blind is None:
                return None
            directions.append(blind)
        one, other = directions
        if [*one] != [*other] or any(abs(one[i] - other[i]) > ALMOST for i in one):
            return None
        return {self.d.coordinates[i]: x for i, x in one.items()}


def _null_direction(generic: np.ndarray, matrix: np.ndarray) -> dict[int, float] | None:
    """The one or two entries, the first of them 1, of the only null vector of a matrix that is
    regular elsewhere."""
    moving = np.flatnonzero(np.abs(generic).max(axis=0) > 0)
    inner = np.ix_(moving, moving)
    if not (np.isfinite(generic).all() and np.isfinite(matrix).all()) or len(moving) < 2:
        return None
    if np.abs(np.linalg.eigvalsh(generic[inner])).min() < DEGENERATE:
        return None
    values, vectors = np.linalg.eigh(matrix[inner])
    order = np.argsort(np.abs(values))
    if abs(values[order[0]]) > DEGENERATE or abs(values[order[1]]) < DEGENERATE:
        return None
    vector = vectors[:, order[0]]
    held = np.flatnonzero(np.abs(vector) > ALMOST)
    if len(held) > 2:
        return None
    return {int(moving[i]): float(vector[i] / vector[held[0]]) for i in held}


def _matrix(angles: Sequence[Any]) -> Any:
    """Rz(phi) Rx(theta) Rz(psi), row by row."""
    (a, b), (c, s), (e, f) = [(se.cos(x), se.sin(x)) for x in angles]
    return (
        (a * e - b * c * f, -a * f - b * c * e, b * s),
        (b * e + a * c * f, -b * f + a * c * e, -a * s),
        (s * f, s * e, c),
    )


def _lay_down(R: Any) -> Any:
    """Q^T R, Q the quarter turn about x."""
    return R[0], R[2], tuple(-x for x in R[1])


def _stand_up(R: Any) -> Any:
    """Q R."""
    return R[0], tuple(-x for x in R[2]), R[1]


def _angles_of(R: Any) -> tuple[Any, Any, Any]:
    """phi, theta, psi of a matrix."""
    across = se.sqrt(R[0][2] ** 2 + R[1][2] ** 2)
    return se.atan2(R[0][2], -R[1][2]), se.atan2(across, R[2][2]), se.atan2(R[2][0], R[2][1])


@dataclass(frozen=True)
class _AlongLines:
    """Two velocities x, y that are components along the lines of theta and of phi, which turn with
    psi, or against it where ``sense`` is -1."""

    x: Any
    y: Any
    sense: int

    def rotate(self, x: Any, y: Any, angle: Any) -> tuple[Any, Any]:
        """Components where the lines have turned by an angle."""
        c, s = se.cos(angle), self.sense * se.sin(angle)
        return c * x + s * y, c * y - s * x

    def along(self, R: Any) -> dict[Any, Any]:
        """Those along the lines of the angles of a matrix, in which psi is what they turn by."""
        across = se.sqrt(R[2][0] ** 2 + R[2][1] ** 2)
        c, s = R[2][1] / across, self.sense * R[2][0] / across
        return {self.x: c * self.x + s * self.y, self.y: c * self.y - s * self.x}


@dataclass(frozen=True)
class _TurnedSystem:
    """A system in angles whose polar axes lie elsewhere, for one or several attitudes."""

    d: Definition
    chosen: tuple[EulerAngles, ...]
    triples: tuple[EulerAngles, ...]

    @property
    def chart(self) -> Chart:
        """The chart; ``EngineLimit`` where the system is not regular at the poles."""
        out = self.d.bridge.outward
        there: dict[Any, Any] = {}
        back: dict[Any, Any] = {}
        sheets: list[dict[Any, Any]] = []

        def outside(values: Any) -> dict[Any, Any]:
            return {out(q): out(e) for q, e in values}

        singular = se.Mul(*[t.singular for t in self.triples])
        kept = [t.singular for t in self.triples if t not in self.chosen]
        other = se.Mul(*kept, *[se.sin(t.theta) for t in self.chosen])
        _, lines = self._frame_rows
        for t in self.chosen:
            # of a direction there is no third
            down = _lay_down(_matrix((*t.upright[:2], se.Integer(0))))
            up = _stand_up(_matrix((*t.horizontal[:2], se.Integer(0))))
            phi, theta, turn = _angles_of(down)
            there |= zip(t.symbols, (phi, theta, t.upright[2] + turn), strict=False)
            phi, theta, turn = _angles_of(up)
            back |= zip(t.symbols, (phi, theta - t.shift, t.sense * (t.last + turn)), strict=False)
            other_side = [t.phi + se.pi, -t.theta - 2 * t.shift]
            other_side += [] if t.psi is None else [t.psi - se.pi]
            sheets.append(dict(zip(t.symbols, other_side, strict=True)))
            for pair in lines[t]:
                there |= pair.along(down)
                back |= pair.along(up)
                sheets[-1] |= {pair.x: -pair.x, pair.y: -pair.y}

        return Chart(
            state=outside(there.items()), singular=out(singular), changes=self._changes(),
            back=outside(back.items()), singular_there=out(other),
            double_cover=[outside(sheet.items()) for sheet in sheets], near=self._near,
        )  # fmt: skip

    @property
    def _near(self) -> dict[Any, Any]:
        """The image of a pole, where the body has turned by something, and the default scene."""
        scenes, out = self.d.system.scenes, self.d.bridge.outward
        start = (
            {plain_name(q): x for q, x in scenes["default"].initial.items()}
            if "default" in scenes
            else {}
        )
        values = {plain_name(q): start.get(plain_name(q), 0) for q in self.d.system.coordinates}
        for t in self.chosen:
            values |= {str(t.phi): sp.pi, str(t.theta): sp.pi / 2}
            values |= {} if t.psi is None else {str(t.psi): sp.Rational(1, 2)}
        return {q: values[plain_name(q)] for q in map(out, self.d.coordinates)}

    def _changes(self) -> dict[str, Any]:
        d, out = self.d, self.d.bridge.outward
        if d.added:
            raise EngineLimit("forces that hold accelerations are not written in other angles")
        changes: dict[str, Any] = {"lagrangian": out(self._move(d.lagrangian))}
        if d.constraints.matrix:
            changes["constraints"] = tuple(map(out, self._constraints()))
        if self._moved_relations != d.relations:
            changes["relations"] = tuple(map(out, self._moved_relations))
        if d.frame is not None:
            changes["frame"] = self._frame([out(row) for row in self._frame_rows[0]])
        if any(f != 0 for f in d.forces):
            power = self._move(_affine(d.forces, se.Integer(0), d.dots))
            pairs = zip(d.system.coordinates, d.dots, strict=True)
            changes["forces"] = {q: out(power.diff(dot)) for q, dot in pairs}
        return changes

    def _constraints(self) -> list[Any]:
        """The constraints in the other angles; where each for itself is singular at the poles, with
        those that give rates of the angles as ones that give angular velocities."""
        d = self.d
        rows = [
            [*row, c] for row, c in zip(d.constraints.matrix, d.constraints.offset, strict=True)
        ]
        for solve in product((False, True), repeat=len(self.chosen)):
            ways = [rows]
            for t in compress(self.chosen, solve):
                ways = [other for way in ways for other in _of_angular_velocities(way, t, d)]
            for way in ways:
                with suppress(EngineLimit):
                    return [self._move(_affine(row[:-1], row[-1], d.dots)) for row in way]
        raise EngineLimit("the constraints are not regular at the poles of the angles")

    @cached_property
    def _moved_relations(self) -> tuple[Any, ...]:
        relations = self.d.relations
        for t in self.chosen:
            relations = tuple(self._of_one(r, t) for r in relations)
        return relations

    @cached_property
    def _frame_rows(self) -> tuple[list[Any], dict[EulerAngles, list[_AlongLines]]]:
        """The velocities of the frame in the other angles, and those pairs of them that are taken
        along other lines there, by the attitude whose angles turn these."""
        d, lines = self.d, dict[EulerAngles, list[_AlongLines]]()
        if d.frame is None:
            return [], {t: [] for t in self.chosen}
        affine = zip(d.frame.matrix, d.frame.offset, strict=True)
        rows = dict(zip(d.velocities, (_affine(r, c, d.dots) for r, c in affine), strict=True))
        for t in self.chosen:
            singular = []
            for name, row in rows.items():
                try:
                    rows[name] = self._turn(row, t)
                except EngineLimit:
                    singular.append(name)
            lines[t] = [*self._pairs(singular, rows, t)]
        taken = [v for pairs in lines.values() for pair in pairs for v in (pair.x, pair.y)]
        if len({*taken}) < len(taken):
            raise EngineLimit("a velocity is along lines that turn at the poles of two attitudes")
        return [*map(self._in_normal_form, rows.values())], lines

    def _pairs(
        self, names: list[Any], rows: dict[Any, Any], t: EulerAngles
    ) -> Iterator[_AlongLines]:
        """Velocities in pairs that are regular along lines that psi does not turn; ``rows`` are
        then those along the lines of the other angles.  ``EngineLimit`` where one has no partner.
        """
        left, turn = [*names], se.Integer(0) if t.psi is None else t.psi
        while left:
            x = left.pop(0)
            for y, sense in product(left, (1, -1)):
                pair = _AlongLines(x, y, sense)
                held = pair.rotate(rows[x], rows[y], -t.upright[2])
                with suppress(EngineLimit):
                    along, across = (self._turn(row, t) for row in held)
                    rows[x], rows[y] = pair.rotate(along, across, turn)
                    left.remove(y)
                    yield pair
                    break
            else:
                raise EngineLimit(f"the velocity {x} is not regular at the poles of the angles")

    def _frame(self, expressions: Sequence[sp.Expr]) -> Frame:
        frame = self.d.system.frame
        assert frame is not None
        return replace(frame, expressions=tuple(expressions))

    def _move(self, expr: Any) -> Any:
        """A function of coordinates and velocities in the other angles."""
        for t in self.chosen:
            expr = self._turn(expr, t)
        return self._in_normal_form(expr)

    def _turn(self, expr: Any, t: EulerAngles) -> Any:
        """A function in the angles of one attitude laid down; roots may be coordinates."""
        try:
            return self._of_one(expr, t)
        except EngineLimit:
            return self._of_one(expr, t, _roots(self.d, t))

    def _in_normal_form(self, expr: Any) -> Any:
        try:
            return canonical([expr], self._moved_relations)[0]
        except EngineLimit:
            return expr

    def _of_one(self, expr: Any, t: EulerAngles, roots: Mapping[Any, Any] | None = None) -> Any:
        """A function in the angles of one attitude laid down; ``roots`` says what squares are."""
        d = self.d
        psi = t.last
        dots = {psi: se.Symbol("its rate"), **dict(zip(d.coordinates, d.dots, strict=True))}
        rates = tuple(se.Symbol(f"rate {i} of an attitude") for i in range(3))
        entries = [[se.Symbol(f"entry {i} {j} of an attitude") for j in range(3)] for i in range(3)]
        s, c = se.sin(psi), se.cos(psi)
        turn = (s * rates[0] + c * rates[1]) / se.sin(t.theta)
        spin = rates[2] - se.cos(t.theta) * turn
        spelled = expr.subs({t.theta: t.theta - t.shift, psi: t.sense * psi})
        spelled = spelled.xreplace({
            dots[t.phi]: turn,
            dots[t.theta]: c * rates[0] - s * rates[1],
            dots[psi]: t.sense * spin,
        })  # fmt: skip
        rewritten = Rotations(t.phi, t.theta, psi, entries, roots or {}).rewrite(spelled)
        matrix = _stand_up(_matrix(t.horizontal))
        values = {entries[i][j]: matrix[i][j] for i in range(3) for j in range(3)}
        # the body's rates do not know which way is up
        upright = EulerAngles(t.phi, t.theta, t.psi, se.Integer(0), 1)
        values |= zip(rates, upright.body_rates(dots), strict=False)
        rewritten = rewritten.xreplace(values)
        return rewritten.subs({psi: 0}) if t.psi is None else rewritten


def _roots(d: Definition, t: EulerAngles) -> dict[Any, Any]:
    """x -> f for every coordinate that a relation x^2 = f binds to the angles."""
    squares: dict[Any, Any] = {}
    for relation in d.relations:
        for x in {*d.coordinates} & relation.free_symbols - {*t.symbols}:
            half = relation.diff(x, x) / 2
            rest = se.expand(-(relation - half * x**2) / half) if half != 0 else x
            if x not in rest.free_symbols and rest.free_symbols & {*t.symbols}:
                squares[x] = rest
    return squares


def _of_angular_velocities(
    rows: list[list[Any]], t: EulerAngles, d: Definition
) -> Iterator[list[list[Any]]]:
    """Rows (k, n + 1) in which those that hold rates of the angles are solved for as many of the
    angular velocities, by each choice of these; none where there is none."""
    columns = [d.coordinates.index(x) for x in t.symbols]
    held = [i for i, row in enumerate(rows) if any(row[j] != 0 for j in columns)]
    kept, width = [row for i, row in enumerate(rows) if i not in held], len(rows[0])
    if not held:
        return
    rates = t.body_rates(dict(zip(d.coordinates, d.dots, strict=True)))
    turn = se.DenseMatrix([[w.diff(d.dots[j]) for j in columns] for w in rates])
    whole = se.DenseMatrix([rows[i] for i in held])
    coefficients = se.DenseMatrix([[rows[i][j] for j in columns] for i in held]) * turn.inv()
    for chosen in combinations(range(len(columns)), len(held)):
        square = [[coefficients[i, j] for j in chosen] for i in range(len(held))]
        if generic_rank(square) == len(held):
            solved = se.DenseMatrix(square).inv() * whole
            yield kept + [[solved[i, j] for j in range(width)] for i in range(len(held))]


def _affine(row: Sequence[Any], offset: Any, dots: Sequence[Any]) -> Any:
    return se.Add(offset, *[a * dot for a, dot in zip(row, dots, strict=True)])
