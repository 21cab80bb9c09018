"""Two derivations side by side: two systems, or a stored one and today's."""

from voronec.proof.comparison.derived import Derived, is_general, random_point, read_derivation
from voronec.proof.comparison.side_by_side import Comparison, compare

__all__ = ["Comparison", "Derived", "compare", "is_general", "random_point", "read_derivation"]
