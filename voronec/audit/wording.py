"""What a record says beside its verdict: how it was found, where it holds, and a witness.

What the engine derived is said as LaTeX in the names of the paper.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef

from voronec.algebra.factors import in_factors
from voronec.algebra.normal import shorten
from voronec.algebra.text import as_expression
from voronec.algebra.verdicts import Witness
from voronec.audit.comparisons import accelerations
from voronec.audit.display import Check
from voronec.audit.formula import Formula
from voronec.audit.hooks import HookError, call_hook
from voronec.audit.latex.nodes import Call, Chain, Dot, Name, Node, walk
from voronec.audit.meaning import SENSELESS, evaluate
from voronec.audit.record import FormulaRecord
from voronec.audit.structure import (
    free_indices,
    mentions,
    names_constant,
    states_dependence,
    whole_name,
)
from voronec.audit.study import Range, Study, key_of
from voronec.audit.transcript import assignments, instance, text_of
from voronec.audit.verify import FormulaOutcome
from voronec.errors import EngineLimit

_MARKUP = (
    (r"\\eqref\{([^}]*)\}", r"(\1)"),
    (r"\\ref\{([^}]*)\}", r"\1"),
    (r"\\cite\{([^}]*)\}", r"[\1]"),
    (r"\\(?:emph|text|caption)\{([^{}]*)\}", r"\1"),
    (r"\\label\{[^}]*\}|\\begin\{aligned\}|\\end\{aligned\}", ""),
    (r"\\footnote\{", " (footnote: "),
    (r"\s*\$\$\s*", " $ "),
    (r"\\begin\{(?:equation|eqnarray)\*?\}|\\end\{(?:equation|eqnarray)\*?\}", "$"),
    (r"\\(?:begin|end)\{itemize\}|\\(?:item|medskip)\b", ""),
)
"""Commands of running text, and what stands for them where words are read."""


def readable(quotation: str) -> str:
    """A quotation in words, its formulas between dollar signs."""
    for pattern, plain in _MARKUP:
        quotation = re.sub(pattern, plain, quotation)
    return " ".join(quotation.split())


def method_of(
    finding: FormulaOutcome, chain: Chain | None = None, check: Check | None = None
) -> str:
    """How the verdict was found, in words."""
    # Where there are ranges, each has its own reasons with it.
    parts = [_where(finding) if finding.ranges else finding.verdict.method]
    if finding.count > 1:
        parts.append(f"{finding.count} comparisons")
    if chain is None or check is None or check.decide is not None:
        return "; ".join(parts)
    if check.stationary:
        parts.append("variations integrated by parts, compared with the d'Alembert equations")
    elif check.truth is not None:
        parts.append("compared with the derived equation of motion")
    elif names_constant(chain.parts[-1]):
        parts.append("its derivative along the motion vanishes")
    elif states_dependence(chain):
        parts.append("it says of what a quantity is a function, and no more")
    if check.given:
        parts.append("given " + ", ".join(f"({label})" for label in check.given))
    return "; ".join(parts)


def _where(finding: FormulaOutcome) -> str:
    """In which ranges a claim holds, and in which not."""
    good = [r.name for r, v in finding.ranges if v.proved]
    bad = [r.name for r, v in finding.ranges if v.refuted]
    open_ = [r.name for r, v in finding.ranges if v.undecided]
    parts = [f"true for {_list_names(good)}"] if good else []
    parts += [f"false for {_list_names(bad)}"] if bad else []
    parts += [f"undecided for {_list_names(open_)}"] if open_ else []
    if not good:
        return finding.verdict.method
    if finding.scope and set(finding.scope) <= set(good) and len(parts) > 1:
        return f"{parts[0]}, of which the section speaks; it does not extend to " + _list_names(
            bad + open_
        )
    sources = dict.fromkeys(r.source for r, v in finding.ranges if r.source and not v.proved)
    if sources:
        parts[-1] += f", which ({', '.join(sources)}) admits: the print must say for which it is"
    return ", ".join(parts)


def _list_names(names: list[str]) -> str:
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def ranges_of(finding: FormulaOutcome) -> tuple[dict[str, Any], ...]:
    """The outcome for each range of the parameters, as a record holds it."""
    return tuple(_range(where, verdict) for where, verdict in finding.ranges)


def _range(where: Range, verdict: Any) -> dict[str, Any]:
    spoken = set(re.findall(r"[A-Za-z]+", verdict.method))
    if verdict.witness is not None:
        spoken |= {*verdict.witness.point}
    shown = [meaning for letter, meaning in where.letters.items() if letter in spoken]
    return {
        "range": where.name,
        "statement": ",\\ ".join([where.statement, *shown]),
        "verdict": verdict.status,
        "method": verdict.method,
        "witness": None if verdict.witness is None else _place_witness(verdict.witness, where),
    }


def _place_witness(witness: Witness, where: Range) -> dict[str, Any]:
    """A witness with the values of the paper's own parameters at its point."""
    record = _values(witness)
    known = {sp.Symbol(name): sp.Rational(v) for name, v in record["point"].items() if _exact(v)}
    for parameter, value in where.values.items():
        plain = value.xreplace({x: sp.Symbol(x.name) for x in value.free_symbols}).xreplace(known)
        if plain.is_Rational and str(parameter) not in record["point"]:
            record["point"] = {str(parameter): str(plain), **record["point"]}
    return record


