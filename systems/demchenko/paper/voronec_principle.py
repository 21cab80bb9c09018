"""The Voronec principle: the displays as printed, and what they are compared with."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from voronec.audit import Check, Section, Study, Transcript

from ..sentences.voronec_principle import (
    CURVATURE,  # noqa: F401  (named in the print)
    SENTENCES,
)
from ..transcription import displays

DEFINITION = Check("definition")
ENERGY = "the kinetic energy of any system, with unknown functions for coefficients"
PRINCIPLE = "d'Alembert's principle, for any constraints affine in the velocities"
RULE = "how variations of independent coordinates change, for any system"


def dalembert(stationary: bool = False, source: str = "") -> Check:
    """Compare with d'Alembert's principle."""
    return Check(
        truth=lambda study, where: study.context.dalembert(where),
        derived=lambda study, where: study.context.structure(),
        stationary=stationary,
        source=source,
    )


def studies(_: Transcript) -> dict[str, Study]:
    """The dictionary of the section on the Voronec principle."""
    from ..dictionary.general import General

    return {
        "general": General.derive().study(),
        "chaplygin": General.chaplygin().study(),
    }


def transposition(study: Study, where: Mapping[str, int]) -> Any:
    """How much varying and differentiating in time differ for a dependent coordinate."""
    return study.context.transposition(where)


DALEMBERT = (dalembert(),)
STATIONARY_FORM = (dalembert(stationary=True, source=PRINCIPLE),)

VORONEC_PRINCIPLE = Section(
    title="The Voronec principle",
    complete=True,
    label="VorPr",
    studies=studies,
    inline=displays(__file__, globals(), "inline"),
    sentences=SENTENCES,
    displays=displays(__file__, globals()),
)
