"""Back to the Demchenko case: no displays, but claims of the running text."""

from __future__ import annotations

from voronec.audit import Section, Study, Transcript

from ..dictionary.quadratures import level
from ..sentences.kinds_of_motion import SENTENCES


def studies(_: Transcript) -> dict[str, Study]:
    """The motion on a level of the integrals."""
    return {"level": level().study({})}


KINDS_OF_MOTION = Section(
    title="Back to the Demchenko case",
    displays=(),
    studies=studies,
    sentences=SENTENCES,
)
