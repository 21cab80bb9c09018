"""Memory for many arrays of one length, taken and given back like a stack."""

from __future__ import annotations

import numpy as np

__all__ = ["PIECE", "Rows", "matrix"]

PIECE = 1 << 19
"""Numbers in a piece of memory that the system hands out in large pages, which is far faster."""


def matrix(count: int, size: int) -> np.ndarray:
    """So many arrays, their values arbitrary, in one piece of memory."""
    enough = count * size
    piece = np.empty(max(enough, PIECE) if enough > PIECE // 8 else enough)
    return piece[:enough].reshape(count, size)


class Rows:
    """A stack of arrays in few pieces of memory.

    New memory for every array would cost as much as the arithmetic on it.
    """

    def __init__(self, count: int, size: int) -> None:
        """Arrays of up to ``size`` numbers, made ``count`` at a time."""
        self._count, self._size = count, size
        self._pieces: list[np.ndarray] = []
        self._rows: list[np.ndarray] = []
        self._taken = 0

    def new(self, size: int) -> np.ndarray:
        """An array of so many numbers, their values arbitrary."""
        place = self._taken
        if place == len(self._rows):
            self._add()
        self._taken = place + 1
        row = self._rows[place]
        return row if size == self._size else row[:size]

    def several(self, count: int, size: int) -> np.ndarray:
        """That many arrays, as the rows of a matrix."""
        if count > self._count:
            return np.empty((count, size))
        piece, place = divmod(self._taken, self._count)
        if place + count > self._count:
            piece, place = piece + 1, 0
        if piece == len(self._pieces):
            self._add()
        self._taken = piece * self._count + place + count
        return self._pieces[piece][place : place + count, :size]

    def _add(self) -> None:
        self._pieces.append(np.empty((self._count, self._size)))
        self._rows += list(self._pieces[-1])

    def mark(self) -> int:
        """Where to go back to with ``free``."""
        return self._taken

    def free(self, mark: int = 0) -> None:
        """Take back all arrays since the mark."""
        self._taken = mark
