"""What the verdicts of a section rest on: change it, and they are made anew."""

from __future__ import annotations

import importlib
import shutil
import sys
from dataclasses import replace
from importlib import metadata

import pytest
import sympy as sp

import voronec as vo
from voronec.audit import Check, Display, Section, Sentence, Study, Verdict
from voronec.audit.cache import Basis
from voronec.declaration import source_digest as sources

pytestmark = pytest.mark.slow

FILES = {
    "__init__.py": "",
    "paper.py": """
from voronec.audit import Display, Section

def studies(_):
    from .study import made

    return made()

SECTION = Section("s", (Display("$x=x$"),), studies)
""",
    "study.py": """
import sheet_neighbour
from sheet_package.deep import VALUE
from voronec import load

def made():
    load("sleigh")
    return {}
""",
    "deep.py": "VALUE = 1",
    "unused.py": "",
}


@pytest.fixture
def package(tmp_path, monkeypatch):
    folder = tmp_path / "sheet_package"
    folder.mkdir()
    for name, text in FILES.items():
        (folder / name).write_text(text)
    (folder / "sheet_neighbour.py").write_text("")
    monkeypatch.syspath_prepend(str(tmp_path))
    yield folder
    for name in [n for n in sys.modules if n.startswith("sheet_")]:
        del sys.modules[name]


def section_of(package):
    return importlib.import_module("sheet_package.paper").SECTION


@pytest.mark.parametrize(
    ("file", "matters"),
    [
        ("paper.py", True),
        ("study.py", True),
        ("deep.py", True),
        ("sheet_neighbour.py", True),
        ("unused.py", False),
    ],
)
def test_what_the_functions_import_matters_and_nothing_else(package, file, matters):
    before = Basis.of(section_of(package)).digest()
    with (package / file).open("a") as stream:
        stream.write("\n# changed")
    assert (Basis.of(section_of(package)).digest() != before) == matters


def test_a_system_that_is_loaded_by_name_matters(package):
    files = [f.name for f in Basis.of(section_of(package)).files]
    assert "sleigh.py" in files
    assert "chaplygin_ball" not in "".join(files)


def test_a_system_that_the_second_paper_loads_matters():
    paper = importlib.import_module("voronec.systems.chaplygin_ball.paper").PAPER
    files = Basis.of(paper.sections[0]).files
    assert {(f.parent.name, f.name) for f in files} >= {
        ("chaplygin_ball", "paper.py"),
        ("chaplygin_ball", "__init__.py"),
    }


def studies(_):
    return {"only": Study({"x": sp.Symbol("x")})}


def decide(study, where):
    return Verdict("proved", "so")


PLAIN = Section(
    "s",
    (Display("$x=x$", (Check(),)),),
    studies,
    inline=(Display("$x=x$"),),
    sentences=(Sentence("so", decide),),
)


@pytest.mark.parametrize(
    "changed",
    [
        replace(PLAIN, title="t"),
        replace(PLAIN, displays=(Display("$x=x+0$", (Check(),)),)),
        replace(PLAIN, displays=(Display("$x=x$", (Check("definition"),)),)),
        replace(PLAIN, displays=(Display("$x=x$", (Check(given=("a",)),)),)),
        replace(PLAIN, displays=(Display("$x=x$", (Check(proposal="x=x"),)),)),
        replace(PLAIN, inline=()),
        replace(PLAIN, sentences=()),
        replace(PLAIN, sentences=(Sentence("so", decide, within=("a",)),)),
    ],
)
def test_every_declaration_matters(changed):
    assert Basis.of(changed).digest() != Basis.of(PLAIN).digest()


@pytest.mark.parametrize(
    ("file", "matters"),
    [
        ("decider.py", True),
        ("algebra/__init__.py", True),
        ("algebra/x.py", True),
        ("late.py", True),
        ("several.py", True),
        ("typed.py", False),
        ("apart.py", False),
    ],
)
def test_what_the_decider_imports_matters_and_nothing_else(tmp_path, monkeypatch, file, matters):
    before = tmp_path / "before"
    (before / "algebra").mkdir(parents=True)
    for name in ("__init__", "algebra/__init__", "late", "several", "typed", "apart"):
        (before / f"{name}.py").write_text("")
    (before / "algebra/x.py").write_text(
        "def late():\n    from voronec import late\n    return late\n"
    )
    (before / "decider.py").write_text(
        "from voronec.algebra import x\nfrom voronec.several import (\n    a,\n    b,\n)\n"
        "if TYPE_CHECKING:\n    from voronec.typed import T\n"
    )
    after = tmp_path / "after"  # another folder: what a file says is remembered
    shutil.copytree(before, after)
    with (after / file).open("a") as stream:
        stream.write("# changed")
    digests = set()
    for folder in (before, after):
        monkeypatch.setattr(sources, "engine_folder", lambda folder=folder: folder)
        digests.add(sources.engine_digest.__wrapped__(frozenset(("voronec.decider",))))
    assert (len(digests) == 2) == matters


def test_what_a_file_takes_from_the_package_matters():
    used = set(
        sources.modules_in("import voronec as vo\nfrom voronec import System\nvo.descend(1)\n")
    )
    assert {"voronec", vo.System.__module__, vo.descend.__module__} == used


@pytest.mark.parametrize("library", sources.LIBRARIES)
def test_the_libraries_matter(monkeypatch, library):
    monkeypatch.setattr(sources, "platform_text", sources.platform_text.__wrapped__)
    before = sources.digest("", [], "voronec.errors")
    known = metadata.version
    monkeypatch.setattr(metadata, "version", lambda n: "none" if n == library else known(n))
    assert sources.digest("", [], "voronec.errors") != before


def test_the_engine_is_this_package():
    assert sources.engine_folder().joinpath("__init__.py").samefile(vo.__file__)
