"""What heyoka compiles is kept in a folder of ours, unless somebody else loaded it."""

from __future__ import annotations

import os
import pickle
import shutil
import subprocess
import sys
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path

import pytest

from voronec.motion.steppers import kept_code

pytest.importorskip("heyoka")

RUN = """
import voronec as vo
traj = vo.integrate(vo.load("sleigh"), times=1, method="heyoka")
print(traj.cost.method)
"""
pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the folder is named otherwise")


def run(code: str, cache: Path) -> subprocess.CompletedProcess[str]:
    """A script in a process whose user keeps caches there."""
    environment = os.environ | {"XDG_CACHE_HOME": str(cache)}
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=True
    )


@pytest.mark.slow
def test_programs_lie_in_our_folder_and_are_found_there(tmp_path: Path) -> None:
    size = "import heyoka\nprint(heyoka.llvm_state.get_diskcache_size())"
    first = run(RUN + size, tmp_path).stdout.split()
    assert first[0] == "heyoka" and int(first[1]) > 0
    assert any((tmp_path / "voronec" / "heyoka").iterdir())
    assert not (tmp_path / "heyoka").exists()
    assert run(RUN + size, tmp_path).stdout.split() == first  # nothing was compiled again


@pytest.mark.slow
def test_who_loads_heyoka_keeps_its_folder(tmp_path: Path) -> None:
    state = "heyoka.llvm_state"
    own = f"import heyoka\n{state}.set_diskcache_path({str(tmp_path / 'mine')!r})\n"
    limit = f"print({state}.get_diskcache_limit() > 2**31)"
    assert run(own + RUN + limit, tmp_path).stdout.split() == ["heyoka", "True"]
    assert any((tmp_path / "mine").iterdir())
    assert not (tmp_path / "voronec" / "heyoka").exists()


@pytest.mark.slow
def test_where_nobody_can_write_programs_are_not_kept(tmp_path: Path) -> None:
    done = run(RUN, Path(os.devnull))
    assert done.stdout.split() == ["heyoka"]
    assert done.stderr == ""


DOORS = """
from contextlib import suppress
import voronec as vo
from voronec.motion.steppers.kept_code import kept_function
from voronec.audit import Cache, Display, Paper, Section, Study, audit_paper
from voronec.cli import main
from voronec.errors import DefinitionError
import sympy as sp

def audit():
    x = sp.Symbol("x")
    displays = (Display("$x+x=2x$"),)
    studies = lambda _: {"only": Study({"x": x})}
    audit = audit_paper(Paper("p", "", (Section("s", displays, studies),)), cache=Cache.of_user())
    assert [r.verdict for r in audit.records] == ["proved"]

def integrate(method):
    try:
        vo.integrate(vo.load("sleigh"), times=1, method=method)
    except DefinitionError as error:
        assert "install" in str(error), error

def compiled():  # as the method numba does, which compiles for seconds
    text = "@jit\\ndef twice(x):\\n    return 2*x\\n"
    assert kept_function("twice", "float64(float64)", "key", lambda: text)(2.0) == 4

for method in ("heyoka", "c"):
    integrate(method)
with suppress(ImportError):
    compiled()
audit()
assert main(["show", "sleigh"]) == 0
"""
"""What reads caches: integration by the methods that keep code, audits, and commands."""
DOOR = DOORS.partition("for method")[0]
NOBODY = 65534
"""A user who is never the one that runs tests."""


