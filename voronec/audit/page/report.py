"""The report of an audit: as files, one of them a page, and for the terminal.

Files are plain data, a page, a LaTeX article; the terminal has a line a record, errata and
conventions below.  The page is typeset, searchable, and readable offline.
"""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from html import escape
from pathlib import Path

from voronec.audit.page.article import audit_latex
from voronec.audit.page.mathml import mathml, prose
from voronec.audit.page.phrases import (
    KINDS,
    MEANING,
    about,
    clauses,
    conventions_with_formulas,
    count_sentences,
    counts,
    end_sentence,
    faults,
    group_ranges,
    plain,
    readable,
    short,
    values,
    with_verdict,
)
from voronec.audit.page.symbols import LETTERS
from voronec.audit.record import VERDICTS, Audit, FormulaRecord, Record
from voronec.declaration.whole_files import replace_file
from voronec.errors import DefinitionError


def write_audit(audit: Audit, folder: str | Path, figures: Sequence[Figure] = ()) -> list[Path]:
    """Write ``report.json``, ``report.html`` and ``report.tex``; return their paths.

    The first is a list of the records: label, section, ordinal, printed, derived, verdict,
    correction, witness, method, and all formulas.  ``DefinitionError`` where the folder cannot be
    written.
    """
    texts = {
        "report.json": json.dumps(audit.as_list(), indent=2, ensure_ascii=False) + "\n",
        "report.html": audit_page(audit, figures),
        "report.tex": audit_latex(audit),
    }
    target = Path(folder)
    try:
        target.mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            replace_file(target / name, text)
    except OSError as error:
        reason = error.strerror or str(error)
        raise DefinitionError(f"the folder '{folder}' cannot be written: {reason}") from None
    return [target / name for name in texts]


NAME = 22
"""The widest name of a record that keeps the columns straight."""
NEAR = 12
"""Characters shown before and after a change where a line holds both readings."""
SEVERAL = 8
"""At most so many formulas of one record are spelled out."""


def audit_summary(audit: Audit, width: int = 100, most: int = 12) -> str:
    """What was found, on one screen: the counts and, a line each, at most so many misprints.

    Plain text, no line longer than ``width``.
    """
    lines = [_cut(line, width) for line in count_sentences(audit)]
    # of a record with several the first
    wrong = {id(r): (r, f) for r, f in reversed([*with_verdict(audit, "misprint")])}
    several = [*reversed(wrong.values())]
    if several:
        lines += ["", "wrong in print"]
    for record, formula in several[:most]:
        if formula.correction is None or not formula.struck:
            what = formula.says or formula.printed
        else:
            (a, b), (c, d) = formula.struck[0], formula.changes[0]
            old = _context(formula.printed, a, b, NEAR)
            what = f"{old} -> {_context(formula.correction, c, d, NEAR)}"
        lines.append(_cut_line(f"  {record.designation}: {' '.join(what.split())}", width))
    if len(several) > most:
        lines.append(f"  and {len(several) - most} more")
    for verdict in ("undecided", "not read"):
        names = [r.designation for r in audit.records if r.verdict == verdict]
        lines += ["", _cut(f"{verdict}: {', '.join(names)}", width)] if names else []
    return "\n".join(lines) + "\n"


def audit_table(audit: Audit, width: int = 100) -> str:
    """One line a record, grouped by section; misprints and conventions spelled out below.

    Plain text, no line longer than ``width``.
    """
    names = max((len(r.designation) for r in audit.records), default=0)
    lines: list[str] = []
    for section in audit.sections:
        lines += ["", _cut(section, width), "-" * min(width, len(section))]
        for record in (r for r in audit.records if r.section == section):
            lines += _lines(record, min(names, NAME), width)
    lines += ["", *(_cut(line, width) for line in count_sentences(audit))]
    for number, (record, formula) in enumerate(with_verdict(audit, "misprint"), 1):
        lines += ["", *_erratum_in_text(number, record, formula, width)]
    for said, several in conventions_with_formulas(audit):
        lines.append("")
        for record, formula in several:
            lines.append(_cut(f"convention: {_place_in_text(record)}", width))
            lines += _wrap(formula.says or formula.printed, "  ", width)
        lines += _wrap(end_sentence(short(said)), "  ", width)
    return "\n".join(lines).lstrip("\n") + "\n"


