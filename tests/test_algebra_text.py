"""Text from users is read, never run; and what is read is what was written."""

import ast
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

import voronec as vo
from voronec.algebra.text import as_expression, exact_number, formula, read_sympy_text
from voronec.errors import DefinitionError

ROOT = Path(__file__).resolve().parents[1]
x, a, E, I1, gamma = sp.symbols("x a E I1 gamma")
HOSTILE = "__import__('os').mkdir('text-was-run') or 1"


@pytest.mark.parametrize(
    ("text", "meaning"),
    [
        ("2*a*sin(x)/3", 2 * a * sp.sin(x) / 3),
        ("E*I1^2 - 0.1*sqrt(gamma)/x", E * I1**2 - sp.sqrt(gamma) / x / 10),
        ("-x**2", -(x**2)),
        ("2**-x", 2 ** (-x)),
        ("x^a^2", x ** (a**2)),
        ("a - x - 1", a - x - 1),
        ("a/x/2", a / x / 2),
        ("--x", x),
        ("lambda + S", sp.Symbol("lambda") + sp.Symbol("S")),
        ("Min(1, x) + Abs(a)", sp.Min(1, x) + sp.Abs(a)),
        ("atan2(a, x)", sp.atan2(a, x)),
        ("θ*1e-3", sp.Symbol("θ") / 1000),
    ],
)
def test_a_formula_means_what_is_written(text, meaning):
    assert formula(text, "here") == meaning


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("-pi/2", -math.pi / 2),
        ("acos(-8/17)", math.acos(-8 / 17)),
        (" 1/3 ", 1 / 3),
        ("1e-320", 1e-320),
        (".5e+3", 500),
        ("2^0.5", math.sqrt(2)),
        ("exp(-1)*cosh(2)", math.exp(-1) * math.cosh(2)),
    ],
)
def test_numbers_may_be_formulas(text, value):
    assert float(exact_number(text, "here")) == pytest.approx(value, rel=1e-15, abs=5e-324)
    assert exact_number("0.1", "here") == sp.Rational(1, 10)


@pytest.mark.parametrize(
    ("text", "word"),
    [
        (HOSTILE, "column 12"),
        ("().__class__.__base__", "column 3"),
        ("[c for c in (1,)]", "column 1"),
        ("(lambda: 1)()", "column 8"),
        ("x.diff", "column 2"),
        ("f(x)", "there is no such function; there are: Abs, "),
        ("2*sgn(x)", "no such function; did you mean 'sign'"),
        ("2 x", "column 3"),
        ("(1 + x", "parenthesis of column 1"),
        ("1 +", "is expected"),
        ("", "is expected"),
        ("9**9**9", "too large"),
        ("10**400", "too large"),
        ("1e999999999", "too long"),
        ("7" * 5000, "too long"),
        ("exp(exp(7e8))", "too large"),
        ("(2*x)**(10**9)", "too large"),
        ("(" * 5000 + "x" + ")" * 5000, "levels"),
        ("2**" * 5000 + "2", "levels"),
        ("x+" * 50_000 + "1", "characters"),
        ("1/(2 - 2)", "division by zero"),
        ("sqrt(1 - 2)", "real number"),
        ("acos(17/8)", "real number"),
        ("log(0)", "real number"),
        ("x\x1b[31m", "column 2"),
    ],
)
def test_what_is_no_formula_is_refused_at_its_place(text, word):
    with pytest.raises(DefinitionError) as caught:
        formula(text, "--at x")
    message = str(caught.value)
    assert message.startswith("--at x: ") and word in message
    assert message.isprintable() and len(message) < 500


def test_long_sums_are_read_in_one_go():
    terms = sp.symbols("a:2000")
    assert formula("+".join(map(str, terms)), "here") == sp.Add(*terms)


def test_what_sympy_prints_is_read_back():
    f = sp.Function("f")
    expr = sp.sin(x) ** 2 / 3 + f(x, 2) * sp.diff(f(x, a), x, x, a)
    assert read_sympy_text(str(expr), "here") == expr
    with pytest.raises(DefinitionError):
        read_sympy_text("Derivative(f(x), (x, 10**9))", "here")