@pytest.fixture(scope="module")
def filled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Caches as all the doors leave them."""
    cache = tmp_path_factory.mktemp("cache")
    run(DOORS, cache)
    return cache


def _plant(cache: Path, markers: Path) -> None:
    """Put code that leaves a marker into every file of a cache that is run when it is read, with
    the digests that belong to it."""

    class Payload:
        def __init__(self, name: str) -> None:
            self.name = name

        def __reduce__(self) -> tuple[Callable[..., object], tuple[str]]:
            return eval, (f"[open({str(markers / self.name)!r}, 'a').close(), {{}}][1]",)

    for file in cache.glob("voronec/models/*"):
        content = pickle.dumps(Payload("model"))
        file.write_bytes(sha256(content).hexdigest().encode() + content)
    for file in cache.rglob(kept_code.SOURCE):
        old = file.read_text()
        text = f"{old}open({str(markers / 'source')!r}, 'a').close()\n"
        file.write_text(text)
        for index in (file.parent / "__pycache__").glob("*.nbi"):  # its name has a digest of it
            marks = (sha256(x.encode()).hexdigest()[:24] for x in (old, text))
            index = index.rename(index.with_name(index.name.replace(*marks)))
            index.write_bytes(pickle.dumps(Payload("numba")))
    for file in cache.rglob(kept_code.LIBRARY):
        source = markers.parent / "payload.c"
        source.write_text(
            "#include <stdio.h>\n__attribute__((constructor)) static void run(void)"
            f'{{ FILE *f = fopen("{markers / "library"}", "a"); if (f) fclose(f); }}\n'
        )
        file.unlink()
        subprocess.run(["cc", "-shared", "-fPIC", "-o", file, source], check=True)
    for folder in cache.glob("voronec/code/*"):
        kept_code.write_list(folder)


def _owned(place: Path) -> None:
    if os.geteuid():
        pytest.skip("only root gives files away")
    os.chown(place, NOBODY, NOBODY)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("are_files", "give"), [(True, _owned), (False, lambda folder: folder.chmod(0o777))],
    ids=["files that another user owns", "folders that others can write"],
)  # fmt: skip
def test_what_others_planted_in_a_cache_is_never_run(filled, tmp_path, give, are_files) -> None:
    cache, markers = tmp_path / "cache", tmp_path / "markers"
    shutil.copytree(filled, cache)
    markers.mkdir()
    _plant(cache, markers)
    files = {p for p in cache.rglob("*") if p.is_file()}
    foreign = files if are_files else {p.parent for p in files}
    for place in foreign:
        give(place)
    done = run(DOORS, cache)
    assert not any(markers.iterdir())
    told = [line for line in done.stderr.splitlines() if "belongs to another user" in line]
    assert told and len({line.split("'")[1] for line in told}) == len(told), "each is named once"
    assert "Traceback" not in done.stderr


@pytest.mark.slow
def test_what_the_user_wrote_is_run(filled, tmp_path) -> None:
    """So the payloads above work: the user's own are run."""
    cache, markers = tmp_path / "cache", tmp_path / "markers"
    shutil.copytree(filled, cache)
    markers.mkdir()
    _plant(cache, markers)
    expected = {"model"}
    for pattern, names in (("*.nbi", {"numba", "source"}), (kept_code.LIBRARY, {"library"})):
        expected |= names if any(cache.rglob(pattern)) else set()
    calls = ("integrate('heyoka')", "integrate('c')", "compiled()")
    run(DOOR + "".join(f"with suppress(Exception): {call}\n" for call in calls), cache)
    assert {p.name for p in markers.iterdir()} == expected


@pytest.mark.slow
def test_what_numba_keeps_lies_in_our_folder(tmp_path, monkeypatch) -> None:
    pytest.importorskip("numba")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "shared"))
    text = "@jit\ndef twice(x):\n    return 2*x\n"
    code = (
        "from voronec.motion.steppers.kept_code import kept_function\n"
        f"print(kept_function('twice', 'float64(float64)', 'k', lambda: {text!r})(2.0))\n"
        "import numba; print(numba.config.CACHE_DIR)"
    )
    for _ in range(2):
        assert run(code, tmp_path).stdout.split() == ["4.0", str(tmp_path / "shared")]
    assert not (tmp_path / "shared").exists() and any(tmp_path.glob("voronec/code/*/*/*.nbi"))
