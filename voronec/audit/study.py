r"""What the names of a paper mean in one derived system: the dictionary of an audit.

A key is a name as the paper spells it, ``u_1``, ``\vartheta``, ``\tilde{\mathbf T}``; a key with
index letters, ``a_{\nu i}``, stands for a family, and its value takes the values of the indices.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from operator import is_
from typing import Any

import sympy as sp

from voronec.algebra.memo import remember
from voronec.algebra.symbols import plain_name, time, velocity
from voronec.algebra.sympy_bridge import SymPyBridge
from voronec.audit.latex.nodes import Dot, Name, Node, Number, Product, Sum, Variation
from voronec.audit.latex.reader import read_name
from voronec.audit.latex.vocabulary import LatexVocabulary
from voronec.errors import DefinitionError


class UnknownRate(DefinitionError):
    """The study does not say how something changes in time: no fault of the print."""


@dataclass(frozen=True)
class Range:
    """A range of the parameters, written so that it is covered by positive numbers.

    ``values``: parameter -> expression in ``positive`` symbols, which run over all positive
    numbers, and ``real`` ones.  ``statement`` is the range in LaTeX, ``source`` the label of the
    formula by which the paper admits it, and ``letters`` says in LaTeX what symbols mean that
    the paper does not have: it is added where a method or a witness speaks of them.
    """

    name: str = ""
    statement: str = ""
    values: Mapping[sp.Expr, sp.Expr] = field(default_factory=dict)
    positive: tuple[sp.Symbol, ...] = ()
    real: tuple[sp.Symbol, ...] = ()
    source: str = ""
    letters: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Replacement:
    """What stands for what in SymPy's expressions and matrices: ``xreplace``, but what is shared
    within one, or stands in several, is worked on once."""

    rules: Mapping[sp.Expr, sp.Expr]

    def __call__(self, value: Any) -> Any:
        """The value with what stands for what; what is no expression stays what it is."""
        if not self.rules or not hasattr(value, "xreplace"):
            return value
        return value.applyfunc(self._in) if isinstance(value, sp.MatrixBase) else self._in(value)

    @cached_property
    def _known(self) -> dict[Any, Any]:
        return dict(self.rules)

    @remember("_known")
    def _in(self, expr: Any) -> Any:
        args = [self._in(part) for part in expr.args]
        return expr if all(map(is_, args, expr.args)) else expr.func(*args)


@dataclass(frozen=True)
class Motion:
    """How the symbols of a system change in time.

    ``rates``: symbol -> its time derivative, which may hold acceleration symbols.
    ``constrained``: velocity symbol -> its value on the constraints.
    ``accelerations``: acceleration symbol -> its value along the motion, where that is known; one
    that is its own value is free, as where forces are arbitrary.
    ``constants``: the symbols that do not change; None for all that have no rate, as long as they
    are no rates themselves.
    ``quasi``: the velocities of a frame, which are those of no coordinates.

    Raises ``DefinitionError`` for an acceleration that is the rate of no symbol.
    """

    rates: Mapping[sp.Expr, sp.Expr] = field(default_factory=dict)
    constrained: Mapping[sp.Expr, sp.Expr] = field(default_factory=dict)
    accelerations: Mapping[sp.Expr, sp.Expr] = field(default_factory=dict)
    constants: frozenset[sp.Expr] | None = None
    quasi: frozenset[sp.Expr] = frozenset()

    def __post_init__(self) -> None:
        known = set(self.rates.values())
        for acceleration in self.accelerations:
            if acceleration not in known:
                raise DefinitionError(
                    f"the acceleration '{acceleration}' is the rate of no symbol; give rates=..."
                )

    @classmethod
    def of(cls, eqs: Any, more: Mapping[sp.Expr, sp.Expr] | None = None) -> Motion:
        """The motion that derived equations define; ``more`` adds rates of further symbols.

        Its constants are the parameters of the system.
        """
        rates = dict(zip(eqs.coordinates, eqs.rates, strict=True))
        constrained = {velocity(q): rate for q, rate in rates.items() if velocity(q) != rate}
        rates |= {v: velocity(v) for v in eqs.velocities}
        constants = frozenset(p.symbol for p in eqs.system.parameters)
        quasi = frozenset(eqs.velocities) - {velocity(q) for q in eqs.coordinates}
        return cls(rates | dict(more or {}), constrained, constants=constants, quasi=quasi)

    def solved(self, eqs: Any) -> Motion:
        """The motion with the accelerations vdot = mass^-1 force."""
        values = eqs.mass.LUsolve(eqs.force)
        symbols = [velocity(v) for v in eqs.velocities]
        return replace(self, accelerations=dict(zip(symbols, values, strict=True)))

    def restrict(self, value: Any) -> Any:
        """A value on the constraints."""
        return self._onto_constraints(value)

    def along(self, value: Any) -> Any:
        """A value on the constraints and along the motion."""
        return self.restrict(self._onto_motion(value))

    @cached_property
    def _onto_constraints(self) -> Replacement:
        return Replacement(self.constrained)

    @cached_property
    def _onto_motion(self) -> Replacement:
        return Replacement(self.accelerations)

    def derivative(self, value: Any) -> Any:
        """The total time derivative, on the constraints.

        ``UnknownRate`` where it holds a symbol that neither has a rate nor is a constant.
        """
        value = self.restrict(value)
        if not self.rates:
            raise UnknownRate("no rates are known; give Study(..., motion=Motion(rates=...))")
        if isinstance(value, sp.MatrixBase):
            return value.applyfunc(self.derivative)
        self._require_rates(value)
        inside = self.bridge.inward(value)
        result = inside.diff(self.bridge.inward(time))
        for symbol, rate in self.rates.items():
            slope = inside.diff(self.bridge.inward(symbol))
            if slope != 0:
                result += slope * self.bridge.inward(rate)
        return self.restrict(self.bridge.outward(result))

    def _require_rates(self, value: sp.Expr) -> None:
        rateless = value.free_symbols - self.rates.keys() - {time}
        moving = set(self.rates.values()) if self.constants is None else rateless - self.constants
        for symbol in sorted(rateless & moving, key=str):
            raise UnknownRate(
                f"the rate of '{plain_name(symbol)}' is not known, and it is no parameter; give "
                "Motion.of(eqs, {symbol: rate}), or Motion(rates=..., constants=...)"
            )

    @cached_property
    def bridge(self) -> SymPyBridge:
        """Calculus is done inside, on shared graphs."""
        return SymPyBridge(self.rates)


@dataclass(frozen=True)
class Study:
    r"""A dictionary to a derived system.

    names
        LaTeX name -> SymPy expression, vector, function of the indices, or function.
    indices
        index letter -> largest value; all count from one.
    motion
        how symbols change in time.
    variations
        coordinate or velocity symbol -> its virtual variation.
    labelled
        heads of names whose superscript is a label.
    numbered
        heads of names whose superscript may be a Roman numeral, as in ``x^{II}``.
    functions
        heads of names that a parenthesis applies.
    primes
        whether a prime is a derivative by the time, and no part of a name.
    narrow_functions
        whether the paper writes ``\sin u v`` for (sin u) v throughout; else that is undecided.
    defined
        names that the paper itself defines, as trees; filled by the audit.
    given
        conditions in force: symbol -> expression.
    relations
        expressions that vanish, wherever two values are compared.
    domains
        LaTeX without spaces of a vector that may vary -> of the space in which it lies.
    positive
        expressions that are positive wherever the coordinates are good, as sin u.
    ranges
        ranges of the parameters, for inequalities; the first is the one that the paper has in mind.
    scope
        names of those of them of which the section itself speaks; all where there are none.  What
        holds there is proved, with a remark on the others.
    in_velocities
        quasi-velocity -> its value in coordinate velocities, for print.
    context
        whatever the functions of the paper's checks want to find here.
    letters
        letter that is not the paper's -> a sentence on what it means, for print.
    note
        in words, how general the derived system is.
    source
        in words, what the values of the names were made from: a system, kinematics, a theorem.
    """

    names: Mapping[str, Any]
    indices: Mapping[str, int] = field(default_factory=dict)
    motion: Motion = field(default_factory=Motion)
    variations: Mapping[sp.Expr, sp.Expr] = field(default_factory=dict)
    labelled: frozenset[str] = frozenset()
    numbered: frozenset[str] = frozenset()
    functions: frozenset[str] = frozenset()
    primes: bool = False
    narrow_functions: bool = False
    defined: Mapping[str, Node] = field(default_factory=dict)
    given: Mapping[sp.Expr, sp.Expr] = field(default_factory=dict)
    relations: tuple[sp.Expr, ...] = ()
    domains: Mapping[str, str] = field(default_factory=dict)
    positive: tuple[sp.Expr, ...] = ()
    ranges: tuple[Range, ...] = ()
    scope: tuple[str, ...] = ()
    in_velocities: Mapping[sp.Expr, sp.Expr] = field(default_factory=dict)
    context: Any = None
    letters: Mapping[str, str] = field(default_factory=dict)
    note: str = ""
    source: str = ""

    @property
    def origin(self) -> str:
        """``source``; without one, the derived system that the hooks find in ``context``."""
        eqs = getattr(self.context, "eqs", self.context)
        system = getattr(getattr(eqs, "system", None), "name", "")
        return self.source or (f"the equations derived for the system '{system}'" if system else "")

    @cached_property
    def table(self) -> dict[str, Any]:
        """Values by canonical key."""
        values: dict[str, Any] = {}
        spelled: dict[str, str] = {}
        for name, value in self.names.items():
            key = self.key(self.tree(name))
            if key in values:
                raise DefinitionError(
                    f"the names '{spelled[key]}' and '{name}' of the study are the same to the "
                    "reader; keep one of them"
                )
            values[key], spelled[key] = value, name
        return values

    def tree(self, name: str) -> Node:
        """The tree of a key of ``names``."""
        try:
            return read_name(name, LatexVocabulary(numbered=self.numbered))
        except DefinitionError as error:
            text = f"the name '{name}' of the study cannot be read: {error}"
            raise DefinitionError(text) from None

    def key(self, node: Node) -> str:
        """The canonical key of a name, with index letters replaced by ``#``."""
        return key_of(node, lambda index: "#" if self.is_index(index) else spell(index))

    def is_index(self, node: Node) -> bool:
        """Whether a node is an index letter of this study."""
        return isinstance(node, Name) and not node.sub and node.head in self.indices

    @cached_property
    def vocabulary(self) -> LatexVocabulary:
        """What the reader has to know of this dictionary."""
        heads = {k: _innermost(self.tree(k)).head for k in self.names}
        plain = {heads[k] for k, v in self.names.items() if callable(v)} & self.table.keys()
        return LatexVocabulary(
            self.functions | plain,
            self.labelled,
            self.numbered,
            primes=self.primes,
            narrow_functions=self.narrow_functions,
            variations="\\delta" not in heads.values(),
            differentials="d" not in heads.values(),
        )

    @cached_property
    def spelling(self) -> dict[Any, str]:
        """Symbols (and applied unknown functions) -> their LaTeX name in the paper."""
        spellings: dict[Any, str] = {}
        for name, value in self.names.items():
            for latex, entry in self._members(name, value):
                if isinstance(entry, (sp.Symbol, sp.core.function.AppliedUndef)):
                    spellings.setdefault(entry, latex)
        for symbol in [x for x in spellings if isinstance(x, sp.Symbol)]:
            for order in ("\\dot", "\\ddot"):
                dotted = velocity(symbol) if order == "\\dot" else velocity(velocity(symbol))
                spellings.setdefault(dotted, _dot_name(order, spellings[symbol]))
        return spellings

    def _members(self, name: str, value: Any) -> Iterator[tuple[str, Any]]:
        if not callable(value) or isinstance(value, sp.Basic):
            yield name, value
            return
        node = _innermost(self.tree(name))
        letters = [i.head for i in (*node.sub, *node.sup) if self.is_index(i)]
        for values in product(*(range(1, self.indices[x] + 1) for x in letters)):
            if letters:
                yield _with_values(name, letters, values), value(*values)

    def join(self, defined: Mapping[str, Node]) -> Study:
        """The study with names that the paper defines itself."""
        if all(self.defined.get(key) == node for key, node in defined.items()):
            return self  # with all that it has made of its names
        return replace(self, defined={**self.defined, **defined})


