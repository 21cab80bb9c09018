"""Directions in which coordinates change though nothing moves: where coordinates are singular.

At a pole of angles two of them turn about one axis.  A chart f that is regular there tells such
directions apart: with q' = f(q) they are the null vectors of df/dq.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import symengine as se
import sympy as sp

from voronec.declaration.charts import Chart
from voronec.equations.attitudes import euler_angles
from voronec.equations.voronec_equations import VoronecEquations
from voronec.motion.split_models import SplitGround, numbers
from voronec.motion.state_probe import quantities

__all__ = ["POLE", "blind_directions", "charted_directions", "open_beyond", "polar_directions"]

POLE = 1e-6
"""At a pole of angles sines, and parts of unit vectors that vanish there, are below this."""


def blind_directions(ground: SplitGround, wide: np.ndarray) -> np.ndarray:
    """An orthonormal basis (N, k) of the directions in which coordinates may change at a wide state
    though nothing moves; k is zero where coordinates are regular."""
    if ground.home.definition.group is not None:
        return np.zeros((len(ground.home.definition.dots), 0))
    found = [polar_directions(ground.home, wide), charted_directions(ground, wide)]
    vectors, sizes, _ = np.linalg.svd(np.hstack(found), full_matrices=False)
    return np.asarray(vectors[:, sizes > POLE])


def polar_directions(equations: VoronecEquations, state: np.ndarray) -> np.ndarray:
    """Directions (N, k), of unit length, in which Euler's angles may change at their poles while
    the attitude stays; k is zero where a state (coordinates first) is at none.

    Rz(phi) Rx(c) Rz(s psi) knows only phi + s psi where c = 0, and phi - s psi where c = pi.
    """
    d, found = equations.definition, []
    for angles in euler_angles(equations):
        first, middle, last = (d.coordinates.index(x) for x in angles.symbols)
        polar = float(state[middle]) + float(angles.shift)
        if abs(np.sin(polar)) < POLE:
            direction = np.zeros(len(d.dots))
            direction[first], direction[last] = 1.0, -angles.sense * np.cos(polar)
            found.append(direction / np.linalg.norm(direction))
    return np.array(found).reshape(-1, len(d.dots)).T


def charted_directions(ground: SplitGround, wide: np.ndarray) -> np.ndarray:
    """An orthonormal basis (N, k) of what the declared chart that is best at a wide state does not
    see; k is zero where the system's own coordinates are regular, or no chart is."""
    system = ground.home.system
    none = np.zeros((len(ground.home.definition.dots), 0))
    if ground.home.definition.group is not None:
        return none
    if not any(_may_be_singular(ground, chart, wide) for chart in system.charts.values()):
        return none  # as of most starts: no slopes are derived
    looked = [_distances(ground, chart, wide) for chart in system.charts.values()]
    own, there, slopes = max(looked, key=lambda found: found[1], default=(1.0, 0.0, none))
    if not own < POLE or not there > POLE:
        return none
    _, sizes, basis = np.linalg.svd(slopes)
    return np.asarray(basis[sizes < POLE * sizes.max()].T)


def _may_be_singular(ground: SplitGround, chart: Chart, wide: np.ndarray) -> bool:
    """Whether the own coordinates may be singular at a wide state, where a chart is declared."""
    d = ground.home.definition
    at = {se.Symbol(name): se.RealDouble(float(x)) for name, x in ground.constants.items()}
    at |= {q: se.RealDouble(float(x)) for q, x in zip(d.coordinates, wide, strict=False)}
    try:
        return abs(float(d.door.inward(chart.singular).xreplace(at).n(real=True))) < POLE
    except (ArithmeticError, RuntimeError, TypeError, ValueError):
        return True  # of the time, or no number there: the slopes tell


def open_beyond(rows: np.ndarray, blind: np.ndarray) -> np.ndarray:
    """Directions (N, k) that conditions with such rows leave open, less their parts along blind
    ones; what is left is small where nothing that moves is open."""
    sizes = np.linalg.norm(rows, axis=1, keepdims=True)
    _, values, basis = np.linalg.svd(rows / np.where(sizes > 0, sizes, 1.0))
    rank = int((values > POLE * values.max(initial=0.0)).sum())
    ways = basis[rank:].T
    return np.asarray(ways - blind @ (blind.T @ ways))


def _distances(ground: SplitGround, chart: Chart, wide: np.ndarray) -> tuple[float, float, Any]:
    """How far a wide state is from the singularities of the own coordinates and of a chart, 0 where
    the chart has no value, and df/dq."""
    d, system = ground.home.definition, ground.home.system
    values = chart.values(system)
    images = dict(
        zip(d.coordinates, (d.door.inward(values[q]) for q in system.coordinates), strict=True)
    )
    wanted = [d.door.inward(chart.singular), d.door.inward(chart.singular_there).xreplace(images)]
    # slopes as sympy has them: x/(x^2 + y^2) of an arctangent is defined where x or y is zero
    own = system.coordinates
    wanted += [d.door.inward(sp.diff(values[q], x)) for q in own for x in own]
    program = quantities(ground.wide, {str(i): se.sympify(e) for i, e in enumerate(wanted)})
    try:
        flat = numbers(program, ground.time, wide.astype(float).tolist(), ground.values(program))
    except ArithmeticError:
        return 1.0, 0.0, None
    singular, there, *slopes = map(float, flat)
    if not np.isfinite(slopes).all():
        return abs(singular), 0.0, None
    return abs(singular), abs(there), np.array(slopes).reshape(len(images), -1)
