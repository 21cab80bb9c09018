"""Rolling of a body with a gyroscope: the displays as printed, and what they are compared with."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from voronec.audit import Check, Section, Study, Transcript

from ..sentences.gyroscope import SENTENCES
from ..transcription import displays

ROTOR = Check(study="rotor")
DEFINITION = Check("definition", study="rotor")
MOMENTS = Check(study="gyrostat", also=("particles",))
TURN_SOURCE = "the kinematics R^T dR/dt of any rotation, and the forms of any surface"
COSINES = Check(study="turning", also=("motion",), source=TURN_SOURCE)


def studies(_: Transcript) -> dict[str, Study]:
    """The dictionaries of this section."""
    from ..dictionary.gyroscope import WithGyroscope
    from ..dictionary.moments import gyrostat, particles
    from ..dictionary.rotor import Rotor, TurningAxes

    return {
        **WithGyroscope.derive().studies(),
        "rotor": Rotor.arbitrary().study(),
        "turning": TurningAxes().study(),
        "gyrostat": gyrostat(),
        "particles": particles(r"\mathfrak v", r"\tilde{\mathbf G}^{(M)}"),
    }


def projection(position: int) -> Check:
    """A projection of the angular momentum of body and gyroscope about the contact point."""

    def value(study: Study, _: Mapping[str, int]) -> Any:
        return study.context.moment[position]

    return Check(study="rotor", value=value)


def motion(position: int) -> Check:
    """The derived balance of moments along u, v or n."""

    def derivation(study: Study, _: Mapping[str, int]) -> list[tuple[Any, Any]]:
        found: list[tuple[Any, Any]] = study.context.terms(position)
        return found

    return Check(
        study="balance",
        truth=lambda study, where: study.context.rows[position],
        derived=derivation,
    )


PROJECTION_ROWS = (projection(0), projection(1), projection(2))
MOTION_ROWS = (motion(0), motion(1), motion(2))

GYROSCOPE = Section(
    title="Rolling of a body with a gyroscope",
    complete=True,
    label="bodyGyr",
    studies=studies,
    inline=displays(__file__, globals(), "inline"),
    sentences=SENTENCES,
    displays=displays(__file__, globals()),
)
