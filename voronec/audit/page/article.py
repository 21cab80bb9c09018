"""The report of an audit as a LaTeX article, for plain pdflatex.

The source is kept letter for letter; colours are put between its characters, around whole factors.
What is wider than a line is broken by TeX.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from voronec.audit.page.marks import in_environment, mark
from voronec.audit.page.mathml import convert
from voronec.audit.page.phrases import (
    KINDS,
    MEANING,
    about,
    conventions_with_formulas,
    counts,
    end_sentence,
    group_ranges,
    short,
    typeset_words,
    values,
    with_verdict,
)
from voronec.audit.page.symbols import LETTERS, SIGNS
from voronec.audit.record import VERDICTS, Audit, FormulaRecord, Record
from voronec.errors import DefinitionError

_LABEL = re.compile(r"\\(?:label|tag)\s*\{[^}]*\}")
_SPECIAL = {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}
_SPECIAL |= {c: f"\\{c}" for c in "_&%#${}"}
# signs and letters that pdflatex knows only by their commands
_SPECIAL |= {c: rf"\ensuremath{{\{n}}}" for n, c in (SIGNS | LETTERS).items() if not c.isascii()}


_EDGE = re.compile(r"\\(left|right)(?![a-zA-Z])")
_TABLE = re.compile(r"\\begin\s*\{(\w+\*?)\}.*\\end\s*\{\1\}", re.DOTALL)


def display(latex: str, marks: Sequence[tuple[int, int]] = (), command: str = "") -> str:
    r"""A displayed formula; ranges of its source in ``marks`` are arguments of ``command``.

    No line ends between ``\left`` and ``\right``: a formula of several lines has ``\bigl`` and
    ``\bigr`` in their place.  A wide table is shrunk.  What is no formula is printed as its source.
    """
    try:
        convert(latex)
        body = _body(mark(latex, marks, command))
    except DefinitionError:
        return f"\n\\texttt{{{escape_text(latex)}}}\n\n"
    if _TABLE.fullmatch(body):
        return f"\\widetable{{{body}}}\n"
    broken = _EDGE.sub(lambda edge: "\\bigl" if edge[1] == "left" else "\\bigr", body)
    return f"\\formula{{{body}}}\n" if broken == body else f"\\formulas{{{body}}}{{{broken}}}\n"


def inline(text: str) -> str:
    """Words with formulas between dollar signs."""
    return typeset_words(text, escape_text, _small)


def _small(latex: str) -> str:
    """A formula within a line."""
    try:
        convert(latex)
    except DefinitionError:
        return f"\\texttt{{{escape_text(latex)}}}"
    return f"${_body(latex)}$"


def own_commands(latex: str) -> set[str]:
    r"""Commands in a formula that LaTeX may not know, such as ``\diag`` of the paper's own."""
    try:
        return {f"\\{name}" for name in convert(latex)[1]}
    except DefinitionError:
        return set()


def escape_text(text: str) -> str:
    """Plain text for LaTeX."""
    return "".join(_SPECIAL.get(c, c) for c in text)


def _body(latex: str) -> str:
    """The formula without its label; lines or cells outside any environment get one."""
    return in_environment(_LABEL.sub("", latex).strip())


_HEAD = r"""\documentclass[11pt]{article}
\usepackage[T1]{fontenc}
\usepackage[utf8]{inputenc}
\IfFileExists{lmodern.sty}{\usepackage{lmodern}}{}
\usepackage{amsmath,amssymb}
\usepackage{xcolor,graphicx}
\usepackage{array,longtable}
\newcolumntype{P}[1]{>{\raggedright\arraybackslash}p{#1\linewidth}}
\usepackage[margin=25mm]{geometry}
\definecolor{misprint}{RGB}{178,34,34}
\definecolor{proved}{RGB}{0,100,55}
\definecolor{convention}{RGB}{138,90,0}
\definecolor{definition}{RGB}{67,84,154}
\definecolor{undecided}{RGB}{122,62,157}
\definecolor{cited}{RGB}{70,96,109}
\definecolor{unaudited}{RGB}{107,107,79}
\colorlet{refuted}{misprint}
\colorlet{not read}{unaudited}
\newcommand{\verdict}[1]{{\color{#1}\textsc{#1}}}
\newcommand{\mended}[1]{{\color{proved}#1}}
\newcommand{\struck}[1]{\mathpalette\struckin{#1}}
% a red line through the formula: plain TeX, so that no further package is needed
\newcommand{\struckin}[2]{{\color{misprint}\setbox0\hbox{$#1#2$}%
  \rlap{\raise\dimexpr(\ht0-\dp0)/2\relax\hbox to\wd0{\leaders\hrule height.5pt\hfill}}\box0}}
\newsavebox{\formulabox}
% a formula that is wider than a line is broken by TeX; the second argument is its form there
\newcommand{\formulas}[2]{\sbox{\formulabox}{$\displaystyle#1$}%
  \ifdim\wd\formulabox>\linewidth
  \par{\raggedright\hangindent=2em\hangafter=1\noindent$\displaystyle#2$\par}%
  \else\[#1\]\fi}
\newcommand{\formula}[1]{\formulas{#1}{#1}}
% a table is shrunk
\newcommand{\widetable}[1]{\sbox{\formulabox}{$\displaystyle#1$}%
  \ifdim\wd\formulabox>\linewidth
  \[\resizebox{\linewidth}{!}{\usebox{\formulabox}}\]\else\[#1\]\fi}
\setlength{\parindent}{0pt}
\setlength{\parskip}{.35\baselineskip}
\emergencystretch=3em
\allowdisplaybreaks
"""


