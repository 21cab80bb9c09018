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
from voronec.audit.page.article import audit_latex
from voronec.audit.page.phrases import clauses, gist, readable, short
from voronec.audit.page.report import Figure, audit_page, audit_table, record_html, write_audit
from voronec.cli import main as voronec
from voronec.cli.files import wanted_folder

pytestmark = pytest.mark.slow

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
    {"range": "inner", "statement": "a, b", "verdict": "proved", "method": "m", "witness": None},
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
EVERYWHERE = FormulaRecord(
    "b>0", "proved", f"{'a long certificate, ' * 12}(a; b); m", ranges=RANGES[:2]
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
        Record("2*", "Second", 4, EVERYWHERE.printed, (EVERYWHERE,), "text"),
    ),
    authors="A. Būthor",
)


SHEET = """
from voronec.audit import Display, Paper, Section, Study
from voronec import time

def studies(_):
    return {"only": Study({"t": time})}

PAPER = Paper("sheet", "T", (Section("All", (Display(r"$t+t=2t$"),), studies),))
"""


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
    records = json.loads((tmp_path / "report.json").read_text("utf-8"))
    first, second, third, fourth, fifth, _ = records
    keys = "label section ordinal printed derived verdict correction witness method kind".split()
    assert set(keys) <= set(first)
    assert (first["label"], first["verdict"], first["correction"]) == ("one", "proved", None)
    assert (second["label"], second["verdict"], second["ordinal"]) == (None, "misprint", 2)
    assert second["correction"] == "A_i=B_i"
    assert second["witness"]["printed"] == "0.100000000000000000001"
    assert [f["verdict"] for f in second["formulas"]] == ["proved", "misprint"]
    assert (third["kind"], fourth["kind"], fifth["kind"]) == ("display", "text", "text")
    assert [r["verdict"] for r in fourth["formulas"][0]["ranges"]] == [
        "proved",
        "proved",
        "refuted",
    ]


def test_the_table_has_a_line_a_record_and_spells_out_errata():
    table = audit_table(AUDIT, 60)
    assert all(len(line) <= 60 for line in table.splitlines())
    assert re.search(r"^\(one\) +proved ", table, re.MULTILINE)
    assert re.search(r"^display 2 +misprint ", table, re.MULTILINE)
    assert re.search(r"^text 2 +convention +\$a_0\$ is negative$", table, re.MULTILINE)
    assert "3 displayed equations: 1 misprint, 1 undecided, 1 proved" in table
    assert "3 in the text: 1 misprint, 1 convention, 1 proved" in table
    assert re.search(r"for +A_j=B_i\n +read +A_i=B_i\n", table)
    assert "as printed  0.100000000000...  (for i = 1, j = 2)" in table
    assert re.search(r"erratum 2: text 3 in 'Second'\n +claim +It is stable\n", table)
    assert re.search(r"^ +undecided .*\n +it cannot be read: a & b\.$", table, re.MULTILINE)
    single = Audit("p", "T", (Record(None, "S", 1, "a+b", (UNBALANCED,)),))
    assert re.search(
        r"^display 1 .*\n +it cannot be read: a & b\.$", audit_table(single), re.MULTILINE
    )
    assert "1 displayed equation: 1 undecided" in audit_table(single)
    assert "convention: display" not in table  # it bears a label
    assert re.search(r"convention: \(one\) in 'Second'\n +x=-y\n +true if y is down", table)


def test_a_value_is_cut_after_its_first_digits():
    assert short("0.000123456789012345") == "0.000123456789012..."
    assert short("-12.3456789012345e-5") == "-12.3456789012...e-5"
    assert short("1/3 + 2.5*I") == "1/3 + 2.5*I"
    assert [short(x) for x in ("0e-44", "-0.000", "28.0000", "10e-4")] == ["0", "0", "28", "10e-4"]


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("Derivative(m12, q1)", r"\partial m_{12}/\partial q_{1}"),
        ("Derivative(E_1, v_1, u_1)", r"\partial^2 E_{1}/\partial v_{1}\partial u_{1}"),
        (r"\wp'{(\zeta)}", r"\wp '(\zeta )"),
        ("q3dotdot", r"\ddot{q}_{3}"),
        ("u_1dot", r"\dot{u}_{1}"),
        ("D''_1", "D''_{1}"),
        ("rho_u", r"\rho _{u}"),
        ("omega~", r"\tilde{\omega}"),
        ("mass", r"\text{mass}"),
        ("cos u", r"\cos  u"),
    ],
)
def test_the_names_of_a_point_are_readable(name, expected):
    assert readable(name) == expected


