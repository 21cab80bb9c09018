"""Errors put into a paper one at a time, and whether its audit notices them.

    python tools/paper.py errors [--paper NAME] [--seed N] [--count N] [--seconds S]
                                 [--section K] [--only K.N] [--sentences] [--corrections]
                                 [--least SHARE] [--jobs N]

An error is made on the LaTeX of the paper, which is first corrected where the audit found a
misprint, so that every formula is true before.  Then what depends on it is audited again.  An error
leaves the count only if the changed formula is proved to say the same as before.  ``--only K.N``
makes error N of section K again, ``--sentences`` changes sentences of the text in place of
formulas, and
with ``--least`` the exit status is 1 where a smaller share is noticed at the right record.
``--jobs`` says how many processes share the work; the counts do not depend on it.

``--corrections`` looks at what the audit proposes to read for each formula that is noticed.  A
proposal restores what stood there, is proved to be equivalent to it, is another true formula, or is
senseless (``papers.proposals``).  Those of the last two kinds are printed.  The search for a
correction has a time of its own, so that it changes nothing of what is noticed.
"""

from __future__ import annotations

import argparse
import collections
import multiprocessing
import random
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache, partial
from typing import Any, NamedTuple

from papers.latex_errors import Slip
from papers.proposals import Proposal, judge
from papers.trials import HIT, OPEN, Fault, Page, Trial
from voronec.audit.transcript import formulas_by_label
from voronec.declaration.catalogue import load_paper

HANG = 60
"""Seconds of CPU after which a trial is given up, and counts as undecided."""
SEARCH = 30
"""Seconds of CPU after which the search for a correction is given up."""
OUTCOMES = (HIT, "noticed elsewhere", *OPEN, "survived", "became true")
AROUND = 30
"""Characters that are shown on each side of a change."""

TOGETHER = 60
"""Errors of one section that a process makes at a time: what they share is derived once."""

Number = tuple[int, int]
Task = tuple[int, list[int]]


class Outcome(NamedTuple):
    """The kind of an error, what became of it, and the kind of the correction, if it was sought."""

    kind: str
    outcome: str
    proposal: str


UNLIKE = ("another", "senseless")
"""Kinds of proposals that are printed."""


def main() -> int:
    """Make the errors, print a line for each that is not noticed where it is, and the counts."""
    chosen = _arguments()
    print(f"seed {chosen.seed}", flush=True)
    tasks, trials, seconds = _tasks(chosen), list[Outcome](), 0.0
    with multiprocessing.get_context("fork").Pool(chosen.jobs) as pool:
        try:
            for lines, found, spent in pool.imap_unordered(partial(_work, chosen), tasks):
                print("".join(f"{line}\n" for line in lines), end="", flush=True)
                trials += found
                seconds += spent
                if chosen.seconds and seconds > chosen.seconds:
                    break
        except KeyboardInterrupt:
            print("interrupted", flush=True)
    share = _summary(trials, seconds)
    return 1 if share < chosen.least else 0


def _work(chosen: argparse.Namespace, task: Task) -> tuple[list[str], list[Outcome], float]:
    """What is printed of some errors of one section, their outcomes, and the seconds of CPU."""
    section, numbers = task
    begun, lines, found = time.process_time(), list[str](), list[Outcome]()
    page = _page(chosen.paper, section)
    every = _slips(page, chosen.sentences)
    for n in numbers:
        place, slip = every[n - 1]
        try:
            with _limit(HANG):
                trial = page.trial(place, slip)
        except TimeoutError:
            trial = Trial("undecided", f"given up after {HANG} s")
        proposal = _proposal(trial.fault) if chosen.corrections else None
        found.append(Outcome(slip.kind, trial.outcome, proposal.kind if proposal else ""))
        if trial.outcome != HIT or found[-1].proposal in UNLIKE or chosen.only:
            lines.append(_line((section, n), page, place, slip, trial))
            lines += [f"    correction ({proposal.words}): {proposal.latex}"] if proposal else []
    return lines, found, time.process_time() - begun


@contextmanager
def _limit(seconds: float) -> Iterator[None]:
    """Raise ``TimeoutError`` after some seconds of CPU."""
    signal.signal(signal.SIGPROF, _give_up)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)


