"""Back to the Demchenko case: no displays, but claims of the running text."""

from __future__ import annotations

from voronec.audit import Section, Sentence, Study, Transcript

from ..dictionary.kinds_of_motion import (
    even_count,
    gaps_printed,
    outer_gaps,
    single_gap,
    without_roots,
)
from ..dictionary.quadratures import level
from ..dictionary.trajectories import equal_steps, regular_at_poles, rests, turns


def studies(_: Transcript) -> dict[str, Study]:
    """The motion on a level of the integrals."""
    return {"level": level().study({})}


KINDS_OF_MOTION = Section(
    title="Back to the Demchenko case",
    displays=(),
    studies=studies,
    sentences=(
        Sentence(
            r"in general, and counted with multiplicity, $X$ has no real root, two or four",
            even_count,
        ),
        Sentence(r"where $X$ has no real root there is no motion", without_roots),
        Sentence(
            r"with four real roots $x$ runs between the two largest, or between the two smallest",
            outer_gaps,
            derived=gaps_printed,
        ),
        Sentence(r"with two real roots, if there is a motion, $x$ runs between them", single_gap),
        Sentence(
            r"from one contact with a limiting parallel to the next, $v$ and $v_1$ grow by the "
            r"same angle every time: their rates are functions of $x$ alone",
            equal_steps,
        ),
        Sentence(
            r"on the ball $v$ turns back just where $\phi$ changes its sign, on the sphere $v_1$ "
            r"just where $F$ does",
            turns,
        ),
        Sentence(
            r"the contact point stops on both surfaces just where $\psi=0$; a simple root of $X$ "
            r"with $-1<x<1$ that is one of $\psi$ is one of $\phi$ and $F$, and gives a cusp on "
            r"both",
            rests,
        ),
        Sentence(
            r"where $x=1$ or $x=-1$ is a simple root of $X$ the contact point does not stop",
            regular_at_poles,
        ),
    ),
)
