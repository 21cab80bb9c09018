"""Elliptic functions and addition theorems: the displays as printed, and what they are compared with."""

from __future__ import annotations

from voronec.audit import Check, Section, Study, Transcript

from ..sentences.inversion import ADDITION as SENTENCES
from ..transcription import displays


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
    displays=displays(__file__, globals()),
)
