"""A table of an input as a file: a line for each instant, its time and the value there.

Columns stand apart by commas, semicolons or tabs; where semicolons do it, a comma is a decimal
comma, as spreadsheets of many countries write it.  A mark of the byte order is passed over, and so
is a first line that holds no number.
"""

from __future__ import annotations

import csv
from math import isfinite
from pathlib import Path

from voronec.algebra.text import exact_number
from voronec.errors import DefinitionError, file_errors, quote

__all__ = ["KINDS", "read_table"]

KINDS = "held", "linear", "cubic"
"""How a table goes on between two instants."""
BYTES = 100_000_000
"""How long a file may be."""


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
    found: tuple[list[float], list[float]] = [], []
    for number, row in enumerate(rows, start=1):
        cells = [c.strip().replace(",", ".") if apart == ";" else c.strip() for c in row]
        if not any(cells) or (not found[0] and not any(map(_is_number, cells))):
            continue
        if len(cells) != 2:
            raise DefinitionError(
                f"{place}: row {number} of '{path}' has {len(cells)} columns; give a "
                "time and a value in each row, with a comma, a semicolon or a tab between them"
            )
        for column, cell in zip(found, cells, strict=True):
            column.append(_number(cell, f"{place}: row {number} of '{path}'"))
    return found


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
