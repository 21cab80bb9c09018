"""Formulations: in which variables a motion is integrated.  Of those that hold what a scene needs
the smallest is taken."""

from voronec.motion.formulation.formulation import (
    Formulation,
    dependence,
    keep_relations,
    needed_variables,
    restrict,
)
from voronec.motion.formulation.model_cache import DYNAMIC_FIELDS, ModelCache, spell
from voronec.motion.formulation.smallest import (
    Model,
    ModelCandidate,
    Role,
    SmallestModels,
    smallest_model,
)
from voronec.motion.formulation.special import constants, is_many_valued

__all__ = [
    "DYNAMIC_FIELDS", "Formulation", "Model", "ModelCache", "ModelCandidate", "Role",
    "SmallestModels", "constants", "dependence", "is_many_valued", "keep_relations",
    "needed_variables", "restrict", "smallest_model", "spell",
]  # fmt: skip
