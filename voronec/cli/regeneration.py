"""``voronec regenerate``: every formula of a paper beside what the engine derives.

The exit status is 1 where a formula stays undecided or is not read; a misprint that is found, with
its witness, is a result and no failure.
"""

from __future__ import annotations

import re
import shutil
from argparse import Namespace
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from voronec.cli.files import deliver, wanted_folder
from voronec.cli.output import answer, progress, progress_line
from voronec.cli.subject import is_file
from voronec.declaration.catalogue import load, load_paper, load_paper_file, names
from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from voronec.audit import Audit
    from voronec.audit.record import Record


def execute(arguments: Namespace) -> int:
    """Audit, tell of each section when it is done and of the errors at the end, and write the
    report where a folder is given."""
    from voronec.audit import Cache, Paper, audit_paper

    folder = None if arguments.out is None else wanted_folder(arguments.out)
    paper = (
        load_paper_file(arguments.paper)
        if is_file(arguments.paper)
        else load_paper(arguments.paper)
    )
    if not isinstance(paper, Paper):
        raise DefinitionError(f"the PAPER of '{arguments.paper}' is not a voronec.audit.Paper")
    cache = None if arguments.fresh else Cache.of_user()
    files: list[Path] = []
    failure: DefinitionError | None = None
    stage = None if arguments.json or arguments.label else _Sections(paper.title)
    with progress_line(f"{paper.name}: deriving what the paper speaks of ..."):
        audit = audit_paper(paper, _announce, cache, arguments.label, stage)
        try:
            if folder is not None:
                files = deliver(folder, lambda to: _write(audit, arguments.paper, to))
        except DefinitionError as error:  # the verdicts are told all the same
            failure = error
    answer(arguments.json, audit.as_list, _lines(audit, arguments, folder, files))
    if failure is not None:
        raise failure
    return 1 if audit.count()["undecided"] + audit.count()["not read"] else 0


class _Sections:
    """Tells of each section when it is done, in a line below the title of the paper."""

    def __init__(self, paper: str) -> None:
        self._heading = f"{paper}\nevery formula is derived and compared with print:"

    def __call__(self, title: str, records: Sequence[Record]) -> None:
        progress("")
        if self._heading:
            print(self._heading)
            self._heading = ""
        counts = Counter(r.verdict for r in records)
        told = ", ".join(f"{n} {verdict}" for verdict, n in counts.items())
        print(f"  {title}: {told or 'nothing to prove'}", flush=True)


def _lines(
    audit: Audit, arguments: Namespace, folder: Path | None, files: list[Path]
) -> Iterator[str]:
    """The errors on one screen, or, of a single label or where details are wanted, all; and what to
    do now."""
    from voronec.audit.page.report import audit_summary, audit_table

    width = shutil.get_terminal_size((100, 24)).columns
    whole = arguments.label or arguments.details
    yield "\n" + (audit_table if whole else audit_summary)(audit, width)
    command = f"voronec regenerate {arguments.paper}"
    if folder is not None and files:
        others = ", ".join(f.name for f in files if f.suffix != ".html")
        yield f"open {folder / 'report.html'}: each formula, derived and as printed"
        yield f"beside it: {others}"
    elif not arguments.label:
        yield f"{command} --out DIR writes a page with all of it"
    if not (arguments.label or arguments.details):
        yield f"{command} --details prints a line a formula; --label L one of them whole"
    if arguments.paper in names():
        yield (f"voronec derive {arguments.paper} prints the equations; voronec run "
               f"{arguments.paper} integrates and draws a motion")  # fmt: skip


def _announce(place: str, verdict: str) -> None:
    progress(f"{place}: {verdict}")


def _write(audit: Audit, name: str, workshop: Path) -> None:
    from voronec.audit.page.report import write_audit

    write_audit(audit, workshop, _figures(name, workshop))


def _figures(name: str, workshop: Path) -> list[Any]:
    """The system's own drawing of its scene ``default``, where it has both."""
    from voronec.audit.page.report import Figure

    system = load(name) if name in names() else None
    if system is None or system.drawing is None or "default" not in system.scenes:
        return []
    from voronec.motion import integrate
    from voronec.motion.pictures.run_pictures import drawing, save

    progress(f"{name}: integrating the scene 'default'")
    path = workshop / "trace.svg"
    save(drawing(integrate(system, scene="default")), path)
    path.write_text(round_paths(path.read_text("utf-8")), "utf-8")
    return [Figure(path, system.scenes["default"].caption)]


def round_paths(svg: str) -> str:
    """A picture with its paths to a hundredth of a point: finer ones show nowhere, and are a third
    of the page that carries them."""
    path = re.compile(r'(?<=\sd=")[^"]*')
    number = re.compile(r"\d+\.\d{3,}")
    return path.sub(lambda d: number.sub(lambda n: f"{float(n[0]):.2f}", d[0]), svg)
