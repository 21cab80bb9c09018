"""Model only what a scene needs: from wanted outputs to the smallest set of equations."""

from voronec.motion.model.smallest import (
    Model,
    ModelCandidate,
    Role,
    SmallestModels,
    smallest_model,
)

__all__ = ["Model", "ModelCandidate", "Role", "SmallestModels", "smallest_model"]
