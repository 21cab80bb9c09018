"""``voronec sweep``: many motions over grids, lists and draws, kept in a folder."""

from __future__ import annotations

import csv
import math
import re
from argparse import Namespace
from contextlib import ExitStack
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

from voronec.cli.files import deliver, wanted_folder
from voronec.cli.output import answer, progress, progress_line, wrote
from voronec.cli.values import BETWEEN, finite, instants, motion_of, name_and_value, tolerance
from voronec.errors import DefinitionError, file_errors

if TYPE_CHECKING:
    from collections.abc import Callable

    from voronec.sweeps import Sweep

MOST = 10**9
"""Values of one name on a grid: more are a slip of the pen."""
PICTURES = (".svg", ".png", ".pdf")


def execute(arguments: Namespace) -> int:
    """Compute what is left of the sweep, draw it if that is asked for, and report.

    Stopped by Ctrl-C, the chunks that are finished stay, and the same command goes on.
    """
    tol, times = tolerance(arguments.tol), _times(arguments.times)
    grid = dict(_axis(text) for text in arguments.grid)
    starts, count = _starts(arguments)
    if arguments.plot and Path(arguments.plot).suffix not in PICTURES:
        raise DefinitionError(f"--plot {arguments.plot}: give a file in {', '.join(PICTURES)}")
    if arguments.plot:
        wanted_folder(str(Path(arguments.plot).parent))
    record = [part.strip() for part in re.split(BETWEEN, arguments.record)]
    system, given = motion_of(arguments)
    from voronec.sweeps import sweep
    from voronec.sweeps.engines import dask_executor

    total = math.prod(map(len, grid.values())) * count
    with ExitStack() as stack:
        stack.enter_context(progress_line(f"{system.name}: deriving ..."))
        executor = None
        if arguments.scheduler:
            executor = stack.enter_context(dask_executor(arguments.scheduler))
        archive = sweep(
            system, grid, starts, record, arguments.out or f"{system.name}-sweep.zarr",
            arguments.seed, executor, arguments.jobs, times, method=arguments.method, tol=tol,
            chunk=arguments.chunk, resume=arguments.resume,
            progress=_clock(system.name, total), **given,
        )  # fmt: skip
    files = [archive.path, *_draw(archive, arguments.plot)]
    counts = archive.counts()
    data = {"system": system.name, "record": record, **counts, "interrupted": archive.interrupted,
            "files": files}  # fmt: skip
    told = ", ".join(f"{n} {what}" for what, n in counts.items())
    lines = [f"{system.name}: {told}{', stopped by hand' if archive.interrupted else ''}"]
    answer(arguments.json, lambda: data, [*lines, *_reasons(archive), *wrote(files)])
    return 130 if archive.interrupted else 0


def _times(text: str | None) -> Any:
    """One number as it is: the end; else the instants."""
    return finite(text, "--times") if text and ":" not in text else instants(text)


def _numbers(text: str, place: str) -> list[float]:
    """``A:B:N``, evenly spaced, or ``A,B,C``."""
    parts = text.split(":")
    if len(parts) == 1:
        return [finite(part, place) for part in re.split(BETWEEN, text)]
    if len(parts) != 3 or not parts[2].isdecimal() or not 1 <= int(parts[2]) <= MOST:
        raise DefinitionError(f"{place}: give START:END:N, such as 0:1:11, or numbers A,B,C")
    import numpy as np

    return np.linspace(finite(parts[0], place), finite(parts[1], place), int(parts[2])).tolist()


def _axis(text: str) -> tuple[str, list[float]]:
    name, value = name_and_value(text, "--grid", "NAME=START:END:N or NAME=A,B,C")
    return name, _numbers(value, f"--grid {name}")


def _starts(arguments: Namespace) -> tuple[Any, int]:
    """The starts of a file, or draws, and how many they are."""
    if arguments.starts and (arguments.draws or arguments.range):
        raise DefinitionError("give --starts or --draws, not both")
    if arguments.starts:
        columns = _columns(Path(arguments.starts))
        return columns, len(next(iter(columns.values())))
    if not arguments.draws:
        if arguments.range:
            raise DefinitionError("--range: say how many are drawn: --draws N")
        return None, 1
    from voronec.sweeps import Draws

    ranges = {}
    for text in arguments.range:
        name, value = name_and_value(text, "--range", "NAME=LOW:HIGH")
        low, colon, high = value.partition(":")
        if not colon:
            raise DefinitionError(f"--range {text}: give NAME=LOW:HIGH")
        ranges[name] = finite(low, f"--range {name}"), finite(high, f"--range {name}")
    return Draws(arguments.draws, ranges, arguments.sampling), arguments.draws


def _columns(path: Path) -> dict[str, list[float]]:
    """A CSV of starts: a line of names, and one of numbers for each start."""
    with file_errors(path, "a CSV of starts"):
        try:
            names, *rows = csv.reader(path.read_text("utf-8-sig").splitlines())
        except (ValueError, csv.Error):
            raise DefinitionError(f"--starts: '{path}' is no CSV with a line of names") from None
    for number, row in enumerate(rows, start=2):
        if len(row) != len(names):
            raise DefinitionError(f"--starts: line {number} of '{path}' has {len(row)} numbers")
    place = f"--starts: '{path}'"
    if not rows:
        raise DefinitionError(f"{place} holds no start")
    columns = zip(*rows, strict=True)
    return {n.strip(): [finite(x, place) for x in c] for n, c in zip(names, columns, strict=True)}


def _clock(name: str, total: int) -> Callable[[float], None]:
    """What shows the share that is done, how many motions go in a second, and the time left."""
    first: list[tuple[float, float]] = []

    def show(share: float) -> None:
        now = perf_counter()
        first[:] = first or [(now, share)]
        rate = (share - first[0][1]) / (now - first[0][0]) if now > first[0][0] else 0.0
        told = f"{name}: {share:.1%} of {total} motions"
        if rate:
            left = (1 - share) / rate
            spell = f"{left / 60:.0f} min" if left > 100 else f"{left:.0f} s"
            told += f", {rate * total:.0f} a second, {spell} left"
        progress(told)

    return show


def _draw(found: Sweep, target: str | None) -> list[Path]:
    if not target:
        return []
    from voronec.motion.pictures.run_pictures import save

    place = Path(target)
    return deliver(place.parent, lambda made: save(found.plot(), made / place.name))


def _reasons(found: Sweep) -> list[str]:
    """The commonest reasons why motions failed."""
    import numpy as np

    told = np.asarray(found.to_xarray()["reason"].values, dtype=object).ravel()
    reasons, counts = np.unique(told[told != ""].astype(str), return_counts=True)
    order = np.argsort(-counts, kind="stable")[:5]
    return [f"{counts[i]} failed: {reasons[i]}" for i in order]
