"""Independence, and factors that do not vanish, on every piece of the space.

What is analytic but for cuts, as w + |w|, may vanish on one side of a cut and not on the other:
a point at which it does not vanish tells of one side alone.  A proof that needs a matrix to have a
rank is cut down to the pieces on which the matrix has it, and to parameters where it has.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import symengine as se

from voronec.algebra.branches import product_of
from voronec.algebra.matrices import determinant
from voronec.algebra.pieces import SpacePiece, pieces_of
from voronec.algebra.points import sample_evaluable
from voronec.algebra.precision import PROOF, SHARP
from voronec.algebra.rank import independent_rows, proved_rank
from voronec.algebra.roots import known_sign
from voronec.algebra.tape import Tape
from voronec.algebra.terms import atoms
from voronec.algebra.verdicts import Verdict
from voronec.equations.vector_field import VectorField
from voronec.errors import EngineLimit, quote

POINTS = 6
"""At how many points of a piece a rank is looked at."""
LARGEST = 4
"""The size of the largest minor of which factors that hold parameters alone are looked for."""
MOST_SIGNS = 3
"""Of so many signs in one factor all 27 choices are looked at."""

Rows = list[list[Any]]
Sides = frozenset[tuple[Any, int]]


def where_independent(
    verdict: Verdict,
    field: VectorField,
    functions: Sequence[Any],
    variables: Sequence[Any],
    bound: Sequence[Any],
    rank: int,
) -> Verdict:
    """A proof that needs ``rank`` of some functions of variables to be independent where relations
    ``bound`` these."""

    def slopes(exprs: Sequence[Any]) -> Rows:
        return [[f.diff(x) for x in variables] for f in (*bound, *exprs)]

    doubt = f"at the points tried fewer than {rank} of the functions are independent"
    return where_of_rank(verdict, field, functions, slopes, max(rank, 0) + len(bound), doubt)


def where_nonzero(verdict: Verdict, field: VectorField, name: str, function: Any) -> Verdict:
    """A proof that needs a function not to vanish but on hypersurfaces, as a density."""
    doubt = f"whether {name} vanishes everywhere is open"
    return where_of_rank(verdict, field, [function], lambda exprs: [[*exprs]], 1, doubt)


def where_of_one_sign(verdict: Verdict, field: VectorField, name: str, function: Any) -> Verdict:
    """A proof that needs a function to keep its sign, as a density, beside the zeros and poles at
    which it may change, and at which the equations have values."""
    if not verdict.proved:
        return verdict
    moving, det = {*field.variables, field.time}, field.determinant
    known = field.hypotheses if det is None else (*field.hypotheses, det > 0)
    try:
        powers = product_of(function, tuple(field.relations)).powers.items()
    except EngineLimit:
        return verdict.where(f"{name} != 0")
    signed = [h for h, k in powers if k % 2 and h.free_symbols & moving and not _is_root(h)]
    # what is positive term by term may no longer be so where relations have been put in
    odd = [h for h in signed if not (_keeps_sign(h, known) or _keeps_sign(h, field.conditions))]

    def has_zero(h: Any, *held: Any) -> bool:
        return any(sample_evaluable(Tape([h, *held]), (*known, h), SHARP, count=1))

    # where no zero is found at all one may be hidden: that none is found proves nothing
    told = [h for h in odd if has_zero(h, *field.entries) or not has_zero(h)]
    return verdict.where(*(f"{quote(field.bridge.outward(h))} != 0" for h in told))


def _keeps_sign(h: Any, known: Sequence[Any]) -> bool:
    """Whether it is proved to have one sign, whatever the values of the signs that it holds."""
    held = sorted(atoms([h], se.sign), key=str)
    sides = product(map(se.Integer, (-1, 0, 1)), repeat=len(held))
    pieces = (h.xreplace(dict(zip(held, side, strict=True))) for side in sides)
    return len(held) <= MOST_SIGNS and {known_sign(p, known) for p in pieces} in ({1}, {-1})


def _is_root(h: Any) -> bool:
    """Whether it is a power that is no whole one: it has no other sign where it is real."""
    return isinstance(h, se.Pow) and not isinstance(h.args[1], se.Integer)


def where_of_rank(
    verdict: Verdict,
    field: VectorField,
    functions: Sequence[Any],
    rows: Callable[[Sequence[Any]], Rows],
    rank: int,
    doubt: str,
) -> Verdict:
    """A proof that needs the matrix that ``rows`` makes of functions to have a rank, where it has
    it; undecided with the words of ``doubt`` where it has it nowhere."""
    if not verdict.proved or rank < 1:
        return verdict
    need = _Need(field, rows, rank)
    try:
        pieces = pieces_of(functions, tuple(field.relations))
        good = [p for p in pieces if need.is_met(p)]
        lacking = _join_pieces(frozenset(p.sides) for p in pieces if p not in good)
        if frozenset() in lacking:
            return Verdict("undecided", doubt)
        letters = dict.fromkeys(h for p in good for h in need.letters(p))
    except EngineLimit as limit:
        return Verdict("undecided", f"{doubt}: {limit}")
    write = field.bridge.outward
    words = [
        " or ".join(sorted(f"{quote(write(h))} {'<>'[s < 0]} 0" for h, s in b)) for b in lacking
    ]
    return verdict.where(*words, *(f"{quote(write(h))} != 0" for h in letters))


def _join_pieces(lacking: Iterable[Sides]) -> list[Sides]:
    """Pieces as few as possible, two that differ in one side joined."""
    pieces = list(dict.fromkeys(lacking))
    while True:
        pair = next(((a, b, a & b) for a in pieces for b in pieces if _is_split(a, b)), None)
        if pair is None:
            return pieces
        a, b, both = pair
        pieces = list(dict.fromkeys([*(c for c in pieces if c not in (a, b)), both]))


def _is_split(a: Sides, b: Sides) -> bool:
    """Whether two pieces lie on the sides of one cut."""
    (*one,), (*other,) = a - b, b - a
    return len(one) == len(other) == 1 and one[0] == (other[0][0], -other[0][1])


@dataclass(frozen=True)
class _Need:
    """A rank that a matrix needs on the states of a field."""

    field: VectorField
    rows: Callable[[Sequence[Any]], Rows]
    rank: int

    def is_met(self, piece: SpacePiece) -> bool:
        """Whether it is met on a piece, or the piece is empty."""
        rows = self._rows(piece)
        there = {h: h > 0 if s > 0 else h < 0 for h, s in piece.sides}
        ranks = self._ranks(rows, (*self.field.hypotheses, *there.values()), [*there])
        if ranks:
            return min(ranks) >= self.rank
        if any(known_sign(h, self.field.hypotheses) == -s for h, s in piece.sides):
            return True
        # no state was found: what is analytic may have the rank beyond the piece, and so on it
        ranks = self._ranks(rows, self.field.hypotheses)
        return bool(ranks) and min(ranks) >= self.rank

    def _rows(self, piece: SpacePiece) -> Rows:
        """The matrix on a piece; a floor is a number between the places where it steps, but there
        are pieces without end."""
        numbers = {n: se.Dummy() for e in piece.exprs for n in e.atoms(se.floor)}
        rows = self.rows([e.xreplace(numbers) for e in piece.exprs])
        held = set[Any]().union(*(e.free_symbols for row in rows for e in row))
        if not held.isdisjoint(numbers.values()):
            raise EngineLimit("floors cut the space into pieces without end")
        return rows

    def _ranks(self, rows: Rows, known: Sequence[Any], held: Sequence[Any] = ()) -> list[int]:
        """The rank at some points with values of what conditions hold, too."""
        ranks, width, size = list[int](), len(rows[0]), sum(map(len, rows))
        tape = Tape([*(e for row in rows for e in row), *held])
        for bits in (SHARP, PROOF):
            samples = sample_evaluable(tape, known, bits, count=POINTS)
            tables = ([v[i : i + width] for i in range(0, size, width)] for _, v in samples)
            ranks = [proved_rank(table, bits) for table in tables]
            if not ranks or min(ranks) >= self.rank:
                break
        return ranks

    def letters(self, piece: SpacePiece) -> list[Any]:
        """Functions of parameters alone of which it is not known that they do not vanish, and where
        the rank is less: factors of a minor, or of an entry where that is too large."""
        moving = {*self.field.variables, self.field.time, self.field.determinant}
        rows = self._rows(piece)
        entries = [e for row in rows for e in row if not e.free_symbols <= moving]
        if not entries:
            return []
        try:
            products = [self._minor(rows)] if self.rank <= LARGEST else entries
            factors = [product_of(e, tuple(self.field.relations)).powers.items() for e in products]
        except EngineLimit:
            return []
        powers = dict.fromkeys(h for items in factors for h, k in items if k > 0)
        still = [h for h in powers if moving.isdisjoint(h.free_symbols)]
        known = self.field.hypotheses
        open_ones = [h for h in still if not known_sign(h, known, strict=True)]
        full, held = self.rank, self.field.entries  # the equations may have no values there
        ranks = {h: self._ranks(rows, (*known, h), [h, *held]) for h in open_ones}
        return [h for h in open_ones if max(ranks[h], default=full) < full]

    def _minor(self, rows: Rows) -> Any:
        """A minor of that rank, at a point."""
        width, known = len(rows[0]), self.field.hypotheses
        tape = Tape([e for row in rows for e in row])
        for _, v in sample_evaluable(tape, known, SHARP, count=1):
            table = [v[i : i + width] for i in range(0, len(v), width)]
            chosen = independent_rows(table, SHARP)[: self.rank]
            across = [[table[i][j] for i in chosen] for j in range(width)]
            columns = independent_rows(across, SHARP)
            return determinant([[rows[i][j] for j in columns] for i in chosen])
        raise EngineLimit("no point was found")
