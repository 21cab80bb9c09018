"""What all reports of an audit say in the same words: verdicts, places, witnesses, lists.

The point of a witness has its names in LaTeX, and its values cut.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from itertools import groupby
from typing import Any

from voronec.audit.page.symbols import FUNCTIONS, LETTERS
from voronec.audit.record import VERDICTS, Audit, FormulaRecord, Record

MEANING = {
    "proved": "the formula follows from the derived equations, exactly",
    "misprint": "it is false as printed; the correction, where one is given, is proved",
    "convention": "it is true under a convention, or in a range of the parameters, that is stated",
    "definition": "it introduces a name or a condition; checked by the formulas that use it",
    "cited": "a fact that the paper quotes, and that is not proved here",
    "unaudited": "a sentence that states something, and that nothing here decides",
    "not read": "it holds a letter, a command or a notation that is not known, or can be read in "
    "two ways; it says which, and where",
    "unknown letters": "it holds letters that neither the dictionary nor the paper explains",
    "undecided": "neither proved nor refuted",
}
FAULTS = ("misprint", "undecided", "not read", "unknown letters")
"""Verdicts that need a reader's attention."""
NOUNS = ("misprint", "convention", "definition")
"""Verdicts that have a plural."""
KINDS = {"display": "displayed equations", "text": "in the text"}


def about(witness: Mapping[str, Any]) -> str:
    """What the two values of a witness are values of, and for which indices; often nothing."""
    where = ", ".join(f"{k} = {v}" for k, v in witness.get("indices", {}).items())
    parts = [str(witness.get("about", "")), f"for {where}" if where else ""]
    return ", ".join(part for part in parts if part)


def sides(formula: FormulaRecord) -> tuple[str, str]:
    """What the two values of a witness are called: an inequality has two sides of equal right."""
    equality = formula.printed and not formula.ranges
    return ("as printed", "derived") if equality else ("left side", "right side")


def values(formula: FormulaRecord) -> tuple[tuple[str, str], ...]:
    """The two values of a witness, each with its name; nothing where that would not say of what."""
    witness = formula.witness
    if witness is None or not (formula.printed or about(witness)):
        return ()
    first, second = sides(formula)
    return (first, plain(str(witness["printed"]))), (second, plain(str(witness["derived"])))


def group_ranges(formula: FormulaRecord) -> tuple[dict[str, str], ...]:
    """The ranges of a claim: those with the same verdict, method and witness are one entry.

    ``range``, ``where`` (with dollar signs), ``verdict``, ``method`` (empty where the record says
    the same) and ``witness`` are words.
    """
    groups: dict[tuple[str, str, str], list[Mapping[str, Any]]] = {}
    for entry in formula.ranges:
        at = _at(formula, entry["witness"])
        groups.setdefault((entry["verdict"], entry["method"], at), []).append(entry)
    return tuple(
        {
            "range": ", ".join(str(r["range"]) for r in several),
            "where": "; ".join(filter(None, (_in_math(r["statement"]) for r in several))),
            "verdict": verdict,
            "method": "" if f"; {method};" in f"; {formula.method};" else short(method),
            "witness": at,
        }
        for (verdict, method, at), several in groups.items()
    )


def _at(formula: FormulaRecord, witness: Mapping[str, Any] | None) -> str:
    if witness is None:
        return ""
    both = f"{short(str(witness['printed']))} against {short(str(witness['derived']))} "
    return (both if formula.printed else "") + f"at {point(witness)}"


def _in_math(statement: str) -> str:
    if "$" in statement or not statement:
        return statement
    return ", ".join(f"${part.strip()}$" for part in re.split(r",\\? ", statement))


def clauses(text: str) -> list[str]:
    """What stands between semicolons outside parentheses and formulas."""
    pieces, depth, math = [""], 0, False
    for position, letter in enumerate(text):
        math ^= letter == "$"
        depth += 0 if math else (letter == "(") - (letter == ")")
        if letter == ";" and depth <= 0 and not math and text[position + 1 : position + 2] == " ":
            pieces.append("")
        else:
            pieces[-1] += letter
    return [clause.strip() for clause in pieces]


def gist(method: str) -> str:
    """The sentence that a list of conventions needs of a method: where it holds, against what."""
    parts = clauses(method)
    last = max((n for n, part in enumerate(parts) if part.startswith("against ")), default=0)
    return "; ".join(parts[: last + 1])


def end_sentence(text: str) -> str:
    """A sentence with its full stop, where it does not end in dots."""
    return text if text.endswith((".", "...")) else f"{text}."


def with_verdict(audit: Audit, verdict: str) -> Iterator[tuple[Record, FormulaRecord]]:
    """The formulas that have a verdict, each with its record, in the order of print."""
    for record in audit.records:
        for formula in record.formulas:
            if formula.verdict == verdict:
                yield record, formula


