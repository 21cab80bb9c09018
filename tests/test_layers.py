"""Who may import whom, and what is packaged: pyproject.toml says so, and a breach is noticed.

Tests stand on public names, and on those of a room's front, so that rooms can be rebuilt.
"""

from __future__ import annotations

import ast
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterable, Iterator
from functools import cache
from importlib import import_module
from pathlib import Path

import pytest
from tool_modules import tool

import voronec

ROOT = Path(__file__).parents[1]
LINT = "from importlinter.cli import lint_imports_command as run; run()"


def lint(folder: Path) -> subprocess.CompletedProcess[str]:
    words = [sys.executable, "-c", LINT, "--config", "pyproject.toml", "--no-cache"]
    return subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)


def test_lower_layers_never_import_upper_ones() -> None:
    answer = lint(ROOT)
    assert answer.returncode == 0, answer.stdout


@pytest.mark.slow
def test_a_breach_is_noticed(tmp_path: Path) -> None:
    skip = shutil.ignore_patterns("__pycache__")
    for folder in ("voronec", "systems"):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=skip)
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    breaches = {
        "voronec/declaration/geometry.py": "import voronec.equations.definition",
        "voronec/equations/referee/plan.py": "import voronec.equations.connection",
        "systems/sleigh.py": "import voronec.equations\nimport systems.bicycle",
        "voronec/declaration/catalogue.py": "import systems.sleigh",
    }
    for path, line in breaches.items():
        with (tmp_path / path).open("a") as file:
            file.write(line + "\n")
    answer = lint(tmp_path)
    assert answer.returncode == 1
    assert "Contracts: 0 kept, 5 broken." in answer.stdout


@pytest.mark.slow
def test_modules_import_one_another_in_no_circle() -> None:
    house = tool("measure_house")
    graph = house.imports()
    assert "voronec.motion.viewer.page" in graph["voronec.motion.trajectory"]  # inside a function
    assert house.circles(graph) == []
    assert house.circles({"a": {"b"}, "b": {"c"}, "c": {"b"}}) == [{"b", "c"}]


@pytest.mark.slow
def test_folders_of_motion_are_entered_by_their_fronts() -> None:
    house = tool("measure_house")
    graph = house.imports()
    assert house.past_fronts("motion", graph) == []
    graph["voronec.motion.solve"] |= {"voronec.motion.steppers", "voronec.motion.steppers.run"}
    graph["voronec.motion.transitions.modes"] |= {"voronec.motion.transitions.splits"}
    pair = ("voronec.motion.solve", "voronec.motion.steppers.run")
    assert house.past_fronts("motion", graph) == [pair]


def test_every_folder_of_code_is_packaged() -> None:
    setup = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    places = {name: ROOT / folder for name, folder in setup["package-dir"].items()}
    found = set()
    for name, folder in places.items():
        for init in folder.rglob("__init__.py"):
            found.add(".".join([name, *init.parent.relative_to(folder).parts]))
    assert found == set(setup["packages"])


@cache
def nodes(text: str) -> tuple[ast.AST, ...]:
    """The syntax of a module, for all tests that look at it."""
    return tuple(ast.walk(ast.parse(text)))


PRIVATE = re.compile(r"(?:def |class |^ *|self[.])(_[A-Za-z]\w*)(?<!_)\b", re.MULTILINE)
"""Where private names are defined; `_repr_html_` and its like are protocols of others."""


def private_names(paths: Iterable[Path]) -> set[str]:
    return {name for path in paths for name in PRIVATE.findall(path.read_text("utf-8"))}


def reaches(text: str, names: set[str]) -> Iterator[str]:
    """Those of private names that a test imports, asks of an object, or writes as a string; it may
    ask for what its own classes define."""
    own = set(re.findall(r"self[.](_\w+) =|^ +def (_\w+)", text, re.M))
    for node in nodes(text):
        found: list[str] = []
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("voronec."):
            found = [*node.module.split("."), *(alias.name for alias in node.names)]
        elif isinstance(node, ast.Attribute) and not any(node.attr in pair for pair in own):
            found = [node.attr]
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            found = [node.value.rpartition(".")[2]]
        yield from (name for name in found if name in names)


