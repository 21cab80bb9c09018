"""What the decision of a claim gives: a verdict, and the level on which it was found."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from voronec.algebra.sympy_bridge import UnknownFunction
from voronec.algebra.verdicts import Verdict, decide_zero
from voronec.errors import DefinitionError, EngineLimit


@dataclass(frozen=True)
class Decision:
    """A verdict; ``level`` is ``coordinates``, ``invariants`` or, where neither, empty."""

    verdict: Verdict
    level: str = ""


def verdict_of(decide: Callable[[], Verdict]) -> Verdict:
    """The verdict on one of several claims: where it makes no sense, the others stand all the
    same."""
    try:
        return decide()
    except (EngineLimit, DefinitionError) as error:
        return verdict_on_failure(error)


def verdict_on_failure(error: EngineLimit | DefinitionError) -> Verdict:
    """What makes no sense is refuted; what holds a function that is not known here may be true."""
    known = not isinstance(error, EngineLimit | UnknownFunction)
    return Verdict("refuted" if known else "undecided", str(error))


def all_zero(residuals: Iterable[tuple[str, Any]], relations: Sequence[Any] = ()) -> Verdict:
    """Whether labelled expressions vanish where relations do; the first that fails is named."""
    doubt: Verdict | None = None
    proof = Verdict("proved", "nothing to prove")
    for label, residual in residuals:
        verdict = decide_zero(residual, relations)
        named = f"{label}: {verdict.method}" if label else verdict.method
        if verdict.refuted:
            return Verdict("refuted", named, verdict.witness)
        if verdict.undecided:
            doubt = Verdict("undecided", named) if doubt is None else doubt
        else:
            proof = verdict
    return proof if doubt is None else doubt


def zero_everywhere(function: Any, name: str, relations: Sequence[Any] = ()) -> Verdict | None:
    """The verdict on a claim about a density or a factor that vanishes, or may vanish, identically;
    None where it was found not to vanish at a point."""
    verdict = decide_zero(function, relations)
    if verdict.refuted:
        return None
    if verdict.proved:
        return Verdict("refuted", f"{name} vanishes identically")
    return Verdict("undecided", f"whether {name} vanishes: {verdict.method}")
