"""Numerically hard cases: a catalogue, condition numbers, references, methods judged by them.

``trials(cases)`` runs methods on cases; an error is good below the larger of 1e-10 and 100 u times
the condition number of the case (``conditioning``), u = 2^-53, and so is a refusal with a reason.
"""

from voronec.accuracy.hard.case import HardCase
from voronec.accuracy.hard.cases import CASES, QUICK, every_case, named_cases
from voronec.accuracy.hard.reference import compute, reference
from voronec.accuracy.hard.trial import CaseResult, Trial, trials

__all__ = [
    "CASES",
    "QUICK",
    "CaseResult",
    "HardCase",
    "Trial",
    "compute",
    "every_case",
    "named_cases",
    "reference",
    "trials",
]
