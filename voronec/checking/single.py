"""One relation decided by itself, for whoever tries one out."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from typing import TYPE_CHECKING

from voronec.catalogue import load
from voronec.errors import DefinitionError, shown
from voronec.reading import several
from voronec.relations import Relation
from voronec.system import System, require_system
from voronec.vector_field import Motions

if TYPE_CHECKING:
    from voronec.relations.checking import CheckedRelation

__all__ = ["check_relation"]


def check_relation(relation: Relation, systems: Iterable[System] = ()) -> CheckedRelation:
    """Prove or refute a relation, DPhi f = nu g(Phi) [Theory, eq. (15)].

    Source and target are looked for among ``systems``, then in the catalogue.  The answer has
    ``verdict``, the ``kinds`` of the relation, the ``levels`` on which it stands, and ``carried``:
    the claims of the target as they stand for the source.  Raises ``DefinitionError`` where the
    relation maps too little or too much.
    """
    from voronec.relations.checking import check_relation as decide

    if not isinstance(relation, Relation):
        raise DefinitionError(f"'{shown(relation)}' is not a voronec.Relation; give one")
    own = {s.name: s for s in map(require_system, several(systems, "systems", "system", System))}

    @cache
    def motions(name: str) -> Motions:
        return Motions.of(own[name] if name in own else load(name))

    return decide(relation, motions)
