"""``voronec hard``: methods against numerically hard cases."""

from __future__ import annotations

import json
import sys
from argparse import Namespace
from typing import TYPE_CHECKING

from voronec.algebra.columns import columns
from voronec.cli.files import deliver, wanted_folder
from voronec.cli.output import answer, progress, warn, wrote
from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from voronec.accuracy.hard import CaseResult, HardCase


def execute(arguments: Namespace) -> int:
    """Run, print the rows of every case when they are there, and say whether all is well.

    Stopped by Ctrl-C, what is done is reported all the same.
    """
    folder = wanted_folder(arguments.out) if arguments.out else None
    cases = _choose_cases(arguments)
    if arguments.list:
        return _list(cases, arguments.json)
    methods = _methods(arguments.method)
    findings, stopped = _run(cases, methods, arguments.json)
    if not findings and stopped:
        raise KeyboardInterrupt
    _tell(findings, folder, arguments.json)
    if stopped:
        print(f"voronec: stopped, {len(findings)} of {len(cases)} cases done", file=sys.stderr)
        return 130
    return 0 if all(f.good for f in findings) else 1


def _choose_cases(arguments: Namespace) -> tuple[HardCase, ...]:
    from voronec.accuracy.hard import QUICK, every_case, named_cases

    known, warnings = every_case()
    for message in warnings:
        warn(message)
    names = arguments.cases or (QUICK if arguments.quick else ())
    return named_cases(names, known) if names else known


def _list(cases: Sequence[HardCase], as_json: bool) -> int:
    answer(
        as_json,
        lambda: [{"case": c.name, "system": c.system, "hard": c.hard} for c in cases],
        columns([c.name, c.system, c.hard] for c in cases),
    )
    return 0


def _methods(names: Sequence[str]) -> tuple[str, ...]:
    from voronec.errors import did_you_mean
    from voronec.motion.methods import METHODS

    for name in names:
        if name not in ("auto", "default", *METHODS):
            raise DefinitionError(f"there is no method '{name}'{did_you_mean(name, METHODS)}")
        if name in METHODS and METHODS[name].absence:
            raise DefinitionError(f"method '{name}': {METHODS[name].absence}; leave it out")
    return tuple(dict.fromkeys(names))


def _run(
    cases: Sequence[HardCase], methods: tuple[str, ...], as_json: bool
) -> tuple[list[CaseResult], bool]:
    """The findings, and whether Ctrl-C ended the run."""
    from voronec.accuracy.hard.page import head, lines
    from voronec.accuracy.hard.trial import trials

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
    from voronec.accuracy.hard.page import data, page, summary

    records = [data(f) for f in findings]

    def write(workshop: Path) -> None:
        (workshop / "hard-cases.md").write_text(page(findings), "utf-8")
        (workshop / "hard.json").write_text(json.dumps(records, indent=2), "utf-8")

    answer(as_json, lambda: records, [summary(findings)])
    files = [] if folder is None else deliver(folder, write)
    if not as_json:
        answer(as_json, list, wrote(files))
