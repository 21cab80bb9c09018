"""The integrators behind one shape: a problem and a grid of times in, a run out."""

from voronec.motion.steppers.choice import choose
from voronec.motion.steppers.run import Halt, Problem, Run, Stepper, Suspect, guarded

__all__ = ["Halt", "Problem", "Run", "Stepper", "Suspect", "choose", "guarded"]
