"""The integrators behind one shape: a problem and a grid of times in, a run out."""

from voronec.motion.steppers.run import (
    Problem,
    Run,
    Solver,
    Suspect,
    Termination,
    cut_at_singularity,
)

__all__ = ["Problem", "Run", "Solver", "Suspect", "Termination", "cut_at_singularity"]
