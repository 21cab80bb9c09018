"""Motions: a system, its initial data and a grid of times make a ``Trajectory``.

Names load on first use: the table of methods is read where nothing is integrated.
"""

from typing import TYPE_CHECKING

from voronec.algebra.lazy_names import load_on_use

if TYPE_CHECKING:
    from voronec.motion.ensembles import Ensemble as Ensemble
    from voronec.motion.ensembles import ensemble as ensemble
    from voronec.motion.inputs import Sampled as Sampled
    from voronec.motion.inputs import Table as Table
    from voronec.motion.prepared_problem import PreparedProblem as PreparedProblem
    from voronec.motion.prepared_problem import integrate as integrate
    from voronec.motion.prepared_problem import prepare as prepare
    from voronec.motion.request import Event as Event
    from voronec.motion.sections import Section as Section
    from voronec.motion.sections import section as section
    from voronec.motion.trajectory import Cost as Cost
    from voronec.motion.trajectory import Crossings as Crossings
    from voronec.motion.trajectory import Trajectory as Trajectory

__all__, __getattr__, __dir__ = load_on_use(
    __name__,
    {
        "ensembles": "Ensemble ensemble",
        "inputs": "Sampled Table",
        "prepared_problem": "PreparedProblem integrate prepare",
        "request": "Event",
        "sections": "Section section",
        "trajectory": "Cost Crossings Trajectory",
    },
)
