"""Our methods and the peers on a motion of any system: ``python tools/bench.py methods NAME``.

What ``voronec bench`` measures, peers beside our methods; what is not installed is named.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import voronec as vo
from figures.peers import PEERS
from voronec.accuracy.bench import OWN, measure, scene_problem
from voronec.cli.benchmark import report, write


def main() -> int:
    """Measure, print the tables and write them, with a plot, into a folder."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("system", metavar="NAME", help="a system of the catalogue, or a file")
    parser.add_argument("--scene")
    parser.add_argument("--outputs", nargs="*", default=())
    parser.add_argument("--time", type=float)
    parser.add_argument("--methods", nargs="*", default=(), help="all by default")
    parser.add_argument("--tols", nargs="*", type=float, default=())
    parser.add_argument("--out", type=Path, help="by default NAME-bench")
    chosen = parser.parse_args()
    try:
        problem = scene_problem(vo.load(chosen.system), chosen.scene, chosen.outputs, chosen.time)
        bench = measure(
            problem, chosen.methods, chosen.tols, among=(*OWN, *PEERS),
            say=lambda text: print(f"{text} ...", file=sys.stderr),
        )  # fmt: skip
    except vo.VoronecError as error:
        parser.error(str(error))
    print("\n".join(report(bench)))
    write(bench, chosen.out or Path(f"{problem.system.name}-bench"))
    return 130 if bench.interrupted else 0
