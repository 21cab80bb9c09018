"""An equation that a student wrote, proved or refuted along the motions of a system.

Its two sides are read in the system's symbols.  Names are those of the declaration: coordinates
with their dots, quasi-velocities, parameters, invariants, the time ``t`` and, unless something else
is called so, ``L`` for the Lagrangian.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.symbols import plain_name, time, velocity
from voronec.algebra.text import as_expression
from voronec.algebra.typeset import caret_text, plain_text, symbol_latex
from voronec.algebra.verdicts import NUMBERS, Verdict, decide_equal
from voronec.audit.latex.nodes import (
    Chain,
    Derivative,
    Differential,
    Dot,
    Name,
    Node,
    Power,
    Quotient,
    walk,
)
from voronec.audit.latex.reader import read_tokens
from voronec.audit.latex.tokens import Misprint, complain
from voronec.audit.lessons.notation import BASE, command_of, spelling_of, words_of
from voronec.audit.meaning import SENSELESS, UnknownName, evaluate
from voronec.audit.study import Motion, Study, name_or_nothing
from voronec.declaration.system import System
from voronec.equations.motions import Motions
from voronec.equations.vector_field import VectorField
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.errors import DefinitionError, EngineLimit, did_you_mean
from voronec.proof.branch_cuts import across_cuts, not_vacuous, positive_domain
from voronec.proof.claims import decide_integral

GROUNDS = {
    "constraints": "it holds in every motion that the constraints admit, whatever the forces",
    "motion": "it follows from the equations of motion",
    "integral": "its rate vanishes along every motion",
}
"""On what an equation rests that is proved."""
LONGEST = 400
"""How long an acceleration is that is printed whole."""
CHARACTERS = 5000
"""How long an equation may be: more than a page of print, which is judged in seconds."""
CONSTANT = sp.Symbol("const")
"""What stands for a constant of the motion."""
BEYOND = sp.Symbol("{rate beyond those of accelerations}")
"""What stands for a rate that is not read."""
_SHAPES = {"\\phi": "\\varphi", "\\theta": "\\vartheta", "\\epsilon": "\\varepsilon"}
_ALIKE = {"\\omega": "w", "\\nu": "v", "\\rho": "p", "\\chi": "x", "\\upsilon": "v"}
_NO_VALUE = (sp.nan, sp.zoo, sp.oo, -sp.oo)


@dataclass(frozen=True)
class Judgement:
    """What came out about an equation.

    ``text`` is what was written, ``read`` how it was understood: the sides between the signs of
    equality, as SymPy expressions.  ``verdict`` is ``proved``, ``refuted`` with a state (a point
    on the constraints, and the values of both sides there) or ``undecided``.  ``ground`` is
    ``constraints``, ``motion`` or ``integral``.  ``accelerations`` are those that were put in.
    """

    system: System
    text: str
    read: tuple[Any, ...]
    verdict: Verdict
    ground: str
    accelerations: dict[Any, Any]

    @property
    def proved(self) -> bool:
        """Whether the equation holds along every motion."""
        return self.verdict.proved

    @property
    def refuted(self) -> bool:
        """Whether there is a state at which it fails."""
        return self.verdict.refuted

    @property
    def undecided(self) -> bool:
        """Whether neither a proof nor such a state was found."""
        return self.verdict.undecided

    def __repr__(self) -> str:
        return f"Judgement({self.system.name!r}, {self.text!r}: {self.verdict.status})"

    def lines(self) -> list[str]:
        """What is asked, what is done, what comes out."""
        title = f": {self.system.title}" if self.system.title else ""
        return [
            f"{self.system.name}{title}",
            "",
            *self._question_lines(),
            *self._answer_lines(),
            *self._result(),
        ]

    def _question_lines(self) -> list[str]:
        said = " = ".join("const" if e == CONSTANT else caret_text(e) for e in self.read)
        question = "stay constant" if CONSTANT in self.read else "hold"
        return [
            "asked",
            f"  {self.text.strip()}",
            "read as",
            f"  {said}",
            f"  Does it {question} along every motion of the system?",
        ]

    def _answer_lines(self) -> list[str]:
        steps = ["done", "  The velocities are replaced by what the constraints leave free."]
        if self.ground == "integral":
            steps.append("  The expression is differentiated along the motion.")
        if self.accelerations:
            steps.append("  The accelerations are those of the equations of motion:")
            for symbol, value in self.accelerations.items():
                text = caret_text(value)
                shown = text if len(text) <= LONGEST else f"an expression of {len(text)} characters"
                steps.append(f"    {plain_name(symbol)} = {shown}")
        return steps

    def _result(self) -> list[str]:
        verdict, witness = self.verdict, self.verdict.witness
        if witness is None:
            lines = ["comes out", f"  {verdict.status}: {verdict.method}"]
            if verdict.limits:
                lines.append(f"  {verdict.limits}")
            return [*lines, f"  {GROUNDS[self.ground]}"] if verdict.proved else lines
        if verdict.method != NUMBERS:
            lines = ["comes out", f"  refuted: {verdict.method}", "  at the state"]
            lines += [f"    {name} = {value}" for name, value in witness.point.items()]
            return [*lines, "  on its two sides", f"    {witness.left}", f"    {witness.right}"]
        constant = self.ground == "integral"
        why = "at which its rate is not zero" if constant else "at which the two sides differ"
        sides = ("its rate is",) if constant else ("the left side is", "the right side is")
        lines = ["comes out", f"  refuted: there is a state of the motion {why}", "  at the state"]
        lines += [f"    {name} = {value}" for name, value in witness.point.items()]
        for words, value in zip(sides, (witness.left, witness.right), strict=False):
            lines += [f"  {words}", f"    {value}"]
        return lines

    def as_dict(self) -> dict[str, Any]:
        """The judgement as data that JSON can hold."""
        witness = self.verdict.witness
        data: dict[str, Any] = {
            "system": self.system.name,
            "equation": self.text,
            "read": [plain_text(e) for e in self.read],
            "verdict": self.verdict.status,
            "why": self.verdict.method,
            "limits": self.verdict.limits,
            "ground": self.ground,
            "accelerations": {plain_name(s): plain_text(v) for s, v in self.accelerations.items()},
        }
        if witness is not None:
            data["state"] = dict(witness.point)
            data["values"] = [witness.left, witness.right]
        return data

    def __str__(self) -> str:
        return "\n".join(self.lines())


def judge(system: System | VoronecEquations, text: str) -> Judgement:
    r"""Whether an equation holds along every motion of a system: proved, refuted with a state at
    which it fails, or undecided.

    ``text`` is LaTeX or plain text in the system's own symbols, as ``\dot v = a w^2``,
    ``m \ddot x = -k x``, ``d/dt(m v) = m a w^2``, ``v^2 + w^2 = const``.  Dots, primes and d/dt
    are derivatives by the time.  An equation may be one of motion (without multipliers), a
    constraint, or an integral, ``= const``.  Several equalities in a row must all hold.

    Raises ``DefinitionError`` where the text cannot be read, with the place, and for a symbol that
    the system does not have, with the nearest one.
    """
    equations = system if isinstance(system, VoronecEquations) else derive(system)
    if not isinstance(text, str):
        raise DefinitionError(f"the equation is a {type(text).__name__}, not a text")
    if len(text) > CHARACTERS:
        told = f"the equation has {len(text)} characters; {CHARACTERS} are read at most"
        raise DefinitionError(f"{told}: judge its parts apart")
    language, motions = Language.of(equations), Motions.of(equations)
    tree = language.tree(text)
    sides = language.sides(tree, text)
    try:
        verdict, ground = _decide_chain(motions, sides)
        verdict = _across_cuts(motions, verdict, language.functions_under_rates(tree))
        verdict = not_vacuous(verdict, motions.on_coordinates)
        used = _accelerations(equations, sides) if ground != "constraints" else {}
    except EngineLimit as limit:
        verdict, ground, used = Verdict("undecided", str(limit)), "motion", {}
    return Judgement(equations.system, text, tuple(sides), verdict, ground, used)


def _decide_chain(motions: Motions, sides: list[Any]) -> tuple[Verdict, str]:
    """The verdict on all links of a chain: the first that fails, else one in doubt."""
    verdicts = [*_links(motions, sides)]
    for status in ("refuted", "undecided"):
        for verdict, ground in verdicts:
            if verdict.status == status:
                return verdict, ground
    weight = [*GROUNDS]
    return max(verdicts, key=lambda pair: weight.index(pair[1]))


def _across_cuts(motions: Motions, verdict: Verdict, functions: list[Any]) -> Verdict:
    """A proof by derivatives of functions, with the cuts of these: one that jumps has none."""
    field, places = motions.on_coordinates, _places(motions)
    read = ((caret_text(f), field.bridge.inward(f)) for f in functions)
    inside = [(words, field.express(f).xreplace(places)) for words, f in read]
    return across_cuts(verdict, field, inside, beyond=True)


def _links(motions: Motions, sides: list[Any]) -> Iterator[tuple[Verdict, str]]:
    if any(side.has(CONSTANT) and side != CONSTANT for side in sides):
        raise DefinitionError("'const' stands alone on one side of an equation; write f = const")
    if all(side == CONSTANT for side in sides):
        raise DefinitionError("'const' stands on both sides; write f = const")
    values = [side for side in sides if side != CONSTANT]
    for left, right in pairwise(values):
        yield _equal(motions, left, right)
    if CONSTANT in sides:
        yield _constant(motions, values[0]), "integral"


def _equal(motions: Motions, left: Any, right: Any) -> tuple[Verdict, str]:
    """First with arbitrary accelerations, which the constraints admit; then with the motion's."""
    field, places = motions.on_coordinates, _places(motions)  # accelerations known to the bridge
    inside = [field.bridge.inward(side) for side in (left, right)]
    free = [field.express(side) for side in inside]
    verdict = _decide(field, free)
    moving = {symbol for side in free for symbol in side.free_symbols} & places.keys()
    if verdict.proved or not moving:
        return verdict, "constraints"
    return _decide(field, [side.xreplace(places) for side in free]), "motion"


