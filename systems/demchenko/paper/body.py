"""The Voronec principle and rolling of a body over a surface: the displays as printed, and what they are compared with."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from voronec.audit import Check, Convention, Display, Section, Study, Transcript

from ..dictionary.surfaces import MASS
from ..sentences.body import KINETIC, SENTENCES


def studies(_: Transcript) -> dict[str, Study]:
    """The dictionaries of this section."""
    from ..dictionary.body import Body

    return Body.derive().studies()


def momentum(position: int) -> Check:
    """K_1 or K_2 in terms of s, tau, n; the print has M for the mass."""

    def derivation(study: Study, _: Mapping[str, int]) -> list[tuple[Any, Any]]:
        return [(f"K_{position + 1}", study.context.momentum_terms(position, study.spelling))]

    return Check(
        study="quasi",
        derived=derivation,
        convention=Convention("$M$ is the mass $\\mathbf M$", "kineticka", {"M": MASS}),
    )


def transposition(position: int) -> Check:
    """What K_1 or K_2 is multiplied by in the principle."""

    def value(study: Study, _: Mapping[str, int]) -> Any:
        return study.context.transpositions[position]

    return Check(value=value)


def motion(position: int) -> Check:
    """The derived equation of u, v or theta."""

    def derivation(study: Study, _: Mapping[str, int]) -> list[tuple[Any, Any]]:
        found: list[tuple[Any, Any]] = study.context.equation_terms(position)
        return found

    return Check(
        truth=lambda study, where: study.context.residuals[position],
        derived=derivation,
    )


DEFINITION = Check("definition")

BODY = Section(
    title="The Voronec principle and rolling of a body over a surface",
    complete=True,
    label="body",
    studies=studies,
    inline=(
        Display(
            r"$T={T}(u,  v, \vartheta, u_1, v_1, \dot u, \dot v, \dot \vartheta, \dot u_1, \dot v_1)$",
            (Check("definition", source=KINETIC),),
        ),
        Display(r"$\mathfrak m_\mathbf u=0,\mathfrak w_\mathbf v=0,\mathfrak m_\mathbf n=0$"),
    ),
    sentences=SENTENCES,
    displays=(
        Display(
            r"""\[
K_1(u,  v, \vartheta, u_1, v_1, \dot u, \dot v, \dot \vartheta)=\frac{\partial{T}}{\partial \dot u_1},\quad K_2(u,  v, \vartheta, u_1, v_1, \dot u, \dot v, \dot \vartheta)=\frac{\partial{T}}{\partial \dot v_1}
\]""",
            (DEFINITION, DEFINITION),
        ),
        Display(
            r"""\[
\begin{aligned}
K_1&=M\sqrt{E_1}\big[(\epsilon s-\rho_u n)\cos \vartheta+(\epsilon\tau-\rho_v n)\sin\vartheta\big]\\
&+\frac{1}{2\sqrt{E_1G_1}}\frac{\partial E_1}{\partial v_1}\frac{\partial\Theta}{\partial n}-\frac{D_1}{\sqrt{E_1}}\Big(\frac{\partial \Theta}{\partial s}\cos\vartheta+\frac{\partial \Theta}{\partial \tau}\sin\vartheta\Big),\\
K_2&=M\sqrt{G_1}\big[(\epsilon s-\rho_u n)\sin \vartheta-(\epsilon\tau-\rho_v n)\cos\vartheta\big]\\
&+\frac{1}{2\sqrt{E_1G_1}}\frac{\partial G_1}{\partial u_1}\frac{\partial\Theta}{\partial n}+\frac {D''_1}{\sqrt{G_1}}\Big(\frac{\partial \Theta}{\partial \tau}\cos\vartheta-\frac{\partial \Theta}{\partial s}\sin\vartheta\Big).
\end{aligned}
\]""",
            (momentum(0), momentum(1)),
        ),
        Display(
            r"""\begin{equation}\label{varijacije}
\begin{aligned}
\sqrt{E_1}\delta u_1 &=-\sqrt{E}\delta u\sin\vartheta+\sqrt{G}\delta v\cos\vartheta,\\
\sqrt{G_1}\delta v_1 &=\sqrt{E}\delta u\cos\vartheta+\sqrt{G}\delta v\sin\vartheta,\\
\end{aligned}
\end{equation}""",
            (Check(constrains=1), Check(constrains=1)),
        ),
        Display(
            r"""$$
