"""Rows of the table of figures of the closed form: accuracy, and what it costs."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from functools import cache, partial
from typing import Any

import mpmath
import numpy as np

import voronec as vo
from figures.closed_motion import NAMES, Motion
from figures.closed_references import STORE, apart, exact_start
from figures.table import Row
from voronec.accuracy.bench import time_fastest
from voronec.equations.program import Program, hoist, taylor_system

ANGLES = NAMES[:5]
PERIODS = 100
LATE = 1e6
INSTANTS = 100_000
LEAST = 1e-14
"""The unit of angles that have no last place to speak of."""
WORK_DIGITS = 90
"""Digits of the independent motions that enclosures must contain."""


@cache
def references() -> dict[str, dict[str, Any]]:
    """The stored motions by name, each with its values."""
    found: dict[str, dict[str, Any]] = json.loads(STORE.read_text("utf-8"))
    return found


@cache
def closed_form(name: str) -> Any:
    """The closed form of a stored motion."""
    start = exact_start(references()[name]["given"])
    return vo.closed_form(
        vo.load("demchenko"), parameters=start["parameters"], initial=start["initial"]
    )


def _of(group: str) -> list[str]:
    return [name for name, told in references().items() if told["group"] == group]


def errors(name: str, late: bool, modulo: bool = True) -> dict[str, float]:
    """The largest error in doubles of every angle of a stored motion, modulo 2 pi."""
    told, closed = references()[name], closed_form(name)
    rows = told["values"]
    early = [r for r in rows if not told["period"] or _within(r[0], told["period"])]
    chosen = [r for r in rows if r not in early] if late else early
    times = np.array([float.fromhex(r[0]) for r in chosen])
    found = (closed.modulo if modulo else closed.at)(times, ANGLES)
    with mpmath.workdps(50):
        return {
            n: float(max(
                apart(n, mpmath.mpf(float(x)), mpmath.mpf(r[1 + i]))
                for x, r in zip(found[n], chosen, strict=True)
            ))
            for i, n in enumerate(ANGLES)
        }  # fmt: skip


def _within(instant: str, period: str) -> bool:
    return float.fromhex(instant) < (PERIODS + 1) * float(period)


def _worst(group: str, late: bool, modulo: bool = True) -> tuple[float, str]:
    found = ((e, f"{n} of {m}") for m in _of(group) for n, e in errors(m, late, modulo).items())
    return max(found)


def early() -> Iterator[Row]:
    """Doubles after 100 periods."""
    worst, where = _worst("class", late=False)
    yield Row(
        f"doubles, {PERIODS} periods, {len(_of('class'))} motions of all classes, outer, inner and "
        "shell, every angle modulo 2 pi, against 42 digits",
        f"{worst:.1e} ({where})",
    )
    worst, where = _worst("class", late=False, modulo=False)
    yield Row(
        "the same, longitudes and theta continuous (whole turns take digits)",
        f"{worst:.1e} ({where})",
    )


def late() -> Iterator[Row]:
    """Doubles after a million periods."""
    worst, where, places = 0.0, "", 0.0
    for name in _of("class"):
        largest = closed_form(name).at([_last(name)], ANGLES)
        for angle, error in errors(name, late=True, modulo=False).items():
            unit = float(np.spacing(np.abs(largest[angle])[0]))
            places = max(places, error / max(unit, LEAST))
            worst, where = max((worst, where), (error, f"{angle} of {name}"))
    yield Row(
        "doubles, 1e6 periods, the same motions, longitudes and theta continuous",
        f"{worst:.1e} ({where}); {places:.1f} units of the last place of the angle at worst",
    )
    worst, where = _worst("class", late=True)
    yield Row("doubles, 1e6 periods, when asked: angles modulo 2 pi", f"{worst:.1e} ({where})")


def _last(name: str) -> float:
    return float.fromhex(references()[name]["values"][-1][0])


def rigorous() -> Iterator[Row]:
    """Enclosures at a million periods, against motions integrated independently."""
    widest, missed, seconds = 0.0, [], []
    for name in _of("class"):
        told = references()[name]
        motion = Motion(told["given"], "theta" not in told["given"], WORK_DIGITS)
        t = Fraction(float.fromhex(told["values"][-1][0]))
        began = time.process_time()
        found = closed_form(name).enclose(t, digits=50)
        seconds.append(time.process_time() - began)
        true = motion.later(t)
        for n in NAMES:
            wide, inside = _enclosure(n, found[n], true[n])
            widest = max(widest, wide)
            missed += [] if inside else [f"{n} of {name}"]
    told_missed = f"; not containing {', '.join(missed)}" if missed else ", all containing it"
    yield Row(
        f"rigorous, 50 digits, 1e6 periods, all coordinates and spins: width, and an independent "
        f"motion in {WORK_DIGITS} digits, by whole periods",
        f"{widest:.0e}{told_missed}; {np.median(seconds):.2g} s of CPU each",
    )


def routes() -> Iterator[Row]:
    """The stored references by their two routes."""
    found = {n: float(told["followed"]) for n, told in references().items() if "followed" in told}
    worst, where = max((x, n) for n, x in found.items())
    yield Row(
        f"the references themselves, {len(found)} motions: whole periods of one period against "
        f"integration all the way through {PERIODS} periods",
        f"{worst:.1e} ({where})",
    )


def _enclosure(name: str, ball: Any, true: Any) -> tuple[float, bool]:
    """The width of an enclosure, and whether it holds a number that is right to 1e-60."""
    with mpmath.workdps(WORK_DIGITS):
        middle, radius = (mpmath.mpf(_digits(part)) for part in (ball.mid(), ball.rad()))
        return float(2 * radius), bool(apart(name, middle, true) <= radius + mpmath.mpf("1e-60"))


def _digits(exact: Any) -> str:
    return str(exact.str(2 * WORK_DIGITS, radius=False))


def hard_table() -> list[tuple[str, float, float, float]]:
    """For every hard case: its largest error in doubles up to 100 periods and at a million, and
    how wide an enclosure of 20 digits is there."""
    found = []
    for group in ("hard", "asymptotic"):
        for name in _of(group):
            told = references()[name]
            balls = closed_form(name).enclose(_last(name), digits=20)
            wide = max(float(balls[n].rad()) for n in ANGLES)
            later = max(errors(name, True).values()) if told["period"] else float("nan")
            shown = name if group == "hard" else f"double root, no period: {name}"
            found.append((shown, max(errors(name, False).values()), later, wide))
    return found


def hard() -> Iterator[Row]:
    """The hard cases, family by family."""
    families: dict[str, list[tuple[float, float, str]]] = {}
    for name, soon, later, _ in hard_table():
        about = name.rpartition(", ")[0] if "1e" in name else name
        families.setdefault(about, []).append((soon, later, name.rpartition(", ")[2]))
    for about, found in families.items():
        soon, later = max(f[0] for f in found), max(f[1] for f in found)
        sizes = f"{found[0][2]} ... {found[-1][2]}" if len(found) > 1 else ""
        told = f"{soon:.1e}" if later != later else f"{soon:.1e}; at 1e6 periods {later:.1e}"
        yield Row(
            f"hard case, doubles, {PERIODS} periods: {about}" + (f", {sizes}" if sizes else ""),
            told,
        )


def dense() -> Iterator[Row]:
    """A hundred thousand instants by the closed form, and by heyoka's steps: its dense output, and
    as runs of ``integrate``; the momentum upright or not, and however late."""
    for name, about in (
        (
            "outer B", f"over {PERIODS} periods, against heyoka's dense output at tolerance "
            "2.3e-16, compiled, set-up excluded",
        ),
        (
            "outer A", f"the momentum not upright, {PERIODS} periods, against heyoka's dense "
            "output as above",
        ),
    ):  # fmt: skip
        times = _grid(name, PERIODS)
        heyoka = _by_steps(exact_start(references()[name]["given"]), times)
        yield _faster(
            f"{INSTANTS:g} instants of all five coordinates, {about}",
            time_fastest(partial(closed_form(name).at, times, ANGLES))[1],
            time_fastest(heyoka)[1],
        )
    seconds = []
    for periods in (PERIODS, 1e4, LATE):
        times = _grid("outer B", periods)
        seconds.append(time_fastest(partial(closed_form("outer B").at, times, ANGLES))[1])
    ratios = [x / seconds[0] for x in seconds[1:]]
    yield Row(
        f"cost of {INSTANTS:g} instants over 1e4 and 1e6 periods, of that over {PERIODS}",
        " and ".join(f"{r:.2f}" for r in ratios) + " times",
    )
    for name, about in (("outer B", "upright"), ("outer A", "not upright")):
        yield _faster(
            f"run of integrate on {INSTANTS:g} instants, the momentum {about}, {PERIODS} periods, "
            "against the method heyoka at tolerance 2.3e-16, set-up excluded",
            *(_run_time(name, method) for method in ("closed-form", "heyoka")),
        )


def _grid(name: str, periods: float) -> np.ndarray:
    return np.linspace(0.0, periods * closed_form(name).period, INSTANTS)


def _faster(what: str, closed: float, heyoka: float) -> Row:
    """Seconds of the closed form against those of heyoka."""
    ratio = heyoka / closed
    return Row(what, f"{ratio:.2f} times as fast ({1e3 * heyoka:.0f} / {1e3 * closed:.0f} ms)")


def _run_time(name: str, method: str) -> float:
    """The least CPU time of a run on the grid."""
    start = exact_start(references()[name]["given"])
    tol = 2.3e-16 if method == "heyoka" else 1e-13
    runs = (
        vo.integrate(
            vo.load("demchenko"), parameters=start["parameters"], initial=start["initial"],
            times=_grid(name, PERIODS), outputs=ANGLES, method=method, tol=tol,
        )
        for _ in range(5)
    )  # fmt: skip
    return min(run.cost.cpu for run in runs)


def _by_steps(start: Mapping[str, Mapping[str, Any]], times: np.ndarray) -> Callable[[], None]:
    """heyoka's run along a grid, compiled: the equations in all eight coordinates and spins."""
    import heyoka as hy

    program = Program.of(vo.derive(vo.load("demchenko")).form)
    numbers = {**start["parameters"], **start["initial"]}
    state, values = ([float(numbers[str(x)]) for x in some] for some in (
        program.state, program.parameters
    ))  # fmt: skip
    raised = hoist(program)
    integrator = hy.taylor_adaptive(
        taylor_system(raised.program), state, pars=raised.values(values), tol=2.3e-16
    )

    def run() -> None:
        integrator.time, integrator.state[:] = 0.0, state
        integrator.propagate_grid(times)

    return run


ROWS: dict[str, Callable[[], Iterator[Row]]] = {
    "early": early,
    "late": late,
    "followed": routes,
    "rigorous": rigorous,
    "hard": hard,
    "dense": dense,
}
