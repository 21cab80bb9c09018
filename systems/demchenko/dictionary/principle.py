"""d'Alembert's principle, made from a Lagrangian and the constraints alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Motion


def forced_motion(eqs: Any, variations: Sequence[sp.Symbol]) -> Motion:
    """The motion of a system with arbitrary forces: some of them give any accelerations."""
    free = {vo.velocity(v): vo.velocity(v) for v in eqs.velocities}
    motion = Motion.of(eqs, {d: vo.velocity(d) for d in variations})
    return replace(motion, accelerations=free)


def lagrange(lagrangian: sp.Expr, coordinates: Sequence[sp.Symbol]) -> tuple[sp.Expr, ...]:
    """d/dt dL/dqdot_s - dL/dq_s for every s, no constraint in force."""
    velocities = [vo.velocity(q) for q in coordinates]
    rates = {x: vo.velocity(x) for x in (*coordinates, *velocities)}
    free = Motion(rates)
    return tuple(
        free.derivative(sp.diff(lagrangian, v)) - sp.diff(lagrangian, q)
        for q, v in zip(coordinates, velocities, strict=True)
    )


def dalembert(
    left: Sequence[sp.Expr], rates: Sequence[sp.Expr], base: int, motion: Motion
) -> tuple[sp.Expr, ...]:
    """sum_s left_s dqdot_s/dqdot_i for the ``base`` first coordinates, on the constraints.

    ``rates`` are the velocities on the constraints.  The accelerations of the fibre are eliminated
    by the differentiated constraints; the connection is not made use of.
    """
    slopes = [[sp.diff(rate, v) for v in rates[:base]] for rate in rates]
    accelerations = {
        vo.velocity(v): motion.derivative(rate) for v, rate in motion.constrained.items()
    }
    rows = sp.Matrix(slopes).T * sp.Matrix(left)
    return tuple(motion.restrict(row.xreplace(accelerations)) for row in rows)
