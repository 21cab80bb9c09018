"""The search for first integrals: exact linear algebra over an ansatz.

dF/dt = 0 is linear in the coefficients of F.  At random points modulo a prime it is a matrix whose
rank is at most the rank over Q and the parameters: so what it does not allow, does not exist for
generic parameters.  What it allows is lifted to Q and the parameters, and proved.

A ``SearchProblem`` is what a search is about: a field at given parameters, the letters of the
ansatz, what is known.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from math import lcm
from time import perf_counter
from typing import Any

import flint
import numpy as np
import symengine as se
import sympy as sp

from voronec.algebra.arguments import accepts, callback
from voronec.algebra.conditions import substituted_conditions
from voronec.algebra.matrices import dot
from voronec.algebra.normal import shortest
from voronec.algebra.points import sample_evaluable
from voronec.algebra.precision import GENERIC
from voronec.algebra.roots import ring_over
from voronec.algebra.tape import Tape
from voronec.algebra.terms import atoms
from voronec.algebra.text import as_expression
from voronec.algebra.verdicts import Verdict, decide_zero
from voronec.declaration.claims import right_of
from voronec.declaration.reading import expression as read_expression
from voronec.declaration.reading import quote, several
from voronec.declaration.system import System
from voronec.equations.motions import Motions
from voronec.equations.reduction import in_invariants
from voronec.equations.vector_field import VectorField
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.errors import DefinitionError, EngineLimit, did_you_mean
from voronec.proof.branch_cuts import across_cuts, not_vacuous
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
from voronec.proof.search.residues import Array
from voronec.proof.search.result import FoundIntegral, IntegralSearch

CLASS_LIMIT = 2000
"""How many monomials of one class are taken on, unless told otherwise."""
PARTS, SMALL = 32, 1e-6
"""In how many parts a turn is divided; what part of the largest of so many values is zero."""
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
    is not.  Raises ``DefinitionError`` for options that make no sense, ``EngineLimit`` for an
    ansatz with more monomials than the limit.
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
    question = SearchProblem.about(
        system, degree, positions, denominators, power, functions or {}, momenta, at or {}, again
    )
    run = _Run.of(question, limit, np.random.default_rng(seed))
    yield replace(run.result, seconds=perf_counter() - started)
    for kernel in run.kernels():
        run.take(kernel)
        yield replace(run.result, seconds=perf_counter() - started)
    yield replace(run.result, finished=True, seconds=perf_counter() - started)


@dataclass
class _Run:
    """One search in progress."""

    question: SearchProblem
    probe: Probe
    values: Values
    classes: list[Array]
    normalization: Normalization
    rng: Any
    known: list[KnownFunction]
    result: IntegralSearch

    @classmethod
    def of(cls, question: SearchProblem, limit: int, rng: Any) -> _Run:
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
        scaled = Normalization.of(question.field, letters, probe.constants)
        result = _beginning(question, probe, classes, probe.independence(rng))
        result = replace(result, known=tuple(names), ignored=(*ignored, *question.foreign))
        return cls(question, probe, values, classes, scaled, rng, known, result)

    def kernels(self) -> Iterator[Kernel]:
        """Degree by degree in the velocities, and class by class."""
        ansatz = self.question.ansatz
        degrees = [ansatz.degrees(rows) for rows in self.classes]
        for bound in range(ansatz.degree + 1):
            for rows, each in zip(self.classes, degrees, strict=True):
                if bound in each:
                    kernel = self._investigate(rows[each <= bound])
                    if bound == each.max():
                        self.result = replace(
                            self.result,
                            examined=self.result.examined + len(rows),
                            functions=self.result.functions + kernel.independent,
                            dimension=self.result.dimension + kernel.dimension,
                            explained=self.result.explained + kernel.known,
                        )
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
            before = self.result
            try:
                new = self._lift(candidate, self._independent(known))
                self.result = replace(before, integrals=(*before.integrals, new))
            except EngineLimit:
                self.result = replace(before, missing=before.missing + 1)
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
        verdict = _proof(mechanics, spelled)
        named = {door_symbol: x.name for door_symbol, x in zip(plain, letters, strict=True)}
        bridge = mechanics.bridge
        shown = bridge.outward(short).xreplace({bridge.outward(a): n for a, n in named.items()})
        name = f"F{len(self.result.integrals) + 1}"
        return FoundIntegral(name, bridge.outward(spelled), shown, verdict, independent)


def _beginning(
    question: SearchProblem, probe: Probe, classes: Sequence[Array], independence: Independence
) -> IntegralSearch:
    """The outcome of a search that has looked at nothing yet."""
    outward = question.field.bridge.outward
    constants = [s for s in probe.constants if s.free_symbols]
    order = [outward(s) for s in (*question.field.parameters, *constants)]
    return IntegralSearch(
        system=question.field.system.name,
        level=question.field.level,
        form=question.ansatz.words(),
        letters={str(x.symbol): x.meaning for x in question.ansatz.letters if x.is_named},
        at=question.at,
        parameters=tuple(sorted(map(outward, constants), key=order.index)),
        monomials=sum(map(len, classes)),
        classes=len(classes),
        assumed=tuple(map(outward, independence.assumed)),
        unknown=tuple(map(outward, independence.unknown)),
    )


def _classes(question: SearchProblem, limit: int) -> list[Array]:
    """The monomials by class, low degrees in the velocities first."""
    ansatz = question.ansatz
    if ansatz.count() > ENUMERATION * limit:
        raise EngineLimit(
            f"the ansatz has {quote(ansatz.count())} monomials; lower a degree, or leave letters "
            "out"
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


def _proof(mechanics: VectorField, function: Any) -> Verdict:
    """Whether a function is constant along motions, those that cross its cuts among them."""
    try:
        verdict = decide_zero(mechanics.derivative(function), mechanics.hypotheses)
    except EngineLimit as limit:
        return Verdict("undecided", str(limit))
    verdict = across_cuts(verdict, mechanics, [("", function)], constant=True)
    return not_vacuous(verdict, mechanics)


@dataclass(frozen=True)
class Letter:
    """One function of the state, of ``kind`` velocity, position or denominator.

    ``name`` is how it is printed, ``value`` what it is, in the engine's symbols, ``meaning`` in the
    user's symbols; a denominator enters by its reciprocal, its meaning is the denominator.
    """

    name: sp.Expr
    value: Any
    meaning: sp.Expr
    kind: str

    @property
    def is_named(self) -> bool:
        """Whether the name is not the function itself."""
        return bool(self.symbol != self.meaning)

    @property
    def symbol(self) -> sp.Expr:
        """What ``meaning`` is the meaning of: the name, or what the name is the reciprocal of."""
        return 1 / self.name if self.kind == "denominator" else self.name


@dataclass(frozen=True)
class Ansatz:
    """Sums of monomials of degree up to ``degree`` in the letters of kind velocity, ``positions``
    in those of kind position, over up to ``power`` powers of each denominator."""

    letters: tuple[Letter, ...]
    degree: int
    positions: int
    power: int

    def of(self, kind: str) -> list[Letter]:
        """The letters of one kind."""
        return [letter for letter in self.letters if letter.kind == kind]

    def count(self) -> int:
        """How many monomials there are."""
        total = (self.power + 1) ** len(self.of("denominator"))
        for kind, bound in (("velocity", self.degree), ("position", self.positions)):
            total *= int(sp.binomial(len(self.of(kind)) + bound, bound))
        return total

    def exponents(self) -> Array:
        """One row for each monomial, in the order of the letters; low degrees first."""
        columns: dict[str, list[int]] = {"velocity": [], "position": [], "denominator": []}
        for i, letter in enumerate(self.letters):
            columns[letter.kind].append(i)
        rows = []
        for v in _up_to(len(columns["velocity"]), self.degree):
            for q in _up_to(len(columns["position"]), self.positions):
                for d in np.ndindex(*([self.power + 1] * len(columns["denominator"]))):
                    row = np.zeros(len(self.letters), dtype=np.int64)
                    row[columns["velocity"]] = v
                    row[columns["position"]] = q
                    row[columns["denominator"]] = d
                    rows.append(row)
        return np.array(sorted(rows, key=_order), dtype=np.int64).reshape(-1, len(self.letters))

    def degrees(self, exponents: Array) -> Array:
        """The degree in the velocities of each monomial."""
        moving = [letter.kind == "velocity" for letter in self.letters]
        return exponents[:, moving].sum(axis=1)

    def words(self) -> str:
        """The form, in one line."""
        velocities, positions = (
            ", ".join(str(x.name) for x in self.of(kind)) for kind in ("velocity", "position")
        )
        parts = []
        if velocities:
            parts.append(f"of degree up to {self.degree} in {velocities}")
        if positions:
            parts.append(f"of degree up to {self.positions} in {positions}")
        text = "a polynomial " + " and ".join(parts)
        below = [str(x.symbol) for x in self.of("denominator")]
        if below:
            power = f"^{self.power}" if self.power > 1 else ""
            text += " over " + " ".join(f"{b}{power}" for b in below)
        return text.replace("**", "^")


def _up_to(letters: int, degree: int) -> Iterator[Sequence[int]]:
    """Exponents of total degree up to a bound."""
    if letters == 0:
        yield ()
        return
    for first in range(degree + 1):
        for rest in _up_to(letters - 1, degree - first):
            yield (first, *rest)


def _order(row: Array) -> tuple[int, ...]:
    return (int(row.sum()), *(-int(e) for e in row))


SymbolValues = Mapping[Any, sp.Expr]


def known_integrals(motions: Motions, field: VectorField, values: SymbolValues) -> dict[str, Any]:
    """The declared integrals that are functions on the field, which has special values of
    parameters, in the engine's symbols."""
    inside = {field.bridge.inward(s): field.bridge.inward(v) for s, v in values.items()}
    integrals = _on_field(motions, field, _declared_integrals(motions.system, values))
    return {name: f.xreplace(inside) for name, f in integrals.items()}


