"""The report of an audit as one page: typeset, searchable, readable offline."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

from voronec.audit.record import VERDICTS, Audit
from voronec.report.audit_words import KINDS, MEANING, counts
from voronec.report.page_records import (
    anchors,
    conventions,
    errata,
    record_html,
    unaudited,
)
from voronec.report.page_style import SCRIPT, STYLE

__all__ = ["Figure", "audit_page"]


@dataclass(frozen=True)
class Figure:
    """A picture for the page: an SVG or PNG file, and what it shows."""

    path: Path
    caption: str = ""


def audit_page(audit: Audit, figures: Sequence[Figure] = ()) -> str:
    """A self-contained HTML page: counts, errata, conventions, then every record by section."""
    places = anchors(audit)
    sections = "".join(_section(audit, n, places) for n in range(len(audit.sections)))
    pictures = "".join(map(_figure, figures))
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>Audit: {escape(audit.title)}</title><style>{STYLE}</style></head><body>\n"
        f"{_contents(audit)}<main>\n<h1>{escape(audit.title)}</h1>\n"
        f'<p class="by">{escape(audit.authors)}</p>\n{_summary(audit)}\n'
        f'<section id="errata"><h2>Errata</h2>\n{errata(audit, places)}</section>\n'
        f"{_conventions(audit, places)}{_unaudited(audit, places)}{_search(audit)}\n"
        f"{sections}{pictures}</main>\n"
        f"<script>{SCRIPT}</script></body></html>\n"
    )


def _contents(audit: Audit) -> str:
    lines = []
    for number, title in enumerate(audit.sections, 1):
        records = [r for r in audit.records if r.section == title]
        wrong = sum(r.verdict == "misprint" for r in records)
        mark = f"<i>{wrong}</i> / " if wrong else ""
        link = f'<a href="#section-{number}">{escape(title)}</a>'
        lines.append(f"<li>{link}<b>{mark}{len(records)}</b></li>")
    head = '<li><a href="#errata">Errata</a></li>'
    if any(r.verdict == "convention" for r in audit.records):
        head += '<li><a href="#conventions">Conventions</a></li>'
    if any(r.verdict == "unaudited" for r in audit.records):
        head += '<li><a href="#unaudited">Not audited</a></li>'
    return f"<aside><b>Contents</b><ol>{head}</ol><b>Sections</b><ol>{''.join(lines)}</ol></aside>"


def _summary(audit: Audit) -> str:
    found = counts(audit)
    verdicts = [v for v in reversed(VERDICTS) if any(c[v] for c in found.values())]
    heads = "".join(f"<th>{KINDS[kind]}</th>" for kind in found)
    rows = []
    for verdict in verdicts:
        cells = "".join(f'<td class="n">{found[kind][verdict]}</td>' for kind in found)
        name = f'<td><span class="badge {verdict}">{verdict}</span></td>'
        rows.append(f"<tr>{name}{cells}<td>{MEANING[verdict]}</td></tr>")
    totals = "".join(f'<td class="n">{sum(found[kind].values())}</td>' for kind in found)
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


def _conventions(audit: Audit, places: dict[tuple[str, int], str]) -> str:
    found = conventions(audit, places)
    if not found:
        return ""
    return (
        f'<section id="conventions"><h2>Conventions and ranges</h2>\n'
        '<p class="lead">True as printed under a convention that another formula contradicts, or '
        f"in some ranges of the parameters only.</p>{found}</section>\n"
    )


def _unaudited(audit: Audit, places: dict[tuple[str, int], str]) -> str:
    found = unaudited(audit, places)
    if not found:
        return ""
    return (
        f'<section id="unaudited"><h2>Not audited</h2>\n'
        '<p class="lead">What the text states, and nothing here decides. Sentences on history, on '
        f"sources and on what comes next state nothing of the kind.</p>{found}</section>\n"
    )


def _search(audit: Audit) -> str:
    found = counts(audit)
    buttons = ""
    for verdict, count in audit.count().items():
        if count:
            buttons += _button("verdict", verdict, verdict, count)
    for kind in found:
        buttons += _button("kind", kind, KINDS[kind], sum(found[kind].values()))
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
