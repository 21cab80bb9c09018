"""Everything that systems declare, checked: claims, relations, squares, and what is broken."""

from voronec.checking.inventory import Inventory, Trouble, graph
from voronec.checking.record import Finding, Report, Result
from voronec.checking.run import check_catalogue

__all__ = [
    "Finding",
    "Inventory",
    "Report",
    "Result",
    "Trouble",
    "check_catalogue",
    "graph",
]
