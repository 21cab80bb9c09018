"""Rolling without slipping of a body over a surface in the Neumann variables: the displays as printed, and what they are compared with."""

from __future__ import annotations

from voronec.audit import Check, Section, Study, Transcript

from ..sentences.neumann import SENTENCES, turns
from ..transcription import displays

DEFINITION = Check("definition")
ROLLING = Check(study="rolling")
CONSTRAINT = Check(study="rolling", constrains=1)


LINES = Check(study="lines")


def studies(_: Transcript) -> dict[str, Study]:
    """The dictionaries of this section."""
    from ..dictionary.moments import particles
    from ..dictionary.neumann import (
        Attitude,
        Space,
        body_energy,
        left_handed_frame,
        principal_lines,
    )
    from ..dictionary.surfaces import Surfaces

    return {
        **Space(Surfaces.arbitrary()).studies(),
        "lines": principal_lines(),
        "energy": body_energy(),
        "energies": Attitude.arbitrary().study(),
        "left-handed": left_handed_frame(),
        "particles": particles(r"\mathfrak v^1", r"\mathbf G^{(M)}"),
    }


ANGULAR_VELOCITIES = tuple(Check(sentence=line) for line in turns())

NEUMANN = Section(
    title="Rolling without slipping of a body over a surface in the Neumann variables",
    complete=True,
    label="Nvar",
    studies=studies,
    inline=displays(__file__, globals(), "inline"),
    sentences=SENTENCES,
    displays=displays(__file__, globals()),
)
