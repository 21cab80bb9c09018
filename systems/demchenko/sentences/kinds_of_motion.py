"""Back to the Demchenko case: how many roots, where the motion runs, what the traces look like."""

from __future__ import annotations

import re
from itertools import product
from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Interval, Quoted, Range, Study, one_of

from .. import k
from ..dictionary.kinds_of_motion import (
    at_state,
    chain_of,
    even_count,
    gaps_text,
    outer_gaps,
    single_gap,
    without_roots,
)
from ..dictionary.quadratures import C5, GAMMA, INERTIA, ROOTS, h, level, p, share, x
from ..dictionary.trajectories import equal_steps, regular_at_poles, rests, turns
from ..transcription import sentences
from .claims import agreement, all_of, constant, denial, exists, sides

CASES = (0, 2, 4)
"""How many real roots there can be, counted with multiplicity."""
LARGEST = ("x^{I}", "x^{IV}", "x^{III}", "x^{II}")
"""The roots in the order that the paper gives them, the largest first."""


def counts(_: Study, where: Range, *, how: str, least: int, middle: int, most: int) -> vo.Verdict:
    """The numbers of real roots that occur, where no two roots coincide."""
    even = even_count(Study({}), where)
    if how != "generic":
        return exists(how, even, _double_root(where))
    bodies = [body_of(where, ratio) for ratio in (sp.Rational(1, 20), 1, 20)]
    seen = {_roots(one, constants) for one in bodies for constants in _levels()}
    return all_of(even, agreement({least, middle, most}, seen, "numbers of real roots that occur"))


def _levels() -> list[dict[Any, Any]]:
    """Values of the constants, for k = 1."""
    grid = product((0, 1), (sp.Rational(1, 2), 2), (sp.Rational(1, 9), 1, 4))
    return [{C5: c, h: e, GAMMA: g} for c, e, g in grid]


def body_of(where: Range, ratio: Any) -> dict[Any, Any]:
    """A body of a range with I = 1, by the number that the ratio of the radii comes from."""
    numbers = {p: sp.sympify(ratio), share: sp.Integer(1), INERTIA: sp.Integer(1)}
    return {**numbers, **{a: e.xreplace(numbers) for a, e in where.values.items()}, k: 1}


def _roots(numbers: dict[Any, Any], constants: dict[Any, Any]) -> int:
    values = [c.xreplace(constants).xreplace(numbers) for c in level().quartic.all_coeffs()]
    return int(sp.Poly(values, x).count_roots())


def _double_root(where: Range) -> vo.Verdict:
    """A motion along a parallel: a double root, so that the number of roots is another one."""
    from .special_solutions import precession_at

    X = sp.Poly(at_state(level().X, precession_at(where)), x)
    number = X.count_roots()
    status = "proved" if number % 2 or sp.discriminant(X, x) == 0 else "undecided"
    return vo.Verdict(status, f"on a regular precession two roots coincide; {number} are left")


def no_motion(study: Study, where: Range, *, case: int, moves: str) -> vo.Verdict:
    """Whether a case produces a motion: the first one has no real root."""
    some = one_of(moves, {"not produce any": False, "produce": True, "produce a": True})
    if not 1 <= case <= len(CASES):
        return vo.Verdict("refuted", f"there are {len(CASES)} cases")
    if case == 1:
        return denial(not some, without_roots(study, where))
    return denial(some, vo.Verdict("proved", f"with {CASES[case - 1]} real roots there is motion"))


def gaps(
    study: Study, where: Range, *, count: int, order: Quoted, upper: Interval, lower: Interval
) -> vo.Verdict:
    """Between which roots x runs, and whether the ends are printed the smaller first."""
    roots, relations = sides(order, ROOTS | dict.fromkeys(LARGEST))
    if relations != (">",) * (len(roots) - 1) or len(set(roots)) != len(roots):
        return vo.Verdict("refuted", "the roots are not put in an order")
    wanted = {frozenset(roots[:2]), frozenset(roots[2:])}
    found = all_of(
        agreement(count, len(roots), "roots that are ordered"),
        agreement({frozenset((i.low, i.high)) for i in (upper, lower)}, wanted, "ends"),
        lambda: outer_gaps(study, where),
    )
    if not found.proved:
        return found
    turned = [i for i in (upper, lower) if roots.index(i.low) < roots.index(i.high)]
    if not turned:
        return found
    first = turned[0]
    about = f"{first.low} > {first.high}, so that no number lies in ({first.low}, {first.high})"
    return vo.Verdict("refuted", f"{about}; with the ends exchanged it is true: {found.method}")


def between_the_roots(_: Study) -> str:
    """The two intervals as they must be printed, as LaTeX."""
    return r"x\in(x^{IV},x^{I})\ \text{or}\ x\in(x^{II},x^{III});\quad " + gaps_text(_)


def without_loss(study: Study, where: Range, *, case: int, gap: Interval) -> vo.Verdict:
    """Turning the axis round exchanges the two intervals: X(-x) with -C_5 is X(x)."""
    own = level()
    mirrored = own.X.subs({x: -x, C5: -C5}, simultaneous=True)
    chosen = LARGEST[:2] if case == 1 else LARGEST[2:]
    return all_of(
        agreement(gap.variable, "x", "what lies in it"),
        chain_of(("X(-x) for -C_5 is X(x)", vo.prove_equal(mirrored, own.X))),
        lambda: between(chosen, gap),
    )


