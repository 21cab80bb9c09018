r"""The class of a trace: what kind of curve a contact draws on a sphere, decided exactly.

x runs between two neighbouring roots of f = (dx/dt)^2, so that the contact runs between two
parallels of the sphere; the *upper* one has the larger cosine.  The longitude's rate is
phi(x)/(1 - cosine^2): where phi vanishes, the curve touches a meridian
[DragovicGajicJovanovic2020, Section 4.5].  The letters are those of [Demchenko1924]; his figures
were not at hand, so that the digits after C, D and E are fixed here.

==========  ===============================================================================
``A``       phi has no root strictly between the ends: the longitude only grows or only falls
``B``       one simple root: it grows along one parallel and falls along the other (loops)
``C1, C2``  two: it grows along both parallels and falls between them, or the other way round;
            over a period it has grown (C1) or fallen (C2); plain ``C`` where the drift is smaller
            than 2^-200
``A|C``     a double root, the boundary of A and C: the curve touches a meridian and goes on
``D1``      phi vanishes at the end on the upper parallel: the contact stops there, in a cusp
``D2``      the same on the lower parallel; ``D3`` on both
``E1``      the curve passes through the pole at cosine = 1; ``E2`` at -1; ``E1+E2`` through both
==========  ===============================================================================

Combinations are joined by ``+``: ``E1+D2``; with D or E the roots strictly between the ends are
added as ``+B``, ``+A|C`` or ``+C``: ``D1+B`` is a cusp above and a loop below.  At a pole phi
vanishes by itself; that root counts for nothing else.

Limits.  ``parallel``: x rests, or the cosine does not depend on it.  ``point``: the contact rests
on the sphere.  ``asymptotic to the upper parallel`` (``lower parallel``, ``both parallels``,
``upper pole``, ``lower pole``, ``a point of the upper parallel``): the end is a multiple root of f,
never reached; what the rest of the curve is follows in brackets where it is not A.

Where the sphere is that of a vector constant in space, the classes are those about its direction.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from voronec.algebra.symbols import plain_name
from voronec.closed.classes.root_positions import Tally, tally
from voronec.closed.classes.trace_polynomials import Curve, declared_traces
from voronec.closed.inverted_motion import InvertedMotion
from voronec.closed.rotation_numbers import DIGITS, turns_of

__all__ = ["LABELS", "TraceClass", "classify", "label_of", "label_trace"]

LABELS = ("A", "B", "C1", "C2", "D1", "D2", "D3", "E1", "E2")
"""The classes of the paper's figures, 4 to 12 in this order."""
REVERSALS = ("A", "B", "C")
BITS = (64, 192, 256)
"""Bits at which the sign of a drift is looked for."""


@dataclass(frozen=True)
class TraceClass:
    """The class of one trace.

    label
        as the head of this module says.
    reversals
        cosines at which the longitude turns back, ascending; touchings are none.
    lower, upper
        cosines of the two parallels.
    period
        infinite where the motion has none.
    drift
        what the longitude grows by in a period; None where there is no period.
    fraction
        what drift/(2 pi) agrees with to 50 digits, where that is rational: likely the curve closes
        after ``fraction.denominator`` periods; no proof.
    note
        a sentence on what is special.
    """

    label: str
    reversals: tuple[float, ...] = ()
    lower: float = float("nan")
    upper: float = float("nan")
    period: float = float("inf")
    drift: float | None = None
    fraction: Fraction | None = None
    note: str = ""

    def __str__(self) -> str:
        return self.label


def classify(closed: InvertedMotion) -> dict[str, TraceClass]:
    """The class of every trace of a motion, by the trace's title.

    Signs and equalities are proved; ``EngineLimit`` where a number cannot be told from zero.
    """
    known = declared_traces(closed.system)
    counted = {c.title: (c, tally(closed.problem, c)) for c in known.curves}
    found: dict[str, TraceClass] = {}
    for name, (curve, counts) in counted.items():
        if counts is not None:
            found[name] = _classify(closed, curve, counts)
    for name, (_, counts) in counted.items():
        if counts is None:
            # without an axis there is no colatitude; of two traces of one contact both rest or none
            resting = any(c.label == "point" for c in found.values())
            note = "its axis has no direction: the vector that gives it vanishes"
            found[name] = TraceClass("point" if resting else "parallel", note=note)
    return {name: found[name] for name in counted}


