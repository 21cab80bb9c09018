"""What a paper introduces: definitions, wherever they stand, free constants, multipliers."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import sympy as sp

from voronec.audit.comparisons import as_vectors, value_of
from voronec.audit.contents import (
    constant_in,
    has_accelerations,
    is_linear,
    lone_name,
    solve_for,
    value_or_none,
)
from voronec.audit.display import Check
from voronec.audit.latex.nodes import Chain, Name, Node
from voronec.audit.lessons.judgement import GROUNDS
from voronec.audit.letters import name_latex, unknown_names
from voronec.audit.printed_claims import PrintedClaim
from voronec.audit.record import FormulaRecord
from voronec.audit.study import Study, key_of
from voronec.audit.verify import verify

INTEGRAL = re.compile(
    r"\bintegrals?\b|constant|conserv|preserv|invariant|first integral", re.IGNORECASE
)
"""Words that say of a formula that its last side is a constant."""
_REACTIONS = re.compile(r"multiplier|reaction|constraint force|lagrange's equations", re.IGNORECASE)


@dataclass
class Introductions:
    """What the formulas of a paper introduce.

    ``study``: the dictionary, which grows by it.  ``records``: the verdicts on formulas that
    introduce something, by their numbers.  ``defined_at``: what introduces a letter.
    ``constants``: free constants of integrals.
    """

    claims: Sequence[PrintedClaim]
    study: Study
    records: dict[int, FormulaRecord] = field(default_factory=dict)
    defined_at: dict[str, PrintedClaim] = field(default_factory=dict)
    constants: set[str] = field(default_factory=set)

    @classmethod
    def of(cls, claims: Sequence[PrintedClaim], study: Study) -> Introductions:
        """What is introduced under a dictionary: definitions first, then multipliers."""
        introduced = cls(claims, study)
        introduced._define()
        introduced._multipliers()
        return introduced

    def _define(self) -> None:
        """Definitions wherever they stand; those that need others come after these."""
        changed = True
        while changed:
            changed = False
            for number, claim in enumerate(self.claims):
                if claim.chain is not None and number not in self.records:
                    changed |= self._define_by(number, claim, claim.chain)
            changed = changed or any(
                self._free_constant(number, claim, pair)
                for number, claim in enumerate(self.claims)
                if claim.chain is not None and {*claim.chain.relations} == {"="}
                for pair in pairwise(claim.chain.parts)
            )

    def _define_by(self, number: int, claim: PrintedClaim, chain: Chain) -> bool:
        """Whether a formula is taken for a definition, or for an integral with its constant."""
        unknown = unknown_names(chain, self.study)
        if {*chain.relations} != {"="} or self.is_forced(unknown):
            return False
        parts = [(part, unknown_names(part, self.study)) for part in chain.parts]
        known = [part for part, names in parts if not names]
        lone = [part for part, _ in parts if lone_name(part) is not None and part not in known]
        name, value = (
            solve_for(lone[0], known[0]) if len(unknown) == 1 and known and lone else (None, None)
        )
        if name is None:
            return False
        second = parts[0][0] is not lone[0]
        constant = second and self._is_constant(known[0])
        state = second and isinstance(known[0], Name)  # v = v_0 says something of a state
        judged = second and (INTEGRAL.search(claim.sentence) or not isinstance(lone[0], Name))
        if (state or judged) and not constant:
            return False
        if len(known) == 1:  # else the other sides are judged
            self._tell(number, "" if constant else unknown[0])
        self.study = self.study.join({key_of(name): value})
        self.defined_at[key_of(name)] = claim
        return True

    def _tell(self, number: int, letter: str = "") -> None:
        """Record that a formula introduces a letter, or is an integral with its free constant."""
        printed, told = self.claims[number].formula.printed, f"it introduces {letter}"
        self.records[number] = FormulaRecord(printed, "definition", told)
        if not letter:
            ground, source = GROUNDS["integral"], self.study.origin
            self.records[number] = FormulaRecord(printed, "proved", ground, source=source)

    def _free_constant(self, number: int, claim: PrintedClaim, pair: tuple[Node, Node]) -> bool:
        """Whether two sides say what a constant is, in which they are linear, as v = g t + C."""
        unknown = unknown_names(Chain(pair, ("=",)), self.study)
        if len(unknown) != 1 or self.is_forced(unknown):
            return False
        value, verdict = constant_in(pair, unknown[0], self.study)
        if verdict is None or not verdict.proved:
            return False
        self.study = replace(self.study, names={**self.study.names, unknown[0]: value})
        moving = value.free_symbols & {*self.study.motion.rates}
        self.constants |= {unknown[0]} if moving else set()
        if claim.chain is not None and len(claim.chain.parts) == 2:
            self._tell(number, "" if moving else unknown[0])
        return True

    def is_forced(self, unknown: Sequence[str]) -> bool:
        """Whether letters stand for multipliers or reactions."""
        return any(letter in self.forces for letter in unknown)

    @cached_property
    def forces(self) -> frozenset[str]:
        """Letters that nothing explains, in equations with accelerations: lambda and mu, and what a
        sentence on multipliers or reactions has."""
        letters: set[str] = set()
        for claim in self.claims:
            if claim.chain is None or not has_accelerations(claim.chain, self.study):
                continue
            said = _REACTIONS.search(claim.sentence)
            for letter in unknown_names(claim.chain, self.study):
                if said or re.match(r"\\(?:lambda|mu)(?![a-zA-Z])", letter):
                    letters.add(letter)
        applied = {n for n in letters if n.partition("_")[0] in self.study.functions}
        return frozenset(letters - applied - {*self._parametric()})

    def _parametric(self) -> Iterator[str]:
        """Letters that the paper says are functions of parameters, or matrices of the state."""
        moving = {*self.study.motion.rates, *self.study.motion.rates.values()}
        for claim in self.claims:
            parts = claim.chain.parts if claim.chain is not None else ()
            values = [value_or_none(value_of, part, self.study, {}) for part in parts]
            held: list[set[Any]] = [getattr(value, "free_symbols", set()) for value in values]
            matrices = any(
                isinstance(value, sp.MatrixBase)
                and not symbols & self.study.motion.accelerations.keys()
                for value, symbols in zip(values, held, strict=True)
            )
            if matrices or any(symbols and not symbols & moving for symbols in held):
                yield from (name_latex(part) for part in parts if isinstance(part, Name))

    def _is_constant(self, part: Node) -> bool:
        """Whether a part keeps its value along every motion."""
        chain = Chain((part, Name("const")), ("=",))
        outcome = value_or_none(verify, chain, Check(), self.study)
        return outcome is not None and outcome.verdict.proved

    def _multipliers(self) -> None:
        """The values of multipliers, each from the first equation that has it; a vector equation
        has several."""
        symbols = {letter: sp.Dummy(letter) for letter in sorted(self.forces)}
        study = replace(self.study, names={**self.study.names, **symbols})
        values: dict[Any, Any] = {}
        for number, claim in enumerate(self.claims if symbols else ()):
            if claim.chain is None or number in self.records or len(claim.chain.parts) != 2:
                continue
            unknown = unknown_names(claim.chain, self.study)
            if not unknown or not {*unknown} <= symbols.keys():
                continue
            gaps = value_or_none(_gaps, claim.chain.parts, study) or []
            count = 0
            for gap in gaps:
                gap = sp.expand(gap.xreplace(values))
                mine = [s for s in symbols.values() if gap.has(s)]
                if not mine or not is_linear(gap, mine):
                    continue
                value = -gap.xreplace({mine[0]: sp.S.Zero}) / sp.diff(gap, mine[0])
                values = {s: v.xreplace({mine[0]: value}) for s, v in values.items()}
                values[mine[0]], count = value, count + 1
                letter = next(k for k, s in symbols.items() if s == mine[0])
                self.defined_at[letter] = claim
            if count and count == len(gaps):
                self._tell(number, letter)
        solved = {k: values[s] for k, s in symbols.items() if s in values}
        solved = {k: v for k, v in solved.items() if not v.free_symbols & {*symbols.values()}}
        self.study = replace(self.study, names={**self.study.names, **solved})


def _gaps(parts: Sequence[Node], study: Study) -> list[Any]:
    """What vanishes along the motion where two sides are equal, component by component."""
    left, right = as_vectors(*(study.motion.along(value_of(part, study, {})) for part in parts))
    return [*(left - right)] if isinstance(left, sp.MatrixBase) else [left - right]
