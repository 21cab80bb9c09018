"""Long formulas on several lines: how wide the parts of a formula are, and where to break it."""

from __future__ import annotations

from dataclasses import dataclass

from voronec.audit.page.boxes import Box

__all__ = ["BINARY", "RELATIONS", "LineBreaks", "break_lines", "width"]

RELATIONS = frozenset("= < > ≠ ≤ ≥ ⩽ ⩾ ≡ ≈ ∼ ∈ → ↦ ⟼ ⇒ ⟺".split())
BINARY = frozenset("+ − ± ∓ ⊕ ∧".split())
INDENT = 2.0
"""How far the second line and those after it begin to the right, in em."""
_LETTER, _DIGIT, _OPERATOR, _SCRIPT = 0.55, 0.5, 1.3, 0.7  # in em


def width(box: Box) -> float:
    """How wide a box is in print, in em, roughly."""
    parts = [width(part) for part in box.parts]
    if box.kind == "space":
        return float(box.text)
    if box.kind == "sign":
        wide = box.text in RELATIONS or box.text in BINARY
        return _OPERATOR if wide else 0.9 if box.text in "∑∏∫" else 0.4
    if box.kind in ("text", "function", "unknown", "number"):
        return _DIGIT * len(box.text) + (0.3 if box.kind == "function" else 0)
    if box.kind == "scripts":
        base, below, above = parts
        beside = _SCRIPT * max(below, above)
        return max(base, beside) if box.text == "limits" else base + beside
    if box.kind == "fraction":
        return max(parts) + 0.2
    if box.kind == "table":
        return max(parts)
    if not parts:
        return _LETTER if box.kind in ("letter", "upright") else 0.0
    return sum(parts) + {"root": 0.8, "primed": 0.3}.get(box.kind, 0.0)


@dataclass(frozen=True)
class _Item:
    """A box on a line; ``depth`` counts the brackets around it that were opened."""

    box: Box
    depth: int


@dataclass(frozen=True)
class LineBreaks:
    """The lines of a formula, and the fences that had to be opened for it."""

    lines: tuple[tuple[Box, ...], ...]
    opened: tuple[Box, ...]

    @property
    def width(self) -> float:
        """How wide the widest line is, in em."""
        indents = (INDENT if number else 0.0 for number in range(len(self.lines)))
        return max(i + sum(map(width, x)) for i, x in zip(indents, self.lines, strict=True))


def break_lines(row: Box, limit: float) -> LineBreaks:
    """The parts of a row on lines that are about ``limit`` em wide at most.

    A break comes before a relation, a sum's sign, or after a comma; between brackets only where
    these would not fit in half a line.
    """
    if row.kind != "row" or width(row) <= limit:
        return LineBreaks((row.parts if row.kind == "row" else (row,),), ())
    opened: list[Box] = []
    rest = _open(row.parts, limit / 2, 0, opened)
    lines: list[tuple[Box, ...]] = []
    while rest:
        cut = _cut(rest, limit - (INDENT if lines else 0.0))
        lines.append(tuple(item.box for item in rest[:cut]))
        rest = rest[cut:]
    return LineBreaks(tuple(lines), tuple(opened))


def _open(parts: tuple[Box, ...], limit: float, depth: int, opened: list[Box]) -> list[_Item]:
    found: list[_Item] = []
    for box in parts:
        inner = box.parts[1] if box.kind == "fence" else box
        if box.kind == "fence" and inner.kind == "row" and width(box) > limit:
            opened.append(box)
            found.append(_Item(box.parts[0], depth + 1))
            found += _open(inner.parts, limit, depth + 1, opened)
            found.append(_Item(box.parts[2], depth + 1))
        else:
            found.append(_Item(box, depth))
    return found


def _cut(items: list[_Item], limit: float) -> int:
    """How many items the next line takes."""
    if sum(width(item.box) for item in items) <= limit:
        return len(items)
    best, score, taken = len(items), float("-inf"), 0.0
    for position, item in enumerate(items):
        if position and _breaks(items[position - 1], item):
            over = taken > limit
            found = (-taken if over else taken / limit) - 0.3 * item.depth
            found += 0.4 * (item.depth == 0 and item.box.text in RELATIONS and not over)
            found += 0.6 * (items[position - 1].box.kind == "space" and not over)
            if found > score and (taken > 0.25 * limit):
                best, score = position, found
        taken += width(item.box)
    return best


def _breaks(before: _Item, item: _Item) -> bool:
    """Whether a line may end between two items."""
    if before.box.kind == "space" and float(before.box.text) >= 1 and item.box.kind != "space":
        return True
    if item.box.kind != "sign" or item.box.text not in RELATIONS | BINARY:
        return False
    return before.box.kind != "sign" or before.box.text in (")", "]", "}", "|", "!")
