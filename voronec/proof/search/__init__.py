"""What a system preserves, found by exact linear algebra: integrals, measures, multipliers,
symmetries, gauge momenta; and the proof that there are no further rational integrals."""

from voronec.proof.search.densities import (
    DensitySearch,
    search_measures,
    search_reducing_multipliers,
)
from voronec.proof.search.gauge import GaugeSearch, search_gauge_momenta
from voronec.proof.search.rational import RationalBound, exclude_rational_integrals
from voronec.proof.search.result import FoundIntegral, IntegralSearch
from voronec.proof.search.search import search_integrals, searches
from voronec.proof.search.symmetries import SymmetrySearch, search_symmetries

__all__ = [
    "DensitySearch",
    "FoundIntegral",
    "GaugeSearch",
    "IntegralSearch",
    "RationalBound",
    "SymmetrySearch",
    "exclude_rational_integrals",
    "search_gauge_momenta",
    "search_integrals",
    "search_measures",
    "search_reducing_multipliers",
    "search_symmetries",
    "searches",
]
