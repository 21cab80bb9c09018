"""Attempts to make the prover lie: statements of known truth, asked for verdicts.

    python tools/fuzz.py prover [--seed N] [--count N] [--seconds S] [--jobs N] [--kind K]
                                  [--only I] [--limit S]

Identities, claims and relations are made from the seed and a number alone, true ones and false
ones, so ``--seed N --kind K --only I`` asks one again.  A failure is what is false and proved, what
is true and refuted, a witness whose values are others by mpmath, or an error.  Exit status 1 where
there is one.  Printed besides: the shares left undecided, what is false and said to agree, and
what has no answer within the limit of processor time for one statement.
"""

from __future__ import annotations

import argparse
import collections
import multiprocessing as mp
import random
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import mpmath
import sympy as sp
from shared.campaign import campaign_parser, read_campaign

from prover import claims, identities
from prover.truth import APART, Outside, Statement, number
from voronec.errors import VoronecError

Maker = Callable[[random.Random, str, bool, bool], Statement | None]
KINDS: dict[str, tuple[Maker, tuple[str, ...]]] = {
    "identities": (identities.identity, tuple(identities.FAMILIES)),
    **claims.KINDS,
}
SHARES = {"identities": 0.6, "claims": 0.3, "relations": 0.1}
DRAWS = 60
"""How often the dice are thrown for a statement whose truth is known."""


LIMIT = 60.0
"""Seconds of processor time for a statement to be asked."""
MAKE_LIMIT = 10.0
"""The same for it to be made: SymPy may expand what it evaluates."""


class NoAnswer(BaseException):
    """A statement had no answer within its time; no error that the prover may take as its own."""


def main() -> int:
    """Ask, print a line for each failure and the counts."""
    chosen = _arguments()
    if chosen.only is not None:
        family, outcome, text = ask(chosen.seed, chosen.only, chosen.kind, chosen.limit)
        print(f"{family}: {text}\n{outcome}")
        return 1 if outcome.startswith("wrong") else 0
    begun = time.monotonic()
    print(
        f"seed {chosen.seed}, {chosen.count} statements, {chosen.seconds:g} s at most", flush=True
    )
    counts: collections.Counter[tuple[str, str]] = collections.Counter()
    wrong = 0
    for index, (family, outcome, text) in _results(chosen, begun):
        word = outcome.partition(":")[0]
        counts[family, word] += 1
        if word.startswith("wrong"):
            wrong += 1
            kind = f" --kind {chosen.kind}" if chosen.kind else ""
            print(f"--seed {chosen.seed}{kind} --only {index}  {family}: {text}\n    {outcome}",
                  flush=True)  # fmt: skip
        elif word == NO_ANSWER or (
            chosen.open and word in ("true undecided", "false said to agree")
        ):
            print(f"{index} {family}: {text}\n    {outcome}", flush=True)
    _print_counts(counts)
    total = sum(counts.values())
    print(f"{total} statements in {time.monotonic() - begun:.0f} s, {wrong} wrong")
    return 1 if wrong else 0


def _arguments() -> argparse.Namespace:
    parser = campaign_parser(__doc__, KINDS)
    parser.add_argument("--limit", type=float, default=LIMIT)
    parser.add_argument("--open", action="store_true", help="print what is left undecided, too")
    return read_campaign(parser)


NO_ANSWER = "no answer"
OPEN = ("true undecided", "false said to agree")


def ask(seed: int, index: int, kind: str | None, limit: float = LIMIT) -> tuple[str, str, str]:
    """The family of a statement, what became of it, and what it says."""
    try:
        with _time_limit(MAKE_LIMIT):
            statement = _statement(seed, index, kind)
    except NoAnswer:
        return "none", f"not made: within {MAKE_LIMIT:g} s", ""
    if statement is None:
        return "none", "not made", ""
    try:
        with _time_limit(limit):
            return outcome_of(statement)
    except NoAnswer:
        return statement.family, f"{NO_ANSWER}: within {limit:g} s", statement.text


@contextmanager
def _time_limit(seconds: float) -> Iterator[None]:
    """Raises ``NoAnswer`` after so much processor time, where Python comes to it."""

    def stop(*_: Any) -> None:
        raise NoAnswer

    before = signal.signal(signal.SIGVTALRM, stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)


