"""Special Solutions: the displays as printed, and what they are compared with."""

from __future__ import annotations

from dataclasses import replace

from voronec.audit import Check, Display, Section, Sentence, Study, Transcript

from ..dictionary.quadratures import level
from ..dictionary.stability import (
    at_rest,
    precession,
    precessions_exist,
    remarkable,
    small_nutation,
    stationary,
)

MEANING = (
    "stable: x stays as near as one likes if u, s, tau, n begin near enough; v and v1 may drift"
)


def studies(transcript: Transcript) -> dict[str, Study]:
    """The motion on a level of the integrals; its context are the conditions as printed."""
    printed = tuple(formula.printed for formula in transcript.formulas())
    return {"level": replace(level().study({}, MEANING), context=printed)}


SPECIAL_SOLUTIONS = Section(
    title="Special Solutions",
    label=None,
    studies=studies,
    sentences=(
        Sentence(
            r"there are regular precessions: $x$ stays at a double root of $X$, and both traces "
            r"are parallels",
            precessions_exist,
        ),
        Sentence(
            r"with a fast gyroscope $|x-x(0)|\le 2\sqrt{2hA}/(|k\mu|)$ is small, for all nearby "
            r"motions too: pseudo-regular precessions, always stable (all of $s_0,\tau_0,n_0$ are "
            r"to be small against $k$)",
            small_nutation,
        ),
        Sentence(
            r"there are stationary motions, $s=\tau=0$ with constant $n$: where $n=0$, or where "
            r"$\sin u=0$",
            at_rest,
        ),
        Sentence(r"stationary motions are always stable", stationary),
        Sentence(
            r"where the axis of the gyroscope rests along the momentum vector, the ball rests, or "
            r"both traces are great circles whatever the energy: $u=u_1=\pi/2$, $n=\tau=0$",
            remarkable,
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
                    says=r"a precession at a double root with $X''<0$ is stable",
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
                    says=r"a precession at a double root with $X''>0$ is unstable",
                ),
            ),
        ),
        Display(
            r"""$$
    \frac{\partial^2 X}{\partial x^{I2}}=0,
    $$""",
            (Check("condition"),),
        ),
        Display(
            r"""$$
    \frac{\partial^3 X}{\partial x^{I3}}=0,
    $$""",
            (
                Check(
                    decide=precession(3, True),
                    says=r"a precession at a root with $X''=X'''=0$ is stable",
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
                    says=r"a precession at a root with $X''=0$ and $X'''\ne0$ is unstable",
                ),
            ),
        ),
    ),
)