def test_a_method_has_clauses_and_a_gist():
    assert clauses("a (b; c); $x; y$; d") == ["a (b; c)", "$x; y$", "d"]
    assert gist("true if a; b; against (c; d); n = 3") == "true if a; b; against (c; d)"
    assert gist("true for outer; x is positive") == "true for outer"


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


def test_the_lines_of_a_formula_may_end_before_each_sign():
    long = "+".join(f"a_{{{n}}}" for n in range(14))
    short = FormulaRecord("a=b", "proved", "m", "b = c")
    wide = FormulaRecord(f"a={long}", "proved", "m", f"b = {long}")
    for formula, count in ((short, 2), (wide, 28)):
        shown = record_html(Record(None, "First", 1, "", (formula,)), {("First", 1): "one"})
        assert shown.count("<wbr/>") == count
        assert "mtable" not in shown


def test_what_is_wider_than_the_screen_is_scrolled_in_the_list_of_conventions(page):
    start = page.index('id="conventions-list"')
    listed = page[start : page.index("</ol>", start)]
    assert listed.count('<div class="cell"><div class="math">') == listed.count('math">') > 0


def test_the_page_begins_with_errata_and_conventions(page):
    headings = re.findall(r"<h2>([^<]*)</h2>", page)
    assert headings == ["Errata", "Conventions and ranges", "First", "Second"]
    errata = page[page.index('id="errata-list"') : page.index('id="conventions"')]
    assert errata.count("<li>") == 2
    assert "Not true: It is stable" in errata
    assert errata.count("0.100000000000...") == 2
    assert "...." not in page


def test_the_page_marks_the_difference_in_both(page):
    assert '<mrow class="struck"><msub><mi>A</mi><mi>j</mi></msub></mrow>' in page
    assert '<mrow class="mended"><msub><mi>A</mi><mi>i</mi></msub></mrow>' in page


def test_the_page_can_be_searched_and_filtered(page):
    head = r'<article id="([^"]*)" data-verdict="([^"]*)" data-kind="([^"]*)"'
    records = re.findall(head, page)
    assert [r[1:] for r in records] == [
        ("proved", "display"),
        ("misprint", "display"),
        ("undecided", "display"),
        ("convention", "text"),
        ("misprint", "text"),
        ("proved", "text"),
    ]
    names = re.findall(r'data-name="([^"]*)"', page)
    assert names == ["(one)", "display 2", "(one)", "text 2", "text 3", "(2*)"]
    assert '"γ": ["\\\\gamma"]' in page
    assert '"weierstrass": ["\\\\wp"]' in page
    texts = re.findall(r'data-text="([^"]*)"', page)
    assert "a_j=b_i" in texts[1]
    assert "is negative" in texts[3]
    buttons = re.findall(r'<button data-(?:verdict|kind)="(\w+)"', page)
    assert buttons == ["misprint", "undecided", "convention", "proved", "display", "text"]


def test_a_button_shows_as_many_records_as_it_says_and_as_the_table_counts(page):
    records = re.findall(r'<article [^>]*data-verdict="(\w+)" data-kind="(\w+)"', page)
    said = re.findall(r'data-(verdict|kind)="(\w+)" aria-pressed="false">[^<]*<small>(\d+)<', page)
    assert len(said) == 6
    for group, value, count in said:
        assert [r[group == "kind"] for r in records].count(value) == int(count)
    row = r'<span class="badge (\w+)">\w+</span></td><td class="n">(\d+)</td><td class="n">(\d+)<'
    table = {verdict: int(a) + int(b) for verdict, a, b in re.findall(row, page)}
    assert table == {value: int(n) for group, value, n in said if group == "verdict"}


