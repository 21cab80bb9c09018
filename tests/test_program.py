"""The straight-line program: what is eliminated, and that every emitter computes the same."""

from __future__ import annotations

import ctypes
import math
import shutil
import subprocess
import traceback
from importlib.util import find_spec
from typing import Any

import mpmath
import numpy as np
import pytest
import symengine as se
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

import voronec as vo
from voronec.algebra.stable import stable_all
from voronec.algebra.stages import factor_sums
from voronec.equations.derivation import FirstOrderForm
from voronec.equations.program import (
    Program,
    c_source,
    compile_program,
    mpmath_source,
    python_source,
    taylor_system,
)
from voronec.equations.program.optimisation import shorten_program
from voronec.equations.program.straight import Block
from voronec.errors import DefinitionError, EngineLimit

pytestmark = pytest.mark.slow

x, y, z, u, v, w, a, b, t = se.symbols("x y z u v w a b t")


def first_order(mass: Any, force: Any, rates: Any = (u, v, w), parameters: Any = (a, b)) -> Any:
    """A first-order form in x, y, z with velocities u, v, w."""
    n = len(force)
    dots = [se.Symbol(f"{q}dot") for q in (x, y, z)]
    return FirstOrderForm(
        coordinates=(x, y, z)[:n], velocities=(u, v, w)[:n], parameters=tuple(parameters), time=t,
        rates=tuple(map(se.sympify, rates[:n])), mass=tuple(map(tuple, mass)),
        force=tuple(map(se.sympify, force)), velocity_symbols=tuple(dots[:n]),
        definitions=(),
    )  # fmt: skip


def coupled() -> Any:
    """A full mass matrix with every kind of function in it."""
    mass = [
        [3 + se.cos(x) ** 2, se.sin(x * y) / 5, b / 7],
        [se.sin(x * y) / 5, 2 + se.exp(-(y**2)), se.atan2(y, 2) / 3],
        [b / 7, se.atan2(y, 2) / 3, 4 + se.sqrt(1 + z**2)],
    ]
    force = [
        se.Rational(1, 3) * u * v - a * se.tan(x) + se.cot(2 + t),
        se.Abs(v) * se.log(3 + z**2) + se.sinh(x) / se.cosh(y) + se.pi * w**5,
        (2 + x**2) ** se.Rational(2, 3) + (2 + y**2) ** se.Rational(-3, 2) - se.tanh(w) * se.E,
    ]
    return first_order(mass, force)


STATE = [0.3, -0.7, 1.1, 0.4, -0.9, 0.6]
VALUES = [1.25, 0.8]


def direct(form: Any, state: list[float], values: list[float], time: float) -> np.ndarray:
    """The derivative by substitution and numpy's solver."""
    at = dict(zip((*form.coordinates, *form.velocities), state, strict=True))
    at |= dict(zip(form.parameters, values, strict=True)) | {t: time}

    def number(e: Any) -> float:
        return float(se.sympify(e).subs(at).n(53, real=True))

    mass = np.array([[number(e) for e in row] for row in form.mass])
    vdot = np.linalg.solve(mass, [number(f) for f in form.force])
    return np.concatenate([[number(r) for r in form.rates], vdot])


def c_function(source: str, folder: Any, size: int) -> Any:
    """The compiled function ``rhs`` of C source, warnings being errors."""
    path = folder / "program.c"
    path.write_text(source)
    flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-O1", "-shared", "-fPIC"]
    library = folder / "program.so"
    subprocess.run(["cc", *flags, str(path), "-o", str(library), "-lm"], check=True)
    function = ctypes.CDLL(str(library)).rhs
    vector = ctypes.POINTER(ctypes.c_double)
    function.argtypes = [ctypes.c_double, vector, vector, vector]
    function.restype = None

    def call(time: float, state: list[float], values: list[float]) -> list[float]:
        result = (ctypes.c_double * size)()
        given = [(ctypes.c_double * max(1, len(s)))(*s) for s in (state, values)]
        function(time, *given, result)
        return list(result)

    return call


def test_python_source_agrees_with_substitution_on_floats_and_arrays() -> None:
    form = coupled()
    program = Program.of(form)
    expected = direct(form, STATE, VALUES, 0.2)
    for scalar in (False, True):
        rhs, _ = compile_program(program, scalar=scalar)
        assert np.allclose(rhs(0.2, STATE, VALUES), expected, rtol=1e-13, atol=0)
    rhs, _ = compile_program(program)
    states = np.array(STATE)[:, None] * np.linspace(0.5, 1, 7)
    rows = rhs(np.full(7, 0.2), list(states), VALUES)
    assert np.allclose([r[-1] for r in rows], expected, rtol=1e-13, atol=0)
    assert np.allclose([r[0] for r in rows], direct(form, list(states[:, 0]), VALUES, 0.2))


