"""The outputs that somebody types: names of a system's quantities, and formulas in them."""

from __future__ import annotations

import re
from typing import Any

from voronec.algebra.text import formula
from voronec.errors import DefinitionError

__all__ = ["outputs_of"]

WORDS = r"[^\W\d]\w*(?: \w+)*"
"""Names, such as u1 or 'momentum squared'; anything else is a formula."""

BETWEEN = r",(?![^()]*\))"
"""Commas that are not between the arguments of a function."""


def outputs_of(text: str | None) -> tuple[Any, ...]:
    """Names and expressions, parted by commas; empty where nothing is said."""
    if text is None:
        return ()
    parts = [part.strip() for part in re.split(BETWEEN, text)]
    if not all(parts):
        raise DefinitionError(f"--outputs '{text}': give names parted by commas, such as u,v")
    return tuple(p if re.fullmatch(WORDS, p) else formula(p, "--outputs") for p in parts)
