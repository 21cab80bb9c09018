"""The Voronec principle: the displays as printed, and what they are compared with."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from voronec.audit import Check, Display, Section, Study, Transcript

from ..sentences.voronec_principle import CURVATURE, SENTENCES

DEFINITION = Check("definition")
ENERGY = "the kinetic energy of any system, with unknown functions for coefficients"
PRINCIPLE = "d'Alembert's principle, for any constraints affine in the velocities"
RULE = "how variations of independent coordinates change, for any system"


def dalembert(stationary: bool = False, source: str = "") -> Check:
    """Compare with d'Alembert's principle."""
    return Check(
        truth=lambda study, where: study.context.dalembert(where),
        derived=lambda study, where: study.context.structure(),
        stationary=stationary,
        source=source,
    )


def studies(_: Transcript) -> dict[str, Study]:
    """The dictionary of the section on the Voronec principle."""
    from ..dictionary.general import General

    return {
        "general": General.derive().study(),
        "chaplygin": General.chaplygin().study(),
    }


def transposition(study: Study, where: Mapping[str, int]) -> Any:
    """How much varying and differentiating in time differ for a dependent coordinate."""
    return study.context.transposition(where)


VORONEC_PRINCIPLE = Section(
    title="The Voronec principle",
    complete=True,
    label="VorPr",
    studies=studies,
    inline=(
        Display(r"$T=T(t,q_s,\dot q_s)$", (Check("definition", source=ENERGY),)),
        Display(
            r"$\frac{d}{dt}\delta q_{n+\nu}-\delta\dot q_{n+\nu}$",
            (Check(value=transposition, source=CURVATURE),),
        ),
    ),
    sentences=SENTENCES,
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
            (dalembert(stationary=True, source=PRINCIPLE),),
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
            (Check("definition", source=RULE),),
        ),
    ),
)
