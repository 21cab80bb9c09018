"""The documentation says what is so: its examples run, its map of the tree is complete."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from voronec.cli.arguments import command_parser

ROOT = Path(__file__).resolve().parent.parent
PAGES = sorted((ROOT / "docs").glob("*.md"))
BLOCKS = [
    pytest.param(block, id=f"{page.stem}-{number}")
    for page in PAGES
    for number, block in enumerate(re.findall(r"```python\n(.*?)```", page.read_text(), re.DOTALL))
]


@pytest.mark.parametrize("block", BLOCKS)
def test_examples_run(block: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    exec(compile(block, "example", "exec"), {"__name__": "example"})


def test_every_command_and_option_is_described() -> None:
    page = (ROOT / "docs" / "commands.md").read_text()
    for name, options in _commands(command_parser()):
        assert re.search(rf"`(search )?{name}\b", page), name
        for option in options:
            assert option == "--help" or option in page, f"{name} {option}"


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


def test_theory_numbers_what_the_code_cites() -> None:
    numbered = set(
        re.findall(r"\((\d+)\)$", (ROOT / "docs" / "theory.md").read_text(), re.MULTILINE)
    )
    for file in (ROOT / "voronec").rglob("*.py"):
        for cited in re.findall(r"\[Theory, eqs?\. ([^\]]*)\]", file.read_text()):
            assert set(re.findall(r"\((\d+)\)", cited)) <= numbered, file


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