def outcome_of(statement: Statement) -> tuple[str, str, str]:
    """The family of a statement, what the prover says against its truth, and its text."""
    truth = "true" if statement.true else "false"
    try:
        verdict = statement.ask()
    except VoronecError as error:
        return statement.family, f"{truth} refused: {error}", statement.text
    except Exception as error:  # whatever it is, it is told
        return statement.family, f"wrong error: {error!r}", statement.text
    outcome = f"{truth} {verdict.status}: {verdict.method}"
    if verdict.status == ("refuted" if statement.true else "proved"):
        outcome = f"wrong {truth} {verdict.status}: {verdict.method}; {verdict.witness}"
    elif verdict.refuted and statement.sides and not _confirm(statement.sides, verdict.witness):
        outcome = f"wrong witness: {verdict.witness}"
    elif verdict.undecided and not statement.true and "agree to" in verdict.method:
        outcome = f"false said to agree: {verdict.method}"
    return statement.family, outcome, statement.text


def _statement(seed: int, index: int, kind: str | None) -> Statement | None:
    """Made of the seed and the number alone; families in turn, a half of it true."""
    dice = random.Random(f"{seed}:{index}")
    kind = kind or dice.choices([*SHARES], [*SHARES.values()])[0]
    make, families = KINDS[kind]
    family = families[dice.randrange(len(families))]
    declared, true = dice.random() < 0.5, dice.random() < 0.5
    for _ in range(DRAWS):
        try:
            made = make(dice, family, declared, true)
        except AssertionError:
            continue  # SymPy's own, of products of roots that are not evaluated
        if made is not None:
            return made
    return None


def _confirm(sides: tuple[Any, Any], witness: Any) -> bool:
    """Whether both sides have the values of the witness at its point, by mpmath."""
    named = {str(s): s for s in sp.Tuple(*sides).free_symbols}
    with mpmath.workdps(80):
        at = {s: mpmath.mpf(3) / 7 for s in named.values()}  # of those that cancel inside
        for name, text in witness.point.items():
            above, _, below = text.partition("/")
            at[named[name]] = mpmath.mpf(above) / (mpmath.mpf(below) if below else 1)
        if any(s.is_positive and value <= 0 for s, value in at.items()):
            return False
        try:
            found = [number(side, at) for side in sides]
        except (Outside, ZeroDivisionError):
            return False
        said = [mpmath.mpf(text) for text in (witness.left, witness.right)]
        near = (
            abs(f - s) <= APART * (1 + abs(s)) or abs(f - s) <= APART * abs(s)
            for f, s in zip(found, said, strict=True)
        )
        return all(near) and witness.left != witness.right


def _work(task: tuple[int, int, str | None, float]) -> tuple[int, tuple[str, str, str]]:
    return task[1], ask(*task)


def _results(
    chosen: argparse.Namespace, begun: float
) -> Iterator[tuple[int, tuple[str, str, str]]]:
    """Statements in blocks, until there are enough or the time is over."""
    tasks = [(chosen.seed, i, chosen.kind, chosen.limit) for i in range(chosen.count)]
    if chosen.jobs == 1:
        for task in tasks:
            if time.monotonic() - begun > chosen.seconds:
                return
            yield _work(task)
        return
    with mp.get_context("fork").Pool(chosen.jobs) as pool:
        for found in pool.imap_unordered(_work, tasks, chunksize=4):
            yield found
            if time.monotonic() - begun > chosen.seconds:
                pool.terminate()
                return


def _print_counts(counts: collections.Counter[tuple[str, str]]) -> None:
    """A line for each family: what is true and what is false in it, and what became of both."""
    for family in sorted({f for f, _ in counts}):
        here = {word: n for (f, word), n in counts.items() if f == family}
        true = sum(n for word, n in here.items() if word.startswith("true"))
        left = here.get("true undecided", 0) + here.get("true refused", 0)
        share = f", {100 * left / true:.0f} % of what is true left open" if true else ""
        told = ", ".join(f"{n} {word}" for word, n in sorted(here.items()))
        print(f"  {family}: {told}{share}")
