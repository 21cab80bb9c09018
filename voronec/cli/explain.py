"""``voronec explain``: what of a system has to be integrated for what is wanted, and why.

Or the derivation of its equations, step by step."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from voronec.cli.files import delivery, wanted_folder
from voronec.cli.output import print_json, progress_line
from voronec.cli.subject import resolve
from voronec.cli.values import input_values, outputs_of, pair, split_values
from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from voronec.motion.model import Model

__all__ = ["execute"]

PICTURES = (".svg", ".png")


def execute(arguments: Namespace) -> int:
    """Explain in words, as data, or in a folder of both with the dependence drawn."""
    if arguments.derivation:
        return _derivation(arguments)
    if arguments.latex:
        raise DefinitionError("--latex: it prints a derivation; add --derivation")
    outputs = outputs_of(arguments.outputs)
    pairs, inputs = [pair(text) for text in arguments.set], input_values(arguments.input)
    folder = None if arguments.out is None else wanted_folder(arguments.out)
    system, _ = resolve(arguments.system)
    parameters, initial = split_values(system, pairs)
    from voronec.motion.explanation import explain, model_text

    scene = arguments.scene or system.first_scene
    with progress_line(f"{system.name}: weighing the levels of the equations ..."):
        model = explain(
            system,
            scene=scene,
            outputs=outputs,
            parameters=parameters,
            initial=initial or None,
            inputs=inputs,
        )
        text = model_text(model)
        files = [] if folder is None else _write(model, text, folder)
    if arguments.json:
        print_json({**model.as_dict(), "scene": scene, "files": [str(f) for f in files]})
        return 0
    print(text)
    if files:
        print("wrote " + ", ".join(str(f) for f in files))
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
        found = lesson(system)
        told = found.as_dict() if arguments.json else None
        text = found.latex() if arguments.latex else str(found)
    files = []
    if folder is not None:
        pages = {"txt": f"{found}\n", "tex": found.latex(), "html": found.html()}
        with delivery(folder) as workshop:
            for suffix, content in pages.items():
                (workshop / f"derivation.{suffix}").write_text(content, encoding="utf-8")
        files = [str(folder / f"derivation.{suffix}") for suffix in pages]
    if told is not None:
        print_json({**told, "files": files})
    else:
        print(text)
        if files:
            print("wrote " + ", ".join(files))
    return 0 if found.verdict.proved else 1


def _write(model: Model, text: str, folder: Path) -> list[Path]:
    from voronec.motion.pictures.model_picture import model_figure
    from voronec.motion.pictures.run_pictures import save

    figure: Any = model_figure(model)
    with delivery(folder) as workshop:
        (workshop / "explanation.txt").write_text(text + "\n", encoding="utf-8")
        for suffix in PICTURES:
            save(figure, workshop / f"dependence{suffix}")
        written = sorted(file.name for file in workshop.iterdir())
    return [folder / name for name in written]
