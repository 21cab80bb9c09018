"""The search for first integrals: exact linear algebra over an ansatz.

dF/dt = 0 is linear in the coefficients of F.  At random points modulo a prime it is a matrix whose
rank is at most the rank over Q and the parameters: so what it does not allow, does not exist for
generic parameters.  What it allows is lifted to Q and the parameters, and proved.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

import numpy as np
import symengine as se

from voronec.algebra.arguments import accepts, callback
from voronec.algebra.verdicts import Verdict, decide_zero
from voronec.declaration.system import System
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import EngineLimit
from voronec.proof.search.gradings import Gradings
from voronec.proof.search.independence import Independence
from voronec.proof.search.lifting import (
    SURPLUS,
    Kernel,
    KnownFunction,
    ModularIntegral,
    Normalization,
    coefficients,
    investigate,
    product_values,
    products,
    rank_of,
)
from voronec.proof.search.probe import Probe, Values
from voronec.proof.search.question import Question
from voronec.proof.search.residues import Array
from voronec.proof.search.result import FoundIntegral, IntegralSearch

__all__ = ["search_integrals", "searches"]

CLASS_LIMIT = 2000
"""How many monomials of one class are taken on, unless told otherwise."""
ENUMERATION = 100
"""So many times as many monomials may be listed."""


def search_integrals(system: System | VoronecEquations, **options: Any) -> IntegralSearch:
    """Search first integrals of a system of a given form; all options have defaults.

    degree, positions
        bounds on the degrees in the velocities (2) and in the positions (3): the invariants,
        where the system descends to them, else the coordinates.
    denominators, power
        functions by which the polynomial may be divided, up to that power (1) each; ``"mass"``
        stands for the determinant of the mass matrix.
    functions
        name -> function of the state, or a vector of them: further letters of the ansatz; they
        count as velocities where they hold one.  ``None`` stands for the function of the declared
        equation of that name.
    momenta
        whether the ansatz is in the momenta mass * v in the place of the velocities.
    at
        parameter -> special value, a number or a function of other parameters, old or new.
    again
        whether declared integrals are to be found again; else they count as known.
    limit
        how many monomials of one class are taken on (2000).
    progress
        is called with a line of text now and then.

    Every integral returned carries the verdict of the exact algebra; ``statement`` says what there
    is not.
    """
    progress = callback("search_integrals", "progress", options.pop("progress", None))
    last = None
    for last in searches(system, **options):
        if progress is not None:
            progress(f"{last.examined} of {last.monomials} monomials, {len(last.integrals)} found")
    assert last is not None
    return last


@accepts()
def searches(
    system: System | VoronecEquations,
    *,
    degree: int = 2,
    positions: int = 3,
    denominators: Sequence[Any] = (),
    power: int = 1,
    functions: Mapping[str, Any] | None = None,
    momenta: bool = False,
    at: Mapping[Any, Any] | None = None,
    again: bool = False,
    limit: int = CLASS_LIMIT,
    seed: int = 1,
) -> Iterator[IntegralSearch]:
    """``search_integrals`` step by step: what is known after each class; the last is finished."""
    started = perf_counter()
    question = Question.about(
        system, degree, positions, denominators, power, functions or {}, momenta, at or {}, again
    )
    run = _Run.of(question, limit, np.random.default_rng(seed))
    yield run.outcome(False, perf_counter() - started)
    for kernel in run.kernels():
        run.take(kernel)
        yield run.outcome(False, perf_counter() - started)
    yield run.outcome(True, perf_counter() - started)


@dataclass
class _Run:
    """One search in progress."""

    question: Question
    probe: Probe
    values: Values
    classes: list[Array]
    monomials: int
    normalization: Normalization
    independence: Independence
    rng: Any
    known: list[KnownFunction]
    names: list[str]
    foreign: list[str]
    integrals: list[FoundIntegral] = field(default_factory=list)
    failures: int = 0
    size: int = 0
    functions: int = 0
    dimension: int = 0
    known_dimension: int = 0

    @classmethod
    def of(cls, question: Question, limit: int, rng: Any) -> _Run:
        letters = [x.value for x in question.ansatz.letters]
        classes = _classes(question, limit)
        declared = list(question.known.values())
        probe = Probe(question.field, letters, declared)
        values = probe.one(max(map(len, classes)) + SURPLUS, rng)
        holding = [not values.known_rates[i].any() for i in range(len(declared))]
        places = zip(probe.degrees_of_known(), holding, strict=True)
        known = [KnownFunction(v, q, i) for i, ((v, q), ok) in enumerate(places) if ok]
        names = [n for n, ok in zip(question.known, holding, strict=True) if ok]
        ignored = [n for n, ok in zip(question.known, holding, strict=True) if not ok]
        ignored += question.foreign
        count = sum(map(len, classes))
        scaled = Normalization.of(question.field, letters, probe.constants)
        free = probe.independence(rng)
        return cls(
            question, probe, values, classes, count, scaled, free, rng, known, names, ignored
        )

    def kernels(self) -> Iterator[Kernel]:
        """Degree by degree in the velocities, and class by class."""
        ansatz = self.question.ansatz
        degrees = [ansatz.degrees(rows) for rows in self.classes]
        for bound in range(ansatz.degree + 1):
            for rows, each in zip(self.classes, degrees, strict=True):
                if bound in each:
                    kernel = self._investigate(rows[each <= bound])
                    if bound == each.max():
                        self.size += len(rows)
                        self.functions += kernel.independent
                        self.dimension += kernel.dimension
                        self.known_dimension += kernel.known
                    yield kernel

    def _investigate(self, rows: Array) -> Kernel:
        ansatz = self.question.ansatz
        powers = products(self.known, ansatz.degree, ansatz.positions)
        needed = len(rows) + len(powers) + SURPLUS
        if self.values.points < needed:
            setting = self.values.parameters[None, :]
            (again,) = self.probe.at(setting, needed, self.values.p, self.rng)
            if again is None:
                raise EngineLimit("not enough points were found at which to test the ansatz")
            self.values = again
        return investigate(rows, self.values, product_values(self.known, powers, self.values))

    def take(self, kernel: Kernel) -> None:
        """Lift and prove what is new in a class, and count it as known from now on."""
        for candidate in kernel.new:
            known = KnownFunction(
                int(self.question.ansatz.degrees(candidate.exponents).max()),
                int(candidate.exponents.sum(axis=1).max()),
                exponents=candidate.exponents,
                vector=candidate.vector,
            )
            try:
                self.integrals.append(self._lift(candidate, self._independent(known)))
            except EngineLimit:
                self.failures += 1
            self.known.append(known)

    def _independent(self, new: KnownFunction) -> bool:
        before = [k.gradient(self.values) for k in self.known]
        after = [*before, new.gradient(self.values)]
        return rank_of(after, self.values) > rank_of(before, self.values)

    def _lift(self, candidate: ModularIntegral, independent: bool) -> FoundIntegral:
        letters, mechanics = self.question.ansatz.letters, self.question.field
        factors = coefficients(candidate, self.probe, self.normalization, self.rng)
        plain = [se.Symbol(f"letter {i}") for i in range(len(letters))]
        by_factor: dict[Any, list[Any]] = {}
        for factor, row in zip(factors, candidate.exponents, strict=True):
            monomial = se.Mul(*[x ** int(e) for x, e in zip(plain, row, strict=True) if e])
            by_factor.setdefault(factor, []).append(monomial)
        short = se.Add(*[c * se.Add(*group) for c, group in by_factor.items()])
        spelled = short.xreplace({a: x.value for a, x in zip(plain, letters, strict=True)})
        verdict = _proof(mechanics.derivative(spelled), mechanics.hypotheses)
        named = {door_symbol: x.name for door_symbol, x in zip(plain, letters, strict=True)}
        door = mechanics.door
        shown = door.outward(short).xreplace({door.outward(a): n for a, n in named.items()})
        name = f"F{len(self.integrals) + 1}"
        return FoundIntegral(name, door.outward(spelled), shown, verdict, independent)

    def outcome(self, finished: bool, seconds: float) -> IntegralSearch:
        question = self.question
        outward = question.field.door.outward
        constants = [s for s in self.probe.constants if s.free_symbols]
        order = [outward(s) for s in (*question.field.parameters, *constants)]
        return IntegralSearch(
            system=question.field.system.name,
            level=question.field.level,
            form=question.ansatz.words(),
            letters={str(x.symbol): x.meaning for x in question.ansatz.letters if x.is_named},
            at=question.at,
            parameters=tuple(sorted(map(outward, constants), key=order.index)),
            known=tuple(self.names),
            ignored=tuple(self.foreign),
            monomials=self.monomials,
            examined=self.size,
            classes=len(self.classes),
            functions=self.functions,
            dimension=self.dimension,
            explained=self.known_dimension,
            integrals=tuple(self.integrals),
            missing=self.failures,
            finished=finished,
            seconds=seconds,
            assumed=tuple(map(outward, self.independence.assumed)),
            unknown=tuple(map(outward, self.independence.unknown)),
        )


def _classes(question: Question, limit: int) -> list[Array]:
    """The monomials by class, low degrees in the velocities first."""
    ansatz = question.ansatz
    if ansatz.count() > ENUMERATION * limit:
        raise EngineLimit(
            f"the ansatz has {ansatz.count()} monomials; lower a degree, or leave letters out"
        )
    exponents = ansatz.exponents()
    labels = Gradings(question.field, [x.value for x in ansatz.letters]).classes(exponents)
    rows: dict[tuple[int, ...], list[int]] = {}
    for i, label in enumerate(labels):
        rows.setdefault(label, []).append(i)
    classes = [exponents[places] for places in rows.values()]
    largest = max(map(len, classes))
    if largest > limit:
        raise EngineLimit(
            f"the ansatz has {largest} monomials of one class, more than the limit {limit}; "
            "lower a degree, or raise the limit"
        )
    return sorted(classes, key=lambda c: (int(ansatz.degrees(c).max()), len(c)))


def _proof(rate: Any, relations: Sequence[Any]) -> Verdict:
    try:
        return decide_zero(rate, relations)
    except EngineLimit as limit:
        return Verdict("undecided", str(limit))
