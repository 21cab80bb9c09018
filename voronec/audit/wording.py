"""What a record says beside its verdict: how it was found, where it holds, and a witness."""

from __future__ import annotations

import re
from typing import Any

import sympy as sp

from voronec.algebra.verdicts import Witness
from voronec.audit.display import Check
from voronec.audit.formula import Formula
from voronec.audit.latex.nodes import Chain
from voronec.audit.record import FormulaRecord
from voronec.audit.structure import free_indices, names_constant
from voronec.audit.study import Range, Study
from voronec.audit.verify import FormulaOutcome

__all__ = ["loose_index", "method_of", "ranges_of", "readable", "with_note", "witness_of"]

_MARKUP = (
    (r"\\eqref\{([^}]*)\}", r"(\1)"),
    (r"\\ref\{([^}]*)\}", r"\1"),
    (r"\\cite\{([^}]*)\}", r"[\1]"),
    (r"\\(?:emph|text|caption)\{([^{}]*)\}", r"\1"),
    (r"\\label\{[^}]*\}|\\begin\{aligned\}|\\end\{aligned\}", ""),
    (r"\\footnote\{", " (footnote: "),
    (r"\s*\$\$\s*", " $ "),
    (r"\\begin\{(?:equation|eqnarray)\*?\}|\\end\{(?:equation|eqnarray)\*?\}", "$"),
    (r"\\(?:begin|end)\{itemize\}|\\(?:item|medskip)\b", ""),
)
"""Commands of running text, and what stands for them where words are read."""


def readable(quotation: str) -> str:
    """A quotation in words, its formulas between dollar signs."""
    for pattern, plain in _MARKUP:
        quotation = re.sub(pattern, plain, quotation)
    return " ".join(quotation.split())


def method_of(
    finding: FormulaOutcome, chain: Chain | None = None, check: Check | None = None
) -> str:
    """How the verdict was found, in words."""
    # Where there are ranges, each has its own reasons with it.
    parts = [_where(finding) if finding.ranges else finding.verdict.method]
    if finding.count > 1:
        parts.append(f"{finding.count} comparisons")
    if chain is None or check is None or check.decide is not None:
        return "; ".join(parts)
    if check.stationary:
        parts.append("variations integrated by parts, compared with the d'Alembert equations")
    elif check.truth is not None:
        parts.append("compared with the derived equation of motion")
    elif names_constant(chain.parts[-1]):
        parts.append("its derivative along the motion vanishes")
    if check.given:
        parts.append("given " + ", ".join(f"({label})" for label in check.given))
    return "; ".join(parts)


def _where(finding: FormulaOutcome) -> str:
    """In which ranges a claim holds, and in which not."""
    good = [r.name for r, v in finding.ranges if v.proved]
    bad = [r.name for r, v in finding.ranges if v.refuted]
    open_ = [r.name for r, v in finding.ranges if v.undecided]
    parts = [f"true for {_list_names(good)}"] if good else []
    parts += [f"false for {_list_names(bad)}"] if bad else []
    parts += [f"undecided for {_list_names(open_)}"] if open_ else []
    if not good:
        return finding.verdict.method
    if finding.scope and set(finding.scope) <= set(good) and len(parts) > 1:
        return f"{parts[0]}, of which the section speaks; it does not extend to " + _list_names(
            bad + open_
        )
    sources = dict.fromkeys(r.source for r, v in finding.ranges if r.source and not v.proved)
    if sources:
        parts[-1] += f", which ({', '.join(sources)}) admits: the print must say for which it is"
    return ", ".join(parts)


def _list_names(names: list[str]) -> str:
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def ranges_of(finding: FormulaOutcome) -> tuple[dict[str, Any], ...]:
    """The outcome for each range of the parameters, as a record holds it."""
    return tuple(_range(where, verdict) for where, verdict in finding.ranges)


def _range(where: Range, verdict: Any) -> dict[str, Any]:
    spoken = set(re.findall(r"[A-Za-z]+", verdict.method))
    if verdict.witness is not None:
        spoken |= {*verdict.witness.point}
    shown = [meaning for letter, meaning in where.letters.items() if letter in spoken]
    return {
        "range": where.name,
        "statement": ",\\ ".join([where.statement, *shown]),
        "verdict": verdict.status,
        "method": verdict.method,
        "witness": None if verdict.witness is None else _place_witness(verdict.witness, where),
    }


def _place_witness(witness: Witness, where: Range) -> dict[str, Any]:
    """A witness with the values of the paper's own parameters at its point."""
    found = _values(witness)
    known = {sp.Symbol(name): sp.Rational(v) for name, v in found["point"].items() if _exact(v)}
    for parameter, value in where.values.items():
        plain = value.xreplace({x: sp.Symbol(x.name) for x in value.free_symbols}).xreplace(known)
        if plain.is_Rational and str(parameter) not in found["point"]:
            found["point"] = {str(parameter): str(plain), **found["point"]}
    return found


def _exact(value: str) -> bool:
    return re.fullmatch(r"-?\d+(/\d+)?", value) is not None


def _values(witness: Witness) -> dict[str, Any]:
    point = {_plain(name): value for name, value in witness.point.items()}
    return {"point": point, "printed": witness.left, "derived": witness.right}


def witness_of(finding: FormulaOutcome) -> dict[str, Any] | None:
    """The point at which a formula is false, and its two sides there."""
    comparison, witness = finding.comparison, finding.verdict.witness
    if witness is None:
        return None
    found = _values(witness)
    if comparison is not None and comparison.where:
        found["indices"] = {letter.lstrip("\\"): i for letter, i in comparison.where.items()}
    if comparison is not None and comparison.about:
        found["about"] = comparison.about
    return found


def _plain(name: str) -> str:
    """An atom's name without the arguments of unknown functions and the marks of LaTeX."""
    name = re.sub(r"(?<=\w)\((?:[\w ]+,\s*)+\w+\)", "", name)
    return re.sub(r"[\\{}]", "", name)


def loose_index(formula: Formula, chain: Chain, study: Study) -> str:
    """Say it where an index is bound by nothing."""
    bound = {w.text for words in formula.piece.quantifiers for w in words}
    bound |= set(free_indices(chain.parts[0], study))
    loose = [letter for letter in free_indices(chain, study) if letter not in bound]
    return f", where nothing binds the index {loose[0]}" if loose else ""


def with_note(record: FormulaRecord, study: Study) -> str:
    """The method, how general the study is, and the letters of the derived side that are not the
    paper's."""
    shown = record.derived or ""
    strange = [
        meaning
        for letter, meaning in study.letters.items()
        if re.search(rf"(?<![a-zA-Z\\]){re.escape(letter)}(?![a-zA-Z])", shown)
    ]
    return "; ".join(filter(None, (record.method, study.note, *dict.fromkeys(strange))))
