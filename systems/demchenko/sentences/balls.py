"""Chaplygin's balls: what the text says beside its displays."""

from __future__ import annotations

from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Quoted, Range, Reference, Sentence, Study, one_of, tight
from voronec.audit.latex.nodes import Call, Dot, Name
from voronec.audit.meaning import evaluate
from voronec.audit.structure import states_dependence
from voronec.audit.study import key_of
from voronec.kinematics import Surface

from ..dictionary.chaplygin_balls import (
    CONFIGURATIONS,
    GAMMA,
    KAPPA,
    OMEGA,
    R1,
    R2,
    SIGNED_RADIUS,
    Ball,
    momentum_is_about_contact,
    rolling_ball,
    u1,
    v1,
)
from ..dictionary.gyroscopic_balls import is_demchenkos, on_the_plane, rotor_is_kappa
from ..dictionary.rubber_balls import is_veselovas
from ..transcription import sentences
from .claims import agreement, all_of, both_sides, constant, denial, equals, holds, values

INTEGRALS = ("F_1", "F_2", "F_3", "F_4")
CONFIGURATION_NAMES = {r.name.split()[0]: r for r in CONFIGURATIONS}


def epsilon_of(formula: Quoted, study: Study) -> tuple[str, Any]:
    r"""The relation and the number of a condition on \epsilon."""
    tree = formula.tree(study)
    if len(tree.parts) != 2 or not (
        isinstance(tree.parts[0], Name) and key_of(tree.parts[0]) == r"\epsilon"
    ):
        raise vo.DefinitionError(f"'{formula.latex}' is no condition on epsilon")
    return tree.relations[0], sp.sympify(evaluate(tree.parts[1], study))


def configuration(
    study: Study, _: Range, *, case: str, surface: str, condition: Quoted
) -> vo.Verdict:
    """Rolling inside needs a larger sphere; a ball around the sphere is larger."""
    letters = {"inner": "$R_1=R_2+p$", "shell": "$R_1=p$ and $R_2=p+q$"}
    name = one_of(case, {"ii": "inner", "iii": "shell"})
    side = agreement(
        surface, {"inner": "inner", "shell": "outer"}[name], f"the surface of ({case})"
    )
    where = CONFIGURATION_NAMES[name]
    radii = {R1: -SIGNED_RADIUS}
    left, right = (
        sp.sympify(v).xreplace(radii).xreplace(dict(where.values)) for v in values(condition, study)
    )
    relation = condition.tree(study).relations[0]
    found = vo.prove_inequality(left, relation, right, where.positive)
    said = vo.Verdict(found.status, f"for {letters[name]}, {found.method}", found.witness)
    return all_of(side, said)


def signs(
    study: Study, _: Range, *, plus: Quoted, first: str, minus: Quoted, second: str, third: str
) -> vo.Verdict:
    """Epsilon is R_1/(R_1 + R_2) outside, and R_1/(R_1 - R_2) in the other two cases."""
    sign = {"$+$": 1, "$-$": -1}
    found = {"i": Ball.on_sphere(R1), "ii": Ball.on_sphere(-R1), "iii": Ball.on_sphere(-R1)}
    claimed = {first: plus, second: minus, third: minus}
    pairs = []
    for case, printed in claimed.items():
        radius = R1 + one_of(printed.latex, sign) * R2
        pairs.append((one_of(case, found).epsilon, R1 / radius))
    return all_of(agreement(set(claimed), set(found), "cases"), equals(pairs, "epsilon"))


def about(study: Study, _: Range, *, point: str) -> vo.Verdict:
    """G is what the mass matrix makes of omega."""
    one_of(point, {"contact": True})
    return momentum_is_about_contact()


def flat_limit(study: Study, _: Range, *, limit: str, to: int, sort: str) -> vo.Verdict:
    """The equations on a sphere as its radius grows or shrinks."""
    ball = Ball.on_sphere(R1)
    reached = one_of(limit, {"infinity": sp.oo, "zero": sp.Integer(0)})
    end = sp.limit(ball.epsilon.xreplace({R2: sp.Integer(1)}), R1, reached)
    found = on_the_plane(ball, Ball.on_plane())
    return all_of(
        agreement(sp.Integer(to), end, "the limit of epsilon"),
        agreement(constant(sort), True, "whether the normal of a plane is constant in space"),
        found,
    )


