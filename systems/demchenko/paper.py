r"""The transcription of the paper on Demchenko's dissertation.

Displays are copied letter for letter, mistakes included; ``general`` and ``ball`` say what the
names stand for in derived systems.  Nothing else of the audit is typed in.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from voronec.audit import Check, Display, Paper, Section, Study, Transcript

DEFINITION = Check("definition")
ZHUKOVSKY = Check(given=("uslovZh",))
BOTH = Check(also=("reduced",))


def dalembert(stationary: bool = False) -> Check:
    """Compare with d'Alembert's principle."""
    return Check(
        truth=lambda study, where: study.context.dalembert(where),
        derived=lambda study, where: study.context.structure(),
        stationary=stationary,
    )


def motion(row: int) -> Check:
    """Compare with a row of the derived equations of motion of both systems."""
    return Check(
        study="reduced",
        also=("rotor",),
        truth=lambda study, where: study.context.equation(row),
        given=("uslovZh",),
    )


def projection(row: int) -> Check:
    """Compare with a projection of the momentum, laid along the vertical axis."""

    def derived(study: Study, where: Mapping[str, int]) -> list[tuple[Any, Any]]:
        vertical, momentum = study.context.projections()
        return [(vertical[row], momentum[row])]

    return Check(study="upright", given=("uslovZh",), derived=derived)


def general_studies(transcript: Transcript) -> dict[str, Study]:
    """The dictionary of the section on the Voronec principle."""
    from .general import General

    return {"general": General.of(transcript).study()}


def ball_studies(_: Transcript) -> dict[str, Study]:
    """The dictionaries of the section on the ball."""
    from .ball import Reduced, WithRotor

    return {**WithRotor.derived().studies(), "reduced": Reduced.derived().study()}


VORONEC_PRINCIPLE = Section(
    title="The Voronec principle",
    label="VorPr",
    studies=general_studies,
    displays=(
        Display(
            r"""\begin{equation}\label{v1}
\dot q_{n+\nu}=\sum_{i=1}^n a_{\nu i} (q,t) \dot q_i + a_\nu (q,t) \qquad (\nu=1,2,\dots,k).
\end{equation}""",
            (DEFINITION,),
        ),
        Display(
            r"""\begin{eqnarray}
&& \Theta(t,q_1,\dots,q_{n+k},\dot q_1,\dots,\dot q_n)=T(t,q_1,\dots,q_{n+k},\dot q_1,\dots,\dot q_{n+k}), \label{v2} \\
&&  K_\nu(t,q_1,\dots,q_{n+k},\dot q_1,\dots,\dot q_n)=\frac{\partial T}{\partial \dot q_\nu}(t,q_1,\dots,q_{n+k},\dot q_1,\dots,\dot q_{n+k}) \quad (\nu=1,\dots,k). \label{v3}
\end{eqnarray}""",
            (DEFINITION, DEFINITION),
        ),
        Display(
            r"""\begin{equation}
\frac{d}{dt}\frac{\partial\Theta}{\partial \dot q_i}=\frac{\partial\Theta}{\partial q_i} + Q_i+\sum_{\nu=1}^k a_{\nu i}\big(\frac{\partial\Theta}{\partial q_{n+\nu}}+Q_{n+\nu}\big)+
\sum_{\nu=1}^k K_\nu\big(\sum_{j=1}^n A_{ij}^{(\nu)} \dot q_j+A_j^{(\nu)}\big) \quad (i=1,\dots,n), \label{v4}
\end{equation}""",
            (dalembert(),),
        ),
        Display(
            r"""\begin{eqnarray*}
&& A_{ij}^{(\nu)}=  \big(\frac{\partial a_{\nu i}}{\partial q_j}+\sum_{\mu=1}^k a_{\mu j}\frac{\partial a_{\nu i}}{\partial q_{n+\mu}}\big)
                   -\big(\frac{\partial a_{\nu j}}{\partial q_i}+\sum_{\mu=1}^k a_{\mu i}\frac{\partial a_{\nu j}}{\partial q_{n+\mu}}\big), \\
&&  A_i^{(\nu)}= \big(\frac{\partial a_{\nu i}}{\partial t}+\sum_{\mu=1}^k a_{\mu }\frac{\partial a_{\nu i}}{\partial q_{n+\mu}}\big)
                   -\big(\frac{\partial a_{\nu}}{\partial q_i}+\sum_{\mu=1}^k a_{\mu i}\frac{\partial a_{\nu}}{\partial q_{n+\mu}}\big).
\end{eqnarray*}"""
        ),
        Display(
            r"""\begin{equation}\label{v5}
\int_{t_1}^{t_2}\Big[\delta\Theta+\sum_{i=1}^{n+k} Q_i \delta q_i+\sum_{\nu=1}^k K_\nu\big(\frac{d}{dt}\delta q_{n+\nu}-\delta\dot q_{n+\nu}\big)  \Big]\cdot dt=0,
\end{equation}""",
            (dalembert(stationary=True),),
        ),
        Display(
            r"""\begin{equation}\label{v6}
\delta q_{n+\nu}=\sum_{i=1}^n a_{\nu i} \delta q_i \qquad (\nu=1,2,\dots,k).
\end{equation}""",
            (DEFINITION,),
        ),
        Display(
            r"""\[
\frac{d}{dt}\delta q_{i}-\delta\dot q_{i}=0 \qquad (i=1,2,\dots,n).
\]""",
            (DEFINITION,),
        ),
    ),
)

BALL = Section(
    title="The Bobilev-Zhukovsky problem and its generalization",
    label="ballGyr",
    studies=ball_studies,
    asides=(
        r"$\mu'=\frac{R_2}{R_1}$",
        r"$\mu=1+\frac{R_2}{R_1}=1+\mu'$",
        r"$P=I+A$",
        r"$I=\mathbf{M}R_2^2$",
    ),
    displays=(
        Display(
            r"""\begin{equation}\label{uslovZh}
C_1=A_1+A_2.
\end{equation}""",
            (Check("condition"),),
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
            (BOTH,),
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
$$"""
        ),
        Display(
            r"""\begin{eqnarray}
\tilde{\mathbf T}&=& \frac12\big(A_1 p_1^2+A_1 q_1^2+C_1 r_1^2\big)+\frac12\big(A_2 p_2^2+A_2 q_2^2+C_2 r_2^2\big)+\frac12\mathbf M \mathbf w^2\nonumber \\
&=& \frac12\big(A p_1^2+A q_1^2+C r_1^2\big)+\frac12 k r_2+\frac12 \mathbf M \mathbf w^2, \quad A=A_1+A_2, \quad C=C_1, \label{kinMod**}
\end{eqnarray}"""
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
\]"""
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

PAPER = Paper(
    name="demchenko",
    title="Demchenko's nonholonomic case of gyroscopic ball rolling without sliding over a sphere "
    "after his 1923 Belgrade doctoral thesis",
    authors="Vladimir Dragović, Borislav Gajić, Božidar Jovanović",
    sections=(VORONEC_PRINCIPLE, BALL),
    references=("DragovicGajicJovanovic2020", "Demchenko1924", "Voronec1902"),
)
