"""Odd values that the fuzzer of doors hands in."""

from __future__ import annotations

import math
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from random import Random
from typing import Any

import mpmath
import numpy as np
import sympy as sp

CANARY = "text-was-run"
"""The folder that hostile text makes where it is run."""
RUN = f"__import__('os').mkdir('{CANARY}')"
HOSTILE = (
    RUN,
    f"{RUN} or 1",
    f"x\n{RUN}",
    f"x\n    {RUN}",
    f'"""\n{RUN}\n"""',
    f"'); {RUN}; ('",
    f"x; {RUN}",
    f"[{RUN} for _ in (1,)]",
    f"lambda: {RUN}",
    f"(lambda: {RUN})()",
    f"{{{RUN}}}",
    f"f(x, {RUN})",
    f"# {RUN}",
    f"$(mkdir {CANARY})",
    f"`mkdir {CANARY}`",
    f"x*/ {RUN} /*",
    f"\\input{{|mkdir {CANARY}}}",
    f"<script>{RUN}</script>",
    "().__class__.__base__.__subclasses__()",
    "9**9**9**9",
    "1e999999999",
    "exp(exp(700000000))",
    "10**400",
    "(" * 3000,
    "-" * 3000 + "1",
    "x+" * 3000 + "x",
    "a" * 300,
    "../../../etc/passwd",
    "/dev/full",
    "~",
    "-",
    "--",
    "--help",
    "%s%n{0}{x}",
)
PLAIN = (
    "", " ", "\n", "\0", "x", "y", "t", "v", "w", "phi", "xdot", "m", "pi", "E", "I", "S", "nan",
    "inf",
    "-inf", "0", "1", "-1", "1/3", "1/0", "2.5", "1e-320", "1e308", "-pi/2", "acos(-8/17)",
    "sin(x)",
    "x+y", "x*", "x=1", "1,2", "0:1:3", "1:0", "0:0", ":", "::", "true", "None", "energy",
    "default",
    "auto", "heyoka", "scipy", "lsoda", "flint", "closed-form", "configuration", "reaction 1",
    "reaction 99", "theta", "θ", "é", "日本", "\ud800", "\u202e", "\x1b[31m", "e\u0301", "_",
    "__name__",
    "lambda", "import", "class", "x y", "x'", 'x"', "x\\", "a" * 40, "1" * 500, "sleigh",
    "demchenko",
    "SYSTEM", ".", "..", "/", "x.py", "x.json", "x.svg", "x.csv", "x.xyz", "/nowhere/at/all",
)  # fmt: skip
X, Y, M = sp.symbols("x y m")


def odd_text(dice: Random) -> str:
    """A text that is empty, hostile, too long, or nearly right."""
    kind = dice.random()
    if kind < 0.3:
        return dice.choice(HOSTILE)
    if kind < 0.85:
        return dice.choice(PLAIN)
    letters = "0123456789.eE+-*/^()[]{},:;=_ xyzmvw'\"\\\n\t\0#$%&@!?θ"
    return "".join(dice.choice(letters) for _ in range(dice.randrange(1, 12)))


def odd_value(dice: Random, depth: int = 0) -> Any:
    """A value of any kind, wrong or nearly right."""
    kind = dice.randrange(9)
    if kind <= 1:
        return odd_text(dice)
    if kind <= 3:
        return dice.choice(_numbers())
    if kind <= 5:
        return dice.choice(_expressions(dice))
    if kind == 6:
        return dice.choice(_arrays())
    if kind == 7 or depth > 1:
        return dice.choice(_others())
    inner = [odd_value(dice, depth + 1) for _ in range(dice.randrange(4))]
    if dice.random() < 0.5:
        keys = [dice.choice(["x", "v", "m", X, Y, M, odd_text(dice)]) for _ in inner]
        return dict(zip(keys, inner, strict=True))
    return dice.choice([list, tuple])(inner)


def _numbers() -> list[Any]:
    return [
        0, 1, -1, 2, 3, 10**400, -(10**400), 2**63, True, False, 0.0, -0.0, 0.5, -2.5, 1e308,
        -1e308,
        1e-320, 5e-324, 1e16, 1e-12, math.nan, math.inf, -math.inf, 1 + 2j, Fraction(1, 3),
        Fraction(10**400, 3), Decimal("0.1"), Decimal("NaN"), Decimal("Infinity"),
        Decimal("1e999999"), np.float64(0.5), np.float64("nan"), np.int64(3), np.bool_(True),
        np.float32(0.1), np.complex128(1j), mpmath.mpf("0.1"), mpmath.mpf("nan"), mpmath.inf,
        mpmath.mpc(1, 1),
    ]  # fmt: skip


