"""Finished verdicts are kept, reused only while nothing they rest on changes, and never trusted
when the file is broken."""

from __future__ import annotations

from dataclasses import replace

import pytest
import sympy as sp

from voronec.audit import Cache, Display, Paper, Section, Study, audit_paper
from voronec.audit import cache as cache_module
from voronec.audit.cache import section_key
from voronec.catalogue import load_paper_file


def paper(made, *latex):
    def studies(_):
        made.append(1)
        return {"only": Study({"x": sp.Symbol("x")})}

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

    whole = paper(made, "x+x=2x", "x=2x", "3x=3x")
    with pytest.raises(KeyboardInterrupt):
        audit_paper(whole, stop, cache)
    assert sorted(f.name for f in tmp_path.rglob("*.json")) == ["1.json", "2.json"]
    audit = audit_paper(whole, cache=cache)
    assert [r.verdict for r in audit.records] == ["proved", "misprint", "proved"]


def test_another_print_or_another_engine_is_another_audit(tmp_path, monkeypatch):
    made, cache = [], Cache(tmp_path)
    audit_paper(paper(made, "x+x=2x"), cache=cache)
    audit_paper(paper(made, "x+x=3x"), cache=cache)
    assert len(made) == 2
    monkeypatch.setattr(cache_module, "_engine", lambda: "another engine")
    audit_paper(paper(made, "x+x=2x"), cache=cache)
    assert len(made) == 3


def test_a_changed_dictionary_is_another_audit(tmp_path):
    source = """
import sympy
from voronec.audit import Display, Paper, Section, Study

def studies(_):
    return {{"only": Study({{"x": sympy.Integer({value})}})}}

PAPER = Paper("p", "", (Section("s", (Display("$x=x^2$"),), studies),))
"""
    keys = []
    for value in ("1", "2"):
        file = tmp_path / "sheet.py"
        file.write_text(source.format(value=value))
        keys.append(section_key(load_paper_file(file).sections[0]))
    assert keys[0] != keys[1]


def test_a_broken_file_is_no_verdict(tmp_path):
    made, cache = [], Cache(tmp_path)
    whole = paper(made, "x+x=2x")
    audit_paper(whole, cache=cache)
    for file in tmp_path.rglob("*.json"):
        file.write_text("[{]")
    assert audit_paper(whole, cache=cache).records[0].verdict == "proved"


def test_a_folder_that_cannot_be_written_costs_only_time(tmp_path):
    (tmp_path / "file").write_text("")
    cache = Cache(tmp_path / "file" / "below")
    assert audit_paper(paper([], "x+x=2x"), cache=cache).records[0].verdict == "proved"


def test_a_misprint_comes_back_from_the_cache_with_all_its_marks(tmp_path):
    cache = Cache(tmp_path)
    first = audit_paper(paper([], "2x=x+x+x-x-1+1+x"), cache=cache)
    again = audit_paper(paper([], "2x=x+x+x-x-1+1+x"), cache=cache)
    assert first.records == again.records
    assert replace(first.records[0].formulas[0], seconds=0.0) == again.records[0].formulas[0]


def test_only_so_many_sections_are_kept(tmp_path, monkeypatch):
    monkeypatch.setattr(cache_module, "KEPT", 2)
    for latex in ("x=x", "2x=x+x", "3x=2x+x", "4x=3x+x"):
        audit_paper(paper([], latex), cache=Cache(tmp_path))
    assert len(list(tmp_path.iterdir())) == 3
