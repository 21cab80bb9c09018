"""Model only what a scene needs: from wanted outputs to the smallest set of equations."""

from voronec.model.model import Candidate, Model, Role
from voronec.model.smallest import smallest_model

__all__ = ["Candidate", "Model", "Role", "smallest_model"]
