"""Figures as rows, and the pages that show them."""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import voronec as vo
from voronec.accuracy.bench import Bench

__all__ = ["Row", "Sheet", "curve", "fill", "markdown", "runs"]


@dataclass(frozen=True)
class Row:
    """One figure: what is measured, asked and reached; ``why`` is said where it is missed."""

    row: str
    asked: str
    reached: str
    good: bool
    why: str = ""

    @property
    def verdict(self) -> str:
        """In one word."""
        return "reached" if self.good else "missed"


def markdown(head: Sequence[str], lines: Iterable[Sequence[Any]]) -> str:
    """A table in Markdown."""
    first, *rows = ("| " + " | ".join(map(str, row)) + " |" for row in (head, *lines))
    return "\n".join([first, "|" + "---|" * len(head), *rows])


def _table(rows: Sequence[Row]) -> str:
    """The table of figures, and below it why some are missed, each reason once."""
    head = ("what", "asked", "reached", "verdict")
    table = markdown(head, ((r.row, r.asked, r.reached, r.verdict) for r in rows))
    missed: dict[str, list[str]] = {}
    for row in rows:
        if not row.good and row.why:
            missed.setdefault(row.why, []).append(row.row)
    if not missed:
        return table
    lines = [f"- {'; '.join(what)}. {why[0].upper()}{why[1:]}." for why, what in missed.items()]
    return "\n".join([table, "", "What is missed, and why:", "", *lines])


def runs(bench: Bench) -> str:
    """The table of the runs of a measurement."""
    head = ("method", "tolerance", "error", "µs per unit of time", "steps or evaluations")
    return markdown(
        head,
        (
            (one.name, f"{p.setting:g}", f"{p.error:.1e}", f"{1e6 * p.per_unit:.3g}", p.evaluations)
            for one in bench.methods
            for p in one.good
        ),
    )


def curve(bench: Bench, page: Path) -> str:
    """The table of the runs of a measurement; the plot is put beside the page."""
    from voronec.accuracy.bench.work_precision_picture import plot_work_precision
    from voronec.motion.pictures.run_pictures import save

    save(plot_work_precision(bench), page.with_suffix(".svg"))
    return runs(bench)


BEGIN, END = "<!-- {}: written by {} -->", "<!-- end of {} -->"


def fill(text: str, parts: Mapping[str, str], by: str) -> str:
    """A page with parts put between their marks; the rest is written by hand, and stays."""
    for name, part in parts.items():
        begin, end = BEGIN.format(name, by), END.format(name)
        before, _, rest = text.partition(begin)
        text = before + begin + "\n" + part + "\n" + end + rest.partition(end)[2]
    return text


@dataclass(frozen=True)
class Sheet:
    """Figures of one kind, and how they are measured anew.

    ``rows`` are measurements by name, ``parts`` what else the page shows, by name, each made from
    the path of the page; ``packages`` are those it names with the machine, and needs.
    """

    by: str
    rows: Mapping[str, Callable[[], Iterator[Row]]]
    parts: Mapping[str, Callable[[Path], str]]
    packages: Sequence[str]
    missed_first: bool = False

    def earlier_figures(self, page: Path) -> dict[str, Any]:
        """What earlier runs measured, from the file beside the page."""
        file = page.with_suffix(".json")
        known: dict[str, Any] = json.loads(file.read_text("utf-8")) if file.exists() else {}
        return {"rows": {}, **dict.fromkeys(self.parts, ""), **known}

    def write(self, page: Path, known: Mapping[str, Any]) -> None:
        """Put what is known between the marks of the page."""
        shown = [Row(**row) for key in self.rows for row in known["rows"].get(key, [])]
        if self.missed_first:
            shown.sort(key=lambda row: row.good)
        parts = {"figures": _table(shown), **{name: known[name] for name in self.parts}}
        parts["machine"] = f"Measured on {known['machine']}."
        page.write_text(fill(page.read_text("utf-8"), parts, self.by), "utf-8")

    def measure(self, names: Sequence[str], page: Path | None) -> list[Row]:
        """The rows of some measurements; each is put on the page as soon as it is done, so that
        Ctrl-C keeps it."""
        rows: list[Row] = []
        for name in names:
            found = _rows_of(self.rows[name]) if name in self.rows else []
            rows += found
            for row in found:
                print(f"{row.row}: {row.reached} ({row.verdict})", file=sys.stderr, flush=True)
            if page is None:
                continue
            known = self.earlier_figures(page)
            if name in self.rows:
                known["rows"][name] = [asdict(row) for row in found]
            else:
                known[name] = self.parts[name](page)
            known["machine"] = self.machine()
            page.with_suffix(".json").write_text(json.dumps(known, indent=1) + "\n", "utf-8")
            self.write(page, known)
        return rows

    def machine(self) -> str:
        """What the figures were measured on."""
        packages = ", ".join(f"{name} {version(name)}" for name in self.packages)
        load, cores = os.getloadavg()[0], os.cpu_count() or 1
        busy = f"; the machine had other work, {load:.0f} processes on {cores} cores"
        return (
            f"{platform.machine()}, Python {platform.python_version()}, {packages}"
            f"{busy if load > cores else ''}"
        )


def _rows_of(measurement: Callable[[], Iterator[Row]]) -> list[Row]:
    """The rows of one measurement; what stops it is a missed row, and the others go on."""
    try:
        return list(measurement())
    except (vo.VoronecError, ImportError, OSError, ValueError) as error:
        return [Row("a measurement", "to be measured", f"it failed: {error}", False)]


def main(about: str | None, sheet_at: Callable[[bool], Sheet]) -> int:
    """Measure, print, and exit with 1 where a figure is missed.

    ``sheet_at(short)`` has what is measured, in full or so far only that everything is called.
    """
    parser = argparse.ArgumentParser(description=(about or "").partition("\n")[0])
    names = [*sheet_at(False).rows, *sheet_at(False).parts]
    parser.add_argument("rows", nargs="*", metavar="ROW", help=f"of {', '.join(names)}")
    parser.add_argument("--page", type=Path, help="put them on a page with those measured before")
    parser.add_argument("--again", action="store_true", help="write the page from what is stored")
    parser.add_argument("--json", action="store_true", help="print the rows as JSON")
    parser.add_argument("--short", action="store_true", help="see only that all rows run")
    options = parser.parse_args()
    sheet = sheet_at(options.short)
    if unknown := [name for name in options.rows if name not in names]:
        parser.error(f"there is no row '{unknown[0]}'; rows are {', '.join(names)}")
    if options.again and options.page:
        sheet.write(options.page, sheet.earlier_figures(options.page))
        return 0
    if absent := [name for name in sheet.packages if not _is_there(name)]:
        parser.error(f"not installed: {', '.join(absent)}")
    rows = sheet.measure(options.rows or names, options.page)
    plain = [asdict(row) | {"verdict": row.verdict} for row in rows]
    told = json.dumps({"machine": sheet.machine(), "rows": plain}, indent=1)
    print(told if options.json else _table(rows))
    return 0 if all(row.good for row in rows) else 1


def _is_there(package: str) -> bool:
    try:
        return bool(version(package))
    except PackageNotFoundError:
        return False
