"""``voronec stability``: a family of steady motions over a quantity, and its critical values."""

from __future__ import annotations

from argparse import Namespace
from functools import partial
from typing import TYPE_CHECKING

from voronec.cli.files import deliver, wanted_folder, write_picture_and_table
from voronec.cli.output import answer, progress_line, wrote
from voronec.cli.steady import options_of
from voronec.cli.subject import resolve
from voronec.cli.values import interval, names_of
from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from voronec.dynamics.families import SteadyFamily


def execute(arguments: Namespace) -> int:
    """Follow the family, and print where its stability changes."""
    given = options_of(arguments)
    between = interval(arguments.between, "--between")
    if arguments.count < 2:
        raise DefinitionError(f"--count {arguments.count}: give a number from 2 on")
    folder = None if arguments.out is None else wanted_folder(arguments.out)
    system, _ = resolve(arguments.system)
    from voronec.dynamics.steady import stability

    with progress_line(f"{system.name}: steady motions over {arguments.over} ..."):
        family = stability(
            system, arguments.over, between, free=names_of(arguments.free),
            hold=names_of(arguments.hold), count=arguments.count, **given,
        )  # fmt: skip
        data, lines = family.as_dict(), _lines(family)
        write = partial(write_picture_and_table, family, "family")
        files = [] if folder is None else deliver(folder, write)
    answer(arguments.json, lambda: {**data, "files": files}, [*lines, *wrote(files)])
    return 0


def _lines(found: SteadyFamily) -> list[str]:
    held = f"; {', '.join(found.held)} held" if found.held else ""
    lines = [f"{found.system.name}: {len(found)} steady motions over {found.over}{held}"]
    for part in found.ranges:
        count = part.unstable or "no"
        lines.append(f"  {part}; {count} eigenvalue{'s' * (part.unstable > 1)} on the right")
    lines += [f"critical: {found.over} = {critical}" for critical in found.critical]
    lines += [f"fold: {found.over} = {value:.13g}" for value in found.folds]
    lines += [f"branch point: {found.over} = {value:.13g}" for value in found.branch_points]
    lines += [f"passes over {found.over} = {value:.6g}, where a logarithm has no value"
              for value in found.logarithmic_poles]  # fmt: skip
    from voronec.dynamics.continuation import COMPLETE

    for end, why in zip((found.values[0], found.values[-1]), found.ends, strict=True):
        if why != COMPLETE:
            lines.append(f"  ends at {end:.6g}: {why}")
    return lines
