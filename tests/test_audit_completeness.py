"""What a formula leaves unsaid: constraints that constrain too little, words that nobody reads."""

from __future__ import annotations

from dataclasses import replace

import pytest
import sympy as sp
from voronec.systems.demchenko.paper.ball import BALL
from voronec.systems.demchenko.paper.body import BODY
from voronec.systems.demchenko.paper.neumann import NEUMANN
from voronec.systems.demchenko.sentences.claims import residuals

import voronec as vo
from voronec.audit import (
    Check,
    Display,
    Motion,
    Paper,
    Quoted,
    Section,
    Sentence,
    Study,
    Transcript,
    Verdict,
    formulas_by_label,
)
from voronec.audit import audit_paper as audited
from voronec.audit.paper_audit import Work, items

pytestmark = pytest.mark.slow

x, y, z, xdot, ydot, zdot, xdd = sp.symbols("x y z xdot ydot zdot xdd")
CONSTRAINT = Check(constrains=1)


def disc() -> Study:
    """ydot = xdot sin z and zdot = xdot cos z, of which the first is singular nowhere."""
    constrained = {ydot: xdot * sp.sin(z), zdot: xdot * sp.cos(z)}
    rates = {x: xdot, y: constrained[ydot], z: constrained[zdot], xdot: xdd}
    names = {
        "t": vo.time,
        "x": x,
        "y": y,
        "z": z,
        r"\dot x": xdot,
        r"\dot y": ydot,
        r"\dot z": zdot,
    }
    return Study({**names, "a": sp.Symbol("a")}, motion=Motion(rates, constrained))


def verdict_of(
    latex: str, *checks: Check, study: Study | None = None, complete: bool = False
) -> str:
    """The verdict of one display."""
    here = study or disc()
    display = Display(latex, checks or (Check(),))
    section = Section("s", (display,), lambda _: {"only": here}, complete=complete)
    return audited(Paper("p", "P", (section,))).records[0].verdict


@pytest.mark.parametrize(
    ("second", "verdict"),
    [
        (r"\dot z=\dot x\cos z", "proved"),
        (r"\dot z+\dot y=\dot x\sin z+\dot x\cos z", "proved"),
        (r"2\dot y=2\dot x\sin z", "misprint"),
        (r"\dot y+\dot y\sin z=\dot x\sin z(1+\sin z)", "misprint"),
        (r"(\dot z-\dot x\cos z)^2=0", "misprint"),
        (r"\dot z\sin z=\dot x\cos z\sin z", "undecided"),  # nothing where sin z = 0
    ],
)
def test_a_second_constraint_has_to_constrain(second: str, verdict: str) -> None:
    display = rf"\[ \dot y=\dot x\sin z, \quad {second} \]"
    assert verdict_of(display, CONSTRAINT) == verdict


@pytest.mark.parametrize(
    ("second", "verdict"),
    [
        (r"\delta z=\delta x\cos z", "proved"),
        (r"\delta z-\delta y=\delta x\cos z-\delta x\sin z", "proved"),
        (r"2\delta y=2\delta x\sin z", "misprint"),
        (r"\delta y\cos z=\delta x\sin z\cos z", "misprint"),
        (r"\delta z\sin z=\delta x\cos z\sin z", "undecided"),  # nothing where sin z = 0
    ],
)
def test_a_second_condition_on_variations_has_to_constrain(second: str, verdict: str) -> None:
    free = sp.Symbol("dx")
    bound = {x: free, y: free * sp.sin(z), z: free * sp.cos(z)}
    study = replace(disc(), variations=bound)
    display = rf"\[ \delta y=\delta x\sin z, \quad {second} \]"
    assert verdict_of(display, CONSTRAINT, study=study) == verdict


def test_an_inequality_between_what_is_equal_says_too_little() -> None:
    study = replace(disc(), names={**disc().names, "P": 2 * x + y})
    for relation in (r"\ge", r"\le", r"\geq", r"\leq"):
        equal = f"$P{relation} x+y+x$"
        assert verdict_of(equal, study=study, complete=True) == "misprint"
        assert verdict_of(equal, study=study) == "undecided", "it is true"
    assert verdict_of(r"$P^2\ge -x^2$", study=study) == "proved"


def test_what_is_positive_in_the_chart_may_be_a_factor() -> None:
    display = r"\[ \dot y=\dot x\sin z, \quad \dot z\sin z=\dot x\cos z\sin z \]"
    chart = replace(disc(), positive=(sp.sin(z),))
    assert verdict_of(display, CONSTRAINT, study=chart) == "proved"


