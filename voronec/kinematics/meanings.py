"""What the usual coordinates and velocities of bodies are, for ``System(meanings=...)``."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from voronec.algebra.arguments import reads
from voronec.kinematics.rolling import RollingContact
from voronec.kinematics.surfaces import Surface

Meanings = dict[Any, str]
ROUND = ("colatitude of the contact", "longitude of the contact")
NTH = ("first", "second")
FLAT = ("first coordinate of the contact", "second coordinate of the contact")
CURVATURE_LINES = (
    "place along the first lines of curvature",
    "place along the second lines of curvature",
)
NORMAL = "normal of the fixed surface at the contact"
"""gamma, which points into the body."""
SPIN = "angular velocity"


@reads("three angles")
def euler_meanings(angles: Sequence[Any]) -> Meanings:
    """{angle: words} of Euler's angles in the sequence zxz: precession, nutation, spin."""
    words = (
        "precession, Euler's angle about the third axis of space",
        "nutation, the angle from the third axis of space to that of the body",
        "spin, Euler's angle about the third axis of the body",
    )
    return dict(zip(angles, words, strict=True))


@reads("three names")
def vector_meanings(names: Iterable[Any], what: str = SPIN, whose: str = "the body") -> Meanings:
    """{name: words} of the components of a vector ``what`` along the axes of a body, ``whose`` they
    are, from the first on."""
    return {x: f"{what} along axis {k} of {whose}" for k, x in enumerate(names, 1)}


@reads("two coordinates")
def place_meanings(place: Sequence[Any], what: str) -> Meanings:
    """{coordinate: words} of the place of ``what`` in a plane, such as the contact on it."""
    return {x: f"{nth} coordinate of {what}" for x, nth in zip(place, NTH, strict=True)}


@reads("three names")
def moving_meanings(spins: Iterable[Any]) -> Meanings:
    """{name: words} of the angular velocity along (e_u, e_v, n), which go with the contact."""
    where = ("the direction of u", "the direction of v", "the normal")
    return {x: f"{SPIN} along {d} at the contact" for x, d in zip(spins, where, strict=True)}


@reads("two coordinates, a heading and two velocities")
def sleigh_meanings(
    place: Sequence[Any], heading: Any, rates: Iterable[Any], plane: str = "plane"
) -> Meanings:
    """{name: words} of a sleigh: where its blade is on the ``plane``, which may be another word for
    the ground, its heading, and its ``rates``: speed along the blade and rate of turning."""
    v, w = rates
    axis = "the first axis" if plane == "plane" else f"the first axis of the {plane}"
    return {
        **place_meanings(place, f"the blade on the {plane}"),
        heading: f"heading of the blade, from {axis}",
        v: "speed along the blade",
        w: "rate of turning",
    }


@reads("a contact of kinematics")
def contact_meanings(
    contact: RollingContact, body: str = "the body", on: tuple[str, str] = ROUND
) -> Meanings:
    """{name: words} of C. Neumann's coordinates of a contact; ``body`` is what the body is called,
    and ``on`` are the words for both coordinates on a surface that is no plane."""
    fixed = contact.fixed
    flat = isinstance(fixed, Surface) and tuple(fixed.position[:2]) == fixed.coordinates
    where = "the plane" if flat else "the fixed surface"
    pairs = (
        *((q, f"{word} on {body}") for q, word in zip(contact.body.coordinates, on, strict=True)),
        *(
            (q, f"{word} on {where}")
            for q, word in zip(fixed.coordinates, FLAT if flat else on, strict=True)
        ),
    )
    turned = f"angle at the contact between the coordinate lines of {body} and of {where}"
    return {**dict(pairs), contact.theta: turned}
