"""The integrators behind one shape: a problem and a grid of times in, a run out."""

from voronec.motion.steppers.run import (
    Integrator,
    Problem,
    Run,
    Suspect,
    Termination,
    cut_at_singularity,
)

__all__ = ["Integrator", "Problem", "Run", "Suspect", "Termination", "cut_at_singularity"]
