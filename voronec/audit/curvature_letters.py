r"""The components of the curvature by their indices, ``A_{ij}^{(\nu)}``, as a paper numbers them.

Authors differ in the sign and, where letters of coordinates do not tell, in the numbers of
coordinates: a formula with such a component is proved with the sign under which more of them are,
and never accused.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from voronec.audit.contents import value_or_none
from voronec.audit.display import Check
from voronec.audit.latex.nodes import Name, Number
from voronec.audit.letters import names_in, spelled
from voronec.audit.meaning import evaluate
from voronec.audit.printed_claims import PrintedClaim
from voronec.audit.study import Study, key_of
from voronec.audit.verify import verify

_SPOKEN_OF = re.compile(r"curvature|voronec|ehresmann", re.IGNORECASE)


def with_curvature(study: Study, claims: Sequence[PrintedClaim], text: str) -> Study:
    """The dictionary with the components that a paper has, whose text speaks of them."""
    if not _SPOKEN_OF.search(text):
        return study
    numbers = _numbers(study, claims)
    mine: list[PrintedClaim] = []
    values: dict[str, Any] = {}
    for claim in claims:
        held = {
            spelled(name): value
            for name in names_in(claim.chain or ())
            if key_of(name) not in study.table
            and (value := _component(name, study, numbers)) is not None
        }
        values |= held
        mine += [claim] * any(held.values())
    proved: dict[int, Study] = {}
    for sign in (1, -1) if mine else ():
        signed = {name: sign * value for name, value in values.items()}
        trial = replace(study, names={**study.names, **signed}, ranges=())
        found = [value_or_none(verify, claim.chain, Check(), trial) for claim in mine]
        count = sum(outcome is not None and outcome.verdict.proved for outcome in found)
        proved[count] = replace(trial, ranges=study.ranges)
    best = max(proved, default=0)
    return proved[best] if best and len(proved) == 2 else study


def is_component(name: Name) -> bool:
    """Whether a name has the indices of a component of the curvature."""
    return len(name.sup) == 1 and len(_indices(name)) == 2


def _indices(name: Name) -> Sequence[Any]:
    """The indices below a name; 12 stands for 1 and 2."""
    first = name.sub[0] if len(name.sub) == 1 else None
    several = isinstance(first, Number) and len(first.text) == 2
    return [Number(digit) for digit in first.text] if several and first else name.sub


def _numbers(study: Study, claims: Sequence[PrintedClaim]) -> dict[int, Any]:
    """The coordinates by their numbers: as the paper says, q_1 = ..., else as the system does."""
    fibration = study.context.system.fibration
    found: dict[int, Any] = dict(enumerate((*fibration.base, *fibration.fibre), 1))
    for claim in claims:
        parts = claim.chain.parts if claim.chain and len(claim.chain.parts) == 2 else ()
        for one, other in (parts, parts[::-1]) if parts else ():
            if isinstance(one, Name) and one.head == "q" and len(one.sub) == 1:
                value = value_or_none(evaluate, other, study)
                if isinstance(one.sub[0], Number) and value in study.context.coordinates:
                    found[int(one.sub[0].text)] = value
    return found


def _component(name: Name, study: Study, numbers: Mapping[int, Any]) -> Any:
    """The component of the system's curvature that a name stands for, else None."""
    if not is_component(name):
        return None
    fibration = study.context.system.fibration
    base, fibre = [*fibration.base], [*fibration.fibre]
    places = []
    for index in (name.sup[0], *_indices(name)):
        number = int(index.text) if isinstance(index, Number) else 0
        shift = len(base) if index is name.sup[0] and number <= len(fibre) else 0
        place = numbers.get(number + shift) if number else value_or_none(evaluate, index, study)
        places.append(place)
    if places[0] not in fibre or not {*places[1:]} <= {*base}:
        return None
    return study.context.curvature[fibre.index(places[0]), *map(base.index, places[1:])]
