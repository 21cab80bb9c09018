"""A system with functions that its author left open, at an example of them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef

from voronec import System, time
from voronec.declaration.claims import without_claims


def fill_functions(system: System) -> System:
    """The system with a trigonometric polynomial for each unknown function of one coordinate,
    without claims; itself where there is none."""
    declared = (system.lagrangian, *system.constraints)
    functions = sorted({f for e in declared for f in e.atoms(AppliedUndef)}, key=str)
    known = {f: _example(k, f.args[0]) for k, f in enumerate(functions) if f.args != (time,)}
    if not known:
        return system

    def read(expr: Any) -> Any:
        return sp.sympify(expr).subs(known).doit()

    frame = system.frame
    if frame is not None:
        frame = replace(frame, expressions=tuple(map(read, frame.expressions)))
    return replace(
        system,
        lagrangian=read(system.lagrangian),
        constraints=tuple(map(read, system.constraints)),
        forces={x: read(e) for x, e in system.forces.items()},
        frame=frame,
        **{**without_claims(), "invariants": {n: read(e) for n, e in system.invariants.items()}},
    )


def _example(number: int, x: sp.Expr) -> sp.Expr:
    """Even about the poles, and so a smooth function on a sphere: a convex body's support."""
    return 1 + sp.cos(x) / (4 + number) + sp.cos(x) ** 2 / (9 + number)
