"""The derivation of a system's equations, step by step, with the numbers of the theory's formulas.

Each step is computed from the one before it by the formula that it names [Theory, eq. (2) to (11)];
at the end what the steps give is proved to be what ``voronec derive`` prints.

The record of a lesson is its text, LaTeX document, page, and data.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape
from itertools import combinations
from pathlib import Path
from textwrap import wrap
from typing import Any

import sympy as sp

from voronec.algebra.matrices import dot
from voronec.algebra.normal import shortest
from voronec.algebra.symbols import plain_name, time, velocity
from voronec.algebra.typeset import caret_text, latex_of, symbol_latex
from voronec.algebra.verdicts import Verdict
from voronec.audit.page.article import escape_text
from voronec.audit.page.mathml import mathml
from voronec.declaration.system import System
from voronec.equations.readable import equation_rows
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.errors import DefinitionError
from voronec.proof.decision import all_zero


def lesson(system: System | VoronecEquations) -> Lesson:
    """The derivation of the equations of motion, step by step [Theory, eq. (2) to (11)].

    What is given; the velocities that the constraints admit; the horizontal fields; their brackets
    and the curvature; the Lagrangian on the constraints and the momenta of the fibre; the terms of
    the equations, and the equations.  Raises ``DefinitionError`` for systems on groups, with forces
    that hold accelerations, or too large to be written out.
    """
    equations = system if isinstance(system, VoronecEquations) else derive(system)
    name, definition = equations.system.name, equations.definition
    if definition.group is not None or definition.added:
        raise DefinitionError(
            f"system '{name}': a derivation is told step by step in coordinates, with forces that "
            "hold no acceleration; 'voronec derive' prints its equations"
        )
    if not equations.in_normal_form:
        raise DefinitionError(
            f"system '{name}': its derivation is too long to be written out; "
            f"'voronec derive {name} --python' prints its program"
        )
    work = LessonWork(equations)
    verdict = all_zero(work.differences(), (*definition.relations, *definition.conditions))
    return Lesson(equations, tuple(work.parts()), verdict)


TERMS = (
    (
        "The momenta",
        "Lc is differentiated by the velocities in use:",
        ("dLc/dv^i", r"\frac{\partial L_c}{\partial v^i}"),
        ("dLc/d{}", r"\frac{{\partial L_c}}{{\partial {}}}"),
    ),
    (
        "The slopes of Lc along the fields",
        "Lc is differentiated along each of the fields:",
        ("h_i(Lc)", r"h_i(L_c)"),
        ("h[{}](Lc)", r"h_{{{}}}(L_c)"),
    ),
    (
        "The term of the curvature",
        "What Lagrange's equations do not have: the brackets, with the momenta and the velocities.",
        (
            "(c_ij^k dLc/dv^k + B_ij^A p_A) v^j",
            r"\Big(c_{ij}^k\frac{\partial L_c}{\partial v^k} + B_{ij}^A p_A\Big)v^j",
        ),
        ("G[{}]", r"G_{{{}}}"),
    ),
    (
        "The forces along the fields",
        "The work of the forces along each of the fields:",
        ("E_i^b Q_b + a_i^A Q_A", r"E_i^b Q_b + a_i^A Q_A"),
        ("Pi[{}]", r"\Pi_{{{}}}"),
    ),
)
"""The terms of the equations (9), one step each: title, sentence, formula, and names of values."""


class LessonWork:
    """What the steps compute, in the engine's symbols; each from those before it."""

    def __init__(self, equations: VoronecEquations) -> None:
        self.eqs = equations
        definition, inward = equations.definition, equations.bridge.inward
        self.own, self.inward, self.outward = definition, inward, equations.bridge.outward
        self.names = [plain_name(v) for v in equations.velocities]
        self.size = range(len(self.names))
        self.rates = [inward(e) for e in equations.rates]
        self.lagrangian = inward(equations.theta)
        self.fields = [[r.diff(v) for r in self.rates] for v in definition.velocities]
        still = dict.fromkeys(definition.velocities, 0)
        self.drift = [r.xreplace(still) for r in self.rates]
        self.slopes = [self.lagrangian.diff(v) for v in definition.velocities]
        self.fibre = [inward(p) for p in equations.momenta]
        slopes = [self.lagrangian.diff(q) for q in definition.coordinates]
        self.lifted = [dot(field, slopes) for field in self.fields]
        dots = dict(zip(definition.coordinate_velocities, self.rates, strict=True))
        forces = [f.xreplace(dots) for f in definition.forces]
        self.pushed = [dot(field, forces) for field in self.fields]
        self.turned = [self._bracket_term(i) for i in self.size]

    def _bracket_term(self, i: int) -> Any:
        """(c_ij^k dLc/dv^k + B_ij^A p_A) v^j, with v^0 = 1."""
        brackets, total = self.eqs.brackets, self.inward(0)
        for j in (*self.size, len(self.names)):
            speed = self.own.velocities[j] if j in self.size else self.inward(1)
            for k, p in enumerate(self.slopes):
                total += self.inward(brackets.c[k, i, j]) * p * speed
            for a, p in enumerate(self.fibre):
                total += self.inward(brackets.B[a, i, j]) * p * speed
        return total

    def differences(self) -> Iterator[tuple[str, Any]]:
        """The sum of the terms of (9), less mass * vdot - force."""
        definition, eqs = self.own, self.eqs
        dots = [eqs.bridge.admit(velocity(v)) for v in eqs.velocities]
        for i in self.size:
            p = self.slopes[i]
            left = p.diff(definition.time) - self.lifted[i] + self.turned[i] - self.pushed[i]
            left += dot([p.diff(q) for q in definition.coordinates], self.rates)
            left += dot([p.diff(v) for v in definition.velocities], dots)
            inertia = dot([self.inward(m) for m in eqs.mass.row(i)], dots)
            yield self.names[i], left - (inertia - self.inward(eqs.force[i, 0]))

    def parts(self) -> Iterator[LessonStep]:
        """The steps in their order."""
        yield self._statement_part()
        yield self._velocities()
        yield self._fields()
        yield self._brackets()
        if self.eqs.has_coordinate_frame:
            yield self._curvature()
        yield self._kind()
        yield self._reduction_part()
        yield from self._terms()
        yield self._sum()
        yield self._solution_part()

    def _statement_part(self) -> LessonStep:
        system = self.eqs.system
        rows = [LessonFormula("L", "L", system.lagrangian)]
        rows += [
            LessonFormula(f"Q[{plain_name(q)}]", f"Q_{{{symbol_latex(plain_name(q))}}}", f)
            for q, f in system.forces.items()
        ]
        rows += [LessonFormula("0", "0", c) for c in system.constraints]
        rows += [LessonFormula("0", "0", r) for r in system.fibration.relations]
        base = ", ".join(map(plain_name, system.fibration.base))
        fibre = ", ".join(map(plain_name, system.fibration.fibre))
        over = f", and of the fibre over them, {fibre}" if fibre else ""
        return LessonStep(
            "What is given",
            f"The coordinates of the base, {base}{over}; the Lagrangian, the forces, and the "
            "constraints, which vanish. What is asked: equations of motion without multipliers for "
            f"{', '.join(self.names)}.",
            "(1), (2)",
            rows=tuple(rows),
        )

    def _velocities(self) -> LessonStep:
        system = self.eqs.system
        rows = []
        if system.frame is not None:
            pairs = zip(system.frame.velocities, system.frame.expressions, strict=True)
            rows = [LessonFormula(plain_name(v), symbol_latex(plain_name(v)), e) for v, e in pairs]
        rows += [
            LessonFormula(plain_name(velocity(q)), f"\\dot{{{symbol_latex(plain_name(q))}}}", rate)
            for q, rate in zip(self.eqs.coordinates, self.eqs.rates, strict=True)
            if velocity(q) != rate
        ]
        return LessonStep(
            "The velocities that the constraints admit",
            "The constraints, with the definitions of the velocities in use, are linear equations "
            "for the velocities of the coordinates; they are solved.",
            "(3), (4)",
            ("rdot = E v + e0,  sdot = a v + a0", r"\dot r = E v + e_0,\qquad \dot s = a v + a_0"),
            tuple(rows),
            "The velocities of the coordinates are free.",
        )

    def _fields(self) -> LessonStep:
        rows = []
        for i, name in enumerate((*self.names, "0")):
            field = self.fields[i] if i in self.size else self.drift
            if i in self.size or any(e != 0 for e in field) or self.own.time in self._symbols():
                entries = map(self.outward, shortest(field, self.own.relations))
                terms = [*zip(entries, self.eqs.coordinates, strict=True)]
                if i not in self.size:
                    terms.insert(0, (sp.Integer(1), time))
                value = LessonField(tuple(term for term in terms if term[0] != 0))
                label = _tex(name)
                rows.append(LessonFormula(f"h[{name}]", f"h_{{{label}}}", value))
        return LessonStep(
            "The horizontal fields",
            "The coefficient of each velocity is a field on the configurations along which the "
            "system can move; d_x is differentiation by x.",
            "(5)",
            ("h_i = E_i^b d_b + a_i^A d_A", r"h_i = E_i^b\,\partial_b + a_i^A\,\partial_A"),
            tuple(rows),
        )

    def _symbols(self) -> set[Any]:
        return set().union(*(r.free_symbols for r in self.rates))

    def _brackets(self) -> LessonStep:
        rows = []
        fibre = self.own.split[1]
        behind = [*self.names, "0"]
        for i, j in combinations(range(len(behind)), 2):
            for symbol, above, table in (
                ("c", self.names, self.eqs.brackets.c),
                ("B", fibre, self.eqs.brackets.B),
            ):
                rows += [
                    LessonFormula(
                        f"{symbol}^{name}[{behind[i]}, {behind[j]}]",
                        f"{symbol}_{{{_tex(behind[i])}\\,{_tex(behind[j])}}}^{{{_tex(name)}}}",
                        table[k, i, j],
                    )
                    for k, name in enumerate(above)
                    if table[k, i, j] != 0
                ]
        return LessonStep(
            "The brackets of the fields",
            "Going round a small parallelogram along two of the fields does not lead back: their "
            "bracket has a part along the fields, c, and one along the fibre, the curvature B.",
            "(6)",
            (
                "[h_i, h_j] = c_ij^k h_k + B_ij^A d_A",
                r"[h_i, h_j] = c_{ij}^k h_k + B_{ij}^A\,\partial_A",
            ),
            tuple(rows),
            "All brackets vanish.",
        )

    def _curvature(self) -> LessonStep:
        base, fibre = self.own.split
        rows = []
        for k, name in enumerate(fibre):
            for i, one in enumerate(base):
                rows += [
                    LessonFormula(
                        f"A^{name}[{one}, {base[j]}]",
                        f"A_{{{_tex(one)}\\,{_tex(base[j])}}}^{{{_tex(name)}}}",
                        self.eqs.curvature[k, i, j],
                    )
                    for j in range(i + 1, len(base))
                ]
                label = f"A_{{{_tex(one)}}}^{{{_tex(name)}}}"
                rows.append(LessonFormula(f"A^{name}[{one}]", label, self.eqs.curvature.time[k, i]))
        return LessonStep(
            "The curvature in the coordinates of the base",
            "In the frame of the base velocities, with Voronec's sign:",
            "(7), (8)",
            (
                "A_ij^nu = -B_ij^nu,  A_i^nu = -B_i0^nu",
                r"A_{ij}^{\nu} = -B_{ij}^{\nu},\qquad A_i^{\nu} = -B_{i0}^{\nu}",
            ),
            tuple(row for row in rows if row.value != 0),
            "It vanishes.",
        )

    def _kind(self) -> LessonStep:
        why = {
            "holonomic": "The curvature vanishes, or there is no fibre: the system is holonomic, "
            "and the equations are Lagrange's.",
            "chaplygin": "Nothing depends on the coordinates of the fibre: this is a Chaplygin "
            "system.",
            "voronec": "The curvature does not vanish, and coordinates of the fibre occur: this "
            "is the general case, Voronec's.",
        }
        distribution = self.eqs.distribution
        growth = ", ".join(map(str, distribution.growth)) + ", ..." * distribution.cut
        return LessonStep(
            "The kind of the system",
            f"{why[self.eqs.kind]} The fields span {distribution.growth[0]} directions; with their "
            "brackets, and the brackets of these, "
            f"({growth}) of {distribution.dimension}.",
        )

    def _reduction_part(self) -> LessonStep:
        rows = [LessonFormula("Lc", "L_c", self.eqs.theta)]
        pairs = zip(self.own.split[1], self.eqs.momenta, strict=True)
        rows += [LessonFormula(f"p[{name}]", f"p_{{{_tex(name)}}}", p) for name, p in pairs]
        return LessonStep(
            "The Lagrangian on the constraints",
            "The velocities of the coordinates are replaced in L. Before that, L is differentiated "
            "by the velocities of the fibre: these momenta are what the curvature acts on.",
            "",
            (
                "Lc = L on the constraints,  p_A = dL/dsdot^A there",
                r"L_c = L|_{\dot q = h_j v^j},\qquad "
                r"p_A = \frac{\partial L}{\partial \dot s^A}\Big|_{\dot q = h_j v^j}",
            ),
            tuple(rows),
        )

    def _terms(self) -> Iterator[LessonStep]:
        for title, sentence, formula, labels, values in zip(
            *zip(*TERMS, strict=True),
            (self.slopes, self.lifted, self.turned, self.pushed),
            strict=True,
        ):
            terms = [
                self.outward(e) for e in shortest(values, self.own.relations, self.own.velocities)
            ]
            rows = [
                LessonFormula(labels[0].format(name), labels[1].format(_tex(name)), value)
                for name, value in zip(self.names, terms, strict=True)
            ]
            shown = rows if values is not self.pushed or any(e != 0 for e in terms) else []
            yield LessonStep(
                title, sentence, "", formula, tuple(shown), "There are no other forces."
            )

    def _sum(self) -> LessonStep:
        rows = tuple(
            LessonFormula(
                f"d/dt dLc/d{name}",
                f"\\frac{{d}}{{dt}}\\frac{{\\partial L_c}}{{\\partial {_tex(name)}}}",
                value,
            )
            for name, value in zip(self.names, self.eqs.right, strict=True)
        )
        return LessonStep(
            "The equations",
            "The principle of d'Alembert and Lagrange, along each field, puts the terms together:",
            "(9)",
            (
                "d/dt dLc/dv^i - h_i(Lc) + (c_ij^k dLc/dv^k + B_ij^A p_A) v^j"
                " = E_i^b Q_b + a_i^A Q_A",
                r"\frac{d}{dt}\frac{\partial L_c}{\partial v^i} - h_i(L_c) + \Big(c_{ij}^k"
                r"\frac{\partial L_c}{\partial v^k} + B_{ij}^A p_A\Big)v^j = E_i^b Q_b + a_i^A Q_A",
            ),
            rows,
        )

    def _solution_part(self) -> LessonStep:
        rows = []
        for i in self.size:
            terms = [self.eqs.mass[i, j] * velocity(v) for j, v in enumerate(self.eqs.velocities)]
            rows.append(LessonFormula("", "", (sp.Add(*terms), self.eqs.force[i, 0])))
        return LessonStep(
            "For the accelerations",
            "The derivative by the time is carried out: linear equations for the accelerations.",
            "(11)",
            (
                "mass vdot = force",
                r"\frac{\partial^2 L_c}{\partial v^i\partial v^j}\,\dot v^j = \text{force}_i",
            ),
            tuple(rows),
        )