def _decide(field: VectorField, sides: list[Any]) -> Verdict:
    """Whether two sides are equal, with what counts as positive in them."""
    left, right = sides
    verdict = decide_equal(left, right, field.hypotheses, pointwise=True)
    return (
        verdict.where(*positive_domain(field, sides, field.hypotheses))
        if verdict.proved
        else verdict
    )


def _places(motions: Motions) -> dict[Any, Any]:
    """Accelerations and their rates in the engine's symbols, and what they are along the motion."""
    field = motions.on_coordinates
    places = {}
    for v, value in zip(motions.equations.velocities, field.accelerations, strict=True):
        places[field.bridge.admit(velocity(v))] = value
        places[field.bridge.admit(velocity(velocity(v)))] = field.derivative(value)
    return places


def _constant(motions: Motions, value: Any) -> Verdict:
    field = motions.on_coordinates
    places = _places(motions)
    inside = field.bridge.inward(value)
    if inside.free_symbols.isdisjoint(places):
        return decide_integral(motions, value).verdict
    function = field.express(inside).xreplace(places)
    verdict = _decide(field, [field.derivative(function), se.Integer(0)])
    return across_cuts(verdict, field, [("", function)], constant=True)


def _accelerations(equations: VoronecEquations, sides: list[Any]) -> dict[Any, Any]:
    """Those that the equation holds, for print; of an integral, those that its rate holds."""
    outward = equations.bridge.outward
    held = {s for side in sides for s in side.free_symbols}
    integral = CONSTANT in held
    accelerations = {}
    for v, value in zip(
        equations.velocities, Motions.of(equations).on_coordinates.accelerations, strict=True
    ):
        if velocity(v) in held or (integral and v in held):
            accelerations[velocity(v)] = as_expression(outward(value))
    return accelerations


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
        meanings: dict[str, Any] = {plain_name(x): x for x in known}
        meanings |= {p.name: p.symbol for p in system.parameters}
        beside = system.frame.beside if system.frame else {}
        more = {plain_name(w): value for w, value in beside.items()} | dict(system.invariants)
        meanings |= {name: value for name, value in more.items() if name not in meanings}
        meanings.setdefault(plain_name(time), time)
        for name, value in system.conserved.items():  # energy = const
            if name.isalpha() and len(name) > 1:
                meanings.setdefault(name, value)
        return meanings

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
        names[f"\\mathrm{{{BASE}}}"] = sp.E
        names.setdefault("const", CONSTANT)
        return Study(names=names, motion=self._motion)

    @property
    def _energies(self) -> dict[str, Any]:
        """T and V of L = T - V, where L has no terms that are odd in the velocities."""
        system, frame = self.equations.system, self.equations.system.frame
        moving = {*map(velocity, system.coordinates), *(frame.velocities if frame else ())}
        rest = system.lagrangian.xreplace(dict.fromkeys(moving, sp.S.Zero))
        kinetic = system.lagrangian - rest
        turned = kinetic.xreplace({v: -v for v in moving})
        odd = se.expand(self.equations.bridge.inward(kinetic - turned))
        return {} if odd != 0 else {"T": kinetic, "V": -rest}

    @property
    def _motion(self) -> Motion:
        """How symbols change: inputs too, by their own rates; those of accelerations are not read,
        and are marked so."""
        motion = Motion.of(self.equations)
        rates = dict(motion.rates)
        for u in self.equations.system.inputs:
            rates |= {u: velocity(u)}
        for v in (*self.equations.velocities, *self.equations.system.inputs):
            rates |= {velocity(v): velocity(velocity(v)), velocity(velocity(v)): BEYOND}
        return replace(motion, rates=rates)

    @property
    def _plain_names(self) -> dict[str, Any]:
        """Names but those of velocities of coordinates, which are written with dots."""
        dotted = {plain_name(q) + "dot" for q in self.equations.coordinates}
        return {name: value for name, value in self.symbols.items() if name not in dotted}

    def tree(self, text: str) -> Chain:
        """An equation as it is read; ``DefinitionError`` names the place of what is not
        understood."""
        dots = {velocity(q) for q in self.equations.coordinates}
        free = [v for v in self.equations.velocities if v not in dots]
        moving = [plain_name(x) for x in (*self.equations.coordinates, *free)]
        source, words = words_of(text, spelling_of([*self._plain_names], moving, _latex))
        if not words:
            raise DefinitionError("the equation is empty; write one such as \\dot v = a w^2")
        vocabulary = replace(self.study.vocabulary, primes=True)
        tree = read_tokens(words, source, vocabulary)
        if not tree.relations or {*tree.relations} != {"="}:
            sign = next((s for s in tree.relations if s != "="), "")
            what = f"'{sign}' is no sign of equality" if sign else "there is no sign of equality"
            raise DefinitionError(f"{what} in '{text}'; write left = right, or = const")
        return tree

    def sides(self, tree: Chain, text: str) -> list[Any]:
        """The values of what stands between the signs of equality.

        ``DefinitionError`` names the place of a symbol that the system does not have, with the
        nearest one.
        """
        values = [self._value(part, text, tree) for part in tree.parts]
        self._refuse_zero_divisors(tree, text)
        return values

    def _refuse_zero_divisors(self, tree: Chain, text: str) -> None:
        """What no motion gives a value: SymPy makes f/f one before it is seen that f is zero."""
        motions = Motions.of(self.equations)
        quotients = [n.bottom for n in walk(tree) if isinstance(n, Quotient)]
        powers = [n for n in walk(tree) if isinstance(n, Power)]
        for node in powers:
            if getattr(self._value_of(node.exponent), "is_negative", False):
                quotients.append(node.base)
        for node in quotients:
            divisor = self._value_of(node)
            if getattr(divisor, "free_symbols", None) and _equal(motions, divisor, 0)[0].proved:
                what = "this divides by what is zero along every motion; take the divisor out"
                raise complain(text, node.at[0], what)

    def functions_under_rates(self, tree: Chain) -> list[Any]:
        """The functions of which an equation takes rates, those that are rates themselves too."""
        functions: dict[Any, None] = {}
        for node in walk(tree):
            if isinstance(node, Derivative | Differential | Dot):
                value = self._value_of(node.body)
                for _ in range(getattr(node, "order", 1)):
                    if not isinstance(value, sp.Expr):
                        break
                    functions.setdefault(value)
                    value = self.study.motion.derivative(value)
        return [*functions]

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
                    raise self._unknown(name_or_nothing(node), text, tree) from None
            raise complain(text, part.at[0], f"this has no value: {error}") from None
        except DefinitionError:
            raise
        except SENSELESS:
            what = "this is no number: a list stands in it, or a function has too many arguments"
            raise complain(text, part.at[0], what) from None
        if isinstance(value, sp.Expr) and value.has(BEYOND):
            what = "this rate is too high; write no higher ones than those of accelerations"
            raise complain(text, part.at[0], what)
        if not isinstance(value, sp.Expr) or value.has(*_NO_VALUE):
            raise complain(text, part.at[0], "this has no value that is a real number")
        return value

    def _unknown(self, name: str, text: str, tree: Chain) -> DefinitionError:
        """Where a symbol stands that the system does not have, and the nearest that it has."""
        names = (n for n in walk(tree) if isinstance(n, (Name, Dot)) and name_or_nothing(n) == name)
        node = next(names, None)
        at = 0 if node is None else node.at[0]
        known = [*self._plain_names]
        word = r"[A-Za-z]+\d+(?!\w)" if "\\" in text else r"[A-Za-z]+\d*(?!\w)"  # I1 is not I
        whole = re.match(word, text[at:])
        bare = whole[0] if whole is not None else name.lstrip("\\")
        alike = _ALIKE.get(name.split("_")[0], "")
        if name == "\\pm":
            return complain(text, at, "this sign makes two equations; write each by itself")
        near = f"; did you mean '{alike}'?" if alike in known else did_you_mean(bare, known)
        if bare in ("lambda", "mu") or bare.startswith(("lambda_", "mu_")):
            near = "; equations are judged without multipliers: eliminate them"
        command = command_of(text[at:]) if "\\" in text else ""
        near = f"; beside commands of LaTeX write {command}" if command else near
        system = self.equations.system.name
        return complain(text, at, f"'{bare}' is no symbol of system '{system}'{near}")


def _latex(name: str) -> str:
    """A name as the reader knows it: one of several letters is a word, with an index or without."""
    head, _, index = name.partition("_")
    if len(head) > 1 and index.isalnum() and symbol_latex(head).startswith("\\mathrm"):
        return f"{symbol_latex(head)}_{{{symbol_latex(index)}}}"
    return symbol_latex(name)
