"""First integrals found by exact linear algebra over an ansatz."""

from voronec.proof.search.result import FoundIntegral, IntegralSearch
from voronec.proof.search.search import search_integrals, searches

__all__ = ["FoundIntegral", "IntegralSearch", "search_integrals", "searches"]