def _declared_integrals(system: System, values: SymbolValues) -> dict[str, sp.Expr]:
    """The declared integrals: those of the system, and those of the cases that hold at these values
    of parameters."""
    claims = dict(system.integrals)
    for name, case in system.cases.items():
        if _is_implied(parameter_values(system, case.parameters), values):
            claims |= {f"{k} ({name})": v for k, v in case.integrals.items()}
    return {k: right_of(c) for k, c in claims.items()}


def _is_implied(case: SymbolValues, values: SymbolValues) -> bool:
    """Whether the values given to parameters are among those of a case."""
    at = dict(values)
    return bool(case) and all(
        sp.cancel(symbol.xreplace(at) - value.xreplace(at)) == 0 for symbol, value in case.items()
    )


def _on_field(
    motions: Motions, field: VectorField, claims: Mapping[str, sp.Expr]
) -> dict[str, Any]:
    """The claims that are functions on the field, in the engine's symbols.

    One that holds coordinates is rewritten in the invariants, where that is possible; one that
    holds the time is left out.
    """
    plain, other = {}, {}
    for name, expr in claims.items():
        if field.level == "coordinates" or not motions.holds_coordinate([expr]):
            plain[name] = motions.at(field.level).read(expr)
        else:
            other[name] = motions.on_coordinates.read(expr)
    functions = plain | _descend(motions, other)
    return {
        k: functions[k] for k in claims if k in functions and functions[k].diff(field.time) == 0
    }