def _lines(record: Record, names: int, width: int) -> Iterator[str]:
    head = f"{record.designation:<{names}}  {record.verdict:<10}  "
    yield head + _cut("; ".join(f.printed or f.says for f in record.formulas), width - len(head))
    wrong = faults(record) if len(record.formulas) > 1 else ()
    for formula in wrong[:SEVERAL]:
        head = f"{'':<{names}}  {formula.verdict:<10}    "
        yield head + _cut(formula.printed or formula.says, width - len(head))
        yield from _reason(formula, names, width)
    if not wrong:
        yield from _reason(record.decisive, names, width)


def _reason(formula: FormulaRecord, names: int, width: int) -> list[str]:
    """Why a formula is neither proved nor refuted, or not read."""
    if formula.verdict not in ("undecided", "not read"):
        return []
    return _wrap(end_sentence(short(formula.method)), " " * (names + 4), width)


def _cut(latex: str, width: int) -> str:
    text = " ".join(latex.split())
    return text if len(text) <= width else text[: max(width - 3, 10)] + "..."


def _wrap(text: str, indent: str, width: int) -> list[str]:
    """Words on lines of the width, the first after ``indent``, the others below its end."""
    lines, empty = [indent], True
    for word in text.split():
        if len(lines[-1]) + len(word) + 1 > width and not empty:
            lines, empty = [*lines, " " * len(indent)], True
        lines[-1] += word if empty else f" {word}"
        empty = False
    return [_cut_line(line, width) for line in lines]


def _cut_line(line: str, width: int) -> str:
    return line if len(line) <= width else line[: width - 3] + "..."


def _place_in_text(record: Record) -> str:
    return f"{record.designation} in '{record.section}'"


def _erratum_in_text(number: int, record: Record, formula: FormulaRecord, width: int) -> list[str]:
    lines = [_cut(f"erratum {number}: {_place_in_text(record)}", width)]
    if formula.says:
        lines += _wrap(formula.says, "  claim  ", width)
    if formula.correction is None:
        lines += _wrap(formula.printed, "  for    ", width) if formula.printed else []
        lines += _wrap(short(formula.method), "  ", width)
    else:
        for (a, b), (c, d) in zip(formula.struck, formula.changes, strict=True):
            lines.append(_cut_line(f"  for    {_context(formula.printed, a, b)}", width))
            lines.append(_cut_line(f"  read   {_context(formula.correction, c, d)}", width))
    return lines + [_cut_line(f"  {line}", width) for line in _witness(formula)]


def _context(latex: str, start: int, end: int, around: int = 24) -> str:
    """The change with a little of what stands around it."""
    a, b = max(0, start - around), min(len(latex), end + around)
    inner = " ".join(latex[a:b].split())
    return ("..." if a else "") + inner + ("..." if b < len(latex) else "")


def _witness(formula: FormulaRecord) -> list[str]:
    """The two values of a witness, in words."""
    witness = formula.witness
    if witness is None:
        return []
    lines = [f"{name:<10}  {short(value)}" for name, value in values(formula)]
    what = about(witness)
    return [lines[0] + (f"  ({what})" if what else ""), *lines[1:]] if lines else []


LONG = 200
"""What is said of a formula is folded where it has more characters."""

Places = Mapping[tuple[str, int], str]


