"""Records of an audit as HTML: printed beside derived, verdict, correction, witness."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any

from voronec.audit.record import Audit, FormulaRecord, Record
from voronec.report.audit_words import about, point, short, sides, with_verdict
from voronec.report.mathml import fits, mathml, prose

__all__ = ["anchors", "conventions", "errata", "record_html"]

COLUMN, WIDE = 31.0, 64.0
"""How wide a formula may be in one of two columns, and in a line of its own, in em."""

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
    items = "".join(
        f'<li>{_place(r, places)}{_statement(f)}<p class="method">{prose(f.method)}</p></li>'
        for r, f in with_verdict(audit, "convention")
    )
    return f'<ol id="conventions-list">{items}</ol>' if items else ""


def record_html(record: Record, places: Places) -> str:
    """One record with all its formulas."""
    anchor = places[record.section, record.ordinal]
    formulas = "".join(_formula(f, len(record.formulas) > 1) for f in record.formulas)
    verdicts = " ".join(dict.fromkeys(f.verdict for f in record.formulas))
    tag = f"{record.kind} {record.ordinal}" if record.label else ""
    return (
        f'<article id="{anchor}" data-verdicts="{verdicts}" data-kind="{record.kind}" '
        f'data-text="{escape(_words(record), quote=True)}"><header><a href="#{anchor}">'
        f'{escape(record.called)}</a><span class="tag">{tag}</span>{_badge(record.verdict)}'
        f"</header>{formulas}</article>\n"
    )


def _words(record: Record) -> str:
    """What the search looks through."""
    parts = [record.called, record.section, record.kind, record.printed]
    for formula in record.formulas:
        parts += [formula.verdict, formula.printed, formula.says, formula.method]
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
        parts.append(f'<p class="method">{prose(short(formula.method))}</p>')
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
        f'<p class="method">{badge}{prose(short(formula.method))}</p>'
        f"{_ranges(formula.ranges)}{_numbers(formula)}{_point(formula)}</div>"
    )


def _cell(title: str, latex: str, marks: Sequence[tuple[int, int]] = (), mark: str = "") -> str:
    """A formula under its title: in one of two columns, or across both where it is too wide."""
    narrow = fits(latex, COLUMN)
    shown = mathml(latex, marks, mark, COLUMN if narrow else WIDE)
    return f'<div class="cell{"" if narrow else " wide"}"><span>{title}</span>{shown}</div>'


def _badge(verdict: str) -> str:
    return f'<span class="badge {verdict}">{verdict}</span>'


def _ranges(ranges: Iterable[Mapping[str, Any]]) -> str:
    """In which ranges of the parameters it holds."""
    rows = "".join(
        f"<tr><td>{escape(r['range'])}</td><td>{_in_math(r['statement'])}</td>"
        f"<td>{_badge(r['verdict'])}</td><td>{prose(short(r['method']))}</td>"
        f"<td>{_range_witness(r['witness'])}</td></tr>"
        for r in ranges
    )
    if not rows:
        return ""
    heads = "".join(f"<th>{h}</th>" for h in ("range", "where", "verdict", "method", "witness"))
    return f'<div class="cell"><table><tr>{heads}</tr>{rows}</table></div>'


def _in_math(statement: str) -> str:
    if "$" in statement or not statement:
        return prose(statement)
    return mathml(statement, inline=True)


def _range_witness(witness: Mapping[str, Any] | None) -> str:
    if witness is None:
        return ""
    values = " against ".join(short(value) for value in _both(witness))
    return escape(f"{values} at {point(witness)}")


def _numbers(formula: FormulaRecord) -> str:
    """The two values of a witness."""
    witness = formula.witness
    if witness is None:
        return ""
    what = about(witness)
    first, second = sides(formula)
    return (
        f'<p class="numbers"><span>{first}</span> {escape(short(witness["printed"]))}'
        f"{escape(f' ({what})') if what else ''}<br>"
        f"<span>{second}</span> {escape(short(witness['derived']))}</p>"
    )


def _at_a_point(formula: FormulaRecord, link: str) -> str:
    """The witness on one line; the record has the point."""
    if formula.witness is None:
        return ""
    what = about(formula.witness)
    values = zip(sides(formula), _both(formula.witness), strict=True)
    text = ", ".join(f"{name} {short(value)}" for name, value in values)
    place = f'<a href="#{link}">At a point</a>'
    return f'<p class="method">{place}: {escape(text + (f" ({what})" if what else ""))}.</p>'


def _point(formula: FormulaRecord) -> str:
    witness = formula.witness
    if witness is None or not witness["point"]:
        return ""
    values = {**witness["point"], **dict(zip(sides(formula), _both(witness), strict=True))}
    rows = "".join(f"<dt>{escape(str(k))}</dt><dd>{escape(str(v))}</dd>" for k, v in values.items())
    return f"<details><summary>the point, all digits</summary><dl>{rows}</dl></details>"


def _both(witness: Mapping[str, Any]) -> tuple[str, str]:
    return str(witness["printed"]), str(witness["derived"])
