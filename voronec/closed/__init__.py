"""Motions in closed form: a declared motion and numbers make a ``ClosedForm``.

Names load on first use: pictures of this room show runs, too, that are not in closed form.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from voronec.closed.closed_form import ClosedForm
    from voronec.closed.compiled_motion import prepare
    from voronec.closed.inverted_motion import Turn
    from voronec.closed.problem import InversionProblem

__all__ = ["ClosedForm", "InversionProblem", "Turn", "prepare"]

_HOME = {
    "ClosedForm": "closed_form",
    "InversionProblem": "problem",
    "Turn": "inverted_motion",
    "prepare": "compiled_motion",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'voronec.closed' has no attribute '{name}'")
    return getattr(import_module(f"voronec.closed.{_HOME[name]}"), name)
