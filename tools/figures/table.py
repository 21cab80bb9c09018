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


@dataclass(frozen=True)
class Row:
    """One figure: what is measured, and what came of it."""

    what: str
    measured: str


def markdown(head: Sequence[str], lines: Iterable[Sequence[Any]]) -> str:
    """A table in Markdown."""
    first, *rows = ("| " + " | ".join(map(str, row)) + " |" for row in (head, *lines))
    return "\n".join([first, "|" + "---|" * len(head), *rows])


def _table(rows: Sequence[Row]) -> str:
    return markdown(("what", "measured"), ((row.what, row.measured) for row in rows))


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


def plot(bench: Bench, page: Path) -> None:
    """The plot of the runs of a measurement, put beside the page."""
    from voronec.accuracy.bench.work_precision_picture import plot_work_precision
    from voronec.motion.pictures.run_pictures import save

    save(plot_work_precision(bench), page.with_suffix(".svg"))


def picture(
    lines: Mapping[str, tuple[Sequence[float], Sequence[float]]],
    axes: tuple[str, str],
    title: str,
    page: Path,
    name: str,
) -> None:
    """Lines by name in a plot with two logarithmic axes, put beside the page as PAGE-NAME.svg; ours
    are drawn thick."""
    from voronec.accuracy.bench.work_precision_picture import COLOURS, MARKERS, SIZE
    from voronec.declaration.figure_style import figure_in_style
    from voronec.motion.pictures.run_pictures import save

    with figure_in_style(*SIZE) as figure:
        panel = figure.subplots()
        panel.set(xscale="log", yscale="log", xlabel=axes[0], ylabel=axes[1])
        for (label, line), colour, marker in zip(lines.items(), COLOURS, MARKERS, strict=False):
            thick = 1.6 if "hand" not in label else 0.8
            panel.plot(*line, label=label, color=colour, marker=marker, markersize=4, lw=thick)
        panel.grid(which="major", color="#dfe4ea", linewidth=0.5)
        panel.spines[["top", "right"]].set_visible(False)
        panel.set_title(title, fontsize=10)
        figure.legend(loc="outside right upper", fontsize=7.5, frameon=False, handlelength=2.2)
    save(figure, page.with_name(f"{page.stem}-{name}.svg"))


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

    def earlier_figures(self, page: Path) -> dict[str, Any]:
        """What earlier runs measured, from the file beside the page."""
        file = page.with_suffix(".json")
        known: dict[str, Any] = json.loads(file.read_text("utf-8")) if file.exists() else {}
        return {"rows": {}, **dict.fromkeys(self.parts, ""), **known}

    def write(self, page: Path, known: Mapping[str, Any]) -> None:
        """Put what is known between the marks of the page."""
        shown = [Row(**row) for key in self.rows for row in known["rows"].get(key, [])]
        call = f"python {self.by} {{}} --page docs/{page.name}"
        parts = {n: known[n] or f"Not measured yet: `{call.format(n)}`." for n in self.parts}
        if shown:
            parts["figures"] = _table(shown)
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
                print(f"{row.what}: {row.measured}", file=sys.stderr, flush=True)
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
    """The rows of one measurement; what stops it is said in a row, and the others go on."""
    try:
        return list(measurement())
    except (vo.VoronecError, ImportError, OSError, ValueError) as error:
        return [Row("a measurement", f"it failed: {error}")]


def main(about: str | None, sheet_at: Callable[[bool], Sheet]) -> int:
    """Measure, print, and write the page.

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
    told = {"machine": sheet.machine(), "rows": [asdict(row) for row in rows]}
    print(json.dumps(told, indent=1) if options.json else _table(rows))
    return 0


def _is_there(package: str) -> bool:
    try:
        return bool(version(package))
    except PackageNotFoundError:
        return False
