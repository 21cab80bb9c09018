"""``voronec check``: everything that systems declare, proved or refuted."""

from __future__ import annotations

import re
import sys
from argparse import Namespace
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from voronec.algebra.columns import columns
from voronec.cli.output import answer, progress, progress_line
from voronec.cli.subject import is_file, name_in
from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from voronec.proof.check import Finding, Report, Result


def execute(arguments: Namespace) -> int:
    """Check, print the table, tell the failures one by one; what Ctrl-C leaves is printed too."""
    from voronec.proof.check import Inventory, check_catalogue, failure_line, user_store

    if arguments.jobs is not None and arguments.jobs < 1:
        raise DefinitionError(f"--jobs {arguments.jobs}: give a number from 1 upward")
    stock = Inventory.of(filter(is_file, arguments.names))
    names = [name_in(stock, subject) for subject in arguments.names]
    store = None if arguments.fresh else user_store()
    with progress_line():
        report = check_catalogue(names, stock, arguments.jobs, store, progress)
    answer(arguments.json, report.as_dict, _lines(report))
    sys.stdout.flush()
    for result, finding in report.failures:
        print(f"voronec: {failure_line(result, finding)}", file=sys.stderr)
    if report.stopped:
        raise KeyboardInterrupt
    return 0 if report.passed else 1


def _lines(report: Report) -> Iterator[str]:
    for title in ("system", "relation", "square"):
        results = report.of_kind(title)
        if results:
            yield from (f"{title}s", *columns(_rows(results), "  "), "")
    yield _summary(report)


def _rows(results: Sequence[Result]) -> Iterator[list[str]]:
    """A line for each result, and one for each claim of it; of what is carried, the number."""
    for result in results:
        took = "known" if result.reused else f"{result.seconds:.2f} s"
        claims, carried = _split_findings(result)
        notes = list(result.notes)
        notes += [f"carries {_count_words(len(carried), 'claim')}"] if carried else []
        name = shorten_square(result.name) if result.kind == "square" else result.name
        yield [result.status, took, name + (f"  ({'; '.join(notes)})" if notes else "")]
        for finding in (*claims, *(f for f in carried if f.status != "proved")):
            remark = _remark(finding)
            told = f"    {finding.kind} {finding.name}" + (f"  {remark}" if remark else "")
            yield [finding.status, "", told]


def shorten_square(label: str) -> str:
    """A square in fewer words: the chain ``a -> b, b -> c`` as ``a -> b -> c``."""
    return re.sub(r"(?<= -> )([^,=>]+), (?=\1 -> )", "", label)


def _split_findings(result: Result) -> tuple[list[Finding], list[Finding]]:
    """The claims of a system, or whatever is told apart; and what a relation carries."""
    carried = [f for f in result.findings if f.kind.startswith("carried ")]
    claims = [f for f in result.findings if f not in carried]
    if result.kind != "system" or (len(claims) == 1 and claims[0].name == result.name):
        claims = [f for f in claims if f.admitted]  # the first line says it all
    return claims, carried


def _remark(finding: Finding) -> str:
    if finding.admitted and not finding.stale:
        return f"admitted: {finding.admitted}"
    return finding.remark if finding.status == "proved" else _shorten(finding.how)


def _shorten(text: str, most: int = 60) -> str:
    text = " ".join(text.split())
    return text if len(text) <= most else text[: most - 3].rstrip() + "..."


def _summary(report: Report) -> str:
    """One line: how much was checked, and what came out."""
    parts = [
        _count_words(len(report.of_kind(kind)), kind) for kind in ("system", "relation", "square")
    ]
    parts.insert(1, _count_words(sum(len(r.findings) for r in report.of_kind("system")), "claim"))
    failing = sum(1 for _ in report.failures)
    end = _count_words(failing, "failure") if failing else "nothing failed"
    end += ", stopped before the end" if report.stopped else ""
    return f"{', '.join(parts)}: {end}; {report.seconds:.1f} s"


def _count_words(number: int, word: str) -> str:
    return f"{number} {word}{'s' * (number != 1)}"
