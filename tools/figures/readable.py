"""How long the equations are that are printed: against books, and over the catalogue.

python tools/bench.py readable [--catalogue]

Characters are counted without blanks: equations, motion of the coordinates, and what is named below
``where``, in our text and in that of the book (``tests/textbook_equations.py``).  With
``--catalogue`` what all systems print is set against mass * vdot = force with every entry in the
exact normal form, which was printed before.
"""

from __future__ import annotations

import argparse
import statistics
import sys
from importlib import import_module
from pathlib import Path
from time import process_time
from typing import Any

import voronec as vo
from voronec.algebra.typeset import caret_text
from voronec.equations.readable import readable

sys.path.append(str(Path(__file__).resolve().parents[2] / "tests"))


def main() -> int:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--catalogue", action="store_true", help="measure the catalogue too")
    chosen = parser.parse_args()
    _books()
    if chosen.catalogue:
        _catalogue()
    return 0


def _books() -> None:
    ratios: dict[str, float] = {}
    for book in import_module("textbook_equations").TEXTBOOK:
        form, seconds = _time(vo.derive(book.system))
        ratios[book.name] = form.length / book.length
        print(
            f"{book.name:44}{form.length:6}{book.length:6}{ratios[book.name]:6.2f}{seconds:7.2f} s"
        )
    worst = max(ratios, key=lambda name: ratios[name])
    print(f"median {statistics.median(ratios.values()):.2f}, worst {ratios[worst]:.2f}: {worst}")


def _catalogue() -> None:
    before = after = 0
    for name in vo.names():
        eqs = vo.derive(vo.load(name))
        if eqs.in_normal_form:
            form, seconds = _time(eqs)
            plain = _entries(eqs)
            before, after = before + plain, after + form.length
            print(f"{name:44}{form.length:6}{plain:6}{form.length / plain:6.2f}{seconds:7.2f} s")
    print(f"catalogue {before} before, {after} after: {after / before:.2f}")


def _time(eqs: Any) -> tuple[Any, float]:
    _ = eqs.best.form
    start = process_time()
    return readable(eqs), process_time() - start


def _entries(eqs: Any) -> int:
    """The characters of motion and equations with every entry as it is exact."""
    size = range(len(eqs.velocities))
    lines = [f"d{q}/dt={rate}" for q, rate in zip(eqs.coordinates, eqs.rates, strict=True)]
    for i in size:
        terms = [
            f"({caret_text(eqs.mass[i, j])})*d{v}/dt"
            for j, v in enumerate(eqs.velocities)
            if eqs.mass[i, j] != 0
        ]
        lines.append(f"{'+'.join(terms)}={caret_text(eqs.force[i])}")
    return sum(len(line.replace(" ", "").replace("**", "^")) for line in lines)