def spell(node: Node) -> str:
    """One spelling for each index expression."""
    if isinstance(node, Number):
        return node.text
    if isinstance(node, Name):
        marks = "".join(f"_{spell(i)}" for i in node.sub) + "".join(
            f"^{spell(i)}" for i in node.sup
        )
        return node.head + marks
    if isinstance(node, Sum):
        return "".join(("+" if s > 0 else "-") + spell(t) for s, t in node.terms)
    if isinstance(node, Product):
        return " ".join(spell(f) for f in node.factors)
    raise DefinitionError(f"an index of the kind {type(node).__name__} is not understood")


def key_of(node: Node, index: Callable[[Node], str] = spell) -> str:
    """The canonical key of a name, of its velocity or its variation."""
    if isinstance(node, Dot):
        return "\\dot " * node.order + key_of(node.body, index)
    if isinstance(node, Variation):
        return "\\delta " + key_of(node.body, index)
    if not isinstance(node, Name):
        raise DefinitionError(f"a {type(node).__name__} is not a name")
    below = ",".join(index(i) for i in node.sub)
    above = ",".join(index(i) for i in node.sup)
    return node.head + (f"_{below}" if below else "") + (f"^{above}" if above else "")


def name_or_nothing(node: Node, index: Callable[[Node], str] = spell) -> str:
    """The key of a name; nothing for what is none."""
    try:
        return key_of(node, index)
    except DefinitionError:
        return ""


def _innermost(node: Node) -> Name:
    while isinstance(node, (Dot, Variation)):
        node = node.body
    if not isinstance(node, Name):
        raise DefinitionError("a dictionary key must be a name")
    return node


def _with_values(name: str, letters: list[str], values: tuple[int, ...]) -> str:
    """``a_{\\nu i}`` with the indices 1, 2 is ``a_{12}``; only what follows the letter changes."""
    cut = min(x for x in (name.find("_"), name.find("^"), len(name)) if x >= 0)
    head, marks = name[:cut], name[cut:]
    for letter, value in zip(letters, values, strict=True):
        marks = marks.replace(letter + " ", str(value)).replace(letter, str(value))
    return head + marks


def _dot_name(accent: str, name: str) -> str:
    cut = min(x for x in (name.find("_"), name.find("^"), len(name)) if x >= 0)
    return f"{accent}{{{name[:cut]}}}{name[cut:]}"