def anchors(audit: Audit) -> dict[tuple[str, int], str]:
    """(section, ordinal) -> an anchor that is used once: the label, or the place."""
    names: dict[tuple[str, int], str] = {}
    used: set[str] = set()
    for record in audit.records:
        number = audit.sections.index(record.section) + 1
        name = re.sub(r"[^\w.*-]+", "-", record.label) if record.label else ""
        if not name or name in used:
            name = f"s{number}-{record.kind}-{record.ordinal}"
        used.add(name)
        names[record.section, record.ordinal] = name
    return names


def errata(audit: Audit, places: Places) -> str:
    """The list of misprints: for ... read ..., and where the print fails."""
    items = "".join(_erratum(r, f, places) for r, f in with_verdict(audit, "misprint"))
    return f'<ol id="errata-list">{items}</ol>' if items else "<p>None.</p>"


def conventions(audit: Audit, places: Places) -> str:
    """The list of what is true under a convention, or in some ranges."""
    items = ""
    for said, several in conventions_with_formulas(audit):
        held = "".join(f"{_place(r, places)}{_statement(f)}" for r, f in several)
        items += f'<li>{held}<p class="method">{prose(end_sentence(said))}</p></li>'
    return f'<ol id="conventions-list">{items}</ol>' if items else ""


def reasons_list(audit: Audit, places: Places, verdict: str) -> str:
    """The list of what has a verdict, each with the reason."""
    items = "".join(
        f"<li>{_place(r, places)}{_statement(f)}"
        f'<p class="method">{prose(end_sentence(f.method))}</p></li>'
        for r, f in with_verdict(audit, verdict)
    )
    return f'<ol id="{verdict.replace(" ", "-")}-list">{items}</ol>' if items else ""


def record_html(record: Record, places: Places) -> str:
    """One record with all its formulas."""
    anchor = places[record.section, record.ordinal]
    formulas = "".join(_formula(f, len(record.formulas) > 1) for f in record.formulas)
    tag = f"{record.kind} {record.ordinal}" if record.label else ""
    return (
        f'<article id="{anchor}" data-verdict="{record.verdict}" data-kind="{record.kind}" '
        f'data-name="{escape(record.designation.lower(), quote=True)}" '
        f'data-text="{escape(_words(record), quote=True)}"><header><a href="#{anchor}">'
        f'{escape(record.designation)}</a><span class="tag">{tag}</span>{_badge(record.verdict)}'
        f"</header>{formulas}</article>\n"
    )


def _words(record: Record) -> str:
    """What the search looks through."""
    parts = [record.designation, record.section, record.kind, record.printed]
    for formula in record.formulas:
        parts += [formula.verdict, formula.printed, formula.says, formula.method]
        parts.append(formula.source)
        parts += [formula.derived or "", formula.correction or ""]
    return " ".join(" ".join(parts).lower().split())


def _place(record: Record, places: Places) -> str:
    anchor = places[record.section, record.ordinal]
    return (
        f'<div><a href="#{anchor}">{escape(record.designation)}</a> '
        f'<span class="tag">{escape(record.section)}</span></div>'
    )


def _statement(formula: FormulaRecord) -> str:
    """The formula, or the claim in words."""
    words = f'<p class="claim">{prose(formula.says)}</p>' if formula.says else ""
    if not formula.printed:
        return words
    shown = mathml(formula.printed, formula.struck, "struck")
    return f'{words}<div class="cell">{shown}</div>'


def _erratum(record: Record, formula: FormulaRecord, places: Places) -> str:
    parts = [_place(record, places)]
    if formula.printed:
        if formula.says:
            parts.append(f'<p class="claim">{prose(formula.says)}</p>')
        parts.append(_line("for", mathml(formula.printed, formula.struck, "struck")))
    else:
        parts.append(f'<p class="claim">Not true: {prose(formula.says)}</p>')
    if formula.correction is not None:
        read = mathml(formula.correction, formula.changes, "mended")
        parts.append(_line("read", read))
    else:
        if formula.derived:
            parts.append(_line("instead", mathml(formula.derived)))
        parts.append(f'<p class="method">{prose(end_sentence(short(formula.method)))}</p>')
    link = places[record.section, record.ordinal]
    return f"<li>{''.join(parts)}{_at_a_point(formula, link)}</li>"


