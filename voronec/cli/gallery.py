"""``voronec gallery``: a motion of every class of traces, found, told and drawn."""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from voronec.algebra.symbols import plain_name
from voronec.cli.files import delivery, refuse_file, wanted_folder
from voronec.cli.output import columns, plain, print_json, progress
from voronec.cli.subject import resolve
from voronec.cli.values import pair, split_values
from voronec.errors import DefinitionError, did_you_mean

if TYPE_CHECKING:
    from voronec.closed import ClosedForm
    from voronec.closed.classes.labels import TraceClass
    from voronec.scene import Scene
    from voronec.system import System

__all__ = ["execute"]

PAPER, FIRST_FIGURE = "Demchenko1924", 4
"""The paper draws the classes in the order of ``LABELS``, from this figure on."""
SUFFIXES = (".svg", ".png", ".pdf")


@dataclass(frozen=True)
class Found:
    """A motion whose trace is of a class, or the reason why there is none."""

    trace: str
    label: str
    figure: int | None
    scene: Scene | None = None
    closed: ClosedForm | None = None
    classes: dict[str, TraceClass] | None = None
    reason: str = ""


def execute(arguments: Namespace) -> int:
    """Find, draw, and print a row for each class and each sphere.

    Stopped by Ctrl-C, what is done is printed and drawn all the same.
    """
    pairs = [pair(text) for text in arguments.set]
    system, _ = resolve(arguments.system)
    target = _target(arguments.out or f"{system.name}-gallery")
    parameters, initial = split_values(system, pairs)
    if initial:
        raise DefinitionError(
            f"--set {next(iter(initial))}: the gallery finds the starts; set parameters only"
        )
    labels = _labels(arguments.only)
    _check(system, parameters)
    stopped, found = False, []
    try:
        for each in _search(system, labels, parameters):
            found.append(each)
    except KeyboardInterrupt:
        stopped = True
    progress("")
    there = [f for f in found if f.scene is not None]
    if not there and stopped:
        raise KeyboardInterrupt
    files = _write(system, there, target) if there else []
    _tell(system, found, files, arguments.json)
    if stopped:
        wanted = len(labels) * len(_traces(system))
        print(f"voronec: stopped, {len(found)} of {wanted} motions done", file=sys.stderr)
        return 130
    return 0 if there else 1


def _target(out: str) -> Path:
    path = Path(out)
    if path.suffix in SUFFIXES:
        if path.is_dir():
            raise DefinitionError(f"'{path}' is a folder; give a file or another folder with --out")
        wanted_folder(str(path.parent))
        return path
    if path.suffix and not path.is_dir():
        raise DefinitionError(
            f"--out {out}: a picture ends in {', '.join(SUFFIXES[:-1])} or {SUFFIXES[-1]}; "
            "a folder has no suffix"
        )
    refuse_file(path)
    return wanted_folder(out)


def _labels(only: str | None) -> tuple[str, ...]:
    from voronec.closed.classes.labels import LABELS

    if only is None:
        return LABELS
    asked = tuple(dict.fromkeys(part.strip() for part in only.split(",")))
    known = (*LABELS, "E1+E2")
    for label in asked:
        if label not in known:
            near = did_you_mean(label, known)
            raise DefinitionError(f"--only: there is no class '{label}'{near}")
    return asked


def _check(system: System, parameters: Any) -> None:
    """Refuse what can have no motion at all, before any search."""
    from voronec.closed.classes.curve import declared
    from voronec.closed.classes.finding import held

    declared(system)
    held(system, parameters)


def _search(system: System, labels: Sequence[str], parameters: Any) -> Iterator[Found]:
    from voronec.closed.classes.curve import declared
    from voronec.closed.classes.finding import find
    from voronec.closed.classes.labels import LABELS, classify
    from voronec.flow.closed_form import closed_form

    for curve in declared(system).curves:
        for label in labels:
            drawn = PAPER in system.references and label in LABELS
            figure = FIRST_FIGURE + LABELS.index(label) if drawn else None
            progress(f"{system.name}: class {label} {curve.title} ...")
            try:
                scene = find(system, label, curve.title, parameters)
            except DefinitionError as error:
                yield Found(curve.title, label, figure, reason=str(error))
                continue
            closed = closed_form(system, scene)
            yield Found(curve.title, label, figure, scene, closed, classify(closed))


def _traces(system: System) -> tuple[Any, ...]:
    return system.motion.traces if system.motion is not None else ()


# -- pictures -----------------------------------------------------------------------------


