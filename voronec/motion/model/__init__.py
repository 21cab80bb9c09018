"""Model only what a scene needs: from wanted outputs to the smallest set of equations."""

from voronec.motion.model.smallest import Candidate, Model, Role, SmallestModels, smallest_model

__all__ = ["Candidate", "Model", "Role", "SmallestModels", "smallest_model"]
