"""Changes of the words that decide a sentence, by the kind of the slot in which they stand."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace

from voronec.audit import Sentence

WORDS = {
    "number": ("no", "one", "two", "three", "four", "five"),
    "quantifier": ("all", "no"),
    "affirmed": (),
    "stability": ("stable", "unstable"),
    "relation": ("bigger", "smaller", "equal"),
    "word": ("not",),
    "reference": (r"\eqref{v1}", r"\eqref{kineticka}"),
}
MEANS = (
    {"no", "zero"},
    {"one", "first", "single"},
    {"two", "second", "both", "quadratic"},
    {"three", "third"},
    {"four"},
)
ALL = {"all", "every", "each", "any", "always", "arbitrary"}


def changes(sentence: Sentence) -> Iterator[tuple[str, str, Sentence]]:
    """Slot, new print, and the sentence with that change of its quotation."""
    for slot in sentence.slots:
        for new in _others(slot.kind, slot.printed):
            text = sentence.text.replace(
                f"@{slot.name}:{slot.kind}{{{slot.printed}}}", f"@{slot.name}:{slot.kind}{{{new}}}"
            )
            changed = Sentence(text, sentence.decide, unaudited=sentence.unaudited)
            yield slot.name, new, replace(sentence, quotation=changed.quotation)


def _others(kind: str, printed: str) -> Iterator[str]:
    old = printed.lower()
    same = next((m for m in MEANS if old in m), {old}) | (ALL if old in ALL else set())
    if kind == "stability":
        same = {"unstable", "instable"} if old != "stable" else {"stable"}
    yield from (new for new in WORDS.get(kind, ()) if new not in same and new != printed)
    if kind == "affirmed":
        yield printed.replace("not ", "") if "not " in printed else f"not {printed}"
    if kind in ("names", "interval", "formula"):
        yield from _turned(printed)


def _turned(printed: str) -> Iterator[str]:
    """One name more or another relation."""
    for old, new in ((">", "<"), ("<", ">"), ("=", "<"), (r"\ne", "="), (r"\psi", r"\phi")):
        if old in printed:
            yield printed.replace(old, new)
            return
    if names := re.findall(r"[a-zA-Z]\^\{?[IV]+\}?|[a-zA-Z]", printed):
        yield printed.replace(names[-1], "q", 1)
