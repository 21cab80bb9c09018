"""Errors put into a paper one at a time, and whether its audit notices them.

    python tools/mutate_paper.py [--paper NAME] [--seed N] [--count N] [--seconds S]
                                 [--section K] [--only K.N] [--sentences] [--corrections]
                                 [--least SHARE]

An error is made on the LaTeX of the paper, which is first corrected where the audit found a
misprint, so that every formula is true before.  Then what depends on it is audited again.  An error
leaves the count only if the changed formula is proved to say the same as before.  ``--only K.N``
makes error N of section K again, ``--sentences`` changes sentences of the text in place of
formulas, ``--corrections`` looks at the corrections that are proposed, and
with ``--least`` the exit status is 1 where a smaller share is noticed at the right record.
"""

from __future__ import annotations

import argparse
import collections
import random
import signal
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from latex_errors import Slip
from paper_trials import NOTICED, Page, Trial

from voronec.audit.transcript import formulas_by_label
from voronec.catalogue import load_paper

HANG = 60
"""Seconds of CPU after which a trial is given up, and counts as undecided."""
OUTCOMES = (NOTICED, "noticed elsewhere", "undecided", "survived", "became true")
AROUND = 30
"""Characters that are shown on each side of a change."""

Number = tuple[int, int]


def main() -> int:
    """Make the errors, print a line for each that is not noticed where it is, and the counts."""
    chosen = _arguments()
    pages = _pages(chosen)
    signal.signal(signal.SIGPROF, _give_up)
    print(f"seed {chosen.seed}", flush=True)
    begun, trials = time.process_time(), list[tuple[Slip, Trial]]()
    for number, page, place, slip in _chosen(chosen, pages):
        signal.setitimer(signal.ITIMER_PROF, HANG)
        try:
            trial = page.trial(place, slip, chosen.corrections)
        except TimeoutError:
            trial = Trial("undecided", f"given up after {HANG} s")
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
        trials.append((slip, trial))
        if trial.outcome != NOTICED or trial.correction == "other" or chosen.only:
            print(_line(number, page, place, slip, trial), flush=True)
        if chosen.seconds and time.process_time() - begun > chosen.seconds:
            break
    share = _summary(trials, time.process_time() - begun)
    return 1 if share < chosen.least else 0


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
    return parser.parse_args()


def _pages(chosen: argparse.Namespace) -> dict[int, Page]:
    sections = load_paper(chosen.paper).sections
    wanted = int(chosen.only.split(".")[0]) if chosen.only else chosen.section
    labels = formulas_by_label(sections)
    return {k: Page(s, labels) for k, s in enumerate(sections, start=1) if wanted in (0, k)}


def _chosen(
    chosen: argparse.Namespace, pages: dict[int, Page]
) -> Iterator[tuple[Number, Page, int, Slip]]:
    """The errors that are made, in an order drawn from the seed."""
    every = [
        ((k, n), page, place, slip)
        for k, page in pages.items()
        for n, (place, slip) in enumerate(
            page.sentence_slips() if chosen.sentences else page.slips(), start=1
        )
    ]
    if chosen.only:
        wanted = tuple(int(x) for x in chosen.only.split("."))
        yield from (one for one in every if one[0] == wanted)
        return
    random.Random(chosen.seed).shuffle(every)
    yield from every[: chosen.count]


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
    text = f"--only {number[0]}.{number[1]}  {trial.outcome}: {slip.kind} in {page.called(place)}"
    text += f"\n    {cut.old}\n    {cut.new}\n    {trial.said}"
    return text + (
        f"\n    correction ({trial.correction}): {trial.proposed}" * bool(trial.proposed)
    )


def _summary(trials: list[tuple[Slip, Trial]], seconds: float) -> float:
    """Print the counts; the share that is noticed where it is."""
    kinds = sorted({slip.kind for slip, _ in trials})
    print(f"{len(trials)} errors in {seconds:.0f} s of CPU")
    for outcome in OUTCOMES:
        found = [slip.kind for slip, trial in trials if trial.outcome == outcome]
        counts = collections.Counter(found)
        told = ", ".join(f"{counts[kind]} {kind}" for kind in kinds if counts[kind])
        print(f"{len(found):6} {outcome}: {told}")
    proposed = collections.Counter(t.correction for _, t in trials if t.correction)
    if proposed:
        told = ", ".join(f"{count} {kind}" for kind, count in proposed.most_common())
        print(f"corrections: {told}")
    counted = [trial for _, trial in trials if trial.outcome != "became true"]
    here = sum(trial.outcome == NOTICED for trial in counted)
    open_ = sum(trial.outcome == "undecided" for trial in counted)
    total = max(1, len(counted))
    print(f"{here / total:.2%} at the right record, {(here + open_) / total:.2%} that or undecided")
    return here / total


if __name__ == "__main__":
    sys.exit(main())
