"""The smallest model of a scene: equal to the full one, and minimal."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp
from model_agreement import agreed, kinds, names

import voronec as vo
from voronec.equations.motions import Motions
from voronec.motion.formulation import Model, smallest, smallest_model
from voronec.motion.numeric_model import numbers_at
from voronec.motion.steppers import heyoka_stepper

pytestmark = pytest.mark.slow

# -- equal to the full model -----------------------------------------------------------------------

CASES = [
    ("ball-on-paraboloid", ("r", "phi")),
    ("ball-on-sphere", ("u", "v")),
    ("ball-on-sphere", ("v1", "energy")),
    ("ball-on-turntable-in-time", ("x",)),
    ("bicycle", ("phi", "x")),
    ("chaplygin-ball", ("omega1",)),
    ("chaplygin-ball", ("x", "y")),
    ("demchenko", ("u", "v")),
    ("demchenko", ("u1", "momentum z")),
    ("falling-disc", ("theta", "x")),
    ("growing-sleigh", ("x",)),
    ("nonholonomic-particle", ("z",)),
    ("rubber-ball-in-rn@4", ()),
    ("sleigh", ("phi",)),
    ("sleigh-in-time", ("x",)),
    ("sleigh-on-turntable", ("phi",)),
    ("snakeboard", ("x", "theta")),
    ("suslov", ("omega1",)),
    ("two-wheeled-carriage", ("x",)),
    ("vertical-disc", ("x", "y")),
    ("veselova", ("omega2",)),
    ("zhukovsky-ball", ("omega3",)),
]


@pytest.mark.parametrize(("name", "outputs"), CASES)
def test_the_outputs_are_those_of_the_full_model(name: str, outputs: tuple[str, ...]) -> None:
    system = vo.load(name)
    known = {*map(str, (*system.coordinates, *system.velocities)), *system.integrals}
    asked = tuple(o for o in outputs if o in known) or tuple(system.velocities)[:2]
    scene = "default" if "default" in system.scenes else next(iter(system.scenes))
    agreed(system, asked, scene=scene)


def test_without_outputs_everything_can_still_be_computed() -> None:
    system = vo.load("sleigh")
    model = agreed(system, ())
    assert {*model.outputs} == {*map(str, (*system.coordinates, *system.velocities))}


def test_a_combination_of_variables_may_be_wanted() -> None:
    v, w = sp.symbols("v w")
    model = agreed(vo.load("sleigh"), (v * w, w**2))
    assert names(model) == {"v", "w"}


# -- minimal ---------------------------------------------------------------------------------------


def test_the_latitude_of_demchenkos_ball_needs_four_variables() -> None:
    model = vo.explain(vo.load("demchenko"), outputs=("u", "v"))
    found = kinds(model)
    assert {x for x, kind in found.items() if kind == "dropped"} == {"theta", "u1", "v1"}
    assert found["v"] == "quadrature" and found["n"] == "integral"
    assert found["s"] == found["tau"] == "integrated"
    assert "n" not in names(model)
    low = next(c for c in model.candidates if c.formulation == "coordinates")
    assert low.states == 4
    narrower = vo.explain(vo.load("demchenko"), outputs=("s",))
    assert kinds(narrower).get("v", "dropped") == "dropped"


def test_the_heading_of_a_sleigh_needs_no_place() -> None:
    model = vo.explain(vo.load("sleigh"), outputs=("phi",))
    assert kinds(model) == {
        "x": "dropped", "y": "dropped", "phi": "quadrature", "v": "integrated", "w": "integrated",
    }  # fmt: skip


def test_an_angle_that_large_equations_hold_in_vain_is_not_kept() -> None:
    ball = vo.load("ball-on-paraboloid")
    R, c, r, phi, alpha = map(sp.Symbol, "R c r phi alpha".split())
    slopes = [e.subs(sp.Symbol("s"), 0) for e in ball.constraints]
    spin = ball.frame.expressions[2]
    along = [(slopes[0] + sp.sqrt(1 + c**2 * r**2) * vo.velocity(r)) / R,
             (slopes[1] - r * vo.velocity(phi)) / R]  # fmt: skip
    frame = vo.Frame.quasi(dict(zip(sp.symbols("o1:4"), (*along, spin), strict=True)))
    without = {"integrals": {}, "equations": {}, "essential": (), "scenes": {}, "charts": {}}
    rolling = replace(ball, frame=frame, **without)
    equations = vo.derive(rolling)
    held = set().union(*(e.free_symbols for e in equations.raw.form.force))
    assert str(alpha) in {str(s) for s in held}  # written in the straight-line form, in vain
    model = vo.explain(equations, outputs=("r", "phi"))
    assert names(model) == {"r", "phi", "o1", "o2", "o3"}


def test_normal_forms_longer_than_the_raw_form_are_not_integrated() -> None:
    x, y, s = sp.symbols("x y s")
    dx, dy, ds = map(vo.velocity, (x, y, s))
    inertia = (3 + sp.sin(s - x) ** 2, 3 + sp.cos(x * y) ** 2, 2 + s**2 + sp.sin(y) * x)
    kinetic = sum(i * d**2 for i, d in zip(inertia, (dx, dy, ds), strict=True)) / 2
    rolling = ds * (2 + sp.sin(s)) + dx * sp.atan(2 * y) + dy / (2 + sp.cos(y))
    made = vo.System("made", vo.Fibration((x, y), (s,)), kinetic, (rolling,))
    equations = vo.derive(made)
    assert not equations.in_normal_form
    assert equations.operations <= equations.raw.form.operations
    start = {"x": 0.5, "y": -0.3, "s": 0.2, "xdot": 1.0, "ydot": 0.4}
    motion = vo.integrate(equations, times=[0, 1e-4, 2e-4], initial=start, method="scipy")
    second = (motion["xdot"][2] - motion["xdot"][0]) / 2e-4
    point = {"x": motion["x"][1], "y": motion["y"][1], "s": motion["s"][1],
             "xdot": motion["xdot"][1], "ydot": motion["ydot"][1]}  # fmt: skip
    truth = vo.multiplier_acceleration(made, point)[x]
    assert second == pytest.approx(float(truth), abs=1e-6)


@pytest.mark.parametrize("method", ["scipy", "heyoka"])
def test_many_fold_angles_are_not_expanded_for_numbers(method) -> None:
    x, t = sp.Symbol("x"), vo.time
    drive = sp.Rational(33, 20)  # in terms of t/20 a polynomial of degree 33
    kinetic = vo.velocity(x) ** 2 / 2
    made = vo.System("driven", vo.Fibration((x,)), kinetic, forces={x: sp.sin(drive * t)})
    motion = vo.integrate(made, times=[0, 3], initial={x: 1}, method=method)
    truth = 1 + 3 / float(drive) - np.sin(3 * float(drive)) / float(drive) ** 2
    assert motion["x"][1] == pytest.approx(truth, abs=1e-12)


def test_constant_rates_and_a_circle_leave_one_quadrature() -> None:
    model = vo.explain(vo.load("vertical-disc"), outputs=("x",))
    assert names(model) == {"phi"}
    assert kinds(model)["thetadot"] == kinds(model)["phidot"] == "constant"
    assert kinds(model)["x"] == "integral"


def test_what_is_wanted_twice_costs_nothing() -> None:
    one = vo.explain(vo.load("snakeboard"), outputs=("psidot",))
    two = vo.explain(vo.load("snakeboard"), outputs=("psidot", "thetadot"))
    assert names(one) == names(two) and kinds(one)["x"] == "dropped"


def test_the_chosen_formulation_is_the_cheapest_that_was_weighed() -> None:
    model = vo.explain(vo.load("ball-on-sphere"), outputs=("u", "v"))
    (chosen,) = [c for c in model.candidates if c.chosen]
    assert len(model.candidates) > 2
    assert chosen.formulation == model.formulation
    assert chosen.weight == min(c.weight for c in model.candidates)


# -- what must not be lost -------------------------------------------------------------------------


def test_formulations_belong_to_the_equations_and_models_to_the_start(monkeypatch) -> None:
    made = []
    plain = smallest.coordinates_formulation
    monkeypatch.setattr(smallest, "coordinates_formulation", lambda *a: made.append(a) or plain(*a))
    motions = Motions.of(
        vo.derive(replace(vo.load("sleigh")))
    )  # nobody made its formulations before

    def of(v: float, *outputs: str) -> Model:
        own = motions.equations.raw.form
        start = dict.fromkeys((*own.coordinates, *own.velocities, *own.parameters, own.time), 0.5)
        start = {x: v if str(x) == "v" else 0.0 if str(x) == "w" else 0.5 for x in start}
        wanted = {name: sp.Symbol(name) for name in outputs}
        return smallest.smallest_model(motions, wanted, {}, start)

    standing, moving, turning = of(0.0, "x"), of(1.0, "x"), of(1.0, "phi")
    assert [len(m.cut.variables) for m in (standing, moving)] == [0, 1]
    assert {*turning.outputs} == {"phi"} and len(made) == 2
    assert of(0.0, "x").cut == standing.cut and len(made) == 2


def test_velocities_that_the_mass_couples_stay_together() -> None:
    x, y = sp.symbols("x y")
    dx, dy = vo.velocity(x), vo.velocity(y)
    system = vo.System(
        name="coupled", fibration=vo.Fibration(base=(x, y)),
        lagrangian=dx**2 + dy**2 + sp.cos(y) * dx * dy - y**2 / 2,
    )  # fmt: skip
    model = agreed(system, ("xdot",), initial={"y": 1, "xdot": 1})
    assert {"x", "y"} & names(model) == {"y"} and len(model.states) == 3


def test_momenta_whose_mass_depends_on_the_time_change_with_it() -> None:
    model = agreed(vo.load("sleigh-in-time"), ("v", "w"))
    assert any(c.formulation == "momenta" for c in model.candidates)


def test_a_dropped_coordinate_returns_where_it_is_wanted() -> None:
    bare = agreed(vo.load("sleigh"), ("phi",))
    more = agreed(vo.load("sleigh"), ("phi", "y"))
    assert "y" not in names(bare) and kinds(more)["y"] in ("quadrature", "integral")


def test_redundant_coordinates_stay_on_their_relations() -> None:
    system = vo.load("rubber-ball-in-rn@4")
    assert system.fibration.relations
    scene = next(iter(system.scenes))
    agreed(system, (system.coordinates[0], system.velocities[0]), scene=scene)


def test_reactions_need_every_acceleration() -> None:
    model = vo.explain(vo.load("sleigh"), outputs=("reaction 1",))
    assert {"v", "w"} <= names(model) and {"x", "y"}.isdisjoint(names(model))


def test_a_gyroscope_stays_in_the_rates_of_momenta() -> None:
    system = vo.load("gyroscopic-ball-on-sphere")
    scene = next(iter(system.scenes))
    model = agreed(system, ("omega1", "omega2"), scene=scene)
    assert any("momenta" in c.formulation for c in model.candidates)


QUADRANTS = [
    (0.6, 0.3), (2.2, 2.0), (-0.6, -2.5), (-2.2, -0.4), (-0.6, 7.0), (0.6 + 2 * np.pi, 2.0),
]  # fmt: skip


@pytest.mark.parametrize(("latitude", "longitude"), QUADRANTS)
def test_angles_are_read_off_from_starts_in_every_quadrant(
    ball: vo.VoronecEquations, latitude: float, longitude: float
) -> None:
    initial = {"u": latitude, "v": longitude, "u1": 1, "omega1": 0.7, "omega2": -0.4, "omega3": 0.5}
    model = agreed(ball, ("u", "v"), initial=initial)
    assert kinds(model)["u"] == kinds(model)["v"] == "read off"


@pytest.fixture(scope="module")
def ball() -> vo.VoronecEquations:
    return vo.derive(vo.load("ball-on-sphere"))


# -- kept models -----------------------------------------------------------------------------------

STARTS = (
    {"u": 1.2, "u1": 0.8, "s": 0.7, "tau": 0.2, "n": 1.5},
    {"u": 1.2, "u1": 0.8, "s": 0.7, "tau": 0.2, "n": 0.0},
    {"u": 0.9, "u1": 1.1, "s": 0.0, "tau": 0.0, "n": 2.5},
    {"u": 1.0, "u1": 0.7, "s": -0.3, "tau": 1.1, "n": 0.4},
)
"""Starts with other zeros; the last has those of the first."""


def _motion(equations: vo.VoronecEquations, at: dict[str, float], k: float) -> np.ndarray:
    run = vo.integrate(
        equations, times=np.linspace(0, 3, 40), initial=at, outputs=("u", "v", "s"),
        parameters={"k": k},
    )  # fmt: skip
    return np.stack([run[name] for name in ("u", "v", "s")])


def test_what_other_starts_left_behind_changes_no_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    together = vo.derive(vo.load("demchenko"))
    runs = [(start, k) for k in (0.2, 0.0, 0.2) for start in STARTS]
    found = [_motion(together, *run) for run in runs]
    monkeypatch.setattr(heyoka_stepper, "IDLE", 0)  # integrators are thrown away after each run,
    _motion(replace(together), *runs[0])  # those of the runs above after this one
    for (start, k), rows in zip(runs, found, strict=True):
        assert np.array_equal(rows, _motion(replace(together), start, k))


def test_a_kept_model_is_taken_only_where_the_start_gives_the_same_answers() -> None:
    """The integral vx + a vy gives vx where a is small, and vy where it is large."""
    x, y, a = sp.symbols("x y a")
    vx, vy = vo.velocity(x), vo.velocity(y)
    system = vo.System(
        name="sum",
        fibration=vo.Fibration(base=(x, y)),
        lagrangian=(vx**2 + vy**2) / 2 - sp.cos(a * x - y),
        parameters=(vo.Parameter(a),),
        integrals={"sum": vx + a * vy},
    )
    equations = vo.derive(system)

    def model(slope: float) -> Model:
        state = np.array([0.3, 0.1, 1.0, 2.0])
        known = numbers_at(equations.raw.form, state, {"a": slope}, 0.0)
        wanted = {"x": x, "y": y}
        return smallest_model(Motions.of(equations), wanted, system.integrals, known)

    small, large = model(1e-3), model(1.0)
    told = [{r.variable for r in m.roles if r.kind == "integral"} for m in (small, large)]
    assert len(told[0]) == len(told[1]) == 1 and told[0] != told[1]
    assert model(2e-3) is small and model(2.0) is large


# -- relations between invariants are kept ---------------------------------------------------------


@pytest.mark.parametrize(
    "name", ["ellipsoid-on-sphere", "roller-racer", "rubber-ball-on-sphere", "spheroid-on-sphere"]
)
def test_rates_keep_the_relations_between_invariants_identically(name: str) -> None:
    system = vo.load(name)
    wanted = {str(v): v for v in system.velocities}
    model = smallest_model(Motions(vo.derive(system)), wanted, {})
    pairs = zip(model.form.coordinates, model.form.rates, strict=True)
    rates = {sp.sympify(x): sp.sympify(rate) for x, rate in pairs}
    assert model.formulation == "invariants" and model.cut.relations
    for relation in map(sp.sympify, model.cut.relations):
        # off the relation too: no relation is used here
        change = sum(relation.diff(x) * rate for x, rate in rates.items())
        assert sp.cancel(sp.together(change)) == 0


def test_rounding_off_a_relation_does_not_grow() -> None:
    # with -1 + cosine^2 in the place of -sine^2 it grew as exp(2 v t/b), to 3e-7 of v at t = 1
    racer = vo.load("roller-racer")
    start = {"theta": -1.532, "phi": 0.153, "v": 1.893, "w": 0.207}
    sizes = {"m": 1.5, "I1": 1.4, "I2": 0.16, "a": 1.57, "b": 0.176}
    asked = {"initial": start, "parameters": sizes, "times": [0.0, 1.0], "outputs": ("v", "w")}
    kept = vo.integrate(racer, **asked, method="heyoka", tol=1e-13)
    angle = vo.integrate(replace(racer, invariants={}), **asked, method="scipy", tol=1e-12)
    assert "in invariants" in str(kept.cost) and "in coordinates" in str(angle.cost)
    for name in ("v", "w"):
        assert kept[name][-1] == pytest.approx(angle[name][-1], rel=1e-10)
