"""``voronec compare``: two systems, or a stored derivation and today's, entry by entry."""

from __future__ import annotations

from argparse import Namespace
from collections import Counter
from collections.abc import Iterator
from typing import TYPE_CHECKING

from voronec.algebra.columns import columns
from voronec.cli.output import answer, progress, progress_line
from voronec.cli.subject import resolve

if TYPE_CHECKING:
    from voronec.proof.comparison import Comparison, StoredDerivation


def execute(arguments: Namespace) -> int:
    """Print what is the same and where the two differ."""
    from voronec.proof.comparison import compare

    with progress_line():
        first, second = (_side(subject) for subject in (arguments.first, arguments.second))
        progress(f"comparing '{first.name}' and '{second.name}'")
        comparison = compare(first, second)
    answer(arguments.json, comparison.as_dict, _lines(comparison))
    return 0 if comparison.equal else 1


def _side(subject: str) -> StoredDerivation:
    from voronec.equations.voronec_equations import derive
    from voronec.proof.comparison import StoredDerivation, read_derivation

    if subject.endswith(".json"):
        return read_derivation(subject)
    system, _ = resolve(subject)
    progress(f"deriving '{system.name}'")
    return StoredDerivation.of(derive(system))


def _lines(found: Comparison) -> Iterator[str]:
    yield f"{found.first} and {found.second}"
    yield ""
    yield from columns(_summary(found), "  ")
    for row in (*found.rewritten_rows, *found.differences):
        where = f" where {row.domain}" if row.domain else ""
        yield from ("", f"{row.group} {row.name}: {row.status}{where}")
        for name, text in ((found.first, row.first), (found.second, row.second)):
            yield f"  {name}: {text.replace('**', '^') or '-'}"
        if row.status != "proved" and row.how:
            yield f"  {row.how}"
    yield ""
    if found.deviations:
        yield "largest differences along the scene 'default'"
        yield from columns(([x, f"{d:.1e}"] for x, d in found.deviations.items()), "  ")
    elif found.remark:
        yield f"no motions compared: {found.remark}"
    yield found.outcome


def _summary(found: Comparison) -> Iterator[list[str]]:
    """For each group, how many entries came out how."""
    for group in dict.fromkeys(row.group for row in found.rows):
        count = Counter(row.status for row in found.rows if row.group == group)
        yield [group, ", ".join(f"{n} {status}" for status, n in count.items())]
