"""What ends one phase of a motion and begins the next, and what such transitions are made of: the
loop over phases, the guards that stop it, and the choice of integrators.  The transitions load on
first use: few motions have each of them."""

from typing import TYPE_CHECKING

from voronec.algebra.lazy_names import load_on_use
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

_loaded_on_use, __getattr__, _names = load_on_use(
    __name__,
    {
        "charts": "through_charts",
        "modes": "SwitchedIntegrator is_switched through_switching_surfaces",
    },
)

__all__ = [
    "ZENO", "Arrival", "Guard", "Phase", "Solver", "SwitchedIntegrator", "Transition",
    "choose", "is_switched", "quantities", "restart", "through_charts",
    "through_switching_surfaces",
]  # fmt: skip
