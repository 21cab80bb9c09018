"""Make the pictures of docs/closed-form.md: ``python tools/build.py gallery [NAME ...]``.

Without names all that the repository carries: the sheets of classes of traces, the phase portrait,
the stability charts, the bifurcation sets, and films as strips.  ``class-A`` to ``class-E2`` show a
motion of one class on both spheres; the site makes them.
"""

from __future__ import annotations

import io
import re
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import sympy as sp

import voronec as vo
from pages.bifurcation_picture import bifurcation_figure
from pages.phase_picture import phase_figure, phase_levels
from pages.rolling_animation import film_strip, rolling_of
from pages.stability_picture import stability_figure
from voronec.closed.classes.search import find
from voronec.closed.classes.trace_classes import LABELS, classify
from voronec.closed.pictures.sphere_picture import motion_traces, traces_figure
from voronec.closed.special.bifurcation import bifurcation_set
from voronec.closed.special.precessions import precessions, quadratures_of
from voronec.closed.special.stability_chart import chart_of
from voronec.motion.pictures.run_pictures import save

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "closed-form"
BALL, SPHERE = "on the ball", "on the sphere"
FIGURES = dict(zip(LABELS, range(4, 13), strict=True))
"""Class -> the figure of the paper."""
CLASSES = {f"class-{label}": label for label in LABELS}
"""Picture of a class -> its label.  The site makes them; the repository carries none."""
LARGEST = 150_000
SHELL = {"A": "7/10"}
"""A shell has its mass beyond R2."""
OUTER, INNER, AROUND = (
    "outer, $R_2/R_1 = 1/2$",
    "inner, $R_2/R_1 = -1/6$",
    "shell, $R_2/R_1 = -5$",
)
BODIES = {
    OUTER: {"R1": "2"},
    "outer, $R_2/R_1 = 2$": {"R1": "1/2"},
    "inner, $R_2/R_1 = -1/4$": {"R1": "-4"},
    "inner, $R_2/R_1 = -1/10$": {"R1": "-10"},
    AROUND: {"R1": "-1/5", **SHELL},
    "shell, $R_2/R_1 = -10$": {"R1": "-1/10", **SHELL},
}
"""Title -> what differs from the default."""
LEVELS = {OUTER: BODIES[OUTER], INNER: {"R1": "-6"}, AROUND: BODIES[AROUND]}
WINDOWS = {INNER: ((2.5, 4.3), (5.0, 13.5))}
"""Where the bifurcation set shows its finer parts."""
MASSES = "$R_2 = M = 1$; $A = 2/5$, of shells $7/10$"


def main() -> int:
    """Write the pictures whose names begin as the words of the command say."""
    names = sys.argv[1:]
    system = vo.load("demchenko")
    for name, make in pictures(system).items():
        if any(name.startswith(n) for n in names) if names else name not in CLASSES:
            size = write_picture(make(), FOLDER / f"{name}.svg")
            print(f"{name}.svg: {size} bytes", flush=True)
    return 0


def pictures(system: vo.System) -> dict[str, Callable[[], Any]]:
    """Name -> what makes the figure."""
    made: dict[str, Callable[[], Any]] = {}
    for name, label in CLASSES.items():
        made[name] = partial(class_figure, system, label)
    made |= {
        "classes-on-the-ball": partial(sheet, system, BALL),
        "classes-on-the-sphere": partial(sheet, system, SPHERE),
        "phase-portrait": partial(portrait, system),
        "stability": partial(stability, system),
        "bifurcation": partial(bifurcation, system),
    }
    for scene in ("default", "inner", "shell"):
        name = "outer" if scene == "default" else scene
        made[f"rolling-{name}"] = partial(strip, system, scene)
    return made


def write_picture(figure: Any, path: Path) -> int:
    """The size of the file; numbers of paths are kept to a hundredth of a point."""
    stream = io.BytesIO()
    save(figure, stream, ".svg")
    text = re.sub(
        r' d="[^"]*"',
        lambda path: re.sub(r"-?\d+\.\d{3,}", lambda n: f"{float(n[0]):.2f}", path[0]),
        stream.getvalue().decode(),
    )
    if len(text) > LARGEST:
        raise SystemExit(f"{path.name} has {len(text)} bytes, more than {LARGEST}")
    path.write_text(text, encoding="utf-8")
    return len(text)


def class_figure(system: vo.System, label: str) -> Any:
    """A motion of a class, on both spheres."""
    closed = vo.closed_form(system, find(system, label, BALL))
    classes = classify(closed)
    titles = {"v": f"on the ball: {label}", "v1": f"on the sphere: {classes[SPHERE].label}"}
    notes = {"v": _start(closed), "v1": _parameters(closed)}
    title = f"Class {label}, as in Demchenko's figure {FIGURES[label]}"
    return traces_figure(motion_traces(closed, titles, notes), title=title, side=2.0)