def _line(title: str, body: str) -> str:
    return f'<div class="line"><span>{title}</span><div class="cell">{body}</div></div>'


def _formula(formula: FormulaRecord, several: bool) -> str:
    cells = []
    if formula.says:
        cells.append(f'<p class="claim wide">{prose(formula.says)}</p>')
    if formula.printed:
        ranges = ", ".join(mathml(q, inline=True) for q in formula.quantifiers)
        title = "printed" + (f", for {ranges}" if ranges else "")
        cells.append(_cell(title, formula.printed, formula.struck, "struck"))
    if formula.derived:
        cells.append(_cell("derived", formula.derived))
    elif formula.verdict == "proved" and formula.printed:
        agrees = '<p class="none">agrees with print</p>'
        cells.append(f'<div class="cell"><span>derived</span>{agrees}</div>')
    if formula.correction is not None:
        cells.append(_cell("corrected", formula.correction, formula.changes, "mended"))
    badge = f"{_badge(formula.verdict)} " if several else ""
    return (
        f'<div class="formula"><div class="pair">{"".join(cells)}</div>'
        f"{_method(short(formula.method), badge)}{_source(formula)}"
        f"{_ranges(formula)}{_numbers(formula)}{_point(formula)}</div>"
    )


def _source(formula: FormulaRecord) -> str:
    """What the derived side was made from."""
    if not formula.source:
        return ""
    return f'<p class="method">Compared with: {prose(end_sentence(formula.source))}</p>'


def _cell(title: str, latex: str, marks: Sequence[tuple[int, int]] = (), mark: str = "") -> str:
    """A formula under its title: in one of two columns, or across both where it is too wide."""
    return f'<div class="cell"><span>{title}</span>{mathml(latex, marks, mark)}</div>'


def _badge(verdict: str) -> str:
    return f'<span class="badge {verdict.replace(" ", "-")}">{verdict}</span>'


def _method(text: str, badge: str = "") -> str:
    """How a verdict was found; what is long begins with its first clause, and unfolds."""
    if len(text) <= LONG:
        return f'<p class="method">{badge}{prose(text)}</p>'
    first = clauses(text)[0]
    head = first if len(first) <= LONG else _beginning(first)
    rest = text[len(head) :].removeprefix(";").strip()
    summary = f"<summary>{badge}{prose(head)} ...</summary>"
    return f'<details class="method">{summary}<p>{prose(rest)}</p></details>'


def _beginning(text: str) -> str:
    """A formula or a few words with which a long text begins, dollar signs in pairs."""
    cut = text[:LONG].rfind(" ")
    while cut > 0 and text[:cut].count("$") % 2:
        cut = text[:cut].rfind(" ")
    return text[: max(cut, 0)]


def _ranges(formula: FormulaRecord) -> str:
    """In which ranges of the parameters it holds; a column of which nothing is said is left out."""
    entries = group_ranges(formula)
    heads = [h for h in ("range", "where", "verdict", "method", "witness")
             if any(entry[h] for entry in entries)]  # fmt: skip
    shown: dict[str, Callable[[str], str]] = {
        "verdict": _badge,
        "method": _method,
        "where": prose,
        "witness": prose,
    }
    rows = "".join(
        "<tr>" + "".join(f"<td>{shown.get(h, escape)(entry[h])}</td>" for h in heads) + "</tr>"
        for entry in entries
    )
    titles = "".join(f"<th>{h}</th>" for h in heads)
    return f'<div class="cell"><table><tr>{titles}</tr>{rows}</table></div>' if rows else ""


def _numbers(formula: FormulaRecord) -> str:
    """The two values of a witness."""
    lines = [f"<span>{name}</span> {escape(short(value))}" for name, value in values(formula)]
    if not lines or formula.witness is None:
        return ""
    what = about(formula.witness)
    lines[0] += escape(f" ({what})") if what else ""
    return f'<p class="numbers">{"<br>".join(lines)}</p>'


