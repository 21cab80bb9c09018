"""The Voronec principle and rolling of a body: what the text says beside its displays."""

from __future__ import annotations

import sympy as sp

import voronec as vo
from voronec.audit import Range, Reference, Study, one_of
from voronec.audit.latex.nodes import Name, Variation, walk

from ..dictionary.body import DOTS, U
from ..dictionary.surfaces import COORDINATES, FIBRE, QUASI, theta, typeset, vector, velocities
from ..transcription import sentences
from .claims import (
    agreement,
    all_of,
    constraint_verdict,
    denial,
    equals,
    relative_curvature,  # noqa: F401  (named in the print)
    residuals,
    value,
)

LETTERS = ("s", r"\tau", "n")
KINETIC = "the kinetic energy of a body, from its mass, its inertia and the contact"
FORMULA_ELSEWHERE = "the formula to which it refers"


def dependent(
    study: Study,
    _: Range,
    *,
    constraints: Reference,
    first: tuple[str, ...],
    second: tuple[str, ...],
) -> vo.Verdict:
    """The determinant of the constraints by the two velocities does not vanish."""
    chosen = [value(x[0], study) for x in (first, second)]
    matrix = vector(residuals(constraints, study)).jacobian(chosen)
    determinant = matrix[0, 0] * matrix[1, 1] - matrix[0, 1] * matrix[1, 0]
    found = vo.prove_equal(determinant, 0)
    if found.proved:
        return vo.Verdict("refuted", "the constraints do not determine them")
    solvable = constraint_verdict(constraints, study, "the constraints")
    if set(chosen) == set(velocities(FIBRE)):
        return all_of(solvable, study.context.surfaces.dependent())
    ends = [determinant.xreplace({theta: end}) for end in (sp.Integer(0), sp.pi / 2)]
    nowhere = [denial(False, vo.prove_equal(end, 0)) for end in ends]
    return all_of(solvable, *nowhere)


def determinant(study: Study) -> str:
    """That of the constraints by the two velocities."""
    area = typeset(study.context.surfaces.area[1], study.spelling)
    return rf"\det\frac{{\partial(\sqrt{{E_1}}\dot u_1,\sqrt{{G_1}}\dot v_1)}}{{\partial(\dot u_1,\dot v_1)}} = {area}"


def restricted_when(study: Study, _: Range, *, constraints: Reference, when: str) -> vo.Verdict:
    """K_1, K_2 are derivatives of T that is free, on the constraints."""
    energy, restrict = study.context.energy, study.motion.restrict
    dots = velocities(FIBRE)
    after = [restrict(sp.diff(energy, w)) for w in dots]
    before = [sp.diff(restrict(energy), w) for w in dots]
    slopes = one_of(when, {"after": after, "before": before})
    return all_of(
        constraint_verdict(constraints, study, "the constraints"),
        equals(zip(slopes, study.context.momenta, strict=True), "derivatives of T and K"),
    )


def of_angular(study: Study, _: Range, *, letters: tuple[str, ...]) -> vo.Verdict:
    """Of which velocities Theta is a function."""
    theta = study.context.quasi_energy
    held = {str(w) for w in QUASI if vo.prove_equal(sp.diff(theta, w), 0).refuted}
    return agreement({str(value(x, study)) for x in letters}, held, "Theta is a function of")


def bar_energy(study: Study, _: Range, *, constraints: Reference) -> vo.Verdict:
    """Theta-bar holds no velocity that the constraints give."""
    left = study.context.constrained_energy.free_symbols & set(velocities(FIBRE))
    return all_of(
        constraint_verdict(constraints, study, "the constraints"),
        agreement({str(x) for x in left}, set(), "velocities that are left of those"),
    )


def arm(study: Study, _: Range, *, letters: tuple[str, ...]) -> vo.Verdict:
    """On the constraints the velocity of O is - omega x OM."""
    contact = study.context.surfaces.contact
    speed = study.motion.restrict(vector(contact.centre_velocity))
    made = -study.context.spin.cross(vector(value(x, study) for x in letters))
    pairs = zip(speed, made, strict=True)
    given = dict(study.given)
    return equals(((a.xreplace(given), b.xreplace(given)) for a, b in pairs), "velocity of O")


