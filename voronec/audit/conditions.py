"""What the words around a formula restrict: cases that they name, reasons why it may fail."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import sympy as sp

from voronec.algebra.verdicts import prove_equal
from voronec.audit.contents import moves, value_or_none, values_of
from voronec.audit.curvature_letters import component_indices
from voronec.audit.display import Check
from voronec.audit.latex.nodes import Chain, Dot, Name, Node
from voronec.audit.letters import has_usual_words, names_in
from voronec.audit.printed_claims import PrintedClaim
from voronec.audit.record import FormulaRecord
from voronec.audit.structure import names_constant
from voronec.audit.study import Study, key_of
from voronec.audit.verify import verify

_CONDITIONS = re.compile(
    r"\b(if|when|whenever|unless|provided|suppos\w*|assum\w*|absence"
    r"|without(?! (?:slip|skid|los|fric))|neglect\w*|small|near|limit\w*|approximat\w*"
    r"|(?<!is )(?<!are )at rest|at the (?:initial|moment|instant)|initial\w*|steady|stationary"
    r"|equilibri\w*|lineari[sz]\w*|(?:special|particular) (?:cas|solution|motion|value)\w*|virtual"
    r"|unconstrained|would|as if|first order|rescal\w*|normali[sz]\w*"
    r"|dimensionless|nondimensional\w*|units|vakonomic|variational|remov\w*"
    r"|free (?:body|motion)|holonomic case|substitutes? (?:the )?variables?|new variables?"
    r"|(?:change|transformation) of (?:the )?variables?|by (?:the|a) substitution"
    r"|wrong\w*|erroneous\w*|incorrect\w*|false|misprint\w*|instead of|in (?:\w+ )?(?:book|paper)"
    r"|solution)\b",
    re.IGNORECASE,
)
"""Words of a sentence which say that a formula in it need not hold always."""
_ASSUMPTIONS = re.compile(
    r"\b(?:let|take(?! the)|choose|put|set|setting|putting|consider|fix|impose|requir\w*)\b"
    r"[\w\s:]{0,25}$"
    r"|\b(?:with|for|where|at|on|as)\s*$",
    re.IGNORECASE,
)
"""Words right before a formula that make an assumption of it."""
_INTEGRALS = re.compile(r"\bintegrals?\b|conserv", re.IGNORECASE)
_BEHIND = re.compile(r"\W*(?:for|if|when|provided|at|near|where)\b")
"""Words right behind a formula that restrict it."""
_LIMIT = re.compile(
    r"\$\s*([^$=]+?)\s*\\(?:to|rightarrow)\s*\+?(-?\d+|-?\s*\\infty)(?![a-zA-Z])\s*\$"
)
r"""A limit, as ``$k\to 0$`` and ``$m\to\infty$``."""
_SMALL = sp.Symbol("small", positive=True)
"""What vanishes where something is infinite."""
_COMMANDS = re.compile(r"\\[a-zA-Z]+\*?|[{}$\\]")
EXCEPTIONS = re.compile(
    r"\b(?:unless|except\w*|unlike|contrary|contrast|opposed|otherwise|else|not|never|no longer|but"
    r"|without(?! (?:slip|skid|los|fric)))\b",
    re.IGNORECASE,
)
"""Words by which a sentence may name the case that it excludes."""
_BRIEF = re.compile(r"\b(?:if|for|when|whenever|unless|at|near)\b", re.IGNORECASE)
"""Words by which a condition is one of its own sentence, or of a few."""
_GENERAL = re.compile(r"\b(?:in general|general case|always|arbitrary|whatever)\b", re.IGNORECASE)
"""Words which say that no condition of earlier sentences is meant."""
_AT_REST = re.compile(r"\bat rest\b", re.IGNORECASE)


@dataclass(frozen=True)
class SpecialCase:
    """A case as its words say, and the dictionary under its conditions, which may hold what is
    infinite."""

    said: str
    study: Study

    def holds(self, chain: Chain) -> bool:
        """Whether a formula is proved in this case."""
        if any(value.has(_SMALL) for value in self.study.given.values()):
            return value_or_none(_in_limit, chain, self.study) is True
        outcome = value_or_none(verify, chain, Check(), self.study)
        return outcome is not None and outcome.verdict.proved


def _in_limit(chain: Chain, study: Study) -> bool:
    """Whether two sides have no difference in the limit."""
    along, given = study.motion.along, dict(study.given)
    left, right = (along(value).xreplace(given) for value in values_of(chain.parts, study))
    top, bottom = (part.xreplace({_SMALL: 0}) for part in sp.fraction(sp.cancel(left - right)))
    return bool(prove_equal(top, 0).proved and prove_equal(bottom, 0).refuted)


def special_cases(
    claim: PrintedClaim, claims: Sequence[PrintedClaim], study: Study
) -> list[SpecialCase]:
    """The cases that the sentence of a formula names: conditions, each alone and all together."""
    cases: list[tuple[str, dict[Any, Any]]] = []
    moving = study.motion.rates
    words = claim.sentence
    if _AT_REST.search(words):
        cases.append(("rest", dict.fromkeys(study.context.velocities, sp.S.Zero)))
    for letter, value in _LIMIT.findall(words):
        node = value_or_none(study.tree, letter)
        symbol = node and study.table.get(study.key(node))
        if isinstance(symbol, sp.Symbol):
            far = "infty" in value and (-1 if "-" in value else 1) / _SMALL
            place = far or sp.Integer(value)
            cases.append((f"${letter}\\to {value}$", {symbol: place}))
    for other in claims:
        if other.display.sentence == claim.display.sentence and other is not claim:
            given = _condition(other, study)
            cases += [(f"${other.formula.printed}$", given)] if given else []
    if len(cases) > 1:
        together: dict[Any, Any] = {}
        for _, given in cases:
            together |= given
        cases.append((" and ".join(said for said, _ in cases), together))
    constant = claim.chain is not None and any(map(names_constant, claim.chain.parts))
    return [
        SpecialCase(said, replace(study, given=given))
        for said, given in cases
        if not (constant and given.keys() & moving.keys())
    ]


def _condition(claim: PrintedClaim, study: Study) -> dict[Any, Any]:
    """What a formula says that symbols are, which is not so in general; nothing for another."""
    chain = claim.chain
    if chain is None or {*chain.relations} != {"="} or SpecialCase("", study).holds(chain):
        return {}
    values = value_or_none(values_of, chain.parts, study)
    still = values and not getattr(values[-1], "free_symbols", set()) & {*study.motion.rates}
    if not still or not isinstance(values[0], sp.Symbol):
        return {}
    return {x: values[-1] for x in values[:-1] if isinstance(x, sp.Symbol)}


def earlier_case(
    claim: PrintedClaim, chain: Chain, claims: Sequence[PrintedClaim], study: Study
) -> SpecialCase | None:
    """A condition of an earlier sentence under which a formula is true, which may be meant.

    A condition on parameters lasts to the end of the paper; behind "if" and "for", or one on the
    state that is assumed, as in "let", to the end of its section.
    """
    if _GENERAL.search(claim.sentence):
        return None
    together: dict[Any, Any] = {}
    for other in claims:
        if other.display.sentence >= claim.display.sentence:
            continue
        given = _condition(other, study)
        words = _COMMANDS.sub(" ", other.display.before)
        brief = _BRIEF.search(words) is not None
        state = given.keys() & study.motion.rates.keys()
        here = not state or (not brief and _ASSUMPTIONS.search(words))
        if not given or not here or ((state or brief) and other.section != claim.section):
            continue
        together |= given
        for values in (given, together):
            case = SpecialCase(f"{other.where} supposes", replace(study, given=values))
            if case.holds(chain):
                return case
    return None


def excuse(
    claim: PrintedClaim, chain: Chain, study: Study, defined_at: Mapping[str, PrintedClaim]
) -> FormulaRecord | None:
    """What else a refuted formula may be than wrong, as a record; else None."""
    printed = claim.formula.printed
    parts = [part for part in chain.parts if not names_constant(part)]
    about = _condition_on(parts, study, constant=len(parts) < len(chain.parts))
    if about == "parameters":
        names = {key_of(n): None for n in names_in(tuple(parts))}
        known = [key for key in names if defined_at.get(key, claim) is not claim]
        for key in known[:1]:
            said = f"'{key}' is defined otherwise in {defined_at[key].where}"
            return FormulaRecord(printed, "convention", said)
    if about == "parameters" or (about and not _INTEGRALS.search(claim.display.before)):
        return FormulaRecord(printed, "definition", f"a condition on the {about}")
    if any(component_indices(name) for name in names_in(tuple(parts))):
        said = "false with one sign and numbering of the curvature; which are meant?"
        return FormulaRecord(printed, "not read", said)
    values = value_or_none(values_of, parts, study) or ()
    if any(value.has(sp.Piecewise) for value in values):
        return FormulaRecord(printed, "not read", "false in general; it holds values by cases")
    for part in parts:
        if isinstance(part, Name) and not has_usual_words(part, claim.sentence):
            return FormulaRecord(printed, "not read", f"{part.head} may be something else here")
    words = claim.display.before.rpartition("\n\n")[2]
    condition = _CONDITIONS.search(words) or _ASSUMPTIONS.search(_COMMANDS.sub(" ", words))
    condition = condition or _BEHIND.match(claim.display.after)
    if condition is None:
        return None
    said = f"its sentence has '{condition[0].strip()}', a condition that is not read"
    return FormulaRecord(printed, "not read", f"false in general; {said}")


def _condition_on(parts: Sequence[Node], study: Study, constant: bool) -> str:
    """Of what a formula may only say what value it has: parameters, the state, coordinates."""
    motion = study.motion
    values = value_or_none(values_of, parts, study) or []
    symbols: list[set[Any]] = [getattr(value, "free_symbols", set()) for value in values]
    states = {s for s in (*motion.rates, *motion.rates.values()) if s.is_Symbol}
    if values and not any(held & states for held in symbols):
        return "parameters"
    still = constant or any(not held & states for held in symbols)
    for part, held in zip(parts, symbols, strict=False):
        moving = held & states and not held <= motion.accelerations.keys()
        vector = isinstance(part, Dot) and isinstance(part.body, Name)
        vector = vector and not held & motion.accelerations.keys()
        velocity_alone = isinstance(part, Dot) and (len(held) == 1 or vector) and moving
        if still and (velocity_alone or (isinstance(part, Name) and held & states)):
            return "state"
    return "" if any(moves(part, study) for part in parts) else "coordinates"
