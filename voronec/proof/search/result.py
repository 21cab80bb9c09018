"""What a search found, and what it proves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import sympy as sp

from voronec.algebra.typeset import html_table, latex_of, plain_text
from voronec.algebra.verdicts import Verdict
from voronec.proof.search.outcome import plain_data


@dataclass(frozen=True)
class FoundIntegral:
    """A first integral: ``expression`` in the user's symbols, ``short`` in the letters of the
    ansatz, the verdict on its rate of change.

    ``independent`` says whether its gradient is independent of those known before it.
    """

    name: str
    expression: sp.Expr
    short: sp.Expr
    verdict: Verdict
    independent: bool

    @property
    def standing(self) -> str:
        """The verdict in words, with its period and its domain, or why there is no proof."""
        verdict = self.verdict
        words = " ".join(filter(None, (verdict.status, verdict.limits)))
        return words if verdict.proved else f"{words}: {verdict.method}"


@dataclass(frozen=True, repr=False)
class IntegralSearch:
    """The outcome of a search.

    Among ``functions`` linearly independent ones (of ``monomials`` in ``classes`` classes), the
    integrals make a space of at most ``dimension``, of which sums of products of ``known`` and of
    those found before make ``explained``.  ``ignored`` are declared, but no integrals on this
    field.  ``missing`` counts those that were found modulo a prime only.  ``finished`` is
    false where the search was stopped.  ``assumed`` are functions that were taken as independent of
    everything else, which is not proved; ``unknown`` are functions that may be any.
    """

    system: str
    level: str
    form: str
    letters: dict[str, sp.Expr]
    at: dict[sp.Symbol, sp.Expr]
    parameters: tuple[sp.Expr, ...]
    monomials: int
    classes: int
    known: tuple[str, ...] = ()
    ignored: tuple[str, ...] = ()
    examined: int = 0
    functions: int = 0
    dimension: int = 0
    explained: int = 0
    integrals: tuple[FoundIntegral, ...] = ()
    missing: int = 0
    finished: bool = False
    seconds: float = 0.0
    assumed: tuple[sp.Expr, ...] = ()
    unknown: tuple[sp.Expr, ...] = ()

    def __repr__(self) -> str:
        names = ", ".join(f.name for f in self.integrals) or "none"
        return f"IntegralSearch({self.system!r}, {self.form}, found: {names})"

    def _repr_html_(self) -> str:
        """For notebooks: what was found, and what is proved."""
        lines = [(f.name, f"${latex_of(f.short, ())}$: {f.standing}") for f in self.integrals]
        rows = [("form", self.form), *lines, ("statement", self.statement)]
        return html_table(f"first integrals of {self.system}", rows)

    @property
    def new(self) -> tuple[FoundIntegral, ...]:
        """Those found that are functionally independent of the known ones and of one another."""
        return tuple(f for f in self.integrals if f.independent)

    @property
    def complete(self) -> bool:
        """Whether every integral of the form is proved to be a sum of products of the known and
        found ones."""
        return self.exhausted and not self.assumed

    @property
    def exhausted(self) -> bool:
        """Whether the search is complete, if the functions in ``assumed`` are independent."""
        proved = all(f.verdict.proved for f in self.integrals)
        return self.finished and proved and not self.missing

    @property
    def statement(self) -> str:
        """What is proved, in words."""
        if not self.finished:
            return "The search was stopped; what it found stands, what it did not see is open."
        text = self._statement
        if self.assumed:
            names = _list_names([plain_text(e) for e in self.assumed]).replace("**", "^")
            first = text[0].lower() + text[1:]
            text = f"Treating {names} as algebraically independent (not proved): {first}"
        return text

    @property
    def _statement(self) -> str:
        """What is proved, in words, for what is taken as independent."""
        data = [*self.parameters, *self.unknown]
        where = f" at {_equations(self.at)}" if self.at else ""
        generic = f", for generic {_list_names(data)}" if data else ""
        if not self.exhausted:
            return (
                f"Integrals that are {self.form}{where}{generic} make a space of dimension at "
                f"most {self.dimension}; some of them are not proved over the rational numbers."
            )
        names = [*self.known, *(f.name for f in self.integrals)] if self.dimension > 1 else []
        if names:
            text = (
                f"Every first integral that is {self.form}{where} is{generic}, a sum of products "
                f"of: {', '.join(names)}."
            )
        else:
            text = f"No first integral but constants is {self.form}{where}{generic}."
        if self.unknown:
            text += " Special functions may allow more."
        if self.parameters:
            text += " Parameters on the zeros of some polynomial may allow more."
        return text

    def as_dict(self) -> dict[str, Any]:
        """The outcome as text and numbers that JSON can hold."""
        told = plain_data(self)
        for inner in ("parameters", "classes", "examined"):
            del told[inner]
        for original, integral in zip(self.integrals, told["integrals"], strict=True):
            integral |= {"verdict": original.verdict.status, "limits": original.verdict.limits}
        return {**told, "complete": self.complete, "statement": self.statement}


def _list_names(symbols: Sequence[Any]) -> str:
    return ", ".join(map(str, symbols))


def _equations(values: dict[Any, Any]) -> str:
    return ", ".join(f"{s} = {plain_text(v)}" for s, v in values.items()).replace("**", "^")
