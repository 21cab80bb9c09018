"""The gyroscopic ball on a sphere: the displays as printed, and what they are compared with."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import sympy as sp

from voronec.audit import Check, Section, Study, Transcript

from ..sentences.ball import FRAMES, SENTENCES
from ..transcription import displays

UPRIGHT = "the momentum of ball and rotor, in which k belongs to chi whatever the quasi-velocities"
DERIVATION = "the equations derived for the system 'ball-with-rotor'"
DEFINITION = Check("definition")
EVERYWHERE = Check("definition", also=("reduced",))
ZHUKOVSKY = Check(study="zhukovsky", given=("uslovZh",))
BOTH = Check(also=("reduced",))
CONSTRAINT = Check(also=("reduced",), constrains=1)
ANY_MOTION = Check(source=FRAMES)
NO_VECTOR = Check(value=lambda study, where: sp.zeros(3, 1), source=FRAMES)


def motion(row: int) -> Check:
    """Compare with a row of the derived equations of motion of both systems."""
    return Check(
        study="reduced",
        also=("zhukovsky",),
        truth=lambda study, where: study.context.equation(row),
        given=("uslovZh",),
    )


def projection(row: int) -> Check:
    """Compare with a projection of the momentum, laid along the vertical axis."""

    def derivation(study: Study, where: Mapping[str, int]) -> list[tuple[Any, Any]]:
        vertical, momentum = study.context.projections()
        return [(vertical[row], momentum[row])]

    return Check(study="upright", given=("uslovZh",), derived=derivation, source=UPRIGHT)


def condition(study: Study, _: Mapping[str, int]) -> Any:
    """What C_1 must be for the momentum along the normal to have the coefficient A of n."""
    return study.context.condition()


def studies(_: Transcript) -> dict[str, Study]:
    """The dictionaries of the section on the ball."""
    from ..dictionary.ball import ReducedBall, WithRotor

    return {**WithRotor.derive().studies(), "reduced": ReducedBall.derive().study()}


AXIAL_MOMENTUM = Check(source=f"{UPRIGHT}, and {DERIVATION}")
PROJECTION_ROWS = (projection(0), projection(1), projection(2))
MOTION_ROWS = (motion(0), motion(1), motion(2))

BALL = Section(
    title="The Bobilev-Zhukovsky problem and its generalization",
    complete=True,
    label="ballGyr",
    studies=studies,
    inline=displays(__file__, globals(), "inline"),
    sentences=SENTENCES,
    displays=displays(__file__, globals()),
)
