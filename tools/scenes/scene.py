"""One random scene of the fuzzer: drawn, run by the engine and by the referee, and judged."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from random import Random
from typing import Any

import mpmath as mp
import numpy as np
import sympy as sp

import voronec as vo
from scenes.mechanics import KINDS_OF_MECHANICS, Case, source_of
from scenes.reference import Motion, NoReferee, Referee, mechanics_of

KINDS = ("smooth", "singular", "nonsmooth", "inputs", "turns")
BLOCK = 5
"""Scenes in a row share their system, which is derived and compiled once."""
UNIT = 1.1e-16
FLOOR = 1e-10
NEARBY = 1e-11
"""How far away the starts are that tell the condition of a motion."""
SAMPLES = 3
WELL = 1e8
LOOSE = {"lsoda": 1000.0}
"""How much more a method makes of the tolerance: steps of low order are many."""
SHARP = {"scipy": 1e-13 / (100 * UNIT)}
"""How many times 100 units a step may err where the estimate of a method is sharp: DOP853 errs by
its tolerance, 1e-13, and by more than 100 units even on x' = x."""
LOSSES = ("errors add up", "lost there by rounding")
"""What notes say of a run that knows that it lost digits."""
BLUR = 0.1
"""Where so large a part of a value may be wrong, nothing can be said about it."""
INSTANTS = 8
"""So many instants of a grid are compared."""


def catalogue_names() -> list[str]:
    """Systems of the catalogue, without loading one."""
    return [n for n in vo.names() if "rolling-body" not in n]


@dataclass(frozen=True)
class Scene:
    """What is asked of the engine."""

    bridge: str
    parameters: Mapping[str, float]
    initial: Mapping[str, float]
    times: list[float]
    outputs: tuple[str, ...]
    method: str
    tol: float
    inputs: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Truth:
    """Values of outputs at some instants, and how far off an answer may be."""

    places: list[int]
    values: list[dict[str, float]]
    bounds: list[dict[str, float]]
    condition: float
    pivot: float
    note: str = ""


class _NoTruth(Exception):
    """The referee cannot tell."""


@dataclass
class _Bench:
    """A system, derived and compiled."""

    system: vo.System
    made: Case | None
    equations: Any
    referee: Referee


