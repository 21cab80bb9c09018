"""What is measured, and what the pages of figures say.

python tools/bench.py KIND [--help] ...

derivation   equations against SymPy's: docs/benchmarks.md
speed        speed against error: docs/speed.md
closed-form  the closed form: docs/closed-form.md
references   the references of the closed form
mechanics    models of SymPy's mechanics against SymPy
chain        a program of thousands of operations
smooth       smooth runs, old code against new
"""

import sys

from shared.kinds import run

KINDS = {
    "derivation": "figures.derivation",
    "speed": "figures.speed",
    "closed-form": "figures.closed_form",
    "references": "figures.closed_references",
    "mechanics": "figures.mechanics",
    "chain": "figures.chain",
    "smooth": "figures.smooth",
}
"""Kind -> the module that does it."""

if __name__ == "__main__":
    sys.exit(run(__doc__, KINDS))
