"""Formulations: in which variables a motion is integrated.  Of those that hold what a scene needs
the smallest is taken."""

from voronec.motion.formulation.formulation import Formulation, dependence
from voronec.motion.formulation.model_cache import DYNAMIC_FIELDS, ModelCache, spell
from voronec.motion.formulation.smallest import (
    Model,
    ModelCandidate,
    Role,
    SmallestModels,
    smallest_model,
)
from voronec.motion.formulation.special import is_many_valued

__all__ = [
    "DYNAMIC_FIELDS", "Formulation", "Model", "ModelCache", "ModelCandidate", "Role",
    "SmallestModels", "dependence", "is_many_valued", "smallest_model", "spell",
]  # fmt: skip