def density_space(study: Study, where: Range, *, dimension: Quoted, sort: str) -> vo.Verdict:
    """The density in the space of omega and gamma."""
    size = tight(dimension.latex)
    return all_of(
        agreement(size, rf"$\mathbb R^{len(OMEGA) + len(GAMMA)}({{\omega}},\gamma)$", "the space"),
        denial(one_of(sort, {"invariant": True}), study.context.measure(where)),
    )


def always_integrals(
    study: Study, where: Range, *, system: Reference, how: str, count: int
) -> vo.Verdict:
    """How many of the functions are integrals whatever epsilon."""
    found = study.context
    good = [name for name in INTEGRALS if found.constants([name], where).proved]
    rates = all(isinstance(tree.parts[0], Dot) for tree in system.trees(study))
    true = all_of(agreement(rates, True, "equations of motion"), holds_in(system, study, where))
    return all_of(
        true,
        agreement(
            one_of(how, {"always": "all", "never": "none", "sometimes": "some"}), "all", "when"
        ),
        agreement(count, len(good), f"integrals: ${', '.join(good)}$"),
        lambda: found.independent(good),
    )


def holds_in(system: Reference, study: Study, where: Range) -> vo.Verdict:
    """Whether equations hold along the motion, in a range."""
    from .claims import residuals

    gaps = [study.motion.along(g).xreplace(dict(where.values)) for g in residuals(system, study)]
    pairs = (vo.prove_equal(gap, 0, study.relations) for gap in gaps)
    return all_of(*pairs)


def fourth(study: Study, _: Range, *, epsilon: Quoted, which: int, integral: Quoted) -> vo.Verdict:
    """F_4 on the sphere of that epsilon, or on the plane."""
    relation, number = epsilon_of(epsilon, study)
    name = one_of(tight(integral.latex).strip("$").split("=")[0], {x: x for x in INTEGRALS})
    if relation != "=":
        return vo.Verdict("undecided", "not one value of epsilon")
    if number == 0:
        return vo.Verdict("undecided", "no sphere has this epsilon, which is R_1/(R_1 + R_2)")
    ball = Ball.on_plane() if number == 1 else Ball.on_sphere(number * R2 / (1 - number))
    _, function = both_sides(integral, study)
    if states_dependence(integral.tree(study)):
        return vo.Verdict("undecided", f"it does not say which function '{name}' is")
    return all_of(
        agreement(which, INTEGRALS.index(name) + 1, "its number"),
        equals([(function, study.context.integrals[name])], "the function"),
        lambda: ball.constants([name]),
    )


def tori(study: Study, _: Range, *, dimension: str) -> vo.Verdict:
    """As many dimensions as are left of the space by its integrals."""
    sizes = {f"{w}-dimensional": n for n, w in enumerate("one two three four".split(), start=1)}
    ball = Ball.on_plane()
    good = [name for name in INTEGRALS if ball.constants([name]).proved]
    return agreement(one_of(dimension, sizes), len(OMEGA) + len(GAMMA) - len(good), "dimensions")


def configurations(study: Study, _: Range, *, count: int) -> vo.Verdict:
    """Outside, inside, around: the signs of the radius, and of its size less the ball's."""
    return agreement(count, len(CONFIGURATIONS), "ranges of the signed radius")


def flat(study: Study, _: Range, *, how: str) -> vo.Verdict:
    """gamma, brought into space by the rotation of the ball, is the normal of the plane."""
    ball = rolling_ball(Surface.plane(u1, v1))
    upright = sp.Matrix(ball.contact.attitude) * sp.Matrix(ball.normal)
    place = sp.Matrix(ball.contact.fixed.position)
    products = [upright.dot(place.diff(q)) for q in (u1, v1)]
    found = equals(((x, 0) for x in products), "the normal and the axes of the plane")
    return denial(one_of(how, {"orthogonal": True, "parallel": False}), found)