def test_texts_inside_lists_are_not_read():
    for things in ([HOSTILE], (HOSTILE,), {HOSTILE}, {1: HOSTILE}, np.array([HOSTILE]), b"1"):
        with pytest.raises(DefinitionError):
            as_expression(things)


def test_no_door_of_the_package_runs_text(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    sleigh = vo.load("sleigh")
    q = vo.Fibration(base=(x,), fibre=())
    doors = [
        lambda: vo.integrate(sleigh, initial={"v": HOSTILE}, times=[0, 1]),
        lambda: vo.integrate(sleigh, parameters={"m": HOSTILE}, times=[0, 1]),
        lambda: vo.integrate(sleigh, outputs=[[HOSTILE]], times=[0, 1]),
        lambda: vo.ensemble(sleigh, starts=[{"v": HOSTILE}], times=[0, 1]),
        lambda: vo.ensemble(sleigh, parameters={"m": [HOSTILE, "1"]}, times=[0, 1]),
        lambda: vo.System(name="s", fibration=q, lagrangian=HOSTILE),
        lambda: vo.System(name="s", fibration=q, lagrangian=x, constraints=([HOSTILE],)),
        lambda: vo.System(name="s", fibration=q, lagrangian=x, forces={x: HOSTILE}),
        lambda: vo.Parameter(a, HOSTILE),
        lambda: vo.Parameter(a, 1, lower=HOSTILE),
        lambda: vo.Scene({x: HOSTILE}),
        lambda: vo.Scene({}, (0, HOSTILE)),
        lambda: vo.prove_equal(HOSTILE, 1),
        lambda: vo.prove_equal(1, x, [HOSTILE]),
        lambda: vo.derive(sleigh).acceleration({"x": HOSTILE}),
    ]
    for bridge in doors:
        with pytest.raises(DefinitionError) as caught:
            bridge()
        assert "\n" not in str(caught.value)
    assert not any(tmp_path.iterdir())


@pytest.mark.slow
def test_text_is_a_number_for_python_as_for_the_command_line():
    sleigh = vo.load("sleigh")
    text = vo.integrate(sleigh, initial={"w": "-pi/2", "v": "1/3"}, times=[0, 1])
    exact = vo.integrate(sleigh, initial={"w": -sp.pi / 2, "v": sp.Rational(1, 3)}, times=[0, 1])
    assert (text["x"] == exact["x"]).all() and text["w"][0] == -math.pi / 2
    scene = vo.Scene({"v": "1/3"}, ("0", "pi"), outputs="v")
    assert scene.initial["v"] == sp.Rational(1, 3) and scene.times[1] == sp.pi
    assert vo.Parameter(a, "2/7").value == sp.Rational(2, 7)
    command = [sys.executable, "-m", "voronec", "explain", "sleigh", "--set", "v=cos(pi/3)"]
    assert subprocess.run(command, env={**os.environ}, capture_output=True).returncode == 0


@pytest.mark.slow
def test_the_package_holds_no_way_to_run_text():
    """``eval`` and SymPy's readers of text occur nowhere; ``exec`` where programs are printed."""
    programs = {
        "declaration/plugin_files.py",
        "equations/program/dialect.py",
        "motion/steppers/kept_code.py",
        "accuracy/bench/peers/hand_programs.py",
        "accuracy/bench/agreement.py",
        "accuracy/bench/peers/numba_dop853.py",
    }
    found = set()
    for file in sorted((ROOT / "voronec").rglob("*.py")):
        place = file.relative_to(ROOT / "voronec").as_posix()
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if not isinstance(node, ast.Call):
                continue
            name = getattr(node.func, "id", getattr(node.func, "attr", ""))
            owner = getattr(getattr(node.func, "value", None), "id", "")
            if name in ("parse_expr", "S") or (name == "eval" and not owner):
                found.add(f"{place}: {name}")
            if name == "sympify" and owner != "se" and place != "algebra/text.py":
                found.add(f"{place}: {name}")
            if name == "exec" and place not in programs:
                found.add(f"{place}: {name}")
    assert not found
