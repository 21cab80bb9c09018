"""Programs out: every language computes what the derivation says, with its Jacobian."""

from __future__ import annotations

import ctypes
import json
import shutil
import subprocess
from collections.abc import Callable, Mapping
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
import symengine as se
import sympy as sp

import voronec as vo
from voronec.equations.derivation import FirstOrderForm
from voronec.equations.program import (
    Program,
    c_source,
    casadi_source,
    compile_program,
    javascript_source,
    jax_source,
    mpmath_source,
    python_source,
    shorten_program,
)
from voronec.equations.program.straight import Block
from voronec.errors import EngineLimit

pytestmark = pytest.mark.slow

Call = Callable[[str, list[list[float]]], np.ndarray]
"""Of the name of a function and its arguments after the time 0.2; ``numpy`` shapes come back."""

x, y, u, w, a, b, t = se.symbols("x y u w a b t")
TIME = 0.2


def forms() -> dict[str, FirstOrderForm]:
    """Programs with every function there is, quotients near zero and at zero among them."""
    smooth = (
        se.tan(x) * u - a * se.atan2(y, 2 + x**2) + se.cot(2 + t) + se.asinh(w) ** 3,
        (2 + x**2) ** se.Rational(2, 3) * se.exp(-y) - se.tanh(w * y) + se.log(3 + x**2) ** b,
    )
    cardinal = (
        se.sin(x) / x + se.tan(y) / y - se.sin(u) ** 2 / u**2 + se.sqrt(x**2 + y**2 + a**2),
        se.log(1 + w**2) * b + (1 - se.cos(x)) / x + se.Abs(y + 1) * w - se.acos(x / 3),
    )
    mass = ((2 + se.cos(x), b * se.sin(y) / 4), (b * se.sin(y) / 4, 3 + y**2))
    made = {"smooth": (mass, smooth), "cardinal": (((1, 0), (0, a)), cardinal)}
    return {
        name: FirstOrderForm(
            coordinates=(x, y), velocities=(u, w), parameters=(a, b), time=t, rates=(u + w, w * x),
            mass=tuple(map(tuple, matrix)), force=force, definitions=(),
            velocity_symbols=(se.Symbol("xdot"), se.Symbol("ydot")),
        )
        for name, (matrix, force) in made.items()
    }  # fmt: skip


def systems() -> dict[str, Program]:
    names = "snakeboard", "falling-disc", "rattleback", "robot-with-two-trailers"
    programs = {name: shorten_program(Program.of(vo.derive(vo.load(name)).form)) for name in names}
    return programs | {"driven": Program.of(vo.derive(driven()).form)}


def driven() -> vo.System:
    """A sleigh that is pushed and turned, and on a plane that is moved."""
    px, py, phi, push, turn, m, inertia, reach = sp.symbols("x y phi push turn m J reach")
    v, omega = sp.symbols("v omega")
    dx, dy, dphi = map(vo.velocity, (px, py, phi))
    return vo.System(
        name="driven-sleigh",
        fibration=vo.Fibration(base=(px, phi), fibre=(py,)),
        frame=vo.Frame.quasi({v: dx * sp.cos(phi) + dy * sp.sin(phi), omega: dphi}),
        lagrangian=m * (dx**2 + dy**2) / 2 + inertia * dphi**2 / 2
        + m * reach * dphi * (dy * sp.cos(phi) - dx * sp.sin(phi)),
        constraints=(dx * sp.sin(phi) - dy * sp.cos(phi) + turn,),
        forces={px: push, phi: turn * push},
        parameters=(m, inertia, reach),
        inputs=(push, turn),
    )  # fmt: skip


def test_inputs_that_nothing_holds_are_arguments() -> None:
    used, idle = sp.symbols("used idle")
    cart = vo.System(
        name="cart", fibration=vo.Fibration(sp.Symbol("x")), forces={sp.Symbol("x"): used},
        lagrangian=vo.velocity(sp.Symbol("x")) ** 2 / 2, inputs=(idle, used),
    )  # fmt: skip
    eqs = vo.derive(cart)
    space: dict[str, Any] = {}
    exec(eqs.python(jacobian=True), space)
    assert space["rhs"](0, [1, 2], [], [5, 3]) == [2, 3]
    assert space["jacobian"](0, [1, 2], [], [5, 3])[1] == [0, 0, 0, 1]
    for source in (eqs.c, eqs.javascript):
        assert "jacobian" in source(jacobian=True) and "jacobian" not in source()
    assert "inputs[0]: idle" in eqs.c() and '"inputs": ["idle", "used"]' in eqs.javascript()
    assert sp.Matrix([[0, 0], [0, 1]]) == vo.linearise(eqs).B


