"""One verdict for several comparisons."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import voronec as vo
from voronec.audit import Verdict


def worst(verdicts: Iterable[Verdict]) -> Verdict:
    """The first verdict that is not a proof, and then no further one is made; else the last."""
    found = Verdict("undecided", "nothing is compared")
    for verdict in verdicts:
        found = verdict
        if not verdict.proved:
            break
    return found


def all_equal(pairs: Iterable[tuple[Any, Any]], relations: Sequence[Any] = ()) -> Verdict:
    """Whether the two of each pair are equal."""
    return worst(vo.prove_equal(a, b, relations) for a, b in pairs)


def all_zero(values: Iterable[Any]) -> Verdict:
    """Whether all values vanish."""
    return worst(vo.prove_equal(value) for value in values)
