"""Special Solutions: the displays as printed, and what they are compared with."""

from __future__ import annotations

from dataclasses import replace

from voronec.audit import Check, Display, Section, Study, Transcript

from ..dictionary.quadratures import level
from ..dictionary.stability import PrintedSection, left_open, precession
from ..sentences.special_solutions import SENTENCES

MEANING = (
    "stable: x stays as near as one likes if u, s, tau, n begin near enough; v and v1 may drift"
)
INSIDE = MEANING + "; at x = 1 or -1, where a root has one side only, the motion is stationary"


def studies(transcript: Transcript) -> dict[str, Study]:
    """The motion on a level of the integrals; the context is what the print says."""
    sentences = transcript.section.sentences or SENTENCES
    printed = PrintedSection(tuple(formula.printed for formula in transcript.formulas()), sentences)
    items = " ".join(sentence.quotation for sentence in sentences)
    return {
        "inside": replace(level().study({}, INSIDE), context=printed),
        "stable": level().study({}, MEANING),
        "level": level().study({}),
        "list": Study({}, context=items, source="the items of the list themselves"),
    }


CONDITIONS = (
    r"""$$
    \frac{\partial^2 X}{\partial x^{I2}}<0,
    $$""",
    r"""$$
    \frac{\partial^2 X}{\partial x^{I2}}>0.
    $$""",
    r"""$$
    \frac{\partial^2 X}{\partial x^{I2}}=0,
    $$""",
    r"""$$
    \frac{\partial^3 X}{\partial x^{I3}}=0,
    $$""",
    r"""$$
    \frac{\partial^3 X}{\partial x^{I3}}\ne0.
    $$""",
)
"""The conditions on the second and third derivative as printed."""


def condition(position: int, opening: str, slot: str) -> Display:
    """The condition at a position, claimed for what the sentence calls stable or unstable."""
    return Display(CONDITIONS[position], (Check(decide=precession(position, opening, slot)),))


SPECIAL_SOLUTIONS = Section(
    title="Special Solutions",
    complete=True,
    label=None,
    studies=studies,
    sentences=SENTENCES,
    displays=(
        condition(0, "The precession", "sort"),
        condition(1, "The precession", "other"),
        Display(CONDITIONS[2], (Check("definition", decide=left_open),)),
        condition(3, "In the cases", "sort"),
        condition(4, "and the", "one"),
    ),
)
