"""The bibliography: BibTeX entries by key, from ``docs/references.bib`` or beside a plugin."""

from __future__ import annotations

import re
from collections.abc import Iterable
from importlib import resources
from pathlib import Path

from voronec.errors import DefinitionError

__all__ = ["bibtex", "read_entries"]

FILE = "references.bib"
_START = re.compile(r"^@(\w+)\{([^,\s]+),", re.MULTILINE)


def bibtex(keys: Iterable[str], folder: Path | None = None) -> dict[str, str]:
    """Key -> BibTeX entry, in the order of the keys.

    Looked up in ``references.bib`` of ``folder``, where a plugin brings its own, then in that of
    the project.  Raises ``DefinitionError`` for a key that neither has.
    """
    known = read_entries(resources.files("voronec.docs").joinpath(FILE).read_text("utf-8"))
    own = folder / FILE if folder is not None else None
    if own is not None and own.is_file():
        known |= read_entries(own.read_text("utf-8"))
    wanted = list(keys)
    for key in wanted:
        if key not in known:
            raise DefinitionError(f"the reference '{key}' is not in {own or FILE}; add its entry")
    return {key: known[key] for key in wanted}


def read_entries(text: str) -> dict[str, str]:
    """The entries of a BibTeX text by key; an entry ends where its braces are balanced."""
    found = {}
    for start in _START.finditer(text):
        depth = 0
        for at in range(start.start(), len(text)):
            depth += {"{": 1, "}": -1}.get(text[at], 0)
            if depth == 0 and text[at] == "}":
                found[start[2]] = text[start.start() : at + 1]
                break
        else:
            raise DefinitionError(f"the reference '{start[2]}' has unbalanced braces; close them")
    return found