def _descend(motions: Motions, functions: Mapping[str, Any]) -> dict[str, Any]:
    """Functions of coordinates and velocities as functions of invariants and velocities, where
    elimination finds them as such."""
    descended = {}
    for name, function in functions.items():
        with suppress(EngineLimit):
            (rewritten,) = in_invariants(motions.equations, [function])
            if rewritten is not None:
                descended[name] = rewritten
    return descended


@dataclass(frozen=True)
class SearchProblem:
    """A field, an ansatz, integrals that need not be found again, by name, and the names of those
    that are declared but are no functions on this field."""

    field: VectorField
    ansatz: Ansatz
    known: dict[str, Any]
    foreign: tuple[str, ...]
    at: dict[sp.Symbol, sp.Expr]

    @classmethod
    def about(
        cls,
        system: System | VoronecEquations,
        degree: int,
        positions: int,
        denominators: Sequence[Any],
        power: int,
        functions: Mapping[str, Any],
        momenta: bool,
        at: Mapping[Any, Any],
        again: bool,
    ) -> SearchProblem:
        """Read what the user handed in."""
        for name, number in (("degree", degree), ("positions", positions), ("power", power)):
            require_bound(name, number)
        motions = Motions.of(system)
        given = _functions(motions.system, functions)
        below = [d if d == "mass" else as_expression(d) for d in denominators]
        plain = [*given.values(), *(d for d in below if d != "mass")]
        values = parameter_values(motions.system, at)
        new = {s for v in values.values() for s in v.free_symbols}
        check_symbols(motions.system, plain, new)
        field = specialize_field(motions.field_for(plain), values)
        if field.existence.refuted:
            raise DefinitionError(f"system '{motions.system.name}': {field.existence.method}")
        reader = _StateReader(field, values)
        letters = [
            *reader.velocities(momenta),
            *reader.positions(),
            *reader.functions(given),
            *reader.denominators(below),
        ]
        ansatz = Ansatz(tuple(letters), degree, positions, power)
        claims = {} if again else _declared_integrals(motions.system, values)
        known = {} if again else known_integrals(motions, field, values)
        return cls(field, ansatz, known, tuple(n for n in claims if n not in known), values)


