"""The documentation says what is so: its examples run, its map of the tree is complete."""

from __future__ import annotations

import argparse
import json
import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import voronec
from voronec.cli import command_parser, main

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parent.parent
PAGES = sorted(p for folder in ("", "how-to") for p in (ROOT / "docs" / folder).glob("*.md"))
BLOCKS = [
    pytest.param(block, id=f"{page.stem}-{number}")
    for page in PAGES
    for number, block in enumerate(re.findall(r"```python\n(.*?)```", page.read_text(), re.DOTALL))
]


SHOWN = re.compile(
    r"^(?:    |\$ |.*(?:/bin/|\\Scripts\\))?voronec (.*)$|`voronec ([^`]*)`", re.MULTILINE
)
"""A command in a block of code, fenced or indented, or between backticks."""


@pytest.mark.parametrize("block", BLOCKS)
def test_examples_run(block: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if "import casadi" in block:
        pytest.importorskip("casadi", reason="CasADi is not installed: voronec[control]")
    monkeypatch.chdir(tmp_path)
    exec(compile(block, "example", "exec"), {"__name__": "example"})


def test_the_lecture_is_prepared_in_its_order(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its commands run as they stand, one after the other, and write what the page promises."""
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs" / "how-to" / "lecture.md").read_text()
    lines = [shlex.split(line) for line in re.findall(r"^ +voronec (.*)$", page, re.MULTILINE)]
    assert [line[0] for line in lines] == "new derive explain show run view judge".split()
    for line in lines:
        assert main(line) == 0, line
    written = {path.name: path for path in (tmp_path / "slides").iterdir()}
    assert {"derivation.tex", "derivation.html", "sketch.svg", "coin.gif"} <= written.keys()
    assert written["coin.gif"].read_bytes().startswith(b"GIF8")
    sliders = {e["name"]: e["slides"] for e in _page_data(written["my-coin.html"])["parameters"]}
    assert sliders["R"]  # which the address of the page sets


def _page_data(page: Path) -> Any:
    """What a page of a motion holds of it."""
    held = re.search(r"^const DATA = (.*);$", page.read_text("utf-8"), re.MULTILINE)
    assert held is not None
    return json.loads(held[1].replace("<\\/", "</"))


def test_every_command_and_its_options_are_described() -> None:
    page = (ROOT / "docs" / "commands.md").read_text()
    rows = dict(re.findall(r"^\| `((?:search )?\w+)(.*)$", page, re.MULTILINE))
    commands = {name.split()[-1]: row for name, row in rows.items()}
    there = dict(_commands(command_parser()))
    assert commands.keys() == there.keys() - {"search"}
    for name, row in commands.items():
        described = set(re.findall(r"`(--[a-z]+)", row))
        assert described == {*there[name]} - {"--help", "--json"}, name


@pytest.mark.parametrize("page", [ROOT / "README.md", *PAGES], ids=lambda page: page.stem)
def test_commands_that_are_shown_are_commands(page: Path) -> None:
    names = {"COMMAND", *dict(_commands(command_parser()))}
    text = page.read_text()
    shown = [found.group(1) or found.group(2) for found in SHOWN.finditer(text)]
    hidden = re.search(rf"\bvoronec (?:{'|'.join(names)})\b.*", SHOWN.sub("", text))
    assert hidden is None, f"a command stands where it is not looked for: {hidden and hidden[0]}"
    for line in shown:
        for alternative in line.split(" | "):
            words = shlex.split(alternative, comments=True)
            assert words[0] in names, line
            if len(words) > 1 and words[0] != "COMMAND":  # a bare name speaks of the command
                command_parser().parse_args(words)  # ends the test where it refuses


def test_outputs_of_the_readme_are_drawn_as_far_as_they_are_wanted(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    run = ["run", "demchenko", "--outputs", "u,v", "--times", "0:1:101", "--out", str(folder)]
    assert main(run) == 0
    assert (folder / "drawing.svg").exists()
    assert (folder / "trajectory.csv").read_text().startswith("t,u,v\n")


def test_public_names_of_motions_are_described() -> None:
    pages = "".join((ROOT / "docs" / page).read_text() for page in ("python.md", "scenes.md"))
    homes = ["motion"], ["closed"], ["accuracy"]
    modules = {name: getattr(getattr(voronec, name), "__module__", "") for name in voronec.__all__}
    names = [name for name, module in modules.items() if module.split(".")[1:2] in homes]
    assert [name for name in names if not re.search(rf"\b{name}\b", pages)] == []


def test_pages_cite_what_is_in_the_bibliography() -> None:
    known = set(re.findall(r"@\w+\{(\w+),", (ROOT / "docs" / "references.bib").read_text()))
    for page in (ROOT / "README.md", *PAGES):
        for key in re.findall(r"\[([A-Z][A-Za-z]+\d{4}\w*)\b", page.read_text()):
            assert key in known, f"{page.name}: {key}"


def _commands(parser: argparse.ArgumentParser) -> Iterator[tuple[str, list[str]]]:
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, command in action.choices.items():
                flags = [o for a in command._actions for o in a.option_strings]
                yield name, [o for o in flags if o.startswith("--")]
                yield from _commands(command)


def test_links_lead_somewhere() -> None:
    for page in (ROOT / "README.md", *PAGES, *(ROOT / "docs" / "systems").glob("*.md")):
        for link in re.findall(r"\]\(([\w./@-]+[./][\w./@-]+)[)#]", page.read_text()):
            assert (page.parent / link).exists(), f"{page.name}: {link}"


def test_the_architecture_names_every_module() -> None:
    page = (ROOT / "docs" / "architecture.md").read_text()
    parts = [p for p in (ROOT / "voronec").iterdir() if not p.name.startswith("__")]
    names = [
        p.name if p.suffix == ".py" else p.name + "/" for p in parts if p.suffix in ("", ".py")
    ]
    assert [name for name in names if f"`{name}`" not in page] == []


def test_every_file_that_the_architecture_names_is_there() -> None:
    """A bare name stands for a file in the folder named before it, or anywhere where none is."""
    page = (ROOT / "docs" / "architecture.md").read_text()
    files = [
        p.relative_to(ROOT) for d in ("voronec", "tests", "tools") for p in (ROOT / d).rglob("*.py")
    ]
    named = re.findall(r"`((?:\w+/)*\w+\.py)", page)
    assert [n for n in named if not any(f"/{f}".endswith(f"/{n}") for f in files)] == []


def test_the_five_walks_name_functions_that_are_there() -> None:
    page = (ROOT / "docs" / "architecture.md").read_text()
    walks = page.partition("## Five walks")[2].partition("## Files")[0].split("\n\n**")[1:]
    source = "\n".join(p.read_text() for p in (ROOT / "voronec").rglob("*.py"))
    known = {
        *re.findall(r"^ *(?:def|class) (\w+)", source, re.M),
        *re.findall(r"^[A-Z]+", source, re.M),
    }
    named = [re.findall(r"`(?:\w+\.)?(?!py`)(\w+)`", walk) for walk in walks]
    assert len(walks) == 5 and all(len(names) >= 10 for names in named)
    assert [name for names in named for name in names if name not in known] == []


def test_each_formula_of_the_theory_is_cited_where_it_is_computed() -> None:
    """Numbers rise by one, letters follow their number, and no range stands for what is in it."""
    theory, cited = (ROOT / "docs" / "theory.md").read_text(), set()
    numbered = re.findall(r"  \((\d+[a-d]?)\)$", theory, re.MULTILINE)
    whole = [int(n) for n in numbered if n.isdigit()]
    assert whole == list(range(1, len(whole) + 1))
    assert numbered == sorted(numbered, key=lambda n: (int(n.rstrip("abcd")), n))
    for file in (ROOT / "voronec").rglob("*.py"):
        for text in re.findall(r"\[Theory,\s+eqs?\.\s+([^\]]*)\]", file.read_text()):
            found = set(re.findall(r"\((\d+[a-d]?)\)", text))
            assert found <= set(numbered), file
            cited |= set() if " to " in text else found
    assert set(numbered) - cited == set()


def test_citations_are_in_the_bibliography() -> None:
    known = set(re.findall(r"@\w+\{(\w+),", (ROOT / "docs" / "references.bib").read_text()))
    for file in (ROOT / "voronec").rglob("*.py"):
        for key in re.findall(r"\[([A-Z][A-Za-z]+\d{4}),? ?", file.read_text()):
            assert key in known, f"{file}: {key}"


def test_nothing_names_one_machine() -> None:
    for folder in ("voronec", "systems", "tools", "docs", ".ci"):
        for file in (ROOT / folder).rglob("*"):
            if file.suffix in (".py", ".md", ".bib", "") and file.is_file():
                text = file.read_text()
                assert not re.search(r"(?<![\w.])/(work|root|home)/", text), file
