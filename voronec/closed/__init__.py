"""Motions in closed form: a declared motion and numbers make a ``ClosedForm``."""

from voronec.closed.closed_form import ClosedForm
from voronec.closed.compiled_motion import prepared
from voronec.closed.problem import InversionProblem
from voronec.closed.rotation_numbers import Turn

__all__ = ["ClosedForm", "InversionProblem", "Turn", "prepared"]
