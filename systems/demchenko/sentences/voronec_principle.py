"""The Voronec principle: what the text says beside its displays."""

from __future__ import annotations

from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Quoted, Range, Reference, Study, one_of
from voronec.audit.meaning import evaluate
from voronec.audit.transcript import assignments

from ..dictionary.general import BASE, DELTA, FIBRE, Q, V
from ..transcription import sentences
from .claims import agreement, all_of, denial, equals, value

CURVATURE = "the curvature of any constraints that are affine in the velocities"


def restriction(study: Study, _: Range, *, constraints: Reference) -> vo.Verdict:
    """Theta is T with the velocities of the fibre as the formula has them."""
    solved = dict(zip(V[BASE:], _right_sides(constraints, study), strict=True))
    theta = study.names["T"].xreplace(solved)
    return equals([(theta, study.context.eqs.theta)], f"T where ({constraints.label}) holds")


def _right_sides(reference: Reference, study: Study) -> list[Any]:
    """The right side of a formula for all values of its free index."""
    (tree,) = reference.trees(study)
    return [evaluate(tree.parts[1], study, where) for where in assignments(tree, study)]


def momenta(
    study: Study, _: Range, *, velocity: tuple[str, ...], constraints: Reference
) -> vo.Verdict:
    """K is the derivative of T by the named velocity, where the constraints hold."""
    tree, energy = Quoted(f"${velocity[0]}$").tree(study), study.names["T"]
    symbols = [evaluate(tree.parts[0], study, {r"\nu": nu}) for nu in range(1, FIBRE + 1)]
    solved = dict(zip(V[BASE:], _right_sides(constraints, study), strict=True))
    slopes = [sp.diff(energy, symbol).xreplace(solved) for symbol in symbols]
    return equals(zip(slopes, study.context.eqs.momenta, strict=True), "derivatives of T and K")


def depends_on(
    study: Study, _: Range, *, time: tuple[str, ...], coordinates: tuple[str, ...]
) -> vo.Verdict:
    """What the components of the curvature hold: the time and all coordinates, no velocity."""
    eqs = study.context.eqs
    entries = [
        eqs.curvature[nu, i, j] for nu in range(FIBRE) for i in range(BASE) for j in range(i)
    ]
    entries += [eqs.curvature.time[nu, i] for nu in range(FIBRE) for i in range(BASE)]
    held = {str(x) for entry in entries for x in entry.free_symbols}
    return agreement(
        _symbols_of(coordinates, study) | _symbols_of(time, study), held, "they depend on"
    )


def _symbols_of(names: tuple[str, ...], study: Study) -> set[str]:
    """The symbols of a list in which dots stand for what lies between."""
    values = [value(x, study) for x in names if x != r"\dots"]
    if r"\dots" not in names:
        return {str(x) for x in values}
    order = next(row for row in (Q, V, DELTA) if values[0] in row)
    first, last = (order.index(x) for x in values)
    return {str(x) for x in order[first : last + 1]}


def displacements(
    study: Study,
    _: Range,
    *,
    free: tuple[str, ...],
    sort: str,
    end: int,
    first: tuple[str, ...],
    second: tuple[str, ...],
    bound: tuple[str, ...],
) -> vo.Verdict:
    """The independent variations, which vanish at the ends, and those that follow from them.

    By parts there remains the sum of dTheta/dqdot delta q at the ends, which only vanishing
    variations make zero for every Theta.
    """
    virtual = [study.names[r"\delta q_{s}"](s) for s in range(1, BASE + FIBRE + 1)]
    independent = {s for s, x in enumerate(virtual, start=1) if x in DELTA}
    boundary = sp.diff(study.context.eqs.theta, V[0]) * DELTA[0]
    needed = 0 if vo.prove_equal(boundary, 0).refuted else end
    return all_of(
        agreement(_indices(free, study), independent, "independent variations"),
        agreement(
            _indices(bound, study), set(range(1, len(virtual) + 1)) - independent, "the others"
        ),
        agreement(one_of(sort, {"arbitrary": True, "fixed": False}), True, "whether they are free"),
        agreement(end, needed, "what the terms at the ends need"),
        agreement((first, second), (("t=t_1",), ("t=t_2",)), "the limits of the integral"),
    )


def _indices(names: tuple[str, ...], study: Study) -> set[int]:
    r"""Which indices a list such as \delta q_1, ..., \delta q_n has."""
    virtual = [study.names[r"\delta q_{s}"](s) for s in range(1, BASE + FIBRE + 1)]
    varied = [value(x, study) for x in names if x != r"\dots"]
    if any(x not in virtual for x in varied):
        raise vo.DefinitionError(f"'{', '.join(names)}' is no list of displacements")
    places = [virtual.index(x) + 1 for x in varied]
    return set(range(places[0], places[-1] + 1)) if r"\dots" in names else set(places)


def transposition(study: Study, _: Range, *, first: Reference, second: Reference) -> vo.Verdict:
    """d/dt of the one right side less the variation of the other one."""
    whole, virtual = (
        study.context,
        [study.names[r"\delta q_{s}"](s) for s in range(1, BASE + FIBRE + 1)],
    )
    rates, displaced = _right_sides(first, study), _right_sides(second, study)
    pairs = []
    for nu, (rate, moved) in enumerate(zip(rates, displaced, strict=True), start=1):
        varied = sp.Add(*[sp.diff(rate, q) * d for q, d in zip(Q, virtual, strict=True)])
        varied += sp.Add(
            *[sp.diff(rate, v) * vo.velocity(d) for v, d in zip(V, DELTA, strict=False)]
        )
        gap = study.motion.derivative(moved) - study.motion.restrict(varied)
        pairs.append((gap, whole.transposition({r"\nu": nu})))
    return equals(pairs, f"d/dt of ({second.label}) less the variation of ({first.label})")


def chaplygin(
    study: Study, _: Range, *, depends: bool, variables: tuple[str, ...], equations: Reference
) -> vo.Verdict:
    """Where nothing depends on the fibre the equations are Chaplygin's, and close in the base."""
    whole = study.context
    held = [study.names["T"], *(study.names[r"a_{\nu i}"](1, i) for i in range(1, BASE + 1))]
    absent = {str(q) for q in Q if not any(sp.diff(e, q) != 0 for e in held)}
    (tree, *_rest) = equations.trees(study)
    left = evaluate(tree.parts[0], study, {"i": 1})
    inertia = study.motion.derivative(sp.diff(whole.eqs.theta, V[0]))
    return all_of(
        agreement(_symbols_of(variables, study), absent, "variables on which nothing depends"),
        denial(not depends, whole.chaplygins()),
        equals([(left, inertia)], f"the inertia in ({equations.label})"),
    )


def latex_of_momenta(_: Study) -> str:
    """What was derived instead."""
    return r"K_\nu=\frac{\partial T}{\partial\dot q_{n+\nu}}"


SENTENCES = sentences(__file__, globals())
