"""Rolling of a body with a gyroscope: what the text says beside its displays."""

from __future__ import annotations

from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Quoted, Range, Reference, Study, one_of
from voronec.audit.structure import mentions

from ..dictionary.rotor import COSINES, chi
from ..dictionary.surfaces import BASE, COORDINATES, QUASI
from ..transcription import sentences
from .claims import (
    AXES,
    agreement,
    all_of,
    constant,
    denial,
    equals,
    relative_curvature,  # noqa: F401  (named in the print)
    residuals,
    value,
)


def constant_speed(
    study: Study, _: Range, *, torque: bool, speed: str, axis: tuple[str, ...]
) -> vo.Verdict:
    """The equation of the gyroscope's angle, without a torque or with one."""
    whole, applied = study.context, sp.Symbol("torque")
    free = whole.constant_speed()
    found = free if not torque else denial(False, vo.prove_equal(applied, 0))
    if torque:
        found = vo.Verdict("refuted", "a torque about the axis changes the speed")
    return all_of(
        agreement(axis[0], r"O\mathbf z", "the axis about which the angle turns"),
        denial(constant(speed), found),
    )


PARTS = {"body": "body", "gyroscope": "gyroscope", "body + gyroscope": "both"}


def moments_of(
    study: Study, _: Range, *, whole: str, letters: tuple[str, ...], first: str, second: str
) -> vo.Verdict:
    """Which moments the letters A, B, C, C~ are, as the energy has them."""
    rotor = study.context
    across = {
        "body": rotor.body[:2],
        "gyroscope": rotor.gyroscope[:2],
        "both": [a + b for a, b in zip(rotor.body, rotor.gyroscope, strict=True)][:2],
    }
    axial = {"body": rotor.body[2], "gyroscope": rotor.gyroscope[2]}
    pairs = [
        (value(x, study), y) for x, y in zip(("A", "B"), across[one_of(whole, PARTS)], strict=True)
    ]
    pairs += [
        (value(x, study), axial[one_of(y, PARTS)])
        for x, y in zip(letters, (first, second), strict=True)
    ]
    return equals(pairs, "moments of inertia")


def without_its_spin(study: Study, _: Range, *, name: tuple[str, ...], to: int) -> vo.Verdict:
    """The momentum of body and gyroscope where the gyroscope's own speed has a value."""
    rotor = study.context
    speed = value(name[0], study)
    rate = sp.solve(speed - to, vo.velocity(chi))[0]
    made = rotor.moment.xreplace({vo.velocity(chi): rate})
    return equals(zip(made, study.names[r"\mathbf G^{(M)}"], strict=True), "the momentum")


def changed_law(study: Study, _: Range, *, which: int, laws: Reference) -> vo.Verdict:
    """Which of the laws holds the angular momentum."""
    trees = laws.trees(study)
    holding = [n for n, tree in enumerate(trees, start=1) if any("G" in x for x in mentions(tree))]
    return agreement(
        [which], holding, f"equations of ({laws.label}) that hold the angular momentum"
    )


def nothing_slips(study: Study, _: Range, *, constraint: Reference) -> vo.Verdict:
    """What makes the velocity of M over the surface that over the body."""
    (tree,) = constraint.trees(study)
    wanted = {r"\mathfrak{v}", r"\mathfrak{v}^1"}
    return agreement(set(mentions(tree)), wanted, f"what ({constraint.label}) sets equal")


def cosines(
    study: Study,
    _: Range,
    *,
    letters: tuple[str, ...],
    axis: tuple[str, ...],
    axes: tuple[str, ...],
) -> vo.Verdict:
    """The components of z along three axes."""
    along = value_of_vector(axis[0], study)
    picked = [along[one_of(x, AXES)] for x in axes]
    return equals(zip((value(x, study) for x in letters), picked, strict=True), "cosines")


def value_of_vector(name: str, study: Study) -> Any:
    """The components of a vector of the dictionary."""
    return one_of(name, {key: x for key, x in study.names.items() if isinstance(x, sp.MatrixBase)})


def by_the_same_rule(study: Study, _: Range, *, one: Quoted, others: tuple[str, ...]) -> vo.Verdict:
    """The printed equation holds, and so do those of the other two cosines."""
    (tree,) = one.trees(study)
    said = {x for x in COSINES if x in mentions(tree.parts[0])}
    gaps = (study.motion.restrict(gap) for gap in residuals(one, study))
    return all_of(
        agreement(said | set(others), set(COSINES), "cosines"),
        equals(((gap, 0) for gap in gaps), "the equation as printed"),
        lambda: study.context.cosines(),
    )


def along_fields(study: Study, _: Range, *, letters: tuple[str, ...]) -> vo.Verdict:
    """The fields are dual to s, tau, n; their brackets are those of rotations."""
    return all_of(
        agreement(
            [str(value(x, study)) for x in letters], [str(x) for x in QUASI], "quasi-velocities"
        ),
        lambda: study.context.commutators(),
    )


def eight(
    study: Study,
    _: Range,
    *,
    count: int,
    unknowns: int,
    letters: tuple[str, ...],
    others: tuple[str, ...],
) -> vo.Verdict:
    """Five coordinates and s, tau, n, each with an equation of the first order."""
    several = len(COORDINATES) + len(QUASI)
    dots = {vo.velocity(q) for q in BASE}
    return all_of(
        agreement((count, unknowns), (several, several), "equations and unknowns"),
        agreement({value(x, study) for x in letters}, {*COORDINATES, *QUASI}, "unknowns"),
        agreement({value(x, study) for x in others}, {*COORDINATES, *dots}, "the other unknowns"),
        lambda: study.context.eight(),
    )


SENTENCES = sentences(__file__, globals())
