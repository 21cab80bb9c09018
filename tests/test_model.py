"""The smallest model of a scene: equal to the full one, minimal, and never unsound."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import networkx
import numpy as np
import pytest
import symengine as se
import sympy as sp
from scipy.integrate import solve_ivp

import voronec as vo
from voronec.algebra.symbols import plain_name
from voronec.flow.observing import Branch
from voronec.flow.vocabulary import Vocabulary
from voronec.program import Program, compiled
from voronec.report.model_boxes import boxes
from voronec.report.model_picture import model_figure
from voronec.report.model_text import model_text

ERROR = 2e-9


def kinds(model: vo.Model) -> dict[str, str]:
    return {role.variable: role.kind for role in model.roles}


def names(model: vo.Model) -> set[str]:
    return {str(x) for x in model.states}


def start_of(motion: vo.Trajectory) -> dict[Any, float]:
    """Numbers of coordinates, velocities, parameters and the time at a full motion's start."""
    state = zip(motion.names, motion.state[0], strict=True)
    given = (*state, *motion.parameters.items(), ("t", motion.t[0]))
    return {se.Symbol(n): float(x) for n, x in given}


def followed(model: vo.Model, start: Mapping[Any, float], t: np.ndarray) -> dict[str, np.ndarray]:
    """The outputs along the model's own motion; nothing of the full one is used but its start."""
    own = model.reduced
    values = dict(start)
    for x, meaning in model.whole.start.items():
        values[x] = float(meaning.subs(dict(start)).n(53, real=True))
    for x, meaning in model.frozen.items():
        values[x] = float(meaning.subs(values).n(53, real=True))
    sides = {f"cos {n}": a.cosine for n, a in own.angles.items()}
    sides |= {f"sin {n}": a.sine for n, a in own.angles.items()}
    program = Program.of(own.form, {**own.outputs, **sides})
    rates, extras = compiled(program)
    constants = [values[p] for p in program.parameters]
    begin = [values[x] for x in program.state]
    states = np.zeros((0, len(t)))
    if begin:
        run = solve_ivp(
            lambda at, y: np.array(rates(at, list(y), constants), dtype=float), (t[0], t[-1]),
            begin, method="DOP853", rtol=1e-12, atol=1e-14, t_eval=t,
        )  # fmt: skip
        assert run.success, run.message
        states = run.y
    series = [np.broadcast_to(np.asarray(s, float), t.shape) for s in
              extras(t, list(states), constants)]  # fmt: skip
    found = dict(zip(program.names, series, strict=True))
    for n, angle in own.angles.items():
        branch = Branch(f"cos {n}", f"sin {n}", angle.signs(start), start[angle.coordinate])
        found[n] = branch.along(found)
    return {n: found[n] for n in (*own.outputs, *own.angles)}


def agreed(
    system: vo.System | vo.VoronecEquations,
    outputs: Sequence[Any],
    end: float = 1.0,
    **setting: Any,
) -> vo.Model:
    """The model, its outputs held against those of the full equations."""
    equations = system if isinstance(system, vo.VoronecEquations) else vo.derive(system)
    system = equations.system
    model = vo.explain(equations, outputs=outputs, **setting)
    t = np.linspace(0.0, end, 41)
    scene = setting.pop("scene", None if "initial" in setting else "default")
    bare = None if scene is None else replace(system.scenes[scene], outputs=())
    full = vo.integrate(equations, scene=bare, times=t, method="scipy", **setting)
    assert {*full.names} == {*map(plain_name, (*system.coordinates, *system.velocities))}
    found, right = followed(model, start_of(full), t), read(equations, outputs, full)
    assert {*found} == {*right}
    for name in right:
        size = max(1.0, float(np.abs(right[name]).max()))
        assert np.abs(found[name] - right[name]).max() < ERROR * size, name
    return model


