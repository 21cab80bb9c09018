"""Fixtures that several files of tests use."""

from __future__ import annotations

from pathlib import Path

import pytest
from command_line import Answer, Call

from voronec.cli import main

# A package of somebody else: its tests run where it is installed, in ``test_conformance``.
collect_ignore = ["plugin_package"]


@pytest.fixture
def call(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Call:
    """Call ``voronec`` with words, in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def command(*words: str) -> Answer:
        capsys.readouterr()
        try:
            status = main(words)
        except SystemExit as end:  # argparse
            status = int(str(end.code))
        said = capsys.readouterr()
        return Answer(status, said.out, said.err)

    return command
