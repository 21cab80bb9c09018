"""Functions, classes, constants and files of the package, the systems and the tools are named by
nouns for values and verbs for work, no participles."""

import ast
import re
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[1]
PACKAGE, TOOLS, SYSTEMS = ROOT / "voronec", ROOT / "tools", ROOT / "systems"
TRAILING = set("about at back by down from in of off on out over through to under up with".split())
IRREGULAR = set(
    "begun bent broken brought built chosen done drawn driven felt found frozen given gone "
    "grown handwritten held hidden kept laid led left lost made met rewritten said seen sent "
    "shown shrunk spent spoken spun stood stuck sung taken thought thrown told woven "
    "wound written".split()
)
"""Participles without an ending of their own; `bound`, `known` and `unknown` are nouns, too."""
BANNED = {"given", "ready", "rest", "seen", "settled", "told"}
NOUNS = set(
    "anything beginning binding building closing conditioning drawing embedding everything finding "
    "heading inequality lifting listing meaning mending nothing opening ordering padding reading "
    "ring rolling rounding sampling scaling setting something spacing spelling string swing "
    "testing timing winding wording hatching mapping bed feed hundred "
    "need red seed speed thread".split()
)
"""Words that end as participles do, and are nouns."""
WORDS_OF_THE_PUBLIC = {
    # attributes and methods that the documentation shows: verdicts, what a family declares
    "Corrected", "Enclosed", "Measured", "Quoted", "Sampled",
    "admitted", "conserved", "declared", "exhausted", "forcing", "passed", "printed", "proved",
    "left", "refuted", "solved", "standing", "undecided",
}  # fmt: skip


def participle(name: str) -> str | None:
    """The participle that a name ends with, prepositions aside; None where there is none."""
    spaced = re.sub("(?<=[a-z])(?=[A-Z])", "_", name)
    words = [w for w in spaced.strip("_").lower().split("_") if w]
    if not words or words[0] in ("are", "has", "is"):
        return None
    while len(words) > 1 and words[-1] in TRAILING:
        words.pop()
    last = words[-1]
    if words[-2:] == ["at", "rest"]:  # of mechanics
        return None
    if last in BANNED | IRREGULAR:
        return last
    return last if re.search("(ed|ing)$", last) and last not in NOUNS else None


def definitions(node: ast.AST) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef]:
    """Functions and classes in a module, inner ones too; expressions hold none."""
    for inner in ast.iter_child_nodes(node):
        if isinstance(inner, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            yield inner
        if not isinstance(inner, ast.expr):
            yield from definitions(inner)


def _assigned(body: list[ast.stmt]) -> Iterator[str]:
    """Constants of a module, fields of a class."""
    for node in body:
        targets = node.targets if isinstance(node, ast.Assign) else []
        targets = [node.target] if isinstance(node, ast.AnnAssign) else targets
        for target in targets:
            yield from (n.id for n in ast.walk(target) if isinstance(n, ast.Name))


@cache
def names(folder: Path) -> list[tuple[str, str, str]]:
    """(file, name, kind) of every file, function, class, field and constant of a folder, but for
    names that are Python's own.  No tree is kept: millions of nodes would be searched for garbage
    in all tests that follow."""
    found = []
    for path in sorted(folder.rglob("*.py")):
        module = ast.parse(path.read_text("utf-8"))
        nodes = [*definitions(module)]
        classes = [node for node in nodes if isinstance(node, ast.ClassDef)]
        own = [(node.name, "class" if node in classes else "function") for node in nodes]
        own += [(name, "field") for node in classes for name in _assigned(node.body)]
        own += [(name, "value") for name in (path.stem, *_assigned(module.body))]
        place = path.relative_to(folder).as_posix()
        found += [(place, n, kind) for n, kind in own if not re.fullmatch("__.*__", n)]
    return found


@pytest.mark.parametrize(
    "name", ["settled", "_rewritten", "made_of", "carried_back", "moving", "MotionSeen"]
)
def test_participles_are_found(name):
    assert participle(name)


@pytest.mark.parametrize(
    "name", ["split_words", "is_closed", "closed_form", "speed", "meaning_of", "ClosedForm"]
)
def test_nouns_and_verbs_are_none(name):
    assert participle(name) is None


def test_no_field_is_a_bare_participle():
    """But for premises of studies and checks, which users pass by keyword."""
    found = {(file, name) for file, name, kind in names(PACKAGE) if kind == "field"}
    assert {one for one in found if one[1] in BANNED} <= {
        ("audit/study.py", "given"),
        ("audit/display.py", "given"),
        ("motion/steppers/heyoka_stepper.py", "given"),
    }


@pytest.mark.parametrize("folder", [PACKAGE, TOOLS, SYSTEMS], ids=lambda folder: folder.name)
def test_nothing_is_named_by_a_participle(folder):
    found = [(file, n) for file, n, kind in names(folder) if kind != "field" and participle(n)]
    assert [one for one in found if one[1] not in WORDS_OF_THE_PUBLIC] == []


def test_a_class_has_its_name_for_itself():
    """But for the sections of a paper and of motions, both of which users hold, and for parts of a
    formula, which messages call by the names of their classes."""
    counts = Counter(name for _, name, kind in names(PACKAGE) if kind == "class")
    assert {name for name, count in counts.items() if count > 1} == {
        "Elementary",
        "Integral",
        "Root",
        "Section",
    }


def bare_numbers(text: str) -> list[str]:
    """Constants of a module that are numbers of somebody's choice, and say neither below nor beside
    them what they are; those that follow each other may share what is said."""
    module, lines, found = ast.parse(text), text.splitlines(), list[str]()
    waiting: list[str] = []
    for node in module.body:
        targets = [t for t in getattr(node, "targets", []) if isinstance(t, ast.Name)]
        values = [*ast.walk(node.value)] if targets and isinstance(node, ast.Assign) else []
        plain = (ast.Constant, ast.Tuple, ast.Load, ast.BinOp, ast.operator, ast.UnaryOp, ast.USub)
        numbers = [v.value for v in values if isinstance(v, ast.Constant)]
        if numbers and all(isinstance(v, plain) for v in values):
            chosen = [n for n in numbers if isinstance(n, int | float) and n not in (0, 1)]
            if chosen and len(chosen) == len(numbers) and "#" not in lines[node.lineno - 1]:
                waiting.append(targets[0].id)
            continue
        said = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        found += [] if said else waiting
        waiting = []
    return found + waiting


def test_numbers_say_what_they_are_for():
    texts = {p: p.read_text("utf-8") for p in PACKAGE.rglob("*.py")}
    found = {
        str(p.relative_to(PACKAGE)): bare for p, t in texts.items() if (bare := bare_numbers(t))
    }
    assert found == {}
    assert bare_numbers('A = 3\nB = (1e-5, 2)\n"""both"""\nC = 4  # of them\nD = -5\nE = "x"') == [
        "D"
    ]