def read(
    equations: vo.VoronecEquations, outputs: Sequence[Any], full: vo.Trajectory
) -> dict[str, np.ndarray]:
    """Outputs from the states of a full motion."""
    wanted = Vocabulary.of(equations).wanted(outputs).expressions
    program = Program.of(equations.form, wanted)
    values = {**full.parameters}
    series = compiled(program)[1](
        full.t, list(full.state.T), [values[str(p)] for p in program.parameters]
    )
    return {
        name: np.broadcast_to(np.asarray(x, float), full.t.shape)
        for name, x in zip(program.names, series, strict=True)
    }


# -- equal to the full model -----------------------------------------------------------------------

CASES = [
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
    assert {*model.reduced.outputs} == {*map(str, (*system.coordinates, *system.velocities))}


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
    low = next(c for c in model.candidates if c.level == "coordinates")
    assert low.states == 4
    narrower = vo.explain(vo.load("demchenko"), outputs=("s",))
    assert kinds(narrower).get("v", "dropped") == "dropped"


def test_the_heading_of_a_sleigh_needs_no_place() -> None:
    model = vo.explain(vo.load("sleigh"), outputs=("phi",))
    assert kinds(model) == {
        "x": "dropped", "y": "dropped", "phi": "quadrature", "v": "integrated", "w": "integrated",
    }  # fmt: skip


def test_constant_rates_and_a_circle_leave_one_quadrature() -> None:
    model = vo.explain(vo.load("vertical-disc"), outputs=("x",))
    assert names(model) == {"phi"}
    assert kinds(model)["thetadot"] == kinds(model)["phidot"] == "constant"
    assert kinds(model)["x"] == "integral"


def test_what_is_wanted_twice_costs_nothing() -> None:
    one = vo.explain(vo.load("snakeboard"), outputs=("psidot",))
    two = vo.explain(vo.load("snakeboard"), outputs=("psidot", "thetadot"))
    assert names(one) == names(two) and kinds(one)["x"] == "dropped"


def test_the_chosen_level_is_the_cheapest_that_was_weighed() -> None:
    model = vo.explain(vo.load("ball-on-sphere"), outputs=("u", "v"))
    (chosen,) = [c for c in model.candidates if c.chosen]
    assert len(model.candidates) > 2
    assert chosen.level == model.level
    assert chosen.weight == min(c.weight for c in model.candidates)


# -- what is zero ----------------------------------------------------------------------------------

x, y, z, u, v, w, a, b, k, m = sp.symbols("x y z u v w a b k m")


def plane_system(**more: Any) -> vo.System:
    """Two oscillators, of which the second one is driven by the product of both."""
    dx, dy = vo.velocity(x), vo.velocity(y)
    return vo.System(
        name="plane",
        fibration=vo.Fibration(base=(x, y)),
        lagrangian=(dx**2 + dy**2) / 2 - (x**2 + y**2 + k * x * y**2) / 2,
        parameters=(vo.Parameter(k, 1),),
        **more,
    )


def test_a_start_on_an_invariant_plane_stays_there() -> None:
    model = agreed(plane_system(), ("x",), initial={"x": 0.3})
    assert names(model) == {"x", "xdot"} and kinds(model)["y"] == "zero"


def test_a_start_off_the_plane_does_not_count_as_on_it() -> None:
    model = agreed(plane_system(), ("x",), initial={"x": 0.3, "y": 1e-300})
    assert names(model) == {"x", "xdot", "y", "ydot"}


def test_a_velocity_that_is_zero_for_an_instant_only_is_kept() -> None:
    model = agreed(plane_system(), ("x",), initial={"y": 0.3})
    assert {"x", "y"} <= names(model)


def test_without_a_start_nothing_counts_as_zero() -> None:
    model = vo.explain(plane_system(), outputs=("x",))
    assert names(model) == {"x", "xdot", "y", "ydot"}


def test_a_parameter_that_is_zero_uncouples_what_it_couples() -> None:
    start = {"x": 0.3, "y": 0.2}
    apart = agreed(plane_system(), ("x",), initial=start, parameters={"k": 0})
    assert names(apart) == {"x", "xdot"}
    assert names(agreed(plane_system(), ("x",), initial=start)) == {"x", "xdot", "y", "ydot"}


def test_an_equilibrium_needs_no_integration() -> None:
    model = agreed(plane_system(), ("x", "y"), initial={})
    assert not model.states
    assert set(kinds(model).values()) == {"zero"}


def test_a_division_by_a_parameter_that_is_zero_is_left_as_it_is() -> None:
    dx = vo.velocity(x)
    force = sp.sin(a * x) / a
    system = vo.System(
        name="quotient", fibration=vo.Fibration(base=(x,)), lagrangian=dx**2 / 2,
        forces={x: -force}, parameters=(vo.Parameter(a, 1),),
    )  # fmt: skip
    model = vo.explain(system, outputs=("x",), initial={"x": 1}, parameters={"a": 0})
    assert se.Symbol("a") in {s for e in model.reduced.force for s in e.free_symbols}


# -- first integrals -------------------------------------------------------------------------------


def line_system(rate: Any, integrals: Mapping[str, Any]) -> vo.System:
    """x is the angle of a free rotor; y' = rate(x) x', a rolling constraint."""
    dx, dy = vo.velocity(x), vo.velocity(y)
    return vo.System(
        name="line", fibration=vo.Fibration(base=(x,), fibre=(y,)),
        lagrangian=(dx**2 + dy**2) / 2 - sp.cos(x) / 4, constraints=(dy - rate * dx,),
        integrals=integrals,
    )  # fmt: skip


def test_a_proved_integral_stands_in_for_an_equation() -> None:
    model = agreed(line_system(sp.cos(x), {"height": y - sp.sin(x)}), ("y",), initial={"xdot": 1})
    assert kinds(model)["y"] == "integral" and "y" not in names(model)


def test_a_false_integral_is_never_used() -> None:
    system = line_system(sp.cos(x), {"height": y - 2 * sp.sin(x)})
    model = agreed(system, ("y",), initial={"xdot": 1})
    assert kinds(model)["y"] == "quadrature"


def test_an_integral_with_a_branch_is_never_used() -> None:
    # d/dx atan(2 tan x) = 2/(1 + 3 sin(x)^2), but the function jumps where x passes a quarter turn
    rate = 2 / (1 + 3 * sp.sin(x) ** 2)
    for claim in (sp.atan(2 * sp.tan(x)), sp.atan2(2 * sp.sin(x), sp.cos(x))):
        model = agreed(line_system(rate, {"jump": y - claim}), ("y",), end=4, initial={"xdot": 2})
        assert kinds(model)["y"] == "quadrature"


def test_an_integral_that_would_enlarge_errors_is_not_used() -> None:
    steep = line_system(1000 * sp.cos(x), {"height": y - 1000 * sp.sin(x)})
    model = agreed(steep, ("y",), initial={"xdot": sp.Rational(1, 10)})
    assert kinds(model)["y"] == "quadrature"


def test_an_integral_that_holds_the_time_is_used_with_the_time() -> None:
    dx = vo.velocity(x)
    falling = vo.System(
        name="falling", fibration=vo.Fibration(base=(x,)), lagrangian=dx**2 / 2 - x,
        integrals={"fall": dx + vo.time},
    )  # fmt: skip
    model = agreed(falling, ("x",), initial={"x": 1, "xdot": 2})
    assert kinds(model)["xdot"] == "integral" and names(model) == {"x"}


# -- what must not be lost -------------------------------------------------------------------------


def test_velocities_that_the_mass_couples_stay_together() -> None:
    dx, dy = vo.velocity(x), vo.velocity(y)
    system = vo.System(
        name="coupled", fibration=vo.Fibration(base=(x, y)),
        lagrangian=dx**2 + dy**2 + sp.cos(y) * dx * dy - y**2 / 2,
    )  # fmt: skip
    model = agreed(system, ("xdot",), initial={"y": 1, "xdot": 1})
    assert {"x", "y"} & names(model) == {"y"} and len(model.states) == 3


def test_momenta_whose_mass_depends_on_the_time_change_with_it() -> None:
    model = agreed(vo.load("sleigh-in-time"), ("v", "w"))
    assert any(c.level == "momenta" for c in model.candidates)


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
    assert any("momenta" in c.level for c in model.candidates)


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


# -- what is said of it ----------------------------------------------------------------------------


def test_the_text_names_every_variable_with_its_reason() -> None:
    text = model_text(vo.explain(vo.load("demchenko"), outputs=("u", "v")))
    assert "the smallest model for u, v" in text
    assert "first integral 'axial'" in text and "theta, u1, v1" in text
    assert "no output depends on it" in text and "chosen" in text
    assert "integrals that can be followed: energy" in text


def test_every_coordinate_and_velocity_has_a_role() -> None:
    for name in ("demchenko", "ball-on-sphere", "snakeboard", "bicycle"):
        system = vo.load(name)
        model = vo.explain(system, outputs=(system.coordinates[0],))
        assert {*map(str, (*system.coordinates, *system.velocities))} <= {*kinds(model)}


def test_data_hold_what_the_text_says() -> None:
    data = vo.explain(vo.load("sleigh"), outputs=("phi",)).as_dict()
    assert data["states"] == ["phi", "v", "w"] and data["level"] == "coordinates"
    assert {"name": "x", "kind": "dropped", "why": "no output depends on it"} in data["variables"]
    assert ["w", "phi"] in data["edges"] and data["levels"][0]["chosen"]


def test_the_picture_has_the_cycles_together_and_the_dropped_apart() -> None:
    model = vo.explain(vo.load("sleigh"), outputs=("x",))
    found, arrows = boxes(model)
    by_names = {box.names: key for key, box in found.items()}
    core = by_names["v", "w"]
    assert found[by_names["y",]].kind == "dropped"
    assert (core, by_names["phi",]) in arrows and (by_names["phi",], by_names["x",]) in arrows
    graph = networkx.DiGraph(arrows)
    assert networkx.is_directed_acyclic_graph(graph)


def test_boxes_lie_in_the_picture_and_not_on_each_other() -> None:
    for name in ("snakeboard", "bicycle", "ball-on-sphere"):
        figure = model_figure(
            vo.explain(vo.load(name), outputs=("x",) if name != "ball-on-sphere" else ("u",))
        )
        (axes,) = figure.axes
        frames = [p.get_bbox() for p in axes.patches if type(p).__name__ == "FancyBboxPatch"]
        width, height = figure.get_size_inches()
        for i, one in enumerate(frames):
            assert 0 <= one.x0 < one.x1 <= width and 0 <= one.y0 < one.y1 <= height
            for other in frames[:i]:
                apart = one.x1 < other.x0 or other.x1 < one.x0
                assert apart or one.y1 < other.y0 or other.y1 < one.y0


# -- refusals --------------------------------------------------------------------------------------


def test_unknown_words_are_refused_with_the_nearest_name() -> None:
    system = vo.load("sleigh")
    with pytest.raises(vo.DefinitionError, match="no output 'phy'; did you mean 'phi'"):
        vo.explain(system, outputs=("phy",))
    with pytest.raises(vo.DefinitionError, match="no scene 'defalt'; did you mean 'default'"):
        vo.explain(system, scene="defalt")
    with pytest.raises(vo.DefinitionError, match="parameter"):
        vo.explain(system, parameters={"zzz": 1})
    with pytest.raises(vo.DefinitionError, match="initial value"):
        vo.explain(system, initial={"zzz": 1})


def test_parameters_without_a_start_say_what_is_missing() -> None:
    with pytest.raises(vo.DefinitionError, match="name a scene, or give initial"):
        vo.explain(plane_system(), parameters={"k": 2})
