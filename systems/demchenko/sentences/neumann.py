"""Rolling without slipping in Neumann's variables: what the text says beside its displays."""

from __future__ import annotations

from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Quoted, Range, Reference, Sentence, Study, one_of
from voronec.audit.meaning import evaluate

from ..dictionary.surfaces import BASE, COORDINATES, QUASI, SLIP, typeset, vector
from ..transcription import sentences
from .claims import (
    AXES,
    agreement,
    all_of,
    both_sides,
    constraint_verdict,
    denial,
    equals,
    left_sides,
    residuals,
    value,
)

FIXED_AXES = {r"\mathbf u_1": 0, r"\mathbf v_1": 1, r"\mathbf n_1": 2}
HANDS = {"negative": -1, "left-handed": -1, "positive": 1, "right-handed": 1}


def orientation(study: Study, _: Range, *, sort: str) -> vo.Verdict:
    """[x, y] = z, as the paper has it, is the usual product in a frame of which orientation."""
    product, z = study.context
    return equals([(product[2], one_of(sort, HANDS) * z[2])], "[x,y] along z, by the usual product")


def usual_sign(study: Study, _: Range, *, product: Quoted, differs: str) -> vo.Verdict:
    """In a frame of negative orientation the usual product of x and y is -z."""
    left, right = both_sides(product, study)
    sign = one_of(differs, {"differs": -1, "agrees": 1})
    return equals(zip(left, sign * right, strict=True), "by the usual product")


def neumann_angle(
    study: Study,
    _: Range,
    *,
    angle: tuple[str, ...],
    first: tuple[str, ...],
    second: tuple[str, ...],
) -> vo.Verdict:
    """The cosine between an axis of the fixed surface and one of the body."""
    turn = study.context.surfaces.contact.turn
    if first[0] in AXES:
        first, second = second, first
    row, column = one_of(first[0], FIXED_AXES), one_of(second[0], AXES)
    cosine = sp.cos(value(angle[0], study))
    return equals([(turn[row, column], cosine)], "the cosine between the two axes")


FRAMES = {
    r"$O\mathbf x\mathbf y\mathbf z$": "body",
    r"$M\mathbf u\mathbf v\mathbf n$": "contact",
    r"$M\mathbf u_1\mathbf v_1\mathbf n_1$": "fixed",
    r"$O_1\mathbf x_1\mathbf y_1\mathbf z_1$": "space",
}


def relative_turn(
    study: Study, _: Range, *, letter: str, moving: Quoted, rest: Quoted
) -> vo.Verdict:
    """The letter is the angular velocity of one frame against the other, R^T dR/dt of each."""
    spins = study.context.spins
    first, second = (spins[one_of(frame.latex, FRAMES)] for frame in (moving, rest))
    named = evaluate(Quoted(f"${letter}$").tree(study).parts[0], study)
    gap = (first - second - named).xreplace(dict(study.given))
    return equals(((entry, 0) for entry in gap), "the angular velocities")


def turns() -> tuple[Sentence, ...]:
    """The four lines of the display that defines the angular velocities."""
    line = (
        r"@letter:word{%s}\colon \text{of @moving:formula{%s} with respect to @rest:formula{%s}%s}"
    )
    body, contact, fixed, space = FRAMES
    end = r", i.e., the angular velocity of the body $\mathrm T$"
    rows = (
        (r"\omega", body, space, end),
        (r"\omega_1 ", body, contact, ""),
        (r"\omega_2 ", contact, fixed, ""),
        (r"\omega_3 ", fixed, space, ""),
    )
    return tuple(Sentence(line % row, relative_turn) for row in rows)


def moving_contact(study: Study, _: Range, *, how: str) -> vo.Verdict:
    """The velocity of M is zero for no motion but rest."""
    speed = study.names[r"\mathfrak v^1"]
    found = equals(((x.xreplace(dict(study.given)), 0) for x in speed), "the velocity of M")
    return denial(one_of(how, {"=": True, "!=": False}), found)


