"""What the page computes: rates, places of bodies and integrals, as one program in JavaScript."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import symengine as se
import sympy as sp

from voronec.declaration.shapes import MESH, Shape
from voronec.equations.program import Program, javascript_source
from voronec.equations.program.straight import Block
from voronec.motion.observables import watched

if TYPE_CHECKING:
    from voronec.motion.vocabulary import Vocabulary

__all__ = ["POSE", "mesh_source", "page_program", "quartic_parts"]

POSE = 15
"""How many numbers place a shape: centre, attitude row by row, contact."""


def page_program(vocabulary: Vocabulary, shapes: Sequence[Shape]) -> Program:
    """The whole equations on coordinates and velocities; its extra quantities are ``POSE`` numbers
    for each shape, then integrals, the sizes of their terms, and ``quartic_parts``."""
    placed = {
        f"shape {i} {k}": vocabulary.inward(e)
        for i, shape in enumerate(shapes)
        for k, e in enumerate((*shape.centre, *shape.attitude, *(shape.contact or (0, 0, 0))))
    }
    beside = watched(vocabulary, ())
    names = [*beside.integrals.values(), *beside.sizes.values()]
    kept = {name: beside.expressions[name] for name in names}
    return Program.of(vocabulary.equations.form, placed | kept | quartic_parts(vocabulary))


def quartic_parts(vocabulary: Vocabulary) -> dict[str, Any]:
    """Of a motion by quadratures, (dx/dtau)^2 = f(x): x, and f at -1, -1/2, 0, 1/2, 1, which fix a
    quartic, as functions of the state; nothing of other motions."""
    motion = vocabulary.equations.system.motion
    if motion is None:
        return {}
    known = dict(motion.constants)
    places = [sp.Rational(k, 2) for k in range(-2, 3)]
    values = [motion.quartic.xreplace({motion.x: place}).xreplace(known) for place in places]
    parts = [motion.meaning, *values]
    return {f"quartic {i}": vocabulary.inward(part) for i, part in enumerate(parts)}


def mesh_source(shapes: Sequence[Shape], vocabulary: Vocabulary) -> str:
    """JavaScript whose ``extras(t, (a, b), parameters)`` gives three numbers for each patch of each
    shape, one after the other."""
    parameters = tuple(se.Symbol(p.name) for p in vocabulary.equations.system.parameters)
    points = [
        vocabulary.equations.door.inward(e) for s in shapes for p in s.patches for e in p.position
    ]
    a, b = (se.Symbol(str(x)) for x in MESH)
    names = tuple(f"point {i}" for i in range(len(points)))
    program = Program(
        time=vocabulary.equations.form.time,
        coordinates=(a,),
        velocities=(b,),
        parameters=parameters,
        derivative=Block((), (se.Integer(0), se.Integer(0))),
        names=names,
        extras=Block((), tuple(points)),
    )
    return javascript_source(program)
