"""Ranges of characters of a formula's source, as the boxes that they cover."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from voronec.audit.page.boxes import Box

__all__ = ["Marks"]


@dataclass(frozen=True)
class Marks:
    """Ranges (start, end) that are to be highlighted."""

    ranges: Sequence[tuple[int, int]]

    @classmethod
    def of(cls, ranges: Sequence[tuple[int, int]], formula: Box) -> Marks:
        """The ranges, where a change in a name's index or exponent is one of the whole name."""
        names = sorted(_names(formula), key=lambda box: box.end - box.start)
        return cls([_whole(names, a, b) for a, b in ranges])

    def cover(self, box: Box) -> bool:
        """Whether a box lies within one range, whatever its font, or the size of a bracket."""
        start, end = box.start, box.end
        if box.kind == "sign" and start < end:
            start = end - 1
        elif box.text == "font":
            start, end = box.parts[0].start, box.parts[-1].end
        return start < end and any(a <= start and end <= b for a, b in self.ranges)

    def groups(self, parts: Sequence[Box]) -> Iterator[tuple[tuple[Box, ...], bool]]:
        """The parts of a row in runs, each marked as a whole or not."""
        run: list[Box] = []
        marked = False
        for box in parts:
            covered = self.cover(box)
            if run and covered != marked:
                yield tuple(run), marked
                run = []
            marked = covered
            run.append(box)
        if run:
            yield tuple(run), marked

    def runs(self, box: Box) -> Iterator[tuple[Box, ...]]:
        """The largest runs of boxes that are marked as a whole, in the order of print.

        A run never reaches over the arguments of a command, or over the cells of a table.
        """
        if box.kind == "table":
            for cell in (cell for row in box.parts for cell in row.parts):
                yield from self.runs(cell)
        elif box.kind == "row":
            for group, marked in self.groups(box.parts):
                if marked:
                    yield group
                else:
                    for part in group:
                        yield from self.runs(part)
        else:
            growing = box.kind == "fence" and box.text == "left"  # its two ends belong together
            for part in box.parts[1:2] if growing else box.parts:
                if self.cover(part):
                    yield (part,)
                else:
                    yield from self.runs(part)


_LETTERS = frozenset({"letter", "upright", "accent", "over", "primed", "unknown", "number"})


def _names(box: Box) -> Iterator[Box]:
    """The letters with an index or an exponent."""
    if box.kind == "scripts" and not box.text:
        base = box.parts[0]
        if base.kind in _LETTERS or base.text in ("font", "group"):
            yield box
    for part in box.parts:
        yield from _names(part)


def _whole(names: Sequence[Box], start: int, end: int) -> tuple[int, int]:
    """The narrowest name whose scripts hold the range, or the range itself."""
    for name in names:
        if start < end and name.parts[0].end <= start and end <= name.end:
            return name.start, name.end
    return start, end
