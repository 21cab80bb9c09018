"""The report of an audit as one page: typeset, searchable, readable offline."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

from voronec.audit.record import Audit, FormulaRecord, Record
from voronec.report.mathml import mathml

__all__ = ["Figure", "audit_page"]


@dataclass(frozen=True)
class Figure:
    """A picture for the page: an SVG or PNG file, and what it shows."""

    path: Path
    caption: str = ""


_STYLE = """
:root { --ink:#1c1e21; --soft:#5d646e; --line:#dfe3e8; --paper:#fff; --tint:#f6f7f9;
  --misprint:#b3261e; --proved:#1b6e3c; --definition:#4a5a8a; --convention:#8a5a00;
  --undecided:#7a3e9d; --cited:#4d6470; }
@media (prefers-color-scheme: dark) { :root { --ink:#e7e9ec; --soft:#a3abb6; --line:#363c45;
  --paper:#15181c; --tint:#1d2127; --misprint:#ff8a80; --proved:#7bd6a0; --definition:#a9b8ee;
  --convention:#eebf6d; --undecided:#d3a5f0; --cited:#a8c0cc; } }
* { box-sizing:border-box; }
body { font:16px/1.55 Georgia,"Times New Roman",serif; color:var(--ink); background:var(--paper);
  max-width:62rem; margin:2.5rem auto; padding:0 1.2rem; }
h1 { font-size:1.65rem; line-height:1.25; margin:0 0 .3rem; } h2 { margin:2.6rem 0 .6rem;
  font-size:1.25rem; border-bottom:1px solid var(--line); padding-bottom:.25rem; }
.by, .method, .count, figcaption { color:var(--soft); font-size:.92rem; }
nav { position:sticky; top:0; background:var(--paper); padding:.6rem 0; z-index:1;
  display:flex; gap:.5rem; flex-wrap:wrap; align-items:center; }
input { font:inherit; padding:.3rem .6rem; border:1px solid var(--line); border-radius:.4rem;
  background:var(--tint); color:inherit; flex:1; min-width:12rem; }
button { font:.85rem/1.4 system-ui,sans-serif; border:1px solid var(--line); color:inherit;
  background:none; border-radius:1rem; padding:.15rem .7rem; cursor:pointer; }
button[aria-pressed=true] { background:var(--ink); color:var(--paper); }
article { border:1px solid var(--line); border-radius:.5rem; margin:.9rem 0; overflow:hidden; }
article > header { display:flex; gap:.8rem; align-items:baseline; padding:.45rem .9rem;
  background:var(--tint); } article header code { font-size:.9rem; }
.badge { font:600 .74rem/1 system-ui,sans-serif; letter-spacing:.03em; text-transform:uppercase; }
.misprint { color:var(--misprint); } .proved { color:var(--proved); }
.definition { color:var(--definition); } .convention { color:var(--convention); }
.undecided { color:var(--undecided); } .cited { color:var(--cited); }
.formula { padding:.5rem .9rem .7rem; } .formula + .formula { border-top:1px dashed var(--line); }
.side { display:grid; grid-template-columns:5.5rem 1fr; align-items:center; overflow-x:auto; }
.side > span { font:.78rem/1.3 system-ui,sans-serif; color:var(--soft); }
math { font-size:1.08rem; margin:.35rem 0; width:max-content; }
.struck { color:var(--misprint); background:color-mix(in srgb,var(--misprint) 16%,transparent);
  text-decoration:line-through; } .mended { color:var(--proved);
  background:color-mix(in srgb,var(--proved) 18%,transparent); font-weight:bold; }
.mathbf { font-weight:bold; } .method { margin:.3rem 0 0; }
details { font-size:.88rem; margin-top:.3rem; } summary { cursor:pointer; color:var(--soft); }
details dl { display:grid; grid-template-columns:auto 1fr; gap:0 .9rem; margin:.4rem 0;
  font-family:ui-monospace,monospace; font-size:.8rem; } dd { margin:0; overflow-wrap:anywhere; }
.numbers { font-family:ui-monospace,monospace; font-size:.82rem; overflow-x:auto; }
figure { margin:1.2rem 0; text-align:center; } figure img { max-width:100%; }
[hidden] { display:none; }
"""

_SCRIPT = """
const box=document.getElementById('search'), buttons=[...document.querySelectorAll('nav button')];
const pressed=b=>b.getAttribute('aria-pressed')=='true';
function show(){const t=box.value.toLowerCase(),v=buttons.find(pressed);
 const want=v?v.dataset.verdict:'';
 for(const a of document.querySelectorAll('article[data-text]')){
  a.hidden=!(a.dataset.text.includes(t)&&(!want||a.dataset.verdict==want));}}
box.addEventListener('input',show);
for(const b of buttons)b.addEventListener('click',()=>{const on=pressed(b);
 for(const x of buttons)x.setAttribute('aria-pressed','false');
 b.setAttribute('aria-pressed',String(!on));show();});
"""


def audit_page(audit: Audit, figures: Sequence[Figure] = ()) -> str:
    """A self-contained HTML page: errata, then every display by section."""
    sections = "".join(_section(audit, title) for title in audit.sections)
    pictures = "".join(map(_figure, figures))
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>Audit: {escape(audit.title)}</title><style>{_STYLE}</style></head><body>\n"
        f"<h1>{escape(audit.title)}</h1>\n<p class=by>{escape(audit.authors)}</p>\n"
        f"{_count(audit)}\n<h2 id=errata>Errata</h2>\n{_errata(audit)}\n{_search(audit)}\n"
        f"{sections}{pictures}<script>{_SCRIPT}</script></body></html>\n"
    )


def _count(audit: Audit) -> str:
    parts = [
        f"<span class={verdict}>{number} {verdict}</span>"
        for verdict, number in audit.count().items()
        if number
    ]
    return f"<p class=count>{len(audit.records)} displays: {', '.join(parts)}</p>"


def _search(audit: Audit) -> str:
    buttons = "".join(
        f'<button data-verdict="{verdict}" aria-pressed=false>{verdict} {number}</button>'
        for verdict, number in audit.count().items()
        if number
    )
    return (
        f'<nav><input id=search type=search placeholder="label, LaTeX, method ...">{buttons}</nav>'
    )


def _name(record: Record) -> str:
    return f"({record.label})" if record.label else f"display {record.ordinal}"


def _anchor(record: Record) -> str:
    section = "".join(c if c.isalnum() else "-" for c in record.section.lower())
    return f"{section}-{record.ordinal}"


def _errata(audit: Audit) -> str:
    if not audit.errata:
        return "<p>None.</p>"
    return "".join(
        _erratum(r, f) for r in audit.errata for f in r.formulas if f.verdict == "misprint"
    )


def _erratum(record: Record, formula: FormulaRecord) -> str:
    read = "no correction by a single change was found"
    if formula.correction is not None:
        read = mathml(formula.correction, formula.changes, "mended")
    return (
        f'<article><header><a href="#{_anchor(record)}"><code>{escape(_name(record))}</code></a>'
        f"<span class=by>{escape(record.section)}</span></header><div class=formula>"
        f"{_side('for', mathml(formula.printed, formula.struck, 'struck'))}"
        f"{_side('read', read)}{_witness(formula)}</div></article>"
    )


def _section(audit: Audit, title: str) -> str:
    records = "".join(_record(r) for r in audit.records if r.section == title)
    return f"<h2>{escape(title)}</h2>\n{records}"


def _record(record: Record) -> str:
    words = " ".join([_name(record), record.printed, *(f.method for f in record.formulas)])
    formulas = "".join(_formula(f) for f in record.formulas)
    return (
        f'<article id="{_anchor(record)}" data-verdict="{record.verdict}" '
        f'data-text="{escape(words.lower(), quote=True)}"><header><code>{escape(_name(record))}'
        f'</code><span class="badge {record.verdict}">{record.verdict}</span></header>'
        f"{formulas}</article>\n"
    )


def _formula(formula: FormulaRecord) -> str:
    parts = [_side("printed", mathml(formula.printed, formula.struck, "struck"))]
    if formula.correction is not None:
        parts.append(_side("corrected", mathml(formula.correction, formula.changes, "mended")))
    if formula.derived is not None:
        parts.append(_side("derived", mathml(formula.derived)))
    badge = f'<b class="badge {formula.verdict}">{formula.verdict}</b> '
    parts.append(f"<p class=method>{badge}{escape(formula.method)}</p>{_witness(formula)}")
    return f"<div class=formula>{''.join(parts)}</div>"


def _side(title: str, body: str) -> str:
    return f"<div class=side><span>{title}</span><div>{body}</div></div>"


def _witness(formula: FormulaRecord) -> str:
    witness = formula.witness
    if witness is None:
        return ""
    rows = "".join(f"<dt>{escape(k)}</dt><dd>{escape(v)}</dd>" for k, v in witness["point"].items())
    indices = ", ".join(f"{k} = {v}" for k, v in witness.get("indices", {}).items())
    about = f" ({witness['about']})" if "about" in witness else ""
    return (
        f"<p class=numbers>as printed {escape(witness['printed'] + about)}<br>"
        f"derived&nbsp;&nbsp;&nbsp; {escape(witness['derived'])}</p>"
        f"<details><summary>the point {escape(indices)}</summary>"
        f"<dl>{rows}</dl></details>"
    )


def _figure(figure: Figure) -> str:
    kind = "image/svg+xml" if figure.path.suffix == ".svg" else "image/png"
    data = base64.b64encode(figure.path.read_bytes()).decode("ascii")
    return (
        f'<figure><img alt="{escape(figure.caption, quote=True)}" src="data:{kind};base64,{data}">'
        f"<figcaption>{escape(figure.caption)}</figcaption></figure>\n"
    )
