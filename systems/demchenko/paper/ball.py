"""The gyroscopic ball on a sphere: the displays as printed, and what they are compared with."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import sympy as sp

from voronec.audit import Check, Display, Section, Study, Transcript

from ..sentences.ball import FRAMES, SENTENCES

UPRIGHT = "the momentum of ball and rotor, in which k belongs to chi whatever the quasi-velocities"
DERIVATION = "the equations derived for the system 'ball-with-rotor'"
DEFINITION = Check("definition")
EVERYWHERE = Check("definition", also=("reduced",))
ZHUKOVSKY = Check(study="zhukovsky", given=("uslovZh",))
BOTH = Check(also=("reduced",))
CONSTRAINT = Check(also=("reduced",), constrains=1)
ANY_MOTION = Check(source=FRAMES)
NO_VECTOR = Check(value=lambda study, where: sp.zeros(3, 1), source=FRAMES)


def motion(row: int) -> Check:
    """Compare with a row of the derived equations of motion of both systems."""
    return Check(
        study="reduced",
        also=("zhukovsky",),
        truth=lambda study, where: study.context.equation(row),
        given=("uslovZh",),
    )


def projection(row: int) -> Check:
    """Compare with a projection of the momentum, laid along the vertical axis."""

    def derivation(study: Study, where: Mapping[str, int]) -> list[tuple[Any, Any]]:
        vertical, momentum = study.context.projections()
        return [(vertical[row], momentum[row])]

    return Check(study="upright", given=("uslovZh",), derived=derivation, source=UPRIGHT)


def condition(study: Study, _: Mapping[str, int]) -> Any:
    """What C_1 must be for the momentum along the normal to have the coefficient A of n."""
    return study.context.condition()


def studies(_: Transcript) -> dict[str, Study]:
    """The dictionaries of the section on the ball."""
    from ..dictionary.ball import ReducedBall, WithRotor

    return {**WithRotor.derive().studies(), "reduced": ReducedBall.derive().study()}


BALL = Section(
    title="The Bobilev-Zhukovsky problem and its generalization",
    complete=True,
    label="ballGyr",
    studies=studies,
    inline=(
        Display(r"$\mu'=\frac{R_2}{R_1}$", (EVERYWHERE,)),
        Display(r"$\mu=1+\frac{R_2}{R_1}=1+\mu'$", (EVERYWHERE,)),
        Display(r"$P=I+A$", (EVERYWHERE,)),
        Display(r"$I=\mathbf{M}R_2^2$", (EVERYWHERE,)),
        Display(r"$p_1^2+q_1^2+r^2_1=s^2+\tau^2+n^2$"),
        Display(r"$[\mathfrak v, \mathfrak M]=0$", (NO_VECTOR,)),
    ),
    sentences=SENTENCES,
    displays=(
        Display(
            r"""\begin{equation}\label{uslovZh}
C_1=A_1+A_2.
\end{equation}""",
            (Check("condition", "zhukovsky", value=condition),),
        ),
        Display(
            r"""$$
\begin{aligned}
& x=R_2\sin u\cos v\quad y=R_2\sin u\sin v\quad z=R_2\cos u\\
& x_1=R_1\sin u_1\cos v_1\quad y_1=R_1\sin u_1\sin v_1\quad z_1=R_1\cos u_1.
\end{aligned}
$$""",
            (DEFINITION,),
        ),
        Display(
            r"""\begin{equation}\label{4.2.2}
\begin{aligned}
& \dot{u}_1=-\mu'\dot{u}\sin\vartheta+\mu'\dot{v}\cos\vartheta\sin u,\\
& \dot{v}_1\sin{u}_1=\mu'\dot{u}\cos\vartheta+\mu'\dot{v}\sin\vartheta\sin u,
\end{aligned}
\end{equation}""",
            (CONSTRAINT,),
        ),
        Display(
            r"""\begin{equation}\label{4.2.789}
s=\mu\sin u\dot{v},\quad \tau=-\mu\dot{u},\quad n=-\dot\vartheta-\cos u\dot v-\cos u_1{\dot v}_1
\end{equation}""",
            (BOTH,),
        ),
        Display(
            r"""$$
C_2r_2=k=const \quad \text{and}\quad p_1^2+q_1^2=p_2^2+q_2^2.
$$""",
            (Check(source=f"{UPRIGHT}, and {DERIVATION}"), ANY_MOTION),
        ),
        Display(
            r"""\begin{eqnarray}
\tilde{\mathbf T}&=& \frac12\big(A_1 p_1^2+A_1 q_1^2+C_1 r_1^2\big)+\frac12\big(A_2 p_2^2+A_2 q_2^2+C_2 r_2^2\big)+\frac12\mathbf M \mathbf w^2\nonumber \\
&=& \frac12\big(A p_1^2+A q_1^2+C r_1^2\big)+\frac12 k r_2+\frac12 \mathbf M \mathbf w^2, \quad A=A_1+A_2, \quad C=C_1, \label{kinMod**}
\end{eqnarray}""",
            (ANY_MOTION, ANY_MOTION, ANY_MOTION),
        ),
        Display(
            r"""\[
\mathbf w^2=R_2^2(s^2+\tau^2),
\]"""
        ),
        Display(
            r"""\begin{equation}\label{kinMod*}
\tilde{\mathbf T}=\frac12(P(s^2+\tau^2)+A n^2)+\frac12 k r_2,
\end{equation}""",
            (ZHUKOVSKY,),
        ),
        Display(
            r"""\begin{equation}\label{GMConst}
\tilde{\mathbf{G}}^{(M)}=const.
\end{equation}""",
        ),
        Display(
            r"""\[
\alpha_1''=\sin u_1\sin\vartheta, \quad \beta_1''=-\sin u_1\cos\vartheta, \quad \gamma_1''=-\cos u_1.
\]""",
            (ANY_MOTION, ANY_MOTION, ANY_MOTION),
        ),
        Display(
            r"""\begin{equation}\label{integrali}
\begin{aligned}
&\Gamma\sin u_1\sin\vartheta=P s-k\sin u\\
-&\Gamma\sin u_1\cos\vartheta=P\tau\\
-&\Gamma\cos u_1=A n+k\cos u\\
\end{aligned}
\end{equation}""",
            (projection(0), projection(1), projection(2)),
        ),
        Display(
            r"""\begin{equation}\label{4.3.131415}
\begin{aligned}
&P\dot s-\mu'A\ n \dot{u}-P\tau(n+\cos u \dot{v})=k\mu\dot u\cos u,\\
&P\dot \tau-\mu'A\ n \sin u \dot{v}+P\ s(n+\cos u \dot{v})=k(n\sin u+\mu\dot v\sin u\cos u),\\
&A\dot n=k\mu\sin u\dot{u},
\end{aligned}
\end{equation}""",
            (motion(0), motion(1), motion(2)),
        ),
    ),
)
