"""The site: its reference has every public name, and no link of it leads nowhere."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from tool_modules import tool

import voronec
from voronec import kinematics, testing


@pytest.fixture(name="build", scope="module")
def _build():
    return tool("pages.site")


def test_the_reference_has_every_public_name_once(build) -> None:
    text = "".join(build.reference_pages().values())
    found = re.findall(r"^\.\. \w+:: (\S+)$", text, re.MULTILINE)
    expected = [f"voronec.{name}" for name in voronec.__all__ if name != "kinematics"]
    expected += [f"voronec.kinematics.{name}" for name in kinematics.__all__]
    expected += [f"voronec.testing.{name}" for name in testing.__all__]
    assert sorted(found) == sorted(expected)


def test_notebooks_for_jupyter_hold_the_cells_of_their_pages(build) -> None:
    nbformat = pytest.importorskip("nbformat")
    for page in (Path(build.DOCS) / "notebooks").glob("[!i]*.md"):
        text = page.read_text("utf-8")
        notebook = build.notebook_of(text)
        nbformat.validate(nbformat.from_dict(notebook))
        code = ["".join(c["source"]) for c in notebook["cells"] if c["cell_type"] == "code"]
        assert code == [cell.strip() for cell in build.CELL.findall(text)] and code
        words = ["".join(c["source"]) for c in notebook["cells"] if c["cell_type"] == "markdown"]
        assert words[0].startswith("# ") and not any("code-cell" in part for part in words)


def test_systems_with_shapes_have_a_motion_on_their_page(build, tmp_path: Path) -> None:
    there, none = (tmp_path / f"{name}-default.html" for name in ("sleigh", "rolling-body"))
    assert build.write_motion(there) and "<canvas" in there.read_text("utf-8")
    assert not build.write_motion(none) and not none.exists()  # its surfaces are not given


def test_links_that_lead_nowhere_are_found(build, tmp_path: Path) -> None:
    (tmp_path / "other.html").write_text('<p id="here">')
    good = '<a href="other.html#here"><a href="other.html"><a href="https://doi.org/10.1/x">'
    (tmp_path / "index.html").write_text(good)
    assert list(build.dead_links(tmp_path)) == []
    (tmp_path / "index.html").write_text('<a href="other.html#there"><img src="none.svg">')
    assert list(build.dead_links(tmp_path)) == [
        "index.html: other.html#there",
        "index.html: none.svg",
    ]