def sized(program: Program) -> list[list[float]]:
    """A state, parameters and inputs."""
    rng = np.random.default_rng(5)
    groups = [program.state, program.parameters] + ([program.inputs] if program.inputs else [])
    return [list(0.3 + rng.random(len(group))) for group in groups]


def truth(program: Program, given: list[list[float]]) -> tuple[np.ndarray, np.ndarray]:
    """Rates, and their slopes by quotients of differences, all in 60 digits."""
    space: dict[str, Any] = {}
    exec(mpmath_source(program), space)
    with mpmath.workdps(60):
        exact = [[mpmath.mpf(e) for e in group] for group in given]
        rates = space["rhs"](mpmath.mpf(TIME), *exact)
        step, columns = mpmath.mpf(10) ** -20, []
        for k, group in enumerate(exact):
            for i in range(len(group)) if k != 1 else ():
                sides = []
                for sign in (1, -1):
                    moved = [[*g] for g in exact]
                    moved[k][i] += sign * step
                    sides.append(space["rhs"](mpmath.mpf(TIME), *moved))
                pairs = zip(*sides, strict=True)
                columns.append([float((p - m) / (2 * step)) for p, m in pairs])
    return np.array([float(r) for r in rates]), np.array(columns).T


def numpy_call(program: Program, folder: Path) -> Call:
    space: dict[str, Any] = {}
    exec(python_source(program, slopes=True), space)
    return lambda name, given: np.array(space[name](TIME, *given), dtype=float)


def c_call(program: Program, folder: Path) -> Call:
    if shutil.which("cc") is None:
        pytest.skip("no C compiler")
    (folder / "rhs.c").write_text(c_source(program, slopes=True))
    flags = ["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", "-shared", "-fPIC"]
    command = ["cc", *flags, str(folder / "rhs.c"), "-o", str(folder / "rhs.so"), "-lm"]
    subprocess.run(command, check=True)
    library = ctypes.CDLL(str(folder / "rhs.so"))
    rows, columns = len(program.state), len(program.state) + len(program.inputs)

    def call(name: str, given: list[list[float]]) -> np.ndarray:
        shape = (rows, columns) if name == "jacobian" else (rows,)
        result = (ctypes.c_double * int(np.prod(shape)))()
        arrays = [(ctypes.c_double * max(1, len(g)))(*g) for g in given]
        getattr(library, name)(ctypes.c_double(TIME), *arrays, result)
        return np.array(result).reshape(shape)

    return call


def javascript_call(program: Program, folder: Path) -> Call:
    node = shutil.which("node")
    if node is None:
        pytest.skip("no Node.js")
    (folder / "rhs.mjs").write_text(javascript_source(program, slopes=True))

    @cache
    def both(arguments: str) -> Any:
        (folder / "main.mjs").write_text(
            'import * as program from "./rhs.mjs";\n'
            'const found = ["rhs", "jacobian"].map((name) => '
            f"[name, program[name]({TIME}, {arguments})]);\n"
            "console.log(JSON.stringify(Object.fromEntries(found)));\n"
        )
        command = [node, str(folder / "main.mjs")]
        done = subprocess.run(command, check=True, capture_output=True, text=True)
        return json.loads(done.stdout)

    def call(name: str, given: list[list[float]]) -> np.ndarray:
        return np.array(both(", ".join(map(json.dumps, given)))[name], dtype=float)

    return call


def casadi_call(program: Program, folder: Path) -> Call:
    casadi = pytest.importorskip("casadi", reason="CasADi is not installed")
    space: dict[str, Any] = {}
    exec(casadi_source(program, slopes=True), space)

    def call(name: str, given: list[list[float]]) -> np.ndarray:
        symbols = [casadi.SX.sym("g", len(group)) for group in given]
        made = casadi.Function(name, symbols, [casadi.SX(space[name](TIME, *symbols))])
        found = np.array(made(*given))
        return found[:, 0] if name == "rhs" else found

    return call