@dataclass(frozen=True)
class _StateReader:
    field: VectorField
    values: Mapping[sp.Symbol, sp.Expr]

    def read(self, expr: sp.Expr) -> Any:
        return self.field.read(as_expression(expr).xreplace(dict(self.values)))

    def _letter(self, value: Any, kind: str, name: str = "") -> Letter:
        meaning = self.field.bridge.outward(value)
        return Letter(sp.Symbol(name) if name else meaning, value, meaning, kind)

    def _kind(self, value: Any) -> str:
        return "velocity" if value.free_symbols & {*self.field.velocities} else "position"

    def velocities(self, momenta: bool) -> list[Letter]:
        field = self.field
        if not momenta:
            return [self._letter(v, "velocity") for v in field.velocities]
        rows = [dot(row, field.velocities) for row in field.mass]
        pairs = zip(rows, field.velocities, strict=True)
        return [self._letter(row, "velocity", f"p_{v}") for row, v in pairs]

    def positions(self) -> list[Letter]:
        """Coordinates; of those under sines and cosines, these, of q/n where q/n is the part of q
        that all angles are multiples of; and these themselves where a force turns them on, or where
        the constraints integrate to a function that holds them."""
        field, leaves = self.field, self._leaves()
        angles = atoms([*field.entries, *leaves], se.sin, se.cos, se.tan)
        letters = []
        for q in field.positions:
            turning = {f: f.args[0].diff(q) for f in angles if q in f.free_symbols}
            turning = {f: c for f, c in turning.items() if isinstance(c, se.Rational)}
            turns = lcm(*(int(c.get_num_den()[1]) for c in turning.values()))
            if turning:
                letters += [self._letter(f(q / turns), "position") for f in (se.cos, se.sin)]
            plain = {f: se.Symbol(f"{i} in a circle") for i, f in enumerate(turning)}
            under = [e for e in field.entries if q in e.free_symbols]
            bare = any(q in e.xreplace(plain).free_symbols for e in (*under, *leaves))
            held = not under or bare
            if held or self._does_work(q, turns):
                letters.append(self._letter(q, "position"))
        return letters

    def _does_work(self, q: Any, turns: int) -> bool:
        """Whether forces at rest do work over whole turns of an angle, as a constant torque does:
        what they are the slope of holds the angle itself."""
        field, still = self.field, dict.fromkeys(self.field.velocities, se.Integer(0))
        (rate,) = (r for x, r in zip(field.positions, field.rates, strict=True) if x == q)
        work = se.Add(
            *[rate.diff(v) * f for v, f in zip(field.velocities, field.force, strict=True)]
        )
        tape = Tape([work.xreplace(still)])
        for point, _ in sample_evaluable(tape, field.hypotheses, count=1):
            angles = (turns * flint.arb.pi() * (2 * k + 1) / PARTS for k in range(PARTS))
            values = [tape.arb({**point, q: angle}, GENERIC)[0] for angle in angles]
            largest = max(map(abs, values))
            return bool(abs(sum(values)) > SMALL * largest)
        return False

    def _leaves(self) -> list[Any]:
        """What the constraints hold constant, where it is known."""
        if self.field.level != "coordinates":
            return []
        try:
            return [self.read(f) for f in derive(self.field.system).leaves]
        except EngineLimit:
            return []

    def functions(self, given: Mapping[str, sp.Expr]) -> list[Letter]:
        letters = []
        for name, expr in given.items():
            value = self.read(expr)
            if not value.free_symbols & {*self.field.variables}:
                holds = self.field.time in value.free_symbols
                why = "holds the time, and no state" if holds else "is a constant"
                raise DefinitionError(f"the function '{name}' {why}; leave it out")
            letters.append(self._letter(value, self._kind(value), name))
        return letters

    def denominators(self, below: Sequence[Any]) -> list[Letter]:
        letters: list[Letter] = []
        longer = sum(d == "mass" or not as_expression(d).is_Symbol for d in below)
        for d in below:
            value = self.read(d) if d != "mass" else self._determinant()
            if not value.free_symbols & {*self.field.variables}:
                raise DefinitionError(f"the denominator '{quote(d)}' is a constant; leave it out")
            meaning = self.field.bridge.outward(value)
            name = meaning
            if not meaning.is_Symbol:
                name = sp.Symbol("Delta" if longer == 1 else f"Delta{len(letters) + 1}")
            letters.append(Letter(1 / name, 1 / value, meaning, "denominator"))
        return letters

    def _determinant(self) -> Any:
        """The numerator of the determinant of the mass."""
        size, relations = len(self.field.mass), self.field.relations
        matrix = se.DenseMatrix(size, size, [e for row in self.field.mass for e in row])
        ring = ring_over([matrix.det()], relations)
        above = ring.field.absorb(ring.fraction(matrix.det())).num
        return shortest([ring.polynomial(above)], relations)[0]


