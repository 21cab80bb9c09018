"""Everything that systems declare, checked: claims, relations, squares, and what is broken."""

from voronec.checking.inventory import Inventory, Trouble, graph
from voronec.checking.record import Finding, Report, Result, told
from voronec.checking.run import check_catalogue, known_results, user_store
from voronec.checking.single import check_relation

__all__ = [
    "Finding",
    "Inventory",
    "Report",
    "Result",
    "Trouble",
    "check_catalogue",
    "check_relation",
    "graph",
    "known_results",
    "told",
    "user_store",
]
