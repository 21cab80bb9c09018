"""The form for people: equal to the equations, as short as a book's, and fit to be printed."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import pytest
import sympy as sp
from textbook_equations import TEXTBOOK, Textbook, pairs, read

import voronec as vo
from voronec.algebra.symbols import plain_name
from voronec.equations.readable import readable

BY_NAME = [pytest.param(book, id=book.name) for book in TEXTBOOK]


def depth(text: str) -> int:
    """How deep brackets are nested."""
    depth = most = 0
    for letter in text:
        depth += (letter == "(") - (letter == ")")
        most = max(most, depth)
    return most


def equations_of(text: str) -> list[Any]:
    """What vanishes by the equations of a text, names that stand on a left side replaced where they
    are no rate."""
    sides = [(read(a), read(b)) for a, b in pairs(text, "=")]
    names = {a: b for a, b in sides if a.is_Symbol and not a.name.endswith("dot")}
    found = [a - b for a, b in sides if a not in names]
    for _ in names:
        found = [e.xreplace(names) for e in found]
    return found


def printed(eqs: Any) -> str:
    """The equations that ``print`` shows, in one line each, without headings."""
    lines = str(eqs).splitlines()
    rows: list[str] = []
    start = next(i for i, line in enumerate(lines) if re.match("motion of|equations of", line))
    for line in lines[start:]:
        if line == "curvature":
            break
        if line.startswith("      "):
            rows[-1] += " " + line.strip()
        elif line.startswith("  "):
            rows.append(line.strip())
    return "; ".join(rows)


def residuals(system: Any, text: str) -> list[Any]:
    """The equations of a text on the motion that the engine derives."""
    eqs = vo.derive(system)
    mass, force = sp.Matrix(eqs.mass), sp.Matrix(eqs.force)
    rates = dict(zip(eqs.coordinates, eqs.rates, strict=True))
    solved = mass.adjugate() * force / mass.det()
    values = dict(zip(map(vo.velocity, eqs.velocities), solved, strict=True))
    for q, rate in rates.items():  # accelerations of coordinates
        moved = {**rates, **{v: values[vo.velocity(v)] for v in eqs.velocities}}
        total = sum((rate.diff(x) * dx for x, dx in moved.items()), rate.diff(vo.time))
        values.setdefault(vo.velocity(vo.velocity(q)), total)
        values.setdefault(vo.velocity(q), rate)
    for name, e in [(str(a), e) for a, e in values.items()]:
        if name.endswith("dotdot"):
            values[sp.Symbol(f"{name[:-6]}ddot")] = e
    accelerated = [e.xreplace(values) for e in equations_of(text)]
    return [e.xreplace(values) for e in accelerated]


@pytest.mark.slow
@pytest.mark.parametrize("book", BY_NAME)
def test_equations_of_a_book_hold_on_the_motion(book: Textbook) -> None:
    for residual in residuals(book.system, book.equations):
        assert vo.prove_equal(residual, 0).proved


@pytest.mark.slow
@pytest.mark.parametrize("book", BY_NAME)
def test_what_is_printed_holds_on_the_motion_and_determines_it(book: Textbook) -> None:
    eqs = vo.derive(book.system)
    text = printed(eqs)
    for residual in residuals(book.system, text):
        assert vo.prove_equal(residual, 0).proved
    dots = [sp.Symbol(re.sub("dotdot$", "ddot", str(vo.velocity(v)))) for v in eqs.velocities]
    slopes = sp.Matrix([[e.diff(a) for a in dots] for e in equations_of(text)])
    point = {s: sp.Rational(i + 3, 7) for i, s in enumerate(sorted(slopes.free_symbols, key=str))}
    assert slopes.xreplace(point).evalf(30).rank() == len(dots)


@pytest.mark.slow
@pytest.mark.parametrize("book", BY_NAME)
def test_lines_are_short_and_brackets_are_not_nested_deeply(book: Textbook) -> None:
    text = str(vo.derive(book.system))
    assert all(len(line) <= 100 for line in text.splitlines())
    assert depth(text) <= 3


@pytest.mark.slow
def test_the_printed_form_is_as_short_as_the_book() -> None:
    ratios = [len(printed(vo.derive(b.system)).replace(" ", "").replace(";", "")) / b.length
              for b in TEXTBOOK]  # fmt: skip
    assert len(ratios) >= 30 and sorted(ratios)[len(ratios) // 2] <= 1
    assert max(ratios) < 1.5


def sled(mass: str = "m", reach: str = "K") -> vo.System:
    """A sleigh whose letters the test chooses."""
    return Textbook(
        "sled", "", "x phi",
        f"{mass}*(xdot^2 + ydot^2)/2 + (J + {mass}*{reach}^2)*phidot^2/2"
        f" + {mass}*{reach}*phidot*(ydot*cos(phi) - xdot*sin(phi)) - D*(x^2 + y^2)/2",
        f"{mass} J {reach} D", "", fibre="y", constraints="xdot*sin(phi) - ydot*cos(phi)",
        frame="v: xdot*cos(phi) + ydot*sin(phi); w: phidot",
    ).system  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", ["demchenko", "chaplygin-ball", "robot-with-two-trailers"])
def test_names_are_nobody_elses_and_stand_for_what_is_said(name: str) -> None:
    system = vo.load(name)
    form = readable(vo.derive(system))
    names = [form.alphabet.text(left) for left, _ in form.names]
    own = {plain_name(s) for s in system.known_symbols()}
    assert names and len({*names}) == len(names) and not own & {*names}
    rows = [form.alphabet.text(side) for pair in form.pairs for side in pair]
    assert all(any(n in re.findall(r"\w+", row) for row in rows) for n in names)


def test_a_name_that_the_user_has_is_not_taken() -> None:
    assert "where" in str(vo.derive(vo.load("demchenko")))
    taken = [line.split()[0] for line in str(vo.derive(sled("K", "L"))).splitlines() if "=" in line]
    assert not {"K", "L", "D", "J"} & {*taken}


@pytest.mark.slow
def test_a_false_identity_is_not_printed(monkeypatch: pytest.MonkeyPatch) -> None:
    """A move that changes what is said is found by the proof, and the exact form stays."""
    system, fresh = vo.load("falling-disc"), {}
    fresh["true"] = str(vo.derive(replace(system)))

    def wrong(self: Any, rule: Any, terms: Any) -> Any:
        return {m: 2 * c if len(m) == 3 else c for m, c in list(terms.items())[1:]}

    monkeypatch.setattr("voronec.equations.readable.FormSearch.apply_rule", wrong)
    fresh["attacked"] = str(vo.derive(replace(system)))
    assert fresh["attacked"] != fresh["true"]
    text = printed(vo.derive(replace(system)))
    for residual in residuals(system, text):
        assert vo.prove_equal(residual, 0).proved


@pytest.mark.slow
def test_latex_is_set_as_a_book_sets_it() -> None:
    text = vo.derive(vo.load("sleigh")).latex(names=True)
    assert r"(J + m a^2) \dot w &= -m a v w" in text and r"\dot x &= v \cos\phi" in text
    text = vo.derive(vo.load("two-wheeled-carriage")).latex(names=True)
    assert r"\dot{\mathrm{left}} &=" in text and r"\dot\mathrm" not in text  # which TeX cannot set
    text = vo.derive(vo.load("ball-on-paraboloid")).latex(names=True)
    assert text.startswith(r"\begin{align}") and r"\text{where}\quad" in text
    for word in (r"\frac{d}{d t}", r"{\left(\phi", r"\operatorname", "sqrt("):
        assert word not in text


CATALOGUE = (
    "suslov snakeboard veselova ball-on-sphere robot-with-two-trailers ellipsoid-on-plane "
    "ball-on-sphere-in-rn ball-on-paraboloid"
)


@pytest.mark.slow
@pytest.mark.parametrize("name", CATALOGUE.split())
def test_lines_of_the_catalogue_fit(name: str) -> None:
    """Equations and curvature; what a user declares stands above, as it is declared."""
    lines = str(vo.derive(vo.load(name))).splitlines()
    assert all(len(line) <= 100 for line in lines)
    start = next(i for i, line in enumerate(lines) if re.match("motion of|equations of", line))
    rows = re.sub(r"\n {6}", " ", "\n".join(lines[start:])).splitlines()
    assert max(map(depth, rows)) <= 3
    for line in lines[start:]:  # what goes on in another line is broken outside of brackets
        assert line.count("(") == line.count(")")


@pytest.mark.slow
@pytest.mark.parametrize("name", CATALOGUE.split())
def test_names_are_defined_in_the_order_of_reading_and_begin_without_a_minus(name: str) -> None:
    form = readable(vo.derive(vo.load(name)))
    text, met = form.alphabet.text, set[str]()
    names = [text(left) for left, _ in form.names]
    for left, right in form.names:
        words = {*re.findall(r"\w+", text(right))}
        assert not text(right).startswith("-") and words & {*names} <= met
        met.add(text(left))
    assert not any(text(row.left).startswith("-") for row in form.rows)


@pytest.mark.slow
def test_accelerations_stand_on_the_left_and_are_in_no_name() -> None:
    form = readable(vo.derive(vo.load("ball-on-free-sphere")))
    dots = "omega1dot omega2dot omega3dot W1dot W2dot W3dot".split()
    for i, row in enumerate(form.rows):
        left, others = form.alphabet.text(row.left), [row.right, *(e for _, e in form.names)]
        assert dots[i] in left and f"- ({dots[i]}" not in left
        assert not any(dot in form.alphabet.text(side) for side in others for dot in dots)


@pytest.mark.parametrize("name", ["robot-with-two-trailers", "ball-on-paraboloid"])
def test_the_curvature_is_printed_with_the_names_of_the_equations(name: str) -> None:
    eqs = vo.derive(vo.load(name))
    text = str(eqs)
    equations, _, below = text.partition("curvature\n")
    rows = re.findall(r"^ +(\S+) += (.*)$", equations.partition("\nwhere\n")[2] + below, re.M)
    names = {read(a): read(b) for a, b in rows if a.isalnum()}
    base, fibres = eqs.definition.split
    shown = re.findall(r"^ +A\^(\w+)\[(\w+), (\w+)\] += (.*)$", below, re.M)
    assert shown and names
    for fibre, p, q, entry in shown:
        found = read(entry)
        for _ in names:
            found = found.xreplace(names)
        place = [[*map(str, base)].index(x) for x in (p, q)]
        exact = eqs.curvature[[*map(str, fibres)].index(fibre), *place]
        assert vo.prove_equal(found, exact).proved
