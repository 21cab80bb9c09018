"""A table of an input: what it must hold, and how it stands in a file.

A line stands for each instant, with its time and the value there. Columns stand apart by commas,
semicolons or tabs; where semicolons do it, a comma is a decimal comma, as spreadsheets of many
countries write it. A mark of the byte order is passed over, and so is a first line that holds no
number.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from itertools import pairwise
from math import isfinite
from pathlib import Path

from voronec.algebra.text import exact_number
from voronec.errors import DefinitionError, file_errors, quote

KINDS = {"held": 1, "linear": 2, "cubic": 4}
"""How a table goes on between two instants, and how many instants that needs at least."""
BYTES = 100_000_000
"""How long a file may be."""


def require_table(times: Sequence[float], values: Sequence[float], kind: str) -> None:
    """``DefinitionError`` unless there are as many times as values, enough of them for the kind,
    all of them finite, and each time is later than the one before it."""
    if len(times) != len(values) or not times:
        raise DefinitionError(
            f"a table has {len(times)} times and {len(values)} values; give as many of each"
        )
    if not all(map(isfinite, (*times, *values))):
        raise DefinitionError("a table holds a number that is not finite; leave it out")
    for number, (before, after) in enumerate(pairwise(times), start=2):
        if after <= before:
            raise DefinitionError(
                f"the times of a table must grow, but time {number} is {after:g}, after {before:g}"
                "; sort the rows and leave out those that stand twice"
            )
    if len(times) < KINDS[kind]:
        raise DefinitionError(f"a {kind} table needs at least {KINDS[kind]} instants")


def read_table(path: Path, place: str) -> tuple[list[float], list[float]]:
    """The times and the values in a file; ``DefinitionError`` names the row and the mend.

    ``place`` is where the file is asked for, and begins every message.
    """
    try:
        with file_errors(path, "a file of times and values"):
            if path.exists() and not (path.is_file() and path.stat().st_size <= BYTES):
                raise DefinitionError(f"'{path}' is no file of at most {BYTES} bytes; name one")
            text = path.read_bytes().decode("utf-8-sig")
        apart = next((sign for sign in ";\t" if sign in text), ",")
        rows = list(csv.reader(text.splitlines(), delimiter=apart))
    except DefinitionError as error:
        raise DefinitionError(f"{place}: {error}") from None
    except (UnicodeDecodeError, csv.Error, ValueError):
        raise DefinitionError(
            f"{place}: '{path}' is no text of two columns; save it as CSV, in UTF-8"
        ) from None
    columns: tuple[list[float], list[float]] = [], []
    for number, row in enumerate(rows, start=1):
        cells = [c.strip().replace(",", ".") if apart == ";" else c.strip() for c in row]
        if not any(cells) or (not columns[0] and not any(map(_is_number, cells))):
            continue
        if len(cells) != 2:
            raise DefinitionError(
                f"{place}: row {number} of '{path}' has {len(cells)} columns; give a "
                "time and a value in each row, with a comma, a semicolon or a tab between them"
            )
        for column, cell in zip(columns, cells, strict=True):
            column.append(_number(cell, f"{place}: row {number} of '{path}'"))
    return columns


def _number(cell: str, place: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = float(exact_number(cell, place))
    if not isfinite(value):
        raise DefinitionError(f"{place}: '{quote(cell)}' is not finite; leave the row out")
    return value


def _is_number(cell: str) -> bool:
    try:
        _number(cell, "")
    except DefinitionError:
        return False
    return True