def audit_latex(audit: Audit) -> str:
    """Counts, errata and conventions first, then every record by section."""
    parts = [_HEAD, *_commands(audit)]
    parts += [f"\\title{{Machine-checked formulas of\\\\\\emph{{{escape_text(audit.title)}}}}}\n"]
    parts += ["\\author{}\n\\date{}\n\\begin{document}\n\\maketitle\n"]
    if audit.authors:
        parts.append(f"The paper: {escape_text(audit.authors)}.\n\n")
    parts.append(_summary(audit))
    parts.append("\\section*{Errata}\n")
    wrong = enumerate(with_verdict(audit, "misprint"), 1)
    parts += [_erratum(n, r, f) for n, (r, f) in wrong] or ["None.\n"]
    held = [
        _convention(n, s, pairs) for n, (s, pairs) in enumerate(conventions_with_formulas(audit), 1)
    ]
    parts += ["\\section*{Conventions and ranges}\n", *held] if held else []
    for section in audit.sections:
        parts.append(f"\\section*{{{escape_text(section)}}}\n")
        parts += [_record(r) for r in audit.records if r.section == section]
    return "".join(parts) + "\\end{document}\n"


def _commands(audit: Audit) -> list[str]:
    """Definitions of the paper's own commands, such as ``\\diag``."""
    commands: set[str] = set()
    for formula in (f for r in audit.records for f in r.formulas):
        for latex in (formula.printed, formula.correction, formula.derived, *formula.quantifiers):
            commands |= own_commands(latex or "")
        commands |= {c for piece in formula.says.split("$")[1::2] for c in own_commands(piece)}
    return [f"\\providecommand{{{c}}}{{\\operatorname{{{c[1:]}}}}}\n" for c in sorted(commands)]


def _summary(audit: Audit) -> str:
    by_kind = counts(audit)
    heads = " & ".join(KINDS[kind] for kind in by_kind)
    rows = []
    for verdict in reversed(VERDICTS):
        numbers = [str(by_kind[kind][verdict]) for kind in by_kind]
        if any(n != "0" for n in numbers):
            rows.append(f"\\verdict{{{verdict}}} & {' & '.join(numbers)} & {MEANING[verdict]}")
    totals = " & ".join(str(sum(by_kind[kind].values())) for kind in by_kind)
    body = "\\\\\n".join([f"& {heads} &", *rows, f"all & {totals} &"])
    columns = f"l{'r' * len(by_kind)}P{{.42}}"
    return f"\\begin{{longtable}}{{{columns}}}\n{body}\n\\end{{longtable}}\n\n"


def _place(record: Record, number: str = "") -> str:
    return f"\\paragraph{{{number}\\texttt{{{escape_text(record.designation)}}}}}"


def _erratum(number: int, record: Record, formula: FormulaRecord) -> str:
    text = f"{_place(record, f'{number}. ')} {escape_text(record.section)}.\n"
    if not formula.printed:
        text += f"Not true: {inline(formula.says)}\n\n"
    else:
        text += f"{inline(formula.says)} For\n" + display(formula.printed, formula.struck, "struck")
    if formula.correction is not None:
        text += "read\n" + display(formula.correction, formula.changes, "mended")
        return text + _witness(formula)
    if formula.derived:
        text += "Instead\n" + display(formula.derived)
    return text + _method(formula) + _witness(formula)


def _convention(number: int, said: str, several: Sequence[tuple[Record, FormulaRecord]]) -> str:
    text = ""
    for place, (record, formula) in enumerate(several):
        count = "" if place else f"{number}. "
        text += f"{_place(record, count)} {escape_text(record.section)}.\n{inline(formula.says)}\n"
        text += display(formula.printed) if formula.printed else "\n"
    return f"{text}\n{{\\small {inline(end_sentence(short(said)))}\\par}}\n\n"


def _record(record: Record) -> str:
    tag = f" {record.kind}" if record.label else ""
    parts = [f"{_place(record)}{tag}\n"]
    for formula in record.formulas:
        parts.append(f"\\verdict{{{formula.verdict}}} {inline(formula.says)}\n")
        if formula.printed:
            parts.append(display(formula.printed, formula.struck, "struck"))
        if formula.correction is not None:
            parts.append("corrected\n" + display(formula.correction, formula.changes, "mended"))
        if formula.derived:
            parts.append("derived\n" + display(formula.derived))
        parts += [_method(formula), _ranges(formula), _witness(formula)]
    return "".join(parts)


def _method(formula: FormulaRecord) -> str:
    quantifiers = ", ".join(f"${q}$" for q in formula.quantifiers)
    text = f"For {quantifiers}. " if quantifiers else ""
    return f"\n{{\\small {text}{inline(end_sentence(short(formula.method)))}\\par}}\n\n"


def _ranges(formula: FormulaRecord) -> str:
    """In which ranges it holds, with what is said of each."""
    rows = []
    for entry in group_ranges(formula):
        said = ", ".join(part for part in (entry["method"], entry["witness"]) if part)
        cells = (escape_text(entry["range"]), inline(entry["where"]))
        rows.append(" & ".join((*cells, f"\\verdict{{{entry['verdict']}}}", inline(said))))
    if not rows:
        return ""
    body = "\\\\\n".join(rows)
    columns = "P{.15}P{.22}P{.12}P{.38}"
    return f"\\begin{{longtable}}{{{columns}}}\n{body}\n\\end{{longtable}}\n\n"


def _witness(formula: FormulaRecord) -> str:
    sides = values(formula)
    if not sides or formula.witness is None:
        return ""
    what = f" ({escape_text(about(formula.witness))})" if about(formula.witness) else ""
    first, second = (f"{name} \\texttt{{{escape_text(short(v))}}}" for name, v in sides)
    stop = "" if short(sides[1][1]).endswith("...") else "."
    return f"{{\\small At a point: {first}{what}, {second}{stop}\\par}}\n\n"
