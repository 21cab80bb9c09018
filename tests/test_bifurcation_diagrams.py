"""Bifurcation diagrams of integral maps, against diagrams that are known exactly."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import pytest
import sympy as sp

import voronec as vo
from voronec.cli import main
from voronec.dynamics import integral_map_of

pytestmark = pytest.mark.slow

x, y = sp.symbols("x y")
vx, vy = vo.velocity(x), vo.velocity(y)
ALONG_X = vx**2 / 2 - x**2 / 2 + x**4 / 4
ALONG_Y = vy**2 / 2 + y**2 / 2


def double_well(**declared):
    """A particle with two wells along x and one along y: two critical values -1/4 and 0 of the
    first integral, 0 of the second, and two tori below the saddle."""
    return vo.System(
        **{
            "name": "double-well",
            "fibration": vo.Fibration(base=(x, y)),
            "lagrangian": vx**2 - ALONG_X + vy**2 - ALONG_Y,
            "integrals": {"along x": ALONG_X, "along y": ALONG_Y},
            "measure": vo.Measure(sp.Integer(1), (x, y, vx, vy)),
            "scenes": {"default": vo.Scene(initial={x: 0.5, vx: 0.3, y: 0.4}, times=(0.0, 5.0))},
            **declared,
        }
    )


WINDOW = {"along x": (-0.4, 0.6), "along y": (-0.2, 0.6)}


@cache
def wells():
    return vo.bifurcation_diagram(double_well(), between=WINDOW)


def test_critical_values_are_those_of_the_wells_and_of_the_saddle():
    found = wells()
    for value, kind in ((-0.25, "stable"), (0.0, "saddle")):
        curves = [c for c in found.curves if np.abs(c.values[:, 0] - value).max() < 1e-9]
        assert curves and max(np.ptp(c.values[:, 1]) for c in curves) > 0.5
        assert all({*c.kinds.tolist()} <= {kind, "degenerate"} for c in curves)
    rest = [c for c in found.curves if np.abs(c.values[:, 1]).max() < 1e-9]
    assert max(np.ptp(c.values[:, 0]) for c in rest) > 0.5
    on_lines = np.vstack([c.values for c in found.curves])
    assert (np.abs(on_lines - [[-0.25, 0]]).min(axis=1) < 1e-9).sum() + (
        np.abs(on_lines[:, 0]) < 1e-9
    ).sum() >= len(on_lines)


def test_tori_are_counted_in_every_region():
    found, random = wells(), np.random.default_rng(2)
    assert found.is_integrable
    for a, b in random.uniform(*found.window.T, size=(300, 2)):
        if min(abs(a + 0.25), abs(a), abs(b)) < 0.01:
            continue
        told = "no motions" if a < -0.25 or b < 0 else "2 tori" if a < 0 else "1 torus"
        assert found.kind(a, b) == told
    assert found.kind(0.0, 0.3) == "critical" and found.kind(9, 9) == "not told"


def test_a_point_answers_with_a_motion_on_its_level():
    found, sides = wells(), set()
    for component in (0, 1):
        motion = found.motion(-0.1, 0.2, component, times=np.linspace(0, 20, 101))
        values = motion["x"], motion["xdot"]
        np.testing.assert_allclose(
            values[1] ** 2 / 2 - values[0] ** 2 / 2 + values[0] ** 4 / 4, -0.1, atol=1e-9
        )
        assert len({*np.sign(motion["x"])}) == 1
        sides |= {*np.sign(motion["x"])}
    assert sides == {-1, 1}
    with pytest.raises(vo.DefinitionError, match="has 2 tori: there is no number 2"):
        found.motion(-0.1, 0.2, 2)
    with pytest.raises(vo.DefinitionError, match="has no motions"):
        found.start(-0.35, 0.2)


def test_veselova_has_the_critical_values_of_its_permanent_rotations():
    # about axis i the momentum is J_i omega_i and the energy J_i omega_i^2/2: k = 2 J_i h, and the
    # middle axis is unstable
    found = vo.bifurcation_diagram(vo.load("veselova"))
    ratios = {}
    for curve in found.curves:
        kept = curve.values[:, 0] > 1e-3
        ratio = curve.values[kept, 1] / curve.values[kept, 0]
        if kept.any():
            assert np.ptp(ratio) < 1e-8
            ratios[round(float(ratio[0]), 6)] = {*curve.kinds[kept].tolist()}
    assert ratios == {2.8: {"stable"}, 3.0: {"saddle"}, 3.4: {"stable"}}
    assert {found.kind(0.04, k * 0.04) for k in (2.7, 3.5)} == {"no motions"}
    assert {found.kind(0.04, k * 0.04) for k in (2.9, 3.2)} == {"2 tori"}
    assert "omega3" in found.map.variables  # nothing is infinite where gamma3 = 0


def test_curves_of_chaplygins_ball_end_at_its_steady_motions():
    found = vo.bifurcation_diagram(vo.load("chaplygin-ball"))
    c = found.held["vertical momentum"]
    ends = np.vstack([curve.values[[0, -1]] for curve in found.curves])
    for moment in (0.4, 0.5, 0.7):  # M along gamma along an axis: M^2 = c^2, 2 h I_i = c^2
        value = c**2 / (2 * moment), c**2
        assert np.abs(ends - value).max(axis=1).min() < 2e-3
        assert np.abs(found.steady_values - value).max(axis=1).min() < 1e-9
    words = {round(float(v[0]), 4): m.verdict.word
             for v, m in zip(found.steady_values, found.steady, strict=True)}  # fmt: skip
    assert words[round(c**2, 4)] == "unstable"
    assert {r.components for r in found.regions if r.share > 0.01} == {0, 2}


def test_integrals_of_the_disc_without_formulas_are_constant_along_a_motion():
    disc = vo.load("falling-disc")
    found = integral_map_of(disc, None, {})
    assert found.integrals == ("energy", "q where theta = 0", "s where theta = 0")
    motion = vo.integrate(disc, times=np.linspace(0, 5, 41))
    points = np.column_stack([motion[name] for name in found.variables])
    values = found.jet(points, 0)[0]
    assert np.ptp(values, axis=0).max() < 1e-8 and np.ptp(points[:, 0]) > 0.1


def test_a_parameter_may_be_an_axis():
    found = vo.bifurcation_diagram(
        vo.load("rubber-ball-on-sphere"), axes=("energy", "R1"), starts=5
    )
    assert not found.is_integrable and found.kind(0.01, 2) == "not told"
    assert all(np.abs(c.values[:, 0]).max() < 1e-12 for c in found.curves) and found.curves


def test_diagrams_are_drawn_and_saved(tmp_path):
    found = wells()
    assert found.plot().axes[0].get_xlabel() == "along x"
    table = found.save(tmp_path / "wells.csv").read_text().splitlines()
    assert table[0] == "curve,along x,along y,x,y,xdot,ydot,kind"
    assert len(table) == 1 + sum(map(len, found.curves))
    assert found.as_dict()["integrable"] and "2 tori" in "\n".join(found.lines())


@pytest.mark.parametrize(
    ("declared", "asked", "words"),
    [
        ({"integrals": {}}, {}, "the integral map is constant"),
        ({"integrals": {"along x": ALONG_X}}, {}, "functions of one alone, along x"),
        ({"forces": {x: -sp.Abs(vx) * vx}}, {}, "right side is not smooth"),
        ({"forces": {x: vo.time}}, {}, "depends on the time"),
        ({}, {"axes": ("along x", "energy")}, "'energy' is no proved integral"),
        ({}, {"axes": ("along x",)}, "name two different integrals"),
        ({}, {"at": {"energy": 1}}, "'energy' is no integral that is held"),
        ({}, {"between": {"along x": (1, 0)}}, "give a low and a high value"),
    ],
)
def test_what_is_no_diagram_is_refused_in_one_line(declared, asked, words):
    with pytest.raises(vo.DefinitionError) as refusal:
        vo.bifurcation_diagram(double_well(**declared), **asked)
    assert words in str(refusal.value) and "\n" not in str(refusal.value)


def test_a_parameter_may_have_a_value_in_doubles():
    k = sp.Symbol("k")
    along = vy**2 / 2 + k * y**2 / 2
    system = double_well(
        parameters=(vo.Parameter(k, 1),),
        lagrangian=vx**2 - ALONG_X + vy**2 - along,
        integrals={"along y": along},
    )
    found = integral_map_of(system, None, {k: 1.5})
    assert found.jet(found.start[None], 0)[0] == pytest.approx(np.array([[1.5 * 0.4**2 / 2]]))


def test_the_command_refuses_a_map_of_one_integral(capsys):
    assert main(["bifurcation", "rubber-ball-on-sphere"]) == 2
    assert "take a parameter for the other axis" in capsys.readouterr().err
    assert main(["bifurcation", "veselova", "--between", "energy=3"]) == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize("sign", [1, -1])
def test_angles_are_counted_once_around(sign):
    """A pendulum beside an oscillator swings, on one torus, or turns, on two."""
    q = sp.Symbol("q")
    swing = vo.velocity(q) ** 2 / 2 - sign * sp.cos(q)
    pendulum = double_well(
        name="pendulum",
        fibration=vo.Fibration(base=(q, y)),
        lagrangian=vo.velocity(q) ** 2 - swing + vy**2 - ALONG_Y,
        integrals={"swing": swing, "along y": ALONG_Y},
        measure=vo.Measure(sp.Integer(1), (q, y, vo.velocity(q), vy)),
        scenes={"default": vo.Scene(initial={q: 0.5, y: 0.4}, times=(0.0, 5.0))},
    )
    found = vo.bifurcation_diagram(pendulum, between={"swing": (-1.5, 3), "along y": (-0.3, 1)})
    assert found.kind(0, 0.3) == "1 torus" and found.kind(2, 0.3) == "2 tori"
    assert found.kind(-1.2, 0.3) == "no motions"


def test_poles_of_coordinates_are_no_critical_points_and_leave_tori_untold():
    """A spherical pendulum: critical motions are circles, with 2 E = 3 cos - 1/cos."""
    theta, phi = sp.symbols("theta phi")
    turn = vo.velocity(phi)
    kinetic = (vo.velocity(theta) ** 2 + sp.sin(theta) ** 2 * turn**2) / 2
    integrals = {"energy": kinetic + sp.cos(theta), "spin": sp.sin(theta) ** 2 * turn}
    start = {theta: 1.5, vo.velocity(theta): 0.3, turn: 0.4}
    pendulum = vo.System(
        "spherical-pendulum",
        vo.Fibration(base=(theta, phi)),
        kinetic - sp.cos(theta),
        integrals=integrals,
        scenes={"default": vo.Scene(initial=start, times=(0.0, 5.0))},
    )
    window = {"energy": (-1.5, 2), "spin": (-1.5, 1.5)}
    found = vo.bifurcation_diagram(pendulum, between=window)
    assert not found.without_formula and not found.is_integrable and "poles" in found.lines()[-1]
    circles = [c for c in found.curves if len(c) > 1]
    assert circles
    for curve in circles:
        cosine = np.cos(curve.points[:, 0])
        energy, spin = curve.values.T
        np.testing.assert_allclose(spin**2 * cosine, -((1 - cosine**2) ** 2), atol=1e-8)
        np.testing.assert_allclose(2 * energy * cosine, 3 * cosine**2 - 1, atol=1e-8)


def test_a_measure_at_other_parameters_makes_no_tori() -> None:
    ball = vo.load("chaplygin-ball")
    (first, *_) = ball.parameters
    case = vo.Case(parameters={first.symbol: 2}, measure=ball.measure)
    other = dataclasses.replace(ball, measure=None, cases={"other": case})
    assert any(c.kind == "measure" and c.verdict.proved for c in vo.check_claims(other))
    assert not vo.bifurcation_diagram(other, starts=2).is_integrable
