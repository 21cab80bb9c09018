"""The report of an audit: plain data, a table, a page, a LaTeX article."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser
from xml.etree import ElementTree

import pytest
from latex_shape import complaints

from voronec import DefinitionError
from voronec.audit import Audit, FormulaRecord, Record
from voronec.report.audit_report import Figure, audit_table, write_audit
from voronec.report.audit_words import short

POINT = {"x": "1/3", "I_1": "7/10"}
WITNESS = {
    "point": POINT,
    "printed": "0.100000000000000000001",
    "derived": "0.2",
    "indices": {"i": 1, "j": 2},
}
PROVED = FormulaRecord(r"a=\frac12b<c", "proved", "zero in exact normal form", "a = b/2")
WRONG = FormulaRecord(
    "A_j=B_i",
    "misprint",
    "refuted as printed",
    "A_1 = B_1",
    "A_i=B_i",
    ((2, 3),),
    ((2, 3),),
    WITNESS,
    ("i=1,2",),
)
UNBALANCED = FormulaRecord(r"\big(a+b=100\%", "undecided", "it cannot be read: a & b")
RANGES = (
    {"range": "outer", "statement": r"\mu'>0", "verdict": "proved", "method": "m", "witness": None},
    {
        "range": "shell",
        "statement": r"\mu'<-1",
        "verdict": "refuted",
        "method": "m",
        "witness": {"point": POINT, "printed": "1", "derived": "2"},
    },
)
PARTIAL = FormulaRecord(
    "", "convention", "true for outer, false for shell", says=r"$a_0$ is negative", ranges=RANGES
)
FALSE = FormulaRecord(
    "", "misprint", "the opposite holds", r"\diag(a)", witness=WITNESS, says="It is stable"
)
CONVENTION = FormulaRecord("x=-y", "convention", "true if y is down; against (one)", "x = y")
AUDIT = Audit(
    "p",
    "On <balls> & spheres",
    (
        Record("one", "First", 1, PROVED.printed, (PROVED,)),
        Record(None, "First", 2, r"\[A_j=B_i, a=b\]", (PROVED, WRONG)),
        Record("one", "Second", 1, UNBALANCED.printed, (UNBALANCED, CONVENTION)),
        Record(None, "Second", 2, PARTIAL.says, (PARTIAL,), "text"),
        Record(None, "Second", 3, FALSE.says, (FALSE,), "text"),
    ),
    authors="A. Būthor",
)


@pytest.fixture(name="page")
def _page(tmp_path):
    picture = tmp_path / "trace.svg"
    picture.write_text("<svg xmlns='http://www.w3.org/2000/svg'/>")
    write_audit(AUDIT, tmp_path / "out", [Figure(picture, "The trace")])
    return (tmp_path / "out" / "report.html").read_text("utf-8")


@pytest.fixture(name="article")
def _article(tmp_path):
    write_audit(AUDIT, tmp_path)
    return (tmp_path / "report.tex").read_text("utf-8")


def test_the_data_has_a_list_with_the_promised_fields(tmp_path):
    write_audit(AUDIT, tmp_path)
    first, second, third, fourth, fifth = json.loads((tmp_path / "report.json").read_text("utf-8"))
    keys = "label section ordinal printed derived verdict correction witness method kind".split()
    assert set(keys) <= set(first)
    assert (first["label"], first["verdict"], first["correction"]) == ("one", "proved", None)
    assert (second["label"], second["verdict"], second["ordinal"]) == (None, "misprint", 2)
    assert second["correction"] == "A_i=B_i"
    assert second["witness"]["printed"] == "0.100000000000000000001"
    assert [f["verdict"] for f in second["formulas"]] == ["proved", "misprint"]
    assert (third["kind"], fourth["kind"], fifth["kind"]) == ("display", "text", "text")
    assert [r["verdict"] for r in fourth["formulas"][0]["ranges"]] == ["proved", "refuted"]


def test_the_table_has_a_line_a_record_and_spells_out_errata():
    table = audit_table(AUDIT, 60)
    assert all(len(line) <= 60 for line in table.splitlines())
    assert re.search(r"^\(one\) +proved ", table, re.MULTILINE)
    assert re.search(r"^display 2 +misprint ", table, re.MULTILINE)
    assert re.search(r"^text 2 +convention +\$a_0\$ is negative$", table, re.MULTILINE)
    assert "3 displayed equations: 1 misprint, 1 undecided, 1 proved" in table
    assert "2 in the text: 1 misprint, 1 convention" in table
    assert re.search(r"for +A_j=B_i\n +read +A_i=B_i\n", table)
    assert "as printed  0.100000000000...  (for i = 1, j = 2)" in table
    assert re.search(r"erratum 2: text 3 in 'Second'\n +claim +It is stable\n", table)
    assert "convention: display" not in table  # it bears a label
    assert re.search(r"convention: \(one\) in 'Second'\n +x=-y\n +true if y is down", table)


def test_a_value_is_cut_after_its_first_digits():
    assert short("0.000123456789012345") == "0.000123456789012..."
    assert short("-12.3456789012345e-5") == "-12.3456789012...e-5"
    assert short("1/3 + 2.5*I") == "1/3 + 2.5*I"


class Tags(HTMLParser):
    """Tags that are open, and those that did not match."""

    def __init__(self):
        super().__init__()
        self.open, self.wrong, self.ids, self.links = [], [], [], []

    def handle_starttag(self, tag, attrs):
        named = dict(attrs)
        self.ids += [named["id"]] if "id" in named else []
        self.links += [named["href"]] if "href" in named else []
        if tag not in ("meta", "br", "input", "img"):
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        pass

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.wrong.append(tag)


def test_the_page_is_well_formed_and_its_links_lead_somewhere(page):
    tags = Tags()
    tags.feed(page)
    assert (tags.open, tags.wrong) == ([], [])
    assert len(tags.ids) == len(set(tags.ids))
    assert {link[1:] for link in tags.links} <= set(tags.ids)
    assert "one" in tags.ids  # the anchor is the label
    for formula in re.findall(r"<math.*?</math>", page):
        ElementTree.fromstring(formula.replace("&nbsp;", "&#xa0;"))


def test_the_page_is_complete_offline(page):
    assert not re.search(r"(?:src|href)=\"?(?:https?:|//)", page)
    assert not re.search(r"@import|url\(|@font-face|<link|<iframe", page)
    assert "On &lt;balls&gt; &amp; spheres" in page
    assert "data:image/svg+xml;base64," in page


def test_the_page_begins_with_errata_and_conventions(page):
    headings = re.findall(r"<h2>([^<]*)</h2>", page)
    assert headings == ["Errata", "Conventions and ranges", "First", "Second"]
    errata = page[page.index('id="errata-list"') : page.index('id="conventions"')]
    assert errata.count("<li>") == 2
    assert "Not true: It is stable" in errata
    assert "0.100000000000..." in errata


def test_the_page_marks_the_difference_in_both(page):
    assert '<mrow class="struck"><mi>j</mi></mrow>' in page
    assert '<mrow class="mended"><mi>i</mi></mrow>' in page


def test_the_page_can_be_searched_and_filtered(page):
    records = re.findall(r'<article id="([^"]*)" data-verdicts="([^"]*)" data-kind="([^"]*)"', page)
    assert [r[1:] for r in records] == [
        ("proved", "display"),
        ("proved misprint", "display"),
        ("undecided convention", "display"),
        ("convention", "text"),
        ("misprint", "text"),
    ]
    texts = re.findall(r'data-text="([^"]*)"', page)
    assert "a_j=b_i" in texts[1]
    assert "is negative" in texts[3]
    buttons = re.findall(r'<button data-(?:verdict|kind)="(\w+)"', page)
    assert buttons == ["misprint", "undecided", "convention", "proved", "display", "text"]


def test_the_page_says_in_which_ranges_a_claim_holds(page):
    record = page[page.index('data-kind="text"') :]
    rows = re.findall(r"<tr><td>(outer|shell)</td>.*?</tr>", record)
    assert rows[:2] == ["outer", "shell"]
    assert "1 against 2 at x = 1/3, I_1 = 7/10" in record


def test_the_article_would_compile(article):
    assert complaints(article) == []
    assert article.rstrip().endswith(r"\end{document}")
    assert r"\providecommand{\diag}{\operatorname{diag}}" in article
    assert set(re.findall(r"\\usepackage(?:\[[^\]]*\])?\{([^}]*)\}", article)) == {
        *("inputenc", "amsmath,amssymb", "xcolor,graphicx", "longtable", "geometry"),
    }


def test_the_article_shows_the_difference_and_escapes_words(article):
    assert r"A_{\struck{j}}=B_i" in article
    assert r"A_{\mended{i}}=B_i" in article
    assert r"On <balls> \& spheres" in article
    assert r"it cannot be read: a \& b" in article
    assert "Not true: It is stable" in article
    assert r"$\mu'>0$ & \verdict{proved} & m" in article


def test_nothing_to_report_is_a_report(tmp_path):
    write_audit(Audit("p", "T", AUDIT.records[:1]), tmp_path)
    page = (tmp_path / "report.html").read_text("utf-8")
    assert "<p>None.</p>" in page
    assert "Conventions and ranges" not in page
    assert complaints((tmp_path / "report.tex").read_text("utf-8")) == []


def test_a_folder_that_cannot_be_written_is_refused(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("")
    with pytest.raises(DefinitionError, match="cannot be written"):
        write_audit(AUDIT, blocked)