def _at_a_point(formula: FormulaRecord, link: str) -> str:
    """The witness on one line; the record has the point."""
    if formula.witness is None or not values(formula):
        return ""
    what = about(formula.witness)
    text = ", ".join(f"{name} {short(value)}" for name, value in values(formula))
    place = f'<a href="#{link}">At a point</a>'
    said = end_sentence(text + (f" ({what})" if what else ""))
    return f'<p class="method">{place}: {escape(said)}</p>'


def _point(formula: FormulaRecord) -> str:
    witness = formula.witness
    if witness is None or not witness["point"]:
        return ""
    point = [(mathml(readable(k), inline=True), v) for k, v in witness["point"].items()]
    rows = "".join(
        f"<dt>{name}</dt><dd>{escape(plain(str(value)))}</dd>"
        for name, value in (*point, *values(formula))
    )
    return f"<details><summary>the point, all digits</summary><dl>{rows}</dl></details>"


_MORE = {"µ": "mu", "∫": "int", "√": "sqrt", "∑": "sum", "weierstrass": "wp", "integral": "int"}


def _spellings() -> dict[str, list[str]]:
    """What a reader may type -> the commands that show it; a variant of a letter is that letter."""
    commands: dict[str, list[str]] = {}
    for command, letter in LETTERS.items():
        plain = command.lower().removeprefix("var")
        same = [c for c in (plain, f"var{plain}") if c in LETTERS or c == command.lower()]
        commands[letter.lower()] = [f"\\{name}" for name in same]
    return commands | {typed: [f"\\{command}"] for typed, command in _MORE.items()}


@dataclass(frozen=True)
class Figure:
    """A picture for the page: an SVG or PNG file, and what it shows."""

    path: Path
    caption: str = ""


def audit_page(audit: Audit, figures: Sequence[Figure] = ()) -> str:
    """A self-contained HTML page: counts, errata, conventions, then every record by section."""
    places = anchors(audit)
    style, script = (_part(f"report.{kind}") for kind in ("css", "js"))
    spellings = json.dumps(_spellings(), ensure_ascii=False)
    sections = "".join(_section(audit, n, places) for n in range(len(audit.sections)))
    pictures = "".join(map(_figure, figures))
    lists = "".join(
        _list_section(name, title, lead, make(audit, places)) for name, title, lead, make in LISTS
    )
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>Audit: {escape(audit.title)}</title><style>\n{style}</style></head><body>\n"
        f"{_contents(audit)}<main>\n<h1>{escape(audit.title)}</h1>\n"
        f'<p class="by">{escape(audit.authors)}</p>\n{_summary(audit)}\n'
        f'<section id="errata"><h2>Errata</h2>\n{errata(audit, places)}</section>\n'
        f"{lists}{_search(audit)}\n"
        f"{sections}{pictures}</main>\n"
        f"<script>const spellings={spellings};\n{script}</script></body></html>\n"
    )


def _part(name: str) -> str:
    """The text of a file that stands beside this one."""
    return Path(__file__).with_name(name).read_text("utf-8")


def _contents(audit: Audit) -> str:
    lines = []
    for number, title in enumerate(audit.sections, 1):
        records = [r for r in audit.records if r.section == title]
        wrong = sum(r.verdict == "misprint" for r in records)
        mark = f"<i>{wrong}</i> / " if wrong else ""
        link = f'<a href="#section-{number}">{escape(title)}</a>'
        lines.append(f"<li>{link}<b>{mark}{len(records)}</b></li>")
    head = '<li><a href="#errata">Errata</a></li>'
    for anchor, title, _, entries in LISTS:
        if entries(audit, anchors(audit)):
            head += f'<li><a href="#{anchor}">{title}</a></li>'
    return f"<aside><b>Contents</b><ol>{head}</ol><b>Sections</b><ol>{''.join(lines)}</ol></aside>"