def _exact(value: str) -> bool:
    return re.fullmatch(r"-?\d+(/\d+)?", value) is not None


def _values(witness: Witness) -> dict[str, Any]:
    point = {_plain(name): value for name, value in witness.point.items()}
    return {"point": point, "printed": witness.left, "derived": witness.right}


def witness_of(finding: FormulaOutcome) -> dict[str, Any] | None:
    """The point at which a formula is false, and its two sides there."""
    comparison, witness = finding.comparison, finding.verdict.witness
    if witness is None:
        return None
    record = _values(witness)
    if comparison is not None and comparison.where:
        record["indices"] = {letter.lstrip("\\"): i for letter, i in comparison.where.items()}
    if comparison is not None and comparison.about:
        record["about"] = comparison.about
    return record


def _plain(name: str) -> str:
    """An atom's name without the arguments of unknown functions and the marks of LaTeX."""
    name = re.sub(r"(?<=\w)\((?:[\w ]+,\s*)+\w+\)", "", name)
    return re.sub(r"[\\{}]", "", name)


def loose_index(formula: Formula, chain: Chain, study: Study) -> str:
    """Say it where an index is bound by nothing."""
    bound = {w.text for words in formula.piece.quantifiers for w in words}
    bound |= set(free_indices(chain.parts[0], study))
    loose = [letter for letter in free_indices(chain, study) if letter not in bound]
    return f", where nothing binds the index {loose[0]}" if loose else ""


def with_note(record: FormulaRecord, study: Study) -> str:
    """The method, how general the study is, and the letters of the derived side that are not the
    paper's."""
    shown = record.derived or ""
    strange = [
        meaning
        for letter, meaning in study.letters.items()
        if re.search(rf"(?<![a-zA-Z\\]){re.escape(letter)}(?![a-zA-Z])", shown)
    ]
    return "; ".join(filter(None, (record.method, study.note, *dict.fromkeys(strange))))


LONGEST = 1500
"""Longer results are left out of the report: nobody reads them."""

FOLDABLE = 20
"""Derived constants with fewer operations are brought in by name."""

EXPANDABLE = 80
"""Results with fewer operations are put into other forms, and the shortest print is taken."""


def derived_latex(
    chain: Chain, source: str, check: Check, study: Study, constant: bool
) -> str | None:
    """The derived counterpart of a formula; ``None`` where there is nothing to derive.

    ``source`` is the display that the places of the tree refer to; ``constant`` says whether a
    claimed constant was proved to be one.
    """
    try:
        if check.derived is not None:
            return _given_pairs(chain, check, study)
        if check.truth is not None:
            return _equation(chain, check, study)
        return _value(chain, source, study, constant)
    except HookError:
        raise
    except SENSELESS:
        return None  # a verdict does not depend on what can be shown beside it


