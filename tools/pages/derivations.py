"""Store what the engine derives of every system, for the tests to compare with.

    python tools/build.py derivations [NAME ...]

Writes ``tests/derivations/NAME.json`` for all systems of the catalogue, or for some, and says what
is different from before; a file that is the same stays untouched.  A body without a rotor is held
by the one with it, and is left out.
"""

from __future__ import annotations

import sys
from pathlib import Path

import voronec as vo
from voronec.proof.comparison import StoredDerivation, compare, read_derivation

FOLDER = Path(__file__).resolve().parents[2] / "tests" / "derivations"


def store(name: str) -> str:
    """Derive one system and store it; one line on what changed."""
    derived = StoredDerivation.of(vo.derive(vo.load(name)))
    file, text = FOLDER / f"{name}.json", derived.text()
    if file.exists() and file.read_text(encoding="utf-8") == text:
        return "unchanged"
    word = "new"
    if file.exists():
        found = compare(read_derivation(file), derived)
        changed = [f"{row.group} {row.name}" for row in found.differences]
        word = "different: " + ", ".join(changed) if changed else "rewritten, proved equal"
    FOLDER.mkdir(exist_ok=True)
    file.write_text(text, encoding="utf-8")
    return word


def main() -> int:
    """Store the systems named, or all, and forget those that are gone."""
    arguments, names = sys.argv[1:], vo.names()
    largest = [name for name in names if f"gyroscopic-{name}" not in names]
    for name in arguments or largest:
        print(f"{name}: {store(name)}", flush=True)
    if not arguments:
        for file in FOLDER.glob("*.json"):
            if file.stem not in largest:
                file.unlink()
                print(f"{file.stem}: gone")
    return 0
