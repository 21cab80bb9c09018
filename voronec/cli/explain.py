"""``voronec explain``: what of a system has to be integrated for what is wanted, and why.

Or the derivation of its equations, step by step."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from voronec.cli.files import deliver, wanted_folder
from voronec.cli.output import answer, progress_line, wrote
from voronec.cli.subject import resolve
from voronec.cli.values import motion_of, outputs_of
from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from voronec.audit.lessons.lesson import Lesson
    from voronec.motion.formulation import Model

PICTURES = (".svg", ".png")


def execute(arguments: Namespace) -> int:
    """Explain in words, as data, or in a folder of both with the dependence drawn."""
    if arguments.derivation:
        return _derivation(arguments)
    if arguments.latex:
        raise DefinitionError("--latex: it prints a derivation; add --derivation")
    outputs = outputs_of(arguments.outputs)
    folder = None if arguments.out is None else wanted_folder(arguments.out)
    system, given = motion_of(arguments)
    from voronec.motion.explanation import explain, model_text

    given["initial"] = given["initial"] or None
    with progress_line(f"{system.name}: weighing formulations of the equations ..."):
        model = explain(system, outputs=outputs, **given)
        text = model_text(model)
        files = [] if folder is None else deliver(folder, lambda to: _write(model, text, to))
    more = {"scene": given["scene"], "files": files}
    answer(arguments.json, lambda: {**model.as_dict(), **more}, [text, *wrote(files)])
    return 0


def _derivation(arguments: Namespace) -> int:
    """The steps as text, as LaTeX, as data, or as files of the first two and a page."""
    for name in ("outputs", "scene", "set", "input"):
        if getattr(arguments, name):
            raise DefinitionError(f"--{name}: a derivation is that of all motions; leave it out")
    folder = None if arguments.out is None else wanted_folder(arguments.out)
    system, _ = resolve(arguments.system)
    from voronec.audit.lessons.lesson import lesson

    with progress_line(f"{system.name}: the derivation step by step ..."):
        derivation = lesson(system)
        told = derivation.as_dict() if arguments.json else None
        text = derivation.latex() if arguments.latex else str(derivation)
    files = [] if folder is None else deliver(folder, lambda to: _write_lesson(derivation, to))
    answer(arguments.json, lambda: {**(told or {}), "files": files}, [text, *wrote(files)])
    return 0 if derivation.verdict.proved else 1


def _write_lesson(found: Lesson, workshop: Path) -> None:
    pages = {"txt": f"{found}\n", "tex": found.latex(), "html": found.html()}
    for suffix, content in pages.items():
        (workshop / f"derivation.{suffix}").write_text(content, encoding="utf-8")


def _write(model: Model, text: str, workshop: Path) -> None:
    from voronec.motion.pictures.model_picture import model_figure
    from voronec.motion.pictures.run_pictures import save

    figure: Any = model_figure(model)
    (workshop / "explanation.txt").write_text(text + "\n", encoding="utf-8")
    for suffix in PICTURES:
        save(figure, workshop / f"dependence{suffix}")
