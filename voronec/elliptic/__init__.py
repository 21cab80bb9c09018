"""Inversion of elliptic integrals: ``(dx/dt)^2 = f(x)`` with f of degree up to 4, and integrals.

Everything exact enough on demand: constants and enclosures as balls of any number of bits.
"""

from voronec.elliptic.constants import Constants, Integral, LogTerm, Numbers, Phase, Pole, Source
from voronec.elliptic.roots import Ends, Root, ends_of
from voronec.elliptic.solution import Enclosed, Solution, invert

__all__ = [
    "Constants",
    "Enclosed",
    "Ends",
    "Integral",
    "LogTerm",
    "Numbers",
    "Phase",
    "Pole",
    "Root",
    "Solution",
    "Source",
    "ends_of",
    "invert",
]
