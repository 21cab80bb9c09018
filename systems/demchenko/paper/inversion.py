"""Inversion of elliptic integrals: the displays as printed, and what they are compared with."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from voronec.audit import Check, Convention, Section, Study, Transcript

from ..sentences.inversion import INVERSION as SENTENCES
from ..transcription import displays


def beside(
    *pairs: tuple[str, Callable[[Any], Any]],
    role: str = "claim",
    study: str = "",
    proposal: str | None = None,
) -> Check:
    """A check beside which values are printed that the curve of the dictionary gives."""
    return Check(
        role,
        study,
        proposal=proposal,
        derived=lambda study, where: [(left, value(study.context)) for left, value in pairs],
    )


OF_X = Check(study="x")
FRACTION = beside((r"2y", lambda curve: 2 * curve.fraction), role="definition")
SUM = beside((r"\wp(u)+\wp(u+\zeta)", lambda curve: curve.at_u[0] + curve.at_sum[0]))
QUARTIC = ("Y", lambda curve: curve.polynomial)
AT_C = (
    beside((r"\wp(\zeta)", lambda curve: curve.at_c[0]), study="x"),
    beside((r"\wp'(\zeta)", lambda curve: curve.at_c[1]), study="x"),
)
POLYNOMIAL = beside(("X(x)", lambda _: r"a_0Y(x-h)"), role="definition", study="polynomial")


def studies(_: Transcript) -> dict[str, Study]:
    """The dictionaries of this section."""
    from ..dictionary.inversion import inversion_studies

    return inversion_studies()


def where_y_falls(argument: Any) -> Any:
    """The function of Weierstrass on the other branch of the root."""
    from ..dictionary.inversion import other_branch

    return other_branch(argument)


BRANCH = Convention(
    statement=r"the root has the sign of $-\frac{dy}{du}$; with the sign that the later formulas "
    r"need it is $\sqrt{Y}=\wp(u)-\wp(u+\zeta)$",
    against=r"$\sqrt{X}=\sqrt{a_0}(-\wp(u+\zeta)+\wp(u))$, $\sqrt{X}=\sqrt{a_0}\frac{dx}{du}$",
    names={r"\wp": where_y_falls},
)


SQUARE_ROWS = (
    beside(
        QUARTIC,
        role="definition",
        # a bracket, too, is not closed in print
        proposal=r"Y=(y^2-3\wp(\zeta))^2+2(2y\wp'(\zeta)-\wp''(\zeta))",
    ),
)
QUARTIC_ROW = (beside(QUARTIC),)

INVERSION = Section(
    title="Inversion of elliptic integrals",
    complete=True,
    label=None,
    studies=studies,
    inline=displays(__file__, globals(), "inline"),
    sentences=SENTENCES,
    displays=displays(__file__, globals()),
)
