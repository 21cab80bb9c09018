"""The gyroscopic ball on a sphere: what the text says beside its displays."""

from __future__ import annotations

from dataclasses import replace

import sympy as sp

import voronec as vo
from voronec.audit import Quoted, Range, Reference, Study, one_of
from voronec.audit.meaning import evaluate

from ..dictionary.ball import A1, A2, C1, C2, VERTICAL, chi, theta, u
from ..transcription import sentences
from .claims import (
    AXES,
    agreement,
    all_of,
    constant,
    constraint_verdict,
    denial,
    equals,
    holds,
    residuals,
    value,
)

ACROSS = {"ball": A1, "gyroscope": A2, "ball + gyroscope": A1 + A2}
ALONG = {"ball": C1, "gyroscope": C2, "ball + gyroscope": C1 + C2}


def zhukovsky(
    study: Study, _: Range, *, one: str, relation: str, system: str, sort: str
) -> vo.Verdict:
    """The moment that makes the inertia about the contact point spherical, rotor apart."""
    table = one_of(sort, {"orthogonal": ACROSS, "parallel": ALONG})
    found = equals(
        [(one_of(one, ALONG).xreplace({C1: study.context.condition()}), one_of(system, table))],
        "the derived condition",
    )
    return denial(one_of(relation, {"=": True, "!=": False}), found)


def idle_axis(study: Study, _: Range, *, much: int) -> vo.Verdict:
    """No constraint holds the rate of the rotor's angle, so that no reaction turns it."""
    roll = study.context.rolling
    slopes = [sp.diff(constraint, vo.velocity(chi)) for constraint in roll.contact.no_slip]
    return equals(((slope, much) for slope in slopes), "the constraints by the rotor's rate")


def colatitude(study: Study, _: Range, *, sort: str) -> vo.Verdict:
    """The height of the contact point over the equator by the coordinate u."""
    height = study.context.rolling.contact.body.position[2]
    radius = sp.sqrt(sum(x**2 for x in study.context.rolling.contact.body.position))
    by = one_of(sort, {"complements": sp.cos(u), "values": sp.sin(u)})
    return equals([(height**2, (radius * by) ** 2)], "the height over the equator")


def same_angle(
    study: Study, _: Range, *, first: tuple[str, ...], second: tuple[str, ...]
) -> vo.Verdict:
    """The cosine between coordinate lines of the ball and of the sphere."""
    column, row = one_of(first[0], {"u": 0, "v": 1}), one_of(second[0], {"u_1": 0, "v_1": 1})
    turn = study.context.rolling.contact.turn
    return equals([(turn[row, column], sp.cos(theta))], "the cosine between them")


def constraints_of(study: Study, _: Range, *, constraints: Reference) -> vo.Verdict:
    """The constraints of two surfaces, for two spheres."""
    return constraint_verdict(constraints, study, f"({constraints.label}) for two spheres")


def simplification(
    study: Study, _: Range, *, constraints: Reference, forms: Reference, letters: tuple[str, ...]
) -> vo.Verdict:
    """s and tau on the constraints hold no velocity on the sphere, and n does."""
    fibre = [vo.velocity(value(x, study)) for x in ("u_1", "v_1")]
    base = [vo.velocity(value(x, study)) for x in ("u", "v", r"\vartheta")]
    solved = sp.solve(residuals(constraints, study), fibre, dict=True)
    if len(solved) != 1:
        return vo.Verdict("refuted", f"({constraints.label}) does not give those velocities")
    names = ("s", r"\tau", "n")
    rights = [evaluate(tree.parts[1], study) for tree in forms.trees(study)]
    short = set()
    if len(rights) != len(names):
        return vo.Verdict("refuted", f"({forms.label}) is not three forms")
    for name, right in zip(names, rights, strict=True):
        form = sp.expand(sp.sympify(right).xreplace(dict(study.given)).xreplace(solved[0]))
        held = [w for w in base if vo.prove_equal(sp.diff(form, w), 0).refuted]
        short |= {name} if len(held) == 1 else set()
    return all_of(
        constraint_verdict(constraints, study, f"({constraints.label})"),
        holds(forms, study, f"({forms.label}) on them"),
        agreement(set(letters), short, "expressions that are left with one term"),
    )