def jax_call(program: Program, folder: Path) -> Call:
    """Compiled by JAX, and the Jacobian taken by JAX itself in forward mode as well."""
    jax = pytest.importorskip("jax", reason="JAX is not installed")
    space: dict[str, Any] = {}
    exec(jax_source(program, slopes=True), space)

    @cache
    def compiled(count: int) -> Callable[..., Any]:
        """Everything at once: to compile is what takes long."""
        groups = tuple(k for k in range(1, count + 1) if k != 2)
        slopes = jax.jacfwd(space["rhs"], argnums=groups)
        return jax.jit(lambda *at: (space["rhs"](*at), space["jacobian"](*at), slopes(*at)))

    def call(name: str, given: list[list[float]]) -> np.ndarray:
        arrays = [jax.numpy.array(group) for group in given]
        rates, found, theirs = compiled(len(arrays))(TIME, *arrays)
        if name == "rhs":
            return np.array(rates)
        told = np.isfinite(found := np.array(found))
        assert_close(np.hstack([np.array(each) for each in theirs])[told], found[told])
        return found

    return call


CALLS: Mapping[str, Callable[[Program, Path], Call]] = {
    "numpy": numpy_call, "c": c_call, "javascript": javascript_call, "casadi": casadi_call,
    "jax": jax_call,
}  # fmt: skip


def assert_close(found: np.ndarray, expected: np.ndarray) -> None:
    assert found.shape == expected.shape
    scale = 1 + np.abs(expected).max()
    assert np.abs(found - expected).max() < 1e-13 * scale


@pytest.mark.parametrize("language", CALLS)
def test_programs_of_every_language_agree_with_many_digits(language: str, tmp_path: Path) -> None:
    made = {name: Program.of(form) for name, form in forms().items()}
    catalogue = systems()
    if language == "jax":  # compiles each of the others for seconds
        catalogue = {"driven": catalogue["driven"]}
    for name, program in (made | catalogue).items():
        given = sized(program)
        rates, slopes = truth(program, given)
        folder = tmp_path / name
        folder.mkdir()
        call = CALLS[language](program, folder)
        assert_close(call("rhs", given), rates)
        assert_close(call("jacobian", given), slopes)


@pytest.mark.parametrize("language", CALLS)
def test_quotients_and_their_slopes_have_values_where_they_divide_by_zero(
    language: str, tmp_path: Path
) -> None:
    """sin(x)/x and the like at zero, and their slopes; from series, which share nothing."""
    program = Program.of(forms()["cardinal"])
    given = [[0.0, 0.0, 0.0, 0.0], [1.0, 0.5]]
    call = CALLS[language](program, tmp_path)
    assert_close(call("rhs", given), np.array([0, 0, 2, -np.pi / 2]))
    slopes = np.zeros((4, 4))
    slopes[0, 2] = slopes[0, 3] = 1  # of u + w
    slopes[3, 0] = 1 / 2 + 1 / 3  # of (1 - cos x)/x and acos(x/3)
    slopes[3, 3] = 1  # of |y + 1| w
    assert_close(call("jacobian", given), slopes)


def beside(expr: sp.Expr, wall: sp.Expr, value: sp.Expr) -> sp.Expr:
    """An expression, but for the places where another vanishes."""
    return sp.Piecewise((expr, sp.Ne(wall, 0)), (value, True))


def versed(w: sp.Expr) -> sp.Expr:
    return beside((1 - sp.cos(w)) / w**2, w, sp.Rational(1, 2))


