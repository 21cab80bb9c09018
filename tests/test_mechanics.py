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
    """A matrix in numbers; derivatives are replaced as a whole."""
    symbols = {k: sp.Dummy() for k in point}
    plain = sp.Matrix(matrix).xreplace(symbols)
    call = sp.lambdify([list(symbols.values())], plain.tolist(), "mpmath", cse=True)
    return mp.matrix(call([point[k] for k in symbols]))


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
    point |= {x: mp.mpf(0) for u in kane._uaux for x in (u, u.diff(t))}
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
