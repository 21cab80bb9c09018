"""Angles that give the attitude of a body, recognised, and a chart beyond their poles.

Where three coordinates are Euler's angles, in any sequence and however they are written, the
kinetic energy is degenerate at the poles of the second one: there the first and the third turn the
body about the same axis.  With c = theta + shift and s = +1 or -1 every such set is

    A Rz(phi) Rx(c) Rz(s psi) B,   A and B constant,

and what is regular as a function of the attitude is a polynomial in the entries of the matrix in
the middle.  So everything that a system declares is rewritten in these, and from these in angles
phi', c', psi' of the attitude with its polar axis laid down: R = Q R', Q the quarter turn about x.
That the rewriting succeeds is the proof that the system is regular at the poles.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, product
from random import Random
from typing import Any

import numpy as np
import symengine as se
import sympy as sp

from voronec.algebra.normal import canonical
from voronec.algebra.rotations import Rotations
from voronec.algebra.symbols import plain_name
from voronec.declaration.charts import Chart
from voronec.declaration.geometry import Frame
from voronec.declaration.system import System, system_in
from voronec.equations.definition import Definition
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.errors import EngineLimit, VoronecError

__all__ = ["EulerAngles", "angles_without_chart", "euler_angles", "with_attitude_charts"]

SEED = 20
"""Of the points at which the kinetic energy is looked at."""
DEGENERATE = 1e-9
"""An eigenvalue of the kinetic energy below this part of the largest is zero."""
QUARTER = se.pi / 2


@dataclass(frozen=True)
class EulerAngles:
    """Three coordinates that are Euler's angles: Rz(phi) Rx(theta + shift) Rz(sense psi), up to
    constant turns of space and of the body.  Symbols are those inside the door."""

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
    def symbols(self) -> tuple[Any, Any, Any]:
        """The three."""
        return self.phi, self.theta, self.psi


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
    """Those that no chart of the system moves."""
    moved = {name for chart in equations.system.charts.values() for name in chart.state}
    triples = euler_angles(equations)
    return tuple(t for t in triples if not moved & {str(q) for q in t.symbols})


def _make_chart(equations: VoronecEquations) -> VoronecEquations | None:
    system, triples = equations.system, angles_without_chart(equations)
    turned: dict[str, Chart] = {}
    for own, count in product(("", *system.charts), range(1, len(triples) + 1)):
        there = equations if not own else derive(system_in(system, own))
        for chosen in combinations(triples, count):
            axes = f"polar axis of {', '.join(str(t.theta) for t in chosen)} turned"
            try:
                chart = _TurnedSystem(there.definition, chosen, triples).chart
            except EngineLimit:
                continue
            declared = system.charts.get(own)
            name = f"{own}, {axes}" if own else axes
            turned[name] = _beside(chart, system) if declared is None else _both(chart, declared)
    if not turned:
        return None
    poles = sp.Mul(*[equations.door.outward(t.singular) for t in triples])
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


def _both(chart: Chart, declared: Chart) -> Chart:
    """A chart of attitudes, made of a system in a declared chart, and that chart: they move
    different coordinates."""
    return Chart(
        state={**declared.state, **chart.state},
        singular=chart.singular * declared.singular,
        changes={**declared.changes, **chart.changes},
        back={**declared.back, **chart.back},
        singular_there=chart.singular_there * declared.singular_there,
        twins=(*declared.twins, *chart.twins),
        near={**chart.near, **declared.near},
    )


def _recognise(d: Definition) -> Iterator[EulerAngles]:
    """Every triple whose two outer rates are one where the middle angle is at its pole."""
    if d.group is not None or d.inputs:
        return
    energy = _Energy(d)
    taken = set().union(*(r.free_symbols for r in d.relations))
    for theta in d.coordinates:
        for shift in (se.Integer(0), QUARTER):
            direction = energy.degenerate_at(theta, -float(shift))
            if direction is None or taken & {theta, *direction}:
                continue
            (phi, x), (psi, y) = sorted(direction.items(), key=lambda p: d.coordinates.index(p[0]))
            if theta not in direction and abs(abs(y / x) - 1) < DEGENERATE**0.5:
                taken |= {phi, theta, psi}
                yield EulerAngles(phi, theta, psi, shift, -1 if y / x > 0 else 1)


@dataclass(frozen=True)
class _Energy:
    """The kinetic energy of free motion, without the constraints, in numbers."""

    d: Definition

    @cached_property
    def _hessian(self) -> Any:
        d = self.d
        L, n = d.lagrangian, len(d.dots)
        entries = [L.diff(a).diff(b) for i, a in enumerate(d.dots) for b in d.dots[: i + 1]]
        try:
            function = se.Lambdify(list(self._symbols), entries, cse=True)
        except RuntimeError:  # an unknown function has no numbers
            return lambda _: np.full((n, n), np.nan)

        def matrix(values: Sequence[float]) -> np.ndarray:
            flat = iter(np.asarray(function(np.array(values)), dtype=float))
            result = np.empty((n, n))
            for i in range(n):
                for j in range(i + 1):
                    result[i, j] = result[j, i] = next(flat)
            return result

        return matrix

    @property
    def _symbols(self) -> tuple[Any, ...]:
        d = self.d
        return (*d.coordinates, *d.dots, *d.parameters, d.time)

    def degenerate_at(self, angle: Any, value: float) -> dict[Any, float] | None:
        """The two coordinates of the single direction without energy where an angle has a value,
        with their rates; None where that is not so."""
        if not se.has_symbol(self.d.lagrangian, angle):
            return None
        dice, found = Random(SEED), []
        place = self._symbols.index(angle)
        for _ in range(2):
            point = np.array([dice.uniform(0.3, 1.2) for _ in self._symbols])
            generic = self._hessian(point)
            point[place] = value
            matrix = self._hessian(point)
            moving = np.flatnonzero(np.abs(generic).max(axis=0) > 0)
            pair = _null_pair(generic, matrix, moving)
            if pair is None:
                return None
            found.append(pair)
        (i, x), (j, y) = found[0].items()
        if [*found[1]] != [i, j] or abs(found[1][j] / found[1][i] - y / x) > DEGENERATE**0.5:
            return None
        return {self.d.coordinates[i]: x, self.d.coordinates[j]: y}


def _null_pair(
    generic: np.ndarray, matrix: np.ndarray, moving: np.ndarray
) -> dict[int, float] | None:
    """The two entries of the only null vector of a matrix that is regular elsewhere."""
    inner = np.ix_(moving, moving)
    if not (np.isfinite(generic).all() and np.isfinite(matrix).all()) or len(moving) < 2:
        return None
    size = np.abs(generic).max()
    if np.abs(np.linalg.eigvalsh(generic[inner])).min() < DEGENERATE * size:
        return None
    values, vectors = np.linalg.eigh(matrix[inner])
    order = np.argsort(np.abs(values))
    if abs(values[order[0]]) > DEGENERATE * size or abs(values[order[1]]) < DEGENERATE * size:
        return None
    vector = vectors[:, order[0]]
    held = np.flatnonzero(np.abs(vector) > DEGENERATE**0.5)
    return {int(moving[i]): float(vector[i]) for i in held} if len(held) == 2 else None


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
class _TurnedSystem:
    """A system in angles whose polar axes lie elsewhere, for one or several attitudes."""

    d: Definition
    chosen: tuple[EulerAngles, ...]
    triples: tuple[EulerAngles, ...]

    @property
    def chart(self) -> Chart:
        """The chart; ``EngineLimit`` where the system is not regular at the poles."""
        out = self.d.door.outward
        there: dict[Any, Any] = {}
        back: dict[Any, Any] = {}
        twins: list[dict[Any, Any]] = []

        def outside(values: Any) -> dict[Any, Any]:
            return {out(q): out(e) for q, e in values}

        singular = se.Mul(*[t.singular for t in self.triples])
        kept = [t.singular for t in self.triples if t not in self.chosen]
        other = se.Mul(*kept, *[se.sin(t.theta) for t in self.chosen])
        for t in self.chosen:
            upright = _matrix((t.phi, t.theta + t.shift, t.sense * t.psi))
            there |= zip(t.symbols, _angles_of(_lay_down(upright)), strict=True)
            phi, theta, psi = _angles_of(_stand_up(_matrix(t.symbols)))
            back |= zip(t.symbols, (phi, theta - t.shift, t.sense * psi), strict=True)
            other_side = (t.phi + se.pi, -t.theta - 2 * t.shift, t.psi - se.pi)
            twins.append(outside(zip(t.symbols, other_side, strict=True)))

        return Chart(
            state=outside(there.items()), singular=out(singular), changes=self._changes(),
            back=outside(back.items()), singular_there=out(other), twins=twins, near=self._near,
        )  # fmt: skip

    @property
    def _near(self) -> dict[Any, Any]:
        """The image of a pole, where the body has turned by something, and the default scene."""
        scenes, out = self.d.system.scenes, self.d.door.outward
        start = (
            {plain_name(q): x for q, x in scenes["default"].initial.items()}
            if "default" in scenes
            else {}
        )
        own = {plain_name(q): start.get(plain_name(q), 0) for q in self.d.system.coordinates}
        for t in self.chosen:
            own |= {str(t.phi): sp.pi, str(t.theta): sp.pi / 2, str(t.psi): sp.Rational(1, 2)}
        return {q: own[plain_name(q)] for q in map(out, self.d.coordinates)}

    def _changes(self) -> dict[str, Any]:
        d, out = self.d, self.d.door.outward
        if d.added:
            raise EngineLimit("forces that hold accelerations are not written in other angles")
        dots = d.dots
        changes: dict[str, Any] = {"lagrangian": out(self._move(d.lagrangian))}
        if d.constraints.matrix:
            rows = zip(d.constraints.matrix, d.constraints.offset, strict=True)
            changes["constraints"] = tuple(out(self._move(_affine(r, c, dots))) for r, c in rows)
        if d.frame is not None:
            rows = zip(d.frame.matrix, d.frame.offset, strict=True)
            read = [out(self._move(_affine(r, c, dots))) for r, c in rows]
            changes["frame"] = self._frame(read)
        if any(f != 0 for f in d.forces):
            power = self._move(_affine(d.forces, se.Integer(0), dots))
            own = d.system.coordinates
            changes["forces"] = {q: out(power.diff(dot)) for q, dot in zip(own, dots, strict=True)}
        return changes

    def _frame(self, expressions: Sequence[sp.Expr]) -> Frame:
        own = self.d.system.frame
        assert own is not None
        return replace(own, expressions=tuple(expressions))

    def _move(self, expr: Any) -> Any:
        """A function of coordinates and velocities in the other angles."""
        for t in self.chosen:
            expr = self._of_one(expr, t)
        try:
            return canonical([expr], self.d.relations)[0]
        except EngineLimit:
            return expr

    def _of_one(self, expr: Any, t: EulerAngles) -> Any:
        d = self.d
        dots = dict(zip(d.coordinates, d.dots, strict=True))
        rates = tuple(se.Symbol(f"rate {i} of an attitude") for i in range(3))
        entries = [[se.Symbol(f"entry {i} {j} of an attitude") for j in range(3)] for i in range(3)]
        s, c = se.sin(t.psi), se.cos(t.psi)
        turn = (s * rates[0] + c * rates[1]) / se.sin(t.theta)
        spin = rates[2] - se.cos(t.theta) * turn
        own = expr.subs({t.theta: t.theta - t.shift, t.psi: t.sense * t.psi})
        own = own.xreplace({
            dots[t.phi]: turn,
            dots[t.theta]: c * rates[0] - s * rates[1],
            dots[t.psi]: t.sense * spin,
        })  # fmt: skip
        found = Rotations(*t.symbols, entries).rewrite(own)
        matrix = _stand_up(_matrix(t.symbols))
        values = {entries[i][j]: matrix[i][j] for i in range(3) for j in range(3)}
        a, b, e = (dots[q] for q in t.symbols)
        sine, cosine = se.sin(t.theta), se.cos(t.theta)
        # the body's rates do not know which way is up
        values |= {
            rates[0]: a * sine * s + b * c,
            rates[1]: a * sine * c - b * s,
            rates[2]: a * cosine + e,
        }
        return found.xreplace(values)


def _affine(row: Sequence[Any], offset: Any, dots: Sequence[Any]) -> Any:
    return se.Add(offset, *[a * dot for a, dot in zip(row, dots, strict=True)])