CASES = (  # force, place, its value there, its slope
    (lambda q: sp.Min(1, sp.exp(q)), 40.0, 1.0, 0.0),
    (lambda q: sp.Min(1, sp.exp(q)), -1.0, np.exp(-1), np.exp(-1)),
    (lambda q: sp.Max(1, -sp.exp(q)), 40.0, 1.0, 0.0),
    (lambda q: sp.Max(-1, sp.Min(1, 10**9 * q)), 1e9, 1.0, 0.0),
    (lambda q: sp.Max(-1, sp.Min(1, 10**9 * q)), -2e-10, -0.2, 1e9),
    (lambda q: -3 * sp.Min(1, 10**18 * q**2, q + 5), 2.0, -3.0, 0.0),
    (lambda q: sp.Min(1, 1 / q**2), 1e-9, 1.0, 0.0),
    (lambda q: sp.Piecewise((1, q <= 0), (sp.exp(-1 / q), True)), -1e-3, 1.0, np.nan),
    (lambda q: sp.Piecewise((1, q > 0), (sp.exp(q), True)), 800.0, 1.0, np.nan),
    (lambda q: sp.Piecewise((2, q < 0), (sp.exp(q), True)), -40.0, 2.0, 0.0),
    (lambda q: sp.Piecewise((2, q < 0), (3, q < 1), (q**3, True)), -1e9, 2.0, 0.0),
    (lambda q: sp.Piecewise((2, q < 0), (3, q < 1), (q**3, True)), 2.0, 8.0, 12.0),
    (lambda q: sp.Min(3, q**5 / (1 + q**2)), 1e20, 3.0, 0.0),
    (lambda q: sp.sin(sp.Max(-1, sp.Min(1, 10**9 * q))), 1e17, np.sin(1), 0.0),
    (lambda q: sp.exp(q**2) * sp.Heaviside(sp.sin(q)), 15.0, np.exp(225), np.nan),
    (lambda q: sp.exp(q**2) * sp.Heaviside(-q), 1.5e3, 0.0, np.nan),
    (lambda q: sp.sign(q) - 2 * sp.Abs(q) + sp.Heaviside(q - 3), 2.0, -3.0, -2.0),
    (lambda q: sp.Heaviside(q - 3) + sp.Max(q, 3), 3.0, 3.5, 0.5),
    (lambda q: sp.Min(1, 1 / q**2), 0.0, 1.0, 0.0),
    (lambda q: 1 / (1 + q**2), 1e200, 0.0, 0.0),
    (lambda q: beside(sp.sin(q) / q, q, 1), 0.0, 1.0, 0.0),
    (lambda q: versed(q), 0.0, 0.5, 0.0),
    (lambda q: versed(q + 1), -0.99999, 0.5 - 1e-10 / 24, np.nan),
    (lambda q: beside(sp.tanh(q) / q, q, 1), 0.0, 1.0, np.nan),
    (lambda q: beside(q * sp.sin(1 / q), q, 0), 0.0, 0.0, np.nan),
    (lambda q: beside(sp.sin(q) / q, q, 1) + 1 / (q - 1), 0.0, 0.0, -1.0),
    (lambda q: beside(sp.sin(q), q - 1, 5), 1.0, 5.0, np.nan),
    (lambda q: sp.Piecewise((sp.exp(-1 / q), q > 0), (0, True)), 0.0, 0.0, 0.0),
    (lambda q: sp.Piecewise((1, q <= 0), (2, True)), 0.0, 1.0, np.nan),
    (lambda q: sp.Piecewise((1, q < 0), (2, q < 1), (q, q > 1), (7, True)), 1.0, 7.0, np.nan),
    (lambda q: sp.exp(q) * sp.Heaviside(q, 1) / (1 + q**2), 0.0, 1.0, np.nan),
    (lambda q: sp.Piecewise((sp.sqrt(sp.Abs(q)), q > 0), (q, True)), 0.0, 0.0, 1.0),
    (lambda q: sp.Piecewise((sp.sqrt(q), q > 0), (q, True)), -2.0, -2.0, 1.0),
    (lambda q: sp.sqrt(sp.Max(0, q)), -2.0, 0.0, 0.0),
    (lambda q: sp.asin(sp.Min(1, sp.sqrt(sp.Abs(q)))), 2.0, np.pi / 2, 0.0),
    (lambda q: 10**36 * sp.Max(-1, sp.Min(1, 1 / ((q**2 - 1) ** 2 + 1))), 1e9, 1.0, -4e-9),
    (lambda q: sp.sqrt(sp.Abs(q**2)) * sp.sign(q), -3.0, -3.0, 1.0),
    (lambda q: sp.sin(q) * sp.Heaviside(q**2), 0.0, 0.0, 1.0),
    (lambda q: sp.log(1 + q) / q, 0.125, 8 * np.log(1.125), 64 / 9 - 64 * np.log(1.125)),
    (lambda q: sp.atan(q) / q, 2.0, np.arctan(2) / 2, 0.1 - np.arctan(2) / 4),
)


