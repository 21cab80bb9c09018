"""Integrals that a system has by its form, whoever has declared others."""

from __future__ import annotations

from contextlib import suppress

import symengine as se
import sympy as sp

from voronec.algebra.shape import operations
from voronec.algebra.symbols import plain_name
from voronec.declaration.claims import right_of
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import EngineLimit

LEAF = "leaf function"
"""What names of leaf functions begin with."""
SHORT = 100
"""Constraints of more operations are long: what is looked for in them takes up to a minute."""


def natural_integrals(equations: VoronecEquations) -> dict[str, sp.Expr]:
    """The energy, the momenta of cyclic coordinates and leaf functions, by names, where no
    integral is declared that is as well one of these.

        E = sum v dL/dv - L        where nothing holds the time, constraints are linear in v, and
                                   forces do no work
        p_q = dL/dqdot             where neither L nor relations hold q, no constraint qdot, and no
                                   force is along q
        functions that integrable constraints hold constant (``VoronecEquations.leaves``), where
                                   constraints are short
    """
    return equations.memo.once("natural integrals", lambda: _find(equations))


def _find(equations: VoronecEquations) -> dict[str, sp.Expr]:
    d, system = equations.definition, equations.system
    if d.group is not None or d.added:
        return {}
    integrals, bound = dict[str, sp.Expr](), (d.constraints, d.differentiated)
    momenta = [d.lagrangian.diff(v) for v in d.dots]
    held = {s for e in (d.lagrangian, *d.relations) for s in e.free_symbols}
    names = map(plain_name, system.coordinates)
    rows = zip(names, d.coordinates, momenta, d.forces, strict=True)
    for i, (name, q, p, force) in enumerate(rows):
        pushed = any(row[i] != 0 for forms in bound for row in forms.matrix)
        if p != 0 and force == 0 and q not in held and not pushed:
            integrals[f"momentum of {name}"] = d.bridge.outward(p)
    if keeps_energy(equations):
        energy = se.Add(*[v * p for v, p in zip(d.dots, momenta, strict=True)]) - d.lagrangian
        integrals["energy"] = d.bridge.outward(energy)
    still_names = {*system.coordinates, *(p.symbol for p in system.parameters)}
    declared = [right_of(e) for e in system.integrals.values()]
    if (
        system.constraints
        and not is_long(equations)
        and not any(e.free_symbols <= still_names for e in declared)
    ):
        with suppress(EngineLimit):
            integrals |= {f"{LEAF} {i}": e for i, e in enumerate(equations.leaves, 1)}
    return {name: e for name, e in integrals.items() if name not in system.integrals}


def is_long(equations: VoronecEquations) -> bool:
    """Whether the constraints are long."""
    return operations([e for row in equations.definition.constraints.matrix for e in row]) > SHORT


def keeps_energy(equations: VoronecEquations) -> bool:
    """Whether the energy is constant by the form of the system, as it stands above."""
    d = equations.definition
    if d.group is not None or d.added:
        return False
    bound = (d.constraints, d.differentiated)
    entries = (e for forms in bound for row in forms.matrix for e in row)
    power = se.expand(se.Add(*[f * v for f, v in zip(d.forces, d.dots, strict=True)]))
    return (
        power == 0
        and all(c == 0 for forms in bound for c in forms.offset)
        and not any(d.time in e.free_symbols for e in (d.lagrangian, *d.relations, *entries))
    )
