"""``voronec steady``: the steady motions of a system, with their spectra."""

from __future__ import annotations

from argparse import Namespace
from typing import TYPE_CHECKING, Any

from voronec.algebra.columns import columns
from voronec.algebra.text import exact_number
from voronec.cli.output import answer, plain, progress_line, warn
from voronec.cli.subject import resolve
from voronec.cli.values import name_and_value, names_of
from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from voronec.dynamics.steady import SteadyMotion


def execute(arguments: Namespace) -> int:
    """Search, and print each motion that was found."""
    given = options_of(arguments)
    system, _ = resolve(arguments.system)
    from voronec.dynamics.steady import steady

    with progress_line(f"{system.name}: steady motions ..."):
        free = names_of(arguments.free)
        motions = steady(system, **given, free=free, exact=arguments.exact)
        lines = [] if arguments.json else [line for m in motions for line in lines_of(m)]
        data = motions.as_dict() if arguments.json else None
    head = f"{system.name}: {motions.solved} of {motions.starts} starts lead to a steady motion"
    for family in motions.families:
        lines.append(
            f"exactly, dimension {family.dimension}: {', '.join(map(plain, family.equations))}"
        )
    if motions.limit:
        warn(f"{motions.limit}; the steady motions are known in numbers")
    answer(arguments.json, lambda: data, [head, *lines])
    return 0


def options_of(arguments: Namespace) -> dict[str, Any]:
    """Values, starts and seed, which ``steady`` and its kin take, as the options mean them."""
    for name in ("starts", "seed"):
        if getattr(arguments, name) < 1:
            raise DefinitionError(f"--{name} {getattr(arguments, name)}: give a number from 1 on")
    return {
        "at": dict(_value(text, "--at") for text in arguments.at),
        "parameters": dict(_value(text, "--set") for text in arguments.set),
        "starts": arguments.starts,
        "seed": arguments.seed,
    }


def _value(text: str, option: str) -> tuple[str, Any]:
    name, value = name_and_value(text, option, "NAME=VALUE, such as v=2")
    return name, exact_number(value, f"{option} {name}")


def lines_of(motion: SteadyMotion) -> list[str]:
    """One motion in words: its point, its family, its eigenvalues."""
    from voronec.dynamics.spectrum import number_text

    size = f"a family of dimension {motion.dimension}" if motion.dimension else "isolated"
    over = f", told apart by {', '.join(motion.free)}" if motion.free else ""
    point = [[f"  {name}", f"{value:.10g}"] for name, value in motion.point.items()]
    values = ", ".join(map(number_text, motion.spectrum)) or "none"
    return [
        f"{motion.kind}, {size}{over}; {motion.verdict}",
        *columns(point),
        f"  eigenvalues: {values}; and {motion.zeros} that vanish",
    ]