def test_c_agrees_with_python(tmp_path: Any) -> None:
    form = coupled()
    program = Program.of(form, {"sign": se.sign(x) + x})
    source = c_source(program)
    assert "state[3]: u" in source and "parameters[1]: b" in source
    if shutil.which("cc"):
        result = c_function(source, tmp_path, 6)(0.2, STATE, VALUES)
        assert np.allclose(result, direct(form, STATE, VALUES, 0.2), rtol=1e-13, atol=0)


def test_mpmath_source_gains_digits_with_the_precision() -> None:
    form = coupled()
    source = mpmath_source(Program.of(form))
    namespace: dict[str, Any] = {}
    exec(source, namespace)
    results = []
    for digits in (40, 60):
        with mpmath.workdps(digits):
            state = [mpmath.mpf(round(10 * s)) / 10 for s in STATE]
            values = [mpmath.mpf(5) / 4, mpmath.mpf(4) / 5]
            results.append(namespace["rhs"](mpmath.mpf(1) / 5, state, values))
    with mpmath.workdps(50):
        for rough, fine in zip(*results, strict=True):
            assert abs(rough - fine) < mpmath.mpf(10) ** -36
    assert np.allclose([float(r) for r in results[0]], direct(form, STATE, VALUES, 0.2))


def test_heyoka_expressions_agree_with_python() -> None:
    form = coupled()
    program = Program.of(form)
    if find_spec("heyoka") is None:  # no wheel for this platform: it says so
        with pytest.raises(ImportError):
            taylor_system(program)
        return
    import heyoka as hy

    pairs = taylor_system(program)
    function = hy.cfunc([e for _, e in pairs], vars=[s for s, _ in pairs])
    result = function(inputs=np.array(STATE), pars=np.array(VALUES), time=0.2)
    assert np.allclose(result, direct(form, STATE, VALUES, 0.2), rtol=1e-12, atol=0)


@settings(max_examples=40, deadline=None)
@given(
    entries=st.lists(st.integers(-3, 3), min_size=9, max_size=9),
    force=st.lists(st.integers(-5, 5), min_size=3, max_size=3),
)
def test_elimination_solves_symmetric_positive_systems(entries: Any, force: Any) -> None:
    root = np.array(entries).reshape(3, 3)
    numbers = root @ root.T + np.eye(3, dtype=int)
    # the same matrix once as numbers, once hidden behind the state
    for hide in (lambda n: se.Integer(n), lambda n: n * x if n else se.Integer(0)):
        mass = [[hide(int(e)) for e in row] for row in numbers]
        program = Program.of(first_order(mass, force))
        rhs, _ = compile_program(program)
        vdot = rhs(0.0, [1.0, 0, 0, 0, 0, 0], [1.0, 1.0])[3:]
        residual = numbers @ np.array(vdot, dtype=float) - force
        assert np.abs(residual).max() <= 1e-10 * (1 + np.abs(numbers).max())


@pytest.mark.parametrize("size", [2, 5, 9])
def test_elimination_on_random_matrices_of_any_size(size: int) -> None:
    rng = np.random.default_rng(size)
    root = rng.normal(size=(size, size))
    numbers = root @ root.T + 0.1 * np.eye(size)
    symbols = {(i, j): se.Symbol(f"m{i}_{j}") for i in range(size) for j in range(i + 1)}
    qs, vs = ([se.Symbol(f"{s}{i}") for i in range(size)] for s in "qv")
    form = FirstOrderForm(
        coordinates=tuple(qs), velocities=tuple(vs), parameters=tuple(symbols.values()), time=t,
        rates=tuple(vs), force=tuple(qs), velocity_symbols=tuple(se.Symbol(f"{q}dot") for q in qs),
        mass=tuple(tuple(symbols[max(i, j), min(i, j)] for j in range(size)) for i in range(size)),
        definitions=(),
    )  # fmt: skip
    rhs, _ = compile_program(Program.of(form), scalar=True)
    q = rng.normal(size=size)
    vdot = rhs(0.0, [*q, *q], [numbers[k] for k in symbols])[size:]
    assert np.allclose(numbers @ vdot, q, rtol=0, atol=1e-9)


