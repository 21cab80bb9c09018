"""A check from beginning to end: what is known is reused, the rest is worked on."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from contextlib import closing
from pathlib import Path
from time import perf_counter

from voronec.checking.inventory import Inventory, Trouble
from voronec.checking.pool import results_of
from voronec.checking.record import Finding, Report, Result, marked
from voronec.checking.unit import Unit, units_of
from voronec.keeping import Store

__all__ = ["broken", "check_catalogue", "known_results", "user_store"]

KEPT = 3000
"""How many results, in whatever state of their sources, are kept."""


def user_store() -> Store:
    """Where results are kept between checks."""
    return Store.of_user("check", KEPT)


def known_results(stock: Inventory, names: Iterable[str] = ()) -> list[Result]:
    """What earlier checks found of units that have not changed since; nothing is decided."""
    store, files = user_store(), dict[str, tuple[Path, ...]]()
    return [*_known(store, {u: u.key(files) for u in units_of(stock, [*names])}).values()]


def check_catalogue(
    names: Sequence[str] = (),
    stock: Inventory | None = None,
    jobs: int | None = None,
    store: Store | None = None,
    progress: Callable[[str], None] | None = None,
) -> Report:
    """Prove or refute everything that the systems declare, or what has to do with some of them.

    names
        of systems: these, their claims, and the relations and squares in which they stand.
    jobs
        processes; as many as there are processors unless told.
    store
        where results are kept; those whose sources and engine are unchanged are taken from there.

    Ctrl-C ends the check: the report then holds what is done and is marked ``stopped``.
    """
    begun = perf_counter()
    stock = Inventory.of() if stock is None else stock
    units = units_of(stock, names)
    files: dict[str, tuple[Path, ...]] = {}
    keys = {} if store is None else {unit: unit.key(files) for unit in units}
    found = _known(store, keys)
    pending = [unit for unit in units if unit not in found]
    stopped = False
    tell = progress or (lambda _: None)
    by_name = {(unit.kind, unit.name): unit for unit in pending}
    running = results_of(
        pending,
        jobs or os.cpu_count() or 1,
        lambda at: tell(f"{len(found)} of {len(units)} done; at {at}"),
    )
    try:
        with closing(running):
            for result in running:
                unit = by_name[result.kind, result.name]
                found[unit] = result
                if store is not None and unit.key({}) == keys[unit]:  # else edited meanwhile
                    store.save(keys[unit], "result", result.as_dict())
    except KeyboardInterrupt:
        stopped = True
    wrong = [broken(t) for t in stock.all_troubles if not names or {t.name, t.owner} & {*names}]
    results = (*wrong, *(found[unit] for unit in units if unit in found))
    return Report(tuple(results), perf_counter() - begun, stopped)


def _known(store: Store | None, keys: dict[Unit, str]) -> dict[Unit, Result]:
    """Results of earlier checks.  What failed is tried again: the cause may lie outside."""
    found = {}
    for unit, key in keys.items():
        result = Result.from_dict(store.load(key, "result")) if store is not None else None
        if result is not None and result.status != "broken":
            found[unit] = marked(result)
    return found


def broken(trouble: Trouble) -> Result:
    """What is wrong at sight, as a result."""
    finding = Finding(trouble.kind, trouble.name, "broken", trouble.why)
    return Result(trouble.kind, trouble.name, trouble.place, (finding,), systems=(trouble.owner,))