def as_functions(
    study: Study,
    _: Range,
    *,
    letters: tuple[str, ...],
    dots: tuple[str, ...],
    kinematics: Reference,
    constraints: Reference,
) -> vo.Verdict:
    """The forms are those of the letters, and on the constraints functions of three velocities."""
    held = {str(x) for e in study.context.spin for x in e.free_symbols}
    held &= {str(w) for w in velocities(COORDINATES)}
    forms = ((gap.xreplace(dict(study.given)), 0) for gap in residuals(kinematics, study))
    return all_of(
        agreement(letters, LETTERS, "left sides"),
        agreement({str(value(x, study)) for x in dots}, held, "velocities that are left"),
        equals(forms, f"({kinematics.label}) for all velocities"),
        constraint_verdict(constraints, study, "the constraints"),
    )


def terms_with(
    study: Study, _: Range, *, principle: Reference, momenta: tuple[str, ...]
) -> vo.Verdict:
    """The principle holds the momenta, times what varies."""
    parts = [x for tree in principle.trees(study) for x in walk(tree)]
    heads = {x.head for x in parts if isinstance(x, Name)}
    varied = any(isinstance(x, Variation) for x in parts)
    return all_of(
        agreement(momenta, ("K_1", "K_2"), "momenta of the dependent velocities"),
        agreement(
            ("K" in heads, varied),
            (True, True),
            f"whether ({principle.label}) holds K and variations",
        ),
    )


def in_principle(study: Study, _: Range, *, principle: Reference) -> vo.Verdict:
    """The formula is an integral that holds the momenta and variations."""
    parts = [x for tree in principle.trees(study) for x in walk(tree)]
    kinds = {type(x).__name__ for x in parts}
    heads = {x.head for x in parts if isinstance(x, Name)}
    return agreement(
        ("Integral" in kinds, "Variation" in kinds, "K" in heads),
        (True, True, True),
        f"whether ({principle.label}) is an integral of variations with K",
    )


def force_function(study: Study, _: Range, *, sign: str) -> vo.Verdict:
    """The whole energy, sum qdot dL/dqdot - L, is T and the potential energy."""
    lagrangian = study.context.eqs.system.lagrangian
    dots = velocities(COORDINATES)
    whole = sp.Add(*[w * sp.diff(lagrangian, w) for w in dots], -lagrangian)
    factor = one_of(sign, {"negative": -1, "positive": 1})
    return equals([(U, factor * (whole - study.context.energy))], "U and the whole energy less T")


def independent(
    study: Study, _: Range, *, displacements: Reference, variations: tuple[str, ...]
) -> vo.Verdict:
    """The displacements of the fibre follow from three that are free."""
    surfaces = study.context.surfaces
    fibre = {surfaces.virtual[q]: q for q in FIBRE}
    gaps = residuals(displacements, study)
    return all_of(
        equals(((gap, 0) for gap in gaps), f"({displacements.label}) for displacements"),
        agreement(len(gaps), len(fibre), "displacements that follow"),
        agreement({value(x, study) for x in variations}, set(surfaces.variations), "free ones"),
    )


def eight(
    study: Study,
    _: Range,
    *,
    several: int,
    order: int,
    more: int,
    constraints: Reference,
    count: int,
    unknowns: int,
    letters: tuple[str, ...],
) -> vo.Verdict:
    """Each equation of the second order is two of the first one."""
    whole = study.context
    accelerations = [vo.velocity(w) for w in DOTS]
    highest = 2 if any(row.has(a) for row in whole.residuals for a in accelerations) else 1
    total = len(whole.residuals) * highest + len(constraints.formulas)
    return all_of(
        agreement((several, order), (len(whole.residuals), highest), "equations, and their order"),
        agreement(more, len(constraints.formulas), f"equations of ({constraints.label})"),
        constraint_verdict(constraints, study, "the constraints"),
        agreement((count, unknowns), (total, total), "equations of the first order, and unknowns"),
        agreement({value(x, study) for x in letters}, {*COORDINATES, *DOTS}, "unknowns"),
        lambda: whole.eight(),
    )


SENTENCES = sentences(__file__, globals())
