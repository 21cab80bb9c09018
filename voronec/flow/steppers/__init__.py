"""The integrators behind one shape: a problem and a grid of times in, a run out."""

from voronec.flow.steppers.choice import METHODS, choose
from voronec.flow.steppers.run import Halt, Problem, Run, Stepper, Suspect, guarded

__all__ = ["METHODS", "Halt", "Problem", "Run", "Stepper", "Suspect", "choose", "guarded"]
