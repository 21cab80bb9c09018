"""What ends one phase of a motion and begins the next, and what such transitions are made of: the
loop over phases, the guards that stop it, and the choice of integrators.  The transitions load on
first use: few motions have each of them."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from voronec.motion.methods import choose
from voronec.motion.request import Guard
from voronec.motion.solve import ZENO, Arrival, Phase, Solver, Transition
from voronec.motion.state_probe import quantities
from voronec.motion.steppers import restart

if TYPE_CHECKING:
    from voronec.motion.transitions.charts import through_charts as through_charts
    from voronec.motion.transitions.modes import SwitchedIntegrator as SwitchedIntegrator
    from voronec.motion.transitions.modes import is_switched as is_switched
    from voronec.motion.transitions.modes import (
        through_switching_surfaces as through_switching_surfaces,
    )

_HOME = {
    "through_charts": "charts", "SwitchedIntegrator": "modes", "is_switched": "modes",
    "through_switching_surfaces": "modes",
}  # fmt: skip

__all__ = [
    "ZENO", "Arrival", "Guard", "Phase", "Solver", "SwitchedIntegrator", "Transition",
    "choose", "is_switched", "quantities", "restart", "through_charts",
    "through_switching_surfaces",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
