"""What the reader must know of a paper before it reads."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Vocabulary"]


@dataclass(frozen=True)
class Vocabulary:
    """What the reader must know beforehand about a paper's names.

    ``functions``: heads that a parenthesis applies.  ``labelled``: heads whose superscript is a
    label, not an exponent.  ``wide_sums``: a sum sign reaches to the end of its group, not only
    over the next term.
    """

    functions: frozenset[str] = frozenset()
    labelled: frozenset[str] = frozenset()
    wide_sums: bool = False
