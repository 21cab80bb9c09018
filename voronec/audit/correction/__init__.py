"""The small change that makes a refuted formula true, found by numbers and proved exactly."""

from __future__ import annotations

from voronec.audit.correction.changes import Spare, close_brackets
from voronec.audit.correction.mending import Correction, correct

__all__ = ["Correction", "Spare", "close_brackets", "correct"]
