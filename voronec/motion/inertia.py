"""Parameters that are zero and leave a velocity without inertia: its acceleration is 0/0."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError
from voronec.motion.state_probe import Probe, quantities

__all__ = ["require_inertia"]

PLACES, AWAY = 3, 0.3
"""At the start and so many places about it, so far apart, the mass matrix is looked at."""
SINGULAR = 1e-12
"""The least eigenvalue of a singular mass matrix, in units of its largest."""


def require_inertia(
    equations: VoronecEquations, constants: Mapping[str, float], state: np.ndarray, time: float
) -> None:
    """Refuse parameters that are zero where they make the mass matrix singular everywhere.

    ``state`` (n,) is the start on the coordinates.  Each of the equations mass * vdot = force may
    then be cancelled before the parameter is put in, or after: the answers differ, so there is
    none.  A matrix that is singular at the start alone is another matter: charts may help.  What
    was found regular stays so, and is kept with the equations.
    """
    zero = [p.name for p in equations.system.parameters if constants.get(p.name) == 0]
    regular = equations.memo.once("regular without", set)
    if not zero or not equations.system.velocities or frozenset(zero) in regular:
        return
    if not _singular(equations, constants, state, time):
        regular.add(frozenset(zero))
        return
    guilty = [
        name for name in zero if not _singular(equations, {**constants, name: 1.0}, state, time)
    ]
    if not guilty and _singular(equations, {**constants, **dict.fromkeys(zero, 1.0)}, state, time):
        return  # that is not their fault
    named = ", ".join(f"{name} = 0" for name in guilty or zero)
    raise DefinitionError(
        f"system '{equations.system.name}': for {named} the mass matrix is singular everywhere, so "
        "the accelerations are 0/0; give other values, or leave out what has no inertia"
    )


def _singular(
    equations: VoronecEquations, constants: Mapping[str, float], state: np.ndarray, time: float
) -> bool:
    """Whether the mass matrix is singular at the start and about it."""
    form = equations.raw.form
    values = [constants.get(str(p), np.nan) for p in form.parameters]
    probe = Probe(equations.system.name, form, quantities(form, {}), values, time)
    random = np.random.default_rng(0)  # any numbers will do, the same every time
    about = state + AWAY * random.standard_normal((PLACES, len(state)))
    masses = probe.masses(np.full(PLACES + 1, time), np.vstack([state, about]))
    if not np.isfinite(masses).all():
        return False
    sizes = np.abs(np.linalg.eigvalsh(masses))
    return bool((sizes.min(axis=1) <= SINGULAR * sizes.max(axis=1)).all())