class Workshop:
    """Draws and judges scenes; the number of a scene and the seed are all it depends on."""

    def __init__(self, seed: int, only: str | None) -> None:
        self.seed, self.only = seed, only
        self._benches: dict[tuple[str, int], tuple[str, _Bench | Exception]] = {}

    def judge(
        self, kind: str, index: int, announce: Callable[[str, str], Any]
    ) -> tuple[str, str, str, str]:
        """System, outcome, detail and snippet of one scene; system and snippet are announced
        before it runs, since it may never end."""
        name, bench = self._bench(kind, index // BLOCK)
        if isinstance(bench, NoReferee):
            return name, "not judged", str(bench), ""
        if isinstance(bench, Exception):
            rough = ", not smooth" if kind == "nonsmooth" else ""
            return name, f"refused{rough}", f"the system: {bench}", ""
        dice = Random(f"{self.seed} {kind} {self.only} scene {index}")
        scene = _draw(dice, bench, kind)
        if scene is None:
            return name, "not judged", "no possible parameters", ""
        snippet = _snippet(bench, scene)
        announce(name, snippet)
        outcome, detail = _judge(bench, scene, kind)
        return name, outcome, detail, snippet

    def _bench(self, kind: str, block: int) -> tuple[str, _Bench | Exception]:
        """The system of a block, and its name; or why there is none."""
        if (kind, block) not in self._benches:
            self._benches = {(kind, block): self._make(kind, block)}
        return self._benches[kind, block]

    def _make(self, kind: str, block: int) -> tuple[str, _Bench | Exception]:
        dice = Random(f"{self.seed} {kind} {self.only} block {block}")
        names = catalogue_names()
        if kind == "turns":
            names = [n for n in names if "ball" in n and "rn" not in n]
        made = None
        own = kind in ("nonsmooth", "inputs") or dice.random() < 0.4
        if self.only == "made" or (self.only is None and own):
            made = dice.choice(KINDS_OF_MECHANICS[kind])(dice)
            system = made.system
        else:
            system = vo.load(self.only or dice.choice(names))
        try:
            named = {sp.Function(u)(vo.time): e for u, e in (made.inputs if made else {}).items()}
            referee = Referee(mechanics_of(system, named))
            return system.name, _Bench(system, made, vo.derive(system), referee)
        except (NoReferee, vo.VoronecError) as error:
            return system.name, error


def _draw(dice: Random, bench: _Bench, kind: str) -> Scene | None:
    parameters = _parameters(dice, bench)
    if parameters is None:
        return None
    system, mechanics = bench.system, bench.referee.mechanics
    size = bench.made.size if bench.made else 1.0
    initial = {n: round(dice.gauss(0, size), 3) for n in mechanics.coordinates}
    initial |= {n: round(dice.gauss(0, size), 3) for n in mechanics.velocities}
    for name, place in (bench.made.centre if bench.made else {}).items():
        initial[name] += place
    scenes = list(system.scenes.values())
    if scenes and dice.random() < 0.7:
        own = _scene_start(dice.choice(scenes), system, parameters)
        spread = dice.choice((0.0, 0.01, 0.3))
        for name in initial:
            if name in own:
                initial[name] = own[name] + spread * initial[name]
    if kind == "singular" and mechanics.coordinates:
        _singular(dice, bench, initial)
    if kind == "nonsmooth" and dice.random() < 0.3:
        initial[dice.choice(list(initial))] = 0.0
    start = _on_relations(bench, initial, parameters)
    if start is None:
        return None
    times = _grid(dice, (bench.made.span if bench.made else 10.0), bool(kind == "nonsmooth"))
    method, tol = _method(dice, bench, kind, times)
    outputs: tuple[str, ...] = ()
    if dice.random() < 0.4:
        names = [*mechanics.coordinates, *mechanics.velocities, *system.invariants]
        outputs = tuple(dice.sample(names, dice.randint(1, min(3, len(names)))))
    bridge = dice.choice(("integrate",) * 8 + ("dense", "ensemble"))
    if method not in ("auto", "heyoka", "scipy") or len(times) < 2:
        bridge = "integrate"
    if bridge != "integrate" and kind == "turns":
        bridge = "integrate"
    inputs = bench.made.inputs if bench.made else {}
    if inputs:
        bridge = "integrate"
    kinds = tuple((u, dice.choice(("expression", "expression", "function"))) for u in inputs)
    return Scene(bridge, parameters, start, times, outputs, method, tol, kinds)


def _parameters(dice: Random, bench: _Bench) -> dict[str, float] | None:
    """Values near the defaults, at which such a body exists."""
    if bench.made:
        return dict(bench.made.parameters)
    system = bench.system
    own = dict(dice.choice(list(system.scenes.values())).parameters) if system.scenes else {}
    own = {str(name): x for name, x in own.items()}
    for attempt in range(40):
        spread = 0.0 if attempt == 39 or dice.random() < 0.3 else 0.6
        values = {}
        for p in system.parameters:
            base = sp.sympify(own.get(p.name, p.value))
            if base is None or base.free_symbols - {q.symbol for q in system.parameters}:
                return None
            defaults = {q.symbol: own.get(q.name, q.value) for q in system.parameters}
            while base.free_symbols:
                base = base.xreplace({s: sp.sympify(defaults[s]) for s in base.free_symbols})
            values[p.name] = float(base) * math.exp(spread * dice.uniform(-1, 1))
        try:
            for p in system.parameters:
                p.check(values[p.name])
        except vo.DefinitionError:
            continue
        exact = {p.symbol: sp.Float(values[p.name]) for p in system.parameters}
        if all(sp.sympify(c).xreplace(exact) == sp.true for c in system.possible.values()):
            return values
    return None


def _scene_start(scene: Any, system: vo.System, parameters: Mapping[str, float]) -> dict[str, Any]:
    exact = {p.symbol: parameters[p.name] for p in system.parameters}
    start = {}
    for name, value in scene.initial.items():
        value = sp.sympify(value).xreplace(exact)
        if value.is_number:
            start[str(name)] = float(value)
    return start


def _singular(dice: Random, bench: _Bench, initial: dict[str, float]) -> None:
    """Put a coordinate, sometimes two, at or near multiples of right angles, and perhaps stop a
    velocity."""
    mechanics = bench.referee.mechanics
    likely = list((bench.made.singular if bench.made else ()) or mechanics.coordinates)
    for name in dice.sample(likely, min(len(likely), dice.choice((1, 1, 2)))):
        place = dice.choice((0.0, 0.0, math.pi / 2, math.pi, -math.pi / 2))
        off = dice.choice((0.0, 1e-12, 1e-9, 1e-7, 1e-5, 1e-4, 1e-3, 1e-2, 0.1))
        initial[name] = place + dice.choice((-1, 1)) * off
    if dice.random() < 0.3:
        initial[dice.choice(list(mechanics.velocities))] = dice.choice((0.0, 1e-8))


def _on_relations(
    bench: _Bench, initial: dict[str, float], parameters: Mapping[str, float]
) -> dict[str, float] | None:
    """Redundant coordinates moved onto their relations."""
    referee = bench.referee
    m = referee.mechanics
    if not m.relations:
        return initial
    q, p = [initial[n] for n in m.coordinates], [parameters[n] for n in m.parameters]
    try:
        moved = referee.onto_relations(q, p)
    except (ZeroDivisionError, ValueError):
        return None
    return {**initial, **{n: float(x) for n, x in zip(m.coordinates, moved, strict=True)}}


def _grid(dice: Random, span: float, short: bool) -> list[float]:
    end = round(span * math.exp(dice.uniform(-3, 0.7 if not short else 0.3)), 3)
    if dice.random() < 0.04 and not short:
        end *= 10
    begin = dice.choice((0.0, 0.0, 0.0, 0.5))
    way = dice.choice((1, 1, 1, -1))
    kind = dice.random()
    if kind < 0.4:
        times = [0.0, end]
    elif kind < 0.6:
        times = list(map(float, np.linspace(0, end, dice.choice((5, 11, 101)))))
    elif kind < 0.75:
        times = list(map(float, np.linspace(0, end, 1001)))
    elif kind < 0.95:
        times = sorted({0.0, *(round(dice.uniform(0, end), 6) for _ in range(6))})
    else:
        times = [0.0]
    return [begin + way * t for t in times]


def _method(dice: Random, bench: _Bench, kind: str, times: list[float]) -> tuple[str, float]:
    method = dice.choice(("auto",) * 5 + ("heyoka", "heyoka", "scipy", "lsoda", "flint"))
    tol = dice.choice((1e-13,) * 4 + (1e-16, 1e-10))
    if bench.system.motion is not None and dice.random() < (0.5 if kind == "turns" else 0.2):
        return "closed-form", 1e-13
    if method == "flint":
        if abs(times[-1] - times[0]) > 3 or len(times) > 20:
            return "auto", tol
        tol = dice.choice((1e-13, 1e-20))
    return method, tol


def _judge(bench: _Bench, scene: Scene, kind: str) -> tuple[str, str]:
    """Outcome and detail: the engine first, since what it answers decides what is asked."""
    error: vo.VoronecError | None = None
    answer: Mapping[str, Any] = {}
    notes: tuple[str, ...] = ()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            answer, notes = answer_of(bench, scene)
    except vo.VoronecError as refusal:
        error = refusal
    except Exception as failure:
        return "broken", f"{type(failure).__name__}: {failure}"
    try:
        truth = _truth(bench, scene)
    except (_NoTruth, NoReferee) as reason:
        return f"no truth{', refused' if error else ''}", str(reason)
    if error is not None:
        if truth.note:
            return "refused, singular", str(error)
        if kind == "nonsmooth" or bench.referee.switches.functions:
            return "refused, not smooth", str(error)
        if truth.condition < WELL and truth.pivot > 1 / WELL:
            return "refused", f"{error} (condition {truth.condition:.1e})"
        return "refused, ill-conditioned", str(error)
    outcome, detail = _compare(scene, truth, answer)
    if outcome == "wrong" and any(word in note for note in notes for word in LOSSES):
        return "wrong, and said so", detail
    return outcome, detail


def _compare(scene: Scene, truth: Truth, answer: Mapping[str, Any]) -> tuple[str, str]:
    worst, said = -1.0, ""
    for place, values, bounds in zip(truth.places, truth.values, truth.bounds, strict=True):
        for name, value in values.items():
            if name not in answer or bounds[name] > BLUR * max(1.0, abs(value)):
                continue
            off = abs(float(answer[name][place]) - value)
            ratio = off / bounds[name] if math.isfinite(off) else math.inf
            if ratio > worst:
                worst = ratio
                said = (
                    f"{name} at t = {scene.times[place]} is {answer[name][place]}, truth {value!r},"
                    f" off by {off:.1e}, allowed {bounds[name]:.1e}; method {scene.method}, "
                    f"tol {scene.tol}, door {scene.bridge}{truth.note}"
                )
    if worst < 0:
        return "no truth", "the errors of one unit in the last place outgrow the motion"
    return ("wrong", said) if worst > 1 else ("right", said)


def answer_of(bench: _Bench, scene: Scene) -> tuple[dict[str, Any], tuple[str, ...]]:
    """What the engine answers: output -> values on the grid, and its notes."""
    common: dict[str, Any] = {"outputs": scene.outputs, "tol": scene.tol, "method": scene.method}
    names = scene.outputs or _everything(bench)
    if scene.bridge == "ensemble":
        nearby = {k: v + (0.1 if k in bench.referee.mechanics.velocities else 0.0)
                  for k, v in scene.initial.items()}  # fmt: skip
        found = vo.ensemble(bench.equations, [dict(scene.initial), nearby], times=scene.times,
                            parameters=dict(scene.parameters), **common)  # fmt: skip
        if 0 in found.errors:
            raise found.errors[0]
        return {n: found[n][0] for n in names}, ()
    dense = scene.bridge == "dense"
    grid = [scene.times[0], scene.times[-1]] if dense else scene.times
    if scene.inputs and bench.made:
        common["inputs"] = {
            u: sp.lambdify(vo.time, bench.made.inputs[u]) if kind == "function"
            else bench.made.inputs[u]
            for u, kind in scene.inputs
        }  # fmt: skip
        if any(kind == "function" for _, kind in scene.inputs):
            common["method"] = "auto"  # functions are for scipy
    motion = vo.integrate(bench.equations, times=grid, initial=dict(scene.initial), dense=dense,
                          parameters=dict(scene.parameters), **common)  # fmt: skip
    seen = motion.at(scene.times) if dense else motion
    return {n: seen[n] for n in names}, motion.notes


def _everything(bench: _Bench) -> tuple[str, ...]:
    m = bench.referee.mechanics
    return (*m.coordinates, *m.velocities)


def _is_singular(referee: Any, q: Any, v: Any, p: Any, time: float) -> bool:
    """Whether the equations are singular at a start."""
    try:
        return bool(referee.condition(referee.start(q, v, p, time), p, time) > 1e13)
    except (NoReferee, ZeroDivisionError, ValueError, TypeError):
        return True


def _bounds(scene: Scene, values: Any, grown: Any) -> np.ndarray:
    """How wrong a method may be: tolerances are local, and a run of many steps adds them up, as
    the methods mean them."""
    loose = max(1.0, scene.tol / 1e-13) * LOOSE.get(scene.method, 1.0)
    size = np.maximum(1.0, np.abs(_doubles(values)))
    share = 100 * UNIT * SHARP.get(scene.method, 1.0)
    return np.maximum(FLOOR * size, share * grown) * loose


def _truth(bench: _Bench, scene: Scene) -> Truth:
    """The motion by the referee in two resolutions, with starts nearby for its condition."""
    referee, m = bench.referee, bench.referee.mechanics
    p = [scene.parameters[n] for n in m.parameters]
    q, v = [scene.initial[n] for n in m.coordinates], [scene.initial[n] for n in m.velocities]
    dice = Random(repr(scene))
    count = len(scene.times)
    places = sorted({count - 1, *(dice.randrange(count) for _ in range(INSTANTS - 1))})
    singular = _is_singular(referee, q, v, p, scene.times[0])
    note = "; compared with starts nearby, where the coordinates are not singular" * singular
    if singular:
        q = [x + 1e-10 * dice.uniform(0.5, 1) for x in q]
    try:
        start = referee.start(q, v, p, scene.times[0])
    except (ZeroDivisionError, ValueError, TypeError) as error:
        raise _NoTruth(f"no start: {error}") from None
    times, rows = _instants(scene, places, _fastest(referee, start, p, scene))
    names = list(scene.outputs or _everything(bench))
    if singular:
        names = [n for n in names if n in m.velocities or n in bench.system.invariants]
    reader = referee.reader([referee.mechanics.meaning(bench.system, n) for n in names])
    fine, values, bounds = _two_runs(bench, scene, (q, v, p), start, times, reader, singular)
    conditions = [referee.condition(s, p, t) for s, t in zip(fine.states, times, strict=True)]
    conditions.append(referee.condition(start, p, scene.times[0]))
    return Truth(
        places,
        [dict(zip(names, map(float, values[k]), strict=True)) for k in rows],
        [dict(zip(names, map(float, bounds[k]), strict=True)) for k in rows],
        max(conditions),
        fine.pivot,
        note,
    )


def _fastest(referee: Any, start: Any, p: list[float], scene: Scene) -> list[float]:
    """The instant at which the motion is fastest: there errors grow most, for a moment that others
    drawn by chance miss."""
    rough = referee.motion(start, p, scene.times[0], [scene.times[-1]], 1e-12, budget=400_000)
    return [rough.fastest] if rough.outcome == "done" else []


def _instants(scene: Scene, places: list[int], known: list[float]) -> tuple[list[float], list[int]]:
    """The instants at which the truth is computed, with some all along the way, where errors may
    begin that grow later on; and the rows of those that are compared."""
    dice, first, span = Random(f"between {scene!r}"), scene.times[0], np.ptp(scene.times)
    way = 1 if scene.times[-1] >= first else -1
    own = [scene.times[i] for i in places]
    between = (first + way * float(span) * (k + dice.random()) / SAMPLES for k in range(SAMPLES))
    times = sorted({*own, *between, *known}, key=lambda t: abs(t - first))
    return times, [times.index(t) for t in own]


def _two_runs(
    bench: _Bench, scene: Scene, at: Any, start: Any, times: list[float], reader: Any,
    singular: bool,
) -> tuple[Motion, list[list[Any]], np.ndarray]:  # fmt: skip
    """The finer run of two that agree far within what an answer may be off, its outputs, and how
    far that is."""
    p = at[2]
    for precision in ("quad",) if singular else ("long double", "quad"):
        tolerances = (3e-17, 1e-15) if precision == "long double" else (1e-22, 1e-19)
        budget = 400_000 if precision == "long double" else 60_000
        fine, coarse = (
            bench.referee.motion(start, p, scene.times[0], times, tol, precision, budget)
            for tol in tolerances
        )
        if fine.outcome != "done" or coarse.outcome != "done":
            raise _NoTruth(f"{fine.outcome} at t = {fine.reached:.6g}")
        values = _values(reader, fine, times, p)
        unsure = np.abs(_doubles(values) - _doubles(_values(reader, coarse, times, p)))
        grown = _growth(bench, scene, at, times, precision, reader, fine.states, values)
        bounds = np.maximum(_bounds(scene, values, grown), 1e-7 if singular else 0.0)
        if (unsure < bounds / 10).all():
            return fine, values, bounds
    raise _NoTruth(f"the truth is known to {unsure.max():.1e} only")


def _growth(
    bench: _Bench, scene: Scene, at: Any, times: list[float], precision: str, reader: Any,
    states: list[list[Any]], values: list[list[Any]],
) -> np.ndarray:  # fmt: skip
    """What errors of one unit have grown to, at each instant the largest up to there: of the start
    and the parameters, and of the states on the way, since steps make errors all along."""
    referee, (q, v, p) = bench.referee, at
    m = referee.mechanics
    dice = Random(f"nearby {scene!r}")
    grown = np.zeros((len(values), len(values[0])))
    tolerance, budget = (1e-16, 400_000) if precision == "long double" else (1e-20, 60_000)
    velocities = referee.reader(m.independent)
    begins = [(scene.times[0], 0, q, v)]
    begins += [
        (times[k], k + 1, states[k][: len(m.q)], velocities(times[k], states[k], p))
        for k in range(len(times) - 1)
        if times[k] not in scene.times
    ]

    def move(values: Any, sizes: Any) -> list[Any]:
        pairs = zip(values, sizes, strict=True)
        return [mp.mpf(x) + NEARBY * size * dice.choice((-1, 1)) for x, size in pairs]

    for begin, first, own, pace in [*begins[:1] * SAMPLES, *begins[1:]]:
        other = [x * (1 + NEARBY * dice.uniform(-1, 1)) for x in p]
        largest = 1 + max(map(abs, pace), default=0)
        places = move(own, [1 + abs(x) for x in own])
        start = referee.start(places, move(pace, [largest] * len(pace)), other, begin)
        near = referee.motion(start, other, begin, times[first:], tolerance, precision, budget)
        if near.outcome != "done":
            raise _NoTruth(f"a motion nearby: {near.outcome} at t = {near.reached:.6g}")
        apart = _values(reader, near, times[first:], other)
        change = [
            [abs(a - b) for a, b in zip(x, y, strict=True)]
            for x, y in zip(apart, values[first:], strict=True)
        ]
        grown[first:] = np.maximum(grown[first:], _doubles(change) / NEARBY)
    return np.maximum.accumulate(grown, axis=0)


def _values(reader: Any, motion: Motion, times: list[float], p: list[float]) -> list[list[Any]]:
    with mp.workdps(30):
        return [reader(t, s, p) for t, s in zip(times, motion.states, strict=True)]


def _doubles(rows: Any) -> np.ndarray:
    return np.array([[float(x) for x in row] for row in rows])


def _snippet(bench: _Bench, scene: Scene) -> str:
    begin = source_of(bench.system) if bench.made else (
        f"import voronec as vo\nsystem = vo.load({bench.system.name!r})"
    )  # fmt: skip
    times = scene.times
    grid = repr(times)
    if len(times) > 12:
        grid = f"__import__('numpy').linspace({times[0]!r}, {times[-1]!r}, {len(times)})"
    call = "ensemble" if scene.bridge == "ensemble" else "integrate"
    first = "[start]" if call == "ensemble" else "start"
    key = "starts" if call == "ensemble" else "initial"
    dense = ", dense=True" if scene.bridge == "dense" else ""
    if scene.inputs and bench.made:
        given = (
            f"{u!r}: lambdify(t, {e})" if dict(scene.inputs)[u] == "function" else f"{u!r}: {e}"
            for u, e in bench.made.inputs.items()
        )
        dense += f", inputs={{{', '.join(given)}}}"
    return "\n".join(
        [
            begin,
            f"start = {dict(scene.initial)!r}",
            f"motion = vo.{call}(system, {key}={first}, parameters={dict(scene.parameters)!r},",
            f"    times={grid}, outputs={scene.outputs!r}, method={scene.method!r}, "
            f"tol={scene.tol!r}{dense})",
        ]
    )
