"""Models of SymPy's mechanics: our equations of them against SymPy's own, at random states."""

from __future__ import annotations

import contextlib
import random
import zlib
from typing import Any

import mpmath as mp
import pytest
import sympy as sp
from sympy.physics import mechanics as me
from tool_modules import tool

import voronec as vo
from voronec.equations.program import Program

models = tool("figures.mechanics_models")

t = sp.Symbol("t")
DIGITS = 30
CLOSE = mp.mpf("1e-12")


def moving_names(method: Any) -> list[sp.Expr]:
    """What a model holds: constants, coordinates, speeds and rates of these."""
    exprs = [*method.mass_matrix_full, *method.forcing_full]
    exprs += [*(method._f_h if isinstance(method, me.KanesMethod) else method._hol_coneqs)]
    constants = set().union(*(sp.sympify(e).free_symbols for e in exprs)) - {t}
    given = set().union(*(me.find_dynamicsymbols(sp.sympify(e)) for e in exprs))
    return sorted({*constants, *given, *method.q, *method.u, *sp.Matrix(method.u).diff(t)}, key=str)


def numbers(names: list[sp.Expr], seed: str) -> dict[sp.Expr, Any]:
    """Random values, positive."""
    source = random.Random(zlib.crc32(seed.encode()))
    return {s: mp.mpf(source.randint(300, 900)) / 601 for s in names}


def solved(exprs: Any, unknown: Any, point: dict[sp.Expr, Any]) -> dict[sp.Expr, Any]:
    """The point with the unknowns moved so that the expressions vanish (Newton's method)."""
    names = sp.symbols(f"z0:{len(unknown)}")
    rest = {k: v for k, v in point.items() if k not in unknown}
    rows = [sp.sympify(e).subs(dict(zip(unknown, names, strict=True))) for e in exprs]
    call = sp.lambdify([names, list(rest)], rows, "mpmath")
    start = [point[u] for u in unknown]
    values = mp.findroot(lambda *z: call(z, list(rest.values())), start, solver="mdnewton")
    return {**point, **dict(zip(unknown, values, strict=True))}


def valued(matrix: Any, point: dict[sp.Expr, Any]) -> mp.matrix:
    """A matrix in numbers, each part of its entries once; derivatives are replaced as a whole."""
    known, powers = dict(point), {sp.Add: mp.fsum, sp.Mul: mp.fprod, sp.Pow: lambda p: p[0] ** p[1]}

    def value(expr: sp.Expr) -> Any:
        if expr not in known:
            if not expr.args:
                known[expr] = expr._to_mpmath(mp.mp.prec)
            elif expr.func in powers:
                known[expr] = powers[expr.func]([*map(value, expr.args)])
            elif hasattr(mp, str(expr.func)):
                known[expr] = getattr(mp, str(expr.func))(*map(value, expr.args))
            else:  # in pieces
                symbols = {k: sp.Dummy() for k in point}
                call = sp.lambdify([*symbols.values()], expr.xreplace(symbols), "mpmath")
                known[expr] = call(*(point[k] for k in symbols))
        return known[expr]

    plain = sp.Matrix(matrix)
    return mp.matrix([[value(entry) for entry in row] for row in plain.tolist()])


def is_closed(constraints: Any, point: dict[sp.Expr, Any]) -> bool:
    return mp.norm(valued(constraints, point)) < CLOSE**2


def kane_speeds(kane: Any, seed: str) -> tuple[dict[sp.Expr, Any], dict[sp.Expr, Any]]:
    """A point on the constraints, and the rates of all speeds there by SymPy."""
    kane.kanes_equations()
    names = moving_names(kane)
    point = numbers(names, seed)
    while kane._qdep and not is_closed(kane._f_h, point):
        seed += "."
        # smaller at each trial: four parameters of a turn are no larger than one
        near = {q: x * mp.mpf("0.95") ** len(seed) for q, x in point.items() if q in kane.q}
        with contextlib.suppress(ValueError):  # links that are too short
            point = solved(kane._f_h, [*kane._qdep], numbers(names, seed) | near)
    point |= {x: mp.mpf(0) for u in models.auxiliary_speeds(kane) for x in (u, u.diff(t))}
    if kane._udep:
        point = solved(kane._k_nh * kane.u + kane._f_nh, [*kane._udep], point)
    rates = mp.lu_solve(valued(kane.mass_matrix, point), valued(kane.forcing, point))
    return point, dict(zip(kane.u, rates, strict=True))


