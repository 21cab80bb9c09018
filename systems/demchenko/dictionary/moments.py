"""The law of moments about a point that moves in any way: mass points, and a body with a rotor."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import sympy as sp

from voronec.audit import Motion, Study

from .neumann import TURN, P, rotation
from .rotor import Rotor
from .surfaces import MASS, vector

PARTICLES = 3
SPEED = sp.Symbol("omega~")
LABELLED_LETTERS = frozenset({r"\mathfrak{v}"})


def particles(trace: str, moment: str) -> Study:
    """Newton's laws for mass points that act on one another along their connecting lines.

    ``trace`` is the name of the velocity of M, which moves in any way; ``moment`` that of the
    angular momentum of all points about M.
    """
    masses = sp.symbols(f"m1:{PARTICLES + 1}", positive=True)
    places, speeds, forces = (
        [vector(sp.symbols(f"{x}{i}_1:4")) for i in range(1, PARTICLES + 1)] for x in "xwf"
    )
    point, speed = vector(sp.symbols("M_1:4")), vector(sp.symbols("dM_1:4"))
    rates = dict(zip(point, speed, strict=True))
    for i, (m, x, w) in enumerate(zip(masses, places, speeds, strict=True)):
        inner = [_strength(i, j) * (x - y) for j, y in enumerate(places) if j != i]
        rates |= dict(zip(x, w, strict=True))
        rates |= dict(zip(w, sum(inner, forces[i]) / m, strict=True))
    momenta = [m * w for m, w in zip(masses, speeds, strict=True)]
    arms = [x - point for x in places]
    none = sp.zeros(3, 1)
    names: dict[str, Any] = {
        r"\mathfrak M": sum(momenta, none),
        r"\mathbf F": sum(forces, none),
        r"\mathbf L^{(M)}": sum((a.cross(f) for a, f in zip(arms, forces, strict=True)), none),
        moment: sum((a.cross(p) for a, p in zip(arms, momenta, strict=True)), none),
        trace: speed,
    }
    note = "for mass points with inner forces along their connecting lines"
    source = f"Newton's laws for {PARTICLES} mass points"
    forces_said = {"f": "$f_{ij}$ is the component $j$ of the outer force on the mass point $i$"}
    return Study(
        names,
        motion=Motion(rates),
        labelled=LABELLED_LETTERS,
        letters=forces_said,
        note=note,
        source=source,
    )


def _strength(i: int, j: int) -> sp.Symbol:
    """What the inner force between two mass points is per distance."""
    return sp.Symbol(f"lambda_{min(i, j) + 1}{max(i, j) + 1}")


def gyrostat() -> Study:
    """A free body with a rotor, each under forces of its own and the torque of the bearings.

    Vectors have components in space; M moves in any way.  The forces on the body and those on
    the rotor have a sum and torques about O; those on the rotor have none about its axis.
    """
    matrix, omega = rotation(TURN), vector(P)
    centre, speed, point, trace, force = (
        vector(sp.symbols(f"{x}_1:4")) for x in ("O", "dO", "M", "dM", "F")
    )
    rates: dict[Any, Any] = {**_turn_rates(omega), **_euler(omega)}
    rates |= dict(zip((*centre, *point), (*speed, *trace), strict=True))
    rates |= dict(zip(speed, force / MASS, strict=True))
    arm = centre - point
    total = _spins(omega)
    moment = matrix * (total[0] + total[1]) + arm.cross(MASS * speed)
    names: dict[str, Any] = {
        r"\mathfrak M": MASS * speed,
        r"\mathbf F": force,
        r"\mathbf L^{(M)}": matrix * (_torques()[0] + _torques()[1]) + arm.cross(force),
        r"\tilde{\mathbf G}^{(M)}": moment,
        r"\mathbf G^{(M)}": moment.xreplace({SPEED: sp.Integer(0)}),
        r"\mathfrak v": trace,
    }
    note = "by the equations of Newton and Euler for a body and a rotor, with the bearings' torque"
    source = "the laws of Newton and Euler for a body and for a rotor, and the bearings' torque"
    return Study(names, motion=Motion(rates), labelled=LABELLED_LETTERS, note=note, source=source)


def _spins(omega: sp.Matrix) -> tuple[sp.Matrix, sp.Matrix]:
    """Angular momenta of body and rotor about O along x, y, z."""
    rotor = Rotor.arbitrary()
    carried = vector((omega[0], omega[1], SPEED))
    return sp.diag(*rotor.body) * omega, sp.diag(*rotor.gyroscope) * carried


def _torques() -> tuple[sp.Matrix, sp.Matrix]:
    """Torques about O of the forces on the body, and of those on the rotor."""
    return vector(sp.symbols("l_1:4")), vector((*sp.symbols("g_1:3"), 0))


def _turn_rates(omega: sp.Matrix) -> dict[Any, Any]:
    """How the rotation changes."""
    a, *rest = TURN
    b = vector(rest)
    moved = (-b.dot(omega), *(a * omega + b.cross(omega)))
    return {x: y / 2 for x, y in zip(TURN, moved, strict=True)}


def _euler(omega: sp.Matrix) -> Mapping[Any, Any]:
    """Euler's equations of body and rotor, solved: the torque of the bearings has no component
    along the axis, and with opposite signs it acts on both."""
    state = (*omega, SPEED)
    dots = sp.symbols("dp dq dr domega~")
    rates = dict(zip(state, dots, strict=True))
    bearing = vector((*sp.symbols("n_1:3"), 0))
    body, rotor = _spins(omega)
    acting = zip((body, rotor), _torques(), (bearing, -bearing), strict=True)
    laws = [
        spin.xreplace(rates) + omega.cross(spin) - torque - inner for spin, torque, inner in acting
    ]
    equations = [x for law in laws for x in law]
    solved = sp.solve(equations, [*dots, *bearing[:2]], dict=True)[0]
    return {x: solved[dot] for x, dot in rates.items()}