def _functions(system: System, given: Mapping[str, Any]) -> dict[str, sp.Expr]:
    """Extra letters by name; a vector counts its entries from 1, and None stands for the function
    of a declared equation."""
    named: dict[str, sp.Expr] = {}
    taken = {str(s) for s in (*system.known_symbols(), *system.invariant_symbols)}
    for name, value in given.items():
        if value is None:
            if name not in system.equations:
                raise DefinitionError(
                    f"system '{system.name}' declares no equation '{name}'"
                    + did_you_mean(name, system.equations)
                )
            value = right_of(system.equations[name]).function
        entries = list(value) if isinstance(value, (list, tuple, sp.MatrixBase)) else [value]
        plain = name.replace(" ", "_")
        count = range(1, len(entries) + 1)
        names = [plain] if len(entries) == 1 else [f"{plain}{i}" for i in count]
        for one, entry in zip(names, entries, strict=True):
            if one in taken or one in named:
                raise DefinitionError(f"the name '{one}' is taken; give the function another")
            named[one] = as_expression(entry)
    return named


def require_bound(name: str, number: Any, least: int = 0) -> None:
    """Refuse what is no bound on a degree."""
    if not isinstance(number, int) or isinstance(number, bool) or number < least:
        raise DefinitionError(f"{name} is {quote(number)}; give a number from {least} upward")


def read_expressions(system: System, given: Any, place: str) -> list[sp.Expr]:
    """Several expressions in symbols that a system has."""
    exprs = several(given, place, "expression", (int, float))
    expressions = [read_expression(as_expression(e), place) for e in exprs]
    check_symbols(system, expressions, set())
    return expressions


def check_symbols(system: System, exprs: Iterable[sp.Expr], new: set[Any]) -> None:
    """Refuse symbols that a system does not have."""
    known = {*system.known_symbols(), *system.invariant_symbols, *new}
    names = {str(s) for s in known}
    for expr in exprs:
        for symbol in sorted(expr.free_symbols - known, key=str):
            if str(symbol) not in names:
                raise DefinitionError(
                    f"system '{system.name}' has no symbol '{symbol}'"
                    + did_you_mean(str(symbol), names)
                )


def parameter_values(system: System, at: Mapping[Any, Any]) -> dict[sp.Symbol, sp.Expr]:
    """Special values of parameters, by symbol."""
    parameters = {str(p.symbol): p.symbol for p in system.parameters}
    values = {}
    for key, value in at.items():
        if str(key) not in parameters:
            raise DefinitionError(
                f"system '{system.name}' has no parameter '{key}'"
                + did_you_mean(str(key), parameters)
            )
        values[parameters[str(key)]] = as_expression(value).xreplace(
            {
                s: parameters[str(s)]
                for s in as_expression(value).free_symbols
                if str(s) in parameters
            }
        )
    for symbol, value in values.items():
        if value.free_symbols & {*values}:
            raise DefinitionError(
                f"the value '{value}' of '{symbol}' holds a parameter that has a value itself; "
                "write it with the others"
            )
    return values


def specialize_field(field: VectorField, values: Mapping[sp.Symbol, sp.Expr]) -> VectorField:
    """The field at special values of parameters; symbols that are new become parameters."""
    if not values:
        return field
    inside = {field.bridge.inward(s): field.bridge.inward(v) for s, v in values.items()}
    text = ", ".join(f"{s} = {v}" for s, v in values.items())

    def enter(exprs: Sequence[Any]) -> tuple[Any, ...]:
        entered = tuple(e.xreplace(inside) for e in exprs)
        if any(e.has(se.zoo) or e.has(se.nan) for e in entered):
            raise DefinitionError(
                f"system '{field.system.name}': the equations have no value at {text}"
            )
        return entered

    new = sorted({s for v in inside.values() for s in v.free_symbols}, key=str)
    left = [s for s in field.parameters if s not in inside]
    return replace(
        field,
        parameters=(*left, *(s for s in new if s not in left)),
        rates=enter(field.rates),
        mass=tuple(enter(row) for row in field.mass),
        force=enter(field.force),
        relations=enter(field.relations),
        conditions=substituted_conditions(field.conditions, inside),
        meaning={k: v.xreplace(inside) for k, v in field.meaning.items()},
    )
