"""A check from beginning to end: what is known is reused, the rest shared by processes."""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Iterable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from contextlib import closing
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

from voronec.algebra.arguments import CALLABLE, COUNT, SEVERAL, Kind, accepts
from voronec.declaration.whole_files import Store
from voronec.declaration.worker_processes import ProcessEnd, Team
from voronec.errors import DefinitionError, quote
from voronec.proof.check.inventory import Inventory, Trouble, names_read
from voronec.proof.check.report import Finding, Report, Result, mark_as_known
from voronec.proof.check.unit import Unit, units_of

if TYPE_CHECKING:
    from voronec.declaration.relation import Relation
    from voronec.declaration.system import System
    from voronec.equations.motions import Motions
    from voronec.proof.check.work import Derivations
    from voronec.proof.relations.decision import CheckedRelation


def check_relation(relation: Relation, systems: Iterable[System] = ()) -> CheckedRelation:
    """Prove or refute a relation, DPhi f = nu g(Phi) [Theory, eq. (15)].

    Source and target are looked for among ``systems``, then in the catalogue.  The answer has
    ``verdict``, the ``kinds`` of the relation, the ``levels`` on which it stands, and ``carried``:
    the claims of the target as they stand for the source.  Raises ``DefinitionError`` where the
    relation maps too little or too much.
    """
    from voronec.declaration.catalogue import load
    from voronec.declaration.reading import several
    from voronec.declaration.relation import Relation
    from voronec.declaration.system import System, require_system
    from voronec.equations.motions import Motions
    from voronec.proof.relations.decision import check_relation as decide

    if not isinstance(relation, Relation):
        raise DefinitionError(f"'{quote(relation)}' is not a voronec.Relation; give one")
    given = {s.name: s for s in map(require_system, several(systems, "systems", "system", System))}

    @cache
    def motions(name: str) -> Motions:
        return Motions.of(given[name] if name in given else load(name))

    return decide(relation, motions)


Progress = Callable[[str], None]


def _results_of(
    units: Sequence[Unit], jobs: int, started: Progress
) -> Generator[Result, None, None]:
    """The results of all units, as they come; ``started`` hears what is being worked on.

    With one unit or one job everything stays in this process.  When the iterator is closed, the
    other processes are ended.
    """
    jobs = min(jobs, len(units))
    if not units:  # nothing is imported for it
        return
    if jobs == 1:
        examine = Examiner()
        for unit in units:
            started(unit.name)
            yield examine(unit)
        return
    team = Team(jobs, Examiner())
    try:
        left = {team.submit(unit): unit for unit in units}
        while left:
            started(", ".join(unit.name for future, unit in left.items() if future.running()))
            for future in wait(left, return_when=FIRST_COMPLETED).done:
                yield _result(left.pop(future), future)
    finally:
        team.end()


@dataclass
class Examiner:
    """What examines units, and keeps what it derives."""

    bench: Derivations | None = None

    def __call__(self, unit: Unit) -> Result:
        """The result of a unit."""
        from voronec.proof.check.work import Derivations, examine

        self.bench = self.bench or Derivations()
        return examine(unit, self.bench)


def _result(unit: Unit, future: Future[Result]) -> Result:
    """The result of a unit that a process was at; that it died is one."""
    try:
        return future.result()
    except ProcessEnd as error:
        how = f"the process that checked it ended with status {error.status}"
        return Result(
            unit.kind, unit.name, unit.entry.place,
            (Finding(unit.kind, unit.name, "broken", how),),
        )  # fmt: skip


RESULTS = 3000
"""How many results, in whatever state of their sources, are kept."""


def user_store() -> Store:
    """Where results are kept between checks."""
    return Store.of_user("check", RESULTS)


def known_results(stock: Inventory, names: Iterable[str] = ()) -> list[Result]:
    """What earlier checks found of units that have not changed since; nothing is decided."""
    store, files = user_store(), dict[str, tuple[Path, ...]]()
    return [*_known(store, {u: u.key(files) for u in units_of(stock, [*names])}).values()]


@accepts(
    names=SEVERAL,
    stock=Kind("an inventory", lambda x: isinstance(x, Inventory), optional=True),
    store=Kind("a store of verdicts", lambda x: isinstance(x, Store), optional=True),
    jobs=Kind("a number of processes", lambda x: COUNT.holds(x) and x > 0, optional=True),
    progress=CALLABLE,
)
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

    Ctrl-C ends the check: the report then holds what is done and is marked ``stopped``.  Raises
    ``DefinitionError`` for a name that no system has.
    """
    begun = perf_counter()
    names = names_read("check_catalogue", names)
    stock = Inventory.of() if stock is None else stock
    units = units_of(stock, names)
    files: dict[str, tuple[Path, ...]] = {}
    keys = {} if store is None else {unit: unit.key(files) for unit in units}
    outcomes = _known(store, keys)
    pending = [unit for unit in units if unit not in outcomes]
    stopped = False
    tell = progress or (lambda _: None)
    by_name = {(unit.kind, unit.name): unit for unit in pending}
    running = _results_of(
        pending,
        jobs or os.cpu_count() or 1,
        lambda at: tell(f"{len(outcomes)} of {len(units)} done; at {at}"),
    )
    try:
        with closing(running):
            for result in running:
                unit = by_name[result.kind, result.name]
                outcomes[unit] = result
                if store is not None and unit.key({}) == keys[unit]:  # else edited meanwhile
                    store.save(keys[unit], "result", result.as_dict())
    except KeyboardInterrupt:
        stopped = True
    wrong = [
        trouble_result(t) for t in stock.all_troubles if not names or {t.name, t.owner} & {*names}
    ]
    results = (*wrong, *(outcomes[unit] for unit in units if unit in outcomes))
    return Report(tuple(results), perf_counter() - begun, stopped)


def _known(store: Store | None, keys: dict[Unit, str]) -> dict[Unit, Result]:
    """Results of earlier checks.  What failed is tried again: the cause may lie outside."""
    outcomes = {}
    for unit, key in keys.items():
        kept = store.load(key, "result") if store is not None else None
        if kept is not None and (result := Result.from_dict(kept)).status != "broken":
            outcomes[unit] = mark_as_known(result)
    return outcomes


def trouble_result(trouble: Trouble) -> Result:
    """What is wrong at sight, as a result."""
    finding = Finding(trouble.kind, trouble.name, "broken", trouble.why)
    return Result(trouble.kind, trouble.name, trouble.place, (finding,), systems=(trouble.owner,))
