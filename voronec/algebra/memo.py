"""What is computed of a value once: the value holds it, and it is forgotten with the value."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any, TypeVar

__all__ = ["Memo"]

T = TypeVar("T")


class Memo:
    """Results that belong to a value, by what they are; a copy of it begins with none.

    A class whose values others compute with has one, as ``memo``: a room above can keep there what
    the value itself knows nothing of.
    """

    def __init__(self) -> None:
        self._known: dict[Hashable, Any] = {}

    def once(self, what: Hashable, make: Callable[[], T]) -> T:
        """The result of that name, made when it is first asked for."""
        if what not in self._known:
            self._known[what] = make()
        found: T = self._known[what]
        return found

    def __reduce__(self) -> Any:
        return Memo, ()
