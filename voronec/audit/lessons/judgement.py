"""An equation that a student wrote, proved or refuted along the motions of a system."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from voronec.algebra.symbols import plain_name, velocity
from voronec.algebra.text import as_expression
from voronec.algebra.typeset import caret_text, plain_text
from voronec.algebra.verdicts import Verdict, decide_equal
from voronec.audit.lessons.meaning_of_text import CONSTANT, Language
from voronec.declaration.system import System
from voronec.equations.motions import Motions
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.errors import DefinitionError
from voronec.proof.claims import decide_integral

__all__ = ["Judgement", "judge"]

GROUNDS = {
    "constraints": "it holds in every motion that the constraints admit, whatever the forces",
    "motion": "it follows from the equations of motion",
    "integral": "its rate vanishes along every motion",
}
"""On what an equation rests that is proved."""


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
        constant = self.ground == "integral"
        why = "at which its rate is not zero" if constant else "at which the two sides differ"
        sides = ("its rate is",) if constant else ("the left side is", "the right side is")
        lines = ["comes out", f"  refuted: there is a state of the motion {why}", "  at the state"]
        lines += [f"    {name} = {value}" for name, value in witness.point.items()]
        for words, value in zip(sides, (witness.left, witness.right), strict=False):
            lines += [f"  {words}", f"    {value}"]
        return lines

    def as_dict(self) -> dict[str, Any]:
        """The same as data that JSON can hold."""
        witness = self.verdict.witness
        data: dict[str, Any] = {
            "system": self.system.name,
            "equation": self.text,
            "read": [plain_text(e) for e in self.read],
            "verdict": self.verdict.status,
            "why": self.verdict.method,
            "ground": self.ground,
            "accelerations": {plain_name(s): plain_text(v) for s, v in self.accelerations.items()},
        }
        if witness is not None:
            data["state"] = dict(witness.point)
            data["values"] = [witness.left, witness.right]
        return data

    def __str__(self) -> str:
        return "\n".join(self.lines())


LONGEST = 400
"""How long an acceleration is that is printed whole."""


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
    sides = Language.of(equations).sides(text)
    verdict, ground = _decide_chain(Motions.of(equations), sides)
    used = _accelerations(equations, sides) if ground != "constraints" else {}
    return Judgement(equations.system, text, tuple(sides), verdict, ground, used)


def _decide_chain(motions: Motions, sides: list[Any]) -> tuple[Verdict, str]:
    """The verdict on all links of a chain: the first that fails, else one in doubt."""
    found = [*_links(motions, sides)]
    for status in ("refuted", "undecided"):
        for verdict, ground in found:
            if verdict.status == status:
                return verdict, ground
    weight = [*GROUNDS]
    return max(found, key=lambda pair: weight.index(pair[1]))


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
    field = motions.on_coordinates
    inside = [field.door.inward(side) for side in (left, right)]
    free = [field.express(side) for side in inside]
    found = decide_equal(free[0], free[1], field.hypotheses, pointwise=True)
    places = _places(motions)
    moving = {symbol for side in free for symbol in side.free_symbols} & places.keys()
    if found.proved or not moving:
        return found, "constraints"
    along = [side.xreplace(places) for side in free]
    return decide_equal(along[0], along[1], field.hypotheses, pointwise=True), "motion"


def _places(motions: Motions) -> dict[Any, Any]:
    """Accelerations and their rates inside the door, and what they are along the motion."""
    field = motions.on_coordinates
    found = {}
    for v, value in zip(motions.equations.velocities, field.accelerations, strict=True):
        found[field.door.admit(velocity(v))] = value
        found[field.door.admit(velocity(velocity(v)))] = field.derivative(value)
    return found


def _constant(motions: Motions, value: Any) -> Verdict:
    field = motions.on_coordinates
    places = _places(motions)
    inside = field.door.inward(value)
    if inside.free_symbols.isdisjoint(places):
        return decide_integral(motions, value).verdict
    rate = field.derivative(field.express(inside).xreplace(places))
    return decide_equal(rate, 0, field.hypotheses, pointwise=True)


def _accelerations(equations: VoronecEquations, sides: list[Any]) -> dict[Any, Any]:
    """Those that the equation holds, for print; of an integral, those that its rate holds."""
    outward = equations.door.outward
    held = {s for side in sides for s in side.free_symbols}
    integral = CONSTANT in held
    found = {}
    for v, value in zip(
        equations.velocities, Motions.of(equations).on_coordinates.accelerations, strict=True
    ):
        if velocity(v) in held or (integral and v in held):
            found[velocity(v)] = as_expression(outward(value))
    return found
