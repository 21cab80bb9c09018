"""The report of an audit: plain data, a table, a page, a LaTeX article."""

from __future__ import annotations

import json
import re
from xml.etree import ElementTree

import pytest

from voronec import DefinitionError
from voronec.audit import Audit, FormulaRecord, Record
from voronec.report.audit_latex import coloured
from voronec.report.audit_report import Figure, audit_table, write_audit
from voronec.report.mathml import mathml

PROVED = FormulaRecord(r"a=\frac12b<c", "proved", "zero in exact normal form", "a = b/2")
WRONG = FormulaRecord(
    "A_j=B_i",
    "misprint",
    "refuted as printed",
    "A_1 = B_1",
    "A_i=B_i",
    ((2, 3),),
    ((2, 3),),
    {"point": {"x": "1/3"}, "printed": "0.1", "derived": "0.2", "indices": {"i": 1, "j": 2}},
)
AUDIT = Audit(
    "p",
    "On <balls> & spheres",
    (
        Record("one", "First", 1, PROVED.printed, (PROVED,)),
        Record(None, "First", 2, r"\[A_j=B_i, a=b\]", (PROVED, WRONG)),
    ),
)


def test_the_data_has_a_list_with_the_promised_fields(tmp_path):
    write_audit(AUDIT, tmp_path)
    first, second = json.loads((tmp_path / "report.json").read_text("utf-8"))
    keys = "label section ordinal printed derived verdict correction witness method".split()
    assert list(first)[:9] == keys
    assert (first["label"], first["verdict"], first["correction"]) == ("one", "proved", None)
    assert (second["label"], second["verdict"], second["ordinal"]) == (None, "misprint", 2)
    assert second["correction"] == "A_i=B_i"
    assert second["witness"]["printed"] == "0.1"
    assert [f["verdict"] for f in second["formulas"]] == ["proved", "misprint"]


def test_the_table_has_a_line_a_display_and_spells_out_errata():
    table = audit_table(AUDIT, 60)
    assert all(len(line) <= 60 for line in table.splitlines())
    assert re.search(r"^\(one\) +proved ", table, re.MULTILINE)
    assert re.search(r"^display 2 +misprint ", table, re.MULTILINE)
    assert "2 displays: 1 misprint, 1 proved" in table
    assert "for   A_j=B_i" in table
    assert "read  A_i=B_i" in table
    assert "as printed  0.1  for i = 1, j = 2" in table


def test_the_page_is_complete_offline_and_marks_the_difference(tmp_path):
    picture = tmp_path / "trace.svg"
    picture.write_text("<svg xmlns='http://www.w3.org/2000/svg'/>")
    write_audit(AUDIT, tmp_path / "out", [Figure(picture, "The trace")])
    page = (tmp_path / "out" / "report.html").read_text("utf-8")
    assert not re.search(r"(?:src|href)=\"?https?:", page)
    assert "On &lt;balls&gt; &amp; spheres" in page
    assert "data:image/svg+xml;base64," in page
    assert page.index("Errata") < page.index("First</h2>")
    assert '<mi class="struck">j</mi>' in page
    assert '<mi class="mended">i</mi>' in page


def test_the_article_colours_the_difference(tmp_path):
    write_audit(AUDIT, tmp_path)
    text = (tmp_path / "report.tex").read_text("utf-8")
    assert r"A_{\color{misprint}j}=B_i" in text
    assert r"A_{\color{mended}i}=B_i" in text
    assert r"On <balls> \& spheres" in text
    assert text.count("{") == text.count("}")
    assert text.rstrip().endswith(r"\end{document}")


def test_a_group_stays_a_group_when_it_is_coloured():
    assert coloured(r"q_{n+\nu}", ((2, 9),), "mended") == r"q_{\color{mended}n+\nu}"


@pytest.mark.parametrize(
    ("latex", "expected"),
    [
        (r"\frac12", "<mfrac><mrow><mn>1</mn></mrow><mrow><mn>2</mn></mrow></mfrac>"),
        (r"q_{ij}^{2}", "<msubsup><mi>q</mi><mrow>"),
        (r"\mu'", '<mrow><mi>μ</mi><mo lspace="0" rspace="0">′</mo></mrow>'),
        (r"\sum_{i=1}^n", "<munderover><mo>∑</mo>"),
        (r"\dot u", '<mover accent="true"><mi>u</mi><mo>˙</mo></mover>'),
        (r"\mathbf M", "<mi>\U0001d40c</mi>"),
        (r"\mathfrak M", "<mi>\U0001d510</mi>"),
        (r"a<b", "<mo>&lt;</mo>"),
    ],
)
def test_mathml(latex, expected):
    found = mathml(latex)
    assert expected in found
    ElementTree.fromstring(found)


def test_what_cannot_be_typeset_is_shown_as_its_source():
    assert mathml(r"\frac{a<") == r'<code class="latex">\frac{a&lt;</code>'


def test_a_folder_that_cannot_be_written_is_refused(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("")
    with pytest.raises(DefinitionError, match="cannot be written"):
        write_audit(AUDIT, blocked)
