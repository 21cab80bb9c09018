"""``voronec bifurcation``: the bifurcation diagram of the integral map of a system."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from voronec.cli.files import deliver, wanted_folder
from voronec.cli.output import answer, progress_line, wrote
from voronec.cli.subject import resolve
from voronec.cli.values import finite, name_and_value, outputs_of
from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from voronec.dynamics.bifurcation import BifurcationDiagram


def execute(arguments: Namespace) -> int:
    """Compute the diagram, and print and draw what is found."""
    for name in ("starts", "seed"):
        if getattr(arguments, name) < 1:
            raise DefinitionError(f"--{name} {getattr(arguments, name)}: give a number from 1 on")
    given: dict[str, Any] = {
        "axes": tuple(map(str, outputs_of(arguments.axes))),
        "at": dict(_value(text, "--at") for text in arguments.at),
        "parameters": dict(_value(text, "--set") for text in arguments.set),
        "between": dict(_span(text) for text in arguments.between),
        "scene": arguments.scene, "starts": arguments.starts, "seed": arguments.seed,
    }  # fmt: skip
    folder = None if arguments.out is None else wanted_folder(arguments.out)
    system, _ = resolve(arguments.system)
    from voronec.dynamics.bifurcation import bifurcation_diagram

    with progress_line(f"{system.name}: critical values ..."):
        found = bifurcation_diagram(system, **given)
        files = [] if folder is None else deliver(folder, lambda to: _write(found, to))
    answer(
        arguments.json, lambda: {**found.as_dict(), "files": files}, [*found.lines(), *wrote(files)]
    )
    return 0


def _value(text: str, option: str) -> tuple[str, float]:
    name, value = name_and_value(text, option, "NAME=VALUE, such as energy=2")
    return name, finite(value, f"{option} {name}")


def _span(text: str) -> tuple[str, tuple[float, float]]:
    name, value = name_and_value(text, "--between", "NAME=A:B, such as energy=0:2")
    ends = value.split(":")
    if len(ends) != 2:
        raise DefinitionError(f"--between {text}: give NAME=A:B, such as energy=0:2")
    low, high = (finite(end, f"--between {name}") for end in ends)
    return name, (low, high)


def _write(found: BifurcationDiagram, workshop: Path) -> None:
    from voronec.motion.pictures.run_pictures import save

    save(found.plot(), workshop / "bifurcation.svg")
    found.save(workshop / "bifurcation.csv")
