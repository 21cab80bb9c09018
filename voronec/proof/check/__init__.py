"""Everything that systems declare, checked: claims, relations, squares, and what is broken."""

from voronec.proof.check.catalogue_check import (
    check_catalogue,
    check_relation,
    known_results,
    user_store,
)
from voronec.proof.check.inventory import Inventory, Trouble, graph
from voronec.proof.check.report import Finding, Report, Result, failure_line

__all__ = [
    "Finding",
    "Inventory",
    "Report",
    "Result",
    "Trouble",
    "check_catalogue",
    "check_relation",
    "failure_line",
    "graph",
    "known_results",
    "user_store",
]