def _proposal(fault: Fault | None) -> Proposal | None:
    """What is proposed for a formula that was noticed, and what it is worth."""
    if fault is None:
        return None
    try:
        with _limit(SEARCH):
            latex = fault.correction()
    except TimeoutError:
        return Proposal(f"not found within {SEARCH} s")
    return Proposal("none found") if latex is None else judge(latex, fault)


@cache
def _page(paper: str, section: int) -> Page:
    """A section of a paper, made once in each process."""
    sections = load_paper(paper).sections
    return Page(sections[section - 1], formulas_by_label(sections))


def _slips(page: Page, sentences: bool) -> list[tuple[int, Slip]]:
    return list(page.sentence_slips() if sentences else page.slips())


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--paper", default="demchenko")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=3000)
    parser.add_argument("--seconds", type=float, default=0.0, help="of CPU; 0 for no limit")
    parser.add_argument("--section", type=int, default=0, help="its number; 0 for all")
    parser.add_argument("--only", default="", help="one error, as it is numbered in the output")
    parser.add_argument("--sentences", action="store_true")
    parser.add_argument("--corrections", action="store_true")
    parser.add_argument("--least", type=float, default=0.0)
    parser.add_argument("--jobs", type=int, default=1)
    return parser.parse_args()


def _tasks(chosen: argparse.Namespace) -> list[Task]:
    """The errors that are made, drawn by the seed: some of one section at a time."""
    if chosen.only:
        section, number = (int(x) for x in chosen.only.split("."))
        return [(section, [number])]
    count = len(load_paper(chosen.paper).sections)
    sections = [k for k in range(1, count + 1) if chosen.section in (0, k)]
    every = [
        (k, n)
        for k in sections
        for n, _ in enumerate(_slips(_page(chosen.paper, k), chosen.sentences), start=1)
    ]
    random.Random(chosen.seed).shuffle(every)
    drawn: dict[int, list[int]] = {}
    for k, n in every[: chosen.count]:
        drawn.setdefault(k, []).append(n)
    return [
        (k, numbers[i : i + TOGETHER])
        for i in range(0, max(map(len, drawn.values()), default=0), TOGETHER)
        for k, numbers in sorted(drawn.items())
        if i < len(numbers)
    ]


def _give_up(*_: Any) -> None:
    raise TimeoutError


@dataclass(frozen=True)
class _Cut:
    """The part of a text in which two differ."""

    old: str
    new: str

    @classmethod
    def between(cls, old: str, new: str) -> _Cut:
        start = next((i for i, (a, b) in enumerate(zip(old, new, strict=False)) if a != b), 0)
        end = 0
        while end < min(len(old), len(new)) - start and old[-1 - end] == new[-1 - end]:
            end += 1
        a = max(0, start - AROUND)
        cut = [text[a : len(text) - max(0, end - AROUND)] for text in (old, new)]
        return cls(*(" ".join(text.split()) for text in cut))


def _line(number: Number, page: Page, place: int, slip: Slip, trial: Trial) -> str:
    cut = _Cut.between(page.latex(place), slip.latex)
    text = f"--only {number[0]}.{number[1]}  {trial.outcome}: {slip.kind} in {page.name_of(place)}"
    return f"{text}\n    {cut.old}\n    {cut.new}\n    {trial.said}"


def _summary(trials: list[Outcome], seconds: float) -> float:
    """Print the counts; the share that is noticed where it is."""
    kinds = sorted({trial.kind for trial in trials})
    print(f"{len(trials)} errors in {seconds:.0f} s of CPU")
    for outcome in OUTCOMES:
        found = [trial.kind for trial in trials if trial.outcome == outcome]
        counts = collections.Counter(found)
        words = ", ".join(f"{counts[kind]} {kind}" for kind in kinds if counts[kind])
        print(f"{len(found):6} {outcome}: {words}")
    proposals = collections.Counter(trial.proposal for trial in trials if trial.proposal)
    if proposals:
        words = ", ".join(f"{count} {kind}" for kind, count in proposals.most_common())
        print(f"corrections: {words}")
    counted = [trial for trial in trials if trial.outcome != "became true"]
    here = sum(trial.outcome == HIT for trial in counted)
    open_ = sum(trial.outcome in OPEN for trial in counted)
    total = max(1, len(counted))
    print(f"{here / total:.2%} at the right record, {(here + open_) / total:.2%} that or open")
    return here / total
