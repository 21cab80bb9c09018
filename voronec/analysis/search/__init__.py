"""First integrals found by exact linear algebra over an ansatz."""

from voronec.analysis.search.result import FoundIntegral, IntegralSearch
from voronec.analysis.search.search import search_integrals, searches

__all__ = ["FoundIntegral", "IntegralSearch", "search_integrals", "searches"]
