"""Records of an audit as HTML: printed beside derived, verdict, correction, witness."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from html import escape

from voronec.audit.record import Audit, FormulaRecord, Record
from voronec.report.audit_words import (
    about,
    clauses,
    convened,
    ended,
    grouped,
    values,
    with_verdict,
)
from voronec.report.mathml import fits, mathml, prose
from voronec.report.points import plain, readable, short

__all__ = ["anchors", "conventions", "errata", "record_html", "unaudited"]

COLUMN, WIDE = 31.0, 64.0
"""How wide a formula may be in one of two columns, and in a line of its own, in em."""
LONG = 200
"""What is said of a formula is folded where it has more characters."""

Places = Mapping[tuple[str, int], str]


def anchors(audit: Audit) -> dict[tuple[str, int], str]:
    """(section, ordinal) -> an anchor that is used once: the label, or the place."""
    found: dict[tuple[str, int], str] = {}
    used: set[str] = set()
    for record in audit.records:
        number = audit.sections.index(record.section) + 1
        name = re.sub(r"[^\w.*-]+", "-", record.label) if record.label else ""
        if not name or name in used:
            name = f"s{number}-{record.kind}-{record.ordinal}"
        used.add(name)
        found[record.section, record.ordinal] = name
    return found


def errata(audit: Audit, places: Places) -> str:
    """The list of misprints: for ... read ..., and where the print fails."""
    items = "".join(_erratum(r, f, places) for r, f in with_verdict(audit, "misprint"))
    return f'<ol id="errata-list">{items}</ol>' if items else "<p>None.</p>"


def conventions(audit: Audit, places: Places) -> str:
    """The list of what is true under a convention, or in some ranges."""
    items = ""
    for said, several in convened(audit):
        held = "".join(f"{_place(r, places)}{_statement(f)}" for r, f in several)
        items += f'<li>{held}<p class="method">{prose(ended(said))}</p></li>'
    return f'<ol id="conventions-list">{items}</ol>' if items else ""


def unaudited(audit: Audit, places: Places) -> str:
    """The list of what nothing decides, each with the reason."""
    items = "".join(
        f'<li>{_place(r, places)}{_statement(f)}<p class="method">{prose(ended(f.method))}</p></li>'
        for r, f in with_verdict(audit, "unaudited")
    )
    return f'<ol id="unaudited-list">{items}</ol>' if items else ""


def record_html(record: Record, places: Places) -> str:
    """One record with all its formulas."""
    anchor = places[record.section, record.ordinal]
    formulas = "".join(_formula(f, len(record.formulas) > 1) for f in record.formulas)
    tag = f"{record.kind} {record.ordinal}" if record.label else ""
    return (
        f'<article id="{anchor}" data-verdict="{record.verdict}" data-kind="{record.kind}" '
        f'data-name="{escape(record.called.lower(), quote=True)}" '
        f'data-text="{escape(_words(record), quote=True)}"><header><a href="#{anchor}">'
        f'{escape(record.called)}</a><span class="tag">{tag}</span>{_badge(record.verdict)}'
        f"</header>{formulas}</article>\n"
    )


def _words(record: Record) -> str:
    """What the search looks through."""
    parts = [record.called, record.section, record.kind, record.printed]
    for formula in record.formulas:
        parts += [formula.verdict, formula.printed, formula.says, formula.method]
        parts.append(formula.source)
        parts += [formula.derived or "", formula.correction or ""]
    return " ".join(" ".join(parts).lower().split())


def _place(record: Record, places: Places) -> str:
    anchor = places[record.section, record.ordinal]
    return (
        f'<div><a href="#{anchor}">{escape(record.called)}</a> '
        f'<span class="tag">{escape(record.section)}</span></div>'
    )


def _statement(formula: FormulaRecord) -> str:
    """The formula, or the claim in words."""
    words = f'<p class="claim">{prose(formula.says)}</p>' if formula.says else ""
    if not formula.printed:
        return words
    return words + mathml(formula.printed, formula.struck, "struck", WIDE)


def _erratum(record: Record, formula: FormulaRecord, places: Places) -> str:
    parts = [_place(record, places)]
    if formula.printed:
        if formula.says:
            parts.append(f'<p class="claim">{prose(formula.says)}</p>')
        parts.append(_line("for", mathml(formula.printed, formula.struck, "struck", WIDE)))
    else:
        parts.append(f'<p class="claim">Not true: {prose(formula.says)}</p>')
    if formula.correction is not None:
        read = mathml(formula.correction, formula.changes, "mended", WIDE)
        parts.append(_line("read", read))
    else:
        if formula.derived:
            parts.append(_line("instead", mathml(formula.derived, limit=WIDE)))
        parts.append(f'<p class="method">{prose(ended(short(formula.method)))}</p>')
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
    return f'<p class="method">Compared with: {prose(ended(formula.source))}</p>'


def _cell(title: str, latex: str, marks: Sequence[tuple[int, int]] = (), mark: str = "") -> str:
    """A formula under its title: in one of two columns, or across both where it is too wide."""
    narrow = fits(latex, COLUMN)
    shown = mathml(latex, marks, mark, COLUMN if narrow else WIDE)
    return f'<div class="cell{"" if narrow else " wide"}"><span>{title}</span>{shown}</div>'


def _badge(verdict: str) -> str:
    return f'<span class="badge {verdict}">{verdict}</span>'


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
    entries = grouped(formula)
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
    said = ended(text + (f" ({what})" if what else ""))
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
