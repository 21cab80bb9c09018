"""Connections, curvature, the invariant form: the displays as printed, and their checks."""

from __future__ import annotations

from typing import Any

from voronec.audit import Check, Convention, Display, Study

from ..dictionary.geometry import CURVATURE_SOURCE

ANY_ENERGY = "Lagrange's derivatives of any kinetic and potential energy"
SPACE = Check(study="space")
DEFINITION = Check("definition", study="space")


def opposite(x: Any, y: Any) -> Any:
    """B(X, Y) with the other sign."""
    from ..dictionary.geometry import opposite as changed

    return changed(x, y)


CONVENTION = Convention(
    r"B has the components $+A^{(\nu)}_{ij}$; there the sign of $B_{ij}^\nu$ in local coordinates, "
    r"of $B_{ij}^\nu=-A^{(\nu)}_{ij}$ and of the last term of (v4*) is the opposite one; else the "
    r"minus sign of $B(X,Y)=-A([X^h,Y^h])$ must go, and the right side of (v5*) needs one",
    r"the components $B_{ij}^\nu$ in local coordinates, $B_{ij}^\nu=-A^{(\nu)}_{ij}$, v4*",
    {r"B(\cdot)": opposite},
)


def studies() -> dict[str, Study]:
    """The dictionaries: the general system, Chaplygin systems, a flow on a torus."""
    from ..dictionary.geometry import geometry
    from ..dictionary.reductions import Chaplygin, fibre_study, torus_study

    general = geometry()
    return {
        "motion": general.study(),
        "space": general.space(),
        "applied": general.lagrangian_study(),
        "invariant": general.invariant(),
        "fibre": fibre_study(),
        "abelian": Chaplygin.derive(0).study(),
        "affine group": Chaplygin.derive(1).study(),
        "torus": torus_study(),
    }


def dalembert() -> Check:
    """Compare with d'Alembert's principle."""
    return Check(
        truth=lambda study, where: study.context.dalembert(where),
        derived=lambda study, where: study.context.structure(),
    )


def invariant_form() -> Check:
    """Compare with d'Alembert's principle, for all virtual displacements at once."""
    return Check(
        study="invariant",
        truth=lambda study, where: study.context.virtual_work(),
        derived=lambda study, where: study.context.right_side(),
        convention=CONVENTION,
    )


CITATION = Check(study="torus", cited="that motions over invariant tori have this form is quoted")

DISPLAYS = (
    Display(
        r"""\[
T_q Q=\mathcal D_q \oplus \mathcal V_q, \qquad \mathcal V_q=\ker d\pi(q).
\]""",
        (SPACE, SPACE),
    ),
    Display(
        r"""\[
B(X,Y)=-A([X^h,Y^h])
\]""",
        (Check(study="space", convention=CONVENTION),),
    ),
    Display(
        r"""\begin{eqnarray*}
&& \pi\colon (q_1,\dots,q_n,q_{n+1},\dots,q_{n+k}) \longmapsto (q_1,\dots,q_n),\\
&& A=\sum_{\nu=1}^k \omega^\nu \frac{\partial}{\partial q_{n+\nu}}, \quad \omega^\nu=dq_{n+\nu}-\sum_{i=1}^n a_{\nu i} dq_i, \\
&& B=\sum_{\nu=1}^k B^\nu\frac{\partial}{\partial q_{n+\nu}}, \quad B^\nu=\sum_{1\le i<j\le n} B^\nu_{ij} dq_i\wedge dq_j,\\
&& B_{ij}^{\nu}=  - \big(\frac{\partial a_{\nu i}}{\partial q_j}+\sum_{\mu=1}^k a_{\mu j}\frac{\partial a_{\nu i}}{\partial q_{n+\mu}}\big)
                   +\big(\frac{\partial a_{\nu j}}{\partial q_i}+\sum_{\mu=1}^k a_{\mu i}\frac{\partial a_{\nu j}}{\partial q_{n+\mu}}\big),
\end{eqnarray*}""",
        (DEFINITION, SPACE, SPACE, SPACE, SPACE, SPACE),
    ),
    Display(
        r"""\begin{equation}
\frac{d}{dt}\frac{\partial L_c}{\partial \dot q_i}=\frac{\partial L_c}{\partial q_i} +\sum_{\nu=1}^k a_{\nu i}\frac{\partial L_c}{\partial q_{n+\nu}}
-\sum_{\nu=1}^k\sum_{j=1}^n\frac{\partial L}{\partial q_{n+\nu}} B_{ij}^{\nu} \dot q_j \quad (i=1,\dots,n), \label{v4*}
\end{equation}""",
        (dalembert(),),
    ),
    Display(
        r"""\begin{eqnarray}\label{v5*}
\delta L_c=\mathbb FL( B(\dot q,\delta q))
\end{eqnarray}""",
        (invariant_form(),),
    ),
    Display(
        r"""\[
\delta q=\sum_{s=1}^{n+k} \delta q_s\frac{\partial}{\partial q_s}\in \mathcal D_q.
\]""",
        (DEFINITION,),
    ),
    Display(
        r"""\begin{equation*}
\delta L_c=\sum_{s=1}^{n+k}\big(\frac{\partial L_c}{\partial q_s}-\frac{d}{dt}\frac{\partial L_c}{\partial \dot q_s}\big)\delta q_s,
\quad \mathbb FL( B(\dot q,\delta q))=\sum_{\nu=1}^k \frac{\partial L}{\partial \dot q_{n+\nu}}B^\nu(\dot q,\delta q),
\end{equation*}""",
        (Check("definition", source=ANY_ENERGY), Check("definition", study="fibre")),
    ),
    Display(
        r"""\begin{equation}
\delta L_{red}=\sum_{i=1}^n\big(\frac{\partial L_{red}}{\partial x_i}-\frac{d}{dt}\frac{\partial L_{red}}{\partial
\dot x_i}\big)\delta x_i= JK(\dot x,\delta x)\quad
\mathrm{for\;all} \quad \delta x\in T_x S,
\label{ChaplyginRed}
\end{equation}""",
        (Check(study="abelian", also=("affine group",)),),
    ),
    Display(
        r"""\begin{equation}
\dot\varphi_1=\omega_1/\Phi(\varphi_1,\dots,\varphi_m),\dots,
\dot\varphi_m=\omega_m/\Phi(\varphi_1,\dots,\varphi_m), \qquad \Phi>0.
\label{Jacobi2}
\end{equation}""",
        (CITATION, CITATION, Check("definition", study="torus")),
    ),
)

INLINE = (
    Display(r"$A(X_q)=X_q$", (SPACE,)),
    Display(r"$B_{ij}^\nu=-A^{(\nu)}_{ij}$", (Check(study="space", source=CURVATURE_SOURCE),)),
    Display(
        r"$Q_s=-{\partial V}/{\partial q_s}$",
        (Check("definition", source=ANY_ENERGY),),
    ),
    Display(
        r"$L(q,\dot q)=T(q,\dot q)-V(q)$",
        (Check("definition", study="applied", source=ANY_ENERGY),),
    ),
    Display(r"$L_c=L(q,\dot q^h)=\Theta-V$", (Check(study="applied"),)),
    Display(r"$L=T-V$", (Check("definition", source=ANY_ENERGY),)),
)