VELOCITIES = {r"\mathfrak v^1": "absolute", r"\mathfrak v": "relative"}


def traces(
    study: Study,
    _: Range,
    *,
    names: tuple[str, ...],
    first: str,
    second: str,
    place: Reference,
    other: Reference,
) -> vo.Verdict:
    """The rate of a place holds the same velocities as the vector that is said to be it."""
    motion, steps = study.motion, []
    for name, sort, where in zip(names, (first, second), (place, other), strict=True):
        steps.append(agreement(sort, one_of(name, VELOCITIES), f"the velocity ${name}$"))
        rates = [motion.derivative(x) for x in left_sides(where, study)]
        held = {w for e in rates for w in e.free_symbols} & set(motion.rates.values())
        mine = {w for e in study.names[name] for w in e.free_symbols} & set(motion.rates.values())
        steps.append(agreement(held, mine, f"velocities in ${name}$"))
    return all_of(*steps)


def left_side_of(
    study: Study, _: Range, *, name: tuple[str, ...], side: str, condition: Reference
) -> vo.Verdict:
    """m is a side of the usual condition."""
    parts = condition.trees(study)[0].parts
    part = parts[one_of(side, {"left": 0, "right": 1})]
    found = evaluate(part, study)
    mine = study.names.get(name[0])
    if mine is None or not isinstance(found, sp.MatrixBase):
        return vo.Verdict("refuted", f"the {side} side of ({condition.label}) is not {name[0]}")
    return equals(zip(mine, found, strict=True), f"${name[0]}$ and the {side} side")


def same_condition(
    study: Study, _: Range, *, first: Reference, how: str, second: Reference
) -> vo.Verdict:
    """Both say that the same vector vanishes, whatever the five velocities."""
    ours, theirs = residuals(first, study), residuals(second, study)
    if len(ours) != len(theirs) or first.label == second.label:
        return vo.Verdict("refuted", f"({first.label}) and ({second.label}) are not two conditions")
    found = equals(zip(ours, theirs, strict=True), "what vanishes in both")
    return denial(one_of(how, {"equivalent": True, "contrary": False}), found)


def projections(
    study: Study,
    _: Range,
    *,
    letters: tuple[str, ...],
    first: tuple[str, ...],
    second: tuple[str, ...],
    axes: tuple[str, ...],
) -> vo.Verdict:
    """The letters are the components of two vectors along three axes, in this order."""
    frame, given = study.context.axes, dict(study.given)
    columns = [one_of(axis, AXES) for axis in axes]
    vectors = [
        study.names[one_of(x[0], {r"\omega": r"\omega", r"\mathfrak m": r"\mathfrak m"})]
        for x in (first, second)
    ]
    along = [(frame[:, c].T * v)[0] for v in vectors for c in columns]
    if len(letters) != len(along):
        return vo.Verdict("refuted", f"{len(letters)} letters for {len(along)} projections")
    pairs = zip((value(x, study) for x in letters), along, strict=True)
    return equals(((a.xreplace(given), b.xreplace(given)) for a, b in pairs), "projections")


def linear_forms(
    study: Study, _: Range, *, letters: tuple[str, ...], sort: str, dots: tuple[str, ...], back: str
) -> vo.Verdict:
    """Linear forms in the five velocities, with a determinant that does not vanish everywhere."""
    whole, found = study.context, study.context.velocities_from_projections()
    order = {
        **{x: i for i, x in enumerate(("s", r"\tau", "n"))},
        r"\mathfrak m_\mathbf u": 3,
        r"\mathfrak m_\mathbf v": 4,
    }
    forms = [whole._forms[one_of(x, order)] for x in letters]
    velocities = vector(value(x, study) for x in dots)
    matrix = vector(forms).jacobian(velocities)
    one_of(back, {"vice-versa": True})
    return all_of(
        agreement(
            one_of(sort, {"homogenous linear": 1, "homogeneous linear": 1, "quadratic": 2}),
            1,
            "degree",
        ),
        agreement(len(set(letters)), len(set(dots)), "forms for as many velocities"),
        equals(zip(forms, matrix * velocities, strict=True), "linear forms"),
        found,
    )