LAGRANGE = ("rolling_disc_on_the_plane", "pendulum_in_the_plane")
TOO_LONG = ("whipple_bicycle",)
"""Matrices of these are not written out."""
KANE = [n for n in models.MODELS if n not in (*LAGRANGE, *TOO_LONG)]


@pytest.mark.slow
@pytest.mark.parametrize("name", KANE)
def test_rates_of_speeds_are_those_of_kanes_method(name: str) -> None:
    with mp.workdps(DIGITS):
        form = vo.derive(vo.from_mechanics(models.MODELS[name]())).to_mechanics()
        point, expected = kane_speeds(models.MODELS[name](), name)
        point = dict.fromkeys(form.q, mp.mpf("0.7")) | point
        rates = mp.lu_solve(valued(form.mass_matrix, point), valued(form.forcing, point))
        for u, rate in zip(form.u, rates, strict=True):
            assert abs(rate - expected[u]) < CLOSE * (1 + abs(rate)), (name, u)


@pytest.mark.parametrize(
    "name", [n if "pendulum" in n else pytest.param(n, marks=pytest.mark.slow) for n in LAGRANGE]
)
def test_accelerations_are_those_of_lagranges_method(name: str) -> None:
    with mp.workdps(DIGITS):
        method = models.MODELS[name]()
        method.form_lagranges_equations()
        point = numbers(moving_names(method), name)
        if method._hol_coneqs:
            point = solved(method._hol_coneqs, [method.q[0]], point)
        rates = [*method.q.diff(t)]
        point = solved(method.coneqs, rates[: len(method.coneqs)], point)
        count = len(method.q)
        full, right = method.mass_matrix_full, method.forcing_full
        values = mp.lu_solve(valued(full, point), valued(right, point))[count : 2 * count]
        eqs = vo.derive(vo.from_mechanics(models.MODELS[name]()))
        named = {k: sp.Float(v, DIGITS) for k, v in point.items() if not k.has(sp.Derivative)}
        speeds = {v: sp.Float(point[v], DIGITS) for v in eqs.velocities}
        here = eqs.acceleration(named | speeds, digits=DIGITS)
        for q, value in zip(method.q, values, strict=True):
            assert abs(mp.mpf(str(here[q])) - value) < CLOSE * (1 + abs(value)), (name, q)


def test_a_method_and_its_arguments_give_the_same_system() -> None:
    kane = models.skate()
    given = vo.from_mechanics(
        kane._inertial, kane.q, kane.u[:2],
        kd_eqs=kane._k_ku_implicit * kane.u + kane._k_kqdot_implicit * kane.q.diff(t),
        u_dependent=kane.u[2:], velocity_constraints=kane._k_nh * kane.u,
        bodies=kane.bodies, forcelist=kane.loads,
    )  # fmt: skip
    assert given == vo.from_mechanics(kane)
    assert [str(u) for u in given.inputs] == ["T(t)"]


def test_places_that_no_function_of_the_coordinates_gives_are_fibre_coordinates() -> None:
    disc = vo.from_mechanics(models.rolling_disc())
    assert [str(q) for q in disc.fibration.fibre] == ["disc_x(t)", "disc_y(t)"]
    eqs = vo.derive(disc)
    assert eqs.kind == "chaplygin" and eqs.growth == (3, 4, 5)
    # with all velocities derived from places there is nothing to add
    assert vo.derive(vo.from_mechanics(models.rolling_disc_on_the_plane())).growth == (3, 4, 5)
    assert vo.derive(vo.from_mechanics(models.chaos_pendulum())).kind == "holonomic"


@pytest.mark.slow
def test_the_form_has_the_shapes_that_kanes_method_has() -> None:
    form = vo.derive(vo.from_mechanics(models.n_pendulum_on_a_cart())).to_mechanics()
    kane = models.n_pendulum_on_a_cart()
    kane.kanes_equations()
    for name in ("q", "u", "mass_matrix", "mass_matrix_full", "forcing", "forcing_full"):
        assert getattr(form, name).shape == getattr(kane, name).shape, name
    assert form.rhs().shape == kane.forcing_full.shape
    assert form.kindiffdict() == kane.kindiffdict()
    assert form.coordinates == [*kane.q] and form.speeds == [*kane.u]


