"""``voronec bifurcation``: the bifurcation diagram of the integral map of a system."""

from __future__ import annotations

from argparse import Namespace
from functools import partial
from typing import Any

from voronec.cli.files import deliver, wanted_folder, write_picture_and_table
from voronec.cli.output import answer, progress_line, wrote
from voronec.cli.steady import options_of
from voronec.cli.subject import resolve
from voronec.cli.values import interval, name_and_value, names_of


def execute(arguments: Namespace) -> int:
    """Compute the diagram, and print and draw what is found."""
    given: dict[str, Any] = {
        **options_of(arguments), "axes": names_of(arguments.axes), "scene": arguments.scene,
        "between": dict(_span(text) for text in arguments.between),
    }  # fmt: skip
    folder = None if arguments.out is None else wanted_folder(arguments.out)
    system, _ = resolve(arguments.system)
    from voronec.dynamics.bifurcation import bifurcation_diagram

    with progress_line(f"{system.name}: critical values ..."):
        diagram = bifurcation_diagram(system, **given)
        write = partial(write_picture_and_table, diagram, "bifurcation")
        files = [] if folder is None else deliver(folder, write)
    answer(
        arguments.json,
        lambda: {**diagram.as_dict(), "files": files},
        [*diagram.lines(), *wrote(files)],
    )
    return 0


def _span(text: str) -> tuple[str, tuple[float, float]]:
    form = "NAME=A:B, such as energy=0:2"
    name, value = name_and_value(text, "--between", form)
    return name, interval(value, f"--between {name}", form)
