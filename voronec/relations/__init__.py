"""How systems validate one another: relations of their motions, proved, and the diagram of them."""

from voronec.relations.declaration import Limit, Relation, Square

__all__ = ["Limit", "Relation", "Square"]
