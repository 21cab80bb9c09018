"""Fixtures that several files of tests use."""

from __future__ import annotations

import gc
import os
from collections import Counter
from collections.abc import Generator
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path

os.environ.setdefault("SYMPY_CACHE_SIZE", "50000")  # what one test asked SymPy helps many others

import pytest
from command_line import Answer, Call

from voronec.cli import OBJECTS, main
from voronec.errors import DefinitionError
from voronec.motion.formulation import model_cache

gc.set_threshold(OBJECTS)  # as commands do

HEYOKA = find_spec("heyoka") is not None
with suppress(ImportError):
    import heyoka  # noqa: F401  # what tests compile is kept in its folder, which has room for all

# A package of somebody else: its tests run where it is installed, in ``test_conformance``.
collect_ignore = ["plugin_package"]
SHOWN_BY_OTHERS = Path(__file__).with_name("shown_by_others.txt")
"""Cases, and the cases beside them that show what they show."""


def shown_by_others() -> tuple[str, ...]:
    """How the names of those cases begin: ``test_file.py::test_name[case``."""
    lines = SHOWN_BY_OTHERS.read_text("utf-8").splitlines()
    return tuple(f"tests/{line}" for line in lines if line and not line.startswith("#"))


def pytest_addoption(parser: pytest.Parser) -> None:
    """How much is run of tables of cases and methods."""
    parser.addoption("--every", action="store_true", help="every case, by every method")


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Cases that others show are left out.  Of a table of cases and methods each case goes by one
    method, and each method has its share of them, in the file where a table has fewer cases than
    methods; those of a ``contract`` go by all of them.

    All go with ``--every``, and what is named one by one.
    """
    if config.getoption("every") or any("[" in word for word in config.args):
        return
    shown = shown_by_others()
    left = {item for item in items if item.nodeid.startswith(shown)}
    tables: dict[tuple[object, str], list[tuple[pytest.Item, int, tuple[int, ...]]]] = {}
    for item in items:
        if not isinstance(item, pytest.Function) or not hasattr(item, "callspec"):
            continue
        params = dict(item.callspec.params)
        if "method" in params and HEYOKA and not item.get_closest_marker("contract"):
            method, case = id(params.pop("method")), tuple(map(id, params.values()))
            tables.setdefault((item.parent, item.originalname), []).append((item, method, case))
    turns = Counter[object]()
    for (file, _), table in tables.items():
        methods = list(dict.fromkeys(method for _, method, _ in table))
        cases = list(dict.fromkeys(case for _, _, case in table))
        period = min(len(methods), len(cases))
        for k, case in enumerate(cases):
            rows = [i for i, m, c in table if c == case and (methods.index(m) - k) % period == 0]
            chosen = rows[turns[file] % max(len(rows), 1) :][:1]
            left |= {i for i, _, c in table if c == case and i not in chosen}
            turns[file] += 1
    config.hook.pytest_deselected(items=[*left])
    items[:] = [item for item in items if item not in left]


def pytest_sessionfinish() -> None:
    """What is left ends with the process, and pytest need not look through it five times."""
    gc.freeze()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call() -> Generator[None]:
    """Where heyoka does not install, as on macOS and Windows, what asks for it is left out."""
    try:
        yield
    except (DefinitionError, ModuleNotFoundError) as error:
        if "heyoka" in str(error) and not HEYOKA:
            pytest.skip("heyoka is not installed")
        raise


@pytest.fixture(autouse=True)
def no_kept_models(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a test changes in the engine must not reach models that are kept on disk."""
    monkeypatch.setattr(model_cache, "user_cache", lambda part: Path(os.devnull) / part)


@pytest.fixture
def no_corrections(monkeypatch: pytest.MonkeyPatch) -> None:
    """An audit gives verdicts alone: to search for a correction takes longer than the proofs."""
    monkeypatch.setattr("voronec.audit.judge.correct", lambda *_: None)


@pytest.fixture
def call(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Call:
    """Call ``voronec`` with words, in an empty folder and on a screen of known width."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")

    def command(*words: str) -> Answer:
        capsys.readouterr()
        try:
            status = main(words)
        except SystemExit as end:  # argparse
            status = int(str(end.code))
        said = capsys.readouterr()
        return Answer(status, said.out, said.err)

    return command
