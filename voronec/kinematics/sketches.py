"""Sketches of the families of systems: a body on a surface, with its coordinates named.

One looks from the side.  The body rolls on a plane or on a sphere; M is the point of contact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, hypot, radians, sin
from typing import Any

import sympy as sp

from voronec.algebra.arguments import reads
from voronec.declaration.reading import expression
from voronec.declaration.shapes import Shape
from voronec.declaration.sketch import Point, Sketch, polar
from voronec.kinematics.rolling import RollingContact

CONTACT: Point = (0.0, -1.0)
RADIUS = 1.35
"""Of the fixed sphere in the drawing."""


@dataclass(frozen=True)
class _Outline:
    """An ellipse that touches the surface: half-axes along the body's axis and across it, and the
    direction of the axis."""

    along: float
    across: float
    axis: float = 118

    @property
    def middle(self) -> Point:
        """Such that the lowest point is the contact."""
        up, aside = sin(radians(self.axis)), cos(radians(self.axis))
        height = hypot(self.along * up, self.across * aside)
        return (self.along**2 - self.across**2) * up * aside / height, CONTACT[1] + height


BODIES = {
    "ball": _Outline(1.0, 1.0),
    "ellipsoid": _Outline(1.25, 0.85),
    "disc": _Outline(0.2, 1.1, 155),
    "torus": _Outline(0.5, 1.25, 110),
    "body": _Outline(1.15, 0.95, 130),
}


def _join(names: Sequence[Any]) -> str:
    return f"({', '.join(map(str, names))})"


def plane(sketch: Sketch, place: Sequence[Any] = (), spin: Any = "") -> Sketch:
    """A plane in perspective, with its axes, or a table that turns."""
    sketch = sketch.area((-2.1, -1.5), (1.5, -1.5), (2.1, -0.6), (-1.5, -0.6))
    if place:
        x, y = place
        corner = (-1.75, -1.35)
        sketch = sketch.arrow(corner, (-0.95, -1.35), x).arrow(corner, (-1.4, -0.85), y)
    return sketch.turn((1.6, -0.9), 90, 0.25, spin) if spin else sketch


def sphere(sketch: Sketch, u: Any = "", v: Any = "") -> Sketch:
    """A sphere below the contact, with colatitude and longitude."""
    centre = (0.0, CONTACT[1] - RADIUS)
    sketch = sketch.ellipse(centre, RADIUS, RADIUS).ring(centre, RADIUS, 0.3, -35)
    if not u:
        return sketch
    axis = 40
    sketch = sketch.line(centre, CONTACT, look="thin")
    sketch = sketch.arrow(centre, polar(centre, RADIUS + 0.6, axis))
    sketch = sketch.angle(centre, 0.6, axis, 90, u)
    return sketch.turn(polar(centre, RADIUS + 0.3, axis), axis, 0.24, v)


@reads("coordinates and names")
def rolling_sketch(
    *,
    on: str = "plane",
    body: str = "ball",
    contact: Sequence[Any] = (),
    place: Sequence[Any] = (),
    attitude: Sequence[Any] = (),
    turned: Any = "",
    gamma: Sequence[Any] = (),
    centre: Sequence[Any] = (),
    support: Sequence[Any] = (),
    height: Any = "",
    spin: Any = "",
    wheel: Any = "",
    mass: Any = "",
    arm: Sequence[Any] = (),
    lines: Sequence[Sequence[Any]] = (),
    note: str = "",
) -> Sketch:
    """A body that rolls on a surface.

    on, body
        ``plane``, ``sphere`` or ``table`` (a plane that turns at the rate ``spin``); ``ball``,
        ``ellipsoid``, ``disc``, ``torus`` or ``body``.
    contact, place
        colatitude and longitude of the contact on the body; where it is on the surface: x and y,
        or colatitude and longitude.
    attitude
        three Euler angles: about the vertical, of the axis, about the axis.
    turned
        the angle about the common normal.
    gamma, centre, support, height
        components of the normal; coordinates of the centre; what else is carried along at the
        contact; how high the centre is over the tangent plane.
    wheel, mass
        the momentum of a gyroscope inside; how far the mass centre is off the middle.
    arm, lines
        components of the vector from the middle to the contact, and of two directions there.
    note
        a word at the body.
    """
    outline = BODIES[body]
    middle = outline.middle
    sketch = Sketch("seen from the side")
    sketch = sphere(sketch, *place) if on == "sphere" else plane(sketch, place, spin)
    sketch = sketch.ellipse(middle, outline.along, outline.across, outline.axis)
    if body == "torus":
        sketch = sketch.ellipse(middle, 0.14, 0.6, outline.axis)
    if wheel:
        sketch = _gyroscope(sketch, middle, outline.axis, wheel)
    sketch = _axis(sketch, outline, contact, attitude)
    if mass:
        sketch = sketch.dot(polar(middle, 0.45, outline.axis), mass, 180)
    sketch = _contact_marks(sketch, turned, gamma, bool(attitude))
    if centre:
        sketch = sketch.dot(middle).line(middle, (1.3, 0.55), look="thin")
        sketch = sketch.text((1.75, 0.62), _join(centre))
    if height:
        sketch = sketch.distance(CONTACT, (0.0, middle[1]), height, -1.45)
    if note:
        sketch = sketch.text((1.55, 0.95), note)
    sketch = sketch.dot(CONTACT, f"M{_join(support)}" if support else "M", -25)
    if arm:
        sketch = sketch.arrow(middle, CONTACT).text((-1.85, -0.15), _join(arm))
        sketch = sketch.line((-1.3, -0.2), (-0.2, -0.45), look="thin")
    if lines:
        ahead, aside = lines
        sketch = sketch.arrow(CONTACT, (-1.0, -1.0), _join(ahead))
        sketch = sketch.arrow(CONTACT, (0.75, -0.55)).text((1.35, -0.45), _join(aside))
    return sketch


def _contact_marks(sketch: Sketch, turned: Any, gamma: Sequence[Any], low: bool) -> Sketch:
    """The angle about the normal, and the normal: ``low`` where angles are drawn above."""
    if turned:
        sketch = sketch.turn((0.0, -0.7), 90, 0.24, turned)
    if gamma and low:
        return sketch.arrow(CONTACT, (0.0, -0.4)).text((-0.42, -0.5), _join(gamma))
    return sketch.arrow(CONTACT, (0.0, 1.3), _join(gamma)) if gamma else sketch


def _axis(
    sketch: Sketch,
    outline: _Outline,
    contact: Sequence[Any],
    attitude: Sequence[Any],
    middle: Point | None = None,
) -> Sketch:
    """The axis of the body, with what is measured from it and about it."""
    if not contact and not attitude:
        return sketch
    middle, axis = middle or outline.middle, outline.axis
    reach = max(outline.along, 0.55) + 0.6
    sketch = sketch.arrow(middle, polar(middle, reach, axis))
    about = polar(middle, reach - 0.25, axis)
    if contact:
        sketch = sketch.line(middle, CONTACT, look="thin")
        sketch = sketch.angle(middle, 0.42, axis, 270, contact[0])
        return sketch.turn(about, axis, 0.24, contact[1])
    first, tilt, last = attitude
    top = middle[1] + 1.75
    sketch = sketch.line(middle, (middle[0], top), look="dashed")
    sketch = sketch.turn((middle[0], top - 0.2), 90, 0.24, first)
    sketch = sketch.angle(middle, 0.62, 90, axis, tilt)
    return sketch.turn(about, axis, 0.24, last)


def _gyroscope(sketch: Sketch, middle: Point, axis: float, wheel: Any) -> Sketch:
    """A wheel that spins inside."""
    at = polar(middle, 0.5, -15)
    sketch = sketch.line(polar(at, -0.16, axis), polar(at, 0.16, axis), look="thin")
    return sketch.ellipse(at, 0.06, 0.22, axis).text((at[0] + 0.24, at[1] + 0.16), wheel)


@reads("coordinates of the contact and names")
def ball_sketch(
    contact: Sequence[Any], place: Sequence[Any], turned: Any, rotor: Sequence[Any] = ()
) -> Sketch:
    """A ball in Neumann's coordinates, on a plane in x and y, else on a sphere.

    ``rotor`` is the momentum of a gyroscope, along the axes of the ball.
    """
    flat = tuple(map(str, place)) == ("x", "y")
    return rolling_sketch(
        on="plane" if flat else "sphere",
        contact=contact,
        place=place,
        turned=turned,
        wheel=wheel_of(rotor),
    )


def wheel_of(rotor: Sequence[Any]) -> str:
    """What a gyroscope is called: its momentum along the axis, or the vector."""
    if not any(rotor):
        return ""
    return "kappa" if any(rotor[:-1]) else str(rotor[-1])


def contact_views(
    contact: RollingContact, centre: Sequence[Any], further: Sequence[Any] = ()
) -> dict[str, Any]:
    """What ``rolling_sketch`` shows of a body on a sphere whose motion carries along C. Neumann's
    coordinates of the ``contact``, the ``centre`` seen from it, and ``further`` coordinates."""
    return {
        "on": "sphere",
        "place": contact.fixed.coordinates,
        "turned": contact.theta,
        "centre": centre,
        "support": (*contact.body.coordinates, *further),
    }


@reads("two coordinates and a heading")
def sleigh_sketch(place: Sequence[Any], heading: Any, ahead: Any = "", left: Any = "") -> Sketch:
    """A body with a blade, from above: its centre of mass ``ahead`` of the blade and ``left``."""
    at, course = (1.2, 0.8), 32.0
    centre = polar(at, 1.0, course)
    if left:
        centre = polar(centre, 0.3, course + 90)
    sketch = Sketch("seen from above").axes(place[0], place[1], size=0.8)
    sketch = sketch.box(polar(at, 0.5, course), 2.1, 1.0, course).wheel(at, course, 0.6)
    sketch = sketch.line(at, (at[0] + 1.5, at[1]), look="dashed")
    sketch = sketch.line(at, polar(at, 2.0, course), look="dashed")
    sketch = sketch.angle(at, 1.3, 0, course, heading).dot(at, _join(place), -100)
    sketch = sketch.dot(centre, "C", 30)
    if left:
        sketch = sketch.distance(polar(at, 1.0, course), centre, left, -0.2)
    if not ahead:
        return sketch
    return sketch.distance(at, polar(at, 1.0, course), ahead, 0.28)


@reads("two coordinates, a heading and a length")
def sleigh_shapes(place: Sequence[Any], heading: Any, ahead: Any) -> tuple[Shape, ...]:
    """A sleigh as it is drawn in space: its body with the centre of mass ``ahead`` of the blade at
    (x, y), the blade along the ``heading``, and the plane below."""
    x, y = (expression(q, "a coordinate of a sleigh") for q in place)
    turn, reach = expression(heading, "a heading"), expression(ahead, "a length")
    middle = (x + reach * sp.cos(turn), y + reach * sp.sin(turn), 0.25)
    blade = Shape.box((0.3, 0.04, 0.2), centre=(x, y, 0.1), attitude=turn, contact=(x, y, 0))
    return Shape.box((0.8, 0.4, 0.1), centre=middle, attitude=turn), blade, Shape.plane()


@reads("two coordinates, a heading and an angle")
def disc_sketch(place: Sequence[Any], heading: Any, rolled: Any, lean: Any = "") -> Sketch:
    """A disc on its edge, from the side: ``place`` has the two coordinates of its contact, its
    ``heading`` is the angle in the plane, ``rolled`` that about its axle, and ``lean``, where
    there is one, that from the vertical."""
    tilt = 17.0 if lean else 0.0
    middle = polar(CONTACT, 1.1, 90 + tilt)
    ahead = (1.0, -0.68)
    sketch = plane(Sketch("seen from the side"), place)
    sketch = sketch.line(CONTACT, (1.25, -1.0), look="dashed")
    sketch = sketch.arrow(CONTACT, ahead).angle(CONTACT, 0.85, 0, 18, heading)
    sketch = sketch.ellipse(middle, 0.5, 1.1, tilt)
    mark = (middle[0] + 0.34, middle[1] + 0.8)
    sketch = sketch.line(middle, CONTACT, look="thin").line(middle, mark, look="thin").dot(middle)
    sketch = sketch.angle(middle, 0.4, 270 + tilt, 427, rolled)
    if lean:
        sketch = sketch.line(CONTACT, (0.0, 1.5), look="dashed")
        sketch = sketch.angle(CONTACT, 2.35, 90, 90 + tilt, lean)
    return sketch.dot(CONTACT, f"M{_join(place)}", -110)


@reads("names")
def pinned_sketch(
    attitude: Sequence[Any] = (), gamma: Sequence[Any] = (), still: str = ""
) -> Sketch:
    """A body about a fixed point: Euler's angles, or a fixed direction as the body sees it;
    ``still`` says about which axis it does not turn."""
    sketch = Sketch("seen from the side").ellipse((0, 0), 1.1, 0.75, 118)
    sketch = sketch.area((0.0, 0.0), (-0.16, -0.32), (0.16, -0.32))
    sketch = sketch.line((-0.4, -0.32), (0.4, -0.32))
    if gamma:
        sketch = sketch.arrow((0, 0), (0.0, 1.5), _join(gamma))
    if attitude:
        sketch = _axis(sketch, _Outline(1.1, 1.1), (), attitude, (0.0, 0.0))
    if still:
        sketch = sketch.text((0.0, -1.35), still)
    return sketch.dot((0.0, 0.0), "O", -20)


@reads("names of three components")
def particle_sketch(gamma: Sequence[Any]) -> Sketch:
    """A particle on the unit sphere, from the side: its place is ``gamma``, three names."""
    sketch = Sketch("seen from the side").ellipse((0, 0), 1.2, 1.2).ring((0, 0), 1.2, 0.3)
    tip = polar((0, 0), 1.2, 55)
    return sketch.dot((0, 0), "O", 200).arrow((0, 0), tip).dot(tip, _join(gamma), 35)


def bowl_sketch(
    place: Any,
    azimuth: Any,
    attitude: Sequence[Any],
    outline: Sequence[Point] | None = None,
    measured: tuple[Point, Point] | None = None,
) -> Sketch:
    """A ball in a bowl, from the side: its ``place`` on the meridian, ``measured`` between two
    points, and the ``azimuth`` of its centre, with Euler's angles; ``outline`` is the bowl."""
    centre, radius = (1.15, 1.05), 0.545
    parabola = [(k / 10, 0.28 * (k / 10) ** 2) for k in range(-22, 23)]
    sketch = Sketch("seen from the side").line(*(outline or parabola))
    sketch = sketch.arrow((0.0, 0.0), (0.0, 2.3)).turn((0.0, 2.0), 90, 0.3, azimuth)
    sketch = sketch.ellipse(centre, radius, radius)
    for end in ((0.0, 1.05), (1.15, 2.2)):
        sketch = sketch.line(centre, end, look="dashed")
    sketch = sketch.distance(*(measured or ((0.0, 1.05), centre)), place, 0.15)
    alpha, beta, psi = attitude
    sketch = sketch.turn((1.15, 2.05), 90, 0.22, alpha).arrow(centre, (2.1, 1.85))
    sketch = sketch.angle(centre, 0.75, 90, 40, beta).turn((1.93, 1.7), 40, 0.22, psi)
    return sketch.dot(centre, "C", -60)
