"""The report of an audit as a LaTeX article."""

from __future__ import annotations

from collections.abc import Sequence

from voronec.audit.record import Audit, FormulaRecord, Record

__all__ = ["audit_latex"]

_HEAD = r"""\documentclass[11pt]{article}
\usepackage[utf8]{inputenc}
\usepackage[T1]{fontenc}
\usepackage{amsmath,amssymb}
\usepackage{xcolor,graphicx}
\usepackage[margin=25mm]{geometry}
\definecolor{misprint}{RGB}{178,34,34}
\definecolor{mended}{RGB}{0,110,60}
\newcommand{\verdict}[1]{\textsc{#1}}
\setlength{\parindent}{0pt}
\allowdisplaybreaks
\title{Machine-checked formulas of\\\emph{%s}}
\author{}
\date{}
\begin{document}
\maketitle
"""


def audit_latex(audit: Audit) -> str:
    """Errata first, then every display by section: printed, derived, verdict."""
    parts = [_HEAD % escape_text(audit.title)]
    if audit.authors:
        parts.append(f"The paper: {escape_text(audit.authors)}.\n")
    count = ", ".join(f"{n}~{verdict}" for verdict, n in audit.count().items() if n)
    parts.append(f"{len(audit.records)} displays: {count}.\n")
    parts.append("\\section*{Errata}\n")
    parts += [_erratum(r) for r in audit.errata] or ["None.\n"]
    for section in audit.sections:
        parts.append(f"\\section*{{{escape_text(section)}}}\n")
        parts += [_record(r) for r in audit.records if r.section == section]
    return "".join(parts) + "\\end{document}\n"


def _name(record: Record) -> str:
    if record.label:
        return f"\\texttt{{({escape_text(record.label)})}}"
    return f"display {record.ordinal}"


def _erratum(record: Record) -> str:
    formula = record.decisive
    text = f"\\paragraph{{{_name(record)}}} {escape_text(record.section)}. For\n"
    text += _display(coloured(formula.printed, formula.struck, "misprint"))
    if formula.correction is None:
        return text + "no correction by a single change was found.\n"
    text += "read\n" + _display(coloured(formula.correction, formula.changes, "mended"))
    return text + _witness(formula)


def _record(record: Record) -> str:
    parts = [f"\\paragraph{{{_name(record)}}}\n"]
    for formula in record.formulas:
        parts.append(f"\\verdict{{{formula.verdict}}}\n")
        parts.append(_display(coloured(formula.printed, formula.struck, "misprint")))
        if formula.correction is not None:
            parts.append("corrected\n")
            parts.append(_display(coloured(formula.correction, formula.changes, "mended")))
        if formula.derived is not None:
            parts.append("derived\n" + _display(formula.derived))
        parts.append(f"{{\\small {escape_text(formula.method)}.}}\n\n")
    return "".join(parts)


def _witness(formula: FormulaRecord) -> str:
    if formula.witness is None:
        return ""
    left, right = formula.witness["printed"], formula.witness["derived"]
    return f"{{\\small At a point: as printed ${left}$, derived ${right}$.}}\n\n"


def _display(latex: str) -> str:
    """Long lines are shrunk to the width of the page."""
    if len(latex) < 220:
        return f"\\[\n{latex}\n\\]\n"
    return (
        "\\begin{center}\\resizebox{\\linewidth}{!}{$\\displaystyle\n"
        f"{latex}\n$}}\\end{{center}}\n"
    )


def coloured(latex: str, ranges: Sequence[tuple[int, int]], colour: str) -> str:
    """The formula with ranges of its source in colour."""
    for start, end in sorted(ranges, reverse=True):
        inner = latex[start:end]
        if inner.startswith("{") and inner.endswith("}"):
            inner = inner[1:-1]
        latex = latex[:start] + f"{{\\color{{{colour}}}{inner}}}" + latex[end:]
    return latex


def escape_text(text: str) -> str:
    """Plain text for LaTeX."""
    replaced = {"\\": "\\textbackslash{}", "_": "\\_", "&": "\\&", "%": "\\%", "#": "\\#"}
    replaced |= {"$": "\\$", "{": "\\{", "}": "\\}", "^": "\\^{}", "*": "*"}
    return "".join(replaced.get(c, c) for c in text)
