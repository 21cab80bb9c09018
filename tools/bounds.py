"""The fast tests with other versions: of what the package rests on, or of Python.

python tools/bounds.py [lowest] [newest] [3.11] [3.12] [3.13] [-- WORDS FOR PYTEST ...]

For each (the first two by default) a virtual environment is made in a temporary folder; it gets
the lower bounds of pyproject.toml exactly, or the newest versions that an index has, of the
dependencies and of the extras that tests touch, and the fast tests run in it.  A version of Python,
whose interpreter is at hand under a name such as ``python3.12``, gets those of constraints.txt,
which continuous integration tests with one Python.  Status 1 says that one of them could not be
installed or failed a test.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
ENDS = ("lowest", "newest")
EXTRAS = ("test", "numba", "control")
"""What tests touch; the site is built with the extra ``docs``, which is too slow for this."""
FAST = ("-q", "-m", "not slow", "-p", "no:cacheprovider")


def requirements(end: str, extras: Sequence[str] = EXTRAS) -> list[str]:
    """What pip is asked for at an end: ``name==bound`` at the lowest, ``name>=bound`` at the
    newest, each with its marker of platforms."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    lists = (project["dependencies"], *(project["optional-dependencies"][e] for e in extras))
    every = dict.fromkeys(requirement for one in lists for requirement in one)
    return [r.replace(">=", "==", 1) if end == "lowest" else r for r in every]


def _run(end: str, folder: Path, words: Sequence[str]) -> bool:
    """Whether the fast tests pass at an end, in an environment made in the folder."""
    interpreter = sys.executable if end in ENDS else f"python{end}"
    making = [interpreter, "-m", "venv", str(folder)]
    if shutil.which(interpreter) is None or subprocess.run(making).returncode:
        print(f"{interpreter} is not at hand")
        return False
    versions = [] if end in ENDS else ["-c", "constraints.txt"]
    python = str(folder / ("Scripts" if os.name == "nt" else "bin") / "python")
    pip = [python, "-m", "pip", "--disable-pip-version-check"]
    steps = [
        [*pip, "install", "-q", *versions, *requirements(end)],
        [*pip, "install", "-q", "--no-deps", "--no-build-isolation", "-e", str(ROOT)],
        [*pip, "freeze", "--exclude-editable"],
        [python, "-m", "pytest", *FAST, *words],
    ]
    # what is compiled and kept by one version is not for another
    own = {**os.environ, "XDG_CACHE_HOME": str(folder / "cache")}
    return all(subprocess.run(step, cwd=ROOT, env=own).returncode == 0 for step in steps)


def main() -> int:
    """Run the ends that are named, one after the other, and say how each came out."""
    given = sys.argv[1:]
    cut = given.index("--") if "--" in given else len(given)
    ends, words = given[:cut] or [*ENDS], given[cut + 1 :]
    if not all(end in ENDS or re.fullmatch(r"3\.\d+", end) for end in ends):
        print((__doc__ or "").strip(), file=sys.stderr)
        return 2
    passed = {}
    for end in ends:
        print(f"== {end}: {', '.join(requirements(end))}", flush=True)
        with tempfile.TemporaryDirectory() as folder:
            passed[end] = _run(end, Path(folder), words)
    for end, well in passed.items():
        print(f"{end}: {'passed' if well else 'failed'}")
    return 0 if all(passed.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
