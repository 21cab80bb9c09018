"""Equations for readers: LaTeX, and plain data for JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import sympy as sp

from voronec.algebra.symbols import plain_name, velocity
from voronec.algebra.typeset import latex_of, plain_text
from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from voronec.equations import VoronecEquations

__all__ = ["equations_dict", "equations_latex"]


def equations_latex(eqs: VoronecEquations) -> str:
    """Kinematic equations, then mass * vdot = force row by row, as an ``aligned`` block."""
    lines = []
    for q, rate in zip(eqs.coordinates, eqs.rates, strict=True):
        if velocity(q) != rate:
            lines.append(f"{_latex(eqs, velocity(q))} &= {_latex(eqs, rate)}")
    dots = sp.Matrix([velocity(v) for v in eqs.velocities])
    for row, force in zip((eqs.mass * dots), eqs.force, strict=True):
        lines.append(f"{_latex(eqs, row)} &= {_latex(eqs, force)}")
    body = " \\\\\n  ".join(lines)
    return f"\\begin{{aligned}}\n  {body}\n\\end{{aligned}}"


def _latex(eqs: VoronecEquations, expr: sp.Expr) -> str:
    return latex_of(expr, eqs.coordinates, eqs.velocities)


def equations_dict(eqs: VoronecEquations) -> dict[str, Any]:
    """What was derived: names, kind, growth, coefficients, curvature, mass, force, rates.

    For a system beyond the exact normal form, the Python source of its program instead.
    """
    base, fibre = eqs.definition.split
    coordinates = [plain_name(q) for q in eqs.coordinates]
    data: dict[str, Any] = {
        "system": eqs.system.name,
        "base": base,
        "fibre": fibre,
        "velocities": [plain_name(v) for v in eqs.velocities],
        "parameters": [p.name for p in eqs.system.parameters],
        "kind": eqs.kind,
        "growth": list(eqs.growth),
        "integrable_constraints": [i + 1 for i in eqs.integrable],
        "normal_form": eqs.in_normal_form,
    }
    if not eqs.in_normal_form:  # written out, a shared graph is endless
        return data | {"program": _program(eqs), "operations": eqs.operations}
    data |= {
        "rates": dict(zip(coordinates, map(plain_text, eqs.rates), strict=True)),
        "mass": [[plain_text(e) for e in eqs.mass.row(i)] for i in range(eqs.mass.rows)],
        "force": [plain_text(e) for e in eqs.force],
        "left": [plain_text(e) for e in eqs.left],
        "right": [plain_text(e) for e in eqs.right],
        "lagrangian_on_constraints": plain_text(eqs.theta),
        "momenta": dict(zip(fibre, map(plain_text, eqs.momenta), strict=True)),
    }
    if eqs.has_coordinate_frame:
        data["coefficients"] = _coefficients(eqs, fibre, base)
        data["curvature"] = _curvature(eqs, fibre, base)
    return data


def _program(eqs: VoronecEquations) -> str | None:
    """Python source, where the system holds no unknown function."""
    try:
        return eqs.python()
    except DefinitionError:
        return None


def _coefficients(eqs: VoronecEquations, fibre: list[str], base: list[str]) -> dict[str, Any]:
    matrix, offset = eqs.coefficients
    return {
        name: {
            **{b: plain_text(matrix[nu, i]) for i, b in enumerate(base)},
            "1": plain_text(offset[nu]),
        }
        for nu, name in enumerate(fibre)
    }


def _curvature(eqs: VoronecEquations, fibre: list[str], base: list[str]) -> dict[str, Any]:
    a = eqs.curvature
    table: dict[str, Any] = {}
    for nu, name in enumerate(fibre):
        entries = {
            f"{p},{q}": plain_text(a[nu, i, j])
            for i, p in enumerate(base)
            for j, q in enumerate(base)
            if i < j
        }
        entries |= {f"{p},t": plain_text(a.time[nu, i]) for i, p in enumerate(base)}
        table[name] = {key: value for key, value in entries.items() if value != "0"}
    return table