def _summary(audit: Audit) -> str:
    tally = counts(audit)
    verdicts = [v for v in reversed(VERDICTS) if any(c[v] for c in tally.values())]
    heads = "".join(f"<th>{KINDS[kind]}</th>" for kind in tally)
    rows = []
    for verdict in verdicts:
        cells = "".join(f'<td class="n">{tally[kind][verdict]}</td>' for kind in tally)
        rows.append(f"<tr><td>{_badge(verdict)}</td>{cells}<td>{MEANING[verdict]}</td></tr>")
    totals = "".join(f'<td class="n">{sum(tally[kind].values())}</td>' for kind in tally)
    formulas = sum(len(r.formulas) for r in audit.records)
    return (
        '<p class="lead">Every displayed equation of the paper, and the formulas and claims of its '
        "text that can be decided, beside what was derived from the Lagrangian and the constraints "
        "alone. A verdict is proved in exact algebra; a refutation comes with a point at which the "
        "printed formula fails. Where a display holds several formulas it takes the worst verdict "
        f"of them, and one that bears several numbers counts once for each; there are {formulas} "
        "formulas and claims in all.</p>"
        f"<table><tr><th>verdict</th>{heads}<th>meaning</th></tr>{''.join(rows)}"
        f"<tr><th>all</th>{totals}<td></td></tr></table>"
    )


LISTS = (
    (
        "conventions", "Conventions and ranges",
        "True as printed under a convention that another formula contradicts, or in some ranges of "
        "the parameters only.",
        conventions,
    ),
    (
        "unaudited", "Not audited",
        "What the text states, and nothing here decides. Sentences on history, on sources and on "
        "what comes next state nothing of the kind.",
        partial(reasons_list, verdict="unaudited"),
    ),
    (
        "not-read", "Not read",
        "What holds a letter, a command or a notation that is not known here, or can be read in "
        "two ways. Nothing is said against it.",
        partial(reasons_list, verdict="not read"),
    ),
)  # fmt: skip
"""The lists of the page after the errata: anchor, title, what it is, and its entries."""


def _list_section(anchor: str, title: str, lead: str, items: str) -> str:
    """A list with its heading; nothing where the list is empty."""
    if not items:
        return ""
    head = f'<section id="{anchor}"><h2>{title}</h2>\n<p class="lead">{lead}</p>'
    return f"{head}{items}</section>\n"


def _search(audit: Audit) -> str:
    tally = counts(audit)
    buttons = ""
    for verdict, count in audit.count().items():
        if count:
            buttons += _button("verdict", verdict, verdict, count)
    for kind in tally:
        buttons += _button("kind", kind, KINDS[kind], sum(tally[kind].values()))
    placeholder = "display 2, (label), words, γ, LaTeX"
    return (
        f'<nav><input id="search" type="search" placeholder="{placeholder}" '
        f'aria-label="search">{buttons}<span id="shown"></span></nav>'
    )


def _button(group: str, value: str, name: str, count: int) -> str:
    """What shows only the records of a verdict, or of a kind, and how many these are."""
    words = f"{name} <small>{count}</small>"
    return f'<button data-{group}="{value}" aria-pressed="false">{words}</button>'


def _section(audit: Audit, number: int, places: dict[tuple[str, int], str]) -> str:
    title = audit.sections[number]
    records = "".join(record_html(r, places) for r in audit.records if r.section == title)
    return (
        f'<section id="section-{number + 1}" data-records><h2>{escape(title)}</h2>\n{records}'
        "</section>\n"
    )


def _figure(figure: Figure) -> str:
    kind = "image/svg+xml" if figure.path.suffix == ".svg" else "image/png"
    data = base64.b64encode(figure.path.read_bytes()).decode("ascii")
    return (
        f'<figure><img alt="{escape(figure.caption, quote=True)}" src="data:{kind};base64,{data}">'
        f"<figcaption>{escape(figure.caption)}</figcaption></figure>\n"
    )
