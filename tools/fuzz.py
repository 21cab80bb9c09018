"""Odd and random input, against what is known by routes that share no code with the engine.

python tools/fuzz.py KIND [--help] ...

doors   odd input at every door: files, texts, commands, Python, environment
scenes  random motions of random systems, against multipliers in many digits
starts  starts at the singular places of the coordinates of every system
turns   whole turns of Demchenko's ball against integration
prover  statements of known truth, asked for verdicts
searches  what systems declare, searched for untold; the rank test on a grid
crossings  zeros of polynomials whose roots are known, by every method
"""

import sys

from shared.kinds import run

KINDS = {
    "doors": "doors.run",
    "scenes": "scenes.run",
    "starts": "scenes.starts",
    "turns": "scenes.turns",
    "prover": "prover.run",
    "searches": "prover.searches",
    "crossings": "scenes.crossings",
}
"""Kind -> the module that does it."""

if __name__ == "__main__":
    sys.exit(run(__doc__, KINDS))
