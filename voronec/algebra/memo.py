"""What is computed of a value once: an object holds it, and it is forgotten with the object."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from functools import wraps
from operator import attrgetter
from typing import Any, TypeVar

T = TypeVar("T")
Owner = TypeVar("Owner")
Key = TypeVar("Key")
NOTHING: Any = object()


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
        result: T = self._known[what]
        return result

    def last(self, what: Hashable, key: Any, make: Callable[[], T]) -> T:
        """The result of that name for a key, made anew where another key was asked for last."""
        kept = self._known.get(what)
        if kept is None or kept[0] != key:
            kept = self._known[what] = key, make()
        result: T = kept[1]
        return result

    def __reduce__(self) -> Any:
        return Memo, ()


def remember(place: str) -> Callable[[Callable[[Owner, Key], T]], Callable[[Owner, Key], T]]:
    """For methods of one argument: each is worked on once, and what is found kept in a dictionary
    that the object has, its attribute ``place``."""
    dictionary = attrgetter(place)

    def decorate(method: Callable[[Owner, Key], T]) -> Callable[[Owner, Key], T]:
        @wraps(method)
        def find(owner: Owner, key: Key) -> T:
            known: dict[Key, T] = dictionary(owner)
            result: T = known.get(key, NOTHING)
            if result is NOTHING:
                result = known[key] = method(owner, key)
            return result

        return find

    return decorate
