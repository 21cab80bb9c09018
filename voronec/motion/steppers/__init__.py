"""The integrators behind one shape: a problem and a grid of times in, a run out."""

from voronec.motion.steppers.run import Halt, Problem, Run, Stepper, Suspect, cut_at_singularity

__all__ = ["Halt", "Problem", "Run", "Stepper", "Suspect", "cut_at_singularity"]
