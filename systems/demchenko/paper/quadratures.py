"""Solving the system in terms of elliptic functions and elliptic integrals: the displays as printed, and what they are compared with."""

from __future__ import annotations

from typing import Any

from voronec.audit import Check, Convention, Display, Section, Study, Transcript

from ..dictionary.kinds_of_motion import by_state, forms, in_seconds
from ..dictionary.quadratures import level, x
from ..sentences.quadratures import SENTENCES

DEFINITION = Check("definition")
BALL_TRACE = Check(study="level", derived=lambda study, where: forms(r"\phi(x)"))
SPHERE_TRACE = Check(
    "definition", "level", derived=lambda study, where: forms("F(x)", r"\theta(x)")
)  # the paper has no other word on F and theta than that they are quadratic, which is a sentence


def square_of_rate(value: Any) -> Any:
    """The square of the rate of x in the unit of time of the equations of motion."""
    return (level().X / level().pace ** 2).subs(x, value)


RATE = Check(
    convention=Convention(
        "the unit of time is $b_2/k$ here, or $X(x)$ stands for $(k/b_2)^2$ times that polynomial",
        "4.4.13",
        {"X": square_of_rate},
    ),
    derived=in_seconds,
)


def studies(_: Transcript) -> dict[str, Study]:
    """The state of the ball, and a level of the integrals."""
    return level().studies()


QUADRATURES = Section(
    title="Solving the system in terms of elliptic functions and elliptic integrals",
    complete=True,
    label=None,
    studies=studies,
    inline=(
        Display(r"$x=\cos u$", (DEFINITION,)),
        Display(r"$C_5=k\mu x_0$", (DEFINITION,)),
        Display(r"$\mu>1$"),
    ),
    sentences=SENTENCES,
    displays=(
        Display(
            r"""\begin{equation}\label{eq:elliptic1}
\big(\frac{dx}{dt}\big)^2=X(x),
\end{equation}""",
            (RATE,),
        ),
        Display(
            r"""\begin{equation}\label{4.4.4}
An=-k\mu x +C_5=-k\mu(x-x_0),
\end{equation}"""
        ),
        Display(
            r"""\begin{equation}\label{eq:areaintegral}
P^2(s^2+\tau^2)+A^2n^2 + k^2-2k(Ps\sin u -A n\cos u)=\Gamma^2,
\end{equation}"""
        ),
        Display(
            r"""\begin{equation}\label{eq:kinetic}
P(s^2+\tau^2)+An^2=2h.
\end{equation}"""
        ),
        Display(
            r"""\begin{equation}\label{4.4.7}
b_2s\sin u = k\mu (-b_0x^2+2b_1x_0x-\bar \Gamma),
\end{equation}"""
        ),
        Display(
            r"""$$
b_0=I\mu+2A, \, b_1=I\mu +A, \, b_2=2PA,
$$""",
            (DEFINITION,),
        ),
        Display(
            r"""$$
\bar \Gamma =\frac{IC_5^2+A(\Gamma^2-k^2)-2hPA}{\mu k^2},
$$""",
            (DEFINITION,),
        ),
        Display(
            r"""$$
b_0>b_1>P=A+1,
$$"""
        ),
        Display(
            r"""$$
b_2^2\tau^2=-2b_2A^2n^2+2b_2Ah-b_2^2s^2.
$$"""
        ),
        Display(
            r"""\begin{equation}\label{4.4.12}
b_2^2\tau^2\sin^2 u=\mu^2k^2X,
\end{equation}"""
        ),
        Display(
            r"""\begin{equation}\label{4.4.13}
X=2b_2(h'-x+x_0)(h'+x-x_0)(1-x^2)-(-b_0x^2+2b_1x_0x-\bar \Gamma)^2,
\end{equation}""",
            (Check(derived=by_state),),
        ),
        Display(
            r"""$$
h'=\frac{\sqrt{2hA}}{\mu k}.
$$""",
            (DEFINITION,),
        ),
        Display(
            r"""\begin{equation}\label{eq:elliptic2}
dv = \frac{\phi(x)dx}{(1-x^2)\sqrt{X}}, \quad dv_1 = \frac{F(x)dx}{\theta(x)\sqrt{X}},
\end{equation}""",
            (BALL_TRACE, SPHERE_TRACE),
        ),
        Display(
            r"""$$
X(x)=(1-x^2)\psi(x)-\phi(x)^2=a_0(x-x^I)(x-x^{II})(x-x^{III})(x-x^{IV}),
$$""",
            (Check(study="product", also=("roots",)),),
        ),
    ),
)
