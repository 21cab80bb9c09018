"""Words and sketches of families refuse in a line what they cannot read."""

from __future__ import annotations

from typing import Any

import pytest
import sympy as sp

import voronec as vo
from voronec import kinematics


@pytest.mark.parametrize(
    "ask",
    [
        lambda: kinematics.euler_meanings("x'"),
        lambda: kinematics.vector_meanings(({}, 1)),
        lambda: kinematics.contact_meanings(-2.5),
        lambda: kinematics.place_meanings(3, "the hub"),
        lambda: kinematics.disc_sketch(sp.oo, "phi", "theta"),
        lambda: kinematics.particle_sketch(object()),
    ],
)
def test_one_line_says_what_to_give(ask: Any) -> None:
    with pytest.raises(vo.DefinitionError, match="give ") as refusal:
        ask()
    assert "\n" not in str(refusal.value)


def test_a_place_in_a_plane_has_two_coordinates() -> None:
    words = kinematics.place_meanings("xy", "the hub")
    assert words == {"x": "first coordinate of the hub", "y": "second coordinate of the hub"}
    with pytest.raises(vo.DefinitionError, match="two coordinates"):
        kinematics.place_meanings("xyz", "the hub")
