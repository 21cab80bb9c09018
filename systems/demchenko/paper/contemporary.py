"""Demchenko's PhD thesis and contemporary nonholonomic mechanics: geometry, then balls."""

from __future__ import annotations

from voronec.audit import Section, Study, Transcript

from ..sentences.balls import SENTENCES as BALLS
from ..sentences.geometry import SENTENCES as GEOMETRY
from . import contemporary_balls as balls
from . import contemporary_geometry as geometry


def studies(_: Transcript) -> dict[str, Study]:
    """The dictionaries of this section."""
    return {**geometry.studies(), **balls.studies()}


CONTEMPORARY = Section(
    title="Demchenko's PhD thesis and contemporary nonholonomic mechanics",
    complete=True,
    label=None,
    studies=studies,
    displays=(*geometry.DISPLAYS, *balls.DISPLAYS),
    inline=(*geometry.INLINE, *balls.INLINE),
    sentences=(*GEOMETRY, *BALLS),
)