def euler_jacobi(study: Study, _: Range, *, theorem: str) -> vo.Verdict:
    """An invariant measure, and two independent integrals less than there are dimensions."""
    if theorem != "euler-jacobi":
        return vo.Verdict("undecided", f"what is needed for '{theorem}' is not known here")
    return integrable(study.context)


def integrable(ball: Ball) -> vo.Verdict:
    """What Euler and Jacobi ask for, with the integrals that are known."""
    good = [name for name in INTEGRALS if ball.constants([name]).proved]
    enough = len(good) + 2 == len(OMEGA) + len(GAMMA)
    said = f"{len(good)} integrals are known, in {len(OMEGA) + len(GAMMA)} dimensions"
    known = vo.Verdict("proved" if enough else "undecided", said)
    return all_of(known, lambda: ball.independent(good), ball.measure)


def remains(study: Study, _: Range, *, sort: str, surface: str, how: str) -> vo.Verdict:
    """With a gyroscope, and three different moments of inertia, on a plane or on a sphere."""
    one_of(sort, {"non-symmetric": True})
    kinds = {"plane": Ball.on_plane, "sphere": lambda kappa: Ball.on_sphere(R1, kappa)}
    ball = one_of(surface, kinds)(KAPPA)
    if not one_of(how, {"integrable": True, "nonintegrable": False}):
        return denial(False, integrable(ball))
    return integrable(ball)


def hypersurface(study: Study, _: Range, *, sort: str, surface: Quoted) -> vo.Verdict:
    """Where an integral has one value: what begins there stays there."""
    name = r"\tilde F_4"
    shown = agreement(surface.latex, f"${name}^{{-1}}(0)$", "the level of the integral")
    found = study.context.constants([name])
    return all_of(shown, denial(one_of(sort, {"invariant": True}), found))


def double_shell(
    study: Study, _: Range, *, epsilon: Quoted, case: str, radii: Quoted
) -> vo.Verdict:
    """A shell whose radius is twice that of the sphere."""
    relation, number = epsilon_of(epsilon, study)
    left, right = both_sides(radii, study)
    ratio = sp.solve(left - right, R1)
    if len(ratio) != 1 or relation != "=":
        return vo.Verdict("undecided", "not one value of epsilon")
    made = (R1 / (R1 - R2)).xreplace({R1: ratio[0]})
    names = {"(iii)": "shell", "(ii)": "inner", "(i)": "outer"}
    inside = vo.prove_inequality(ratio[0], "<", R2)
    return all_of(
        equals([(made, number)], "epsilon of those radii"),
        inside,
        agreement(one_of(case, names), "shell", "the case in which R_1 < R_2"),
        lambda: study.context.constants([r"\tilde F_4"]),
    )


def no_twist(study: Study, _: Range, *, constraint: Quoted) -> vo.Verdict:
    """On the constraint the component of omega along the normal vanishes."""
    return holds(constraint, study, "omega along the normal of the rubber ball")


def multiplier(study: Study, _: Range, *, how: str, constraint: Quoted) -> vo.Verdict:
    """lambda makes the rate of the constraint zero."""
    whole = study.context
    rates = whole.motion.along(whole.motion.derivative(whole.motion.restrict(OMEGA).dot(GAMMA)))
    found = vo.prove_equal(rates, 0, study.relations)
    one_of(how, {"differentiation": True})
    return all_of(holds(constraint, study, "the constraint"), found)


def keeps(study: Study, where: Range, *, sort: str, density: Quoted) -> vo.Verdict:
    """Whether the flow has the printed density, on the constraint."""
    whole = study.context
    left = density.tree(study).parts[0]
    _, weight = both_sides(density, study)
    from ..dictionary.rubber_balls import AREA

    found = vo.prove_equal(vo.divergence(weight * AREA, whole.flow), 0, study.relations)
    return all_of(
        agreement(isinstance(left, (Name, Call)), True, "whether it names the density"),
        denial(one_of(sort, {"invariant": True}), found),
    )


def veselova(study: Study, _: Range, *, epsilon: Quoted) -> vo.Verdict:
    """The rubber ball on a plane; elsewhere gamma turns at another rate."""
    relation, number = epsilon_of(epsilon, study)
    return all_of(
        agreement(
            (relation, number), ("=", sp.Integer(1)), "where gamma turns as it does for a body"
        ),
        lambda: is_veselovas(study.context),
    )