def _classify(closed: InvertedMotion, curve: Curve, counts: Tally) -> TraceClass:
    offset, slope = (float(closed.exact(c)(BITS[0])) for c in curve.cosine)
    ends = zip(counts.ends, counts.poles, strict=True)
    lower, upper = sorted(float(pole) or offset + slope * e for e, pole in ends)
    turns = sorted(offset + slope * place for place, times in counts.inner if times % 2)
    name = plain_name(curve.trace.longitude)
    turn = None if counts.rest else turns_of(closed).get(name)
    return TraceClass(
        label=label_trace(closed, curve, counts),
        reversals=tuple(turns),
        lower=lower,
        upper=upper,
        period=closed.period,
        drift=None if turn is None else turn.advance,
        fraction=None if turn is None else turn.fraction,
        note=_note(turn),
    )


def _note(turn: Any) -> str:
    if turn is None or turn.fraction is None:
        return ""
    count = turn.fraction.denominator
    word = "period" if count == 1 else "periods"
    turns = f"{count} {word}, {turn.fraction} of a turn each"
    return f"likely a closed curve: {turns} to {DIGITS} digits (no proof)"


def label_trace(closed: InvertedMotion, curve: Curve, counts: Tally) -> str:
    """The label of a trace; the drift is looked at where it matters."""
    label = label_of(counts, 0)
    if "C" in label and not counts.rest:
        return label_of(counts, _drift_sign(closed, curve))
    return label


def _drift_sign(closed: InvertedMotion, curve: Curve) -> int:
    """The sign of what the longitude grows by in a period; 0 where it cannot be told from zero,
    and where there is no period."""
    index = closed.quadratures.angles.index(curve.trace.longitude)
    for bits in BITS:
        advances = closed.solution.constants(bits).advances
        if advances is None:
            return 0
        if advances[index] > 0:
            return 1
        if advances[index] < 0:
            return -1
    return 0


def label_of(counts: Tally, drift: int) -> str:
    """The label of a trace, from what is counted and the sign of the drift."""
    if counts.rest or counts.flat:
        return "point" if counts.still else "parallel"
    order = (0, 1) if counts.tilt > 0 else (1, 0)
    limits, met, poles = (
        tuple(pair[i] for i in order) for pair in (counts.limits, counts.met, counts.poles)
    )
    usual = _usual(counts, limits, met, poles, drift)
    if not any(limits):
        return usual
    towards = _towards(limits, met, poles)
    return f"asymptotic to {towards}" + (f" ({usual})" if usual != "A" else "")


def _usual(counts: Tally, limits: Any, met: Any, poles: Any, drift: int) -> str:
    """The label by poles, cusps and reversals."""
    through = [not limit and pole != 0 for limit, pole in zip(limits, poles, strict=True)]
    cusps = [
        hit and not limit and pole == 0 for hit, limit, pole in zip(met, limits, poles, strict=True)
    ]
    parts = [name for name, at in (("E1", through[1]), ("E2", through[0])) if at]
    if any(cusps):
        parts.append("D3" if all(cusps) else "D1" if cusps[1] else "D2")
    loops = _loops(counts.inner, drift)
    return "+".join([*parts, *([loops] if loops != "A" or not parts else [])])


def _loops(inner: Any, drift: int) -> str:
    simple = sum(times % 2 for _, times in inner)
    if simple == 0 and inner:
        return "A|C"
    if simple < len(REVERSALS):
        letter = REVERSALS[simple]
        return letter + {1: "1", -1: "2", 0: ""}[drift] if letter == "C" else letter
    return f"{simple} reversals"


def _towards(limits: Any, met: Any, poles: Any) -> str:
    if all(limits):
        return "both parallels"
    end = 1 if limits[1] else 0
    name = ("lower", "upper")[end]
    if poles[end]:
        return f"the {name} pole"
    return f"a point of the {name} parallel" if met[end] else f"the {name} parallel"
