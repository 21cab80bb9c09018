"""Motions in closed form: a declared motion and numbers make a ``ClosedForm``."""

from voronec.closed.form import ClosedForm
from voronec.closed.prepared import prepared
from voronec.closed.problem import Problem
from voronec.closed.turns import Turn

__all__ = ["ClosedForm", "Problem", "Turn", "prepared"]
