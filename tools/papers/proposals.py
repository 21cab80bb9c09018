"""What a correction is worth that the audit proposes for an error put in on purpose."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import pairwise

from papers.trials import Fault, same_claim
from voronec.audit.latex.nodes import Chain
from voronec.audit.latex.reader import read
from voronec.audit.latex.tokens import tokenize
from voronec.audit.structure import are_multiples, holds_always
from voronec.audit.study import Study
from voronec.audit.verify import verify


@dataclass(frozen=True)
class Proposal:
    """A proposed formula, and its kind; ``why`` a senseless one is senseless."""

    kind: str
    latex: str = ""
    why: str = ""

    @property
    def words(self) -> str:
        """The kind with the reason."""
        return f"{self.kind}: {self.why}" if self.why else self.kind


def judge(latex: str, fault: Fault) -> Proposal:
    """Whether a proposal restores what stood there, is equivalent to it, another one or senseless.

    Senseless is what is not proved, says nothing, or differs in more words from the error than the
    formula that stood there does.
    """
    if any(_bare(latex) == _bare(true.printed) for true in fault.true):
        return Proposal("restored", latex)
    study = fault.work.bench.study(fault.formula.display.check(fault.formula.position))
    new = read(latex, study.vocabulary)
    if any(same_claim(true.tree(study.vocabulary), new, study) for true in fault.true):
        return Proposal("equivalent", latex)
    why = _senseless(new, latex, fault, study)
    return Proposal("senseless" if why else "another", latex, why)


def _senseless(new: Chain, latex: str, fault: Fault, study: Study) -> str:
    """Why a proposal makes no sense; nothing where it does."""
    check = fault.formula.display.check(fault.formula.position)
    if any(holds_always(*link) or are_multiples(*link) for link in pairwise(new.parts)):
        return "it says nothing"
    if not verify(new, check, study).verdict.proved:
        return "it is not proved"
    trees = [(true.printed, true.tree(study.vocabulary)) for true in fault.true]
    stood = [(latex, tree) for latex, tree in trees if verify(tree, check, study).verdict.proved]
    if not stood:
        return ""  # what stood there is true under a convention only
    wrong = fault.formula.printed
    if _distance(latex, wrong) > min(_distance(true, wrong) for true, _ in stood):
        return "what stood there is nearer"
    return ""


def _bare(latex: str) -> str:
    """Without spacing, brackets' sizes and braces around one word."""
    return re.sub(r"\s|\\[bB]igg?|&|\\\\|\\,|\{(?=\w\})|(?<=\{\w)\}", "", latex)


def _distance(one: str, two: str) -> int:
    """How many words are left out, put in or exchanged between two formulas (Levenshtein)."""
    before = [word.text for word in tokenize(one)]
    after = [word.text for word in tokenize(two)]
    row = list(range(len(after) + 1))
    for i, a in enumerate(before, start=1):
        last, row[0] = row[0], i
        for j, b in enumerate(after, start=1):
            last, row[j] = row[j], min(row[j] + 1, row[j - 1] + 1, last + (a != b))
    return row[-1]