@pytest.mark.parametrize("language", CALLS)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_only_the_side_that_is_in_force_is_looked_at(language: str, tmp_path: Path) -> None:
    """1 is lost in exp(40) + 1, and 0 times an infinite case, or slope, is no number."""
    places = sp.symbols(f"q:{len(CASES)}")
    forces, at, values, slopes = zip(*CASES, strict=True)
    system = vo.System(
        name="k", fibration=vo.Fibration(places),
        lagrangian=sum(vo.velocity(q) ** 2 for q in places) / 2,
        forces={q: force(q) for q, force in zip(places, forces, strict=True)},
    )  # fmt: skip
    call = CALLS[language](vo.derive(system).program, tmp_path)
    state, n = [[*at, *np.zeros(len(at))], []], len(at)
    assert call("rhs", state).ravel()[n:] == pytest.approx(values, rel=1e-14)
    found = np.diag(call("jacobian", state).reshape(2 * n, 2 * n)[n:, :n])
    told = ~np.isnan(slopes)
    assert found[told] == pytest.approx(np.array(slopes)[told], rel=1e-14)


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_cases_that_are_not_in_force_warn_of_nothing() -> None:
    q = sp.Symbol("q")
    force = sp.Piecewise((sp.log(q), q > 1), (-q, True))
    eqs = vo.derive(vo.System("k", vo.Fibration(q), vo.velocity(q) ** 2 / 2, forces={q: force}))
    space: dict[str, Any] = {}
    exec(eqs.python(), space)
    state = [np.array([-1.0, 0.0, 2.0]), np.ones(3)]
    for rhs in (space["rhs"], compile_program(eqs.program)[0]):
        assert np.allclose(rhs(0.0, state, [])[1], [1.0, 0.0, np.log(2)])


def test_a_quasi_velocity_at_a_wall_is_itself_where_its_base_velocity_vanishes() -> None:
    """v = xdot c + ydot s, in which the rates hold push c/s: at s = 0 this is no number."""
    px, py, c, s, v, omega, push = sp.symbols("x y c s v omega push")
    dx, dy, dc, ds = map(vo.velocity, (px, py, c, s))
    sledge = vo.System(
        name="sledge",
        fibration=vo.Fibration((px, c), (py, s), relations=(c**2 + s**2 - 1,)),
        frame=vo.Frame.quasi({v: dx * c + dy * s + c, omega: c * ds - s * dc}),
        lagrangian=(dx**2 + dy**2 + dc**2 + ds**2) / 2,
        constraints=(dx * s - dy * c - push,),
        forces={v: push * sp.sin(vo.time) - v * sp.Abs(v)},
        inputs=(push,),
    )
    eqs = vo.derive(sledge)
    assert eqs.force[0].has(sp.sqrt(v**2))
    space: dict[str, Any] = {}
    exec(eqs.python(), space)
    for place in (1e-15, 0.0):
        found = space["rhs"](0.0, [0, 1.0, 0, place, 3.0, 0.0], [], [0.5])
        assert found[4] == pytest.approx(-9.0, rel=1e-14)


def test_names_whose_users_cancel_are_not_printed() -> None:
    """An unused constant is a warning of compilers of C; here k3 is v."""
    c, s, v, push, *k = se.symbols("c s v push k0:4")
    lines = (
        (k[0], c / s), (k[1], -y - k[0] * push), (k[2], 1 / (s + c * k[0])),
        (k[3], y + k[0] * (push + c * k[2] * (v + k[1])) + s * k[2] * (k[1] + v)),
    )  # fmt: skip
    program = Program(
        time=t, coordinates=(c, s), velocities=(v,), parameters=(y, push), names=(),
        derivative=Block(lines, (v, v, k[3] ** 2)), extras=Block((), ()),
    )  # fmt: skip
    assert shorten_program(program).derivative == Block((), (v, v, v**2))


