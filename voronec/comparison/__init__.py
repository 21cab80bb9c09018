"""Two derivations side by side: two systems, or a stored one and today's."""

from voronec.comparison.compare import Comparison, compare
from voronec.comparison.derived import Derived, read_derived
from voronec.comparison.points import is_general, random_point

__all__ = ["Comparison", "Derived", "compare", "is_general", "random_point", "read_derived"]
