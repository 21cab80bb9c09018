"""What a search is about: a field at given parameters, the letters of the ansatz, what is known."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.conditions import substituted_conditions
from voronec.algebra.normal import shortest
from voronec.algebra.ring import Ring
from voronec.algebra.text import sympified
from voronec.analysis.search.ansatz import Ansatz, Letter
from voronec.analysis.search.declared import declared, on_field
from voronec.claims import Corrected
from voronec.equations import VoronecEquations
from voronec.errors import DefinitionError, did_you_mean
from voronec.reading import shown
from voronec.system import System
from voronec.vector_field import Motions, VectorField

__all__ = ["Question"]


@dataclass(frozen=True)
class Question:
    """A field, an ansatz, integrals that need not be found again, by name, and the names of those
    that are declared but are no functions on this field."""

    field: VectorField
    ansatz: Ansatz
    known: dict[str, Any]
    ignored: tuple[str, ...]
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
    ) -> Question:
        """Read what the user handed in."""
        for name, number in (("degree", degree), ("positions", positions), ("power", power)):
            if not isinstance(number, int) or number < 0:
                raise DefinitionError(f"{name} is {shown(number)}; give a number from 0 upward")
        motions = Motions.of(system)
        given = _functions(motions.system, functions)
        below = [d if d == "mass" else sympified(d) for d in denominators]
        plain = [*given.values(), *(d for d in below if d != "mass")]
        values = _values(motions.system, at)
        new = {s for v in values.values() for s in v.free_symbols}
        _check_symbols(motions.system, plain, new)
        field = _specialized(motions.deciding(plain), values)
        reader = _Reader(field, values)
        letters = [
            *reader.velocities(momenta),
            *reader.positions(),
            *reader.functions(given),
            *reader.denominators(below),
        ]
        ansatz = Ansatz(tuple(letters), degree, positions, power)
        cases = {k: _values(motions.system, c.parameters) for k, c in motions.system.cases.items()}
        claims = {} if again else declared(motions.system, values, cases)
        inside = {field.door.inward(s): field.door.inward(v) for s, v in values.items()}
        given_known = on_field(motions, field, claims)
        known = {name: f.xreplace(inside) for name, f in given_known.items()}
        return cls(field, ansatz, known, tuple(n for n in claims if n not in known), values)


@dataclass(frozen=True)
class _Reader:
    field: VectorField
    values: Mapping[sp.Symbol, sp.Expr]

    def read(self, expr: sp.Expr) -> Any:
        return self.field.read(sympified(expr).xreplace(dict(self.values)))

    def _letter(self, value: Any, kind: str, name: str = "") -> Letter:
        meaning = self.field.door.outward(value)
        return Letter(sp.Symbol(name) if name else meaning, value, meaning, kind)

    def _kind(self, value: Any) -> str:
        return "velocity" if value.free_symbols & {*self.field.velocities} else "position"

    def velocities(self, momenta: bool) -> list[Letter]:
        field = self.field
        if not momenta:
            return [self._letter(v, "velocity") for v in field.velocities]
        rows = [
            se.Add(*[m * v for m, v in zip(row, field.velocities, strict=True)])
            for row in field.mass
        ]
        pairs = zip(rows, field.velocities, strict=True)
        return [self._letter(row, "velocity", f"p_{v}") for row, v in pairs]

    def positions(self) -> list[Letter]:
        """Coordinates; of those under sines and cosines, these."""
        field = self.field
        entries = (*field.rates, *field.force, *(e for row in field.mass for e in row))
        under = {q: [e for e in entries if q in e.free_symbols] for q in field.positions}
        found = []
        for q in field.positions:
            plain = se.Symbol(f"{q} in a circle")
            bare = any(
                q in e.xreplace({se.cos(q): plain, se.sin(q): plain, se.tan(q): plain}).free_symbols
                for e in under[q]
            )
            if under[q] and (not bare or any(e.has(se.sin(q), se.cos(q)) for e in under[q])):
                found += [self._letter(f(q), "position") for f in (se.cos, se.sin)]
            if bare or not under[q]:
                found.append(self._letter(q, "position"))
        return found

    def functions(self, given: Mapping[str, sp.Expr]) -> list[Letter]:
        found = []
        for name, expr in given.items():
            value = self.read(expr)
            if not value.free_symbols & {*self.field.variables}:
                raise DefinitionError(f"the function '{name}' is a constant; leave it out")
            found.append(self._letter(value, self._kind(value), name))
        return found

    def denominators(self, below: Sequence[Any]) -> list[Letter]:
        found: list[Letter] = []
        longer = sum(d == "mass" or not sympified(d).is_Symbol for d in below)
        for d in below:
            value = self.read(d) if d != "mass" else self._determinant()
            if not value.free_symbols & {*self.field.variables}:
                raise DefinitionError(f"the denominator '{shown(d)}' is a constant; leave it out")
            meaning = self.field.door.outward(value)
            name = meaning
            if not meaning.is_Symbol:
                name = sp.Symbol("Delta" if longer == 1 else f"Delta{len(found) + 1}")
            found.append(Letter(1 / name, 1 / value, meaning, "denominator"))
        return found

    def _determinant(self) -> Any:
        """The numerator of the determinant of the mass."""
        size, relations = len(self.field.mass), self.field.relations
        matrix = se.DenseMatrix(size, size, [e for row in self.field.mass for e in row])
        ring = Ring([matrix.det()], relations)
        above = ring.field.absorbed(ring.fraction(matrix.det())).num
        return shortest([ring.polynomial(above)], relations)[0]


def _functions(system: System, given: Mapping[str, Any]) -> dict[str, sp.Expr]:
    """Extra letters by name; a vector counts its entries from 1, and None stands for the function
    of a declared equation."""
    found: dict[str, sp.Expr] = {}
    taken = {str(s) for s in (*system.known_symbols(), *system.invariant_symbols)}
    for name, value in given.items():
        if value is None:
            if name not in system.equations:
                raise DefinitionError(
                    f"system '{system.name}' declares no equation '{name}'"
                    + did_you_mean(name, system.equations)
                )
            claim = system.equations[name]
            value = (claim.right if isinstance(claim, Corrected) else claim).function
        entries = list(value) if isinstance(value, (list, tuple, sp.MatrixBase)) else [value]
        plain = name.replace(" ", "_")
        count = range(1, len(entries) + 1)
        names = [plain] if len(entries) == 1 else [f"{plain}{i}" for i in count]
        for one, entry in zip(names, entries, strict=True):
            if one in taken or one in found:
                raise DefinitionError(f"the name '{one}' is taken; give the function another")
            found[one] = sympified(entry)
    return found


def _check_symbols(system: System, exprs: Iterable[sp.Expr], new: set[Any]) -> None:
    known = {*system.known_symbols(), *system.invariant_symbols, *new}
    names = {str(s) for s in known}
    for expr in exprs:
        for symbol in sorted(expr.free_symbols - known, key=str):
            if str(symbol) not in names:
                raise DefinitionError(
                    f"system '{system.name}' has no symbol '{symbol}'"
                    + did_you_mean(str(symbol), names)
                )


def _values(system: System, at: Mapping[Any, Any]) -> dict[sp.Symbol, sp.Expr]:
    """Special values of parameters, by symbol."""
    parameters = {str(p.symbol): p.symbol for p in system.parameters}
    found = {}
    for key, value in at.items():
        if str(key) not in parameters:
            raise DefinitionError(
                f"system '{system.name}' has no parameter '{key}'"
                + did_you_mean(str(key), parameters)
            )
        found[parameters[str(key)]] = sympified(value).xreplace(
            {s: parameters[str(s)] for s in sympified(value).free_symbols if str(s) in parameters}
        )
    for symbol, value in found.items():
        if value.free_symbols & {*found}:
            raise DefinitionError(
                f"the value '{value}' of '{symbol}' holds a parameter that has a value itself; "
                "write it with the others"
            )
    return found


def _specialized(field: VectorField, values: Mapping[sp.Symbol, sp.Expr]) -> VectorField:
    """The field at special values of parameters; symbols that are new become parameters."""
    if not values:
        return field
    inside = {field.door.inward(s): field.door.inward(v) for s, v in values.items()}
    text = ", ".join(f"{s} = {v}" for s, v in values.items())

    def enter(exprs: Sequence[Any]) -> tuple[Any, ...]:
        found = tuple(e.xreplace(inside) for e in exprs)
        if any(e.has(se.zoo) or e.has(se.nan) for e in found):
            raise DefinitionError(
                f"system '{field.system.name}': the equations have no value at {text}"
            )
        return found

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
