"""Solving the system in terms of elliptic functions and elliptic integrals: the displays as printed, and what they are compared with."""

from __future__ import annotations

from typing import Any

from voronec.audit import Check, Convention, Section, Study, Transcript

from ..dictionary.kinds_of_motion import (
    by_state,  # noqa: F401  (named in the print)
    forms,
    in_seconds,
)
from ..dictionary.quadratures import level, x
from ..sentences.quadratures import SENTENCES
from ..transcription import displays

DEFINITION = Check("definition")
BALL_TRACE = Check(study="level", derived=lambda study, where: forms(r"\phi(x)"))
SPHERE_TRACE = Check(
    "definition", "level", derived=lambda study, where: forms("F(x)", r"\theta(x)")
)  # the paper has no other word on F and theta than that they are quadratic, which is a sentence


def square_of_rate(value: Any) -> Any:
    """The square of the rate of x in the unit of time of the equations of motion."""
    return (level().X / level().pace ** 2).subs(x, value)


RATE = Check(
    convention=Convention(
        "the unit of time is $b_2/k$ here, or $X(x)$ stands for $(k/b_2)^2$ times that polynomial",
        "4.4.13",
        {"X": square_of_rate},
    ),
    derived=in_seconds,
)


def studies(_: Transcript) -> dict[str, Study]:
    """The state of the ball, and a level of the integrals."""
    return level().studies()


QUADRATURES = Section(
    title="Solving the system in terms of elliptic functions and elliptic integrals",
    complete=True,
    label=None,
    studies=studies,
    inline=displays(__file__, globals(), "inline"),
    sentences=SENTENCES,
    displays=displays(__file__, globals()),
)
