"""Functions, classes, constants and files, tools included, are named by nouns for values and verbs
for work, no participles."""

import ast
import re
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[1]
PACKAGE, TOOLS = ROOT / "voronec", ROOT / "tools"
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
    "Corrected", "Enclosed", "Measured", "Quoted",
    "admitted", "conserved", "declared", "exhausted", "forcing", "passed", "printed", "proved",
    "left", "refuted", "seen", "solved", "standing", "undecided",
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


def _constants(module: ast.Module) -> Iterator[str]:
    """Names that a module assigns at its top."""
    for node in module.body:
        targets = node.targets if isinstance(node, ast.Assign) else []
        targets = [node.target] if isinstance(node, ast.AnnAssign) else targets
        for target in targets:
            yield from (n.id for n in ast.walk(target) if isinstance(n, ast.Name))


@cache
def names(folder: Path) -> list[tuple[str, str, bool]]:
    """(file, name, whether a class has it) of every file, function, class and constant of a folder,
    but for names that are Python's own.  No tree is kept: millions of nodes would be searched for
    garbage in all tests that follow."""
    found = []
    for path in sorted(folder.rglob("*.py")):
        module = ast.parse(path.read_text("utf-8"))
        own = [(node.name, isinstance(node, ast.ClassDef)) for node in definitions(module)]
        own += [(name, False) for name in (path.stem, *_constants(module))]
        place = str(path.relative_to(folder))
        found += [(place, n, is_class) for n, is_class in own if not re.fullmatch("__.*__", n)]
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


@pytest.mark.parametrize("folder", [PACKAGE, TOOLS], ids=lambda folder: folder.name)
def test_nothing_is_named_by_a_participle(folder):
    found = [(file, name) for file, name, _ in names(folder) if participle(name)]
    assert [one for one in found if one[1] not in WORDS_OF_THE_PUBLIC] == []


def test_a_class_has_its_name_for_itself():
    """But for the sections of a paper and of motions, both of which users hold, and for parts of a
    formula, which messages call by the names of their classes."""
    counts = Counter(name for _, name, is_class in names(PACKAGE) if is_class)
    assert {name for name, count in counts.items() if count > 1} == {
        "Elementary",
        "Integral",
        "Root",
        "Section",
    }
