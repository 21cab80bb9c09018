"""The pages of the systems are those of today's declarations, and of proved claims."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

from voronec.declaration.bibliography import citation, read_entries
from voronec.proof.check import Inventory, Result

pytestmark = pytest.mark.slow

TOOLS = Path(__file__).resolve().parent.parent / "tools"
STALE = "run: python tools/build.py pages"


@pytest.fixture(name="build", scope="module")
def _build() -> Iterator[ModuleType]:
    sys.path.insert(0, str(TOOLS))
    try:
        from pages import systems

        yield systems
    finally:
        sys.path.remove(str(TOOLS))


@pytest.fixture(name="stock", scope="module")
def _stock() -> Inventory:
    return Inventory.of()


@pytest.fixture(name="results", scope="module")
def _results(build: ModuleType) -> list[Result]:
    found: list[Result] = build.read_results()
    return found


def outline(page: str) -> list[str]:
    """Its headings, and the first column of its tables: what is declared, by name."""
    rows = [line.strip() for line in page.splitlines()]
    return [r for r in rows if r.startswith("#")] + [r.split("|")[1] for r in rows if r[:1] == "|"]


def test_the_pages_say_what_is_declared(
    build: ModuleType, stock: Inventory, results: list[Result], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Their equations are left to ``test_readable_equations``: here none is derived."""
    no_equations = SimpleNamespace(in_normal_form=False)
    monkeypatch.setattr("pages.system_page.derive", lambda _: no_equations)
    expected = build.pages(stock, results)
    found = {page.name for page in build.FOLDER.glob("*.md")}
    assert found == set(expected), STALE
    for name, text in expected.items():
        page = (build.FOLDER / name).read_text("utf-8")
        assert outline(page) == outline(text), f"{name} is stale; {STALE}"


def test_lists_and_pages_count_claims_alike(stock: Inventory, results: list[Result]) -> None:
    own = {r.name: len(r.findings) for r in results if r.kind == "system"}
    assert {name: s.claims for name, s in stock.contents.systems.items() if name in own} == {
        name: own[name] for name in stock.contents.systems if name in own
    }


def test_every_claim_relation_and_square_has_its_verdict(
    stock: Inventory, results: list[Result]
) -> None:
    own = {r.name: r for r in results if r.kind == "system"}
    for name, system in stock.systems.items():
        decided = {f.name for f in own[name].findings}
        assert {*system.integrals, *system.equations} <= decided, f"{name}; {STALE}"
    kinds = {kind: {r.name for r in results if r.kind == kind} for kind in ("relation", "square")}
    assert kinds["relation"] == {r.label for r in stock.relations}, STALE
    assert kinds["square"] == {s.label for s in stock.faces}, STALE


def test_nothing_failed_and_what_is_open_has_a_reason(results: list[Result]) -> None:
    assert results
    for result in results:
        assert not result.failures, (result.name, result.failures)


def test_a_citation_is_a_line_of_text() -> None:
    entry = """@article{Key,
  author  = {Demchenko, Vasilije and Bilimovi\\'c, Anton},
  title   = {Rouler sans {G}lissement},
  journal = {Matemati\\v{c}ki Vesnik},
  volume  = {3},
  year    = {1924},
  pages   = {1--6},
  note    = {In French}
}"""
    assert citation(entry) == (
        "Vasilije Demchenko and Anton Bilimovi\u0107 (1924). Rouler sans Glissement. "
        "Matemati\u010dki Vesnik 3, 1\u20136. In French."
    )


def test_an_entry_may_stand_on_one_line_and_in_quotation_marks() -> None:
    entry = (
        "@article{K, author={Y, X and Z W}, title={A {B} c}, journal={J}, year={1999}, volume={3}}"
    )
    assert citation(entry) == "X Y and Z W (1999). A B c. J 3."
    assert citation('@book{K, author = "X Y", title = "A {B}, c", year = 1999}') == (
        "X Y (1999). A B, c."
    )


def test_entries_are_found_however_they_are_laid_out() -> None:
    text = """  @Book { K , date-added={2020}, title={T}} @misc{L, note={a
@misc{N, x} b}, title={S}}"""
    found = read_entries(text)
    assert list(found) == ["K", "L"]
    assert citation(found["K"]) == " (n. d.). T."
    assert citation(found["L"]) == " (n. d.). S. a @miscN, x b."


def test_names_have_their_letters_in_a_citation() -> None:
    entry = r"@book{K, author={J{\k e}drzej N{\o}rsett and {\L}ukasz \k{A}}, title={\kappa}}"
    assert citation(entry) == "Jędrzej Nørsett and Łukasz Ą (n. d.). \\kappa."


def test_help_on_a_kind_of_tool_does_none_of_its_work(
    build: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from shared.kinds import run

    monkeypatch.setattr(build, "main", lambda: pytest.fail("it works"))
    monkeypatch.setattr(sys, "argv", ["build.py", "pages", "--help"])
    assert run("all kinds", {"pages": "pages.systems"}) == 0
    assert capsys.readouterr().out.startswith("Rebuild the pages of the systems")
