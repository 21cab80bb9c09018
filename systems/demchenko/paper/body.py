"""The Voronec principle and rolling of a body over a surface: the displays as printed, and what they are compared with."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from voronec.audit import Check, Convention, Section, Study, Transcript

from ..dictionary.surfaces import MASS
from ..sentences.body import (
    KINETIC,  # noqa: F401  (named in the print)
    SENTENCES,
)
from ..transcription import displays


def studies(_: Transcript) -> dict[str, Study]:
    """The dictionaries of this section."""
    from ..dictionary.body import Body

    return Body.derive().studies()


def momentum(position: int) -> Check:
    """K_1 or K_2 in terms of s, tau, n; the print has M for the mass."""

    def derivation(study: Study, _: Mapping[str, int]) -> list[tuple[Any, Any]]:
        return [(f"K_{position + 1}", study.context.momentum_terms(position, study.spelling))]

    return Check(
        study="quasi",
        derived=derivation,
        convention=Convention("$M$ is the mass $\\mathbf M$", "kineticka", {"M": MASS}),
    )


def transposition(position: int) -> Check:
    """What K_1 or K_2 is multiplied by in the principle."""

    def value(study: Study, _: Mapping[str, int]) -> Any:
        return study.context.transpositions[position]

    return Check(value=value)


def motion(position: int) -> Check:
    """The derived equation of u, v or theta."""

    def derivation(study: Study, _: Mapping[str, int]) -> list[tuple[Any, Any]]:
        found: list[tuple[Any, Any]] = study.context.equation_terms(position)
        return found

    return Check(
        truth=lambda study, where: study.context.residuals[position],
        derived=derivation,
    )


DEFINITION = Check("definition")

MOMENTUM_ROWS = (momentum(0), momentum(1))
TRANSPOSITION_ROWS = (transposition(0), transposition(1))
PRINCIPLE_ROW = (
    Check(
        stationary=True,
        truth=lambda study, where: study.context.row(where),
        # Two omissions that show in no number.
        proposal=r"\int\limits_{t_1}^{t_2}\big[\delta\bar{\Theta}+\delta U+K'_1\sqrt{E}(n\delta u-\dot u n') +K'_2\sqrt{G}(n\delta v-\dot v n')\big]dt=0",
    ),
)
MOTION_ROWS = (motion(0), motion(1), motion(2))

BODY = Section(
    title="The Voronec principle and rolling of a body over a surface",
    complete=True,
    label="body",
    studies=studies,
    inline=displays(__file__, globals(), "inline"),
    sentences=SENTENCES,
    displays=displays(__file__, globals()),
)