\begin{aligned}
\frac{1}{\sqrt{E_1}}\big[\sqrt{E}(n\delta u-\dot u n')\cos \vartheta +\sqrt{G}(n\delta v-\dot v n')\sin\vartheta\big],\\
\frac{1}{\sqrt{G_1}}\big[\sqrt{E}(n\delta u-\dot u n')\sin \vartheta -\sqrt{G}(n\delta v-\dot v n')\cos\vartheta\big],\\
\end{aligned}
$$""",
            (transposition(0), transposition(1)),
        ),
        Display(
            r"""$$
n'=-\delta\vartheta+\frac{1}{2\sqrt{GE}}\Big(\frac{\partial E}{\partial v}\delta u-\frac{\partial G}{\partial u}\delta v\Big)+
\frac{1}{2\sqrt{G_1E_1}}\Big(\frac{\partial E_1}{\partial v_1}\delta u_1-\frac{\partial G_1}{\partial u_1}\delta v_1\Big).
$$"""
        ),
        Display(
            r"""$$
K_1'=\frac{K_1}{\sqrt{E_1}}\cos\vartheta+\frac{K_2}{\sqrt{G_1}}\sin\vartheta,\quad K_2'=\frac{K_1}{\sqrt{E_1}}\sin\vartheta-\frac{K_2}{\sqrt{G_1}}\cos\vartheta,
$$""",
            (DEFINITION, DEFINITION),
        ),
        Display(
            r"""$$
\int\limits_{t_1}^{t}\big[\delta\bar{\Theta}+\delta U+K'_1\sqrt{E}(n\delta u-\dot u n') +K'_2\sqrt{G}(n\delta v-\dot v n')\big]dt.
$$""",
            (
                Check(
                    stationary=True,
                    truth=lambda study, where: study.context.row(where),
                    # Two omissions that show in no number.
                    proposal=r"\int\limits_{t_1}^{t_2}\big[\delta\bar{\Theta}+\delta U+K'_1\sqrt{E}(n\delta u-\dot u n') +K'_2\sqrt{G}(n\delta v-\dot v n')\big]dt=0",
                ),
            ),
        ),
        Display(
            r"""\begin{equation}\label{jednacine1}
\begin{aligned}
\frac{d}{dt}\frac{\bar{\Theta}}{\partial\dot u}-\frac{\partial(\bar{\Theta}+U)}{\partial u}&=\sqrt{E}\Big[-\frac{\partial(\bar{\Theta}+U)}{\partial u_1}\frac{\sin\vartheta}{\sqrt{E_1}}
+\frac{\partial(\bar{\Theta}+U)}{\partial v_1}\frac{\cos\vartheta}{\sqrt{G_1}}-K'_1\dot\vartheta\Big]\\
&-(\Delta_2K'_1+\Delta_1K'_2)\sqrt{EG}\dot v,\\
\frac{d}{dt}\frac{\bar{\Theta}}{\partial\dot v}-\frac{\partial(\bar{\Theta}+U)}{\partial v}&=\sqrt{G}\Big[\frac{\partial(\bar{\Theta}+U)}{\partial u_1}\frac{\cos\vartheta}{\sqrt{E_1}}
+\frac{\partial(\bar{\Theta}+U)}{\partial v_1}\frac{\sin\vartheta}{\sqrt{G_1}}-K'_2\dot\vartheta\Big]\\
&+(\Delta_2K'_1+\Delta_1K'_2)\sqrt{EG}\dot u,\\
\frac{d}{dt}\frac{\bar{\Theta}}{\partial\dot \vartheta}-\frac{\partial(\bar{\Theta}+U)}{\partial \vartheta}&=K'_1\sqrt{E}\dot u+K '_2\sqrt{G}\dot v,
\end{aligned}
\end{equation}""",
            (motion(0), motion(1), motion(2)),
        ),
        Display(
            r"""\begin{eqnarray*}
&& 2\Delta_1=\frac{1}{\sqrt{G}}\frac{\partial\ln E}{\partial v}-\frac{\sin\vartheta}{\sqrt{G_1}}\frac{\partial\ln E_1}{\partial v_1}-\frac{\cos\vartheta}{\sqrt{E_1}}\frac{\partial\ln G_1}{\partial u_1}, \\
&& 2\Delta_2=\frac{1}{\sqrt{E}}\frac{\partial\ln G}{\partial u}-\frac{\sin\vartheta}{\sqrt{E_1}}\frac{\partial\ln G_1}{\partial u_1}-\frac{\cos\vartheta}{\sqrt{G_1}}\frac{\partial\ln E_1}{\partial v_1}.
\end{eqnarray*}"""
        ),
    ),
)
