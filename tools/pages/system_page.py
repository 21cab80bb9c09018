"""A page on one system, in Markdown: its equations, a motion, what is claimed of it, how it is
related, and how it is defined."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sympy as sp

from voronec.algebra.symbols import plain_name, velocity
from voronec.algebra.text import as_expression
from voronec.algebra.typeset import latex_of, symbol_latex
from voronec.declaration.bibliography import citation
from voronec.declaration.claims import (
    Assertion,
    Corrected,
    Equation,
    Measure,
    Poisson,
    declared_claims,
    right_of,
)
from voronec.declaration.system import System
from voronec.equations.readable import readable
from voronec.equations.voronec_equations import derive
from voronec.proof.check import Finding, Result

LONG = 2500
"""Formulas whose source has more characters are left to ``voronec show``."""
WIDE = 400
"""Those with more characters than that are folded: a click shows them."""


@dataclass(frozen=True)
class _Formulas:
    """LaTeX in the symbols of a system."""

    system: System

    def __call__(self, expr: Any) -> str:
        return latex_of(expr, self.system.coordinates, self.system.velocities)

    def names(self, things: Iterable[Any]) -> str:
        return ", ".join(f"${self(t)}$" for t in things) or "none"

    def vector(self, entries: Sequence[Any]) -> str:
        if len(entries) == 1:
            return self(entries[0])
        rows = r" \\ ".join(self(e) for e in entries)
        return rf"\begin{{pmatrix}} {rows} \end{{pmatrix}}"


def system_page(
    system: System, found: Result, relations: Sequence[Result], bibliography: Mapping[str, str]
) -> str:
    """The page of a system.

    found
        the result of its check; ``relations`` those of the relations it stands in.
    bibliography
        its references, as BibTeX entries by key.
    """
    parts = [
        f"# {system.title or system.name}",
        f"`{system.name}`. {system.description}",
        *_equations(system),
        *_motions(system),
        *_claims(system, found),
        *_relations(system, relations),
        *_definition(system),
        "## References",
        *(f"- {citation(entry)}" for entry in bibliography.values()),
        f"Made from the system by `python tools/build.py pages`; `voronec check {system.name}` "
        "decides it anew.",
    ]
    return _join_paragraphs(parts)


def index_page(systems: Sequence[System], results: Mapping[str, Result]) -> str:
    """The list of all systems."""
    rows = [
        [
            f"[{s.name}]({s.name}.md)",
            s.title or s.description,
            str(len(results[s.name].findings)),
            results[s.name].status,
        ]
        for s in systems
    ]
    undecided = [
        f"- `{name}`, {f.kind} *{f.name}*: {f.admitted}"
        for name, result in results.items()
        for f in result.findings
        if f.admitted
    ]
    return _join_paragraphs(
        [
            "# The systems",
            "Each is a file of declarations; what it claims is decided by `voronec check`. The "
            "picture, by `voronec graph`, shows how they are related.",
            "![The diagram of systems and relations](graph.svg)",
            _table(["system", "", "claims", "verdict"], rows),
            "## Undecided",
            *(undecided or ["Nothing."]),
        ]
    )


def _join_paragraphs(parts: Iterable[str]) -> str:
    """Paragraphs, with the items of a list below one another."""
    text = ""
    last = ""
    for part in parts:
        text += "" if not text else "\n" if part[:2] == last[:2] == "- " else "\n\n"
        text, last = text + part, part
    return text + "\n"


def _definition(system: System) -> Iterator[str]:
    show = _Formulas(system)
    yield "## Definition"
    fibration = system.fibration
    yield f"- base: {show.names(fibration.base)}"
    yield f"- fibre: {show.names(fibration.fibre)}"
    yield f"- velocities: {show.names(system.velocities)}"
    for relation in fibration.relations:
        yield f"- relation: ${show(relation)} = 0$"
    if system.meanings:
        yield _table(["", "meaning"], [*_meanings(system, show)])
    yield "Lagrangian"
    yield _display(show(system.lagrangian), system)
    if system.constraints:
        yield "Constraints"
        for constraint in system.constraints:
            yield _display(show(constraint) + " = 0", system)
    yield from _frame(system, show)
    for q, force in system.forces.items():
        yield f"Force on ${show(q)}$"
        yield _display(show(force), system)
    for name, function in system.invariants.items():
        yield _display(f"{symbol_latex(name)} = {show(function)}", system)
    rows = [
        [
            f"${show(p.symbol)}$",
            "" if p.value is None else f"${sp.latex(as_expression(p.value))}$",
            p.meaning,
        ]
        for p in system.parameters
    ]
    if rows:
        yield _table(["parameter", "default", "meaning"], rows)


def _meanings(system: System, show: _Formulas) -> Iterator[list[str]]:
    """What things are in words: symbols in formulas, the names of integrals as they are."""
    ambient = system.frame.ambient if system.frame is not None else ()
    symbols = {plain_name(q): show(q) for q in (*system.coordinates, *ambient)}
    symbols |= {name: symbol_latex(name) for name in system.invariants}
    for name, words in system.meanings.items():
        yield [f"${symbols[name]}$" if name in symbols else name, words]


def _frame(system: System, show: _Formulas) -> Iterator[str]:
    frame = system.frame
    if frame is None:
        return
    if frame.is_group:
        yield "Velocities of a frame on the group, with rates of the coordinates"
        for q, rate in frame.rates.items():
            yield _display(f"{show(velocity(q))} = {show(rate)}", system)
        if frame.momenta:
            yield f"In claims {show.names(frame.momenta)} are the momenta $dL_c/dv$."
        if frame.determinant is not None:
            yield f"In claims ${show(frame.determinant)}$ is the determinant of the mass matrix."
        return
    yield "Quasi-velocities"
    for v, e in zip(frame.velocities, frame.expressions, strict=True):
        yield _display(f"{show(v)} = {show(e)}", system)


def _equations(system: System) -> Iterator[str]:
    """The equations in the form for people."""
    yield "## Equations of motion"
    eqs = derive(system)
    latex = readable(eqs).latex("aligned") if eqs.in_normal_form else ""
    if latex and len(latex) <= LONG:
        yield _display(latex, system)
    else:
        yield f"(long: `voronec derive {system.name}`)"


def _display(latex: str, system: System) -> str:
    if len(latex) > LONG:
        return f"(long: `voronec show {system.name}`)"
    shown = f"$$\n{latex}\n$$"
    if len(latex) > WIDE:
        return f"<details><summary>formula</summary>\n\n{shown}\n\n</details>"
    return shown


# -- claims -------------------------------------------------------------------------------


def _claims(system: System, found: Result) -> Iterator[str]:
    yield "## Claims"
    if not found.findings:
        yield "None."
        return
    for finding in found.findings:
        yield f"**{finding.kind}: {finding.name}** - {_standing_words(finding)}"
        yield from _statement(system, finding)
    for name, case in system.cases.items():
        values = ", ".join(f"{k} = {v}" for k, v in case.parameters.items())
        note = case.note[:1].upper() + case.note[1:]
        yield f"*{name}*: " + " ".join(filter(None, (values and f"{values}.", note)))


def _standing_words(finding: Finding) -> str:
    words = finding.status
    if finding.remark:
        words += f" ({finding.remark})"
    return f"{words}: {finding.admitted}" if finding.admitted else words


def _statement(system: System, finding: Finding) -> Iterator[str]:
    """The formula of a claim, where it has one."""
    case, _, name = finding.name.rpartition(": ")
    holder: Any = system.cases.get(case, system)
    name = finding.name if holder is system else name
    show = _Formulas(system)
    known = {(c.kind, c.name): c.value for c in declared_claims(holder)}
    claim = known.get((finding.kind, name))
    if claim is None or isinstance(claim, Poisson | tuple | str):
        return
    yield _display(_formula(show, right_of(claim)), system)
    if isinstance(claim, Corrected):
        yield f"as printed in {claim.source}"
        yield _display(_formula(show, claim.printed), system)


def _formula(show: _Formulas, claim: Any) -> str:
    if isinstance(claim, Equation):
        return rf"\frac{{d}}{{dt}} {show.vector(claim.function)} = {show.vector(claim.rate)}"
    if isinstance(claim, Measure):
        volume = r"\,".join(f"d{show(v)}" for v in claim.variables)
        return show(claim.density) + (r"\;" + volume if volume else "")
    if isinstance(claim, Assertion):
        return r",\; ".join(map(show, claim.expressions))
    return show(claim)


# -- relations and motions ----------------------------------------------------------------


def _relations(system: System, relations: Sequence[Result]) -> Iterator[str]:
    if not relations:
        return
    yield "## Relations"
    rows = []
    for r in relations:
        source, target = (r.systems * 2)[:2]
        carried = len(r.findings) - 1
        kinds = ", ".join(r.notes)
        rows.append([_link(source, system), _link(target, system), kinds, str(carried), r.status])
    yield _table(["from", "to", "kind", "claims carried", "verdict"], rows)


def _link(name: str, here: System) -> str:
    return f"`{name}`" if name == here.name else f"[{name}]({name.partition('@')[0]}.md)"


def _motions(system: System) -> Iterator[str]:
    if not system.scenes:
        return
    yield "## Motions"
    command = "view" if system.shapes else "run"
    for name, scene in system.scenes.items():
        flag = "" if name == "default" else f" --scene {name}"
        yield f"- `voronec {command} {system.name}{flag}`: {scene.caption}"


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(
        "| " + " | ".join(c.replace("|", r"\|") for c in line) + " |" for line in lines
    )