@pytest.mark.slow
def test_the_program_is_solved_for_the_rates_where_that_is_shorter() -> None:
    eqs = vo.derive(vo.from_mechanics(models.rolling_disc()))
    assert eqs.program.operations < Program.of(eqs.form).operations
    form, names = eqs.to_mechanics(), {}
    exec(eqs.python(), names)
    state = [0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.1]
    values = dict(zip([*form.q, *form.u], state, strict=True)) | {
        p.symbol: 1.5 for p in eqs.system.parameters
    }
    expected = [float(e.subs(values)) for e in form.rhs()]
    assert names["rhs"](0.0, state, [1.5, 1.5, 1.5]) == pytest.approx(expected, rel=1e-13)
    assert vo.derive(vo.load("bicycle")).program.operations < 1500  # too long to be solved


def test_plain_symbols_become_functions_of_the_time() -> None:
    form = vo.derive(vo.load("sleigh")).to_mechanics()
    assert [str(x) for x in (*form.q, *form.u)] == ["x(t)", "phi(t)", "y(t)", "v(t)", "w(t)"]
    held = set().union(*(e.free_symbols for e in (*form.mass_matrix, *form.forcing_full)))
    assert held <= {t, *(p.symbol for p in vo.load("sleigh").parameters)}
    assert all(isinstance(v, float) for v in form.constants.values())


@pytest.mark.slow
def test_pydy_integrates_it() -> None:
    system = pytest.importorskip("pydy.system")
    import numpy as np

    eqs = vo.derive(vo.from_mechanics(models.rolling_disc()))
    form = eqs.to_mechanics()
    start = {q: 0.1 * i for i, q in enumerate(form.q)} | dict.fromkeys(form.u, 0.5)
    values = {p.symbol: v for p, v in zip(eqs.system.parameters, (9.81, 1.0, 1.0), strict=True)}
    run = system.System(form, constants=values, initial_conditions=start)
    run.times = np.linspace(0, 1, 5)
    there = run.integrate(rtol=1e-11, atol=1e-11)
    parameters = {str(k): v for k, v in values.items()}
    initial = {str(k.func): v for k, v in start.items()}
    here = vo.integrate(eqs.system, times=run.times, initial=initial, parameters=parameters)
    for column, name in enumerate(str(x.func) for x in (*form.q, *form.u)):
        assert np.allclose(there[:, column], here[name], atol=1e-7), name


N = me.ReferenceFrame("N")
P = me.Point("P")
Q, U, W = me.dynamicsymbols("q u w")
MASS = me.Particle("mass", P, sp.Symbol("m"))
P.set_vel(N, U * N.x)


@pytest.mark.parametrize(
    ("words", "given"),
    [
        ("no bodies", {"bodies": None}),
        ("neither a RigidBody nor a Particle", {"bodies": [3]}),
        ("no pair of a Point", {"forcelist": [(3, N.x)]}),
        ("nothing that has a velocity", {"forcelist": [(sp.Symbol("q"), N.x)]}),
        ("the load on 'lost'", {"forcelist": [(me.Point("lost"), N.x)]}),
        ("loads hold no accelerations", {"forcelist": [(P, U.diff(t) * N.x)]}),
        ("holds 'Derivative(w(t), (t, 2))'", {"forcelist": [(P, W.diff(t, 2) * N.x)]}),
        ("the axes of", {"forcelist": [(P, me.ReferenceFrame("M").x)]}),
        ("neither a symbol nor a dynamicsymbol", {"u_ind": [U**2]}),
        ("not linear in the speeds", {"kd_eqs": [Q.diff(t) - U**2]}),
        ("arguments are those of KanesMethod", {"wheels": 3}),
    ],
)
def test_what_makes_no_sense_is_refused_in_one_line(words: str, given: dict[str, Any]) -> None:
    usual = {"q_ind": [Q], "u_ind": [U], "kd_eqs": [Q.diff(t) - U], "bodies": [MASS]}
    with pytest.raises(vo.DefinitionError) as refusal:
        vo.from_mechanics(N, **(usual | given))
    assert words in str(refusal.value) and "\n" not in str(refusal.value)


