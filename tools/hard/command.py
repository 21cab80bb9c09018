"""Every integrator on numerically hard cases: ``python tools/bench.py hard [CASE ...]``.

Prints the rows of every case when they are there.  The status is 1 where the tool's own choice is
wrong without saying so; stopped by Ctrl-C, what is done is reported all the same.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

import voronec as vo
from hard.case import HardCase
from hard.cases import CASES, QUICK, named_cases
from hard.page import data, head, lines, page, summary
from hard.trial import CaseResult, trials
from voronec.algebra.columns import columns
from voronec.cli.files import deliver, wanted_folder
from voronec.cli.output import answer, progress, wrote
from voronec.errors import did_you_mean
from voronec.motion.methods import METHODS


def main() -> int:
    """Run, print the rows, and say whether all is well."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("cases", nargs="*", metavar="CASE", help="only these cases (all)")
    parser.add_argument(
        "--method", action="append", default=[], metavar="M",
        help=f"auto, default, {', '.join(METHODS)}; may be given several times",
    )  # fmt: skip
    parser.add_argument("--quick", action="store_true", help="a short selection of the cases")
    parser.add_argument("--list", action="store_true", help="list the cases without running them")
    parser.add_argument("--out", metavar="DIR", help="write hard-cases.md and hard.json there")
    parser.add_argument("--json", action="store_true", help="print the result as JSON")
    chosen = parser.parse_args()
    try:
        return _execute(chosen)
    except vo.VoronecError as error:
        parser.error(str(error))


def _execute(chosen: argparse.Namespace) -> int:
    folder = wanted_folder(chosen.out) if chosen.out else None
    names = chosen.cases or (QUICK if chosen.quick else ())
    cases = named_cases(names, CASES) if names else CASES
    if chosen.list:
        rows = [{"case": c.name, "system": c.system, "hard": c.hard} for c in cases]
        answer(chosen.json, lambda: rows, columns([*row.values()] for row in rows))
        return 0
    findings, stopped = _run(cases, _methods(chosen.method), chosen.json)
    _tell(findings, folder, chosen.json)
    if stopped:
        print(f"stopped, {len(findings)} of {len(cases)} cases done", file=sys.stderr)
        return 130
    return 0 if all(f.good for f in findings) else 1


def _methods(names: Sequence[str]) -> tuple[str, ...]:
    for name in names:
        if name not in ("auto", "default", *METHODS):
            raise vo.DefinitionError(f"there is no method '{name}'{did_you_mean(name, METHODS)}")
        if name in METHODS and METHODS[name].absence:
            raise vo.DefinitionError(f"method '{name}': {METHODS[name].absence}; leave it out")
    return tuple(dict.fromkeys(names))


def _run(
    cases: Sequence[HardCase], methods: tuple[str, ...], as_json: bool
) -> tuple[list[CaseResult], bool]:
    """The findings, and whether Ctrl-C ended the run."""
    findings: list[CaseResult] = []
    try:
        for finding in trials(cases, methods, progress):
            progress("")
            if not as_json:
                rows = lines(finding, cases)
                print("\n".join(rows if findings else [head(cases), *rows]), flush=True)
            findings.append(finding)
    except KeyboardInterrupt:
        progress("")
        return findings, True
    progress("")
    return findings, False


def _tell(findings: Sequence[CaseResult], folder: Path | None, as_json: bool) -> None:
    found = [data(f) for f in findings]

    def write(workshop: Path) -> None:
        (workshop / "hard-cases.md").write_text(page(findings), "utf-8")
        (workshop / "hard.json").write_text(json.dumps(found, indent=2), "utf-8")

    answer(as_json, lambda: found, [summary(findings)])
    files = [] if folder is None else deliver(folder, write)
    if not as_json:
        answer(as_json, list, wrote(files))
