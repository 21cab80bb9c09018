"""Every one of very many motions classified: what doubles leave open is decided by balls."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from voronec.closed.classes.curve import declared
from voronec.closed.classes.labels import labelled
from voronec.closed.classes.survey import Survey, arrays, survey
from voronec.closed.classes.tally import tally
from voronec.closed.form import ClosedForm
from voronec.closed.prepared import prepared
from voronec.closed.problem import Problem
from voronec.errors import EngineLimit
from voronec.system import System

__all__ = ["UNDECIDED", "classify_many"]

UNDECIDED = "undecided"
"""The label of a motion on which algebra has no verdict."""


def classify_many(
    system: System,
    parameters: Mapping[Any, Any],
    initial: Mapping[Any, Any],
    trace: str | None = None,
    progress: Callable[[float], Any] | None = None,
) -> Survey:
    """The class of every one of n motions on one sphere, the first unless told.

    ``parameters`` and ``initial`` give arrays or numbers by name or symbol, used as the doubles
    they are; what is not given is the parameter's default, and 0 at the start.
    """
    found = survey(system, parameters, initial, trace)
    values = arrays(declared(system), parameters, initial)
    labels, reversals = found.labels.astype(object), found.reversals.copy()
    left = found.open
    for done, i in enumerate(left):
        label, turns = _settled(system, [row[i] for row in values], trace)
        labels[i] = label
        reversals[i] = turns
        if progress is not None and done % 50 == 0:
            progress(done / len(left))
    return replace(found, labels=labels, reversals=reversals)


def _settled(system: System, row: list[Any], trace: str | None) -> tuple[str, int]:
    """Label and number of reversals of one motion."""
    known = declared(system)
    curve = known.curve(trace)
    values = dict(zip(known.inputs, map(float, row), strict=True))
    closed = ClosedForm(Problem(prepared(system, values), values))
    try:
        counts = tally(closed.problem, curve)
        if counts is None:
            return "parallel", 0
        label = labelled(closed, curve, counts)
    except EngineLimit:
        return UNDECIDED, -1
    return label, sum(times % 2 for _, times in counts.inner)