@pytest.mark.parametrize(
    ("printed", "verdict"), [("p=q", "proved"), ("(p,p)=(q,q)", "misprint"), ("q-p=0", "proved")]
)
def test_a_vector_says_as_much_as_its_components(printed: str, verdict: str) -> None:
    """p - q has two components along axes that turn by x, and none along the third."""
    slip = sp.Matrix([ydot - xdot * sp.sin(z), zdot - xdot * sp.cos(z), 0])
    c, s = sp.cos(x), sp.sin(x)
    turn = sp.Matrix([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    speed = sp.Matrix([xdot, 0, 0])
    study = disc()
    study = replace(study, names={**study.names, "p": turn * slip + speed, "q": speed})
    assert verdict_of(f"${printed}$", Check(constrains=2), study=study) == verdict


def test_a_constant_before_two_vectors_multiplies_their_product() -> None:
    a, b = (sp.Matrix(sp.symbols(f"{w}1:4")) for w in "ab")
    study = Study({"a": a, "b": b, "D": sp.Symbol("D")}, source="letters")
    right = "+".join(rf"Da_{i}b_{i}" for i in (1, 2, 3))
    entries = {f"{w}_{i}": v[i - 1] for w, v in (("a", a), ("b", b)) for i in (1, 2, 3)}
    study = replace(study, names={**study.names, **entries})
    assert verdict_of(rf"\[ D(a,b)={right} \]", study=study) == "proved"


def test_the_space_of_a_vector_is_read() -> None:
    text = r"\[ \frac{d}{dt}y=\dot x\sin z\quad \mathrm{for\;all}\quad \delta x\in T_x %s \]"
    known = replace(disc(), domains={r"\delta x": "T_xS"})
    assert verdict_of(text % "S", study=known) == "proved"
    assert verdict_of(text % "Q", study=known) == "misprint"
    assert verdict_of(text % "S") == "not read"  # nothing is known of it


@pytest.mark.parametrize(
    ("words", "verdict"),
    [
        (r"for\;all", "proved"),
        ("for every", "proved"),
        ("for any", "proved"),
        (r"for\;some", "misprint"),
        ("for no", "misprint"),
        ("for almost all", "not read"),
    ],
)
def test_the_quantifier_before_a_vector_is_read(words: str, verdict: str) -> None:
    known = replace(disc(), domains={r"\delta x": "T_xS"})
    text = rf"\[ \frac{{d}}{{dt}}y=\dot x\sin z\quad \mathrm{{{words}}}\quad \delta x\in T_xS \]"
    assert verdict_of(text, study=known) == verdict


def test_words_in_a_display_are_a_sentence() -> None:
    def decide(_: Study, __: object, *, n: int) -> Verdict:
        return Verdict("proved" if n == 2 else "refuted", str(n))

    line = Sentence(r"f\colon \text{of degree @n:number{two}}", decide)
    for word, verdict in (("two", "proved"), ("three", "misprint"), ("tow", "undecided")):
        display = rf"\[ f\colon \text{{of degree {word}}}, \]"
        assert verdict_of(display, Check(sentence=line)) == verdict


KEPT: dict[str, dict[str, Study]] = {}


def dictionaries(section: Section) -> dict[str, Study]:
    if section.title not in KEPT:
        KEPT[section.title] = dict(section.studies(Transcript(section)))
    return KEPT[section.title]


@pytest.mark.parametrize(
    ("section", "called", "old", "new"),
    [
        (
            NEUMANN,
            "(eq:nosliding2)",
            r"\sqrt{G_1}\dot v_1= \sqrt{E} \dot u \cos \vartheta + \sqrt{G} \dot v \sin \vartheta.",
            r"2\sqrt{E_1}\dot u_1= - 2\sqrt{E}\dot u\sin\vartheta+2\sqrt{G}\dot v\cos\vartheta.",
        ),
        (
            NEUMANN,
            "display 3",
            r"\text{of $M\mathbf u\mathbf v\mathbf n$ with respect to $M\mathbf u_1",
            r"\text{of $O\mathbf x\mathbf y\mathbf z$ with respect to $M\mathbf u_1",
        ),
        (
            BODY,
            "(varijacije)",
            r"\sqrt{G_1}\delta v_1 &=\sqrt{E}\delta u\cos\vartheta+\sqrt{G}\delta v\sin\vartheta",
            r"-\sqrt{E_1}\delta u_1 &=\sqrt{E}\delta u\sin\vartheta-\sqrt{G}\delta v\cos\vartheta",
        ),
        (BALL, "(uslovZh)", "C_1=A_1+A_2", r"C_1\ge A_1+A_2"),
        (
            BALL,
            "(4.2.2)",
            r"\dot{v}_1\sin{u}_1=\mu'\dot{u}\cos\vartheta+\mu'\dot{v}\sin\vartheta\sin u",
            r"\dot{u}_1\mu'=-\mu'^2\dot{u}\sin\vartheta+\mu'^2\dot{v}\cos\vartheta\sin u",
        ),
    ],
    ids=lambda value: value if isinstance(value, str) and len(value) < 20 else "",
)
def test_prints_of_the_paper_that_say_too_little(
    section: Section, called: str, old: str, new: str
) -> None:
    verdicts = []
    for print_ in (old, new):
        displays = tuple(replace(d, latex=d.latex.replace(old, print_)) for d in section.displays)
        page = replace(section, displays=displays)
        work = Work(page, formulas_by_label([page]), dictionaries(section), corrects=False)
        item = next(i for i in items(work.transcript) if i.designation == called)
        verdicts.append({e.record.verdict for e in work.examine(item)})
    assert verdicts[0] <= {"proved", "definition"}
    assert "misprint" in verdicts[1]


def test_an_inequality_in_the_place_of_an_equation_is_refused() -> None:
    assert residuals(Quoted("$x=a$"), disc()) == [x - sp.Symbol("a")]
    with pytest.raises(vo.DefinitionError, match="an inequality stands where an equation"):
        residuals(Quoted("$x<a$"), disc())