def by_condition(
    study: Study, _: Range, *, condition: Reference, letters: tuple[str, ...]
) -> vo.Verdict:
    """The condition is the derived one; with it the energy is one of three velocities."""
    given = dict(study.given)
    gaps = [gap.xreplace(given) for gap in residuals(condition, study)]
    energy = study.motion.restrict(study.names[r"\tilde{\mathbf{T}}"]).xreplace(given)
    names = ("s", r"\tau", "n")
    held = {x for x in names if vo.prove_equal(sp.diff(energy, value(x, study)), 0).refuted}
    return all_of(
        equals(((gap, 0) for gap in gaps), f"({condition.label}), the derived condition"),
        agreement(set(letters), held, "the energy is a function of"),
    )


def conservation(study: Study, _: Range, *, first: Quoted, second: Quoted, sort: str) -> vo.Verdict:
    """No force acts, M runs along the momentum, and so the angular momentum stays."""
    momentum = study.names[r"\tilde{\mathbf{G}}^{(M)}"]
    rate = study.motion.along(study.motion.derivative(momentum))
    found = equals(((x, 0) for x in rate), "the rate of the momentum")
    return all_of(
        holds(first, study, "the product"),
        holds(second, study, "the torque"),
        denial(constant(sort), found),
    )


def cosines(
    study: Study,
    _: Range,
    *,
    letters: tuple[str, ...],
    axis: tuple[str, ...],
    axes: tuple[str, ...],
) -> vo.Verdict:
    """The components of the vertical along the axes at the contact point."""
    vertical = {r"\mathbf z_1": VERTICAL}
    along = study.context.rolling.axes.T * one_of(axis[0], vertical)
    picked = [along[one_of(x, AXES)] for x in axes]
    return equals(zip((value(x, study) for x in letters), picked, strict=True), "cosines")


def by_integrals(study: Study, _: Range, *, momentum: Reference, energy: Reference) -> vo.Verdict:
    """The right sides of the one are components of a constant vector, the other is constant."""
    rights = [evaluate(tree.parts[1], study) for tree in momentum.trees(study)]
    length = sp.Add(*[x**2 for x in rights])
    stored = evaluate(energy.trees(study)[0].parts[1], study)
    rates = [study.motion.along(study.motion.derivative(x)) for x in (length, stored)]
    given = dict(study.given)
    return all_of(
        agreement(len(rights), len(AXES), f"components in ({momentum.label})"),
        equals(((x.xreplace(given), 0) for x in rates), "rates of the integrals"),
    )


def eight(
    study: Study,
    _: Range,
    *,
    count: int,
    dynamics: Reference,
    kinematics: Reference,
    constraints: Reference,
    letters: tuple[str, ...],
) -> vo.Verdict:
    """The equations hold along the motion, and are as many as the variables."""
    several = sum(len(x.formulas) for x in (dynamics, kinematics, constraints))
    wanted = {*study.context.eqs.coordinates, *study.context.eqs.velocities}
    return all_of(
        agreement(count, several, "equations"),
        agreement({value(x, study) for x in letters}, wanted, "variables"),
        agreement(several, len(wanted), "equations for as many variables"),
        holds(dynamics, study, f"({dynamics.label}) along the motion"),
        holds(kinematics, study, f"({kinematics.label})"),
        constraint_verdict(constraints, study, f"({constraints.label})"),
        lambda: denial(False, holds(dynamics, _free(study), f"({dynamics.label}) for any motion")),
    )


def _free(study: Study) -> Study:
    """The same where the accelerations are any."""
    return replace(study, motion=replace(study.motion, accelerations={}))


FRAMES = "true of the frames of ball and rotor, whatever their motion"
ENERGIES = "the momentum and the energy of ball and rotor"
LITERATURE = "a statement on the quadratures of others, which are not derived here"

SENTENCES = sentences(__file__, globals())
