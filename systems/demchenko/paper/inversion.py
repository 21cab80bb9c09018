"""Inversion of elliptic integrals: the displays as printed, and what they are compared with."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from voronec.audit import Check, Convention, Display, Section, Study, Transcript

from ..sentences.inversion import INVERSION as SENTENCES


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


INVERSION = Section(
    title="Inversion of elliptic integrals",
    complete=True,
    label=None,
    studies=studies,
    inline=(
        Display(r"$x=y+h$", (Check("definition", study="x"),)),
        Display(r"$x=y-a_1/a_0$", (OF_X,)),
    ),
    sentences=SENTENCES,
    displays=(
        Display(
            r"""$$
2y = \frac{\wp'(u)-\wp'(\zeta)}{\wp(u)-\wp(\zeta)}.
$$""",
            (FRACTION,),
        ),
        Display(
            r"""$$
y^2-3\wp(\zeta)=(\wp(u)-\wp(\zeta))+(\wp(u+\zeta)-\wp(\zeta)),
$$""",
            (SUM,),
        ),
        Display(
            r"""$$
\wp''(\zeta)-2y\wp'(\zeta)=2(\wp(u)-\wp(\zeta))(\wp(u+\zeta)-\wp(\zeta)).
$$"""
        ),
        Display(
            r"""$$
Y=(y-3\wp(\zeta))^2+2(2y\wp'(\zeta)-\wp''(\zeta).
$$""",
            (
                beside(
                    QUARTIC,
                    role="definition",
                    # a bracket, too, is not closed in print
                    proposal=r"Y=(y^2-3\wp(\zeta))^2+2(2y\wp'(\zeta)-\wp''(\zeta))",
                ),
            ),
        ),
        Display(
            r"""$$
Y=(\wp(u+\zeta)-\wp(u))^2.
$$"""
        ),
        Display(
            r"""$$
\sqrt{Y}=\wp(u+\zeta)-\wp(u),
$$""",
            (Check(convention=BRANCH),),
        ),
        Display(
            r"""$$
Y= y^4-6y^2\wp(\zeta)+4y\wp'(\zeta)+9\wp(\zeta)-2\wp''(\zeta).
$$""",
            (beside(QUARTIC),),
        ),
        Display(
            r"""$$
X(x)=a_0x^4+4a_1x^3+6a_2x^2+4a_3x+a_4.
$$""",
            (POLYNOMIAL,),
        ),
        Display(
            r"""$$
\wp(\zeta)=\frac{{a_1}^2-a_0a_2}{{a_0}^2}, \quad \wp'(\zeta)=\frac{{a_0}^2a_3-3a_0a_1a_2+2a_1^3}{a_0^3}
$$""",
            AT_C,
        ),
        Display(
            r"""$$
x=-\frac{a_1}{a_0}+\frac{1}{2}\frac{\wp'(u)-\wp'(\zeta)}{\wp(u)-\wp(\zeta)}, \quad \sqrt{X}=\sqrt{a_0}(-\wp(u+\zeta)+\wp(u)).
$$""",
            (OF_X,),
        ),
        Display(
            r"""$$
-\wp(u+\zeta)+\wp(u)=\frac{1}{2}\frac{d}{du}
\frac{\wp'(u)-\wp'(\zeta)}{\wp(u)-\wp(\zeta)},
$$"""
        ),
        Display(
            r"""$$
\sqrt{X}=\sqrt{a_0}\frac{dx}{du}.
$$""",
            (OF_X,),
        ),
        Display(
            r"""$$
\frac{u}{\sqrt{a_0}}=\int\frac {dx}{\sqrt X}.
$$""",
            (OF_X,),
        ),
    ),
)
