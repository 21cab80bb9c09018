"""Formulations: in which variables a motion is integrated.  Of those that hold what a scene needs
the smallest is taken."""

from voronec.motion.formulation.smallest import (
    Model,
    ModelCandidate,
    Role,
    SmallestModels,
    smallest_model,
)

__all__ = ["Model", "ModelCandidate", "Role", "SmallestModels", "smallest_model"]
