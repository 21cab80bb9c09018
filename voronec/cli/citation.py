"""``voronec cite``: the references of a system as BibTeX."""

from __future__ import annotations

from argparse import Namespace

from voronec.cli.declaration import declaration
from voronec.cli.output import answer, warn
from voronec.declaration.bibliography import bibtex


def execute(arguments: Namespace) -> int:
    """Print the entries in the order in which the system names them."""
    data, folder = declaration(arguments.system)
    entries = bibtex(data["references"], folder)
    answer(
        arguments.json,
        lambda: [{"key": key, "bibtex": text} for key, text in entries.items()],
        ["\n\n".join(entries.values())] if entries else [],
    )
    if not (entries or arguments.json):
        warn(f"system '{data['name']}' names no references")
    return 0
