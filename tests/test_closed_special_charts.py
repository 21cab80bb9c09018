"""Stability charts, bifurcation sets, and the expansions of pseudo-regular precessions."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
import sympy as sp

import voronec as vo
from voronec.closed.special import bifurcation_set, chart_of, precessions, pseudo_regular
from voronec.closed.special.precessions import upright

pytestmark = pytest.mark.slow

R = sp.Rational
u = sp.Symbol("u")


@pytest.fixture(scope="module")
def demchenko():
    return vo.load("demchenko")


@pytest.fixture(scope="module")
def outer(demchenko):
    return chart_of(demchenko, unit=sp.Symbol("k") / sp.Symbol("A"))


# -- the chart --------------------------------------------------------------------------------


def test_outside_two_ranges_of_the_rate_have_an_unstable_equator(outer):
    unstable = [region for region in outer.regions if not region.stable]
    assert len(unstable) == 2
    assert all(abs(region.sample[0]) < Fraction(1, 10) for region in unstable)


def test_every_region_of_the_chart_agrees_with_the_decision_at_other_points(demchenko, outer):
    family = precessions(demchenko)
    rng = np.random.default_rng(1)
    second = sp.lambdify(
        (family.place, family.rate),
        family.derivative(2).xreplace({p.symbol: p.value for p in demchenko.parameters}),
    )
    for region in outer.regions:
        low, high = region.outline[:, 1].min(), region.outline[:, 1].max()
        rows = low + (high - low) * (0.1 + 0.8 * rng.random(20))
        for row in rows:
            left = np.interp(row, *_side(region.outline, first=True))
            right = np.interp(row, *_side(region.outline, first=False))
            for share in (0.05, 0.5, 0.95):
                x = left + share * (right - left)
                assert (second(x, row * float(outer.unit)) < 0) is np.bool_(region.stable)


def _side(outline, first):
    half = (len(outline) - 1) // 2
    part = outline[:half] if first else outline[half:-1][::-1]
    return part[:, 1], part[:, 0]


def test_the_boundary_is_where_the_second_derivative_vanishes(outer):
    x, w = sorted(outer.boundary.free_symbols, key=str, reverse=True)
    value = sp.lambdify((x, w), outer.boundary / sp.Poly(outer.boundary, x, w).max_norm())
    for curve in outer.curves:
        assert np.abs(value(*curve.T)).max() < 1e-9


def loose_ends(curves, points=()):
    """The ends at which a curve meets no other one and no single point."""
    ends = [end for curve in curves for end in (curve[0], curve[-1])]
    alone = []
    for i, end in enumerate(ends):
        others = np.array([*ends[:i], *ends[i + 1 :], *points])
        if np.abs((others - end) / (1 + np.abs(end))).max(axis=1).min() > 1e-9:
            alone.append(end)
    return alone


def test_the_boundary_closes_at_every_fold(outer):
    assert len(outer.curves) > 2
    assert not loose_ends(outer.curves)


@pytest.mark.parametrize(("radius", "inertia"), [(-3, R(2, 5)), (R(-1, 2), R(7, 10))])
def test_inside_and_around_with_a_positive_leading_coefficient_all_are_stable(
    demchenko, radius, inertia
):
    own = {"R1": radius, "A": inertia}
    chart = chart_of(demchenko, own, unit=sp.Symbol("k") / sp.Symbol("A"))
    assert all(region.stable for region in chart.regions)
    assert not chart.curves


def test_a_chart_needs_a_positive_unit(demchenko):
    with pytest.raises(vo.DefinitionError, match="not a positive number"):
        chart_of(demchenko, unit=-1)


# -- the bifurcation set ----------------------------------------------------------------------


@pytest.fixture(scope="module")
def levels(demchenko):
    return bifurcation_set(demchenko, ("C5", "h2"), {"S0": 1})


def test_the_discriminant_vanishes_on_the_family_and_on_the_single_points(demchenko, levels):
    value = sp.lambdify(levels.plane, levels.discriminant)
    scale = sp.lambdify(levels.plane, sp.Add(*map(abs, levels.discriminant.expand().args)))
    for curve in levels.curves:
        ratio = np.abs(value(*curve.points.T)) / scale(*curve.points.T)
        assert ratio.max() < 1e-8
    for single in levels.points:
        assert abs(value(*single.point)) < 1e-8 * scale(*single.point)
    off = levels.curves[0].points[20] * 1.01
    assert abs(value(*off)) > 1e-8 * scale(*off)


def test_curves_end_in_cusps_in_folds_and_at_single_points(levels):
    # two run out of the window, and one of the pieces that meet has its limit from 0/0
    points = [single.point for single in levels.points]
    assert len(points) == 2
    assert len(loose_ends([c.points for c in levels.curves], points)) == 2


@pytest.mark.parametrize("body", [{}, {"R1": -6}, {"R1": R(-1, 5), "A": R(7, 10)}])
def test_a_branch_beside_the_family_is_reached(demchenko, body):
    found = bifurcation_set(demchenko, ("S0", "h2"), {"C5": R(1, 2)}, body, (-30, 30))
    points = [single.point for single in found.points]
    (beside,) = [single.point for single in found.points if single.what == "beside the family"]
    ends = [c.points[i] for c in found.curves for i in (0, -1)]
    assert np.abs(np.array(ends) - beside).max(axis=1).min() < 1e-9
    assert len(loose_ends([c.points for c in found.curves], points)) == 2  # of the window


def test_the_number_of_motions_changes_across_the_set(levels):
    stable = next(c for c in levels.curves if c.stable)
    first, second = map(Fraction, stable.points[30])
    counts = {levels.motions(first, second * (1 + Fraction(d, 1000))) for d in (-1, 1)}
    assert len(counts) == 2


def test_on_a_line_of_equal_constants_the_family_is_rational(demchenko):
    found = bifurcation_set(demchenko, ("S0", "h2"), {"C5": 1}, window=(-3, 3))
    assert found.curves
    quartic = sp.lambdify((*found.plane, found.variable), found.quartic)
    slope = sp.lambdify((*found.plane, found.variable), sp.diff(found.quartic, found.variable))
    for curve in found.curves:
        kept = np.abs(curve.rate) < 3
        place = (*curve.points[kept].T, curve.x[kept])
        size = 1 + np.abs(curve.points[kept]).max()
        assert np.abs(quartic(*place)).max() < 1e-6 * size
        assert np.abs(slope(*place)).max() < 1e-6 * size


def test_a_wrong_plane_is_refused(demchenko):
    with pytest.raises(vo.DefinitionError, match="each of the constants"):
        bifurcation_set(demchenko, ("C5", "C5"), {"S0": 1})


# -- pseudo-regular precessions ---------------------------------------------------------------

BODY = {"R1": 2, "R2": 1, "M": 1, "A": R(2, 5)}
START = {"x": R(3, 5), "s": R(1, 2), "tau": R(1, 3), "n": R(1, 5)}


def measured(system, k):
    """The same from the closed form."""
    values = {p.symbol: sp.sympify({**BODY, "k": k}[p.name]) for p in system.parameters}
    state = {sp.Symbol(name): e for name, e in START.items() if name != "x"}
    x = START["x"]
    angles = upright(system.motion.space, {**state, **values}, u, x, sp.sqrt(1 - x**2))
    closed = vo.closed_form(
        system, vo.Scene(initial={u: sp.acos(x), **state, **angles}, parameters=values)
    )
    low, high = closed.ends
    return {
        "frequency": 2 * math.pi / closed.period,
        "half width": (high - low) / 2,
        "centre": (high + low) / 2,
        "v": closed.turns["v"].advance / closed.period,
        "v1": closed.turns["v1"].advance / closed.period,
    }


def test_every_term_of_the_expansions_gains_an_order(demchenko):
    found = pseudo_regular(demchenko, "k", terms=2, parameters=BODY, start=START)
    true = {k: measured(demchenko, k) for k in (200, 400)}
    # the first term left out: of the frequency k (...), the drift, and (...)/k of the widths
    lost = {"frequency": -1, "v": 0, "v1": 0, "half width": 1, "centre": 1}
    for terms in (1, 2):
        own = {k: found.at(START, {"k": k}, terms) for k in true}
        for name, begin in lost.items():
            ratio = (own[200][name] - true[200][name]) / (own[400][name] - true[400][name])
            assert abs(math.log2(abs(ratio)) - (begin + terms)) < 0.1, (name, terms)


def test_the_first_terms_are_the_harmonic_nutation(demchenko):
    start = {"x": R(3, 5)}
    found = pseudo_regular(demchenko, "k", parameters=BODY, start=start)
    P, A, x, mu = R(7, 5), R(2, 5), R(3, 5), R(3, 2)
    square = (1 - x**2) / (A * P) + x**2 / P**2
    assert vo.prove_equal(found.frequency[0] ** 2, square).proved
    s, n = sp.symbols("s n")
    drift = (P * s * sp.sqrt(1 - x**2) / A - x * n) / (mu * P**2 * square)
    assert vo.prove_equal(found.drifts[sp.Symbol("v")][0], drift).proved


def test_an_unknown_start_is_refused(demchenko):
    with pytest.raises(vo.DefinitionError, match="a start has no 'z'"):
        pseudo_regular(demchenko, "k", start={"z": 1})


def test_a_pole_at_which_no_velocities_are_left_is_no_motion(demchenko):
    levels = bifurcation_set(demchenko, ("C5", "h2"), {"S0": 1}, {"R1": -3})
    # at x = -1 the quartic is zero, and P (s^2 + tau^2) = h2 - 5/2
    assert [levels.motions(-1, Fraction(h2, 10)) for h2 in (9, 25, 40)] == [0, 1, 1]
