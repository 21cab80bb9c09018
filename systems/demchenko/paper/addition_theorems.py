"""Elliptic functions and addition theorems: the displays as printed, and what they are compared with."""

from __future__ import annotations

from voronec.audit import Check, Display, Section, Study, Transcript

from ..sentences.inversion import ADDITION as SENTENCES


def law(study: str, printed: str, value: str) -> Check:
    """An identity; printed beside it is the derived value of ``printed``."""
    return Check(
        study=study,
        derived=lambda study, where: [(printed, getattr(study.context, value))],
    )


AT_THE_SUM = law("sum", r"\wp(u+\zeta)", "wp")
OF_SIGMA = law("difference", r"\frac{\sigma(u-v)\sigma(u+v)}{\sigma(u)^2\sigma(v)^2}", "sigma")
OF_ZETA = law("difference", r"\zeta(u+v)-\zeta(u)-\zeta(v)", "zeta")


def studies(_: Transcript) -> dict[str, Study]:
    r"""Two dictionaries: ``\zeta`` is an argument in the first, a function in the second."""
    from ..dictionary.weierstrass import addition_studies

    return addition_studies()


ADDITION_THEOREMS = Section(
    title="Elliptic functions and addition theorems",
    complete=True,
    label=None,
    studies=studies,
    sentences=SENTENCES,
    displays=(
        Display(
            r"""\begin{equation}\label{eq:addition1}
\wp(u+\zeta)+\wp(u)+\wp(\zeta)
 =
\frac14
 \left(
\frac{\wp'(u)-\wp'(\zeta)}{\wp(u)-\wp(\zeta)}
 \right)^2.
\end{equation}""",
            (AT_THE_SUM,),
        ),
        Display(
            r"""\begin{equation}\label{eq:addition2}
\wp'(\zeta)\frac{\wp'(u)-\wp'(\zeta)}{\wp(u)-\wp(\zeta)}=\wp''(\zeta)-2(\wp(u)-\wp(\zeta))(\wp(u+\zeta)-\wp(\zeta))
\end{equation}""",
            (AT_THE_SUM,),
        ),
        Display(
            r"""$$
\wp(u)-\wp(v)=-\frac{\sigma(u-v)\sigma(u+v)}{\sigma(u)^2\sigma(v)^2},
$$""",
            (OF_SIGMA,),
        ),
        Display(
            r"""$$
\frac {\wp'(u)}{\wp(u)-\wp(v)}=\zeta(u-v)+\zeta(u+v)-2\zeta(u).
$$""",
            (OF_ZETA,),
        ),
    ),
)
