"""A derivation step by step: its numbers against formulas by hand, and its three forms."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import pytest
import sympy as sp
from command_line import refused
from sympy.physics.mechanics import dynamicsymbols

import voronec as vo
from voronec.audit.lessons.lesson import LessonStep, LessonWork
from voronec.cli import main

told = cache(lambda name: vo.lesson(vo.load(name)))


def _part(name: str, title: str) -> LessonStep:
    (found,) = [part for part in told(name).parts if part.title == title]
    return found


def _values(name: str, title: str) -> dict[str, sp.Expr]:
    return {row.text: row.value for row in _part(name, title).rows}


@pytest.mark.parametrize(
    "name",
    [
        "sleigh",
        "vertical-disc",
        "snakeboard",
        "roller-racer",
        "chaplygin-ball",
        "ball-on-turntable",
        "sleigh-on-turntable",
        "free-particle",
        "growing-sleigh",
    ],
)
def test_the_steps_add_up(name: str) -> None:
    """The terms of (9), each computed by its own formula, are mass * vdot - force: proved."""
    assert told(name).verdict.proved


q, phi, v, w = dynamicsymbols("q phi v w")
ANGLE = vo.System("angle", vo.Fibration(base=q), q.diff() ** 2 / 2 + sp.cos(q))
SPEEDS = vo.System(
    "speeds", vo.Fibration(base=(q, phi)), (q.diff() ** 2 + phi.diff() ** 2) / 2,
    frame=vo.Frame.quasi({v: q.diff() / sp.cos(phi), w: phi.diff()}),
)  # fmt: skip


@pytest.mark.parametrize("system", [ANGLE, SPEEDS])
def test_functions_of_time_have_steps_too(system: vo.System) -> None:
    """Coordinates and velocities may be ``dynamicsymbols``: their rates are accelerations."""
    assert vo.lesson(system).verdict.proved


@pytest.mark.parametrize(
    ("system", "text", "status"),
    [
        (ANGLE, r"\ddot q = -\sin q", "proved"),
        (ANGLE, r"\ddot q = \sin q", "refuted"),
        (SPEEDS, r"\dot w = 0", "proved"),
        (SPEEDS, r"\dot v = v w \tan(phi)", "proved"),
        (SPEEDS, r"\dot v = 0", "refuted"),
    ],
)
def test_equations_in_functions_of_time_are_judged(
    system: vo.System, text: str, status: str
) -> None:
    """In a fresh system each: whoever asks first must be answered."""
    assert vo.judge(replace(system, name="fresh"), text).verdict.status == status


def test_a_wrong_step_is_found() -> None:
    """Without the curvature the terms do not add up, and the check says so."""
    work = LessonWork(vo.derive(vo.load("sleigh")))
    work.turned = [term * 0 for term in work.turned]
    assert any(sp.sympify(difference) != 0 for _, difference in work.differences())


def test_numbers_of_the_sleigh() -> None:
    """By hand: y' = x' tan(phi), so A = d(tan)/dphi; Lc and its derivatives [Chaplygin1911]."""
    m, J, a, v, w, phi = sp.symbols("m J a v w phi")
    curvature = _values("sleigh", "The curvature in the coordinates of the base")
    assert sp.simplify(curvature["A^y[x, phi]"] - sp.tan(phi).diff(phi)) == 0
    reduced = _values("sleigh", "The Lagrangian on the constraints")
    assert sp.expand(reduced["Lc"] - m * v**2 / 2 - (J + m * a**2) * w**2 / 2) == 0
    assert sp.expand(reduced["p[y]"] - m * (v * sp.sin(phi) + a * w * sp.cos(phi))) == 0
    term = _values("sleigh", "The term of the curvature")
    assert sp.expand(term["G[v]"] + m * a * w**2) == 0
    assert sp.expand(term["G[w]"] - m * a * v * w) == 0


def test_numbers_of_the_disc() -> None:
    """By hand: x' = R theta' cos(phi), y' = R theta' sin(phi)."""
    R, phi = sp.symbols("R phi")
    curvature = _values("vertical-disc", "The curvature in the coordinates of the base")
    assert curvature["A^x[theta, phi]"] == (R * sp.cos(phi)).diff(phi)
    assert curvature["A^y[theta, phi]"] == (R * sp.sin(phi)).diff(phi)


def test_the_text_reads_as_a_derivation() -> None:
    """Numbered steps with the numbers of the theory, and the check at the end."""
    text = str(told("vertical-disc"))
    assert text.startswith("vertical-disc: Vertical rolling disc\n\n1. What is given\n")
    for number in ("(3), (4)", "(5)", "(6)", "(7), (8)", "(9)", "(11)"):
        assert number in text
    assert "h[theta" in text
    assert "d_theta" in text
    assert "proved" in text.splitlines()[-2] + text.splitlines()[-1]
    assert all(len(line) <= 110 for line in text.splitlines())


def test_the_page_is_well_formed_and_loads_nothing() -> None:
    """MathML that a browser reads as XML, and no address."""
    page = told("chaplygin-ball").html()
    assert "http" not in page.replace('xmlns="http', "")
    assert "<script" not in page
    assert 'class="latex"' not in page, "a formula was not set"
    body = page[page.index("<body>") : page.index("</body>") + 7].replace("&nbsp;", " ")
    root = ElementTree.fromstring(body)
    assert len(root.findall("h2")) == len(told("chaplygin-ball").parts)


def test_the_latex_is_balanced() -> None:
    """Braces, environments and displays close."""
    text = told("snakeboard").latex()
    assert text.count("{") == text.count("}")
    assert text.count("\\[") == text.count("\\]")
    assert "h_{\\dot{\\theta}} = \\partial_{\\theta} - " in text
    assert "\\frac{l \\cos{\\left(\\phi \\right)}" in text


def test_what_is_too_large_or_on_a_group_is_refused() -> None:
    """One line that says what to do instead."""
    with pytest.raises(vo.DefinitionError, match="--python"):
        vo.lesson(vo.load("bicycle"))


def test_the_command(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Text, LaTeX, data, and three files."""
    monkeypatch.chdir(tmp_path)
    assert main(["explain", "sleigh", "--derivation"]) == 0
    assert "1. What is given" in capsys.readouterr().out
    assert main(["explain", "sleigh", "--derivation", "--latex"]) == 0
    assert capsys.readouterr().out.startswith("\\documentclass")
    assert main(["explain", "sleigh", "--derivation", "--json", "--out", "pages"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["check"] == "proved"
    assert [Path(f).name for f in data["files"]] == [
        f"derivation.{suffix}" for suffix in ("html", "tex", "txt")
    ]
    assert all(Path(f).is_file() for f in data["files"])


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--latex"], "add --derivation"),
        (["--derivation", "--outputs", "x"], "--outputs"),
        (["--derivation", "--set", "a=1"], "--set"),
    ],
)
def test_what_does_not_go_together(
    words: list[str], said: str, capsys: pytest.CaptureFixture[str],
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    """A refusal in one line."""
    from command_line import Answer

    monkeypatch.chdir(tmp_path)
    status = main(["explain", "sleigh", *words])
    out = capsys.readouterr()
    assert said in refused(Answer(status, out.out, out.err))


def test_a_refuted_check_is_told() -> None:
    """The last line is the verdict's, whatever it is."""
    wrong = vo.Verdict("refuted", "ball arithmetic")
    assert "refuted" in str(replace(told("sleigh"), verdict=wrong)).splitlines()[-1]


def test_roots_of_sizes_are_of_one_form_in_lessons() -> None:
    """|v|^(1/2) was a root of a root beside the fourth root of v^2: undecided."""
    x, y, phi = sp.symbols("x y phi")
    dx, dy, dphi = map(vo.velocity, (x, y, phi))
    drag = {x: -sp.sign(dx) * sp.sqrt(sp.Abs(dx))}
    system = vo.System(
        name="rooted", fibration=vo.Fibration((x, phi), (y,)),
        lagrangian=(dx**2 + dy**2 + dphi**2) / 2, constraints=(dy - sp.Abs(x) * dphi,), forces=drag,
    )  # fmt: skip
    assert vo.lesson(system).verdict.proved
    assert vo.by_methods(system).proved
