"""Finished verdicts are kept, reused only while nothing they rest on changes, and never trusted
when the file is broken."""

from __future__ import annotations

import pytest
import sympy as sp

from voronec.audit import Cache, Display, Paper, Section, Study, audit_paper
from voronec.audit import cache as cache_module
from voronec.audit.cache import Basis

pytestmark = pytest.mark.slow


def paper(made, *latex):
    def studies(_):
        made.append(1)
        x = sp.Symbol("x")
        return {"only": Study({"x": x, "y": 2 * x})}

    return Paper("p", "", (Section("s", tuple(Display(f"${x}$") for x in latex), studies),))


def test_a_finished_audit_is_not_done_again(tmp_path):
    made, cache = [], Cache(tmp_path)
    first = audit_paper(paper(made, "x+x=2x", "x=2x"), cache=cache)
    second = audit_paper(paper(made, "x+x=2x", "x=2x"), cache=cache)
    assert first == second
    assert len(made) == 1, "the dictionary is not even derived"


def test_what_was_finished_before_an_interrupt_is_kept(tmp_path):
    made, cache, seen = [], Cache(tmp_path), []

    def stop(place, verdict):
        seen.append(place)
        if len(seen) == 2:
            raise KeyboardInterrupt

    whole = paper(made, "x+x=2x", "x=2x", "2x+x=3x")
    with pytest.raises(KeyboardInterrupt):
        audit_paper(whole, stop, cache)
    assert sorted(f.name for f in tmp_path.rglob("*.json")) == ["1.json", "2.json"]
    audit = audit_paper(whole, cache=cache)
    assert [r.verdict for r in audit.records] == ["proved", "misprint", "proved"]


def test_another_print_is_another_audit(tmp_path):
    made, cache = [], Cache(tmp_path)
    audit_paper(paper(made, "x+x=2x"), cache=cache)
    audit_paper(paper(made, "x+x=3x"), cache=cache)
    assert len(made) == 2


def test_sources_that_are_edited_during_an_audit_leave_nothing_behind(tmp_path, monkeypatch):
    states = iter(["before", "after", "after"])
    monkeypatch.setattr(Basis, "digest", lambda self: next(states))
    audit_paper(paper([], "x+x=2x"), cache=Cache(tmp_path))
    assert not list(tmp_path.rglob("*.json"))


def test_a_broken_file_is_no_verdict(tmp_path):
    made, cache = [], Cache(tmp_path)
    whole = paper(made, "x+x=2x")
    audit_paper(whole, cache=cache)
    for file in tmp_path.rglob("*.json"):
        file.write_text("[{]")
    with pytest.warns(UserWarning, match="is damaged; it is made anew"):
        assert audit_paper(whole, cache=cache).records[0].verdict == "proved"


def test_a_folder_that_cannot_be_written_costs_only_time(tmp_path):
    (tmp_path / "file").write_text("")
    cache = Cache(tmp_path / "file" / "below")
    assert audit_paper(paper([], "x+x=2x"), cache=cache).records[0].verdict == "proved"


def test_a_misprint_comes_back_from_the_cache_with_all_its_marks(tmp_path):
    cache = Cache(tmp_path)
    first = audit_paper(paper([], "y=x+2-2"), cache=cache)
    again = audit_paper(paper([], "y=x+2-2"), cache=cache)
    assert first.records == again.records
    assert first.records[0].formulas[0].changes == again.records[0].formulas[0].changes != ()


def test_only_so_many_sections_are_kept(tmp_path, monkeypatch):
    monkeypatch.setattr(cache_module, "SECTIONS", 2)
    for latex in ("x=x", "2x=x+x", "3x=2x+x", "4x=3x+x"):
        audit_paper(paper([], latex), cache=Cache(tmp_path))
    assert len(list(tmp_path.iterdir())) == 2


def test_a_draft_that_was_never_finished_is_no_verdict(tmp_path, monkeypatch):
    def stopped(draft, target):
        raise KeyboardInterrupt

    monkeypatch.setattr("os.replace", stopped)
    with pytest.raises(KeyboardInterrupt):
        audit_paper(paper([], "x+x=2x"), cache=Cache(tmp_path))
    assert not list(tmp_path.rglob("*.json"))