def between(roots: tuple[str, ...], *intervals: Interval) -> vo.Verdict:
    """Whether intervals lie between two roots, the larger of which is given first: without their
    ends, since a root that coincides with one of them is a case of its own."""
    ends = {frozenset((i.low, i.high)) for i in intervals}
    turned = [i for i in intervals if (i.low, i.high) == roots]
    found = all_of(
        agreement(ends, {frozenset(roots)}, "the ends of the interval in which x runs"),
        agreement({i.closed for i in intervals}, {(False, False)}, "whether its ends belong to it"),
    )
    if not found.proved or not turned:
        return found
    about = f"{roots[0]} > {roots[1]}, so that no number lies in ({roots[0]}, {roots[1]})"
    return vo.Verdict("refuted", f"{about}; with the ends exchanged it is true")


def upright(_: Study) -> str:
    """The interval as it must be printed, as LaTeX."""
    return r"(x^{IV},x^{I})"


def two_roots(study: Study, where: Range, *, count: int, order: Quoted) -> vo.Verdict:
    """With two real roots x runs between them, as between the two largest of four."""
    roots, relations = sides(order, ROOTS | dict.fromkeys(LARGEST))
    return all_of(
        agreement(count, 2, "roots, for two names"),
        agreement(tuple(roots), LARGEST[:2], "names, as of the two largest roots of four"),
        agreement(relations, (">",), "order"),
        lambda: single_gap(study, where),
    )


IN_TURN = {"alternatively": True, "alternately": True, "once": False, "never": False}


def parallels(
    study: Study, where: Range, *, ends: tuple[str, ...], how: str, distance: str
) -> vo.Verdict:
    """x oscillates between the two roots, and v, v_1 grow by the same angle every time."""
    wanted = tuple(name.replace("x", "u") for name in LARGEST[:2])
    return all_of(
        agreement(set(ends), set(wanted), "the parallels of the two roots"),
        agreement(
            one_of(how, {"alternatively": True, "once": False, "never": False}), True, "in turn"
        ),
        lambda: denial(constant(distance), equal_steps(study, where)),
    )


def trace_cases(
    study: Study,
    where: Range,
    *,
    cases: int,
    first: int,
    second: int,
    third: int,
    one: Interval,
    two: Interval,
    three: Interval,
) -> vo.Verdict:
    """How many roots phi can have between two values of x: its degree is the most."""
    degree = int(sp.Poly(level().phi, x).degree())
    return all_of(
        agreement({first, second, third}, set(range(degree + 1)), "numbers of roots of phi"),
        agreement(cases, degree + 1, "cases"),
        turns(study, where),
        between(LARGEST[:2], one, two, three),
    )


def on_the_fixed_sphere(
    study: Study, where: Range, *, polynomial: tuple[str, ...], gap: Interval
) -> vo.Verdict:
    """The polynomial in the rate of v_1, whose sign is that of the rate."""
    return all_of(
        agreement(polynomial, ("F(x)",), "the numerator in the rate of v_1"),
        turns(study, where),
        between(LARGEST[:2], gap),
    )


STOPS = {r"\psi(x)": True, r"\phi(x)": False, "F(x)": False, r"\theta(x)": False, "X(x)": False}


def cusps(
    study: Study,
    where: Range,
    *,
    roots: tuple[str, ...],
    other: tuple[str, ...],
    polynomial: tuple[str, ...],
) -> vo.Verdict:
    """Where the contact point stops on both surfaces."""
    ends = set(roots + other)
    return all_of(
        agreement(ends, set(LARGEST[:2]), "the ends of the interval in which x runs"),
        denial(one_of(polynomial[0], STOPS), rests(study, where)),
    )


def smooth(
    study: Study, where: Range, *, top: Quoted, bottom: Quoted, sphere: str, singular: bool
) -> vo.Verdict:
    """Where x = 1 or -1 is a simple root the contact point does not stop."""
    ends = [tuple(sides_of(one)) for one in (top, bottom)]
    one_of(sphere, dict.fromkeys(("fixed", "movable", "mobile")))  # the speed on both is the same
    wanted = [(LARGEST[0], "1"), (LARGEST[1], "-1")]
    found = agreement(ends, wanted, "the ends at which the ball has a pole")
    return found if not found.proved else denial(not singular, regular_at_poles(study, where))


def curve_of_figure(_: Study, __: Range, *, curve: tuple[str, ...], figure: str) -> vo.Verdict:
    """Which curve the text announces where it refers to a figure."""
    said = announcements("".join(f" {sentence.quotation}" for sentence in TEXT))
    label = one_of(figure, {name: name for name in said})
    return agreement(curve, (said[label],), "the curve for which the text refers to this figure")


def announcements(text: str) -> dict[str, str]:
    """Label of each figure -> the curve that is named for it: of several figures in a row, the
    last ones that are named before them."""
    found: dict[str, str] = {}
    for words, figures in re.findall(
        rf"((?:(?!{FIGURE}).)+)((?:{FIGURE}(?:\s*and\s*)?)+)", text, re.S
    ):
        labels = re.findall(r"\{([^}]*)\}", figures)
        curves = re.findall(r"\$([A-E](?:_\d)?)\$", words)
        found |= dict(zip(labels, curves[-len(labels) :], strict=True))
    return found


FIGURE = r"Figure\s*\\ref\{[^}]*\}"
"""How the text refers to a figure."""
OF_THE_THESIS = "that the dissertation has it there is quoted, and the figure is not in the LaTeX"


def sides_of(formula: Quoted) -> list[str]:
    """Both sides of an equation as they are printed."""
    return formula.latex.strip("$").replace(" ", "").split("=")


SENTENCES = sentences(__file__, globals())
TEXT = tuple(s for s in SENTENCES if s.decide is not curve_of_figure)