@pytest.mark.parametrize("language", CALLS)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_wall_without_a_value_leaves_none(language: str, tmp_path: Path) -> None:
    """What is no number is neither above nor below a wall, but not on it either."""
    q = sp.Symbol("q")
    dq, wall = vo.velocity(q), sp.log(q)
    forces = wall * sp.Abs(wall), sp.sign(wall), sp.Piecewise((1, wall > 0), (2, True))
    for number, force in enumerate(forces):
        system = vo.System(
            name="k", fibration=vo.Fibration(q), lagrangian=dq**2 / 2, forces={q: force}
        )
        folder = tmp_path / str(number)
        folder.mkdir()
        call = CALLS[language](vo.derive(system).program, folder)
        assert np.isnan(call("rhs", [[-2.0, 0.0], []]).ravel()[1])


@pytest.mark.parametrize("language", ["numpy", "c", "javascript"])
def test_an_angle_on_its_cut_is_one_half_turn(language: str, tmp_path: Path) -> None:
    """-q is the negative zero of doubles at q = 0, and so is the product of 0 and -1."""
    q = sp.Symbol("q")
    dq = vo.velocity(q)
    for number, force in enumerate((sp.atan2(-q, -1), sp.atan2(q * sp.cos(q + 3), q - 1))):
        system = vo.System(
            name="k", fibration=vo.Fibration(q), lagrangian=dq**2 / 2, forces={q: force}
        )
        folder = tmp_path / str(number)
        folder.mkdir()
        call = CALLS[language](vo.derive(system).program, folder)
        assert call("rhs", [[0.0, 0.0], []]).ravel()[1] == pytest.approx(np.pi)


def test_a_slope_along_a_wall_is_that_of_the_value_there() -> None:
    x, y = sp.symbols("x y")
    dx, dy = map(vo.velocity, (x, y))
    force = sp.Piecewise((sp.exp(y), sp.Eq(x, 1)), (sp.sin(y) + x, True))
    system = vo.System(
        name="k", fibration=vo.Fibration((x, y)), lagrangian=(dx**2 + dy**2) / 2, forces={x: force}
    )
    space: dict[str, Any] = {}
    exec(vo.derive(system).python(jacobian=True), space)
    assert space["jacobian"](0, [1, 0.5, 0, 0], [])[2][1] == pytest.approx(np.exp(0.5))
    assert space["jacobian"](0, [2, 0.5, 0, 0], [])[2][1] == pytest.approx(np.cos(0.5))


def test_a_parameter_before_what_is_cut_off_hides_no_side() -> None:
    q, k = sp.symbols("q k")
    dq = vo.velocity(q)
    system = vo.System(
        name="k", fibration=vo.Fibration(q), lagrangian=dq**2 / 2,
        forces={q: sp.sqrt(sp.Max(0, k * q))}, parameters=(vo.Parameter(k),),
    )  # fmt: skip
    space: dict[str, Any] = {}
    exec(vo.derive(system).python(jacobian=True), space)
    with np.errstate(invalid="ignore"):
        for place, size in ((-2, 0.5), (2, -0.5)):
            assert space["rhs"](0, [place, 0], [size])[1] == 0
            assert space["jacobian"](0, [place, 0], [size])[1][0] == 0
    assert space["jacobian"](0, [2, 0], [0.5])[1][0] == pytest.approx(0.25)


def test_friction_is_printed_as_it_was() -> None:
    q = sp.Symbol("q")
    dq = vo.velocity(q)
    force = -3 * sp.sign(dq) - dq * sp.Abs(dq) - q
    system = vo.System(name="k", fibration=vo.Fibration(q), lagrangian=dq**2 / 2, forces={q: force})
    assert "choice" not in vo.derive(system).python()


def test_programs_agree_with_the_derivation_in_balls() -> None:
    """Another form of the equations, another evaluation: `acceleration` knows no program."""
    system = vo.load("snakeboard")
    eqs = vo.derive(system)
    program = Program.of(eqs.form)
    state, parameters = sized(program)
    space: dict[str, Any] = {}
    exec(eqs.python(), space)
    found = space["rhs"](0.0, state, parameters)
    point = dict(zip((*eqs.coordinates, *eqs.velocities), state, strict=True))
    point |= dict(zip((p.symbol for p in system.parameters), parameters, strict=True))
    at = {**point, vo.time: 0}
    slopes = eqs.acceleration(at)
    for q, rate in zip(eqs.coordinates, eqs.rates, strict=True):
        # d2q/dt2 by the chain rule along the program
        dots = dict(zip((*eqs.coordinates, *eqs.velocities), found, strict=True))
        along = sum(rate.diff(s) * dot for s, dot in dots.items()).subs(point)
        assert abs(float(along) - float(slopes[q])) < 1e-12


