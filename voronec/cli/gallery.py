"""``voronec gallery``: a motion of every class of traces, found, told and drawn.

Without a name, pages of a dozen motions.
"""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from voronec.algebra.columns import columns
from voronec.algebra.symbols import plain_name
from voronec.cli.files import deliver, refuse_file, wanted_folder
from voronec.cli.output import answer, plain, progress, progress_line
from voronec.cli.subject import resolve
from voronec.cli.values import pair, split_values
from voronec.errors import DefinitionError, did_you_mean

if TYPE_CHECKING:
    from voronec.closed import ClosedForm
    from voronec.declaration.scene import Scene
    from voronec.declaration.system import System

PAPER, FIRST_FIGURE = "Demchenko1924", 4
"""The paper draws the classes in the order of ``LABELS``, from this figure on."""
SUFFIXES = (".svg", ".png", ".pdf")


@dataclass(frozen=True)
class ClassRequest:
    """A class that the trace on some sphere is to have, and the paper's figure of it."""

    trace: str
    label: str
    figure: int | None


@dataclass(frozen=True)
class GalleryMotion:
    """A motion of a class."""

    request: ClassRequest
    scene: Scene
    form: ClosedForm


@dataclass(frozen=True)
class GalleryGap:
    """Why there is no motion of a class, or none was found."""

    request: ClassRequest
    reason: str


def execute(arguments: Namespace) -> int:
    """Find, draw, and print a row for each class and each sphere.

    Stopped by Ctrl-C, what is done is printed and drawn all the same.
    """
    if arguments.system is None:
        return _pages(arguments)
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
    stopped, answers = False, []
    try:
        for each in _search(system, labels, parameters):
            answers.append(each)
    except KeyboardInterrupt:
        stopped = True
    progress("")
    exhibits = [f for f in answers if isinstance(f, GalleryMotion)]
    if not exhibits and stopped:
        raise KeyboardInterrupt
    files = _write(system, exhibits, target) if exhibits else []
    _tell(system, answers, files, arguments.json)
    if stopped:
        wanted = len(labels) * len(_traces(system))
        print(f"voronec: stopped, {len(answers)} of {wanted} motions done", file=sys.stderr)
        return 130
    return 0 if exhibits else 1


def _pages(arguments: Namespace) -> int:
    """The pages that integrate by themselves, and ``index.html``."""
    if arguments.only is not None or arguments.set:
        raise DefinitionError("--only and --set are for one system; write: voronec gallery NAME")
    folder = wanted_folder(arguments.out or "gallery")
    from voronec.motion.viewer.gallery import write_gallery

    names = list[str]()
    with progress_line():
        deliver(folder, lambda to: names.extend(f.name for f in write_gallery(to, progress)))
    told = f"wrote {len(names) - 1} pages; open {folder / names[0]} in a browser"
    answer(arguments.json, lambda: {"files": [folder / name for name in names]}, [told])
    return 0


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
    from voronec.closed.classes.trace_classes import LABELS

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
    from voronec.closed.classes.search import held_parameters
    from voronec.closed.classes.trace_classes import declared_traces

    declared_traces(system)
    held_parameters(system, parameters)


def _search(
    system: System, labels: Sequence[str], parameters: Any
) -> Iterator[GalleryMotion | GalleryGap]:
    from voronec.closed.classes.search import find
    from voronec.closed.classes.trace_classes import LABELS, declared_traces
    from voronec.motion.closed_form import closed_form

    for curve in declared_traces(system).curves:
        for label in labels:
            drawn = PAPER in system.references and label in LABELS
            figure = FIRST_FIGURE + LABELS.index(label) if drawn else None
            asked = ClassRequest(curve.title, label, figure)
            progress(f"{system.name}: class {label} {curve.title} ...")
            try:
                scene = find(system, label, curve.title, parameters)
            except DefinitionError as error:
                yield GalleryGap(asked, str(error))
                continue
            yield GalleryMotion(asked, scene, closed_form(system, scene))


def _traces(system: System) -> tuple[Any, ...]:
    return system.motion.traces if system.motion is not None else ()


# -- pictures -----------------------------------------------------------------------------


