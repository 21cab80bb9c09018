"""Two derivations side by side: two systems, or a stored one and today's."""

from voronec.comparison.derived import Derived, read_derived
from voronec.comparison.points import is_general, random_point
from voronec.comparison.side_by_side import Comparison, compare

__all__ = ["Comparison", "Derived", "compare", "is_general", "random_point", "read_derived"]
