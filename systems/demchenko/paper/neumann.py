"""Rolling without slipping of a body over a surface in the Neumann variables: the displays as printed, and what they are compared with."""

from __future__ import annotations

from voronec.audit import Check, Display, Section, Study, Transcript

from ..sentences.neumann import SENTENCES, turns

DEFINITION = Check("definition")
ROLLING = Check(study="rolling")
CONSTRAINT = Check(study="rolling", constrains=1)


LINES = Check(study="lines")


def studies(_: Transcript) -> dict[str, Study]:
    """The dictionaries of this section."""
    from ..dictionary.moments import particles
    from ..dictionary.neumann import (
        Attitude,
        Space,
        body_energy,
        left_handed_frame,
        principal_lines,
    )
    from ..dictionary.surfaces import Surfaces

    return {
        **Space(Surfaces.arbitrary()).studies(),
        "lines": principal_lines(),
        "energy": body_energy(),
        "energies": Attitude.arbitrary().study(),
        "left-handed": left_handed_frame(),
        "particles": particles(r"\mathfrak v^1", r"\mathbf G^{(M)}"),
    }


NEUMANN = Section(
    title="Rolling without slipping of a body over a surface in the Neumann variables",
    complete=True,
    label="Nvar",
    studies=studies,
    inline=(
        Display(r"$\omega=\omega_1+\omega_2+\omega_3$"),
        Display(r"$\mathfrak v^1=\mathfrak v+\mathfrak m$"),
        Display(r"$F=0, D'=0$", (LINES,)),
        Display(r"$F_1=0, D_1'=0$", (LINES,)),
        Display(r"$\mathfrak m_\mathbf n=0$"),
        Display(r"$\mathfrak m_\mathbf u=0$", (ROLLING,)),
        Display(r"$\mathfrak m_\mathbf v=0$", (ROLLING,)),
    ),
    sentences=SENTENCES,
    displays=(
        Display(
            r"""\begin{eqnarray}
&& x_1=x_1(u_1,v_1), \qquad y_1=y_1(u_1,v_1), \qquad z_1=z_1(u_1,v_1),\label{parametrizacija1}\\
&& x=x(u,v), \qquad \qquad y=y(u,v), \qquad \qquad z=z(u,v),\label{parametrizacija}
\end{eqnarray}""",
            (DEFINITION,),
        ),
        Display(
            r"""\begin{eqnarray*}
& \omega\colon  & \text{of $O\mathbf x\mathbf y\mathbf z$ with respect to $O_1\mathbf x_1\mathbf y_1\mathbf z_1$, i.e., the angular velocity of the body $\mathrm T$},\\
&  \omega_1 \colon & \text{of $O\mathbf x\mathbf y\mathbf z$ with respect to $M\mathbf u\mathbf v\mathbf n$},\\
&\omega_2  \colon &  \text{of $M\mathbf u\mathbf v\mathbf n$ with respect to $M\mathbf u_1\mathbf v_1\mathbf n_1$},\\
& \omega_3  \colon & \text{of $M\mathbf u_1\mathbf v_1\mathbf n_1$ with respect to $O_1\mathbf x_1\mathbf y_1\mathbf z_1$},
\end{eqnarray*}""",
            tuple(Check(sentence=line) for line in turns()),
        ),
        Display(
            r"""\begin{equation}\label{uobicajeno}
\omega \times \overrightarrow{OM}+\frac{d}{dt}\overrightarrow{O_1O}=0.
\end{equation}""",
            (ROLLING,),
        ),
        Display(
            r"""\begin{equation}\label{eq:nosliding1}
\mathfrak v^1=\mathfrak v.
\end{equation}""",
            (Check(study="rolling", constrains=2),),
        ),
        Display(
            r"""\begin{eqnarray}
&& s=-\frac{D''}{\sqrt{G}}\dot v- \frac{D''_1}{\sqrt{G_1}}\dot v_1\sin\vartheta-\frac{D_1}{\sqrt{E_1}}\dot u_1\cos\vartheta, \nonumber\\
&& \tau=\frac{D}{\sqrt{E}}\dot u- \frac{D_1}{\sqrt{E_1}}\dot u_1\sin\vartheta+\frac{D''_1}{\sqrt{G_1}}\dot v_1\cos\vartheta,\nonumber\\
&& n=-\dot \vartheta + \frac{1}{2\sqrt{E_1G_1}}\big(\frac{\partial E_1}{\partial v_1}\dot u_1- \frac{\partial G_1}{\partial u_1}\dot v_1\big)+\frac{1}{2\sqrt{EG}}\big(\frac{\partial E}{\partial v}\dot u- \frac{\partial G}{\partial u}\dot v\big),\label{eq:n}
\end{eqnarray}"""
        ),
        Display(
            r"""\begin{equation}\label{eq:nosliding2}
\sqrt{E_1}\dot u_1= - \sqrt{E} \dot u \sin \vartheta + \sqrt{G} \dot v \cos \vartheta, \quad \sqrt{G_1}\dot v_1= \sqrt{E} \dot u \cos \vartheta + \sqrt{G} \dot v \sin \vartheta.
\end{equation}""",
            (CONSTRAINT,),
        ),
        Display(
            r"""\begin{equation}\label{kineticka}
\mathbf T=\frac{\mathbf M}2\big(\mathbf w_\mathbf x^2+\mathbf w_\mathbf y^2+\mathbf w_\mathbf z^2\big) +\frac12\big(Ap^2+Bq^q+Cr^2\big).
\end{equation}""",
            (Check(study="energy"),),
        ),
        Display(
            r"""\begin{equation}\label{eq:lawmoments}
\dot{\mathfrak M}=\mathbf F, \qquad \dot{\mathbf G}^{(M)}+ [\mathfrak v^1, \mathfrak M]=\mathbf L^{(M)},
\end{equation}""",
            (Check(study="particles", cited="proved for three mass points"),),
        ),
        Display(
            r"""\begin{equation}\label{kineticka*}
\bar{\mathbf T}(\mathfrak m_\mathbf u,\mathfrak w_\mathbf v,\mathfrak m_\mathbf n, s, \tau,n)=\mathbf T(\mathbf w_\mathbf x,\mathbf w_\mathbf y,\mathbf w_\mathbf z,p,q,r),
\end{equation}""",
            (Check(study="energies"),),
        ),
    ),
)
