"""Whole turns of Demchenko's ball against integration: ``python tools/fuzz.py turns``.

Random motions, the momentum in any direction: outside, inside, as a shell, with the gyroscope and
without, forwards and backwards, with a period and without, at rest in x.  The closed form is asked
at two instants, [0, T]; the reference shares no code with the package.  It is integrated in space
without coordinates, where there are no singularities (``bench_closed_taylor``), by heyoka, and its
angles are followed by steps so short that nothing that has a direction can go round.

Prints the seed, each motion that ends on other turns, and the count; exits with 1 if there is one.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from time import process_time
from typing import Any

import numpy as np
import sympy as sp

import voronec as vo

ANGLES = ("v", "v1", "theta")
ROLLING = {"outer": (2.0, 0.4), "inner": (-3.0, 0.4), "shell": (-0.5, 0.7)}
"""Radius of the fixed sphere, moment of inertia; the ball's radius and mass are 1."""
ASYMPTOTIC = {
    "outer": "2 4/5 12753/7420 sqrt(780939/2202256) -2157/1060 2/5",
    "inner": "4 8/17 8164/2975 sqrt(7689104/8850625) -12/5 2/5",
    "shell": "6 20/29 -375/406 sqrt(353475/41209) 5/2 3/5",
}
"""k, cos(u), s, tau, n, A of motions without a period."""
SHORT = 0.5
"""Of the time in which a direction could go round, a step takes this part."""
MOST = 1_000_000
"""Instants by which a motion is followed."""
SAME = 1e-3
"""Angles that differ by less are the same: what counts is whole turns."""


@dataclass(frozen=True)
class Motion:
    """One motion: exact data for the closed form, the span, and what it is."""

    parameters: Mapping[str, Any]
    initial: Mapping[str, Any]
    span: float
    kind: str

    def closed_form(self) -> tuple[np.ndarray, float]:
        """The angles at the end in closed form, and CPU seconds, set-up included."""
        began = process_time()
        form = vo.closed_form(
            vo.load("demchenko"), parameters=self.parameters, initial=self.initial
        )
        found = form.at([0.0, self.span], ANGLES)
        return np.array([found[q][-1] for q in ANGLES]), process_time() - began


def random_motion(rng: np.random.Generator, longest: float) -> Motion:
    """A motion of any kind."""
    rolling = str(rng.choice(list(ROLLING)))
    radius, inertia = ROLLING[rolling]
    span = float(rng.choice([-1, 1]) * rng.uniform(1, 30))
    if rng.random() < 0.04:
        span *= longest / 30
    initial: dict[str, Any] = {q: float(rng.uniform(-9, 9)) for q in ("v", "v1", "theta")}
    initial["u1"] = float(rng.uniform(0.02, 3.12))
    chance = rng.random()
    if chance < 0.05:
        return _asymptotic(rng, rolling, initial)
    k: float = 0.0 if chance < 0.15 else float(rng.normal() * rng.choice([0.1, 1, 4]))
    initial |= {"u": float(rng.uniform(0.02, 3.12)), "s": float(rng.normal()),
                "tau": float(rng.normal()), "n": float(2 * rng.normal())}  # fmt: skip
    kind = "no gyroscope" if k == 0 else "any"
    if chance < 0.08:  # straight along a great circle: x rests
        initial |= {"u": sp.pi / 2, "tau": 0, "n": 0}
        kind = "straight"
    elif chance > 0.95:  # from a place near a pole of the sphere
        initial["u1"], kind = float(10.0 ** rng.uniform(-6, -1)), "from near a pole"
    return Motion({"R1": radius, "A": inertia, "k": k}, initial, span, f"{rolling}, {kind}")


def _asymptotic(rng: np.random.Generator, rolling: str, initial: dict[str, Any]) -> Motion:
    k, cosine, s, tau, n, inertia = map(sp.sympify, ASYMPTOTIC[rolling].split())
    data = {"u": sp.acos(cosine), "s": s, "tau": tau, "n": n}
    parameters = {"R1": sp.Rational(ROLLING[rolling][0]), "A": inertia, "k": k}
    # for longer, integration would leave the motion, and some are at a pole of the ball by then
    span = float(rng.choice([-1, 1]) * rng.uniform(0.5, 2.5))
    return Motion(parameters, {**initial, **data}, span, f"{rolling}, without a period")


Run = Callable[[np.ndarray, Sequence[float], float], Callable[[np.ndarray], np.ndarray]]
"""Start, numbers (K, k, P, I/A, mu'/mu) and span, to the states at times, row by row."""


def rates(state: Any, numbers: Any) -> list[Any]:
    """Of n1, the sphere's normal at the contact, and of axes e3 and e1 of the ball, in space."""
    normal, third, first = state[:3], state[3:6], state[6:]
    whole, (rotor, inertia, ratio, slide) = numbers[:3], numbers[3:]
    pull = [p - rotor * q for p, q in zip(whole, third, strict=True)]
    lean = ratio * (pull[0] * normal[0] + pull[1] * normal[1] + pull[2] * normal[2])
    omega = [(p + lean * q) / inertia for p, q in zip(pull, normal, strict=True)]
    return [*(slide * e for e in _cross(omega, normal)), *_cross(omega, third),
            *_cross(omega, first)]  # fmt: skip


def by_heyoka() -> Run:
    """Taylor's method, compiled once."""
    import heyoka as hy

    x = hy.make_vars(*(f"{v}{i}" for v in ("n", "e", "f") for i in range(3)))
    system = list(zip(x, rates(x, [hy.par[i] for i in range(7)]), strict=True))
    integrator = hy.taylor_adaptive(system, [0.0] * 9, pars=[1.0] * 7, tol=2.3e-16)

    def run(start: np.ndarray, numbers: Sequence[float], span: float) -> Any:
        integrator.time, integrator.state[:], integrator.pars[:] = 0.0, start, numbers
        return integrator.propagate_until(span, c_output=True)[4]

    return run


