"""``voronec cite``: the references of a system as BibTeX."""

from __future__ import annotations

from argparse import Namespace

from voronec.cli.declaration import declaration
from voronec.cli.output import print_json, warn
from voronec.declaration.bibliography import bibtex

__all__ = ["execute"]


def execute(arguments: Namespace) -> int:
    """Print the entries in the order in which the system names them."""
    data, folder = declaration(arguments.system)
    entries = bibtex(data["references"], folder)
    if arguments.json:
        print_json([{"key": key, "bibtex": text} for key, text in entries.items()])
    elif entries:
        print("\n\n".join(entries.values()))
    else:
        warn(f"system '{data['name']}' names no references")
    return 0
