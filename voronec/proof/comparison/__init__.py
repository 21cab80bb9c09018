"""Two derivations side by side: two systems, or a stored one and today's."""

from voronec.proof.comparison.side_by_side import Comparison, compare
from voronec.proof.comparison.stored_derivation import (
    StoredDerivation,
    is_general,
    random_point,
    read_derivation,
)

__all__ = [
    "Comparison",
    "StoredDerivation",
    "compare",
    "is_general",
    "random_point",
    "read_derivation",
]