def _cross(a: Any, b: Any) -> list[Any]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _frame(u: float, v: float) -> np.ndarray:
    """e_u, e_v, n of a sphere, columns."""
    a, b, c, d = np.cos(u), np.sin(u), np.cos(v), np.sin(v)
    return np.array([[a * c, -d, b * c], [a * d, c, b * d], [-b, 0.0, a]])


def follow(run: Run, motion: Motion) -> np.ndarray:
    """The angles at the end, by integration."""
    own = {**{q: float(x) for q, x in motion.initial.items()}}
    radius, inertia, k = (float(motion.parameters[p]) for p in ("R1", "A", "k"))
    whole, curved = 1 + inertia, 1 / radius
    slide = curved / (1 + curved)
    axis, level, normal = _frame(own["u1"], own["v1"]).T
    c, s = np.cos(own["theta"]), np.sin(own["theta"])
    moving = np.array([c * level - s * axis, c * axis + s * level, -normal])
    axes = _frame(own["u"], own["v"]) @ moving  # rows: the ball's axes in space
    spins = np.array([whole * own["s"], whole * own["tau"], inertia * own["n"]])
    momentum = spins @ moving + k * axes[2]
    start = np.concatenate([normal, axes[2], axes[0]])
    inside = run(start, [*momentum, k, whole, 1 / inertia, slide], motion.span)

    def observe(times: np.ndarray) -> np.ndarray:
        """Time, state, and how long no angle can go round."""
        states = np.array(inside(times))
        pull = momentum - k * states[:, 3:6]
        lean = (pull * states[:, :3]).sum(axis=1) / inertia
        fast = np.linalg.norm(pull + lean[:, None] * states[:, :3], axis=1) / whole
        return np.column_stack([times, states, _room(states, slide) / fast])

    rows = observe(np.linspace(0.0, motion.span, 200))
    while True:
        times, room = rows[:, 0], rows[:, -1]
        wide = np.abs(np.diff(times)) > SHORT * np.minimum(room[1:], room[:-1])
        if not wide.any():
            break
        if wide.size > MOST:
            raise RuntimeError("the angles cannot be followed: a pole is passed too closely")
        rows = np.concatenate([rows, observe((times[1:] + times[:-1])[wide] / 2)])
        rows = rows[np.argsort(np.abs(rows[:, 0]))]
    states = rows[:, 1:-1]
    turned = np.unwrap(_read(states), axis=1)
    return np.array([own[q] for q in ANGLES]) + turned[:, -1] - turned[:, 0]


def _room(states: np.ndarray, slide: float) -> np.ndarray:
    """How far the ball may turn before an angle could have gone round."""
    normal, third = states[:, :3].T, states[:, 3:6].T
    on_sphere = np.hypot(normal[0], normal[1])
    on_ball = np.sqrt(np.clip(1 - (normal * third).sum(axis=0) ** 2, 1e-30, None))
    return np.minimum(on_sphere / abs(slide), on_ball / (1 + abs(slide)))


def _read(states: np.ndarray) -> np.ndarray:
    """v, v1 and theta, modulo a turn; the ends of the span by the columns."""
    normal, third, first = (states[:, i : i + 3].T for i in (0, 3, 6))
    second = np.cross(third, first, axis=0)
    x, y, z = (-(normal * e).sum(axis=0) for e in (first, second, third))
    u, v = np.arctan2(np.hypot(x, y), z), np.arctan2(y, x)
    v1 = np.arctan2(normal[1], normal[0])
    u1 = np.arctan2(np.hypot(normal[0], normal[1]), normal[2])
    along = np.cos(u) * (np.cos(v) * first + np.sin(v) * second) - np.sin(u) * third
    level = np.array([np.cos(u1) * np.cos(v1), np.cos(u1) * np.sin(v1), -np.sin(u1)])
    across = np.array([-np.sin(v1), np.cos(v1), 0 * v1])
    theta = np.arctan2(-(along * level).sum(axis=0), (along * across).sum(axis=0))
    return np.array([v, v1, theta])


def main() -> int:
    """Compare, and exit with 1 where turns differ."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--motions", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1, help="motions are seeded by it and a number")
    parser.add_argument("--longest", type=float, default=300.0, help="span of the longest motions")
    options = parser.parse_args()
    run, other, lost, spent = by_heyoka(), 0, 0, []
    for i in range(options.motions):
        motion = random_motion(np.random.default_rng((options.seed, i)), options.longest)
        found, seconds = motion.closed_form()
        try:
            true = follow(run, motion)
        except RuntimeError as error:
            lost += 1
            print(f"seed ({options.seed}, {i}), {motion.kind}: {error}", flush=True)
            continue
        spent.append(seconds)
        off = (found - true) / (2 * np.pi)
        if not (np.abs(off) < SAME).all():
            other += 1
            turns = dict(zip(ANGLES, off.round(4).tolist(), strict=True))
            what = f"seed ({options.seed}, {i}), {motion.kind}, T = {motion.span}"
            print(f"{what}: other turns, {turns}", flush=True)
        if i % 100 == 99:
            print(f"{i + 1} motions: {other} on other turns", file=sys.stderr, flush=True)
    print(
        f"{options.motions} motions, seed {options.seed}: {other} end on other turns, {lost} "
        f"could not be followed; two instants in {1e3 * float(np.median(spent)):.1f} ms of CPU"
    )
    return 1 if other else 0
