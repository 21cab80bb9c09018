"""Equations in the form for people: the shortest of several that are proved equal.

A draft is equations that vanish, rates of coordinates, and names with what they stand for.  Moves
lead from a draft to another that says the same: an identity of sines, a relation, the rate of a
coordinate written by its own letter, a name for what occurs often.  A move is made where fewer
characters are printed, until none is left or the budget, in terms that are arranged, is spent.
What comes out is put back into the equations and proved by the exact algebra; what is not proved is
not used.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from itertools import chain, combinations
from textwrap import wrap
from typing import TYPE_CHECKING, Any, NamedTuple

import symengine as se

from voronec.algebra.bracket_depth import BracketDepth
from voronec.algebra.laurent import (
    ACCELERATION,
    COORDINATE,
    PARAMETER,
    VELOCITY,
    Alphabet,
    Factor,
    LetterProduct,
    Monomial,
    Rational,
    Sum,
    Terms,
    add,
    divide,
    mul,
    negate,
    over,
    times,
)
from voronec.algebra.roots import ring_over
from voronec.algebra.symbols import plain_name
from voronec.algebra.typeset import caret_text, latex_of, symbol_latex
from voronec.equations.vector_field import solved_form
from voronec.errors import EngineLimit

if TYPE_CHECKING:
    from voronec.equations.derivation import FirstOrderForm
    from voronec.equations.derived_equations import DerivedEquations

WIDTH = 100
"""Characters of a line of text."""
COLUMN = 56
"""Characters of a line of LaTeX that fits a column."""
LONGEST_LEFT_SIDE = 32
"""How long a left side may be for others to be aligned with it."""
BRACKETS = 4
"""How deep in brackets an equation may be broken."""
STAYS = "\N{NO-BREAK SPACE}"
WORDS_STAY: Any = {"break_long_words": False, "break_on_hyphens": False}
ONE = 1
TRIGONOMETRIC = (se.sin, se.cos, se.tan, se.cot)
LONG_SUM = 200
"""Equations of more terms keep the brackets of the exact form."""
MOST = 4000
"""Terms of one equation, at most."""
BUDGET = 8_000
"""How many terms may be arranged on the way from one draft to the shortest form."""
PROOF = 600_000
"""Work of the proof of one equation."""
GAIN = 4
"""Characters that a name must save: who reads has to look it up."""
TRIES = 6
"""Names that are tried at once, those first that seem to save most."""
CONSTANTS, MOTIONS = "K L N P Q S U W Z A B C F H".split(), "D E F G H T Y X V U".split()
ANGLES = "delta epsilon eta zeta xi".split()


class Draft(NamedTuple):
    """Equations that vanish, those of a form, rates of coordinates, and names."""

    form: FirstOrderForm
    rows: tuple[Terms, ...]
    rates: tuple[tuple[int, Terms], ...]
    names: tuple[tuple[int, Terms], ...] = ()


class EquationRow(NamedTuple):
    """An equation as it is printed, and what it was multiplied by."""

    left: Sum
    right: Sum
    number: Rational
    factor: Monomial


class Rule(NamedTuple):
    """A sum that equals another; or, for ``head``, a monomial."""

    terms: Terms
    value: Terms
    head: bool
    kinematic: bool = False


@dataclass(frozen=True)
class ReadableEquations:
    """The form for people of some equations.

    ``rates`` are the motion of the coordinates, ``rows`` the equations of motion, ``names`` what
    stands below ``where``: left and right sides in the letters of ``alphabet``.
    """

    alphabet: Alphabet
    rates: tuple[tuple[Sum, Sum], ...]
    rows: tuple[EquationRow, ...]
    names: tuple[tuple[Sum, Sum], ...]

    @property
    def pairs(self) -> Iterator[tuple[Sum, Sum]]:
        """Everything that is printed: rates, equations of motion, what is named."""
        yield from self.rates
        yield from ((row.left, row.right) for row in self.rows)
        yield from self.names

    @property
    def length(self) -> int:
        """Characters of all equations and of what is named, blanks aside."""
        return sum(self.alphabet.length(a) + self.alphabet.length(b) + 1 for a, b in self.pairs)

    @property
    def heading(self) -> str:
        """What the equations of motion were cleared of: it changes with time, and is not zero where
        they determine the accelerations."""
        letters = self.alphabet.letters
        moving = [i for row in self.rows for i, _ in row.factor if letters[i].moves]
        texts = dict.fromkeys(map(self.alphabet.letter_text, moving))
        cleared = [text if len(text) < LONGEST_LEFT_SIDE else "a denominator" for text in texts]
        return "equations of motion" + (f", cleared of {', '.join(cleared)}" if cleared else "")

    def lines(self, width: int) -> list[str]:
        """Text in lines of some width."""
        parts = [("motion of the coordinates", self.rates)] if self.rates else []
        parts.append((self.heading, tuple((row.left, row.right) for row in self.rows)))
        parts += [("where", self.names)] if self.names else []
        layout: list[str] = []
        for head, pairs in parts:
            texts = ((self.alphabet.text(a), self.alphabet.text(b)) for a, b in pairs)
            layout += ["", head, *equation_lines(texts, width)]
        return layout[1:]

    def latex(self, environment: str) -> str:
        """A LaTeX block: ``align``, or ``aligned`` inside of a formula."""
        rows: list[str] = []
        more = r" \nonumber" if environment == "align" else ""
        for place, (left, right) in enumerate(self.pairs):
            first = place == len(self.rates) + len(self.rows)
            begin = (r"\text{where}\quad " if first else "") + self.alphabet.latex(left)
            sides = self._in_columns(right, len(begin))
            rows += [f"{begin} &= {sides[0]}", *(rf"&\quad {side}" for side in sides[1:])]
            for k in range(len(rows) - len(sides), len(rows) - 1):
                rows[k] += more
        body = " \\\\\n  ".join(rows)
        return f"\\begin{{{environment}}}\n  {body}\n\\end{{{environment}}}"

    def _in_columns(self, parts: Sum, begun: int) -> list[str]:
        """The terms of a sum in lines that fit a column."""
        lines, room = [""], COLUMN - begun
        for product in self.alphabet.in_order(parts) or [LetterProduct(0, ())]:
            text, width = self.alphabet.latex((product,)), self.alphabet.length((product,))
            if lines[-1] and room < width:
                lines.append("")
                room = COLUMN
            room -= width
            if len(lines) > 1 or lines[-1]:  # a sign between blanks
                text = f" - {text[1:]}" if text.startswith("-") else f" + {text}"
            lines[-1] += text
        return [*map(str.strip, lines)]


def equation_rows(pairs: Iterable[tuple[str, str]]) -> list[str]:
    """Left and right sides as lines, aligned but for left sides that are long."""
    sides = [*pairs]
    wide = max((len(left) for left, _ in sides if len(left) <= LONGEST_LEFT_SIDE), default=0)
    return [f"  {left.ljust(wide)} = {right}" for left, right in sides]


def equation_lines(pairs: Iterable[tuple[str, str]], width: int) -> list[str]:
    """Equations in rows that go on in further lines."""
    return [line for row in equation_rows(pairs) for line in break_lines(row, width)]


def break_lines(row: str, width: int) -> list[str]:
    """An equation in lines that end before a sign: one outside of brackets and functions, if that
    will do."""
    if len(row) <= width:
        return [row]
    for depth in range(BRACKETS):
        bound, open_ = [], list[bool]()
        for piece in re.split(r"(\w*\(|\)| [+-] | = )", row):
            if piece.endswith("("):
                open_.append(len(piece) > 1)
            elif piece == ")":
                open_.pop()
            sign = piece in (" + ", " - ", " = ")
            kept = any(open_) or depth < len(open_) < BRACKETS
            text = f"{STAYS if kept else ' '}{piece[1]}{STAYS}" if sign else piece
            bound.append(text.replace(", ", f",{STAYS}") if any(open_) else text)
        lines = wrap("".join(bound), width, subsequent_indent=" " * 6, **WORDS_STAY)
        if all(len(line) <= width for line in lines):
            break
    return [line.replace(STAYS, " ") for line in lines]


def readable(equations: DerivedEquations) -> ReadableEquations:
    """The form for people, kept with the equations."""
    return _search(equations).shortest


def short_texts(equations: DerivedEquations, given: dict[str, Any]) -> list[list[tuple[str, str]]]:
    """Expressions beside the equations, such as the curvature, with what they are called, in texts
    that use the names of the equations; then what is named in them alone."""
    return _search(equations).arrange_rows(given)


def _search(equations: DerivedEquations) -> FormSearch:
    return equations.memo.once("readable", lambda: FormSearch(equations))


@dataclass
class FormSearch:
    """The way from the exact form to the form for people."""

    equations: DerivedEquations
    alphabet: Alphabet = field(init=False)
    printed: dict[Any, tuple[int, EquationRow]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        form = self.form = self.equations.best.form
        self.dots = form.velocity_symbols or tuple(se.Symbol(f"{q}dot") for q in form.coordinates)
        self.accelerations = [se.Symbol(f"d{v}/dt") for v in form.velocities]
        self.texts = {
            a: _dot(str(v)) for a, v in zip(self.accelerations, form.velocities, strict=True)
        }
        self.ranks: dict[Any, tuple[int, int]] = {}
        for kind, things in (
            (ACCELERATION, self.accelerations),
            (VELOCITY, (*form.velocities, *self.dots)),
            (COORDINATE, (form.time, *form.inputs, *form.coordinates)),
            (PARAMETER, form.parameters),
        ):
            for place, thing in enumerate(things):
                self.ranks.setdefault(thing, (kind, place))
        self.alphabet = Alphabet(self._rank, self._text, self._latex, MOST)
        names = {
            str(s) for e in (*form.expressions, *self.ranks) for s in se.sympify(e).free_symbols
        }
        self.taken = names | {plain_name(s) for s in self.equations.system.known_symbols()}
        self.taken |= {f"{name}dot" for name in self.taken} | {"t"}

    def _rank(self, atom: Any) -> tuple[int, int]:
        if atom in self.ranks:
            return self.ranks[atom]
        inside = atom.xreplace(self.alphabet.angles).free_symbols
        places = [self.ranks.get(s, (COORDINATE, 0)) for s in inside]
        highest = max(places, default=(PARAMETER, 0))
        if highest[0] < COORDINATE:
            return PARAMETER + 1, len(self.alphabet.letters)
        return (COORDINATE + 1 if highest[0] < VELOCITY else highest[0], len(self.alphabet.letters))

    def _text(self, atom: Any) -> str:
        if isinstance(atom, TRIGONOMETRIC):
            angle = self.alphabet.arrange(self._angle(atom.args[0]))
            return f"{type(atom).__name__}({self.alphabet.text(angle)})"
        if atom in self.alphabet.angles:
            return str(atom)
        return self.texts.get(atom) or caret_text(self.equations.bridge.outward(atom))

    def _angle(self, angle: Any) -> Terms:
        """An angle as it is written: a name stays, what merely stands for a sum does not."""
        if str(angle).startswith("angle "):
            angle = self.alphabet.angles[angle]
        return self.alphabet.read(angle)

    def _latex(self, atom: Any) -> str:
        if isinstance(atom, TRIGONOMETRIC):
            angle = self.alphabet.arrange(self._angle(atom.args[0]))
            inner = self.alphabet.latex(angle)
            plain = len(angle) == 1 and angle[0].number == 1 and len(angle[0].factors) == 1
            return rf"\{type(atom).__name__}" + (
                f"({inner})" if not plain else inner if inner[0] == "\\" else f" {inner}"
            )
        if not atom.is_Symbol:
            system = self.equations.system
            outside = self.equations.bridge.outward(atom)
            return latex_of(outside, system.coordinates, system.velocities)
        name, dots = self.texts.get(atom, str(atom)), 0
        if atom in self.texts and name.endswith("ddot"):
            name, dots = name[:-4], 2
        elif atom in self.texts or atom in self.dots:
            name, dots = name[:-3], 1
        text = symbol_latex(name)
        if dots and text.startswith("\\mathrm"):  # a dot takes one letter, or what is in braces
            text = f"{{{text}}}"
        return text if not dots else rf"\{'d' * dots}ot" + (" " * text[0].isalpha()) + text

    # -- drafts -------------------------------------------------------------------------------

    @cached_property
    def shortest(self) -> ReadableEquations:
        """The shortest draft that is proved."""
        self.alphabet.whole = True
        plain = self._draft(self.form)
        forms = [(self.finish(draft), draft) for draft in self._shorten(plain)]
        forms.sort(key=lambda one: one[0].length)
        proved = (form for form, draft in forms if self.proved(form, draft))
        return next(proved, None) or self.finish(plain)

    def _draft(self, form: FirstOrderForm) -> Draft:
        read = self.alphabet.read
        rows = []
        for row, force in zip(form.mass, form.force, strict=True):
            terms = [mul(read(e), read(a)) for e, a in zip(row, self.accelerations, strict=True)]
            rows.append(add(*terms, mul({(): -ONE}, read(force))))
        rates = [
            (self.alphabet.index(dot), read(rate))
            for dot, rate in zip(self.dots, form.rates, strict=True)
            if dot != rate
        ]
        return Draft(form, tuple(rows), tuple(rates))

    def _shorten(self, plain: Draft) -> Iterator[Draft]:
        """The exact form written out and as it stands, each after all moves."""
        self.alphabet.whole = spent = False
        try:
            spread = [self._draft(self.form)]
            if (solved := solved_form(self.equations)) is not None:
                spread.append(self._draft(solved))
            for draft in sorted(spread, key=_size):
                long = _size(draft) > LONG_SUM
                if not long:
                    yield self._improve(draft)
                spent |= long or self._spend()
            if not spent:  # nothing shorter is found in the brackets
                return
        except EngineLimit:
            pass
        yield self._improve(plain)

    def _spend(self) -> bool:
        return self.alphabet.work > self.alphabet.limit

    def _improve(self, draft: Draft) -> Draft:
        """A draft after all moves that make it shorter."""
        self.alphabet.work, self.alphabet.limit = 0, BUDGET
        length, moved = self.length(draft), True
        moves = self._angles, self._names, self._identities, self._monomials
        while moved and not self._spend():
            moved = False
            for other, least in chain.from_iterable(move(draft) for move in moves):
                if self._spend():
                    break
                size = self.length(other)
                if size <= length - least:
                    draft, length, moved = other, size, True
                    break
        return draft

    # -- length -------------------------------------------------------------------------------

    def length(self, draft: Draft) -> int:
        """The characters of what is printed."""
        total = sum(self.row(*row)[0] for row in enumerate(draft.rows))
        for letter, terms in (*draft.rates, *draft.names):
            total += len(self.alphabet.letter_text(letter)) + 1 + self._length(terms)
        return total

    def _length(self, terms: Terms) -> int:
        return self.alphabet.length(self.alphabet.arrange(terms))

    def row(self, place: int, terms: Terms) -> tuple[int, EquationRow]:
        """The equation of that place as it is printed, multiplied by what makes it short."""
        key = place, frozenset(terms.items())
        if key not in self.printed:
            self.printed[key] = self._row(place, terms)
        return self.printed[key]

    def _row(self, place: int, terms: Terms) -> tuple[int, EquationRow]:
        alphabet = self.alphabet
        number, common, _ = alphabet.primitive(terms)
        common = tuple(p for p in common if alphabet.letters[p[0]].rank[0] < ACCELERATION)
        rest = {times(m, common, -1): over(c, number) for m, c in terms.items()}
        below = alphabet.below(rest)
        factor = times(common, below)
        rest = {times(m, below, -1): c for m, c in rest.items()}
        best = self._sides(place, rest)
        led = [dict(m) for m in rest if self._leads(m)]
        for i, _ in below if len(rest) <= LONG_SUM else ():
            most = min if alphabet.letters[i].moves else max
            for _ in range(int(most((m.get(i, 0) for m in led), default=0))):
                other = {times(m, ((i, 1),), -1): c for m, c in rest.items()}
                if len(rest) > 2 * TRIES and self._flat_length(other) > self._flat_length(rest):
                    break
                sides = self._sides(place, other)
                whole = all(m.get(i, 0) > 0 for m in led)
                if sides[0] > best[0] - (1 if whole else GAIN):
                    break
                rest, best, factor = other, sides, times(factor, ((i, 1),))
        length, left, right, sign = best
        return length, EquationRow(left, right, over(sign, number), times((), factor, -1))

    def _sides(self, place: int, rest: Terms) -> tuple[int, Sum, Sum, int]:
        """Accelerations on the left, its own with a positive mass, everything else on the right."""
        left = {m: c for m, c in rest.items() if self._leads(m)}
        right = {m: -c for m, c in rest.items() if m not in left}
        letters = self.alphabet.letters
        leading = [m for m in left if any(letters[i].rank == (ACCELERATION, place) for i, _ in m)]
        still = [
            m
            for m in leading
            if not any(COORDINATE <= letters[i].rank[0] < ACCELERATION for i, _ in m)
        ]
        sign = -1 if sum(1 if left[m] > 0 else -1 for m in still or leading or left) < 0 else 1
        left, right = ({m: sign * c for m, c in p.items()} for p in (left, right))
        sides = [self.alphabet.arrange(p) for p in (left, right)]
        if any(len(self.alphabet.text((product,))) > WIDTH - 8 for product in sides[0]):
            each: dict[int, Terms] = {}
            for m, c in left.items():
                each.setdefault(next(i for i, _ in m if self._leads(((i, 1),))), {})[m] = c
            sides[0] = tuple(p for terms in each.values() for p in self.alphabet.arrange(terms))
        return sum(map(self.alphabet.length, sides)) + 1, sides[0], sides[1], sign

    def _leads(self, m: Monomial) -> bool:
        return any(self.alphabet.letters[i].rank[0] == ACCELERATION for i, _ in m)

    # -- identities ---------------------------------------------------------------------------

    def _identities(self, draft: Draft) -> Iterator[tuple[Draft, int]]:
        """Drafts with an identity used wherever that makes a sum shorter."""
        for rule in [*self._rules(draft)]:
            rewritten = self._rewrite(draft, lambda terms: self._shorter(rule, terms), {})  # noqa: B023
            if rule.kinematic:
                rewritten = rewritten._replace(rates=draft.rates)
            if rewritten != draft:
                yield rewritten, 1

    def _shorter(self, rule: Rule, terms: Terms) -> Terms:
        changed = self.apply_rule(rule, terms)
        return changed if self._flat_length(changed) < self._flat_length(terms) else terms

    def _flat_length(self, terms: Terms) -> int:
        """About how many characters a sum has where it is written out."""
        text = self.alphabet.letter_text
        return sum(2 + sum(len(text(i)) + 2 * (e != 1) for i, e in m) for m in terms)

    def apply_rule(self, rule: Rule, terms: Terms) -> Terms:
        """A sum in which the rule has put its value for what it names."""
        if not rule.head:
            quotient, rest = divide(terms, rule.terms)
            return add(mul(quotient, rule.value), rest) if quotient else terms
        (head,) = rule.terms
        for _ in range(3):
            divisible = [m for m in terms if _divides(head, m)]
            if not divisible:
                break
            rest = {m: c for m, c in terms.items() if m not in divisible}
            terms = add(rest, *(mul({times(m, head, -1): terms[m]}, rule.value) for m in divisible))
        return terms

    def _rules(self, draft: Draft) -> Iterator[Rule]:
        letters, read = self.alphabet.letters, self.alphabet.read
        used = {i for terms in draft.rows for m in terms for i, _ in m}
        meanings = (letters[i].meaning for i in sorted(used))
        angles = [*dict.fromkeys(m.args[0] for m in meanings if isinstance(m, se.sin | se.cos))]
        for angle in angles:
            s, c = (read(f(angle)) for f in (se.sin, se.cos))
            yield Rule(mul(s, s), add({(): ONE}, mul({(): -ONE}, mul(c, c))), True)
            yield Rule(mul(c, c), add({(): ONE}, mul({(): -ONE}, mul(s, s))), True)
            yield Rule(add(mul(s, s), mul(c, c)), {(): ONE}, False)
        for relation in self.form.relations:
            yield from self._heads(read(relation), lambda r: r >= COORDINATE)
        for letter, rate in draft.rates:
            yield from self._heads(
                add(rate, {((letter, 1),): -ONE}), lambda r: r >= VELOCITY, letter
            )

    def _heads(self, relation: Terms, moves: Any, kept: int | None = None) -> Iterator[Rule]:
        """A relation solved for what moves in each of its terms."""
        letters = self.alphabet.letters
        for m, c in relation.items():
            head = tuple((i, e) for i, e in m if letters[i].rank[0] >= COORDINATE)
            if any(i == kept for i, _ in m) or not any(moves(letters[i].rank[0]) for i, _ in head):
                continue
            rest = {n: d for n, d in relation.items() if n != m}
            value = mul({times(head, m, -1): over(-1, c)}, rest)
            yield Rule({head: ONE}, value, True, kept is not None)

    # -- names --------------------------------------------------------------------------------

    def _names(self, draft: Draft) -> Iterator[tuple[Draft, int]]:
        """Drafts with a name for a sum that stands in brackets, or is divided by."""
        counts: Counter[Any] = Counter()
        sums: dict[Any, Terms] = {}
        for terms in self._brackets(draft):
            _, _, rest = self.alphabet.primitive(terms)
            if len(rest) > 1 and not any(map(self._leads, rest)):
                key = frozenset(rest.items())
                sums[key] = rest
                counts[key] += 1
        length = {key: self._length(sums[key]) for key, count in counts.items() if count > 1}
        for key in sorted(length, key=lambda key: (-counts[key] * length[key], length[key]))[
            :TRIES
        ]:
            yield self._with_name(draft, sums[key]), GAIN

    def _brackets(self, draft: Draft) -> Iterator[Terms]:
        """The sums in brackets, as often as they stand."""
        for product in self._products(draft):
            for base, _ in product.factors:
                if not isinstance(base, int):
                    yield self._spread(base)
                elif (
                    inner := self.alphabet.letters[base].terms
                ) and base not in self.alphabet.named:
                    yield inner

    def _spread(self, parts: Sum) -> Terms:
        total: Terms = {}
        for product in parts:
            terms: Terms = {(): product.number}
            for base, e in product.factors:
                if not isinstance(base, int) and (not isinstance(e, int) or e < 0):
                    base = self.alphabet.index(None, self._spread(base))
                if isinstance(base, int):
                    terms = mul(terms, {((base, e),): ONE})
                else:
                    for _ in range(e):
                        terms = mul(terms, self._spread(base))
            total = add(total, terms)
        return total

    def _with_name(self, draft: Draft, terms: Terms) -> Draft:
        letter = self._name_parts(terms, (i for i, _ in draft.names))

        def change(sum_: Terms) -> Terms:
            if len(terms) > 1:
                quotient, rest = divide(sum_, terms)
                return add(mul(quotient, {((letter, 1),): ONE}), rest) if quotient else sum_
            ((head, _),) = terms.items()
            return {
                times(times(m, head, -1), ((letter, 1),)) if _divides(head, m) else m: c
                for m, c in sum_.items()
            }

        rewritten = self._rewrite(draft, change, {})
        return rewritten._replace(names=(*rewritten.names, (letter, terms)))

    def _rewrite(self, draft: Draft, change: Any, swaps: dict[int, int]) -> Draft:
        """A draft with all of its sums changed and letters swapped, inside of letters too."""
        alphabet, known = self.alphabet, dict(swaps)

        def whole(terms: Terms) -> Terms:
            changed = change(terms)
            if all(swap(i) == i for m in changed for i, _ in m):
                return changed
            return {times((), tuple((swap(i), e) for i, e in m)): c for m, c in changed.items()}

        def swap(i: int) -> int:
            if i not in known:
                inner = alphabet.letters[i].terms
                known[i] = i
                if inner is not None and i not in alphabet.named:
                    changed = whole(inner)
                    if changed == inner or not changed:
                        return i
                    ((m, c), *others) = changed.items()
                    if not others and c == 1 and len(m) == 1 and m[0][1] == 1:
                        known[i] = m[0][0]
                    else:
                        known[i] = alphabet.index(None, changed)
            return known[i]

        return Draft(
            draft.form,
            tuple(map(whole, draft.rows)),
            tuple((i, whole(rate)) for i, rate in draft.rates),
            tuple((i, whole(of)) for i, of in draft.names),
        )

    def _name_parts(self, terms: Terms, names: Iterable[int]) -> int:
        """A letter for a sum beside other names."""
        moving = any(self.alphabet.letters[i].moves for m in terms for i, _ in m)
        return self.alphabet.name(self._free(names, MOTIONS if moving else CONSTANTS), terms)

    def _free(self, names: Iterable[int], pool: Sequence[str]) -> str:
        used = self.taken | {*map(self.alphabet.letter_text, names)}
        longer = (f"{name}{i}" for i in range(1, 99) for name in pool)
        return next(name for name in (*pool, *longer) if name not in used)

    def _monomials(self, draft: Draft) -> Iterator[tuple[Draft, int]]:
        """Drafts with a name for factors that often stand together."""
        letters = self.alphabet.letters
        powers = [
            {
                (f.base, f.exponent)
                for f in product.factors
                if isinstance(f.base, int) and letters[f.base].rank[0] < VELOCITY
            }
            for product in self._products(draft)
        ]
        counts: Counter[Monomial] = Counter()
        for a, b in combinations(powers, 2):
            if len(both := a & b) > 1:
                counts[tuple(sorted(both))] += 1
        gains = {}
        for m, _ in counts.most_common(2 * TRIES):
            width = self._length({m: ONE})
            gains[m] = (sum(set(m) <= one for one in powers) - 1) * (width - 1) - 4
        for m in sorted((m for m in gains if gains[m] > GAIN), key=lambda m: -gains[m])[:TRIES]:
            yield self._with_name(draft, {m: ONE}), 5 * GAIN

    def _products(self, draft: Draft) -> Iterator[LetterProduct]:
        """The products that are printed."""
        sides = [side for row in enumerate(draft.rows) for side in self.row(*row)[1][:2]]
        sides += [self.alphabet.arrange(terms) for _, terms in (*draft.rates, *draft.names)]
        while sides:
            for product in sides.pop():
                yield product
                for base, _ in product.factors:
                    if not isinstance(base, int):
                        sides.append(base)
                    elif (inner := self.alphabet.letters[base].terms) and (
                        base not in self.alphabet.named
                    ):
                        sides.append(self.alphabet.arrange(inner))

    def _angles(self, draft: Draft) -> Iterator[tuple[Draft, int]]:
        """Drafts with a name for a sum of angles."""
        letters = self.alphabet.letters
        every = (*draft.rows, *(t for _, t in draft.rates), *(t for _, t in draft.names))
        used = sorted({i for terms in every for m in terms for i, _ in m})
        meanings, known = [letters[i].meaning for i in used], self.alphabet.angles
        angles = {str(m.args[0]): m.args[0] for m in meanings if isinstance(m, TRIGONOMETRIC)}
        for stand_in in (angles[a] for a in sorted(angles) if a.startswith("angle ")):
            name = se.Symbol(self._free((i for i, _ in draft.names), ANGLES))
            known[name], self.ranks[name] = known[stand_in], (COORDINATE, len(known) + 99)
            swaps = {
                i: self.alphabet.index(meaning.func(name))
                for i, meaning in zip(used, meanings, strict=True)
                if isinstance(meaning, TRIGONOMETRIC) and meaning.args[0] == stand_in
            }
            rewritten = self._rewrite(draft, _same, swaps)
            letter = self.alphabet.index(name)
            terms = self.alphabet.read(known[stand_in])
            yield rewritten._replace(names=(*rewritten.names, (letter, terms))), GAIN

    # -- proof --------------------------------------------------------------------------------

    def proved(self, printed: ReadableEquations, draft: Draft) -> bool:
        """Whether every equation, names put in, is the exact one times its factor, and every rate
        the exact rate."""
        try:
            return all(self._vanishes(e) for e in self._differences(printed, draft))
        except EngineLimit:
            return False

    def _differences(self, printed: ReadableEquations, draft: Draft) -> Iterator[Any]:
        form, spread = draft.form, self._spread
        show = lambda parts: self.expression(spread(parts))  # noqa: E731
        yield from (show(name) - show(meaning) for name, meaning in printed.names)
        if form is not self.form:  # mass^-1 force
            for row, force in zip(self.form.mass, self.form.force, strict=True):
                yield se.Add(*(e * a for e, a in zip(row, form.force, strict=True))) - force
        for row, mass, force in zip(printed.rows, form.mass, form.force, strict=True):
            factor = self.expression({row.factor: row.number})
            exact = se.Add(*(e * a for e, a in zip(mass, self.accelerations, strict=True))) - force
            yield (show(row.left) - show(row.right)) / factor - exact
        given = dict(zip(self.dots, form.rates, strict=True))
        for dot, rate in printed.rates:
            yield (
                self.alphabet.expression(spread(rate))
                - given[self.alphabet.expression(spread(dot))]
            )

    def expression(self, terms: Terms) -> Any:
        """A sum as an expression, rates and names replaced by what they stand for."""
        return self.alphabet.expression(terms).xreplace(
            dict(zip(self.dots, self.form.rates, strict=True))
        )

    def _vanishes(self, expr: Any) -> bool:
        if expr == 0:
            return True
        ring = ring_over([expr], self.form.relations, PROOF)
        return bool(ring.fraction(expr).num == 0)

    def finish(self, draft: Draft) -> ReadableEquations:
        """The draft as it is printed."""
        arrange, rows = self.alphabet.arrange, [self.row(*row)[1] for row in enumerate(draft.rows)]
        nesting = self.depth_of((i, arrange(terms)) for i, terms in draft.names)
        sides = [arrange(terms) for _, terms in draft.rates]
        sides = nesting.fold([*sides, *(side for row in rows for side in row[:2])])
        names = tuple((_letter(i), nesting.definitions[i]) for i in nesting.read_in_order(sides))
        rates = tuple((_letter(i), sides.pop(0)) for i, _ in draft.rates)
        for k, row in enumerate(rows):
            left, right, number = sides[2 * k], sides[2 * k + 1], row.number
            if self.alphabet.text(left).startswith("-"):
                left, right, number = negate(left), negate(right), -number
            rows[k] = EquationRow(left, right, number, row.factor)
        return ReadableEquations(self.alphabet, rates, tuple(rows), names)

    def arrange_rows(self, given: dict[str, Any]) -> list[list[tuple[str, str]]]:
        """Expressions arranged as the equations are, and what is named in them alone."""
        with suppress(EngineLimit):
            if texts := self._proved_texts(given):
                return texts
        return [[(name, caret_text(e)) for name, e in given.items()], []]

    def _proved_texts(self, given: dict[str, Any]) -> list[list[tuple[str, str]]]:
        alphabet, letters = self.alphabet, self.alphabet.letters
        names = {name[0].factors[0].base: meaning for name, meaning in self.shortest.names}
        alphabet.whole, alphabet.work = True, 0
        exact = [self.equations.bridge.inward(e) for e in given.values()]
        draft = Draft(self.form, tuple(map(alphabet.read, exact)), ())
        named = {alphabet.angles[m]: m for i in names if (m := letters[i].meaning) is not None}
        swaps = {
            alphabet.index(f(a)): alphabet.index(f(named[e]))
            for a, e in [*alphabet.angles.items()]
            if e in named and a != named[e]
            for f in (se.sin, se.cos)
        }
        nesting = self.depth_of(names.items())
        rows = self._rewrite(draft, _same, swaps).rows
        sides = nesting.fold(map(alphabet.arrange, rows))
        proofs = (
            self.alphabet.expression(self._spread(a)) - b for a, b in zip(sides, exact, strict=True)
        )
        if not all(map(self._vanishes, proofs)):
            return []
        text, ordered = alphabet.text, nesting.read_in_order(sides)
        below = [(alphabet.letter_text(i), text(nesting.definitions[i])) for i in ordered]
        return [
            [*zip(given, map(text, sides), strict=True)],
            [pair for i, pair in zip(ordered, below, strict=True) if i not in names],
        ]

    def depth_of(self, names: Iterable[tuple[int, Sum]]) -> BracketDepth:
        """What names brackets that are nested too deeply, or do not fit a line."""
        fresh = lambda parts, others: self._name_parts(self._spread(parts), others)  # noqa: E731
        return BracketDepth(self.alphabet, fresh, WIDTH - 8, names)


def _letter(letter: int) -> Sum:
    return (LetterProduct(ONE, (Factor(letter, 1),)),)


def _dot(name: str) -> str:
    return f"{name[:-3]}ddot" if name.endswith("dot") else f"{name}dot"


def _size(draft: Draft) -> int:
    """How many terms equations have."""
    return sum(map(len, draft.rows))


def _same(terms: Terms) -> Terms:
    return terms


def _divides(head: Monomial, m: Monomial) -> bool:
    powers = dict(m)
    return all(e > 0 and powers.get(i, 0) >= e for i, e in head)