def test_a_body_without_an_orientation_is_refused() -> None:
    x, spins = me.dynamicsymbols("x"), me.dynamicsymbols("w1:4")
    ground, ball = me.ReferenceFrame("G"), me.ReferenceFrame("B")
    ball.set_ang_vel(ground, spins[0] * ground.x + spins[1] * ground.y + spins[2] * ground.z)
    centre = me.Point("C")
    centre.set_vel(ground, spins[1] * ground.x - spins[0] * ground.y)
    moments = (me.inertia(ground, 1, 1, 1), centre)
    body = me.RigidBody("ball", centre, ball, 1, moments)
    with pytest.raises(vo.DefinitionError, match="add coordinates for its orientation"):
        vo.from_mechanics(ground, [x], spins, kd_eqs=[x.diff(t) - spins[1]], bodies=[body])


def test_something_else_is_refused() -> None:
    with pytest.raises(vo.DefinitionError, match="arguments are those of LagrangesMethod"):
        vo.from_mechanics("disc")
    with pytest.raises(vo.DefinitionError, match="give it alone"):
        vo.from_mechanics(models.skate(), 3)


def test_symbols_that_do_no_work_are_parameters_and_inputs() -> None:
    q, u, push = me.dynamicsymbols("q u F")
    ground, origin = me.ReferenceFrame("N"), me.Point("O")
    origin.set_vel(ground, 0)
    rod = ground.orientnew("A", "Axis", [q, ground.z])
    rod.set_ang_vel(ground, u * ground.z)
    centre = origin.locatenew("C", sp.Symbol("l") * rod.x)
    centre.v2pt_theory(origin, ground, rod)
    inertia = me.inertia(rod, *sp.symbols("I_x I_y I_z"))
    body = me.RigidBody("b", centre, rod, sp.Symbol("m"), (inertia, centre))
    idle = -sp.Symbol("g") * ground.z + push * ground.z  # the plane is level
    system = vo.from_mechanics(
        ground, [q], [u], [q.diff(t) - u], bodies=[body], forcelist=[(centre, idle)]
    )
    assert [p.name for p in system.parameters] == ["I_x", "I_y", "I_z", "g", "l", "m"]
    assert system.inputs == (push,)
    length, m, moment = sp.symbols("l m I_z")
    assert sp.expand(vo.derive(system).mass[0, 0] - m * length**2 - moment) == 0


def test_auxiliary_speeds_bring_the_reactions_that_kanes_method_finds() -> None:
    kane = models.rolling_disc_with_contact_forces()
    with mp.workdps(DIGITS):
        point, rates = kane_speeds(kane, "contact")
        own = dict(
            zip(kane.q.diff(t), valued(list(kane.kindiffdict().values()), point), strict=True)
        )
        own |= point | {u.diff(t): a for u, a in rates.items()}
        forces = me.dynamicsymbols("f1:4")
        expected = solved(kane.auxiliary_eqs, forces, own | dict.fromkeys(forces, mp.mpf(1)))
    system = vo.from_mechanics(models.rolling_disc_with_contact_forces())
    idle = models.auxiliary_speeds(kane)
    values = {k: v for k, v in point.items() if not k.has(sp.Derivative) and k not in idle}
    at = dict.fromkeys(system.coordinates, 1) | values | dict.fromkeys(forces, 0)
    found = vo.reaction_forces(system, at, DIGITS).multipliers
    for force, ours in zip(forces, found, strict=False):
        assert abs(expected[force] - mp.mpf(str(ours))) < CLOSE, force


def test_accelerations_that_are_set_against_the_velocities_are_not_read() -> None:
    # SymPy's test of auxiliary speeds treats the contact as a point fixed in the disc
    from test_mechanics_models import disc_with_contact_forces

    given = vo.from_mechanics(disc_with_contact_forces(set_acceleration=True))
    assert given == vo.from_mechanics(disc_with_contact_forces(set_acceleration=False))


USUAL = {"q_ind": [Q], "u_ind": [U], "kd_eqs": [Q.diff(t) - U], "bodies": [MASS]}


