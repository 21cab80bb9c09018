"""Who may import whom, and what is packaged: pyproject.toml says so, and a breach is noticed."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from tool_modules import tool

ROOT = Path(__file__).parents[1]
LINT = "from importlinter.cli import lint_imports_command as run; run()"


def lint(folder: Path) -> subprocess.CompletedProcess[str]:
    words = [sys.executable, "-c", LINT, "--config", "pyproject.toml", "--no-cache"]
    return subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)


def test_lower_layers_never_import_upper_ones() -> None:
    answer = lint(ROOT)
    assert answer.returncode == 0, answer.stdout


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


def test_every_folder_of_code_is_packaged() -> None:
    setup = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    places = {name: ROOT / folder for name, folder in setup["package-dir"].items()}
    found = set()
    for name, folder in places.items():
        for init in folder.rglob("__init__.py"):
            found.add(".".join([name, *init.parent.relative_to(folder).parts]))
    assert found == set(setup["packages"])