def conventions_with_formulas(
    audit: Audit,
) -> Iterator[tuple[str, tuple[tuple[Record, FormulaRecord], ...]]]:
    """The conventions: what is said of each, and the formulas in a row of which it is said."""
    pairs = with_verdict(audit, "convention")
    for said, several in groupby(pairs, key=lambda pair: gist(pair[1].method)):
        yield said, tuple(several)


def faults(record: Record) -> tuple[FormulaRecord, ...]:
    """The formulas of a record that need a reader's attention."""
    return tuple(f for f in record.formulas if f.verdict in FAULTS)


def counts(audit: Audit) -> dict[str, dict[str, int]]:
    """kind -> verdict -> number of records, worst first, for the verdicts that occur."""
    tally = {}
    for kind in KINDS:
        records = [r for r in audit.records if r.kind == kind]
        if records:
            tally[kind] = {v: sum(r.verdict == v for r in records) for v in reversed(VERDICTS)}
    return tally


def count_sentences(audit: Audit) -> list[str]:
    """The counts, a sentence for each kind of record."""
    lines = []
    for kind, numbers in counts(audit).items():
        each = ", ".join(
            f"{n} {verdict}{'s' * (n > 1 and verdict in NOUNS)}"
            for verdict, n in numbers.items()
            if n
        )
        total = sum(numbers.values())
        name = KINDS[kind].removesuffix("s") if total == 1 else KINDS[kind]
        lines.append(f"{total} {name}: {each}")
    return lines


DIGITS = 12
"""Digits of a decimal that are shown; the plain data hold them all."""
_ZERO = re.compile(r"(?<![\w.])-?0(?:\.0*)?(?:e[+-]?\d+)?(?![\w.])")
_DERIVATIVE = re.compile(r"Derivative\((.*?), ((?:\w+'*, )*\w+'*)\)")
_WORD = re.compile(
    r"(?P<head>[A-Za-z]+?)(?P<digits>\d*)(?:_(?P<under>\w+?))?(?P<dots>(?:dot){0,2})(?P<tilde>~?)"
    r"(?!\w)|_(?P<sub>\w+)"
)


def plain(value: str) -> str:
    """A value in which a zero with exponents, as ``0e-44``, is ``0``."""
    return _ZERO.sub("0", value)


def short(value: str, digits: int = DIGITS) -> str:
    """A value with its decimals cut after ``digits`` significant digits, and dots for the rest."""

    def cut(match: re.Match[str]) -> str:
        whole, rest = match[1], match[2].rstrip("0")
        leading = len(rest) - len(rest.lstrip("0")) if not whole.strip("0") else 0
        kept = max(digits - len(whole.lstrip("0")), 1) + leading
        if len(rest) <= kept:
            return f"{whole}.{rest}" if rest else whole
        return f"{whole}.{rest[:kept]}..."

    return re.sub(r"(\d+)\.(\d+)", cut, plain(value))


def readable(name: str) -> str:
    """The name of a witness's coordinate as LaTeX: a derivative, a letter, its dots and index."""
    derivative = _DERIVATIVE.fullmatch(name)
    if derivative is not None:
        by = derivative[2].split(", ")
        order = f"^{len(by)}" if len(by) > 1 else ""
        below = "".join(rf"\partial {readable(x)}" for x in by)
        return rf"\partial{order} {readable(derivative[1])}/{below}"
    return _WORD.sub(_spell_name, re.sub(r"[\\{}]", "", name)).strip()


def _spell_name(match: re.Match[str]) -> str:
    """One word of a name: ``q1dot`` is ``\\dot{q}_{1}``."""
    head, below = match["head"], match["digits"] or match["under"] or match["sub"]
    script = f"_{{{_WORD.sub(_spell_name, below).strip()}}}" if below else ""
    if head is None:
        return script
    known = head in LETTERS or head in FUNCTIONS or head == "dot"
    letter = f"\\{head} " if known else head if len(head) == 1 else rf"\text{{{head}}}"
    accent = {"dot": "\\dot", "dotdot": "\\ddot"}.get(
        match["dots"], "\\tilde" * len(match["tilde"])
    )
    return f"{accent}{{{letter.strip()}}}{script}" if accent else letter + script


def point(witness: Mapping[str, Any]) -> str:
    """The point of a witness on one line, its names between dollar signs."""
    return ", ".join(
        f"${readable(name)}$ = {short(str(v), 6)}" for name, v in witness["point"].items()
    )


def typeset_words(text: str, word: Callable[[str], str], formula: Callable[[str], str]) -> str:
    """Words with formulas between dollar signs, each set by a function of its own."""
    pieces = text.split("$")
    if len(pieces) % 2 == 0 or "" in pieces[1::2]:  # signs that enclose no formula
        return word(text)
    return "".join((formula if i % 2 else word)(piece) for i, piece in enumerate(pieces))