def gyroscope(
    study: Study, _: Range, *, sort: str, axis: str, vector: tuple[str, ...]
) -> vo.Verdict:
    """A rotor with a coordinate of its own adds a constant vector along its axis."""
    return all_of(
        agreement(one_of(axis, {"axis": "axis", "equator": "equator"}), "axis", "its direction"),
        agreement(vector, (r"\mathbf G",), "to what it is added"),
        lambda: denial(constant(sort), rotor_is_kappa()),
    )


def over_what(study: Study, _: Range, *, surface: str, equations: Quoted) -> vo.Verdict:
    """The equations hold on every sphere; the print does not say over what the ball rolls."""
    if not surface.strip():
        return vo.Verdict(
            "refuted", "what the ball rolls over is left out; the equations hold on a sphere"
        )
    true = {"sphere": study.context, "plane": None}
    if one_of(surface.strip(), true) is None:
        return denial(False, vo.prove_equal(study.context.epsilon, 1))
    gaps = []
    for tree in equations.trees(study):
        left, right = (evaluate(part, study) for part in tree.parts)
        gaps += list(study.motion.along(left - right))
    return all_of(*(vo.prove_equal(gap, 0, study.relations) for gap in gaps))


def markeev(study: Study, _: Range, *, epsilon: Quoted, same: str, count: int) -> vo.Verdict:
    """The ball with a gyroscope on a plane: its density and its integrals."""
    relation, number = epsilon_of(epsilon, study)
    plain = Ball.on_plane()
    good = [name for name in INTEGRALS if study.context.constants([name]).proved]
    equal = vo.prove_equal(plain.density, study.context.density, study.relations)
    return all_of(
        agreement((relation, number), ("=", sp.Integer(1)), "where the plane is"),
        denial(one_of(same, {"same": True, "different": False}), equal),
        study.context.measure(),
        agreement(count, len(good), "integrals"),
        lambda: study.context.independent(good),
    )


def for_all(study: Study, where: Range, *, functions: tuple[str, ...], how: str) -> vo.Verdict:
    """Whether functions are integrals whatever epsilon."""
    found = study.context.constants(
        [one_of(x, {n: n for n in INTEGRALS}) for x in functions], where
    )
    if how in ("all", "none"):
        return denial(how == "all", found)
    return vo.Verdict("undecided", f"whether that is so for '{how}' alone is not decided here")


def demchenkos(
    study: Study, _: Range, *, first: Quoted, second: Quoted, condition: Reference
) -> vo.Verdict:
    """On the plane and on a sphere; the condition makes three moments equal."""
    from .. import SYSTEM
    from ..dictionary.ball import A1, A2, C1

    (tree,) = condition.trees(study)
    moments = Study({"C_1": C1, "A_1": A1, "A_2": A2})
    left, right = (evaluate(part, moments) for part in tree.parts)
    if left != C1:
        raise vo.DefinitionError(f"({condition.label}) is no condition on C_1")
    return all_of(
        agreement(epsilon_of(first, study), ("=", sp.Integer(1)), "the plane"),
        agreement(epsilon_of(second, study), (r"\ne", sp.Integer(1)), "a sphere"),
        lambda: is_demchenkos(SYSTEM, right),
    )


QUOTATION = "a result of others that is quoted, and not derived here"
RADII = "the radii of the two spheres, and the side on which they touch"
RUBBER = "the equations derived for the system 'rubber-ball'"


def latex_of_density(study: Study) -> str:
    """What was derived instead."""
    return study.context.wider_density()


def latex_of_surface(_: Study) -> str:
    """What was derived instead."""
    return r"\text{over the sphere}"


TEXT = sentences(__file__, globals())

SENTENCES = (
    *TEXT[:18],
    *(
        Sentence(
            r"""The system has an @sort:word{invariant} measure with the density
@density:formula{$
\mu_\epsilon(\gamma)=(\mathbf I^{-1}\gamma,\gamma)^\frac{1}{2\epsilon}
$}""",
            keeps,
            name,
        )
        for name in ("rubber", "rubber inside")
    ),
    *TEXT[18:],
)