@pytest.mark.parametrize("verdict", ["unaudited", "not read"])
def test_the_page_lists_what_is_not_audited_or_not_read(verdict):
    open_ = FormulaRecord("", verdict, "fame is not derived", says="It is famous")
    audit = Audit("p", "T", (Record(None, "s", 1, "It is famous", (open_,), "text"),))
    page, name = audit_page(audit), verdict.replace(" ", "-")
    listed = page[page.index(f'id="{name}-list"') : page.index("<nav>")]
    assert "It is famous" in listed
    assert "fame is not derived" in listed
    assert f'<a href="#{name}">' in page
    assert audit.count()[verdict] == 1 and audit.as_list()[0]["verdict"] == verdict
    assert "fame is not derived" in audit_table(audit) or verdict == "unaudited"
    assert not complaints(audit_latex(audit))


def test_the_page_says_in_which_ranges_a_claim_holds(page):
    record = page[page.index('data-kind="text"') :]
    rows = re.findall(r"<tr><td>(outer, inner|shell)</td>.*?</tr>", record)
    assert rows == ["outer, inner", "shell", "outer, inner"]
    heads = re.findall(r"<tr>((?:<th>\w+</th>)+)</tr>", record)
    assert [h.count("<th>") for h in heads] == [5, 3], "nothing is said twice, or of nothing"
    assert re.search(r"<td>at <math>.*?</math> = 1/3, <math>.*?</math> = 7/10</td>", record)


def test_a_long_certificate_unfolds(page):
    record = page[page.index('<article id="2*"') :]
    folded = re.search(r'<details class="method"><summary>(.*?)</summary><p>(.*?)</p>', record)
    assert folded is not None
    assert folded[2].endswith("(a; b); m")
    assert len(folded[1]) < 210


def test_the_article_would_compile(article):
    assert complaints(article) == []
    assert article.rstrip().endswith(r"\end{document}")
    assert r"\providecommand{\diag}{\operatorname{diag}}" in article
    assert set(re.findall(r"\\usepackage(?:\[[^\]]*\])?\{([^}]*)\}", article)) == {
        *("fontenc", "inputenc", "lmodern", "amsmath,amssymb", "xcolor,graphicx"),
        *("array,longtable", "geometry"),
    }


def test_the_article_shows_the_difference_and_escapes_words(article):
    assert r"{\struck{A_j}}=B_i" in article
    assert r"{\mended{A_i}}=B_i" in article
    assert r"\paragraph{2. \texttt{text 3}} Second." in article
    assert "...." not in article.replace(r"\dots", "")
    assert r"On <balls> \& spheres" in article
    assert r"it cannot be read: a \& b" in article
    assert "Not true: It is stable" in article
    assert r"outer, inner & $\mu'>0$; $a$, $b$ & \verdict{proved} & " in article


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


def test_the_table_is_printed_though_the_report_cannot_be_written(tmp_path, monkeypatch, capsys):
    def full(*_):
        raise DefinitionError("'report' cannot be written: no space")

    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr("voronec.audit.page.report.write_audit", full)
    (tmp_path / "sheet.py").write_text(SHEET)
    assert voronec(["regenerate", "sheet.py", "--out", "report"]) == 2
    out, err = capsys.readouterr()
    assert "1 displayed equation: 1 proved" in out
    assert "cannot be written: no space" in err
    assert not (tmp_path / "report").exists()
    assert voronec(["regenerate", "sheet.py", "--out", ""]) == 2
    assert "the folder for --out has no name" in capsys.readouterr().err


def test_a_folder_is_tried_before_any_work(tmp_path, monkeypatch):
    assert wanted_folder(str(tmp_path / "a" / "b")) == tmp_path / "a" / "b"
    assert list(tmp_path.iterdir()) == []
    blocked = tmp_path / "file"
    blocked.write_text("")
    for name, told in (("", "has no name"), (blocked, "is a file"), (blocked / "in", "no folder")):
        with pytest.raises(DefinitionError, match=told):
            wanted_folder(str(name))
    monkeypatch.setattr("os.access", lambda *_: False)
    with pytest.raises(DefinitionError, match="allows no new files"):
        wanted_folder(str(tmp_path / "new"))