def _given_pairs(chain: Chain, check: Check, study: Study) -> str:
    assert check.derived is not None
    pairs = []
    for where in assignments(chain, study)[:1]:
        pairs += call_hook(check.derived, study, where)
    return ", \\quad ".join(
        f"{_side(a, chain, study)} = {_side(b, chain, study)}" for a, b in pairs
    )


def _side(side: Any, chain: Chain, study: Study) -> str:
    if isinstance(side, str):
        return side
    value = study.motion.restrict(side).xreplace(dict(study.given))
    return _print_latex(value, chain, study)


def _equation(chain: Chain, check: Check, study: Study) -> str | None:
    """An equation of motion: terms with accelerations on the left, the rest on the right."""
    assert check.truth is not None
    where = next(iter(assignments(chain, study)))
    residual = call_hook(check.truth, study, where).xreplace(dict(study.given))
    dots = [d for d in accelerations(study) if residual.has(d)]
    inertia = sum((sp.diff(residual, d) * d for d in dots), sp.Integer(0))
    at_rest = {d: sp.Integer(0) for d in dots}
    rest = -residual.xreplace(at_rest)
    return f"{_print_latex(inertia, chain, study)} = {_print_latex(rest, chain, study)}"


def _value(chain: Chain, source: str, study: Study, constant: bool) -> str | None:
    """The first part that the dictionary knows, and its derived value."""
    if names_constant(chain.parts[-1]) and constant:
        return f"{text_of(chain.parts[0], source)} = \\mathrm{{const}}"
    known = [p for p in chain.parts if whole_name(p, study) is None and not names_constant(p)]
    if len(known) < 2 and len(known) < len(chain.parts):
        return None
    where, value = _first_value(known[0], chain, study)
    if any(isinstance(part, Dot) for part in walk(chain)):
        value = value.xreplace(dict(study.in_velocities))
    left = instance(_without_arguments(known[0], study), source, where)
    right = _entry_or_column(value, chain, study)
    return None if _bare(left) == _bare(right) else f"{left} = {right}"


def _bare(latex: str) -> str:
    """Without spacing and braces, to see whether two prints are the same."""
    return re.sub(r"[\s{}]", "", latex)


def _without_arguments(part: Node, study: Study) -> Node:
    """``K_i`` for ``K_i(t, q)``, where the list only says what K_i depends on."""
    if not isinstance(part, Call) or callable(study.table.get(study.key(part.function))):
        return part
    return part.function


def _entry_or_column(value: Any, chain: Chain, study: Study) -> str:
    if not isinstance(value, sp.MatrixBase):
        return _print_latex(value, chain, study)
    if value.cols > 1:
        raise EngineLimit("a matrix is not worth printing")
    rows = ""
    for entry in value:
        rows += (" \\\\ " if rows else "") + _print_latex(entry, chain, study)
        if len(rows) > LONGEST // 5:
            raise EngineLimit("a long vector is not worth printing")
    return f"\\begin{{pmatrix}} {rows} \\end{{pmatrix}}"


def _first_value(part: Node, chain: Chain, study: Study) -> tuple[dict[str, int], Any]:
    """Values of the free indices for which a part does not vanish, and its value there."""
    values = [
        (where, study.motion.restrict(evaluate(part, study, where)).xreplace(dict(study.given)))
        for where in assignments(chain, study)
    ]
    return next((pair for pair in values if pair[1] != 0), values[0])


def _print_latex(value: Any, chain: Chain, study: Study) -> str:
    """A value in its shortest proved form, with the abbreviations that the formula uses."""
    value, symbols = _fold(as_expression(value), chain, study)
    short, names = _plain_symbols(shorten([value])[0], study)
    forms = _forms(short)
    if sp.count_ops(value) <= sp.count_ops(short):  # a root may bring in what does not cancel
        value, more = _plain_symbols(value, study)
        forms, names = (*forms, value), {**names, **more}
    names = {**study.spelling, **symbols, **names}
    text = min((_latex(form, names) for form in forms), key=len)
    if len(text) > LONGEST:
        raise EngineLimit(f"the derived expression has {len(text)} characters in print")
    return text


