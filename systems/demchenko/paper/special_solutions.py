"""Special Solutions: the displays as printed, and what they are compared with."""

from __future__ import annotations

from dataclasses import replace

from voronec.audit import Check, Display, Section, Sentence, Study, Transcript

from ..dictionary.quadratures import level
from ..dictionary.stability import (
    at_rest,
    left_open,
    ordinary_ball,
    ordinary_printed,
    precession,
    precessions_exist,
    remarkable,
    small_nutation,
    small_nutation_printed,
    stationary,
)

MEANING = (
    "stable: x stays as near as one likes if u, s, tau, n begin near enough; v and v1 may drift"
)
INSIDE = MEANING + "; at x = 1 or -1, where a root has one side only, the motion is stationary"


def studies(transcript: Transcript) -> dict[str, Study]:
    """The motion on a level of the integrals; the context are the conditions as printed."""
    printed = tuple(formula.printed for formula in transcript.formulas())
    inside = replace(level().study({}, INSIDE), context=printed)
    return {"inside": inside, "stable": level().study({}, MEANING), "level": level().study({})}


SPECIAL_SOLUTIONS = Section(
    title="Special Solutions",
    label=None,
    studies=studies,
    sentences=(
        Sentence(
            r"there are regular precessions: $x$ stays at a double root of $X$, and both traces "
            r"are parallels",
            precessions_exist,
            "level",
        ),
        Sentence(
            r"with a fast gyroscope, while $s_0,\tau_0$ (and $n_0$) are given, $|x-x(0)|$ is "
            r"small, and on nearby motions just as well: pseudo-regular precessions, always stable",
            small_nutation,
            "level",
            derived=small_nutation_printed,
        ),
        Sentence(
            r"there are stationary motions, $s=\tau=0$ with constant $n$: where $n=0$, or where "
            r"$\sin u=0$",
            at_rest,
            "level",
        ),
        Sentence(r"stationary motions are always stable", stationary, "stable"),
        Sentence(
            r"where the gyroscope stays at rest, $k=0$, an ordinary ball rolls, with constant $n$ "
            r"and $s^2+\tau^2$",
            ordinary_ball,
            "level",
            derived=ordinary_printed,
        ),
        Sentence(
            r"where the axis of the gyroscope rests along the momentum vector, the ball rests, or "
            r"it spins about that axis with the contact at a pole, or both traces are great "
            r"circles, whatever the energy: $u=u_1=\pi/2$, $n=\tau=0$",
            remarkable,
            "level",
        ),
    ),
    displays=(
        Display(
            r"""$$
    \frac{\partial^2 X}{\partial x^{I2}}<0,
    $$""",
            (
                Check(
                    decide=precession(0, True),
                    says=r"a precession at a double root $-1<x<1$ with $X''<0$ is stable",
                ),
            ),
        ),
        Display(
            r"""$$
    \frac{\partial^2 X}{\partial x^{I2}}>0.
    $$""",
            (
                Check(
                    decide=precession(1, False),
                    says=r"a precession at a double root $-1<x<1$ with $X''>0$ is unstable",
                ),
            ),
        ),
        Display(
            r"""$$
    \frac{\partial^2 X}{\partial x^{I2}}=0,
    $$""",
            (
                Check(
                    "definition",
                    decide=left_open,
                    says=r"the case that $X''<0$ and $X''>0$ leave open",
                ),
            ),
        ),
        Display(
            r"""$$
    \frac{\partial^3 X}{\partial x^{I3}}=0,
    $$""",
            (
                Check(
                    decide=precession(3, True),
                    says=r"a precession at a root $-1<x<1$ with $X''=X'''=0$ is stable",
                ),
            ),
        ),
        Display(
            r"""$$
    \frac{\partial^3 X}{\partial x^{I3}}\ne0.
    $$""",
            (
                Check(
                    decide=precession(4, False),
                    says=r"a precession at a root $-1<x<1$ with $X''=0$ and $X'''\ne0$ is unstable",
                ),
            ),
        ),
    ),
)
