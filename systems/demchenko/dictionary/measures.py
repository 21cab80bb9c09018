"""Invariant measures of vector fields, found and proved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import shorten

Flow = Mapping[sp.Expr, sp.Expr]


def density(base: sp.Expr, flow: Flow, point: Mapping[sp.Expr, sp.Expr], volume: Any = 1) -> Any:
    """The power of ``base`` that can be a density, if any: base^p times the ``volume``.

    div(volume base^p X) = 0 reads p X(base)/base = -div(volume X)/volume; that gives p at one
    point.  Whether the same p does everywhere remains to be proved.
    """
    growth = sp.Add(*[sp.diff(base, x) * rate for x, rate in flow.items()])
    power = -base * vo.divergence(volume, flow) / (volume * growth)
    return base ** shorten([power.xreplace(dict(point))])[0]


def quadratic(value: sp.Expr, unit: sp.Matrix, relations: Sequence[sp.Expr]) -> sp.Expr:
    """A function of a unit vector as a diagonal quadratic form in it, where it is one."""
    form = sp.Integer(0)
    for x in unit:
        axis = {y: sp.Integer(x == y) for y in unit}
        form += shorten([value.xreplace(axis)])[0] * x**2
    return form if vo.prove_equal(value, form, relations).proved else value
