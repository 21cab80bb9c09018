"""The systems of the project pass the tests that those of others pass; a wrong one does not."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest
from plugins import install
from without_claims import bare

import voronec as vo
from voronec.declaration import catalogue
from voronec.errors import DefinitionError
from voronec.proof.check import Inventory
from voronec.proof.check.report import failure_line
from voronec.proof.check.unit import units_of
from voronec.proof.check.work import Derivations, examine
from voronec.testing import STATEMENTS, conformance

pytestmark = pytest.mark.slow

PLUGIN = Path(__file__).parent / "plugin_package"
STOCK = Inventory.of()
OWN = [e.name for e in catalogue.entries()[0] if e.distribution == catalogue.OWN]
RELATED = sorted(name for name in STOCK.graph if "@" in name)
SINGLE = {what: holds for what, holds in STATEMENTS.items() if what != "relations hold"}

test_conformance = conformance(*OWN, *RELATED, statements=SINGLE)


# Relations and squares one by one, each once, and not for each of its systems.
RELATIONS = {r.label: STOCK.relation(r) for r in STOCK.relations}
SQUARES = [u for u in units_of(STOCK) if u.kind == "square"]
BENCH = Derivations()
CARRYING = [
    "free-particle -> suslov",
    "symmetric-gyroscopic-ball-on-sphere -> gyroscopic-ball-on-sphere",
    "demchenko -> zhukovsky-ball",
    "chaplygin-ball-in-rn@3 -> chaplygin-ball-in-rn",
    "rubber-ball-in-new-time -> veselova-in-new-time",
    "veselova -> veselova-in-new-time",
    "vertical-disc -> two-wheeled-carriage",
    "sleigh on a turntable reversed",
]
"""Specialisations, limits, reductions, embeddings, changes of time, symmetries."""


@cache
def unclaimed(name):
    """A system that claims nothing: a relation to it carries nothing."""
    system = vo.load(name)
    return bare(system, invariants=system.invariants)


@pytest.mark.parametrize("label", RELATIONS)
def test_every_relation_holds(label):
    """What it carries then follows from the claims of its target, which are proved there."""
    relation = RELATIONS[label]
    found = vo.check_relation(relation, [*map(unclaimed, {relation.source, relation.target})])
    known = {**vo.load(relation.source).undecided, **vo.load(relation.target).undecided}
    assert found.kinds and (found.verdict.proved or label in known), found.verdict


@pytest.mark.parametrize("label", CARRYING)
def test_a_relation_carries_all_that_its_target_claims(label):
    """The second route to it: each is decided at the source."""
    target = vo.load(RELATIONS[label].target)
    found = vo.check_relation(RELATIONS[label])
    assert found.verdict.proved and found.pulled
    assert not [(c.name, c.verdict) for c in found.pulled if not c.verdict.proved]
    assert {c.name for c in found.pulled if c.kind == "integral"} == {*target.integrals}


@pytest.mark.parametrize("unit", SQUARES, ids=lambda u: u.name)
def test_every_square_commutes(unit):
    result = examine(unit, BENCH)
    assert not [failure_line(result, f) for f in result.failures]


def test_nothing_declared_is_broken():
    assert [(t.name, t.why) for t in STOCK.all_troubles if {t.name, t.owner} & {*OWN}] == []


# -- somebody else's package ---------------------------------------------------------------------


def test_a_package_of_somebody_else_runs_the_same_tests_with_three_lines(tmp_path: Path):
    assert len((PLUGIN / "test_plugin.py").read_text().splitlines()) == 3
    shutil.copytree(PLUGIN, tmp_path, dirs_exist_ok=True)
    install(tmp_path, "voronec-plugin", PLUGIN / "pyproject.toml")
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_plugin.py"],
        cwd=tmp_path, capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
    assert f"{len(STATEMENTS)} passed" in done.stdout


HOOP = (PLUGIN / "voronec_plugin" / "systems" / "plugin_hoop.py").read_text()
SHARED = "from voronec_plugin.systems._shared import R, m\n"


@pytest.mark.parametrize(
    ("change", "statement", "message"),
    [
        (('"energy": kinetic', '"energy": kinetic + x'), "claims hold", "'energy' is refuted"),
        (('integrals={"energy": kinetic},', ""), "claims hold", "claims nothing"),
        (("Hoop2000", "Hoops"), "references are known", "'Hoops' is not in"),
        (("phi: -phi", "phi: phi"), "relations hold", "'plugin-hoop mirrored' is refuted"),
        (('"free-particle"', '"free-partcle"'), "relations hold", "did you mean 'free-particle'"),
        (('title="A hoop on a line"', 'title=""'), "names are fine", "has no title"),
        (('"plugin-hoop",\n    title', '"Hoop",\n    title'), "names are fine", "'Hoop' is not"),
        (("(phi): 1}", '(phi): 1, "xdot": 1}'), "scenes run", "off the constraints"),
    ],
)
def test_the_kit_finds_what_is_wrong(tmp_path: Path, change, statement, message):
    file = tmp_path / "hoop.py"
    text = HOOP.replace(SHARED, 'R, m = sp.symbols("R m")\n')
    (tmp_path / "references.bib").write_text("@misc{Hoop2000,\n}\n")
    file.write_text(text)
    STATEMENTS[statement](str(file))
    assert change[0] in text
    wrong = tmp_path / "wrong.py"
    wrong.write_text(text.replace(*change))
    with pytest.raises((AssertionError, DefinitionError), match=message):
        STATEMENTS[statement](str(wrong))


BELT = """
import sympy as sp
import voronec as vo

x, y, v = sp.symbols("x y v")
u = sp.Function("u")(vo.time)
SYSTEM = vo.System(
    name="belt",
    title="A block on a belt that is steered",
    fibration=vo.Fibration(base=(x,), fibre=(y,)),
    lagrangian=(vo.velocity(x)**2 + vo.velocity(y)**2) / 2,
    constraints=(vo.velocity(y) - u*vo.velocity(x),),
    inputs=(u,),
    scenes={"default": vo.Scene({x: 0, vo.velocity(x): 1}, (0, 1), inputs={u: 2 + vo.time})},
)
"""


def test_systems_with_inputs_conform(tmp_path: Path) -> None:
    file = tmp_path / "belt.py"
    file.write_text(BELT)
    for what in ("routes agree at random points", "routes agree where scenes start", "scenes run"):
        STATEMENTS[what](str(file))


def test_the_kit_finds_equations_that_the_multipliers_refute(monkeypatch):
    from voronec import testing

    def wrong(system, point, digits):
        return {q: a + 1 for q, a in right(system, point, digits).items()}

    right = testing.multiplier_acceleration
    testing.routes_agree_at_random_points("sleigh")
    monkeypatch.setattr(testing, "multiplier_acceleration", wrong)
    with pytest.raises(AssertionError, match="'sleigh': the acceleration of x is"):
        testing.routes_agree_at_random_points("sleigh")
