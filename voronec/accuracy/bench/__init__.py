"""Speed against error: every method and every peer, against a reference of proved accuracy.

``ask`` makes a question of a scene, ``reference`` its answer by two independent runs, ``measure``
a ``Bench`` of all methods.  Peers are optional: what is not installed is named, never needed.
"""

from voronec.accuracy.bench.agreement import reference
from voronec.accuracy.bench.call_time import CallStages, SetupTime, measure_calls, measure_setup
from voronec.accuracy.bench.measurement import At, Bench, Measured, Point, at_error, observed_order
from voronec.accuracy.bench.question import ask
from voronec.accuracy.bench.runs import CONTENDERS, measure
from voronec.accuracy.problem import ReferenceProblem
from voronec.accuracy.reference import ReferenceSolution, difference

__all__ = [
    "CONTENDERS",
    "At",
    "Bench",
    "CallStages",
    "Measured",
    "Point",
    "ReferenceProblem",
    "ReferenceSolution",
    "SetupTime",
    "ask",
    "at_error",
    "difference",
    "measure",
    "measure_calls",
    "measure_setup",
    "observed_order",
    "reference",
]