def sheet(system: vo.System, trace: str) -> Any:
    """All classes that a trace has, one sphere each; each a motion of its own."""
    found = []
    for label in LABELS:
        try:
            closed = vo.closed_form(system, find(system, label, trace))
        except vo.DefinitionError as error:
            print(f"{label} {trace}: {error}")
            continue
        longitude = "v" if trace == BALL else "v1"
        spheres = motion_traces(closed, {longitude: label})
        found.append(spheres[0 if trace == BALL else 1])
    return traces_figure(
        found, columns=3, side=2.0, title=f"Traces {trace}, a motion of each class"
    )


def _parameters(closed: Any) -> str:
    given = closed.problem.exact
    values = {p.name: given(p.symbol)(64) for p in closed.system.parameters}
    return ", ".join(f"${_sub(n)} = {float(v):g}$" for n, v in values.items())


def _start(closed: Any) -> str:
    state = closed.at([0.0], ("u", "s", "tau", "n"))
    words = {"u": "u", "s": "s", "tau": r"\tau", "n": "n"}
    return ", ".join(f"${words[n]} = {x[0] + 0.0:.4g}$" for n, x in state.items())


def _sub(name: str) -> str:
    return f"{name[0]}_{name[1:]}" if len(name) > 1 else name


def _known(system: vo.System, **changed: Any) -> dict[Any, Any]:
    return {p.symbol: sp.nsimplify(changed.get(p.name, p.value)) for p in system.parameters}


def portrait(system: vo.System) -> Any:
    """Levels of the energy, of which one is a separatrix."""
    motion = quadratures_of(system)
    names = {str(c): c for c in motion.constants}
    quartic = motion.quartic.xreplace(
        {**_known(system), names["C5"]: sp.Rational(1, 2), names["S0"]: sp.Integer(6)}
    )
    levels = phase_levels(sp.expand(quartic), motion.x, names["h2"], sp.Integer(24), place=0.7)
    note = "levels of $2h$ with $C_5 = 1/2$, $S_0 = 6$; $R_2/R_1 = 1/2$, $A = 2/5$, $k = 3$"
    return phase_figure(levels, note=note)


def stability(system: vo.System) -> Any:
    """The family of regular precessions, for three ways of rolling."""
    charts = {name: chart_of(system, own, unit="k/A") for name, own in BODIES.items()}
    (_, inner), (shell, _) = _always_stable(system, {}), _always_stable(system, SHELL)
    note = (
        f"{MASSES}. All precessions are stable\ninside for $-1 < R_2/R_1 < {inner:.3f}$, "
        f"and of a shell for ${shell:.3f} < R_2/R_1 < -1$."
    )
    labels = (r"$x = \cos u$", r"$\dot v\, A/k$")
    return stability_figure(_by_column(charts), labels=labels, note=note)


def _always_stable(system: vo.System, own: dict[str, str]) -> tuple[float, float]:
    """The ratios R2/R1 between which f > 0, so that every precession is stable."""
    ratio = sp.Symbol("m")
    bare = precessions(system, {"R1": 1 / ratio, "R2": 1, "M": 1, "k": 1, "A": "2/5", **own})
    low, high = sp.Poly(sp.fraction(sp.together(bare.derivative(4)))[0], ratio).nroots(n=20)
    return float(low), float(high)


def _by_column(things: dict[str, Any]) -> dict[str, Any]:
    """Pairs in columns: the first ones above, the second ones below."""
    names = list(things)
    return {name: things[name] for name in (*names[::2], *names[1::2])}


def bifurcation(system: vo.System) -> Any:
    """The plane of two constants, for three ways of rolling."""
    sets, poles = {}, {}
    for name, own in LEVELS.items():
        sets[name] = bifurcation_set(system, ("S0", "h2"), {"C5": "1/2"}, own, (-30, 30))
        poles[name] = _through(system, own)
    note = f"$C_5 = 1/2$, $k = 3$, {MASSES}"
    labels = ("$S_0$", "$2h$")
    return bifurcation_figure(sets, labels=labels, poles=poles, windows=WINDOWS, note=note)


def _through(system: vo.System, own: dict[str, str]) -> dict[str, float]:
    """S0 of the motions through x = 1 and x = -1."""
    motion = quadratures_of(system)
    names = {str(c): c for c in motion.constants}
    known = {**_known(system, **own), names["C5"]: sp.Rational(1, 2)}
    found = {}
    for place in (1, -1):
        (value,) = sp.solve(motion.poles[sp.Integer(place)].xreplace(known), names["S0"])
        found[f"$x = {place}$"] = float(value)
    return found


def strip(system: vo.System, scene: str) -> Any:
    """A ball that rolls, at three instants."""
    closed = {"default": 14.0, "inner": 24.0, "shell": 11.0}[scene]
    run = vo.integrate(system, scene=scene, times=np.linspace(0, closed, 421), method="closed-form")
    return film_strip(rolling_of(run), [140, 280, 420])
