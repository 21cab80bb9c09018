"""Back to the Demchenko case: no displays, but claims of the running text."""

from __future__ import annotations

from voronec.audit import Section, Study, Transcript

from ..dictionary.quadratures import level
from ..sentences.kinds_of_motion import SENTENCES


def studies(_: Transcript) -> dict[str, Study]:
    """The motion on a level of the integrals; for captions, the text alone."""
    text = Study({}, source="the text that refers to the figure")
    return {"level": level().study({}), "text": text}


KINDS_OF_MOTION = Section(
    title="Back to the Demchenko case",
    complete=True,
    displays=(),
    studies=studies,
    sentences=SENTENCES,
)
