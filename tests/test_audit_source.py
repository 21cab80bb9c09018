"""What a derived side was made from is named, and it is not the print typed once more."""

from __future__ import annotations

import ast
import json
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
import sympy as sp
from voronec.systems.demchenko import v
from voronec.systems.demchenko.dictionary.chaplygin_balls import KAPPA, R1, SIGNED_RADIUS, Ball
from voronec.systems.demchenko.dictionary.quadratures import level
from voronec.systems.demchenko.dictionary.rubber_balls import Rubber

import voronec as vo
from voronec.audit import Check, Display, Paper, Section, Study, Transcript, audit_paper, load_paper
from voronec.audit.latex.nodes import Listing, Node, Number, Power, Product, Quotient, Sum, walk
from voronec.audit.page.report import audit_page

pytestmark = pytest.mark.slow

DICTIONARY = Path(__file__).resolve().parent.parent / "systems" / "demchenko" / "dictionary"
REPORT = DICTIONARY.parents[2] / "docs" / "audit" / "demchenko"
SMALL = 2
"""Operations in a value: fewer are a name, or a sign."""


def typed(folder: Path) -> Iterator[tuple[str, ast.expr]]:
    """Every name of a dictionary that is given as an expression, and the expression."""
    for file in sorted(folder.glob("*.py")):
        for node in ast.walk(ast.parse(file.read_text("utf-8"))):
            if isinstance(node, ast.Dict):
                for key, value in zip(node.keys, node.values, strict=True):
                    if isinstance(key, ast.Constant) and isinstance(key.value, str):
                        yield key.value, value


def operations(node: ast.expr) -> Counter[str]:
    """How often a Python expression adds, multiplies, divides, and takes powers and products."""
    names = {ast.Add: "+", ast.Sub: "+", ast.Mult: "*", ast.Div: "/", ast.Pow: "^"}
    found = Counter(
        names[type(n.op)]
        for n in ast.walk(node)
        if isinstance(n, ast.BinOp) and type(n.op) in names
    )
    calls = [n.func.attr for n in ast.walk(node)
             if isinstance(n, ast.Call) and isinstance(n.func, ast.Attribute)]  # fmt: skip
    found["()"] += sum(name in ("dot", "cross") for name in calls)
    return +found


def printed_operations(node: Node) -> Counter[str]:
    """The same of a printed side; a half is a division."""
    found: Counter[str] = Counter()
    for part in walk(node):
        if isinstance(part, Sum):
            found["+"] += len(part.terms) - 1
        elif isinstance(part, Product):
            halves = sum(isinstance(f, Quotient) and _is_number(f.top) for f in part.factors)
            found["*"] += len(part.factors) - 1 - halves
        elif isinstance(part, Quotient):
            found["/"] += 1
        elif isinstance(part, Power):
            found["^"] += 1
        elif isinstance(part, Listing):
            found["()"] += 1
    return +found


def _is_number(node: Node) -> bool:
    return isinstance(node, Number)


def retyped(section: Section, given: dict[str, list[Counter[str]]], study: Study) -> Iterator[str]:
    """Claims whose left side is a name, given in the dictionary by the operations of the print."""
    for formula in Transcript(section).formulas():
        if formula.display.check(formula.position).role != "claim":
            continue
        try:
            chain = formula.tree(study.vocabulary)
            key = study.key(chain.parts[0])
        except vo.DefinitionError:
            continue
        for part in chain.parts[1:]:
            shape = printed_operations(part)
            if sum(shape.values()) >= SMALL and shape in given.get(key, []):
                yield key


def test_no_name_of_a_dictionary_is_given_by_the_operations_of_the_print_that_it_is_to_prove():
    draft = Study({})
    given: dict[str, list[Counter[str]]] = {}
    for name, value in typed(DICTIONARY):
        try:
            key = draft.key(draft.tree(name))
        except vo.DefinitionError:
            continue
        given.setdefault(key, []).append(operations(value))
    assert len(given) > 50
    found = {n for s in load_paper("demchenko").sections for n in retyped(s, given, draft)}
    assert found == set()
    twin = Section("s", (Display("$F=\\frac12(G,\\omega)$"),), lambda _: {})
    given = {"F": [operations(ast.parse("G.dot(omega) / 2", mode="eval").body)]}
    assert list(retyped(twin, given, draft)) == ["F"]


def test_every_record_that_is_compared_names_its_source():
    records = json.loads((REPORT / "report.json").read_text("utf-8"))
    formulas = [f for record in records for f in record["formulas"]]
    assert all(
        f["source"] for f in formulas if f["verdict"] in ("proved", "convention", "misprint")
    )
    assert not any(f["source"] for f in formulas if f["verdict"] == "definition")


def test_a_source_is_the_check_s_the_study_s_or_the_derived_system():
    eqs = vo.derive(vo.load("sleigh"))
    names = {"T": eqs.theta, "v": eqs.velocities[0]}
    studies = {"own": Study(names, context=eqs), "said": Study(names, source="a source")}
    checks = (Check(), Check(study="said"), Check(study="said", source="a theorem"))
    displays = tuple(Display("$v+T=T+v$", (check,)) for check in checks)
    paper = Paper("p", "T", (Section("S", displays, lambda _: studies),))
    audit = audit_paper(paper)
    wanted = ["the equations derived for the system 'sleigh'", "a source", "a theorem; a source"]
    assert [r.as_dict()["source"] for r in audit.records] == wanted
    assert "Compared with: a theorem; a source." in audit_page(audit, [])


@pytest.mark.parametrize(
    ("on", "which"), [(Ball.on_sphere, R1), (Ball.on_plane, KAPPA), (Ball.on_sphere, SIGNED_RADIUS)]
)
def test_the_integrals_of_the_ball_are_found_and_constant(on, which):
    ball = on(which)
    for name, value in ball.integral_forms.items():
        assert ball.constant(value).proved
        assert vo.prove_equal(value, ball.integrals[name], ball.relations).proved
    assert ("F_4" in ball.integral_forms) == (ball.epsilon == 1)


def test_a_ball_of_other_equations_has_no_such_integrals():
    ball = Ball.on_plane()
    mass = ball.reduced.mass.as_mutable()
    mass[0, 0] *= 2
    other = replace(ball, reduced=replace(ball.reduced, mass=mass.as_immutable()))
    assert vo.prove_equal(
        other.integral_forms["F_3"], other.integrals["F_3"], ball.relations
    ).refuted


def test_the_third_component_is_the_one_that_the_engine_eliminates():
    rubber = Rubber.on_sphere(R1)
    assert rubber.no_twist.proved
    rates = rubber.reduced.rates.as_mutable()
    rates[0] += sp.Symbol("omega1")
    other = replace(rubber, reduced=replace(rubber.reduced, rates=rates.as_immutable()))
    assert other.no_twist.refuted
    with pytest.raises(vo.DefinitionError, match="omega_3 is not what was eliminated"):
        other.study()


def test_phi_is_not_taken_from_the_rate_that_it_is_to_prove():
    found = level()
    rates = {**found.motion.rates, v: 2 * found.motion.rates[v]}
    other = replace(found, motion=replace(found.motion, rates=rates))
    assert other.rate(v) == 2 * found.rate(v)
    assert vo.prove_equal(other.phi, found.phi).proved
