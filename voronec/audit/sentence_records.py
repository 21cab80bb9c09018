"""The records of the sentences of a paper: what each claims in words, judged as formulas are."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import sympy as sp

from voronec.audit.claim_judge import ClaimJudge
from voronec.audit.claims_in_words import WordClaim, claims_in_words, last_side
from voronec.audit.comparisons import value_of
from voronec.audit.contents import value_or_none
from voronec.audit.latex.document import Document, PrintedSentence
from voronec.audit.printed_claims import claim_in_words
from voronec.audit.record import FormulaRecord


@dataclass(frozen=True)
class SentenceJudge:
    """What the sentences of a paper are judged with."""

    document: Document
    judge: ClaimJudge

    def place(self, sentence: PrintedSentence) -> tuple[str, int, int]:
        """File, line and column of a sentence."""
        return self.document.source.place(self.document.body.origins[sentence.at])

    def records(self, sentence: PrintedSentence) -> Iterator[tuple[str, FormulaRecord]]:
        """The records of a sentence: of its claims, or one that says that it is not audited."""
        quoted = str(sentence)
        claims = claims_in_words(sentence, partial(self._density, sentence), self._side)
        if not claims:
            yield quoted, FormulaRecord("", "unaudited", "no pattern reads it", says=quoted)
        for claim in claims:
            record = self._judge_words(sentence, claim)
            if record.verdict == "misprint" and not claim.alone:
                doubt = "false in general, where its sentence says more than this"
                record = FormulaRecord("", "unaudited", doubt)
            elif record.verdict not in ("proved", "misprint", "unaudited"):
                record = FormulaRecord("", "unaudited", f"{record.verdict}: {record.method}")
            yield quoted, replace(record, says=quoted)

    def _judge_words(self, sentence: PrintedSentence, claim: WordClaim) -> FormulaRecord:
        """The verdict on a claim in words, by the formula that it makes if it makes one."""
        if claim.decide is not None:
            verdict, method = claim.decide(self.judge.study.context)
            return FormulaRecord("", verdict, method, source=self.judge.study.origin)
        made = claim_in_words(
            self.document, sentence, claim.formula, self.judge.study, claim.before, claim.after
        )
        return FormulaRecord("", "not read", "a slot") if made is None else self.judge.judge(made)

    def _density(self, sentence: PrintedSentence, latex: str) -> Any:
        """The value of a formula in the invariants of the system, else None."""
        made = claim_in_words(self.document, sentence, f"${latex}=0$", self.judge.study)
        if made is None or made.chain is None:
            return None
        invariants = self.judge.study.context.system.invariants
        inside = {value: sp.Symbol(name) for name, value in invariants.items()}
        names = {
            letter: value.applyfunc(lambda x: inside.get(x, x))
            if isinstance(value, sp.MatrixBase)
            else inside.get(value, value)
            for letter, value in self.judge.study.names.items()
        }
        study = replace(self.judge.study, names=names)
        return value_or_none(value_of, made.chain.parts[0], study, {})

    def _side(self, label: str) -> str:
        """The last side of the formula with a number, empty where there are several or none."""
        formulas = [c.formula.printed for c in self.judge.claims if c.display.number == label]
        return last_side(formulas[0]) if len(formulas) == 1 else ""
