"""What systems declare, in names that JSON can hold, and what is wrong with it at sight."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from voronec.declaration.relation import Square

__all__ = ["Contents", "Edge", "Face", "Summary", "Trouble"]


@dataclass(frozen=True)
class Trouble:
    """What cannot be checked, and why; ``owner`` is the system beside which it stands."""

    kind: str
    name: str
    owner: str
    place: str
    why: str


@dataclass(frozen=True)
class Summary:
    """What a system is called, how many claims it makes, and its scenes."""

    title: str
    claims: int
    scenes: tuple[str, ...]


@dataclass(frozen=True)
class Edge:
    """A relation by its names; it stands beside the system ``owner``, at a ``position``.

    ``line`` is the kind that its declaration shows.
    """

    label: str
    owner: str
    position: int
    source: str
    target: str
    line: str
    note: str


@dataclass(frozen=True)
class Face:
    """A square by the labels of its relations; at position -1 where nobody names it."""

    label: str
    owner: str
    position: int
    first: tuple[str, ...]
    second: tuple[str, ...]
    up_to: str
    name: str

    def declaration(self) -> Square:
        """The square itself."""
        from voronec.declaration.relation import Square

        return Square(self.first, self.second, self.up_to, self.name)


@dataclass(frozen=True)
class Contents:
    """What the systems of an inventory declare, in names.

    ``families`` holds the members of each system that has some, and whether a member is the one
    that stands for its family.
    """

    systems: Mapping[str, Summary]
    families: Mapping[str, Mapping[str, bool]]
    relations: tuple[Edge, ...]
    faces: tuple[Face, ...]
    troubles: tuple[Trouble, ...] = ()

    @classmethod
    def from_dict(cls, data: Any) -> Contents | None:
        """The contents that were written as a dictionary; ``None`` where the data are none."""
        try:
            systems = {
                n: Summary(**s | {"scenes": (*s["scenes"],)}) for n, s in data["systems"].items()
            }
            faces = (
                Face(**f | {"first": (*f["first"],), "second": (*f["second"],)})
                for f in data["faces"]
            )
            return cls(
                systems, data["families"], tuple(Edge(**e) for e in data["relations"]), tuple(faces)
            )
        except (AttributeError, KeyError, TypeError):
            return None
