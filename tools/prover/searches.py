"""What systems declare, searched for untold; and the rank test on a grid of parameters.

    python tools/fuzz.py searches [NAME ...] [--rank] [--degree D]

Of every system and each of its cases the declared measure, the reducing multiplier and the
integrals of the form that is searched are sought as if nothing were declared.  What is found has to
be proved by the prover of declared claims, and symmetries and gauge momenta by the exact algebra;
an integral counts as found where the search is complete and its form is the one searched.  With
``--rank`` the gyroscopic ball is tested at 400 points instead: an excess has to be there exactly
where an integral is shown.  Exit status 1 where anything is missed or not proved.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import sympy as sp

import voronec as vo
from voronec.errors import VoronecError

RATIOS = ((1, 1), (-1, 1), (2, 3), (1, 2), (3, 2), (-1, 2), (2, 1), (-2, 1), (1, 3), (5, 4))
"""epsilon = R1/(R1 + R2) of the rank test."""
MANY = 9
"""Systems with more variables are searched for integrals of degree 1 in the positions."""


def main() -> int:
    """Search, print a line for each, and the counts."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("names", nargs="*")
    parser.add_argument("--rank", action="store_true")
    parser.add_argument("--degree", type=int, default=6)
    chosen = parser.parse_args()
    if chosen.rank:
        return _rank(chosen.degree)
    counts: Counter[tuple[str, str]] = Counter()
    for name in chosen.names or vo.names():
        for kind, case, outcome, seconds in _of_system(vo.load(name)):
            counts[kind, outcome.partition(":")[0]] += 1
            print(f"{name:36}{case:30}{kind:13}{seconds:7.1f} s  {outcome}", flush=True)
    for (kind, outcome), count in sorted(counts.items()):
        print(f"{kind:13}{count:5}  {outcome}")
    bad = sum(n for (_, o), n in counts.items() if o.startswith(("missed", "not proved")))
    return 1 if bad else 0


def _of_system(system: Any) -> Iterator[tuple[str, str, str, float]]:
    for case, holder in (("", system), *system.cases.items()):
        at = dict(holder.parameters) if case else {}
        searches = {
            "measure": (holder.measure, vo.search_measures),
            "multiplier": (holder.multiplier, vo.search_reducing_multipliers),
        }
        for kind, (claim, search) in searches.items():
            if claim is not None or not case:
                found = partial(_density, claim is not None, partial(search, system, at=at))
                yield kind, case, *_with_seconds(found)
        if holder.integrals:
            yield "integrals", case, *_with_seconds(partial(_integrals, system, at))
        symmetries = partial(vo.search_symmetries, system, at=at)
        yield "symmetries", case, *_with_seconds(partial(_outcome, symmetries))
        gauge = partial(vo.search_gauge_momenta, system, at=at, positions=1)
        yield "gauge", case, *_with_seconds(partial(_outcome, gauge))


def _with_seconds(search: Callable[[], str]) -> tuple[str, float]:
    begin = time.process_time()
    try:
        outcome = search()
    except VoronecError as error:
        outcome = f"refused: {error}"
    return outcome, time.process_time() - begin


def _density(declared: bool, search: Callable[[], Any]) -> str:
    result = search()
    if result.found is None:
        return "missed: declared, and not found" if declared else "none declared, none found"
    if not result.found.verdict.proved:
        return f"not proved: {result.statement[:100]}" if declared else "undecided, none declared"
    return "declared, found and proved" if declared else "none declared, found and proved"


def _outcome(search: Callable[[], Any]) -> str:
    result = search()
    return f"proved: {result.statement}" if result.is_decided else f"not proved: {result.statement}"


def _integrals(system: Any, at: Any) -> str:
    few = len(system.coordinates) + len(system.velocities) <= MANY or system.invariants
    bounds: dict[str, Any] = {
        "degree": 2,
        "positions": 3 if few and len(system.invariants) <= 4 else 1,
    }
    result = vo.search_integrals(system, again=True, at=at, **bounds)
    unproved = [f.name for f in result.integrals if not f.verdict.proved]
    if unproved:
        return f"not proved: {', '.join(unproved)}"
    if not result.complete:
        return f"incomplete: {result.statement[:80]}"
    known = vo.search_integrals(system, at=at, **bounds)  # what is declared fills the same space
    return f"complete: {len(result.new)} found, declared {len(known.known)}, {len(known.new)} more"


def _rank(degree: int) -> int:
    """400 points: ten ratios of the radii, four gyroscopes, ten bodies."""
    sphere, plane = vo.load("gyroscopic-ball-on-sphere"), vo.load("gyroscopic-ball-on-plane")
    untold = {k: v for k, v in plane.integrals.items() if k in sphere.integrals}
    plane = replace(plane, integrals=untold)  # the vertical momentum is what has to show
    ratio = sp.Rational
    epsilons = [ratio(a, b) for a, b in RATIOS]
    wheels = [(0, 0, 0), (0, 0, ratio(1, 2)), (ratio(3, 10), ratio(-1, 5), ratio(1, 2)), (1, 2, 0)]
    bodies = [(ratio(4, 10), ratio(5, 10), ratio(6 + k, 10)) for k in range(10)]
    radius = [f"I{i} + I{j} - I{k}" for i, j, k in ((1, 2, 3), (2, 3, 1), (3, 1, 2))]
    begin, wrong, count = (time.perf_counter(), time.process_time()), 0, Counter[str]()
    for epsilon in epsilons:
        for wheel in wheels:
            for moments in bodies:
                at = {f"I{i + 1}": moments[i] for i in range(3)}
                at |= {f"kappa{i + 1}": wheel[i] for i in range(3)}
                system, name = (plane, "R") if epsilon == 1 else (sphere, "R2")
                if epsilon != 1:  # with R2 = 1
                    at["R1"] = epsilon / (1 - epsilon)
                body = (*radius, f"2*m*{name}^2 - I1 - I2 - I3")
                found = vo.exclude_rational_integrals(system, degree, at=at, body=body)
                shown = epsilon == 1 or (epsilon == -1 and not any(wheel))
                new = not found.is_decided
                words = "integral shown" if shown else "none shown"
                count[f"{words}, {'excess' if new else 'no excess'}"] += 1
                count["formal values"] += bool(found.formal)
                if new != shown:
                    wrong += 1
                    print(f"epsilon {epsilon}, kappa {wheel}, I {moments}: {found.statement}")
    for key, number in count.items():
        print(f"{number:5}  {key}")
    wall, cpu = time.perf_counter() - begin[0], time.process_time() - begin[1]
    print(f"degree {degree}: {wrong} wrong, {wall:.0f} s, {cpu:.0f} s of CPU")
    return 1 if wrong else 0
