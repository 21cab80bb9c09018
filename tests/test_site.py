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


@pytest.fixture(name="source", scope="module")
def _source(build, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The source of the site, which takes ten seconds to write; nobody changes it."""
    folder = tmp_path_factory.mktemp("site") / "source"
    build.write_source(folder)
    return folder


def test_the_reference_has_every_public_name_once(build) -> None:
    text = "".join(build.reference_pages().values())
    found = re.findall(r"^\.\. \w+:: (\S+)$", text, re.MULTILINE)
    expected = [f"voronec.{name}" for name in voronec.__all__ if name != "kinematics"]
    expected += [f"voronec.kinematics.{name}" for name in kinematics.__all__]
    expected += [f"voronec.testing.{name}" for name in testing.__all__]
    assert sorted(found) == sorted(expected)


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


@pytest.mark.slow
def test_the_source_links_to_nothing_outside_of_the_documentation(source: Path) -> None:
    for page in source.glob("*.md"):
        assert "](../" not in page.read_text(), page.name
    for page, count in (("audit", 3), ("closed-form", 16)):
        text = (source / f"{page}.md").read_text()
        places = re.findall(rf"\]\(({page}/[^)]*)\)", text)
        assert len(set(places)) == count
        for place in places:
            assert (source / place).is_file(), place


@pytest.mark.slow
def test_the_site_carries_the_pages_of_a_dozen_motions(build, source: Path, tmp_path: Path) -> None:
    page = tmp_path / "source" / "how-to" / "view.md"
    page.parent.mkdir(parents=True)
    page.write_bytes((source / "how-to" / "view.md").read_bytes())
    build.add_motions(page, tmp_path / "html" / "motions")
    files = sorted(tmp_path.glob("html/motions/*.html"))
    assert len(files) == 13
    assert all(f.stat().st_size < 900_000 for f in files)
    assert list(build.dead_links(tmp_path / "html")) == []
    assert '<iframe src="../motions/demchenko-default.html"' in page.read_text()


@pytest.mark.slow
def test_the_index_names_every_page_and_systems_have_their_sketches(source: Path) -> None:
    entries = (source / "index.md").read_text().splitlines()
    assert {p.stem for p in source.glob("*.md")} - {"index"} <= {*entries}
    assert {f"reference/{p.stem}" for p in source.glob("reference/*.rst")} <= {*entries}
    tasks = (source / "how-to" / "index.md").read_text().splitlines()
    assert {p.stem for p in source.glob("how-to/*.md")} - {"index"} <= {*tasks}
    assert (
        "![The mechanism, seen from above](sleigh.svg)"
        in (source / "systems" / "sleigh.md").read_text()
    )
    assert (source / "systems" / "sleigh.svg").exists()
