"""What ends one phase of a motion and begins the next, and what such transitions are made of: the
loop over phases, the guards that stop it, and the choice of integrators."""

from voronec.motion.methods import choose
from voronec.motion.request import Guard
from voronec.motion.solve import ZENO, Arrival, Phase, Solver, Transition
from voronec.motion.state_probe import quantities
from voronec.motion.steppers.run import restart

__all__ = [
    "ZENO", "Arrival", "Guard", "Phase", "Solver", "Transition", "choose", "quantities", "restart",
]  # fmt: skip