def test_what_sympy_is_told_of_its_solvers_changes_nothing() -> None:
    plain = vo.from_mechanics(N, **USUAL)
    told = {"constraint_solver": "CRAMER", "kd_eqs_solver": "LU", "explicit_kinematics": False}
    assert vo.from_mechanics(N, **USUAL, **told) == plain
    form = vo.derive(plain).to_mechanics()
    assert form.linearize(new_method=True, simplify=True) == form.linearize()


def test_symbols_with_assumptions_come_back_as_they_are() -> None:
    q, u, push = me.dynamicsymbols("q u F", real=True)
    ground, point = me.ReferenceFrame("N"), me.Point("P")
    point.set_vel(ground, u * ground.x)
    mass = me.Particle("mass", point, sp.Symbol("m", positive=True))
    load = (point, push * ground.x)
    system = vo.from_mechanics(ground, [q], [u], [q.diff(t) - u], bodies=[mass], forcelist=[load])
    form = vo.derive(system).to_mechanics()
    assert (form.q[0], form.u[0], form.forcing[0]) == (q, u, push)
    assert system.inputs == (push,)


def test_rows_that_follow_from_others_are_named_and_left_out() -> None:
    from test_mechanics_models import robot

    energy, ground, q, rows = robot()
    with pytest.warns(
        UserWarning, match="constraints that follow from the others are left out"
    ) as w:
        found = vo.from_mechanics(energy, q, nonhol_coneqs=rows, frame=ground)
    assert str(w[0].message).count("= 0") == 3
    few = vo.from_mechanics(energy, q, nonhol_coneqs=[rows[k] for k in (0, 1, 3)], frame=ground)
    assert found == few
    with pytest.raises(vo.DefinitionError, match="contradicts the others"):
        vo.from_mechanics(energy, q, nonhol_coneqs=[*rows, rows[0] - 1], frame=ground)


def test_a_connector_without_mass_adds_no_coordinates() -> None:
    lost = me.Point("L")
    lost.set_vel(N, U * sp.cos(W) * N.x + Q * U * N.y)  # the rate of no place
    connector = me.Particle("connector", lost, 0)
    system = vo.from_mechanics(N, **(USUAL | {"bodies": [MASS, connector]}))
    assert system.coordinates == (Q,)


@pytest.mark.slow
def test_axes_turned_by_exponentials_of_speeds_cost_nothing() -> None:
    q, u = me.dynamicsymbols("q1:4"), me.dynamicsymbols("u1:4")
    found = []
    for turns in (0, 3):
        ground, body = me.ReferenceFrame("N"), me.ReferenceFrame("C")
        body.orient_body_fixed(ground, q, "zxy")
        turning, axes = body.ang_vel_in(ground), body
        for i in range(turns):
            axes = axes.orientnew(f"D{i}", "Axis", [sp.exp(u[i]), [*axes][i]])
        spin = sum((v * e for v, e in zip(u, body, strict=True)), 0 * body.x)
        body.set_ang_vel(ground, spin.express(axes))
        centre = me.Point("P")
        centre.set_vel(ground, 0)
        ball = me.RigidBody("b", centre, body, 1, (me.inertia(body, 1, 2, 3), centre))
        kd = [me.dot(spin - turning, axis) for axis in body]
        found.append(vo.derive(vo.from_mechanics(ground, q, u, kd, bodies=[ball])))
    point = {x: mp.mpf(k + 2) / 7 for k, x in enumerate((*q, *u))}
    plain, turned = (valued(e.mass, point) ** -1 * valued(e.force, point) for e in found)
    assert mp.norm(plain - turned) < 1e-12


def test_auxiliary_speeds_that_turn_a_body_are_zero() -> None:
    q, u, a, b = me.dynamicsymbols("q u a b")
    ground, centre = me.ReferenceFrame("N"), me.Point("C")
    centre.set_vel(ground, 0)
    found = []
    for held in ((), (a, b)):  # by two speeds across its pin a body has no orientation
        own = ground.orientnew("A", "Axis", [q, ground.z])
        across = sum((v * e for v, e in zip(held, own, strict=False)), 0 * own.x)
        own.set_ang_vel(ground, u * own.z + across)
        body = me.RigidBody("b", centre, own, 1, (me.inertia(own, 1, 2, 3), centre))
        given = {"kd_eqs": [q.diff(t) - u], "bodies": [body], "u_auxiliary": held}
        found.append(vo.from_mechanics(ground, [q], [u], **given))
    assert found[0] == found[1]
