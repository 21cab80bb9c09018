"""A derivation step by step as a record: its text, LaTeX document, page, and data."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape
from textwrap import wrap
from typing import Any

from voronec.algebra.symbols import plain_name
from voronec.algebra.typeset import caret_text, latex_of, symbol_latex
from voronec.algebra.verdicts import Verdict
from voronec.audit.page.article import escape_text
from voronec.audit.page.mathml import mathml
from voronec.declaration.system import System
from voronec.equations.voronec_equations import VoronecEquations, equation_rows

__all__ = ["Field", "Lesson", "Part", "Row"]

WIDTH = 96
COLUMN = 52.0
"""How wide a formula on the page may be, in em."""


_INDENT: dict[str, Any] = {"initial_indent": "  ", "subsequent_indent": "  "}


@dataclass(frozen=True)
class Field:
    """A vector field: coefficients, each with the coordinate (or time) of its differentiation."""

    terms: tuple[tuple[Any, Any], ...]


@dataclass(frozen=True)
class Row:
    """A formula: its left side as text and as LaTeX, and the value; or both sides as values."""

    text: str
    latex: str
    value: Any


@dataclass(frozen=True)
class Part:
    """A step: what is asked and done, the formula of the theory, and what comes out.

    ``numbers`` are those of the formulas in ``docs/theory.md``; ``formula`` is the one that is
    used, as text and as LaTeX.  Where nothing comes out, ``nothing`` says so.
    """

    title: str
    sentence: str
    numbers: str = ""
    formula: tuple[str, str] = ("", "")
    rows: tuple[Row, ...] = ()
    nothing: str = ""


@dataclass(frozen=True)
class Lesson:
    """The steps of a derivation, and the verdict on their sum."""

    equations: VoronecEquations
    parts: tuple[Part, ...]
    verdict: Verdict

    @property
    def system(self) -> System:
        """The system."""
        return self.equations.system

    def __repr__(self) -> str:
        return f"Lesson({self.system.name!r}, {len(self.parts)} steps: {self.verdict.status})"

    def lines(self) -> list[str]:
        """Numbered steps: what is done, the formula with its number, what comes out."""
        lines = [_title(self)]
        for number, part in enumerate(self.parts, 1):
            lines += ["", f"{number}. {part.title}", *wrap(part.sentence, WIDTH, **_INDENT)]
            if part.formula[0]:
                lines.append(f"      {part.formula[0]}    {part.numbers}".rstrip())
            rows = [_text(row) for row in part.rows]
            lines += [f"  {row}" for row in equation_rows(rows)] or _nothing(part)
        return [*lines, "", *wrap(_end(self), WIDTH, **_INDENT)]

    def latex(self) -> str:
        """A document of its own; formulas of the theory bear its numbers."""
        body = [f"\\section*{{{escape_text(_title(self))}}}"]
        for number, part in enumerate(self.parts, 1):
            body.append(f"\\subsection*{{{number}. {escape_text(part.title)}}}")
            body.append(escape_text(part.sentence))
            if part.formula[1]:
                tag = f"\\tag*{{{part.numbers}}}" if part.numbers else ""
                body.append(f"\\[ {part.formula[1]} {tag}\\]")
            rows = [f"\\[ {_latex(self, row)} \\]" for row in part.rows]
            body += rows or ([escape_text(part.nothing)] if part.nothing else [])
        body.append(escape_text(_end(self)))
        return "\n".join(
            [
                "\\documentclass{article}",
                "\\usepackage{amsmath,amssymb}",
                "\\begin{document}",
                *body,
                "\\end{document}",
                "",
            ]
        )

    def html(self) -> str:
        """One page; formulas are MathML, and nothing is loaded."""
        title = escape(_title(self))
        return "\n".join(
            [
                '<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">',
                '<meta name="viewport" content="width=device-width, initial-scale=1">',
                f"<title>{title}</title><style>{STYLE}</style></head><body><h1>{title}</h1>",
                *_sections(self),
                f"<p class='end'>{escape(_end(self))}</p></body></html>",
                "",
            ]
        )

    def as_dict(self) -> dict[str, Any]:
        """The steps with their formulas as text and LaTeX."""
        return {
            "system": self.system.name,
            "steps": [
                {
                    "title": part.title,
                    "sentence": part.sentence,
                    "theory": part.numbers,
                    "formula": part.formula[0],
                    "results": [
                        {
                            "left": _text(row)[0],
                            "right": _text(row)[1],
                            "latex": _latex(self, row),
                        }
                        for row in part.rows
                    ],
                }
                for part in self.parts
            ],
            "check": self.verdict.status,
            "why": self.verdict.method,
        }

    def __str__(self) -> str:
        return "\n".join(self.lines())


def _nothing(part: Part) -> list[str]:
    return [f"  {part.nothing}"] if part.nothing else []


def _title(found: Lesson) -> str:
    system = found.system
    return f"{system.name}: {system.title}" if system.title else system.name


def _end(found: Lesson) -> str:
    """What the proof at the end says."""
    if found.verdict.proved:
        why = "identical" if "identical" in found.verdict.method else "their difference is zero"
        return (
            "Check: the terms, put together, are the equations that 'voronec derive' prints: "
            f"proved, {why} in exact normal form."
        )
    return f"Check: {found.verdict.status}: {found.verdict.method}."


def _text(row: Row) -> tuple[str, str]:
    if isinstance(row.value, tuple):
        left, right = map(caret_text, row.value)
        return left, right
    if isinstance(row.value, Field):
        terms = [(c, caret_text(c), f"d_{plain_name(q)}") for c, q in row.value.terms]
        return row.text, _sum(terms, " ", "({})")
    return row.text, caret_text(row.value)


def _formula(found: Lesson, value: Any) -> str:
    system = found.system
    if isinstance(value, Field):
        terms = [
            (c, _formula(found, c), f"\\partial_{{{symbol_latex(plain_name(q))}}}")
            for c, q in value.terms
        ]
        return _sum(terms, "\\,", "\\left({}\\right)")
    return latex_of(value, system.coordinates, system.velocities)


def _sum(terms: Sequence[tuple[Any, str, str]], times: str, brackets: str) -> str:
    """Coefficients before signs of differentiation, which act on what the field is applied to."""
    text = ""
    for coefficient, written, sign in terms:
        factor = brackets.format(written) if coefficient.is_Add else written
        term = (
            sign if coefficient == 1 else f"-{sign}" if coefficient == -1 else factor + times + sign
        )
        text += (
            f" - {term[1:].lstrip()}"
            if term.startswith("-") and text
            else f" + {term}"
            if text
            else term
        )
    return text


def _latex(found: Lesson, row: Row) -> str:
    if isinstance(row.value, tuple):
        left, right = (_formula(found, value) for value in row.value)
        return f"{left} = {right}"
    return f"{row.latex} = {_formula(found, row.value)}"


def _sections(found: Lesson) -> Iterator[str]:
    for number, part in enumerate(found.parts, 1):
        yield f"<h2>{number}. {escape(part.title)}</h2><p>{escape(part.sentence)}</p>"
        if part.formula[1]:
            told = f"<span>{escape(part.numbers)}</span>" if part.numbers else ""
            yield f"<div class='theory'>{mathml(part.formula[1], limit=COLUMN)}{told}</div>"
        for row in part.rows:
            yield f"<div class='row'>{mathml(_latex(found, row), limit=COLUMN)}</div>"
        if not part.rows and part.nothing:
            yield f"<p>{escape(part.nothing)}</p>"


STYLE = """
:root { color-scheme: light dark; }
body { font: 17px/1.55 "STIX Two Text", "Latin Modern Roman", Georgia, serif; max-width: 56rem;
  margin: 0 auto; padding: 1.5rem; }
h1 { font-size: 1.7rem; } h2 { font-size: 1.2rem; margin: 2rem 0 .3rem; }
.theory { display: flex; align-items: center; gap: 1rem; background: #8881; padding: .4rem 1rem;
  border-left: 3px solid #43549a; overflow-x: auto; }
math { font-family: "Latin Modern Math", "STIX Two Math", "Cambria Math", math; }
mo.accent { padding-bottom: .12em; }
.theory math { flex: 1; } .theory span { color: #777; white-space: nowrap; }
.row { overflow: auto hidden; padding: .4rem 1rem; }
.end { margin-top: 2rem; border-top: 1px solid #8885; padding-top: .8rem; }
"""