def gives_constraints(
    study: Study, _: Range, *, condition: Reference, first: Quoted, second: Quoted
) -> vo.Verdict:
    """Along u and v the condition is m_u = 0 and m_v = 0."""
    frame, given = study.context.axes, dict(study.given)
    along = frame.T * vector(residuals(condition, study))
    gaps = [residuals(one, study)[0] for one in (first, second)]
    pairs = zip(along[:2], gaps, strict=True)
    return equals(((a.xreplace(given), b) for a, b in pairs), "what vanishes along u and v")


def idle(study: Study, _: Range, *, acts: bool, point: tuple[str, ...]) -> vo.Verdict:
    """A reaction is a force at M: it has no torque about it, and one about O."""
    if point[0] != "M":
        one_of(point[0], {"O": 0})
        force = vector(sp.symbols("X_u X_v X_n"))
        torque = study.context.surfaces.arm.cross(force)
        return denial(
            not acts, equals(((x, 0) for x in torque), "the torque of a force at M about O")
        )
    return denial(not acts, study.context.idle())


def energy_letters(study: Study, _: Range, *, letters: tuple[str, ...]) -> vo.Verdict:
    """The arguments of the energy: the projections of m, and those of omega."""
    if len(letters) != len(SLIP) + len(QUASI):
        return vo.Verdict("refuted", f"{len(letters)} letters for {len(SLIP) + len(QUASI)}")
    pairs = zip(letters, (*SLIP, *QUASI), strict=True)
    return all_of(
        *(equals([(value(x, study), y)], f"${x}$ as a projection of m or omega") for x, y in pairs)
    )


def starts_from(
    study: Study, _: Range, *, constraints: Reference, kinematics: Reference
) -> vo.Verdict:
    """The one formula constrains the velocities, the other one holds for all of them."""
    given = dict(study.given)
    found = ((gap.xreplace(given), 0) for gap in residuals(kinematics, study))
    return all_of(
        constraint_verdict(constraints, study, f"({constraints.label}) where nothing slips"),
        equals(found, f"({kinematics.label}) for all velocities"),
    )


def equation_count(
    study: Study,
    _: Range,
    *,
    count: int,
    unknowns: int,
    letters: tuple[str, ...],
    others: tuple[str, ...],
) -> vo.Verdict:
    """Of the first order: the moments about M, the constraints, and the forms s, tau, n."""
    surfaces = study.context.surfaces
    several = 2 * len(surfaces.spin) + len(surfaces.contact.no_slip)
    names = {str(q) for q in COORDINATES}
    symbols = [
        {str(value(x, study)) for x in some if x not in QUASI_LETTERS} for some in (letters, others)
    ]
    dots = {str(vo.velocity(q)) for q in BASE}
    return all_of(
        agreement(count, several, "equations"),
        agreement(unknowns, several, "unknown functions"),
        agreement((len(set(letters)), len(set(others))), (several, several), "letters"),
        agreement(set(letters) & set(QUASI_LETTERS), set(QUASI_LETTERS), "angular velocities"),
        agreement(symbols[0], names, "coordinates"),
        agreement(symbols[1], names | dots, "coordinates and independent velocities"),
    )


QUASI_LETTERS = ("s", r"\tau", "n")


def determinant(study: Study) -> str:
    """The determinant on which it depends, in the paper's names."""
    context: Any = study.context
    text = (
        r"\frac{\partial(s,\tau,n,\mathfrak m_\mathbf u,\mathfrak m_\mathbf v)}"
        r"{\partial(\dot u,\dot v,\dot u_1,\dot v_1,\dot\vartheta)}"
    )
    return f"{text} = {typeset(context.determinant, study.spelling)}"


def latex_of_slip(_: Study) -> str:
    """What was derived instead."""
    return r"\mathfrak m_\mathbf v"


SENTENCES = sentences(__file__, globals())
