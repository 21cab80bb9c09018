"""Portraits of sections: several levels side by side, motions coloured by their rotation numbers,
with the lines that reversing symmetries fix.

A reversal r, f(r x) = -r f(x), takes the section plane = value to itself, and crossings upwards to
crossings upwards, where it turns the sign of the plane's quantity and the value is zero; for
crossings both ways where it leaves the quantity.  Then it acts on the points by signs of the
outputs, and the map of the section is a product of two such reflections: islands and orbits on its
fixed line are symmetric [LambRoberts1998].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from voronec.algebra.arguments import accepts
from voronec.dynamics.phase_space import PhaseSpace
from voronec.dynamics.rotation import RotationNumbers, rotation_numbers
from voronec.errors import DefinitionError, VoronecError
from voronec.motion import Section

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LARGEST_BAR = 3e-3
"""Rotation numbers with larger bars are none."""


@dataclass(frozen=True, eq=False)
class SectionPortrait:
    """Sections with the rotation ``numbers`` of their motions; ``reflections`` are the signs of the
    first two outputs under the reversals of the system that keep the section."""

    sections: tuple[Section, ...]
    numbers: tuple[RotationNumbers, ...]
    reflections: tuple[tuple[int, int], ...]

    def plot(self) -> Figure:
        """A panel for each section: dots in the colour of the motion's rotation number, grey where
        it has none or its bar is larger than ``LARGEST_BAR``, as where the motion is chaotic; with
        their images under the reflections, and the fixed lines of these."""
        from voronec.motion.pictures.section_picture import plot_levels

        values = [np.where(n.bars < LARGEST_BAR, n.values, np.nan) for n in self.numbers]
        return plot_levels(self.sections, values, self.reflections)


@accepts()
def section_portrait(
    sections: Section | Sequence[Section], centre: Sequence[float] | None = None
) -> SectionPortrait:
    """The portrait of one section, or of several of one system with the same plane and outputs.

    ``centre`` is as for ``rotation_numbers``; reversals are changes of signs of the variables, as
    they are found at random states.  ``DefinitionError`` where the sections do not belong together.
    """
    chosen = (sections,) if isinstance(sections, Section) else tuple(sections)
    if not chosen or not all(isinstance(s, Section) for s in chosen):
        raise DefinitionError("section_portrait: give a section, or several")
    kinds = {(s.system.name, s.plane, s.value, s.direction, s.outputs[:2]) for s in chosen}
    if len(kinds) > 1:
        raise DefinitionError(
            "section_portrait: the sections differ in their system, plane, value, direction or "
            "first two outputs; draw them apart"
        )
    numbers = tuple(rotation_numbers(s, centre) for s in chosen)
    return SectionPortrait(chosen, numbers, _reflections(chosen[0]))


def _reflections(section: Section) -> tuple[tuple[int, int], ...]:
    """The signs of the first two outputs under reversals that keep a section; none where outputs
    or plane are no variables."""
    names = (section.plane, *section.outputs[:2])
    values = {n: float(np.asarray(v).flat[0]) for n, v in section.parameters.items()}
    state: dict[Any, Any] = dict.fromkeys(section.outputs, 0.1)
    try:
        scene = None if "default" in section.system.scenes else state
        space = PhaseSpace.of(section.system, None, scene, values, None, names)
    except VoronecError:
        return ()
    if not {*names} <= {*space.names}:
        return ()
    places, reflections = [space.names.index(n) for n in names], set()
    for signs in space.reversals(0):
        plane, *flips = (signs[i] for i in places)
        if (plane == -1 and section.value == 0) or (plane == 1 and section.direction == 0):
            reflections.add((flips[0], flips[1]))
    return tuple(sorted(reflections))
