"""What is measured, and what the pages of figures say.

python tools/bench.py KIND [--help] ...

derivation   equations against SymPy's: docs/benchmarks.md
speed        speed against error: docs/speed.md
methods      any system: our methods and the peers against a reference
closed-form  the closed form: docs/closed-form.md
references   the references of the closed form
setup        large systems, to the first equations and to the first step, against SymPy
mechanics    models of SymPy's mechanics against SymPy
prepared     runs of prepared problems beside equations by hand
costs        what steps of heyoka and DOP853 cost: the constants by which `auto` chooses
readable     the equations that are printed against those of books, and what the catalogue prints
orbits       families of periodic orbits; Lyapunov exponents beside C by hand and published values
sweep        sweeps beside heyoka's lanes by hand, their memory, kills on a cluster of Dask
dynamics     steady motions: families, spectra, critical values
diagrams     bifurcation diagrams: eight, and what motions from random places say of them
doubts       how often the check of runs doubts what is right, and notices what is wrong
"""

import sys

from shared.kinds import run

KINDS = {
    "derivation": "figures.derivation",
    "speed": "figures.speed",
    "methods": "figures.methods",
    "closed-form": "figures.closed_form",
    "references": "figures.closed_references",
    "setup": "figures.setup",
    "mechanics": "figures.mechanics",
    "prepared": "figures.many_calls",
    "costs": "figures.method_costs",
    "readable": "figures.readable",
    "doubts": "figures.doubts",
    "dynamics": "figures.steady_motions",
    "diagrams": "figures.diagrams",
    "orbits": "figures.orbits",
    "sweep": "figures.sweeps",
}
"""Kind -> the module that does it."""

if __name__ == "__main__":
    sys.exit(run(__doc__, KINDS))
