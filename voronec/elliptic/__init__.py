"""Inversion of elliptic integrals: ``(dx/dt)^2 = f(x)`` with f of degree up to 4, and integrals.

Everything exact enough on demand: constants and enclosures as balls of any number of bits.
"""

from voronec.elliptic.constants import (
    Constants,
    Integral,
    LogTerm,
    Numbers,
    Pole,
    Source,
    ThetaPhase,
)
from voronec.elliptic.roots import Ends, Root, ends_of
from voronec.elliptic.solution import Enclosed, Solution, invert

__all__ = [
    "Constants",
    "Enclosed",
    "Ends",
    "Integral",
    "LogTerm",
    "Numbers",
    "Pole",
    "Root",
    "Solution",
    "Source",
    "ThetaPhase",
    "ends_of",
    "invert",
]
