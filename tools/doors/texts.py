"""The doors of texts: systems in TOML, formulas, values of options, tables and bibliographies."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from random import Random
from typing import Any

import voronec as vo
from doors.commands import Wrong
from doors.values import HOSTILE, odd_text
from voronec.algebra.text import as_expression, exact_number, formula, read_sympy_text
from voronec.cli.template import MECHANISMS
from voronec.cli.values import input_values, instants, outputs_of, pair, tolerance
from voronec.declaration.bibliography import read_entries
from voronec.errors import DefinitionError
from voronec.proof.comparison import read_derivation

Door = tuple[str, Callable[[], Any]]
MORE = """
[forces]
phi = "-m*g*phidot - J*phidotdot/9"
v = "u"
"xdot - g*phidot" = "m"
[equations]
one = { function = "phidot", rate = "0" }
two = { function = ["x", "y"], rate = ["xdot", "ydot"] }
[invariants]
c = { is = "cos(phi)", meaning = "cosine" }
[possible]
"in words" = "m < 100*J"
[cases."at rest"]
parameters = { g = 0 }
measure = { density = "1", variables = ["x", "y"] }
integrals = { a = 'c' }
note = '''a
note'''
[undecided]
energy = "no"
[inputs]
u = "push"
[scenes.other]
initial = { x = -1.5e-3, xdot = "1/3" }
parameters = { m = 2 }
inputs = { u = "sin(t)" }
times = ["0", "2*pi"]
outputs = ["x^2 + c", "energy", "reaction 1", "configuration"]
[scenes.table]
initial = { v = 1 }
inputs = { u = { times = [0, "1/2", 3.5], values = [1, 2, "-pi"], kind = "held" } }
[scenes.file]
inputs = { u = { file = "u.csv" } }
[[shapes]]
kind = "surface"
coordinates = ["c1", "c2"]
position = ["c1", "c2", "m*c1^2"]
ranges = [[-1, 1], [0, "2*pi"]]
role = "ground"
[[shapes]]
kind = "torus"
ring = "m"
tube = "J"
title = "tyre"
attitude = [{ axis = "z", angle = "phi" }, { axis = "x", angle = "pi/2" }]
"""
TEXTS = [m.toml.replace("@NAME@", "made") for m in MECHANISMS]
SYSTEMS = [*TEXTS, TEXTS[0] + MORE]
TABLES = "0,1\n1,2\n", "t;u\n0;1,5\n1;2", "0,1,2\n", "\0", "0,nan\n", "1e400\t1\n"
WORDS = re.compile(r"\w+|[^\w\s]")
STRING = re.compile(r'"[^"\n]*"')
SIGNS = [*"[]{}()=.,#\"'\\+-*/^<>\n\t\0\r", '"""', "'''", "[[", "]]", "\ufeff", "é", "\u202e", "**"]
VALUES = [
    "1", "-1", "0", "1.5", "1e400", "inf", "nan", "true", "[]", "{}", "[1, 2]", "{ is = 'x' }",
    "''", "1979-05-27", "07:32:00", "0x1f", "1_000", "'x'", "'t'", "'pi'", "'1/0'",
    "'xdot = ydot = 0'", "'x^x^x^x'", "9" * 4400, "[" * 200 + "]" * 200, "[" * 3000 + "]" * 3000,
    "{ a = { b = 1 } }",
]  # fmt: skip
FORMULAS = (
    "m*(xdot^2 + ydot^2)/2", "2*a*sin(x)/3", "acos(-8/17)", "Derivative(f(x), (x, 2))",
    "sqrt(x)**(1/3)", "Min(1, x, y)", "1e-9*pi", "((x))", "atan2(y, x) - floor(3.5)",
)  # fmt: skip


def text_door(dice: Random, place: Path) -> Door:
    """A text that is malformed, hostile or nearly right, and who reads it."""
    if dice.random() < 0.6:
        return _system(dice, place)
    name = dice.choice([*READERS])
    text = _formula(dice)
    return f"{name} of {ascii(text)[-300:]}", lambda: READERS[name](text, place)


