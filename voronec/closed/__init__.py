"""Motions in closed form: a declared motion and numbers make a ``ClosedForm``.

Names load on first use: pictures of this room show runs, too, that are not in closed form.
"""

from typing import TYPE_CHECKING

from voronec.algebra.lazy_names import load_on_use

if TYPE_CHECKING:
    from voronec.closed.closed_form import ClosedForm as ClosedForm
    from voronec.closed.compiled_motion import prepare as prepare
    from voronec.closed.inverted_motion import Turn as Turn
    from voronec.closed.problem import InversionProblem as InversionProblem

__all__, __getattr__, __dir__ = load_on_use(
    __name__,
    {
        "closed_form": "ClosedForm",
        "compiled_motion": "prepare",
        "inverted_motion": "Turn",
        "problem": "InversionProblem",
    },
)