def _expressions(dice: Random) -> list[Any]:
    f = sp.Function("f")
    t = sp.Symbol("t")
    return [
        X, Y, M, t, sp.Symbol("v"), sp.Symbol("xdot"), sp.Symbol(""), sp.Symbol(" "),
        sp.Symbol("x y"),
        sp.Symbol("a" * 300), sp.Symbol("θ"), sp.Symbol("x", real=True), sp.Symbol("lambda"),
        sp.Symbol(dice.choice(HOSTILE)), sp.Dummy("x"), f(X), f(t), f(t).diff(t), f(t).diff(t, 2),
        sp.Function(dice.choice(HOSTILE))(X), sp.pi, sp.E, sp.I, sp.oo, -sp.oo, sp.zoo, sp.nan,
        sp.Rational(1, 3), sp.Float("0.1", 50), sp.Integer(10) ** 400, sp.Float("1e400"),
        sp.exp(sp.exp(sp.Integer(700000000))), 1 / X, X**Y, sp.sqrt(-1 - X**2), sp.log(X),
        sp.sin(X),
        sp.Abs(X), sp.sign(X), sp.Max(X, Y), sp.Piecewise((X, X > 0), (0, True)), sp.Eq(X, 1),
        X > 1,
        sp.true, sp.Matrix([1, 2]), sp.eye(2), sp.ImmutableMatrix([[X]]), sp.Tuple(X, Y), sp.sin,
        sp.Integral(X, X), sp.Sum(X, (X, 0, 3)), sp.Derivative(X, X), sp.Lambda(X, X),
        sp.S.EmptySet,
        sp.Interval(0, 1), sp.gamma(X), sp.floor(X), sp.MatrixSymbol("A", 2, 2), X**100000,
        sp.erf(X),
        sp.factorial(X), sp.Mod(X, 2), sp.conjugate(X), sp.re(X), sp.O(X), sp.tan(X / 0.5),
    ]  # fmt: skip


def _arrays() -> list[Any]:
    return [
        np.array([]), np.array([0.0, 1.0]), np.array([1.0, 0.0]), np.array([0.0, 0.0]),
        np.array([0.0, np.nan]), np.array([0.0, np.inf]), np.zeros((2, 2)), np.array(3.0),
        np.array(["1", RUN]), np.array([None, 1], dtype=object), np.array([X, 1], dtype=object),
        np.array([0, 1], dtype=np.int8), np.array([1j, 2]), np.array([0.0, 1e308]),
        np.array([0, 1, 2], dtype="datetime64[s]"), [0, 1, 2], (0.0, 1.0), [0], [1, 0], [], (),
        {}, "01",
        [[0, 1], [2]], [RUN], (RUN, 1), {"x": RUN}, {"v": [0, 1]}, {"v": []}, {"m": [1, -1, 2]},
        [{"v": 1}, {"v": 2}], [{"v": RUN}], [{}], [None], {None: 1}, {1: 2}, {("x", "y"): 1},
        {"x": None}, {X: X}, {X: Y, "x": 1}, [X, X], [X, Y], (X,), {X}, {"nobody": 1},
    ]  # fmt: skip


def _others() -> list[Any]:
    return [
        None, ..., NotImplemented, object(), int, print, lambda: 1, lambda *_: RUN, len, b"x", b"",
        bytearray(b"1"), range(3), range(0), iter([1, 2]), (i for i in (0, 1)), set(), {1, 2},
        frozenset(("x",)), slice(1), Path("/"), Path(RUN), memoryview(b"x"), ValueError("x"),
        sp, np, math, _Odd(), _Silent(),
    ]  # fmt: skip


class _Odd:
    """An object that cannot even be told."""

    def __str__(self) -> str:
        raise RuntimeError("no text")

    __repr__ = __str__


class _Silent:
    """An object that pretends to have everything."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return self

    def __call__(self, *_: Any, **__: Any) -> Any:
        return self