def _write(system: System, found: Sequence[Found], target: Path) -> list[Path]:
    """A picture of each motion on both spheres, and of all motions on the sphere of their class; or
    all of them in the one file that was named."""
    from voronec.report.pictures import save
    from voronec.report.sphere_picture import traces_figure

    own = [(f, _drawn(system, f)) for f in found]
    if target.suffix in SUFFIXES:
        with delivery(target.parent) as workshop:
            shown = [_of_class(f, traces) for f, traces in own]
            save(traces_figure(shown, columns=3), workshop / target.name)
        return [target]
    names = []
    with delivery(target) as workshop:
        for f, traces in own:
            progress(f"{system.name}: drawing {f.label} {f.trace}")
            names.append(f"{_slug(f.trace)}-{f.label}.svg")
            save(traces_figure(traces), workshop / names[-1])
        for title in dict.fromkeys(f.trace for f, _ in own):
            shown = [_of_class(f, traces) for f, traces in own if f.trace == title]
            names.append(f"{_slug(title)}.svg")
            save(traces_figure(shown, title=title, columns=3), workshop / names[-1])
    progress("")
    return [target / name for name in names]


def _drawn(system: System, found: Found) -> tuple[Any, ...]:
    """A motion on every sphere."""
    from voronec.closed.classes.curve import title
    from voronec.report.motion_traces import motion_traces

    assert found.closed is not None and found.classes is not None
    longitudes = {plain_name(t.longitude): title(t) for t in _traces(system)}
    titles = {v: f"{name}: {found.classes[name].label}" for v, name in longitudes.items()}
    assert found.scene is not None
    periods = found.scene.times[1] / found.closed.period
    return motion_traces(found.closed, titles, periods=periods)


def _of_class(found: Found, traces: Sequence[Any]) -> Any:
    """The sphere whose class was looked for."""
    assert found.classes is not None
    return traces[list(found.classes).index(found.trace)]


def _slug(title: str) -> str:
    words = "".join(c if c.isalnum() else " " for c in title).split()
    return "-".join(words)


# -- words --------------------------------------------------------------------------------


def _tell(system: System, found: Sequence[Found], files: Sequence[Path], as_json: bool) -> None:
    there = [f for f in found if f.scene is not None]
    if as_json:
        print_json({"system": system.name, "motions": [_data(f) for f in found],
                    "files": [str(file) for file in files]})  # fmt: skip
        return
    if there:
        print("\n".join(columns([_head(there), *map(_row, there)])))
    for f in found:
        if f.reason:
            print(f.reason)
    if files:
        print(f"wrote {files[0]}" if len(files) == 1 else f"wrote {len(files)} pictures to "
              f"{files[0].parent}")  # fmt: skip


def _head(found: Sequence[Found]) -> list[str]:
    first = found[0]
    assert first.classes is not None
    figure = ["figure"] if first.figure is not None else []
    spheres = [part for name in first.classes for part in (name, "drift")]
    return ["sphere", *figure, "class", *spheres, "period", "parameters", "start"]


def _row(found: Found) -> list[str]:
    assert found.classes is not None and found.scene is not None and found.closed is not None
    figure = [str(found.figure)] if found.figure is not None else []
    cells = []
    for each in found.classes.values():
        drift = "" if each.drift is None else f"{each.drift:.4f}"
        closes = f" = {each.fraction} of 2pi" if each.fraction is not None else ""
        cells += [each.label, drift + closes]
    return [
        found.trace, *figure, found.label, *cells, f"{found.closed.period:.4f}",
        _values(found.scene.parameters) or "the defaults", _values(found.scene.initial),
    ]  # fmt: skip


def _values(given: Any) -> str:
    return ", ".join(f"{plain_name(k)} = {plain(v)}" for k, v in given.items())


def _data(found: Found) -> dict[str, Any]:
    data: dict[str, Any] = {"trace": found.trace, "class": found.label, "figure": found.figure}
    if found.scene is None or found.classes is None or found.closed is None:
        return {**data, "reason": found.reason}
    return {
        **data,
        "parameters": {plain_name(k): str(v) for k, v in found.scene.parameters.items()},
        "initial": {plain_name(k): str(v) for k, v in found.scene.initial.items()},
        "times": list(found.scene.times),
        "period": found.closed.period,
        "traces": {
            name: {
                "class": each.label, "drift": each.drift, "lower": each.lower, "upper": each.upper,
                "reversals": list(each.reversals),
                "fraction": None if each.fraction is None else str(each.fraction),
            }
            for name, each in found.classes.items()
        },
    }  # fmt: skip