@pytest.mark.slow
def test_tests_reach_no_private_name_of_the_house() -> None:
    folders = [ROOT / folder for folder in ("voronec", "systems", "tools")]
    names = private_names(p for folder in folders for p in folder.rglob("*.py"))
    texts = {p.name: p.read_text("utf-8") for p in sorted((ROOT / "tests").rglob("*.py"))}
    assert len(names) > 1000
    assert [(n, *found) for n, text in texts.items() if (found := {*reaches(text, names)})] == []


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("from voronec.motion import _heap", 1),
        ("from voronec._heap import heap", 1),
        ("import voronec.motion as motion\nmotion._heap.clear()", 1),
        ("monkeypatch.setattr(motion, '_heap', {})", 1),
        ("monkeypatch.setattr('voronec.motion._heap', {})", 1),
        ("def _heap(): return motion._heap\n_heap()", 1),
        ("class Own:\n    def __init__(self):\n        self._heap = {}\nOwn()._heap", 0),
        ("pair._replace(a=1), system._repr_html_(), os._exit(1)", 0),
    ],
)
def test_a_reach_for_a_private_name_is_found(text: str, count: int) -> None:
    assert [*reaches(text, {"_heap"})] == ["_heap"] * count


@pytest.mark.slow
def test_an_underscore_says_what_is_private() -> None:
    """Fronts, and modules whose names are public, list these; inside of rooms an underscore says
    what a module keeps to itself, and none takes such a name from another."""
    listing, taken = set(), set()
    for path in (ROOT / "voronec").rglob("*.py"):
        for node in nodes(path.read_text("utf-8")):
            if isinstance(node, ast.Name) and node.id == "__all__":
                listing.add(path.name)
            elif isinstance(node, ast.ImportFrom):
                taken |= {a.name for a in node.names if re.match("_[a-z]", a.name, re.IGNORECASE)}
    assert listing == {"__init__.py", "testing.py", "errors.py"}
    assert taken == set()


INSIDE = (Path(__file__).parent / "inside_of_rooms.txt").read_text("utf-8").split()
"""Test files that take names from inside of rooms: none is added, and each that is mended goes."""


def inside(text: str) -> set[str]:
    """What a test imports, or names in a string to replace it, that is no public name and not in
    the ``__all__`` of a room, or of a folder in it."""
    found = set()
    for node in nodes(text):
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "voronec":
            found |= {f"{node.module}.{a.name}" for a in node.names if not _at_front(node, a.name)}
        elif isinstance(node, ast.Import):
            found |= {a.name for a in node.names if _is_room(a.name) and a.name.count(".") > 1}
        elif isinstance(node, ast.Constant) and re.fullmatch(r"voronec(\.\w+)+", str(node.value)):
            found |= {node.value} if _is_room(node.value) and node.value.count(".") > 1 else set()
    return found


def _is_room(module: str) -> bool:
    """Whether a module lies in a room: ``voronec.errors`` and ``voronec.systems`` do not."""
    parts = module.split(".")[1:2]
    return parts != ["systems"] and (ROOT / "voronec" / "".join(parts) / "__init__.py").is_file()


def _at_front(node: ast.ImportFrom, name: str) -> bool:
    module = node.module or ""
    if module == "voronec" or name in voronec.__all__ or not _is_room(module):
        return (ROOT / "voronec" / name).is_dir() <= (name in voronec.__all__)
    folder = (ROOT / Path(*module.split("."))).is_dir()
    return folder and name in getattr(import_module(module), "__all__", ())


def test_no_more_tests_take_names_from_inside_of_rooms() -> None:
    files = sorted((ROOT / "tests").rglob("*.py"))
    assert [p.stem for p in files if inside(p.read_text("utf-8"))] == INSIDE


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("import voronec as vo\nfrom voronec import System, errors, kinematics", 0),
        ("from voronec.errors import EngineLimit\nfrom voronec.systems.sleigh import SYSTEM", 0),
        ("from voronec.motion import Event\nfrom voronec.motion.request import Event", 0),
        ("from voronec.proof.check import Inventory\n'voronec.motion'", 0),
        ("from voronec import motion", 1),
        ("from voronec.motion import batches", 1),
        ("from voronec.motion.request import Guard, Namespace", 2),
        ("import voronec.motion.request as request", 1),
        ("monkeypatch.setattr('voronec.motion.batches.LONG', 3)", 1),
    ],
)
def test_a_name_from_inside_of_a_room_is_found(text: str, count: int) -> None:
    assert len(inside(text)) == count


def test_cases_that_others_show_are_tests() -> None:
    """What runs with ``--every`` alone: each line of the list names a test of tables."""
    lines = (ROOT / "tests" / "shown_by_others.txt").read_text("utf-8").splitlines()
    cases = [line for line in lines if line and not line.startswith("#")]
    assert cases and len({*cases}) == len(cases)
    for case in cases:
        file, _, name = case.partition("[")[0].partition("::")
        text = (ROOT / "tests" / file).read_text("utf-8")
        assert f"def {name}(" in text or f"{name} = conformance(" in text, case