def _tex(name: str) -> str:
    """LaTeX of a name; what ends so is a velocity."""
    if name.endswith("dot") and name != "dot":
        return f"\\dot{{{symbol_latex(name.removesuffix('dot'))}}}"
    return "0" if name == "0" else symbol_latex(name)


WIDTH = 96
"""Letters in a line of text."""


_INDENT: dict[str, Any] = {"initial_indent": "  ", "subsequent_indent": "  "}


@dataclass(frozen=True)
class LessonField:
    """A vector field: coefficients, each with the coordinate (or time) of its differentiation."""

    terms: tuple[tuple[Any, Any], ...]


@dataclass(frozen=True)
class LessonFormula:
    """A formula: its left side as text and as LaTeX, and the value; or both sides as values."""

    text: str
    latex: str
    value: Any


@dataclass(frozen=True)
class LessonStep:
    """A step: what is asked and done, the formula of the theory, and what comes out.

    ``numbers`` are those of the formulas in ``docs/theory.md``; ``formula`` is the one that is
    used, as text and as LaTeX.  Where nothing comes out, ``empty_note`` says so.
    """

    title: str
    sentence: str
    numbers: str = ""
    formula: tuple[str, str] = ("", "")
    rows: tuple[LessonFormula, ...] = ()
    empty_note: str = ""


