r"""What an equation that a student wrote means in a system: two sides, in the system's symbols.

Names are those of the declaration: coordinates with their dots, quasi-velocities, parameters,
invariants, the time ``t`` and, unless something else is called so, ``L`` for the Lagrangian.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.symbols import plain_name, time, velocity
from voronec.algebra.typeset import symbol_latex
from voronec.audit.latex.nodes import (
    Chain,
    Derivative,
    Dot,
    Name,
    Node,
    Partial,
    Variation,
    walk,
)
from voronec.audit.latex.reader import read_tokens
from voronec.audit.latex.tokens import Misprint, complain
from voronec.audit.lessons.notation import spelling_of, words_of
from voronec.audit.meaning import SENSELESS, UnknownName, evaluate
from voronec.audit.study import Motion, Study, key_of
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError, did_you_mean

__all__ = ["CONSTANT", "Language"]

CONSTANT = sp.Symbol("const")
"""What stands for a constant of the motion."""
BEYOND = sp.Symbol("{rate beyond those of accelerations}")
"""What stands for a rate that is not read."""
_SHAPES = {"\\phi": "\\varphi", "\\theta": "\\vartheta", "\\epsilon": "\\varepsilon"}
_ALIKE = {"\\omega": "w", "\\nu": "v", "\\rho": "p", "\\chi": "x", "\\upsilon": "v"}
_NO_VALUE = (sp.nan, sp.zoo, sp.oo, -sp.oo)


@dataclass(frozen=True)
class Language:
    """How students may name what a derived system holds."""

    equations: VoronecEquations

    @classmethod
    def of(cls, equations: VoronecEquations) -> Language:
        """Made once for each system."""
        return equations.memo.once("language of students", lambda: cls(equations))

    @cached_property
    def symbols(self) -> dict[str, Any]:
        """Plain names and what they stand for."""
        system = self.equations.system
        known = (*system.coordinates, *self.equations.velocities, *system.inputs)
        found: dict[str, Any] = {plain_name(x): x for x in known}
        found |= {p.name: p.symbol for p in system.parameters}
        found |= {name: value for name, value in system.invariants.items() if name not in found}
        found.setdefault(plain_name(time), time)
        for name, value in system.conserved.items():  # energy = const
            if name.isalpha() and len(name) > 1:
                found.setdefault(name, value)
        return found

    @cached_property
    def study(self) -> Study:
        """The dictionary, in LaTeX."""
        names = {_latex(name): value for name, value in self._plain_names.items()}
        for shape, other in _SHAPES.items():
            for latex in [x for x in names if x.startswith(shape)]:
                names.setdefault(other + latex.removeprefix(shape), names[latex])
        names.setdefault("L", self.equations.system.lagrangian)
        for name, value in self._energies.items():
            names.setdefault(name, value)
        names.setdefault("\\pi", sp.pi)
        names.setdefault("const", CONSTANT)
        names |= {"\\mathrm{abs}": sp.Abs, "\\mathrm{sgn}": sp.sign}
        return Study(names=names, motion=self._motion)

    @property
    def _energies(self) -> dict[str, Any]:
        """T and V of L = T - V, where L has no terms that are odd in the velocities."""
        system, frame = self.equations.system, self.equations.system.frame
        moving = {*map(velocity, system.coordinates), *(frame.velocities if frame else ())}
        rest = system.lagrangian.xreplace(dict.fromkeys(moving, sp.S.Zero))
        kinetic = system.lagrangian - rest
        turned = kinetic.xreplace({v: -v for v in moving})
        odd = se.expand(self.equations.door.inward(kinetic - turned))
        return {} if odd != 0 else {"T": kinetic, "V": -rest}

    @property
    def _motion(self) -> Motion:
        """How symbols change: inputs too, by their own rates; those of accelerations are not read,
        and are marked so."""
        motion = Motion.of(self.equations)
        rates = dict(motion.rates)
        for u in self.equations.system.inputs:
            rates |= {u: velocity(u), velocity(u): velocity(velocity(u))}
        for v in self.equations.velocities:
            rates |= {velocity(v): velocity(velocity(v)), velocity(velocity(v)): BEYOND}
        return replace(motion, rates=rates)

    @property
    def _plain_names(self) -> dict[str, Any]:
        """Names but those of velocities of coordinates, which are written with dots."""
        dotted = {plain_name(q) + "dot" for q in self.equations.coordinates}
        return {name: value for name, value in self.symbols.items() if name not in dotted}

    def sides(self, text: str) -> list[Any]:
        """The values of what stands between the signs of equality.

        ``DefinitionError`` names the place of what is not understood, and of a symbol that the
        system does not have, with the nearest one.
        """
        dots = {velocity(q) for q in self.equations.coordinates}
        free = [v for v in self.equations.velocities if v not in dots]
        moving = [plain_name(x) for x in (*self.equations.coordinates, *free)]
        words = words_of(text, spelling_of([*self._plain_names], moving, _latex))
        if not words:
            raise DefinitionError("the equation is empty; write one such as \\dot v = a w^2")
        vocabulary = replace(self.study.vocabulary, by_hand=True)
        try:
            tree = read_tokens(words, text, vocabulary)
        except RecursionError:
            raise DefinitionError(
                "the equation is nested too deeply; leave out parentheses"
            ) from None
        if not tree.relations or {*tree.relations} != {"="}:
            sign = next((s for s in tree.relations if s != "="), "")
            what = f"'{sign}' is no sign of equality" if sign else "there is no sign of equality"
            raise DefinitionError(f"{what} in '{text}'; write left = right, or = const")
        self._refuse_doubtful(tree, text)
        return [self._value(part, text, tree) for part in tree.parts]

    def _refuse_doubtful(self, tree: Chain, text: str) -> None:
        """Derivatives that one book takes along the motion, or on the constraints, and another
        with everything else held."""
        system = self.equations.system
        quasi = {*self.equations.velocities} - {velocity(q) for q in system.coordinates}
        for node in walk(tree):
            if isinstance(node, Variation):
                what = "variations are not read; write what holds along the motion"
                raise complain(text, node.at[0], what)
            if isinstance(node, Derivative) and self._value_of(node.variable) not in (time, None):
                what = "a derivative with d is by t; write \\partial, or rates: \\dot y/\\dot x"
                raise complain(text, node.at[0], what)
            if not isinstance(node, Partial) or node.body is None:
                continue
            held = getattr(self._value_of(node.body), "free_symbols", None)
            by = {self._value_of(v) for v in node.variables}
            if held is not None and not by <= held and (by | held) & quasi:
                what = "no velocities of a frame stand in this; take those of the coordinates"
                raise complain(text, node.at[0], what)

    def _value_of(self, node: Node) -> Any:
        """The value of a part; None where it has none, which is told elsewhere."""
        try:
            return evaluate(node, self.study)
        except SENSELESS:
            return None

    def _value(self, part: Node, text: str, tree: Chain) -> Any:
        try:
            value = evaluate(part, self.study)
        except UnknownName as unknown:
            raise self._unknown(unknown.name, text, tree) from None
        except Misprint as error:
            for node in walk(part):
                if isinstance(node, Name) and node.sub and self._value_of(node) is None:
                    raise self._unknown(_name_of(node), text, tree) from None
            raise complain(text, part.at[0], f"this has no value: {error}") from None
        except DefinitionError:
            raise
        except SENSELESS as error:
            what = f"this has no value: {type(error).__name__.lower()}"
            raise complain(text, part.at[0], what) from None
        if isinstance(value, sp.Expr) and value.has(BEYOND):
            what = "this rate is too high; write no higher ones than those of accelerations"
            raise complain(text, part.at[0], what)
        if not isinstance(value, sp.Expr) or value.has(*_NO_VALUE):
            raise complain(text, part.at[0], "this has no value that is a real number")
        return value

    def _unknown(self, name: str, text: str, tree: Chain) -> DefinitionError:
        """Where a symbol stands that the system does not have, and the nearest that it has."""
        names = (n for n in walk(tree) if isinstance(n, (Name, Dot)) and _name_of(n) == name)
        node = next(names, None)
        at = 0 if node is None else node.at[0]
        known = [*self._plain_names]
        word = r"[A-Za-z]+\d+(?!\w)" if "\\" in text else r"[A-Za-z]+\d*(?!\w)"  # I1 is not I
        whole = re.match(word, text[at:])
        bare = whole[0] if whole is not None else name.lstrip("\\")
        alike = _ALIKE.get(name.split("_")[0], "")
        near = f"; did you mean '{alike}'?" if alike in known else did_you_mean(bare, known)
        if bare in ("lambda", "mu") or bare.startswith(("lambda_", "mu_")):
            near = "; equations are judged without multipliers: eliminate them"
        system = self.equations.system.name
        return complain(text, at, f"'{bare}' is no symbol of system '{system}'{near}")


def _latex(name: str) -> str:
    """A name as the reader knows it: one of several letters is a word, with an index or without."""
    head, _, index = name.partition("_")
    if len(head) > 1 and index.isalnum() and symbol_latex(head).startswith("\\mathrm"):
        return f"{symbol_latex(head)}_{{{symbol_latex(index)}}}"
    return symbol_latex(name)


def _name_of(node: Node) -> str:
    try:
        return key_of(node)
    except DefinitionError:
        return ""