def test_diagonal_and_constant_masses_cost_nothing() -> None:
    diagonal = Program.of(first_order([[1, 0], [0, 1]], [-x, -y]))
    assert not diagonal.derivative.assignments
    assert diagonal.derivative.results == (u, v, -x, -y)
    with_parameter = Program.of(first_order([[a, 0], [0, a * b]], [-a * x, a * b * y]))
    assert with_parameter.derivative.results[2:] == (-x, y)
    # numbers fold: only the products with the force are left, no quotient of the matrix
    constant = Program.of(first_order([[2, 1], [1, 3]], [x, y]))
    assert constant.operations <= 8
    rhs, _ = compile_program(constant)
    assert np.allclose(rhs(0, [1.0, 2.0, 0, 0], VALUES)[2:], [0.2, 0.6])


def test_the_elimination_adds_little_to_large_forces() -> None:
    # each force is used by every row below its pivot: it is computed once all the same
    form = coupled()
    heavy = [f + sum((x + i * y) ** i for i in range(2, 30)) * u for f in form.force]
    entries = [form.mass[i][j] for i in range(3) for j in range(i + 1)]
    replacements, reduced = se.cse(stable_all([*heavy, *entries]))
    shared = int(se.count_ops(*[e for _, e in replacements], *reduced))
    assert Program.of(first_order(form.mass, heavy)).operations <= shared + 45


def test_independent_blocks_stay_apart() -> None:
    mass = [[a, 0, se.cos(x)], [0, b + x**2, 0], [se.cos(x), 0, a]]
    program = Program.of(first_order(mass, [u, v, w]))
    names = dict(program.derivative.assignments)
    middle = program.derivative.results[4]
    reached, stack = set(), [middle]
    while stack:
        for symbol in stack.pop().free_symbols - reached:
            reached.add(symbol)
            stack += [names[symbol]] if symbol in names else []
    assert {s for s in reached if s not in names} == {v, b, x}


def test_zeros_on_the_diagonal_are_passed_over() -> None:
    mass = [[0, 1 + x**2, 0], [1 + x**2, 0, y], [0, y, 2]]
    form = first_order(mass, [x, y, z])
    rhs, _ = compile_program(Program.of(form))
    assert np.allclose(rhs(0.0, STATE, VALUES), direct(form, STATE, VALUES, 0.0))
    with pytest.raises(DefinitionError, match="mass matrix is singular"):
        Program.of(first_order([[0, 0], [0, 1]], [x, y]))


def test_extras_may_use_the_velocities_of_all_coordinates() -> None:
    form = first_order([[1]], [-x], rates=(a * u,))
    program = Program.of(form, {"speed": se.Symbol("xdot") ** 2, "one": 1})
    _, extras = compile_program(program)
    assert extras(0.0, [0.5, 3.0], [2.0, 0.0]) == [36.0, 1]
    assert program.operations == Program.of(form).operations


def test_awkward_names_become_identifiers(tmp_path: Any) -> None:
    names = se.symbols("lambda double sin c0 state 1st")
    form = first_order([[1]], [sum(se.sin(n) for n in names) + se.exp(x * y - x * y + t)],
                       parameters=names)  # fmt: skip
    program = Program.of(form)
    values = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]
    expected = sum(map(math.sin, values)) + math.exp(0.2)
    rhs, _ = compile_program(program)
    assert rhs(0.2, [0.0, 0.0], values)[1] == pytest.approx(expected, rel=1e-14)
    source = c_source(program)
    assert "const double double_ = parameters[1];" in source
    if shutil.which("cc"):
        result = c_function(source, tmp_path, 2)(0.2, [0.0, 0.0], values)
        assert result[1] == pytest.approx(expected, rel=1e-14)


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_macros_of_c_are_no_names(tmp_path: Any) -> None:
    """The mass of the Earth is M_E, and so is, for compilers at their own standard, a number."""
    names = se.symbols("M_E FP_NAN true linux _Bool M_1")
    form = first_order([[1]], [se.Add(*names)], parameters=names)
    (tmp_path / "names.c").write_text(c_source(Program.of(form)))
    for standard in ([], ["-std=c99"], ["-std=gnu2x"]):
        command = ["cc", *standard, "-fsyntax-only", str(tmp_path / "names.c")]
        subprocess.run(command, check=True)
    assert "const double M_1 = parameters[5];" in (tmp_path / "names.c").read_text()


def test_assigned_names_avoid_those_in_use() -> None:
    c0, c1 = se.symbols("c0 c1")
    force = [c0 * se.sin(x) + se.sin(x) ** 2 + c1 * se.sin(se.sin(x))]
    rhs, _ = compile_program(Program.of(first_order([[1]], force, parameters=(c0, c1))))
    sine = math.sin(0.5)
    expected = 2 * sine + sine**2 + 3 * math.sin(sine)
    assert rhs(0.0, [0.5, 0.0], [2.0, 3.0])[1] == pytest.approx(expected, rel=1e-14)