def _system(dice: Random, place: Path) -> Door:
    text = dice.choice(SYSTEMS)
    for _ in range(dice.choice((1, 1, 2, 4))):
        change = dice.choice((_cut, _swap, _change_sign, _change_value, _change_text, _double))
        text = change(dice, text)
    data = text.encode("utf-8", "surrogateescape" if dice.random() < 0.9 else "surrogatepass")
    if dice.random() < 0.02:
        data += bytes(dice.randrange(256) for _ in range(40))
    file = place / "x.toml"
    file.write_bytes(data)
    further = dice.random() < 0.02
    (place / "u.csv").write_text(dice.choice(TABLES))
    return f"system of {ascii(text)[-300:]}", lambda: _load(file, further)


def _load(file: Path, further: bool) -> None:
    """A refusal names a line and a column, unless the file is no text."""
    try:
        system = vo.load(file)
    except DefinitionError as error:
        placed = re.search(r"x\.toml, line \d+, column \d+: .|is no text: its byte", str(error))
        if placed is None:
            raise Wrong(f"message without its place: {error}") from None
        raise
    system = system if further else replace(system, sketch=None)  # to draw takes long
    repr(system), system._repr_html_()
    if further:
        vo.derive(system).as_dict()


def _cut(dice: Random, text: str) -> str:
    at = dice.randrange(len(text) + 1)
    return text[:at] + text[at + dice.choice((1, 3, 30, len(text))) :]


def _swap(dice: Random, text: str) -> str:
    words = [*WORDS.finditer(text)]
    if not words:
        return text
    one, other = dice.choice(words), dice.choice(words)
    return text[: one.start()] + other[0] + text[one.end() :]


def _change_sign(dice: Random, text: str) -> str:
    at = dice.randrange(len(text) + 1)
    return text[:at] + dice.choice(SIGNS) + text[at:]


def _change_value(dice: Random, text: str) -> str:
    """Another value in the place of one."""
    lines = text.split("\n")
    at = dice.randrange(len(lines))
    key, equals, _ = lines[at].partition("=")
    if equals:
        value = dice.choice(VALUES) if dice.random() < 0.7 else json.dumps(odd_text(dice))
        lines[at] = f"{key}= {value}"
    return "\n".join(lines)


def _change_text(dice: Random, text: str) -> str:
    """Another text in the place of one."""
    strings = [*STRING.finditer(text)]
    if not strings:
        return text
    one = dice.choice(strings)
    return text[: one.start()] + json.dumps(_formula(dice)) + text[one.end() :]


def _double(dice: Random, text: str) -> str:
    """A line or a piece of the file once more."""
    lines = text.split("\n")
    start = dice.randrange(len(lines))
    piece = lines[start : start + dice.choice((1, 1, 4))]
    at = dice.randrange(len(lines))
    return "\n".join([*lines[:at], *piece, *lines[at:]])


def _formula(dice: Random) -> str:
    kind = dice.random()
    if kind < 0.2:
        return dice.choice(HOSTILE)
    if kind < 0.5:
        return odd_text(dice)
    text = dice.choice(FORMULAS)
    for _ in range(dice.choice((1, 2))):
        text = dice.choice((_cut, _swap, _change_sign))(dice, text)
    return text


def _table(text: str, place: Path) -> None:
    (place / "u.csv").write_text("t,u\n0,1\n" + text, "utf-8", "replace")
    input_values([f"u={place / 'u.csv'}:held"])


def _derivation(text: str, place: Path) -> None:
    data = json.dumps({"name": "x", "mass": [text], "facts": {"base": text}})
    (place / "x.json").write_text(data if len(text) % 2 else text, "utf-8", "replace")
    read_derivation(place / "x.json")


READERS: dict[str, Callable[[str, Path], Any]] = {
    "formula": lambda text, _: formula(text, "it"),
    "number": lambda text, _: exact_number(text, "it"),
    "sympified": lambda text, _: as_expression(text),
    "printed": lambda text, _: read_sympy_text(text, "it"),
    "--outputs": lambda text, _: outputs_of(text),
    "--set": lambda text, _: pair("m=" + text),
    "--times": lambda text, _: instants(text),
    "--tol": lambda text, _: tolerance(text),
    "--input": _table,
    "compare": _derivation,
    "bibliography": lambda text, _: read_entries("@book{a, title={" + text),
    "equal": lambda text, _: vo.prove_equal(text, "x") if len(text) < 9 else None,
    "load": lambda text, _: vo.load(text + ".toml"),
}
"""Who reads texts, beside systems."""
