"""What the reader must know of a paper before it reads."""

from __future__ import annotations

from dataclasses import dataclass

from voronec.audit.latex.tokens import FUNCTIONS

CALL = r"(\cdot)"
r"""Ends the spelling of a name that is a function where a parenthesis follows it, and something
else where none does: the dictionary holds ``\zeta`` and ``\zeta(\cdot)``."""


@dataclass(frozen=True)
class LatexVocabulary:
    r"""What the reader must know beforehand about a paper's names.

    ``functions``: heads that a parenthesis applies.  ``labelled``: heads whose superscript is a
    label, not an exponent.  ``numbered``: heads whose superscript may be a Roman numeral, which is
    a label too.  ``wide_sums``: a sum sign reaches to the end of its group, not only over the next
    term.  ``primes``: a prime is a derivative by the time, and no part of a name.
    ``narrow_functions``: as the paper writes throughout, a function without a parenthesis takes
    the one name behind it, ``\sin u v`` is (sin u) v.  ``variations``, ``differentials``:
    ``\delta``, or ``d``, before a name makes a variation, or a differential, of it, and is no name
    itself.
    """

    functions: frozenset[str] = frozenset()
    labelled: frozenset[str] = frozenset()
    numbered: frozenset[str] = frozenset()
    wide_sums: bool = False
    primes: bool = False
    narrow_functions: bool = False
    variations: bool = True
    differentials: bool = True

    def applies(self, head: str) -> bool:
        """Whether a parenthesis after this head holds arguments; primes mean derivatives."""
        if head in FUNCTIONS:
            return True
        plain = head.rstrip("'")
        spelled = (head, head + CALL, plain, plain + CALL)
        return any(name in self.functions for name in spelled)
