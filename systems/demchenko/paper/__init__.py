r"""The transcription of the paper on Demchenko's dissertation.

Every module holds one section, and a file of LaTeX beside it its displays, copied letter for letter,
mistakes included, with the names of what checks each; the package ``dictionary`` says what the names stand for in derived systems.
Nothing else of the audit is typed in.
"""

from __future__ import annotations

from voronec.audit import Paper

from .addition_theorems import ADDITION_THEOREMS
from .ball import BALL
from .body import BODY
from .contemporary import CONTEMPORARY
from .gyroscope import GYROSCOPE
from .inversion import INVERSION
from .kinds_of_motion import KINDS_OF_MOTION
from .neumann import NEUMANN
from .quadratures import QUADRATURES
from .special_solutions import SPECIAL_SOLUTIONS
from .voronec_principle import VORONEC_PRINCIPLE

__all__ = ["PAPER"]

PAPER = Paper(
    name="demchenko",
    title="Demchenko's nonholonomic case of gyroscopic ball rolling without sliding over a sphere "
    "after his 1923 Belgrade doctoral thesis",
    authors="Vladimir Dragović, Borislav Gajić, Božidar Jovanović",
    sections=(
        NEUMANN,
        VORONEC_PRINCIPLE,
        BODY,
        GYROSCOPE,
        BALL,
        QUADRATURES,
        ADDITION_THEOREMS,
        INVERSION,
        KINDS_OF_MOTION,
        SPECIAL_SOLUTIONS,
        CONTEMPORARY,
    ),
    references=("DragovicGajicJovanovic2020", "Demchenko1924", "Voronec1902"),
)
