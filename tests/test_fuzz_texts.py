"""The fuzzer of texts: that it finds nothing, and that it would."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

import pytest
from tool_modules import tool

fuzz = tool("doors.run")
texts = sys.modules["doors.texts"]


@pytest.fixture
def opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.chdir(tmp_path)
    here = os.getcwd()
    yield lambda number: fuzz.open_door(7, number, "texts", tmp_path)
    os.chdir(here)


@pytest.mark.slow
def test_texts_are_refused_in_one_line_and_never_run(opened: Any) -> None:
    assert [found for found in map(opened, range(150)) if found[2]] == []


@pytest.mark.slow
def test_a_reader_that_runs_text_is_found(opened: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    def run(text: str, place: Path) -> Any:
        if "sin" in text:
            raise KeyError(text)
        return eval(text, {}) if text.startswith("__import__") else None

    monkeypatch.setattr(texts, "READERS", {"formula": run})
    wrong = {opened(number)[2].split(":")[0] for number in range(400)}
    assert {"text was run", "untyped"} <= wrong


def test_a_refusal_without_its_place_is_found(opened: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    def load(file: Path) -> Any:
        raise texts.DefinitionError(f"{file}: something is wrong")

    monkeypatch.setattr(texts.vo, "load", load)
    assert any("without its place" in opened(number)[2] for number in range(20))
