r"""What a sentence claims in words, by a few exact patterns; all other sentences are not audited.

"A is a first integral", "A and B are constant" and "A equals B" become formulas, which are judged
as those in print.  The number of degrees of freedom, "the constraints are nonholonomic" and an
invariant measure with its density are decided for the system.  A sentence is accused only where it
says nothing else: no negation, no second formula, no word behind its claim but of the motion; a
number of degrees of freedom and a density never are.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from voronec.audit.latex.document import ELLIPSIS, PrintedSentence
from voronec.declaration.claims import Measure
from voronec.equations.motions import Motions
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError, EngineLimit
from voronec.proof.claims import check_claims
from voronec.proof.measures import decide_measure

CONSTANT_WORD = r"\text{const}"
"""What stands in the place of a constant while an integral is judged."""

_LIST = r"(?P<all>\$\d+\$(?: ?,? (?:and )?\$\d+\$)*)"
_CONSTANT = re.compile(
    rf"{_LIST} ?,? (?:is|are|remains?|stays?)(?: both| all| also| thus| therefore)? (?:an? |the )?"
    r"(?:(?:first )?integrals?(?: of (?:the )?motion)?|constants?(?: of (?:the )?motion)?"
    r"|conserved(?: quantit(?:y|ies))?|preserved)\b",
    re.IGNORECASE,
)
_EQUAL = re.compile(
    rf"{_LIST} (?:(?P<always>equals|is equal to|coincides with)|becomes|tends to|reduces to) "
    r"(?:the right(?:-hand)? side of )?(?:\$(?P<value>\d+)\$|\((?P<label>[^()\s]+)\))"
)
_FREEDOM = re.compile(r"\bhas (?P<count>\w+) degrees? of freedom\b")
_BOUND = re.compile(
    r"\b(?:(?P<each>both|all|neither|none)(?: of)?(?: the)? )?(?:constraint(?P<plural>s)?"
    r"|(?<=the )(?P<system>system)(?= is (?:not )?(?:non-?)?holonomic))(?: \([^()\s]+\))?"
    r" (?:is|are) (?P<no>not )?"
    r"(?P<kind>non-?holonomic|holonomic|(?:non-?)?integrable)\b",
    re.IGNORECASE,
)
_WHOLE_SYSTEM = re.compile(
    r"\b(?:system|problem|equations)(?: of motion)? (?:is|are) (?:completely )?integrable\b"
)
_MEASURE = re.compile(r"\bmeasure\b[^$]* with (?:the )?density (?:\w+ )?\$(?P<density>\d+)\$")
_NEGATION = re.compile(
    r"\b(?:not?|neither|nor|never|only|cannot|nothing|hardly|false|\w*wrong\w*"
    r"|erroneous\w*|incorrect\w*)\b",
    re.IGNORECASE,
)
_ALONG = re.compile(
    r"(?: (?:along|of|for|during|on) (?:the |these |every |each |all )?(?:whole |reduced )?"
    r"(?:motions?|solutions?|trajector(?:y|ies)|systems?|equations|problem|flow|constraints?))*\W*"
)
_SUBJECT = re.compile(
    r"(?:[\d.]+ )?(?:(?:hence|thus|therefore|so|then|moreover|consequently|also|besides|indeed|here"
    r"|it follows that|we see that|(?:the )?\w+(?: \w+)? is (?:preserved|conserved)) ?,? )*"
    r"(?:(?:the|its|this) (?:(?!that|wh|case|for|with|such|control)[\w-]+ ){0,3}"
    r"(?:(?:of|about|along) (?:the )?(?:(?!that|wh|case|for|with|such|control)[\w-]+ ){0,3})?)?",
    re.IGNORECASE,
)
"""Words before a formula that say only what it is."""
_COUNTS = "zero one two three four five six seven eight nine ten".split()


@dataclass(frozen=True)
class WordClaim:
    """A claim in words: the ``formula`` that it makes, in LaTeX, with the words ``before`` it; or
    what ``decide`` tells of the equations: a verdict and a method.

    ``alone`` says whether the sentence holds nothing else that may restrict it.
    """

    alone: bool
    before: str = ""
    after: str = ""
    formula: str = ""
    decide: Callable[[VoronecEquations], tuple[str, str]] | None = None


def claims_in_words(
    sentence: PrintedSentence,
    value_of: Callable[[str], Any],
    side_of: Callable[[str], str],
) -> list[WordClaim]:
    """What a sentence claims by one of the patterns.

    ``value_of`` gives the value of LaTeX, None where it has none; ``side_of`` the last side of the
    formula with a label, empty where there is none.
    """
    words = sentence.words
    if (match := _BOUND.search(words)) is not None:
        denied = bool(match["no"]) != ((match["each"] or "")[:1].lower() == "n")
        positive = denied == match["kind"].lower().startswith("non")
        several = bool(match["plural"] or match["system"])
        if match["each"]:
            return [WordClaim(False, decide=lambda equations: _each(equations, positive))]
        mine = match["system"] is None  # else it may be that of another paper
        return [WordClaim(mine, decide=lambda equations: _integrable(equations, positive, several))]
    if _NEGATION.search(words):
        return []
    if _WHOLE_SYSTEM.search(words) is not None:
        return [WordClaim(False, decide=_theorem)]
    if (match := _FREEDOM.search(words)) is not None:
        count = match["count"].lower()
        number = _COUNTS.index(count) if count in _COUNTS else count
        return [WordClaim(False, decide=lambda equations: _freedom(equations, str(number)))]
    if (match := _MEASURE.search(words)) is not None:
        density = value_of(last_side(sentence.formulas[int(match["density"])]))
        return [WordClaim(False, decide=lambda equations: _measure(equations, density))]
    for pattern, constant in ((_CONSTANT, True), (_EQUAL, False)):
        if (match := pattern.search(words)) is None:
            continue
        subjects = [sentence.formulas[int(i)] for i in re.findall(r"\d+", match["all"])]
        head, tail = words[: match.start()], words[match.end() :]
        value = CONSTANT_WORD if constant else _value(match, sentence.formulas, side_of)
        says = constant or (match["always"] and not re.fullmatch(r"[\d./-]+", value))
        alone = bool(says and _SUBJECT.fullmatch(head) and _ALONG.fullmatch(tail))
        before, after = sentence.with_formulas(head), sentence.with_formulas(tail)
        return [
            WordClaim(alone, before, after, f"${subject}={value}$")
            for subject in map(last_side, subjects)
            if value and subject and subject != ELLIPSIS
        ]
    return []


def _value(match: re.Match[str], formulas: Sequence[str], side_of: Callable[[str], str]) -> str:
    """The LaTeX of what the subject of a sentence is said to equal."""
    return side_of(match["label"]) if match["label"] else last_side(formulas[int(match["value"])])


def last_side(formula: str) -> str:
    r"""The last side of ``E = ...``; empty where it is not the longest, as in ``... = c_1``, which
    is judged as a formula."""
    sides = [side.strip() for side in re.split(r"=(?![^{]*\})", formula)]
    return sides[-1] if sides[-1] == max(sides, key=len) else ""


def _freedom(equations: VoronecEquations, stated: str) -> tuple[str, str]:
    """A number of degrees of freedom is that of the velocities or that of the coordinates; another
    may be that of a reduced system, or count coordinates that the system has not."""
    free, places = len(equations.velocities), len(equations.coordinates)
    said = stated in (str(free), str(places))
    return "proved" if said else "unaudited", f"{free} independent velocities, {places} coordinates"


def _integrable(equations: VoronecEquations, stated: bool, several: bool) -> tuple[str, str]:
    """Whether the constraints are integrable, all of them together; one of several is not told."""
    if not several and len(equations.system.constraints) != 1:
        return "unaudited", "the system has several constraints, or none"
    if (equations.kind == "holonomic") == stated:
        said = "vanishes" if stated else "does not vanish"
        return "proved", f"the curvature of the constraints {said}"
    if stated:
        return "unaudited", "the curvature of the system's constraints does not vanish; others do"
    return "misprint", "the curvature of the constraints vanishes"


def _each(equations: VoronecEquations, stated: bool) -> tuple[str, str]:
    """Whether each of the constraints is integrable, or none, whatever their combinations are."""
    count = len(equations.integrable)
    if count == (len(equations.system.constraints) if stated else 0):
        return "proved", f"{count or 'no'} combinations of the constraints integrate"
    return "unaudited", f"{count} combinations of the constraints integrate; which are meant?"


def _theorem(equations: VoronecEquations) -> tuple[str, str]:
    """Whether a theorem of integrability that the system itself claims is proved for it."""
    system = equations.system
    for claim in check_claims(replace(system, cases={})) if system.integrable else ():
        if claim.kind == "integrable" and claim.verdict.proved:
            return "proved", f"{claim.standing}: {claim.verdict.method}"
    return "unaudited", "the system claims no theorem of integrability that is proved"


def _measure(equations: VoronecEquations, density: Any) -> tuple[str, str]:
    """Whether a density is that of an invariant measure, in the coordinates and velocities or in
    the variables of the measure that the system declares."""
    declared = getattr(equations.system.measure, "variables", ())
    for variables in ((), declared) if density is not None else ():
        try:
            verdict = decide_measure(Motions.of(equations), Measure(density, variables)).verdict
        except (DefinitionError, EngineLimit):
            continue
        if verdict.proved:
            return "proved", "the divergence of density times velocity vanishes"
    return "unaudited", "no measure of the system with this density is known; in other variables?"
