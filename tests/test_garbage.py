"""What is loaded in one go is looked through with all that is old."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Iterator

import pytest

from voronec.declaration.catalogue import no_collection


class Loop:
    """An object that holds itself: only a search finds that nobody else does."""

    def __init__(self) -> None:
        self.own = self


@pytest.fixture
def collection() -> Iterator[None]:
    gc.enable()
    gc.unfreeze()
    before = gc.get_threshold()
    gc.set_threshold(1_000)
    yield
    gc.set_threshold(*before)
    gc.unfreeze()
    gc.enable()


def young() -> int:
    return sum(type(x) is Loop for k in (0, 1) for x in gc.get_objects(generation=k))


def test_what_was_made_inside_is_old(collection: None) -> None:
    with no_collection():
        assert not gc.isenabled()
        made = [Loop() for _ in range(10_000)]
        assert young() == len(made)
    assert gc.isenabled() and young() == 0


@pytest.mark.slow
def test_what_nobody_holds_is_found_by_a_search_of_all(collection: None) -> None:
    with no_collection():
        made = [weakref.ref(Loop()) for _ in range(1_000)]
    gc.collect()
    assert all(loop() is None for loop in made)


@pytest.mark.slow
def test_what_somebody_froze_stays_frozen(collection: None) -> None:
    gc.freeze()
    frozen = gc.get_freeze_count()
    with no_collection():
        pass
    assert gc.get_freeze_count() == frozen > 0


def test_where_searches_are_off_they_stay_off(collection: None) -> None:
    gc.disable()
    with no_collection():
        pass
    assert not gc.isenabled()