def test_numpy_programs_take_arrays_of_states() -> None:
    program = systems()["driven"]
    space: dict[str, Any] = {}
    exec(python_source(program, slopes=True), space)
    state, parameters, inputs = sized(program)
    states = np.array(state)[:, None] * np.linspace(0.5, 1, 7)
    found = np.array(space["jacobian"](TIME, list(states), parameters, inputs))
    assert found.shape == (len(state), len(state) + len(inputs), 7)
    assert np.allclose(found[..., -1], space["jacobian"](TIME, state, parameters, inputs))


def test_a_function_for_casadi_is_differentiated_by_casadi_as_by_us() -> None:
    casadi = pytest.importorskip("casadi", reason="CasADi is not installed")
    eqs = vo.derive(driven())
    function = eqs.to_casadi()
    program = Program.of(eqs.form)
    given = sized(program)
    assert function.name_in() == ["t", "state", "parameters", "inputs"]
    assert_close(np.array(function(TIME, *given))[:, 0], truth(program, given)[0])
    symbols = [casadi.MX.sym("g", len(g)) for g in given]
    by_state = casadi.jacobian(function(TIME, *symbols), symbols[0])
    ours: dict[str, Any] = {}
    exec(eqs.casadi(jacobian=True), ours)
    theirs = np.array(casadi.Function("j", symbols, [by_state])(*given))
    mine = np.array(ours["jacobian"](TIME, *map(casadi.DM, given)))
    assert_close(mine[:, : len(given[0])], theirs)
    still = vo.derive(vo.load("sleigh")).to_casadi()  # without inputs their column is empty
    assert still.size_in("inputs") == (0, 1) or still.size_in("inputs") == (0, 0)


def test_jax_maps_compiles_and_differentiates_in_doubles() -> None:
    jax = pytest.importorskip("jax", reason="JAX is not installed")
    eqs = vo.derive(driven())
    space: dict[str, Any] = {}
    exec(eqs.jax(), space)
    program = Program.of(eqs.form)
    state, *rest = map(np.array, sized(program))
    many = np.outer(np.linspace(0.5, 1, 5), state)
    mapped = jax.jit(jax.vmap(space["rhs"], in_axes=(None, 0, None, None)))(TIME, many, *rest)
    assert mapped.dtype == np.float64 and mapped.shape == many.shape
    for row, each in zip(mapped, many, strict=True):
        assert_close(np.array(row), truth(program, [each, *rest])[0])
    slope = jax.grad(lambda x: space["rhs"](TIME, x, *rest)[-1])(state)
    assert_close(np.array(slope), truth(program, [state, *rest])[1][-1, : len(state)])


def test_without_casadi_a_line_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "casadi", None)
    with pytest.raises(vo.DefinitionError, match=r"pip install 'voronec\[control\]'"):
        vo.derive(vo.load("sleigh")).to_casadi()


def test_a_jacobian_that_nobody_differentiates_is_refused() -> None:
    form = forms()["cardinal"]
    unknown = ((se.sin(x) / x).diff(x), se.Integer(0))
    program = Program.of(FirstOrderForm(**{**vars(form), "force": unknown}))
    with pytest.raises(EngineLimit, match="is not differentiated"):
        python_source(program, slopes=True)


def test_the_command_prints_every_language(capsys: pytest.CaptureFixture[str]) -> None:
    from voronec.cli import main

    for language in ("--python", "--c", "--javascript", "--casadi", "--jax"):
        assert main(["derive", "sleigh", language]) == 0
        plain = capsys.readouterr().out
        assert main(["derive", "sleigh", language, "--jacobian"]) == 0
        assert "jacobian" in capsys.readouterr().out and "jacobian" not in plain
    for line in (["derive", "sleigh", "--jacobian"], ["derive", "sleigh", "--latex", "--jacobian"]):
        assert main(line) == 2
        assert "add one of --python" in capsys.readouterr().err
    assert find_spec("casadi") is None or "vertcat" in vo.derive(vo.load("sleigh")).casadi()
