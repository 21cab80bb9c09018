"""Claims written by hand, false and true ones: bounces, cuts, wrong levels and orders, dependent
parameters, orientation, sheets.  No false one is proved, and no true one refuted."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
import sympy as sp
from sympy import Abs, Max, atan, atan2, cos, floor, sign, sin, sqrt

import voronec as vo
from voronec.declaration.charts import Chart
from voronec.declaration.quadratures import Quadratures
from voronec.equations.motions import Motions
from voronec.proof.claims import check_claims
from voronec.proof.quadratures import check_motion
from voronec.proof.relations.charts import check_charts

pytestmark = pytest.mark.slow

x, y, z, q, r, phi, u, h, p, j, c, g, m, k, w, v, eps = sp.symbols(
    "x y z q r phi u h p j c g m k w v eps"
)
arm = sp.Symbol("a")
n = sp.Symbol("n", integer=True)
X, Y, Z, Q, R, P = (vo.velocity(s) for s in (x, y, z, q, r, phi))
half, t = sp.Rational(1, 2), vo.time
omega = sqrt(k / m)


def positive(*symbols):
    return tuple(vo.Parameter(s, positive=True) for s in symbols)


def system(name, base, lagrangian, parameters=(), fibre=(), **more):
    fibration = vo.Fibration(tuple(base), tuple(fibre))
    return vo.System(name, fibration, lagrangian, parameters=tuple(parameters), **more)


SPRING = system("spring", (x,), m * X**2 / 2 - k * x**2 / 2, positive(m, k))
LINE = system("line", (x,), X**2 / 2)
PLANE = system("plane", (x, y), (X**2 + Y**2) / 2)
QUARTIC = system("quartic", (x,), X**2 / 2 - x**4 / 4)
DOWN = system("down", (x,), X**2 / 2 - x)
BESIDE = system("beside", (x, y), (X**2 + Y**2) / 2 - x**4 / 4)
ISOTROPIC = system(
    "isotropic", (x, y), m * (X**2 + Y**2) / 2 - k * (x**2 + y**2) / 2, positive(m, k)
)
ANISOTROPIC = system("anisotropic", (x, y), (X**2 + Y**2) / 2 - (x**2 + 2 * y**2) / 2)
BENT = system(
    "bent", (x,), m * X**2 / 2 - k * x**2 / 2 - c * x**4, (*positive(m, k), vo.Parameter(c))
)
SLEIGH = vo.load("sleigh")
TILTED = system(
    "tilted", (x, y), (X**2 + Y**2 + Z**2) / 2, fibre=(z,), constraints=(Z - y * X,)
)  # fmt: skip
LESS = replace(SPRING, name="less", possible={"k < m": k < m})
SAME = replace(SPRING, name="same", possible={"k = m": sp.Eq(k, m)})
SYSTEMS = (
    SPRING, LINE, PLANE, ISOTROPIC, ANISOTROPIC, BENT, SLEIGH,
    system("unit", (q,), (Q**2 - w**2 * q**2) / 2, (w,)),
    system("free", (q,), Q**2 / 2),
    system("radial", (r,), R**2 / 2 - j**2 / (2 * r**2), (j,)),
    system("fall", (q,), Q**2 / 2 + g * q, (g,)),
    system("pendulum", (phi,), P**2 / 2 + g * cos(phi), (g,)),
    system("other-pendulum", (q,), Q**2 / 2 + g * cos(q), (g,)),
)  # fmt: skip


def relation(source, target, **more):
    return "relation", vo.Relation(source, target, **more)


def to_unit(place, frequency=omega, **more):
    state = place if isinstance(place, dict) else {q: place}
    return relation("spring", "unit", state=state, parameters={w: frequency}, **more)


def to_free(place, **more):
    return relation("line", "free", state={q: place}, **more)


def moved_sleigh(x, y, phi, v, w, clock=1, a=arm):
    state = {"x": x, "y": y, "phi": phi, "v": v, "w": w}
    parameters = {s.symbol: a if str(s.symbol) == "a" else s.symbol for s in SLEIGH.parameters}
    return relation("sleigh", "sleigh", state=state, parameters=parameters, clock=clock)


def to_spring(values, order=1, place=x, stiffness=k):
    limit = vo.Limit(eps, values, order)
    parameters = {m: m, k: stiffness}
    return relation("bent", "spring", state={x: place}, parameters=parameters, limit=limit)


def chart(of, place, **more):
    state = place if isinstance(place, dict) else {x: place}
    return "chart", replace(of, charts={"chart": Chart(state=state, singular=x, **more)})


def bracket(variables, entries, hamiltonian, clock=1, of=SPRING):
    return "claims", replace(of, poisson=vo.Poisson(variables, entries, hamiltonian, clock))


def claim(of, **claims):
    return "claims", replace(of, **claims)


def integral(of, function):
    return claim(of, integrals={"F": function})


def quadrature(quartic, of=QUARTIC, variable=x, level=X**2 / 2 + x**4 / 4, **more):
    constants = {h: level, **more.pop("constants", {})}
    return "motion", replace(
        of,
        motion=Quadratures(
            variable={u: variable},
            constants=constants,
            quartic=quartic,
            integrals=more.pop("integrals", {}),
            **more,
        ),
    )


ENERGY = p**2 / (2 * m) + k * q**2 / 2

FALSE: dict[str, Any] = {
    "bounce abs": to_unit(Abs(x), omega),
    "bounce root": to_unit(sqrt(x**2), omega),
    "bounce max": to_unit(Max(x, -x), omega),
    "bounce sign": to_unit(x * sign(x), omega),
    "bounce of velocity": to_unit(Abs(X), omega),
    "bounce given": relation("line", "free", state={q: Abs(x), Q: X * sign(x)}),
    "bounce on a slope": to_free(Abs(x - 1) + x),
    "bounce fourth root": to_free((x**4) ** sp.Rational(1, 4)),
    "bounce acos": to_free(sp.acos(cos(x))),
    "bounce asin": to_free(sp.asin(sin(x))),
    "stairs": to_free(x + floor(x)),
    "step": to_free(x + sign(x)),
    "step in clock": to_free(x, clock=sign(x)),
    "clock root": to_free(x, clock=sqrt(x**2) / x),
    "clock zero": to_free(x, clock=0),
    "clock 2": to_unit(x, omega, clock=2),
    "clock by x": to_free(x, clock=1 + x**2),
    "given velocity": to_unit({q: x, Q: 2 * X}, omega),
    "reversed velocity": to_unit({q: x, Q: X}, omega, clock=-1),
    "parameter jumps": to_unit(x, omega * sign(x)),
    "parameter jumps in v": to_unit(x, omega * sqrt(X**2) / X),
    "parameter moves": to_unit(x, omega + x),
    "parameter on a level": to_unit(x, omega * (m * X**2 + k * x**2)),
    "parameter inverse": to_unit(x, sqrt(m / k)),
    "parameter squared": to_unit(x, k / m),
    "phase given wrong": to_unit({q: x * cos(1) + X * sin(1), Q: X * cos(1) - x * sin(1)}, omega),
    "square": to_unit(x**2, 2 * omega),
    "product of one frequency": to_unit(x * X, omega),
    "energy as place": to_unit(m * X**2 + k * x**2, omega),
    "shift": to_unit(x + 1, omega),
    "shift in time squared": to_free(x + t**2),
    "exchange of parameters": relation("spring", "spring", state={x: x}, parameters={m: k, k: m}),
    "swapped aniso": relation("anisotropic", "anisotropic", state={x: y, y: x}),
    "turned aniso": relation(
        "anisotropic", "anisotropic", state={x: x * cos(1) - y * sin(1), y: x * sin(1) + y * cos(1)}
    ),
    "no rotation": relation("plane", "plane", state={x: x * cos(x), y: y * sin(x)}),
    "reflected half plane": relation("plane", "plane", state={x: x, y: Abs(y)}),
    "rotating without force": relation(
        "plane", "plane", state={x: x * cos(t) - y * sin(t), y: x * sin(t) + y * cos(t)}
    ),
    "radius wrong level": relation(
        "plane", "radial", state={r: sqrt(x**2 + y**2)}, parameters={j: 1}
    ),
    "radius other momentum": relation(
        "plane", "radial", state={r: sqrt(x**2 + y**2)}, parameters={j: x * Y + y * X}
    ),
    "radius of a line": relation("line", "radial", state={r: sqrt(x**2)}, parameters={j: 0}),
    "square falls wrong": relation("line", "fall", state={q: x**2}, parameters={g: X**2}),
    "square falls abs": relation(
        "line", "fall", state={q: x * Abs(x)}, parameters={g: 2 * X**2 * sign(x)}
    ),
    "pendulum upside down": relation(
        "pendulum", "other-pendulum", state={q: phi + sp.pi}, parameters={g: g}
    ),
    "pendulum mirrored g": relation(
        "pendulum", "other-pendulum", state={q: -phi}, parameters={g: -g}
    ),
    "pendulum half": relation("pendulum", "other-pendulum", state={q: 2 * phi}, parameters={g: g}),
    "sleigh mirrored, same turn": moved_sleigh(x, -y, -phi, v, w),
    "sleigh backwards": moved_sleigh(x, y, phi + sp.pi, -v, w),
    "sleigh swapped without mirror": moved_sleigh(y, x, sp.pi / 2 - phi, v, w),
    "sleigh turned wrong sense": moved_sleigh(
        cos(1) * x - sin(1) * y, sin(1) * x + cos(1) * y, phi - 1, v, w
    ),
    "sleigh reversed, not w": moved_sleigh(x, y, phi, -v, w, clock=-1),
    "sleigh |w|": moved_sleigh(x, y, phi, v, Abs(w)),
    "limit order": to_spring({c: eps}, 2, x, k),
    "limit order root": to_spring({c: sqrt(eps)}, 1, x, k),
    "limit wrong target": to_spring({c: eps}, 1, x, 2 * k),
    "limit of the state": to_spring({c: eps**3}, 2, x + eps * x**2, k),
    "limit that stays": to_spring({c: 1 + eps}, 1, x, k),
    "limit massless": to_spring({m: eps, c: eps}, 1, x, k),
    "limit log": to_spring({c: eps * sp.log(eps)}, 1, x, k),
    "chart abs": chart(LINE, {x: Abs(x)}),
    "chart not its inverse": chart(LINE, {x: 2 * x}, changes={"lagrangian": 4 * X**2 / 2}),
    "chart cube": chart(LINE, {x: x**3}),
    "chart forgets turns": chart(QUARTIC, {x: x}, back={x: atan2(sin(x), cos(x))}),
    "chart swapped aniso": chart(ANISOTROPIC, {x: y, y: x}),
    "chart shift": chart(SPRING, {x: 1 - x}),
    "chart inverse wrong L": chart(LINE, {x: 1 / x}, changes={"lagrangian": X**2 / (2 * x**2)}),
    "chart back wrong": chart(LINE, {x: x + 1}, back={x: x + 1}),
    "chart loses a sheet": chart(
        LINE, {x: x**2}, back={x: sqrt(x)}, changes={"lagrangian": 2 * x**2 * X**2}
    ),
    "chart wrong sheet": chart(
        LINE, {x: sqrt(x)}, back={x: x**2}, changes={"lagrangian": X**2 / (8 * x)}
    ),
    "chart sign": chart(LINE, {x: x + sign(x)}, back={x: x - sign(x)}),
    "bracket sign": bracket({q: x, p: m * X}, {(p, q): 1}, ENERGY),
    "bracket mass": bracket({q: x, p: X}, {(q, p): 1}, ENERGY),
    "bracket Hamiltonian": bracket({q: x, p: m * X}, {(q, p): 1}, p**2 / (2 * m) - k * q**2 / 2),
    "bracket jumps in H": bracket({q: x, p: m * X}, {(q, p): 1}, ENERGY + sign(q)),
    "bracket loses a sheet": bracket(
        {q: x**2, p: m * X}, {(q, p): 2 * sqrt(q)}, p**2 / (2 * m) + k * q / 2
    ),
    "bracket of sizes": bracket({q: Abs(x), p: m * X}, {(q, p): sign(x)}, ENERGY),
    "bracket of a bounce": bracket({q: Abs(x), p: m * X * sign(x)}, {(q, p): 1}, ENERGY),
    "bracket clock": bracket({q: x, p: m * X}, {(q, p): 1}, ENERGY, 2),
    "bracket clock jumps": bracket({q: x, p: m * X}, {(q, p): sign(x)}, ENERGY, sign(x)),
    "bracket no Jacobi": bracket(
        {x: x, y: y, u: X, v: Y}, {(x, u): 1, (y, v): 1, (x, y): x}, (u**2 + v**2) / 2, of=PLANE
    ),
    "bracket of too few": bracket({x: x, u: X}, {(x, u): 1}, u**2 / 2, of=PLANE),
    "quadrature sign": quadrature(2 * h + u**4 / 2),
    "quadrature constant jumps": quadrature(2 * h - u**4 / 2, constants={c: sign(x)}),
    "quadrature constant moves": quadrature(2 * h, level=X**2 / 2),
    "quadrature clock -1": quadrature(2 * h - u**4 / 2, clock=-1),
    "quadrature clock u": quadrature((2 * h - 2 * u) * u**2, of=DOWN, level=X**2 / 2 + x, clock=u),
    "quadrature rate": quadrature(
        2 * h - u**4 / 2, of=BESIDE, constants={p: Y}, integrals={y: p * u}
    ),
    "measure jump": claim(SPRING, measure=2 + sign(x)),
    "measure moves": claim(SPRING, measure=1 + x**2),
    "measure step of v": claim(PLANE, measure=3 + sign(x) * sign(y)),
    "possible wrong size": integral(LESS, (Abs(k - m) - (k - m)) * x),
    "dependent possible": integral(SAME, k * x**2 + 2 * m * X**2),
    "level": integral(SPRING, (m * X**2 + k * x**2 - 1) * x),
    "root sheet": integral(LINE, X * sqrt((x - t * X) ** 2) / (x - t)),
    "gap of phase": integral(
        SPRING,
        omega * t
        - 2 * atan(x * omega / (X + sqrt(X**2 + omega**2 * x**2)))
        + atan2(omega * x, X) * half,
    ),
    "multiplier jump": claim(TILTED, multiplier=(2 + sign(y)) / sqrt(1 + y**2)),
    "multiplier wrong": claim(TILTED, multiplier=1 / (1 + y**2)),
}

TRUE: dict[str, Any] = {
    "phase mixed": to_unit(x * cos(1) + X * sin(1), omega),
    "bracket on sheets": bracket({q: x**2, p: m * X}, {(q, p): 2 * x}, p**2 / (2 * m) + k * q / 2),
    "bracket of a line": bracket(
        {x: x, y: y, u: X, v: Y}, {(x, u): 1, (y, v): 1, (x, y): v}, (u**2 + v**2) / 2, of=PLANE
    ),
    "identity": to_unit(x, omega),
    "minus": to_unit(-x, omega),
    "negative w": to_unit(x, -omega),
    "roots apart": to_unit(x, sqrt(k) / sqrt(m)),
    "velocity as place": to_unit(X, omega),
    "double frequency": to_unit(x * X, 2 * omega),
    "double frequency, squares": to_unit(m * X**2 - k * x**2, 2 * omega),
    "phase": to_unit(x * cos(1) + X * sin(1) / omega, omega),
    "reversed": to_unit(x, omega, clock=-1),
    "reversed given": to_unit({q: x, Q: -X}, omega, clock=-1),
    "clock": to_unit(x, omega / 2, clock=2),
    "clock of an integral": to_free(x, clock=1 + X**2),
    "clock of a sign kept": to_free(x, clock=2 + sign(X)),
    "sign of a constant": to_free(x * sign(X)),
    "size of a constant": to_free(x * Abs(X)),
    "Galilei": to_free(x + 3 * t),
    "amplitude": to_unit(x / sqrt(m * X**2 + k * x**2), omega),
    "amplitude as a parameter": to_unit(x, omega * (m * X**2 + k * x**2) / (k * x**2 + X**2 * m)),
    "same ratio": relation("spring", "spring", state={x: x}, parameters={m: 2 * m, k: 2 * k}),
    "swapped": relation("isotropic", "isotropic", state={x: y, y: x}, parameters={m: m, k: k}),
    "turned": relation(
        "isotropic",
        "isotropic",
        state={x: x * cos(1) - y * sin(1), y: x * sin(1) + y * cos(1)},
        parameters={m: m, k: k},
    ),
    "radius": relation(
        "plane", "radial", state={r: sqrt(x**2 + y**2)}, parameters={j: x * Y - y * X}
    ),
    "radius of momentum of either sign": relation(
        "plane", "radial", state={r: sqrt(x**2 + y**2)}, parameters={j: Abs(x * Y - y * X)}
    ),
    "square falls": relation("line", "fall", state={q: x**2}, parameters={g: 2 * X**2}),
    "pendulum turned": relation(
        "pendulum", "other-pendulum", state={q: phi + 2 * sp.pi}, parameters={g: g}
    ),
    "pendulum upside down, -g": relation(
        "pendulum", "other-pendulum", state={q: phi + sp.pi}, parameters={g: -g}
    ),
    "sleigh mirrored": moved_sleigh(x, -y, -phi, v, -w),
    "sleigh turned": moved_sleigh(cos(1) * x - sin(1) * y, sin(1) * x + cos(1) * y, phi + 1, v, w),
    "sleigh half turn": moved_sleigh(-x, -y, phi + sp.pi, v, w),
    "sleigh swapped and mirrored": moved_sleigh(y, x, sp.pi / 2 - phi, v, -w),
    "sleigh backwards, -a": moved_sleigh(x, y, phi + sp.pi, -v, w, a=-arm),
    "limit": to_spring({c: eps}, 1, x, k),
    "limit square": to_spring({c: eps**2}, 2, x, k),
    "limit below its order": to_spring({c: sin(eps) ** 3}, 2, x, k),
    "limit near the identity": to_spring({c: eps**3}, 1, x + eps * x**2, k),
    "chart inverse": chart(LINE, {x: 1 / x}, changes={"lagrangian": X**2 / (2 * x**4)}),
    "chart mirrored": chart(SPRING, {x: -x}),
    "chart swapped": chart(ISOTROPIC, {x: y, y: x}),
    "chart shifted": chart(LINE, {x: x + 1}, back={x: x - 1}),
    "bracket": bracket({q: x, p: m * X}, {(q, p): 1}, ENERGY),
    "bracket with mass inside": bracket({q: x, p: X}, {(q, p): 1 / m}, m * p**2 / 2 + k * q**2 / 2),
    "bracket of cubes": bracket(
        {q: x**3, p: m * X}, {(q, p): 3 * x**2}, p**2 / (2 * m) + k * x**2 / 2
    ),
    "bracket with a clock": bracket({q: x, p: m * X}, {(q, p): half}, ENERGY, 2),
    "bracket, H squared": bracket({q: x, p: m * X}, {(q, p): 1 / (p**2 / m + k * q**2)}, ENERGY**2),
    "quadrature": quadrature(2 * h - u**4 / 2),
    "quadrature with a rate": quadrature(
        2 * h - u**4 / 2, of=BESIDE, constants={p: Y}, integrals={y: p}
    ),
    "measure of an integral": claim(SPRING, measure=Abs(m * X**2 + k * x**2) + 1),
    "measure of a kink": claim(SPRING, measure=2 + Abs(m * X**2 + k * x**2 - 1)),
    "possible size": integral(LESS, (Abs(k - m) - (m - k)) * x + m * X**2 + k * x**2),
    "dependent possible": integral(SAME, x**2 + X**2),
    "multiplier": claim(TILTED, multiplier=1 / sqrt(1 + y**2)),
    "half phase": integral(
        SPRING, omega * t - 2 * atan(x * omega / (X + sqrt(X**2 + omega**2 * x**2)))
    ),
}


def statuses(kind, stated):
    """What is said of each part of a claim."""
    if kind == "relation":
        return {vo.check_relation(stated, systems=SYSTEMS).verdict.status}
    check = {"chart": check_charts, "motion": check_motion}.get(kind)
    found = check_claims(stated) if check is None else check(Motions.of(stated))
    return {claim.verdict.status for claim in found}


OPEN = {
    "bounce given", "square falls abs", "limit order root", "limit log", "bracket of sizes",
    "bracket of a bounce", "bracket clock jumps", "chart sign",
}  # fmt: skip
"""False, and left undecided."""


@pytest.mark.parametrize("name", FALSE)
def test_what_is_false_is_refuted(name):
    found = statuses(*FALSE[name])
    assert found - {"proved"} and ("refuted" in found or name in OPEN)


@pytest.mark.parametrize("name", TRUE)
def test_what_is_true_is_proved(name):
    assert statuses(*TRUE[name]) == {"proved"}


@pytest.mark.parametrize("variable", [Abs(x), sqrt(x**2), x**2])
def test_a_variable_that_loses_the_sign_of_a_coordinate_is_refused(variable):
    with pytest.raises(vo.DefinitionError, match="no value to the coordinate 'x'"):
        quadrature(2 * h - u**4 / 2, variable=variable)


def test_what_jumps_where_coordinates_are_singular_is_proved_beside_that_place_only():
    """A skate turns through phi = pi/2, where y is not determined by x; motions go on beyond it."""
    blade = (X * sin(phi) - Y * cos(phi),)
    kinetic = (X**2 + Y**2 + P**2) / 2
    skate = system("skate", (x, phi), kinetic, fibre=(y,), constraints=blade)
    speed = sqrt(X**2 + Y**2)
    for function in (sign(cos(phi)), P * sign(cos(phi)), Abs(X) / cos(phi), speed * sign(cos(phi))):
        (found,) = check_claims(replace(skate, integrals={"F": function}))
        assert found.verdict.proved and "cos(phi/2) != 0" in found.standing
    for function in (P, X / cos(phi), speed):
        (found,) = check_claims(replace(skate, integrals={"F": function}))
        assert found.standing == "proved"


def test_coordinates_whose_velocities_become_infinite_bound_what_has_branches():
    """With x = z^3 motions pass z = 0; there z |z| zdot, continuous in z and zdot, jumps."""
    cube = system("cube", (z,), 9 * z**4 * Z**2 / 2, integrals={"F": z * Abs(z) * Z})
    (found,) = check_claims(cube)
    assert found.standing == "proved where z != 0"


@pytest.mark.parametrize(
    ("potential", "function", "words"),
    [
        (x**k, X**2 / 2 + (x**2) ** (k / 2), " where x > 0"),  # at k = 3 where x > 0 alone
        (x**k, X**2 / 2 + x**k, " where x > 0"),
        ((1 + x**2) ** k, X**2 / 2 + (1 + x**2) ** k, ""),
        (x**n, X**2 / 2 + x**n, ""),
    ],
)
def test_what_counts_as_positive_under_letters_is_said(potential, function, words):
    powers = system("powers", (x,), X**2 / 2 - potential, (k, n), integrals={"F": function})
    (found,) = check_claims(powers)
    assert found.standing == f"proved{words}"


def test_what_counts_as_positive_in_the_field_alone_is_said():
    forces = {x: x**k, q: (x**2) ** (k / 2)}
    free = (X**2 + Q**2) / 2
    pair = system("pair", (x, q), free, (k,), forces=forces, integrals={"F": X - Q})
    assert check_claims(pair)[0].standing == "proved where x > 0"
