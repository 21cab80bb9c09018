"""What heyoka compiles is kept in a folder of ours, unless somebody else loaded it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

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