def _latex(value: sp.Expr, names: dict[Any, str]) -> str:
    """An expression in the names of the paper, exponents in their shortest form."""
    names = {**{x: x.name for x in value.free_symbols if "{" in x.name}, **names}
    powers = {p: p.base ** shorten([p.exp])[0] for p in value.atoms(sp.Pow) if p.exp.free_symbols}
    return str(sp.latex(value.xreplace(powers), symbol_names=names, fold_func_brackets=True))


def _forms(value: sp.Expr) -> tuple[sp.Expr, ...]:
    """Equal forms of a value: as it is, multiplied out, and in factors with nothing to cancel."""
    if sp.count_ops(value) >= EXPANDABLE:
        return (value,)
    return value, sp.expand(value), in_factors(value)


def _fold(value: sp.Expr, chain: Chain, study: Study) -> tuple[sp.Expr, dict[Any, str]]:
    """Bring in the names of constants that this formula uses, as P = I + A."""
    # Not the name on the left: it would be said of itself.
    used, symbols = mentions(chain) - {_own_name(chain)}, {}
    shown = {s for s, latex in study.spelling.items() if latex in used}
    rules: dict[Any, sp.Expr] = {}
    for key, meaning in _meanings(used, study):
        symbol = sp.Symbol(f"fold {key}")
        for old, new in rules.items():
            meaning = meaning.xreplace({old: new})
        meaning = shorten([meaning])[0]
        raw = _eliminable(meaning, shown, study)
        if raw is None or raw in rules:
            continue
        solution = _solutions(meaning - symbol, raw)
        if len(solution) != 1:
            continue
        rules = {o: n.xreplace({raw: solution[0]}) for o, n in rules.items()}
        rules[raw] = solution[0]
        symbols[symbol] = key
    return value.xreplace(rules), symbols


@cache  # a constant is brought in wherever a formula uses it
def _solutions(equation: sp.Expr, unknown: sp.Expr) -> list[sp.Expr]:
    return list(sp.solve(equation, unknown))


def _own_name(chain: Chain) -> str:
    left = chain.parts[0]
    return key_of(left) if isinstance(left, Name) else ""


def _meanings(used: set[str], study: Study) -> Iterator[tuple[str, sp.Expr]]:
    """Names in a formula that stand for expressions: the paper's own, and derived constants; names
    of vectors stand for none."""
    moving = set(study.motion.rates) | set(study.motion.constrained)
    for key, node in study.defined.items():
        if key in used and key not in study.table:
            value = evaluate(node, study)
            if not isinstance(value, sp.MatrixBase):
                yield key, value
    for key, value in study.table.items():
        if key not in used or not isinstance(value, sp.Expr) or value.is_Atom:
            continue
        if isinstance(value, sp.MatrixBase):
            continue
        if not value.free_symbols & moving and sp.count_ops(value) < FOLDABLE:
            yield key, value


def _eliminable(meaning: sp.Expr, shown: set[Any], study: Study) -> Any | None:
    """A constant, linear in the meaning, that the formula itself does not show."""
    moving = set(study.motion.rates) | set(study.motion.constrained)
    constants = sorted(meaning.free_symbols - moving - shown, key=str)
    linear = [x for x in constants if sp.diff(meaning, x, 2) == 0]
    return (linear or constants or [None])[0]


def _plain_symbols(value: sp.Expr, study: Study) -> tuple[sp.Expr, dict[Any, str]]:
    """Applied unknown functions and their derivatives as symbols with short names."""
    names: dict[Any, str] = {}
    rules: dict[Any, Any] = {}
    for node in value.atoms(sp.Derivative) | value.atoms(AppliedUndef):
        symbol = sp.Symbol(f"plain {node}")
        rules[node] = symbol
        names[symbol] = _jet_name(node, study)
    return value.xreplace(rules), names


def _jet_name(node: Any, study: Study) -> str:
    if not isinstance(node, sp.Derivative):
        return study.spelling.get(node, str(sp.latex(node.func)))
    top = _jet_name(node.expr, study)
    order = "" if node.derivative_count == 1 else f"^{{{node.derivative_count}}}"
    below = "\\,".join(
        f"\\partial {study.spelling.get(x, sp.latex(x))}" + (f"^{{{c}}}" if c > 1 else "")
        for x, c in node.variable_count
    )
    return f"\\frac{{\\partial{order} {top}}}{{{below}}}"
