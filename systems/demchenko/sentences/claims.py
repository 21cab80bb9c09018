"""What the decisions of the sentences share: a word of the print against what is derived."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from itertools import pairwise
from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Quoted, Reference, Study, one_of, tight
from voronec.audit.latex.nodes import Call, Dot, Name, Variation
from voronec.audit.meaning import evaluate
from voronec.audit.transcript import assignments

AXES = {r"\mathbf u": 0, r"\mathbf v": 1, r"\mathbf n": 2}
"""The axes at the contact point, by number."""
CONSTANT = {
    **dict.fromkeys(("constant", "fixed", "a constant", "conserved"), True),
    **dict.fromkeys(("variable", "not constant", "a variable", "arbitrary"), False),
}


def agreement(printed: Any, derived: Any, what: str) -> vo.Verdict:
    """Whether the print says what is derived."""
    if printed == derived:
        return vo.Verdict("proved", f"{what}: {_wording(derived)}")
    return vo.Verdict("refuted", f"{what}: {_wording(derived)} is derived, not {_wording(printed)}")


def _wording(value: Any) -> str:
    if isinstance(value, frozenset):
        return " and ".join(sorted(map(_wording, value)))
    if isinstance(value, set):
        return ", ".join(sorted(map(_wording, value)))
    if isinstance(value, (tuple, list)):
        return ", ".join(map(_wording, value))
    if isinstance(value, bool):
        return {True: "yes", False: "no"}[value]
    text = str(value)
    return f"${text}$" if "\\" in text and "$" not in text else text  # LaTeX is set as such


def denial(claimed: bool, found: vo.Verdict) -> vo.Verdict:
    """The verdict on what is claimed, or on its denial, where that on the claim was found."""
    if claimed or found.undecided:
        return found
    status = "proved" if found.refuted else "refuted"
    return vo.Verdict(status, found.method, found.witness)


def all_of(*steps: Callable[[], vo.Verdict] | vo.Verdict) -> vo.Verdict:
    """Proved where every step is, with all that was said; else the first that is not."""
    said = []
    for step in steps:
        found = step if isinstance(step, vo.Verdict) else step()
        if not found.proved:
            return found
        said.append(found.method)
    return vo.Verdict("proved", "; ".join(dict.fromkeys(said)))


def exists(how: str, found: vo.Verdict, exception: vo.Verdict | None = None) -> vo.Verdict:
    """A claim that there is something, that there is nothing, or that there is nothing else.

    ``found`` shows an instance; ``exception``, if proved, something that is none.
    """
    if how in ("some", "none"):
        return denial(how == "some", found)
    if exception is not None and exception.proved:
        return vo.Verdict("refuted", f"not for all: {exception.method}")
    return vo.Verdict("undecided", f"whether that is so for '{how}' is not decided here")


def constant(word: str) -> bool:
    """Whether a word says that something does not change."""
    return one_of(word, CONSTANT)


def values(formula: Quoted, study: Study) -> list[Any]:
    """The values of the parts of a formula under a dictionary."""
    return [evaluate(part, study) for part in formula.tree(study).parts]


def both_sides(formula: Quoted, study: Study) -> tuple[Any, Any]:
    """The values of the two sides of an equation."""
    tree = formula.tree(study)
    if tree.relations != ("=",):
        raise vo.DefinitionError(f"'{formula.latex}' is no equation of two sides")
    left, right = (sp.sympify(evaluate(part, study)) for part in tree.parts)
    return left, right


def value(name: str | Quoted, study: Study) -> Any:
    """The value of one name or of a formula without a relation."""
    formula = name if isinstance(name, Quoted) else Quoted(f"${name}$")
    tree = formula.tree(study)
    if len(tree.parts) != 1:
        raise vo.DefinitionError(f"'{name}' is a formula with a relation, not a value")
    if isinstance(name, str) and not isinstance(tree.parts[0], (Name, Dot, Variation, Call)):
        raise vo.DefinitionError(f"'{name}' is no name")
    return sp.sympify(evaluate(tree.parts[0], study))


def sides(formula: Quoted, names: Mapping[str, Any]) -> tuple[list[str], tuple[str, ...]]:
    """The names of a chain such as a>b>c, and the relations between them."""
    text = tight(formula.latex.strip("$ .,"))
    found, relations = [""], []
    for letter in text:
        if letter in "<>=":
            relations.append(letter)
            found.append("")
        else:
            found[-1] += letter
    for name in found:
        one_of(name, names)
    return found, tuple(relations)


def left_sides(reference: Reference, study: Study) -> list[Any]:
    """The left sides of the formulas to which a sentence refers."""
    return [evaluate(tree.parts[0], study) for tree in reference.trees(study)]


def residuals(formula: Reference | Quoted, study: Study) -> list[Any]:
    """Left minus right of every equation, all constraints forgotten; vectors by components."""
    found: list[Any] = []
    for tree in formula.trees(study):
        if set(tree.relations) - {"="}:
            raise vo.DefinitionError("an inequality stands where an equation is needed")
        for where in assignments(tree, study):
            parts = [evaluate(part, study, where) for part in tree.parts]
            for left, right in pairwise(parts):
                found += _components(left, right)
    return [sp.sympify(value).xreplace(dict(study.given)) for value in found]


def _components(left: Any, right: Any) -> list[Any]:
    vectors = [side for side in (left, right) if isinstance(side, sp.MatrixBase)]
    if not vectors:
        return [left - right]
    zero = vectors[0] * 0
    gap = (zero if left == 0 else left) - (zero if right == 0 else right)
    return list(gap)


def equals(pairs: Iterable[tuple[Any, Any]], what: str) -> vo.Verdict:
    """Whether the two of each pair are equal, in exact algebra."""
    count = 0
    for left, right in pairs:
        count += 1
        found = vo.prove_equal(left, right)
        if not found.proved:
            return vo.Verdict(found.status, f"{what}: {found.method}", found.witness)
    if not count:
        return vo.Verdict("undecided", f"{what}: nothing is compared")
    return vo.Verdict("proved", f"{what}: {count} equal in exact normal form")


def holds(formula: Reference | Quoted, study: Study, what: str) -> vo.Verdict:
    """Whether equations are true on the constraints of a study."""
    motion, given = study.motion, dict(study.given)
    gaps = (motion.along(gap).xreplace(given) for gap in residuals(formula, study))
    return equals(((gap, 0) for gap in gaps), what)


def constraint_verdict(formula: Reference | Quoted, study: Study, what: str) -> vo.Verdict:
    """Whether equations are constraints: true where the constraints hold, and not elsewhere."""
    found = holds(formula, study, what)
    if not found.proved:
        return found
    free = [vo.prove_equal(gap, 0) for gap in residuals(formula, study)]
    if any(verdict.proved for verdict in free):
        return vo.Verdict("refuted", f"{what}: an identity, which constrains nothing")
    return found


def relative_curvature(study: Study) -> str:
    """The determinant on which it depends, in the paper's names."""
    found: str = study.context.surfaces.spelled_curvature(study.spelling)
    return found
