"""Splits of the velocities: the same motion with other independent velocities, or other pivots.

At a point where the constraints A w + a = 0 are independent, some of the velocities w determine the
others.  Which do so best is told by the metric

    g = d2L/dw2 + s A^T A

in which units and coordinates play no part: of the covectors dw, at unit length, those whose
restrictions to the admissible velocities are farthest from being dependent.  For each choice the
equations are derived anew, exactly, with pivots that are well conditioned at that point.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.linalg
import symengine as se
import sympy as sp

from voronec.algebra.symbols import plain_name, velocity
from voronec.algebra.text import sympified
from voronec.charts import Chart, bare
from voronec.definition import Definition, read
from voronec.derivation import Derivation, FirstOrderForm
from voronec.equations import VoronecEquations
from voronec.geometry import Fibration, Frame
from voronec.system import System

__all__ = [
    "Geometry",
    "equations_near",
    "geometry_entries",
    "metric_of",
    "split_system",
    "wide_form",
]

SHARE = 0.1
"""A pivot is no smaller than this part of its row, at the point for which it is chosen."""
DEPENDENT = 1e-9
"""Constraints whose least singular value is below this part of the largest are dependent."""


def wide_form(d: Definition) -> FirstOrderForm:
    """The coordinates and all their velocities (of a group, those of its frame) as a state: what
    the splits of a system share.  It says nothing of how the velocities change."""
    n = len(d.dots)
    one, zero = se.Integer(1), se.Integer(0)
    return FirstOrderForm(
        coordinates=d.coordinates,
        velocities=tuple(d.dots),
        parameters=d.parameters,
        time=d.time,
        rates=tuple(d.dots if d.group is None else d.group.moved(d.dots)),
        mass=tuple(tuple(one if i == j else zero for j in range(n)) for i in range(n)),
        force=(zero,) * n,
        velocity_symbols=() if d.group is None else d.coordinate_velocities,
    )


def geometry_entries(d: Definition) -> dict[str, Any]:
    """What ``Geometry.of`` takes, by name, as functions of the wide state: rows of the constraints
    and the relations, rows of the frame, each with its offset, and d2L/dw2."""
    forms: list[tuple[Sequence[Any], Any]] = []
    forms += zip(d.constraints.matrix, d.constraints.offset, strict=True)
    forms += zip(d.differentiated.matrix, d.differentiated.offset, strict=True)
    n = len(d.velocities)
    own: list[tuple[Sequence[Any], Any]] = []
    if d.frame is not None:
        own += zip(d.frame.matrix, d.frame.offset, strict=True)
    else:
        unit = [[se.Integer(int(i == a)) for a in range(len(d.dots))] for i in range(n)]
        own += [(row, se.Integer(0)) for row in unit]
    entries: dict[str, Any] = {}
    for kind, rows in (("condition", forms), ("frame", own)):
        for i, (row, offset) in enumerate(rows):
            entries |= {f"{kind} {i},{a}": se.sympify(e) for a, e in enumerate((*row, offset))}
    for a, w in enumerate(d.dots):
        slope = d.lagrangian.diff(w)
        entries |= {f"mass {a},{b}": slope.diff(u) for b, u in enumerate(d.dots[: a + 1])}
    return entries


@dataclass(frozen=True)
class Geometry:
    """Frame and metric at one point.

    ``frame`` (n, N) are the rows of the velocities v; ``admissible`` (N, k) is a basis of the
    admissible velocities that is orthonormal in the metric, ``lengths`` are those of the covectors
    dw; k = n where the constraints are independent.
    """

    frame: np.ndarray
    metric: np.ndarray
    admissible: np.ndarray
    lengths: np.ndarray

    @classmethod
    def of(cls, values: Mapping[str, Any], conditions: np.ndarray, frame: np.ndarray) -> Geometry:
        """The geometry from the values of ``geometry_entries`` at one point, and their rows
        without offsets."""
        metric = metric_of(values, conditions)
        root = np.linalg.cholesky(metric)
        inverse = np.linalg.inv(root).T  # columns are orthonormal in the metric
        left = conditions @ inverse
        left = left / np.maximum(np.linalg.norm(left, axis=1, keepdims=True), 1e-300)
        _, sizes, vt = np.linalg.svd(left)
        rank = int((sizes > DEPENDENT * sizes.max(initial=0.0)).sum())
        return cls(frame, metric, inverse @ vt[rank:].T, np.linalg.norm(inverse, axis=1))

    @property
    def quality(self) -> float:
        """How far the velocities v are from being dependent: 1 at best, 0 where they are none."""
        rows = self.frame
        lengths = np.linalg.norm(np.linalg.solve(np.linalg.cholesky(self.metric), rows.T), axis=0)
        if not lengths.all():
            return 0.0
        sizes = np.linalg.svd((rows @ self.admissible) / lengths[:, None], compute_uv=False)
        return float(sizes.min(initial=1.0))

    @property
    def best(self) -> tuple[int, ...]:
        """Positions of the velocities w that are the best frame."""
        rows = self.admissible / self.lengths[:, None]
        _, _, order = scipy.linalg.qr(rows.T, mode="economic", pivoting=True)
        return tuple(sorted(int(a) for a in order[: len(self.frame)]))


def metric_of(values: Mapping[str, Any], rows: np.ndarray) -> np.ndarray:
    """g = d2L/dw2 + s A^T A with s such that both parts are of one size, at one point."""
    width = rows.shape[1]
    mass = np.empty((width, width))
    for a in range(width):
        for b in range(a + 1):
            mass[a, b] = mass[b, a] = values[f"mass {a},{b}"]
    square = rows.T @ rows
    scale = np.trace(mass) / np.trace(square) if square.any() else 0.0
    found: np.ndarray = mass + (scale or 1.0) * square
    return found


# -- other systems for the same motion ------------------------------------------------------


def split_system(system: System, chosen: Sequence[int]) -> System:
    """The system with those velocities as its independent ones: positions among the velocities of
    the coordinates, or of a group's frame.  Claims and scenes are left out."""
    frame = system.frame
    own = [system.directions[a] for a in chosen]
    rest = tuple(x for x in system.directions if x not in own)
    title = f"{system.name}, {', '.join(map(plain_name, own))}"
    if frame is not None and frame.is_group:
        group = Frame.group(own, frame.brackets or {}, frame.rates, rest)
        return bare(system, title, frame=group)
    if system.fibration.relations:
        taken = {plain_name(s) for s in system.known_symbols()}
        dots = {_fresh(f"d{plain_name(q)}", taken): velocity(q) for q in own}
        return bare(system, title, **_spelled(system, frame), frame=Frame.quasi(dots))
    return bare(
        system,
        title,
        **_spelled(system, frame),
        frame=None,
        fibration=Fibration(tuple(own), rest),
        charts={name: _split_chart(system, chart) for name, chart in system.charts.items()},
    )


