"""Connections, curvature, the invariant form: the displays as printed, and their checks."""

from __future__ import annotations

from typing import Any

from voronec.audit import Check, Convention, Study

from ..dictionary.geometry import CURVATURE_SOURCE  # noqa: F401  (named in the print)
from ..transcription import displays

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

DALEMBERT = (dalembert(),)
INVARIANT_FORM = (invariant_form(),)

DISPLAYS = displays(__file__, globals())

INLINE = displays(__file__, globals(), "inline")
