"""Numerically hard cases: a catalogue, condition numbers, references, methods judged by them.

``trials(cases)`` runs methods on cases; an error is good below the larger of 1e-10 and 100 u times
the condition number of the case (``conditioning``), u = 2^-53, and so is a refusal with a reason.
"""

from hard.case import HardCase
from hard.cases import CASES, QUICK, named_cases
from hard.reference import compute, reference
from hard.trial import CaseResult, Trial, trials

__all__ = [
    "CASES",
    "QUICK",
    "CaseResult",
    "HardCase",
    "Trial",
    "compute",
    "named_cases",
    "reference",
    "trials",
]
