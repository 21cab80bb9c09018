"""Bad definitions: one line that names the object and the mend, of the right kind."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

import voronec as vo
from voronec import DefinitionError, Fibration, Frame, Parameter, Scene, System, time, velocity

x, y, z, phi, s = sp.symbols("x y z phi s")
Dx, Dy, Dz, Dphi = map(velocity, (x, y, z, phi))
v, w, m, k = sp.symbols("v w m k")
PLANE = Fibration((x, phi), (y,))
KINETIC = (Dx**2 + Dy**2 + Dphi**2) / 2
KNIFE = Dy - sp.tan(phi) * Dx


def asked(**options):
    given = {"name": "s", "fibration": PLANE, "lagrangian": KINETIC, "constraints": (KNIFE,)}
    eqs = vo.derive(System(**(given | options)))
    return eqs.force


def test_the_sound_definition_is_accepted():
    assert asked().shape == (2, 1)


QUASI = {v: Dx, w: Dphi}
MEANT = {
    "curved constraint": (
        {"constraints": (Dy**2 - Dx,)}, ["constraint 1", "not affine in the velocities"],
    ),
    **{
        f"constraint with a corner: {corner}": (
            {"constraints": (Dy - corner,)}, ["constraint 1", "not affine in the velocities"],
        )
        for corner in (sp.sign(Dx), sp.Abs(Dx), sp.Max(Dx, 0), sp.floor(Dx), sp.sqrt(Dx**2))
    },
    "constraint on coordinates": ({"constraints": (KNIFE, x - phi)}, ["redundant", "frame="]),
    "constraint nothing": ({"constraints": (sp.Integer(0),)}, ["constraint 1"]),
    "constraint impossible": ({"constraints": (sp.Integer(1),)}, ["constraint 1", "drop it"]),
    "too many": ({"constraints": (KNIFE, Dx)}, ["2 constraint", "1 fibre"]),
    "too few": ({"constraints": ()}, ["1 fibre", "0 constraint", "to the base"]),
    "dependent": (
        {"fibration": Fibration((phi,), (x, y)), "constraints": (KNIFE, 2 * KNIFE)},
        ["constraint 2", "follows from the others", "drop it"],
    ),
    "dependent in disguise": (
        {
            "fibration": Fibration((phi,), (x, y)),
            "constraints": (Dy * sp.cos(phi) - Dx * sp.sin(phi), Dy - Dx * sp.tan(phi)),
        },
        ["follows from the others"],
    ),
    "contradictory": (
        {"fibration": Fibration((phi,), (x, y)), "constraints": (KNIFE, KNIFE - 1)},
        ["constraint 2", "contradict"],
    ),
    "not transverse": (
        {"constraints": (Dx - Dphi,)}, ["undetermined: y", "base=(phi, y), fibre=(x)"],
    ),
    "unknown symbol": ({"lagrangian": KINETIC + k}, ["the Lagrangian", "'k'", "parameters="]),
    "unknown in a constraint": ({"constraints": (KNIFE - k,)}, ["constraint 1", "'k'"]),
    "unknown in a force": ({"forces": {x: k}}, ["the force on 'x'", "'k'"]),
    "unknown in the frame": ({"frame": Frame.quasi({v: Dx + k, w: Dphi})}, ["'v'", "'k'"]),
    "unknown in a claim": ({"integrals": {"E": k}}, ["integral 'E'", "'k'"]),
    "an acceleration": ({"lagrangian": KINETIC + velocity(Dx)}, ["'xdotdot'"]),
    "another symbol of the name": (
        {"lagrangian": KINETIC * sp.Symbol("x", positive=True)}, ["'x'", "one symbol object"],
    ),
    "force on nothing": ({"forces": {z: 1}}, ["'z'", "neither a coordinate", "'phi'"]),
    "parameter twice": ({"parameters": (m, m)}, ["'m' is used twice", "rename"]),
    "parameter and coordinate": (
        {"parameters": (x,)}, ["'x' is used twice", "a coordinate and a parameter"],
    ),
    "parameter and time": ({"parameters": (time,)}, ["'t'", "the time"]),
    "unknown beside the frame": ({"frame": Frame.quasi(QUASI, {z: Dx + k})}, ["'z'", "'k'"]),
    "too many beside the frame": (
        {"frame": Frame.quasi(QUASI, {z: Dx, k: Dx})}, ["2 velocities beside"],
    ),
    "quasi-velocity and velocity": ({"frame": Frame.quasi({Dx: Dx, w: Dphi})}, ["'xdot'", "twice"]),
    "no inertia": ({"lagrangian": (Dx**2 + Dy**2) / 2}, ["mass matrix is singular", "'phidot'"]),
    "no inertia in a combination": (
        {"lagrangian": (Dx + Dphi) ** 2 / 2}, ["singular", "xdot, phidot"],
    ),
    "no Lagrangian": ({"lagrangian": 0}, ["mass matrix is singular"]),
    "curved frame": ({"frame": Frame.quasi({v: Dx**2, w: Dphi})}, ["'v'", "not affine"]),
    "dependent frame": ({"frame": Frame.quasi({v: Dx, w: 2 * Dx})}, ["do not determine", "phi"]),
    "small frame": ({"frame": Frame.quasi({v: Dx})}, ["phi", "1 more"]),
    "large frame": ({"frame": Frame.quasi(QUASI | {z: Dx + Dphi})}, ["dependent", "leave out"]),
    "frame by itself": ({"frame": Frame.quasi({v: Dx + w, w: Dphi})}, ["'v'", "quasi-velocity"]),
    "relation on velocities": (
        {"fibration": Fibration((x, phi), (y,), relations=(y * Dx - 1,))}, ["relation 1", "xdot"],
    ),
    "relation on quasi-velocities": (
        {
            "fibration": Fibration((x, phi), (y,), relations=(y - v,)), "constraints": (),
            "frame": Frame.quasi(QUASI),
        },
        ["relation 1", "v"],
    ),
    "redundant base without a frame": (
        {"fibration": Fibration((x, phi), (y,), relations=(x**2 + phi**2 - 1,))},
        ["redundant", "frame="],
    ),
    "impossible relation": (
        {"fibration": Fibration((x, phi), (y,), relations=(sp.Integer(1),))}, ["relation 1"],
    ),
    "Heaviside": (
        {"lagrangian": KINETIC + sp.Heaviside(x)},
        ["the Lagrangian", "jumps where x = 0", "impact"],
    ),
    "DiracDelta": (
        {"lagrangian": KINETIC + sp.DiracDelta(x)}, ["the Lagrangian", "DiracDelta", "elementary"],
    ),
    "not a number": ({"lagrangian": KINETIC + sp.nan}, ["nan"]),
    "imaginary": ({"lagrangian": KINETIC * sp.I}, ["I"]),
    "Lagrangian missing": ({"lagrangian": None}, ["Lagrangian"]),
    "Lagrangian unreadable": ({"lagrangian": "x + ("}, ["Lagrangian"]),
    "Lagrangian a matrix": ({"lagrangian": sp.eye(2)}, ["Lagrangian"]),
    "Lagrangian a list": ({"lagrangian": [KINETIC]}, ["Lagrangian"]),
    "Lagrangian true": ({"lagrangian": sp.true}, ["Lagrangian"]),
    "constraints missing": ({"constraints": None}, ["constraints", "tuple"]),
    "two equations": ({"constraints": ("xdot = ydot = 1",)}, ["constraint 1", "column 6"]),
    "equation without a side": ({"constraints": ("xdot =",)}, ["constraint 1", "a number"]),
    "an input perhaps": ({"forces": {x: k}}, ["inputs=(...)"]),
    "essential in a text": ({"essential": ("x",)}, ["essential: 'x' is no symbol"]),
    "constraints a mapping": ({"constraints": {y: KNIFE}}, ["constraints", "tuple"]),
    "constraint trivial": ({"constraints": (sp.Eq(Dy, Dy),)}, ["constraint"]),
    "constraint missing": ({"constraints": (None,)}, ["constraint 1 is 'None'"]),
    "constraint an inequality": ({"constraints": (Dy < Dx,)}, ["constraint", "vanishes"]),
    "constraint unreadable": ({"constraints": ("ydot - (",)}, ["constraint"]),
    "parameters a mapping": ({"parameters": {m: 1}}, ["parameters", "tuple"]),
    "parameter a string": ({"parameters": ("m",)}, ["'m'", "sympy.Symbol"]),
    "forces a list": ({"forces": [1]}, ["forces"]),
    "force missing": ({"forces": {x: None}}, ["force"]),
    "frame a mapping": ({"frame": {v: Dx, w: Dphi}}, ["Frame.quasi"]),
    "fibration a tuple": ({"fibration": ((x, phi), (y,))}, ["Fibration"]),
    "integrals a list": ({"integrals": [Dx]}, ["integrals"]),
    "scenes a list": ({"scenes": [1]}, ["scenes"]),
    "scene a mapping": ({"scenes": {"default": {x: 1}}}, ["scene 'default'", "Scene(initial="]),
    "coordinate and time": (
        {"fibration": Fibration((x, time), (y,))}, ["'t'", "a coordinate and the time"],
    ),
    "imaginary force": ({"forces": {x: sp.I}}, ["the force on 'x'", "Symbol('I')"]),
    "invariants a list": ({"invariants": [x]}, ["invariants"]),
    "measure unreadable": ({"measure": "x("}, ["measure"]),
    "name a number": ({"name": 5}, ["name"]),
}  # fmt: skip


@pytest.mark.parametrize(("options", "words"), MEANT.values(), ids=MEANT)
def test_a_bad_definition_is_refused_in_one_line_that_names_it(options, words):
    with pytest.raises(DefinitionError) as caught:
        asked(**options)
    message = str(caught.value)
    assert "\n" not in message
    for word in words:
        assert any(part in message for part in word.split("|")), message


MADE = {
    "base a number": (lambda: Fibration(base=5), "base"),
    "base missing": (lambda: Fibration(base=None), "base"),
    "base a string": (lambda: Fibration(base="xy"), "base"),
    "base an expression": (lambda: Fibration(base=(x + y,)), "base"),
    "base twice": (lambda: Fibration(base=(x, x)), "'x' is listed twice"),
    "base and fibre": (lambda: Fibration(base=(x,), fibre=(x,)), "'x' is listed twice"),
    "relation missing": (lambda: Fibration((x,), relations=(None,)), "relation"),
    "relations a mapping": (lambda: Fibration((x,), relations={x: 1}), "relations"),
    "relation unreadable": (lambda: Fibration((x,), relations=("x(",)), "relation"),
    "frame empty": (lambda: Frame.quasi({}), "non-empty mapping"),
    "frame a list": (lambda: Frame.quasi([v]), "mapping"),
    "frame of a sum": (lambda: Frame.quasi({v + w: Dx}), "frame"),
    "frame unreadable": (lambda: Frame.quasi({v: "x("}), "'v'"),
    "frame missing": (lambda: Frame.quasi({v: None}), "'v'"),
    "negative": (lambda: Parameter(m, -1, positive=True), "'m' = -1 must be positive"),
    "not a value": (lambda: Parameter(m, "wide"), "'m' = wide"),
    "a symbol for a value": (lambda: Parameter(m, k), "'m' = k"),
    "imaginary": (lambda: Parameter(m, 1j), "'m' = 1j"),
    "nan": (lambda: Parameter(m, float("nan")), "'m' = nan"),
    "infinite": (lambda: Parameter(m, float("inf")), "'m' = inf"),
    "above": (lambda: Parameter(m, 2, upper=1), "above 1"),
    "below": (lambda: Parameter(m, 0, lower=1), "below 1"),
    "bound unreadable": (lambda: Parameter(m, 2, lower="q("), "'m'"),
    "a string": (lambda: Parameter("m"), "sympy.Symbol"),
    "scene of a list": (lambda: Scene(initial=[1]), "initial"),
    "velocity of a number": (lambda: velocity(5), "symbol"),
    "velocity of a sum": (lambda: velocity(x + y), "symbol"),
    "measure in a text": (lambda: vo.Measure(1, ("x",)), "'x' is no symbol; give the symbol"),
    "measure of an array": (lambda: vo.Measure(1, (sp.sin(x), np.ones(2))), "is no symbol"),
    "measure of one variable twice": (lambda: vo.Measure(1, (x, y, x)), "'x' is named twice"),
    "derive nothing": (lambda: vo.derive(None), "System"),
    "derive a name": (lambda: vo.derive("sleigh"), "System"),
}


@pytest.mark.parametrize(("make", "word"), MADE.values(), ids=MADE)
def test_a_bad_part_is_refused_in_one_line(make, word):
    with pytest.raises(DefinitionError) as caught:
        make()
    assert "\n" not in str(caught.value) and word in str(caught.value)


def test_the_lagrangian_forces_and_constraints_may_be_written_with_quasi_velocities():
    frame = Frame.quasi({v: Dx + Dphi * x, w: Dphi})
    body = {"name": "s", "fibration": PLANE, "frame": frame}
    meant = System(
        lagrangian=KINETIC + (Dx + Dphi * x) * phi,
        constraints=(Dy - (Dx + Dphi * x) * phi,),
        forces={x: Dx + Dphi * x},
        **body,
    )
    said = System(lagrangian=KINETIC + v * phi, constraints=(Dy - v * phi,), forces={x: v}, **body)
    point = {x: 1, phi: 2, y: 0, v: 3, w: 4}
    found = vo.derive(said).acceleration(point)
    assert found == vo.derive(meant).acceleration(point)
    independent = vo.multiplier_acceleration(said, point)
    assert all(abs(found[q] - independent[q]) < 1e-25 for q in found)


def test_a_quasi_velocity_in_the_lagrangian_moves_by_its_definition():
    system = System(
        name="s",
        fibration=Fibration((x, phi)),
        frame=Frame.quasi({v: Dx + Dphi * x, w: Dphi}),
        lagrangian=(Dx**2 + Dphi**2) / 2 + v * phi,
    )
    found = vo.derive(system).acceleration({x: 1, phi: 2, v: 3, w: 4})
    assert abs(found[x] - 4) < 1e-25 and abs(found[phi] - 1) < 1e-25


def test_one_thing_stands_for_a_tuple_of_it():
    bare = System("s", Fibration((x, phi), y), KINETIC * m, KNIFE, m, references="Key")
    full = System("s", PLANE, KINETIC * m, (KNIFE,), (m,), references=("Key",))
    assert bare == full
    assert System("s", PLANE, KINETIC * m, sp.Eq(KNIFE, 0), Parameter(m, 1)).constraints == (KNIFE,)
    for text in ("ydot - tan(phi)*xdot", "ydot = tan(phi)*xdot", "ydot == tan(phi)*xdot"):
        assert System("s", PLANE, KINETIC, text) == System("s", PLANE, KINETIC, KNIFE)
    circle = x**2 + y**2 - 1
    assert Fibration((x, y), relations="x^2 + y^2 = 1").relations == (circle,)
    assert Fibration((x, y), relations=circle) == Fibration((x, y), relations=(circle,))


def test_a_constraint_that_only_looks_curved_is_accepted():
    disguised = (sp.sin(x) ** 2 + sp.cos(x) ** 2 - 1) * Dx**2 + KNIFE
    assert asked(constraints=(disguised,)) == asked()


def test_the_split_offered_works():
    constraints = (Dx - Dphi, Dphi - 2 * Dx + Dz)
    with pytest.raises(DefinitionError, match="a split that works") as caught:
        asked(
            fibration=Fibration((x, phi), (y, z)),
            lagrangian=KINETIC + Dz**2,
            constraints=constraints,
        )
    text = str(caught.value)
    parts = [text.split(f"{part}=(")[1].split(")")[0].split(", ") for part in ("base", "fibre")]
    base, fibre = (tuple(sp.Symbol(n) for n in part) for part in parts)
    assert asked(
        fibration=Fibration(base, fibre), lagrangian=KINETIC + Dz**2, constraints=constraints
    ).rows == len(base)


@pytest.mark.parametrize("name", ["rolling-body", "symmetric-body-on-sphere"])
def test_a_system_with_unknown_functions_has_no_motion_in_numbers(name):
    with pytest.raises(vo.DefinitionError, match="holds the unknown function"):
        vo.integrate(vo.load(name), times=[0, 1], initial={})


@pytest.mark.parametrize("value", [-0.0, 0, False, ()])
def test_a_theorem_is_named_by_a_text(value):
    with pytest.raises(DefinitionError, match="names no theorem"):
        vo.Case({}, integrable=value)