def _write(system: System, found: Sequence[GalleryMotion], target: Path) -> list[Path]:
    """A picture of each motion on both spheres, and of all motions on the sphere of their class; or
    all of them in the one file that was named."""
    from voronec.closed.pictures.sphere_picture import traces_figure
    from voronec.motion.pictures.run_pictures import save

    drawings = [(f, _draw_motion(system, f)) for f in found]
    names = list[str]()

    def write_one(workshop: Path) -> None:
        shown = [_of_class(f, traces) for f, traces in drawings]
        save(traces_figure(shown, columns=3), workshop / target.name)

    def write_all(workshop: Path) -> None:
        for f, traces in drawings:
            progress(f"{system.name}: drawing {f.request.label} {f.request.trace}")
            names.append(f"{_slug(f.request.trace)}-{f.request.label}.svg")
            save(traces_figure(traces), workshop / names[-1])
        for title in dict.fromkeys(f.request.trace for f, _ in drawings):
            shown = [_of_class(f, traces) for f, traces in drawings if f.request.trace == title]
            names.append(f"{_slug(title)}.svg")
            save(traces_figure(shown, title=title, columns=3), workshop / names[-1])

    if target.suffix in SUFFIXES:
        return deliver(target.parent, write_one)
    deliver(target, write_all)
    progress("")
    return [target / name for name in names]


def _draw_motion(system: System, found: GalleryMotion) -> tuple[Any, ...]:
    """A motion on every sphere."""
    from voronec.closed.classes.trace_classes import title
    from voronec.closed.pictures.sphere_picture import motion_traces

    longitudes = {plain_name(t.longitude): title(t) for t in _traces(system)}
    titles = {v: f"{name}: {found.form.classes[name].label}" for v, name in longitudes.items()}
    periods = found.scene.times[1] / found.form.period
    return motion_traces(found.form, titles, periods=periods)


def _of_class(found: GalleryMotion, traces: Sequence[Any]) -> Any:
    """The sphere whose class was looked for."""
    return traces[list(found.form.classes).index(found.request.trace)]


def _slug(title: str) -> str:
    words = "".join(c if c.isalnum() else " " for c in title).split()
    return "-".join(words)


# -- words --------------------------------------------------------------------------------


def _tell(
    system: System,
    answers: Sequence[GalleryMotion | GalleryGap],
    files: Sequence[Path],
    as_json: bool,
) -> None:
    exhibits = [f for f in answers if isinstance(f, GalleryMotion)]
    lines = columns([_head(exhibits[0]), *map(_row, exhibits)]) if exhibits else []
    lines += [f.reason for f in answers if isinstance(f, GalleryGap)]
    if files:
        many = f"{len(files)} pictures to {files[0].parent}"
        lines.append(f"wrote {files[0] if len(files) == 1 else many}")
    motions = map(_data, answers)
    answer(as_json, lambda: {"system": system.name, "motions": [*motions], "files": files}, lines)


def _head(first: GalleryMotion) -> list[str]:
    figure = ["figure"] if first.request.figure is not None else []
    spheres = [part for name in first.form.classes for part in (name, "drift")]
    return ["sphere", *figure, "class", *spheres, "period", "parameters", "start"]


def _row(found: GalleryMotion) -> list[str]:
    asked = found.request
    figure = [str(asked.figure)] if asked.figure is not None else []
    cells = []
    for each in found.form.classes.values():
        drift = "" if each.drift is None else f"{each.drift:.4f}"
        closes = f", likely {each.fraction} of 2pi" if each.fraction is not None else ""
        cells += [each.label, drift + closes]
    return [
        asked.trace, *figure, asked.label, *cells, f"{found.form.period:.4f}",
        _values(found.scene.parameters) or "the defaults", _values(found.scene.initial),
    ]  # fmt: skip


def _values(given: Any) -> str:
    return ", ".join(f"{plain_name(k)} = {plain(v)}" for k, v in given.items())


def _data(found: GalleryMotion | GalleryGap) -> dict[str, Any]:
    asked = found.request
    data: dict[str, Any] = {"trace": asked.trace, "class": asked.label, "figure": asked.figure}
    if isinstance(found, GalleryGap):
        return {**data, "reason": found.reason}
    return {
        **data,
        "parameters": {plain_name(k): str(v) for k, v in found.scene.parameters.items()},
        "initial": {plain_name(k): str(v) for k, v in found.scene.initial.items()},
        "times": list(found.scene.times),
        "period": found.form.period,
        "traces": {
            name: {
                "class": each.label, "drift": each.drift, "lower": each.lower, "upper": each.upper,
                "reversals": list(each.reversals),
                "fraction": None if each.fraction is None else str(each.fraction),
            }
            for name, each in found.form.classes.items()
        },
    }  # fmt: skip
