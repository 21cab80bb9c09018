"""One problem by all methods as a record: its text, and data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import symengine as se

from voronec.algebra.typeset import html_table
from voronec.algebra.verdicts import Verdict
from voronec.audit.lessons.statement import Statement
from voronec.equations.voronec_equations import equation_rows

__all__ = ["Comparison", "Equality", "Method", "Rows", "Step"]


Rows = tuple[tuple[str, Any], ...]


@dataclass(frozen=True)
class Step:
    """What is done, in a sentence, and what comes out: names, or texts, with formulas."""

    sentence: str
    rows: Rows = ()


@dataclass(frozen=True)
class Method:
    """The steps of one method; ``residuals`` vanish along the motion: they are written with q, v
    and vdot, and one belongs to each velocity.  Where a method gives accelerations, ``solved`` are
    those of v instead."""

    name: str
    steps: tuple[Step, ...]
    residuals: tuple[Any, ...] = ()
    solved: tuple[Any, ...] = ()


@dataclass(frozen=True)
class Equality:
    """Two methods, and the verdict on whether their equations are the same."""

    left: str
    right: str
    verdict: Verdict
    seconds: float


@dataclass(frozen=True)
class Comparison:
    """One problem by all methods, and the proofs that they agree."""

    problem: Statement
    methods: tuple[Method, ...]
    equalities: tuple[Equality, ...]
    seconds: float

    def __repr__(self) -> str:
        names = ", ".join(method.name for method in self.methods)
        return f"Comparison({self.problem.equations.system.name!r}, {names}: {self._outcome})"

    def _repr_html_(self) -> str:
        """For notebooks: the verdict on each equality."""
        rows = [(f"{e.left} and {e.right}", e.verdict.status) for e in self.equalities]
        name = self.problem.equations.system.name
        return html_table(f"{name} by {len(self.methods)} methods", rows)

    @property
    def _outcome(self) -> str:
        return "proved to agree" if self.proved else "not proved to agree"

    @property
    def proved(self) -> bool:
        """Whether every equality is proved."""
        return all(e.verdict.proved for e in self.equalities)

    def lines(self) -> list[str]:
        """What is asked, each method with its steps and equations, and the proofs."""
        problem = self.problem
        system = problem.equations.system
        lines = [f"{system.name}: {system.title}" if system.title else system.name, ""]
        lines += ["asked", f"  The equations of motion for {', '.join(map(str, problem.v))}."]
        lines += equation_rows(_statement_lines(problem))
        for number, method in enumerate(self.methods, 1):
            lines += ["", f"{number}. {method.name}"]
            for step in method.steps:
                lines.append(f"  {step.sentence}")
                lines += [f"  {row}" for row in equation_rows(_texts(problem, step.rows))]
            lines += [f"  {row}" for row in equation_rows(_equations(problem, method))]
        lines += ["", "comes out"]
        for e in self.equalities:
            why = f"{e.verdict.status}, {e.verdict.method}"
            lines.append(f"  {e.left} = {e.right}: {why}")
        if self.proved:
            lines.append("  All methods give the same equations: proved.")
        return lines

    def as_dict(self) -> dict[str, Any]:
        """The same as data that JSON can hold."""
        problem = self.problem
        return {
            "system": problem.equations.system.name,
            "velocities": [str(v) for v in problem.v],
            "given": dict(_statement_lines(problem)),
            "methods": [
                {
                    "name": method.name,
                    "steps": [
                        {"sentence": s.sentence, "formulas": _texts(problem, s.rows)}
                        for s in method.steps
                    ],
                    "equations": _equations(problem, method),
                }
                for method in self.methods
            ],
            "equalities": [
                {
                    "left": e.left,
                    "right": e.right,
                    "verdict": e.verdict.status,
                    "why": e.verdict.method,
                    "seconds": round(e.seconds, 3),
                }
                for e in self.equalities
            ],
            "proved": self.proved,
            "seconds": round(self.seconds, 3),
        }

    def __str__(self) -> str:
        return "\n".join(self.lines())


def _statement_lines(problem: Statement) -> list[tuple[str, str]]:
    """Lagrangian, forces, constraints, velocities."""
    rows = [("L", problem.text(problem.lagrangian))]
    rows += [
        (f"Q[{q}]", problem.text(f))
        for q, f in zip(problem.q, problem.forces, strict=True)
        if f != 0
    ]
    for row, offset in zip(problem.constraint_rows, problem.constraint_offsets, strict=True):
        form = se.Add(offset, *[e * d for e, d in zip(row, problem.qd, strict=True)])
        rows.append(("0", problem.text(form)))
    pairs = zip(problem.v, problem.frame_rows, problem.frame_offsets, strict=True)
    for v, row, offset in pairs:
        form = se.Add(offset, *[e * d for e, d in zip(row, problem.qd, strict=True)])
        if form != v:
            rows.append((str(v), problem.text(form)))
    return rows


def _texts(problem: Statement, rows: Any) -> list[tuple[str, str]]:
    """Names, or left sides, with formulas."""
    found = []
    for name, value in rows:
        if isinstance(value, tuple):
            left, right = problem.texts(value)
            found.append((f"{name}:  {left}", right))
        else:
            found.append((name, *problem.texts([value])))
    return found


def _equations(problem: Statement, method: Method) -> list[tuple[str, str]]:
    """What a method ends with: the terms with accelerations on the left, the rest on the right."""
    found = []
    still = dict.fromkeys(problem.vd, se.Integer(0))
    for residual in method.residuals:
        slopes = problem.tidy([residual.diff(a) for a in problem.vd])
        texts = problem.texts([*slopes, -residual.xreplace(still)])
        terms = []
        for slope, text, v in zip(slopes, texts, problem.v, strict=False):
            if slope != 0:
                factor = "" if text == "1" else f"({text})*" if " " in text else f"{text}*"
                terms.append(f"{factor}d{v}/dt")
        found.append((" + ".join(terms) or "0", texts[-1]))
    return found
