"""What a steady motion is called: rest, permanent rotation, uniform rolling."""

from __future__ import annotations

from typing import Any

import numpy as np
import symengine as se

from voronec.algebra.terms import atoms
from voronec.dynamics.joint_function import JointFunction
from voronec.dynamics.newton import solve
from voronec.dynamics.steady_equations import constants_of
from voronec.equations.attitudes import euler_angles
from voronec.equations.program.straight import fresh_names, share_subexpressions
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import VoronecError

STILL = 1e-9
"""Rates below this part of the largest velocity are zero."""


def kind_of(motion: Any) -> str:
    """``rest`` where nothing moves; ``permanent rotation`` where angles alone do: coordinates that
    stand under sines alone, or are Euler's angles; ``uniform rolling`` where coordinates of the
    fibre move, as constraints ask whose coefficients hold parameters, such as a radius; else
    ``steady motion``."""
    if motion.is_rest:
        return "rest"
    equations = motion.motions.equations
    d, rates = equations.definition, _coordinate_rates(motion)
    if rates is None or d.group is not None:
        return "steady motion"
    size = np.abs(rates).max(initial=0.0)
    moving = [q for q, rate in zip(d.coordinates, rates, strict=True) if abs(rate) > STILL * size]
    if {*moving} <= _angles(equations):
        return "permanent rotation"
    rolling = any(q in moving and c.free_symbols & {*d.parameters}
                  for row in d.constraints.matrix
                  for q, c in zip(d.coordinates[: d.base], row, strict=False))  # fmt: skip
    rolls = rolling and {*moving} & {*d.coordinates[d.base :]}
    return "uniform rolling" if rolls else "steady motion"


def _angles(equations: VoronecEquations) -> set[Any]:
    """Coordinates that stand under sines and cosines alone, or are Euler's angles."""
    d = equations.definition
    exprs = [d.lagrangian, *d.forces, *(c for row in d.constraints.matrix for c in row)]
    sines = atoms(exprs, se.sin, se.cos)
    blank = {f: se.Symbol(f"sine {i}") for i, f in enumerate(sines)}
    bare = {s for e in exprs for s in e.xreplace(blank).free_symbols}
    under = {s for f in sines for s in f.free_symbols} & {*d.coordinates}
    return under - bare | {x for t in euler_angles(equations) for x in t.symbols}


def _coordinate_rates(motion: Any) -> np.ndarray | None:
    """The rates of all coordinates at some place of the motion: the variables leave cyclic ones
    open; None where no place is found."""
    equations, form = motion.equations, motion.motions.equations.raw.form
    formulation = equations.formulation
    names = [*map(str, (*equations.rates.state, *constants_of(formulation)))]
    start = {str(x): e for x, e in formulation.start.items()}
    values = {**equations.values, **motion.point}
    targets = np.array([float(values[n]) for n in names])

    def make() -> JointFunction:
        symbols = (*form.coordinates, *form.velocities, *form.parameters)
        rows = share_subexpressions(
            [*(start[n] for n in names), *form.rates], fresh_names([form.time, *symbols], "h")
        )
        return JointFunction.of(form.time, symbols, rows, symbols[: -len(form.parameters) or None])

    try:
        function: JointFunction = equations.memo.once("places", make).with_values(values)
    except VoronecError:
        return None

    def off(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        outputs, slopes = function.at(x)
        return outputs[: len(names)] - targets, slopes[: len(names)]

    here = [float(values.get(str(x), 0.4 + i / 7)) for i, x in enumerate(function.unknowns)]
    place = solve(off, np.array(here), np.ones(len(here)))
    return None if place is None else function.at(place)[0][len(names) :]
