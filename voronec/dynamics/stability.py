"""Linear stability of the steady motions of a system, over a quantity."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from voronec.algebra.arguments import COUNT, SEVERAL, VALUES, accepts
from voronec.declaration.system import System
from voronec.dynamics.families import SteadyFamily
from voronec.dynamics.steady import steady
from voronec.equations.voronec_equations import VoronecEquations


@accepts(at=VALUES, parameters=VALUES, free=SEVERAL, count=COUNT, starts=COUNT, seed=COUNT)
def stability(
    system: System | VoronecEquations,
    over: Any,
    between: Any,
    at: Mapping[Any, Any] | None = None,
    parameters: Mapping[Any, Any] | None = None,
    free: Any = (),
    hold: Any = (),
    count: int = 100,
    starts: int = 100,
    seed: int = 1,
) -> SteadyFamily:
    """Spectra and critical values of a family of steady motions over a quantity.

    The motion that ``steady`` finds with ``at``, ``parameters`` and ``free`` - one that moves,
    where there is one - is followed over ``over`` as ``SteadyMotion.along`` does; all arguments,
    and what is raised, are those of the two.
    """
    found = steady(system, at, parameters, free, starts, seed)
    motion = next((m for m in found if not m.is_rest), found[0])
    return motion.along(over, between, hold, count)