def test_what_has_no_value_is_refused_by_name() -> None:
    f = se.Function("f")
    with pytest.raises(DefinitionError, match=r"equations of motion: the function 'f\(x\)'"):
        Program.of(first_order([[1]], [f(x)]))
    with pytest.raises(DefinitionError, match="unknown"):
        Program.of(first_order([[1]], [f(x).diff(x)]))
    with pytest.raises(DefinitionError, match="'power': 'q' is neither a coordinate"):
        Program.of(first_order([[1]], [x]), {"power": se.Symbol("q")})
    with pytest.raises(EngineLimit, match="gamma"):
        python_source(Program.of(first_order([[1]], [se.gamma(x)])))


def test_a_traceback_shows_the_generated_line() -> None:
    rhs, _ = compile_program(Program.of(first_order([[1]], [1 / x])), scalar=True)
    with pytest.raises(ZeroDivisionError) as caught:
        rhs(0.0, [0.0, 1.0], VALUES)
    shown = "".join(traceback.format_exception(caught.value))
    assert "1/x,  # d(u)/dt" in shown


def test_source_says_what_goes_in_and_in_which_units() -> None:
    source = python_source(Program.of(coupled()))
    assert "state      = [x, y, z, u, v, w]" in source
    assert "parameters = [a, b]" in source
    assert "units" in source and "radians" in source


def test_long_sums_keep_their_fractions_and_series_nest_only_so_deep() -> None:
    """The common denominator of sin(n x)/n, n = 1 ... 800, is beyond doubles; 1500 powers of one
    letter, one inside the other, are deeper than Python calls functions."""
    q = sp.Symbol("q")
    rate, orders = vo.velocity(q), range(1, 801)
    system = vo.System(
        name="saw", fibration=vo.Fibration(q), lagrangian=rate**2 / 2,
        forces={q: sp.Add(*[sp.sin(n * q) / n for n in orders])},
    )  # fmt: skip
    space: dict[str, Any] = {}
    exec(vo.derive(system).python(), space)
    truth = math.fsum(math.sin(0.7 * n) / n for n in orders)
    assert space["rhs"](0.0, [0.7, 0.0], [])[1] == pytest.approx(truth, rel=1e-12)
    assert "151.0*q)/151.0" in vo.derive(system).c()
    total = se.Add(*[a**n * se.sin(n * x) / n for n in range(1, 1501)])
    names = (se.Symbol(f"s{i}") for i in range(2000))
    found = factor_sums({z: total}, lambda: next(names))
    at: dict[Any, Any] = {a: 0.999, x: 0.3}
    for name, expr in found.items():
        at[name] = float(expr.xreplace(at))
    series = math.fsum(0.999**n * math.sin(0.3 * n) / n for n in range(1, 1501))
    assert at[z] == pytest.approx(series, rel=1e-12)


def test_sums_that_collapse_when_their_sign_is_taken_out_are_kept() -> None:
    """-2 a - (b - 2 a) is -b: it was lost, and exp of it 1."""
    block = Block((), (se.exp(-2 * a - (b - 2 * a)),))
    program = Program(t, (a,), (b,), (), block, (), Block((), ()))
    (found,) = shorten_program(program).derivative.results
    assert found == se.exp(-b)


def test_terms_of_which_nothing_is_left_are_no_parts_of_pairs() -> None:
    """c0 - 2 x is zero where c0 is 2 x; the sum was shared with others as if it held x."""
    c0, c1 = se.symbols("c0 c1")
    two, third, exp = se.Integer(2), se.Rational(2, 3), se.exp
    inner = 3 * exp(two + c0) - 10 * exp(c0) + 3 * exp(two + 6 * x)
    expr = exp(-two - 3 * c1 - 2 * x) * (inner - 2 * exp(two + c1 + 14 * x / 3))
    block = Block(((c0, 2 * x), (c1, -third * y)), (expr,))
    found = shorten_program(Program(t, (x, y), (), (), block, (), Block((), ()))).derivative

    def value(expr: Any, assignments: Any) -> float:
        for name, meaning in reversed(assignments):
            expr = expr.xreplace({name: meaning})
        return float(expr.xreplace({x: se.Rational(3, 10), y: se.Rational(7, 10)}).n())

    assert value(found.results[0], found.assignments) == pytest.approx(
        value(expr, block.assignments), rel=1e-12
    )