@dataclass(frozen=True)
class Lesson:
    """The steps of a derivation, and the verdict on their sum."""

    equations: VoronecEquations
    parts: tuple[LessonStep, ...]
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
            body += rows or ([escape_text(part.empty_note)] if part.empty_note else [])
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
        style = Path(__file__).with_name("lesson.css").read_text("utf-8")
        return "\n".join(
            [
                '<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">',
                '<meta name="viewport" content="width=device-width, initial-scale=1">',
                f"<title>{title}</title><style>\n{style}</style></head><body><h1>{title}</h1>",
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


def _nothing(part: LessonStep) -> list[str]:
    return [f"  {part.empty_note}"] if part.empty_note else []


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


def _text(row: LessonFormula) -> tuple[str, str]:
    if isinstance(row.value, tuple):
        left, right = map(caret_text, row.value)
        return left, right
    if isinstance(row.value, LessonField):
        terms = [(c, caret_text(c), f"d_{plain_name(q)}") for c, q in row.value.terms]
        return row.text, _sum(terms, " ", "({})")
    return row.text, caret_text(row.value)


def _formula(found: Lesson, value: Any) -> str:
    system = found.system
    if isinstance(value, LessonField):
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


def _latex(found: Lesson, row: LessonFormula) -> str:
    if isinstance(row.value, tuple):
        left, right = (_formula(found, value) for value in row.value)
        return f"{left} = {right}"
    return f"{row.latex} = {_formula(found, row.value)}"


def _sections(found: Lesson) -> Iterator[str]:
    for number, part in enumerate(found.parts, 1):
        yield f"<h2>{number}. {escape(part.title)}</h2><p>{escape(part.sentence)}</p>"
        if part.formula[1]:
            told = f"<span>{escape(part.numbers)}</span>" if part.numbers else ""
            yield f"<div class='theory'>{mathml(part.formula[1])}{told}</div>"
        for row in part.rows:
            yield f"<div class='row'>{mathml(_latex(found, row))}</div>"
        if not part.rows and part.empty_note:
            yield f"<p>{escape(part.empty_note)}</p>"
