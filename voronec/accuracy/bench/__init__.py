"""Speed against error: every method of ours against a reference of proved accuracy.

``scene_problem`` makes a problem of a scene, ``reference`` its motion by two independent runs,
``measure`` a ``Bench`` of all methods, ours unless others are given as ``Contender``s.
"""

from voronec.accuracy.bench.call_time import CallStages, SetupTime, measure_calls, measure_setup
from voronec.accuracy.bench.contender import Contender, NotHere, Outcome, time_fastest
from voronec.accuracy.bench.measurement import At, Bench, Measured, Point, at_error, observed_order
from voronec.accuracy.bench.runs import OWN, contenders, measure
from voronec.accuracy.problem import ReferenceProblem, scene_problem
from voronec.accuracy.reference import reference
from voronec.accuracy.solution import ReferenceSolution, difference

__all__ = [
    "OWN",
    "At",
    "Bench",
    "CallStages",
    "Contender",
    "Measured",
    "NotHere",
    "Outcome",
    "Point",
    "ReferenceProblem",
    "ReferenceSolution",
    "SetupTime",
    "at_error",
    "contenders",
    "difference",
    "measure",
    "measure_calls",
    "measure_setup",
    "observed_order",
    "reference",
    "scene_problem",
    "time_fastest",
]
