"""The audit that the documentation carries is that of the transcription, and all of one piece."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest
from demchenko_audit import records_of

import voronec as vo
from voronec.audit import Audit, Paper, Section, Transcript, load_paper
from voronec.audit.page.article import audit_latex

pytestmark = pytest.mark.slow

TOOLS = Path(__file__).resolve().parent.parent / "tools"
STALE = "run: python tools/build.py audit"


@pytest.fixture(name="build", scope="module")
def _build() -> Iterator[ModuleType]:
    sys.path.insert(0, str(TOOLS))
    try:
        from pages import audit

        yield audit
    finally:
        sys.path.remove(str(TOOLS))
        sys.modules.pop("pages.audit", None)


@pytest.fixture(name="paper", scope="module")
def _paper(build: ModuleType) -> Paper:
    found = load_paper(build.PAPER)
    assert isinstance(found, Paper)
    return found


@pytest.fixture(name="audit", scope="module")
def _audit(build: ModuleType, paper: Paper) -> Audit:
    found = build.read_audit(build.FOLDER, paper)
    assert isinstance(found, Audit)
    return found


def transcribed(section: Section) -> list[tuple[str, str | None, str, list[str]]]:
    """Kind, label, source and formulas of each record that the section has to have."""
    units: dict[int, list] = {}
    for formula in Transcript(section).formulas():
        units.setdefault(id(formula.unit), []).append(formula)
    found = [
        (several[0].kind, several[0].unit.label, several[0].unit.source,
         [formula.printed for formula in several])
        for several in units.values()
    ]  # fmt: skip
    return found + [("text", None, claim.quotation, [""]) for claim in section.sentences]


def test_every_formula_and_claim_of_the_transcription_has_its_record(
    audit: Audit, paper: Paper
) -> None:
    for section in paper.sections:
        records = [r for r in audit.records if r.section == section.title]
        found = [(r.kind, r.label, r.printed, [f.printed for f in r.formulas]) for r in records]
        assert found == transcribed(section), STALE
    assert {r.section for r in audit.records} <= {s.title for s in paper.sections}, STALE


def test_the_page_and_the_article_are_made_of_the_data(
    build: ModuleType, audit: Audit, tmp_path: Path
) -> None:
    build.write_pages(tmp_path)
    page, article = (tmp_path / name for name in ("report.html", "report.tex"))
    assert vo.load(build.PAPER).scenes["default"].caption in page.read_text("utf-8")
    for record in audit.records:
        assert record.designation in page.read_text("utf-8")
    assert article.read_text("utf-8") == audit_latex(audit)
    assert json.loads((tmp_path / "report.json").read_text("utf-8")) == json.loads(
        (build.FOLDER / "report.json").read_text("utf-8")
    )


def test_the_documentation_lists_these_errata(
    build: ModuleType, audit: Audit, paper: Paper
) -> None:
    page = build.PAGE.read_text("utf-8")
    assert build.paste(page, build.summary(audit, paper)) == page, STALE


def test_a_section_audited_anew_has_the_verdicts_that_are_kept(audit: Audit, paper: Paper) -> None:
    section = next(s for s in paper.sections if s.label == "ballGyr")
    kept = [r for r in audit.records if r.section == section.title]
    assert list(records_of(section.title)) == kept, STALE


WORDS = re.compile(r"\\([a-zA-Z]+)|([a-zA-Z])")
SIGNS = set(
    "frac tfrac sqrt left right sin cos partial dot det quad langle rangle le cdot times int sum "
    "in or mathbf mathfrak mathbb mathcal bar tilde overrightarrow delta big Big d".split()
)


def heads(latex: str) -> set[str]:
    """The letters of a formula, without its commands."""
    bare = re.sub(r"\\(?:text|begin|end|mathrm)\{[^}]*\}", " ", latex)
    return {a or b for a, b in WORDS.findall(bare)} - SIGNS


def test_letters_that_are_not_the_papers_are_explained(audit: Audit) -> None:
    """Those of print anywhere, and sigma, a tensor that its own formula defines, are known."""
    printed = {r.section: set[str]() for r in audit.records}
    for record in audit.records:
        printed[record.section] |= heads(record.printed)
    theirs = {"mu", "A", "E", "Sigma"}
    for record in audit.records:
        for formula in record.formulas:
            said = heads(" ".join(re.findall(r"\$[^$]*\$", formula.method)))
            strange = heads(formula.derived or "") - printed[record.section] - said - theirs
            assert not strange, (record.designation, record.section)


def test_it_is_small_enough_to_be_carried(build: ModuleType) -> None:
    assert sum(file.stat().st_size for file in build.FOLDER.iterdir()) < 2_000_000