def _fresh(name: str, taken: set[str]) -> sp.Symbol:
    while name in taken:
        name += "_"
    return sp.Symbol(name)


def _spelled(
    system: System, frame: Frame | None, changes: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """Lagrangian, constraints and forces, with changes, without the quasi-velocities of a frame."""
    meaning = {} if frame is None else dict(zip(frame.velocities, frame.expressions, strict=True))
    names = ("lagrangian", "constraints", "forces")
    own = {name: getattr(system, name) for name in names} | dict(changes or {})

    def on(expr: Any) -> Any:
        return sympified(expr).xreplace(meaning)

    return {
        "lagrangian": on(own["lagrangian"]),
        "constraints": tuple(map(on, own["constraints"])),
        "forces": {q: on(e) for q, e in own["forces"].items()},
    }


def _split_chart(system: System, chart: Chart) -> Chart:
    """A chart of the system as one of its split: the velocities follow the coordinates."""
    frame = chart.changes.get("frame", system.frame)
    quasi = set() if frame is None else {plain_name(v) for v in frame.velocities}
    changes = {name: e for name, e in chart.changes.items() if name != "frame"}
    return replace(
        chart,
        state={name: e for name, e in chart.state.items() if name not in quasi},
        back={name: e for name, e in chart.back.items() if name not in quasi},
        changes=_spelled(system, frame, changes),
    )


def equations_near(system: System, near: Mapping[str, Any]) -> VoronecEquations:
    """The equations with pivots that are well conditioned at a point, numbers by name."""
    definition = read(system, near, SHARE)
    return VoronecEquations(
        system, definition, Derivation(definition, False), Derivation(definition, True)
    )
