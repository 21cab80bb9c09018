r"""The components of the curvature by their indices, ``A_{ij}^{(\nu)}``, as a paper has them.

Indices are letters of coordinates, or numbers in the order of the system: of the base below, of the
fibre above.  Authors differ in the sign and in these numbers: a formula with a component is proved
with the sign under which more of them are, and never accused.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from voronec.audit.contents import value_or_none
from voronec.audit.display import Check
from voronec.audit.latex.nodes import Name, Node, Number
from voronec.audit.letters import name_latex, names_in
from voronec.audit.meaning import evaluate
from voronec.audit.printed_claims import PrintedClaim
from voronec.audit.study import Study, key_of
from voronec.audit.verify import verify

_INDEX_LETTERS = frozenset(("i", "j", "k", "l", "r", "s", "\\alpha", "\\beta", "\\mu", "\\nu"))
"""Letters that stand for all values of an index."""
_SUBJECT = re.compile(r"curvature|voronec|ehresmann", re.IGNORECASE)


def with_curvature(study: Study, claims: Sequence[PrintedClaim], text: str) -> Study:
    """The dictionary with the components that a paper has, whose text speaks of them."""
    values: dict[str, Any] = {}
    mine: list[PrintedClaim] = []
    for claim in claims if _SUBJECT.search(text) else ():
        names = {n for n in names_in(claim.chain or ()) if key_of(n) not in study.table}
        held = {name_latex(name): _component(name, study) for name in names}
        values |= {name: value for name, value in held.items() if value is not None}
        mine += [claim] * any(held.values())
    proved: dict[int, Study] = {}
    for sign in (1, -1) if mine else ():
        signed = {name: sign * value for name, value in values.items()}
        trial = replace(study, names={**study.names, **signed})
        outcomes = [value_or_none(verify, claim.chain, Check(), trial) for claim in mine]
        proved[sum(outcome is not None and outcome.verdict.proved for outcome in outcomes)] = trial
    return proved[max(proved)] if len(proved) == 2 else study


def component_indices(name: Name) -> Sequence[Any]:
    """The indices of a component of the curvature, that of the fibre first, else none; 12 stands
    for 1 and 2."""
    below = name.sub
    if len(below) == 1 and isinstance(below[0], Number) and len(below[0].text) == 2:
        below = tuple(map(Number, below[0].text))
    return (*name.sup, *below) if len(name.sup) == 1 and len(below) == 2 else ()


def has_running_indices(part: Node, study: Study) -> bool:
    r"""Whether a part is a component whose letters run over all indices, ``A_{ij}^{(\nu)}``."""
    indices = component_indices(part) if isinstance(part, Name) else ()
    below = indices[1:]
    return bool(indices) and all(
        isinstance(i, Name) and i.head in _INDEX_LETTERS and key_of(i) not in study.table
        for i in below
    )


def _component(name: Name, study: Study) -> Any:
    """The component of the system's curvature that a name stands for, else None."""
    fibration, places = study.context.system.fibration, list[int]()
    for position, index in enumerate(component_indices(name)):
        coordinates = fibration.base if position else fibration.fibre
        number = int(index.text) if isinstance(index, Number) else 0
        place = (
            coordinates[number - 1]
            if 0 < number <= len(coordinates)
            else value_or_none(evaluate, index, study)
        )
        if place not in coordinates:
            return None
        places.append(coordinates.index(place))
    return study.context.curvature[tuple(places)] if places else None
