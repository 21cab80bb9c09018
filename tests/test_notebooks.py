"""The tutorial and the notebooks run, cell by cell, and nothing that they show is long."""

from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import Any

import matplotlib as mpl
import pytest

DOCS = Path(__file__).parents[1] / "docs"
PAGES = [DOCS / "tutorial.md", *sorted((DOCS / "notebooks").glob("*.md"))]
NOTEBOOKS = [page for page in PAGES if "file_format: mystnb" in page.read_text("utf-8")]

CELL = re.compile(r"^```\{code-cell\}.*?\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def test_there_are_four_notebooks() -> None:
    assert len(NOTEBOOKS) == 1 + 4


@pytest.mark.slow
@pytest.mark.parametrize("page", NOTEBOOKS, ids=lambda page: page.stem)
def test_cells_run_and_show_little(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    mpl.use("agg")
    names: dict[str, Any] = {"__name__": "__main__"}
    cells = CELL.findall(page.read_text("utf-8"))
    assert cells
    for cell in cells:
        shown = _run(cell, names)
        assert repr(shown).count("\n") < 40
        for form in ("_repr_html_", "_repr_latex_"):
            assert isinstance(getattr(shown, form, str)(), str | None), (cell, form)


def _run(cell: str, names: dict[str, Any]) -> Any:
    """Run a cell, and return what its last line shows."""
    tree = ast.parse(cell)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "cell", "exec"), names)
    return eval(compile(ast.Expression(last.value), "cell", "eval"), names) if last else ""
