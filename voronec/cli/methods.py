"""``voronec methods``: one problem by every method, and the proofs that they agree."""

from __future__ import annotations

from argparse import Namespace

from voronec.cli.output import answer, progress_line
from voronec.cli.subject import resolve


def execute(arguments: Namespace) -> int:
    """Print each method with its equations, then the proofs; 1 unless all are proved."""
    system, _ = resolve(arguments.system)
    from voronec.audit.lessons.methods import by_methods

    with progress_line(f"{system.name}: the equations by six methods ..."):
        comparison = by_methods(system)
        lines = [] if arguments.json else [str(comparison)]
    answer(arguments.json, comparison.as_dict, lines)
    return 0 if comparison.proved else 1
