"""The smallest model of a scene in words: what is integrated, what is not, and why."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from voronec.motion.model import Model, Role

__all__ = ["KINDS", "model_text"]

KINDS = {
    "integrated": "integrated",
    "quadrature": "quadrature",
    "constant": "constant",
    "zero": "zero",
    "integral": "by an integral",
    "read off": "read off",
    "replaced": "replaced",
    "dropped": "dropped",
}
"""What may become of a variable, in the order of being told, and what that is called."""
WIDTH = 96
LONGEST = 60
"""A formula with more characters is not written out."""


def model_text(model: Model, width: int = WIDTH) -> str:
    """The explanation of a model, a few lines of plain text."""
    own = model.cut
    wanted = sorted({*own.outputs, *own.angles}, key=_place(model))
    head = f"{model.system.name}: the smallest model for {', '.join(wanted)}"
    size = f"{_count(len(model.states), 'state')}, in {_level_words(model.level)}"
    parts = [*_wrap([head], width, ""), size, "", *_roles(model, width), ""]
    parts += ["what was weighed", *_levels(model), ""]
    return "\n".join([*parts, *_followed_integrals(model, width)])


def _roles(model: Model, width: int) -> list[str]:
    """The variables of one kind and one reason together, reasons on the right."""
    rows: dict[tuple[str, str], list[str]] = {}
    for role in model.roles:
        rows.setdefault((role.kind, _why(model, role)), []).append(role.variable)
    order = list(KINDS)
    ranked = sorted(rows.items(), key=lambda row: order.index(row[0][0]))
    table = [(KINDS[kind], ", ".join(names), why) for (kind, why), names in ranked]
    first = max(len(kind) for kind, *_ in table)
    second = min(max(len(names) for _, names, _ in table), width // 3)
    lines: list[str] = []
    before = ""
    for kind, names, why in table:
        shown = textwrap.wrap(names, second) or [""]
        said = textwrap.wrap(why, max(width - first - second - 4, 20))
        for i in range(max(len(shown), len(said))):
            columns = (
                kind if i == 0 and kind != before else "",
                shown[i] if i < len(shown) else "",
                said[i] if i < len(said) else "",
            )
            lines.append(f"{columns[0]:{first}}  {columns[1]:{second}}  {columns[2]}".rstrip())
        before = kind
    return lines


def _why(model: Model, role: Role) -> str:
    """The reason, with the formula where a first integral gives the variable."""
    if role.kind != "integral":
        return role.why.replace("**", "^")
    formula = next((e for x, e in model.cut.stages if str(x) == role.variable), None)
    text = "" if formula is None else str(formula).replace("**", "^")
    return f"{role.why}: {role.variable} = {text}" if 0 < len(text) <= LONGEST else role.why


def _levels(model: Model) -> list[str]:
    """A table of the levels with their cost; the weight counts products of moving quantities."""
    head = ["variables", "states", "operations", "weight", ""]
    rows = [
        [
            _level_words(c.level), str(c.states), str(c.operations), f"{c.weight:.1f}",
            "chosen" if c.chosen else "",
        ]
        for c in model.candidates
    ]  # fmt: skip
    return _table([head, *rows], right={1, 2, 3})


def _followed_integrals(model: Model, width: int) -> list[str]:
    """Which declared integrals the model can still compute."""
    instead = model.eliminating_integrals
    able = [name for name in model.integrals if name not in instead]
    told = {*able, *instead, *model.refuted}
    lost = [name for name in model.system.integrals if name not in told]
    rows = [
        ("declared integrals that can be followed", able),
        ("integrals in place of equations", instead),
        (
            "integrals that need more variables",
            lost,
        ),
        ("declared integrals that are not constant, which is proved", model.refuted),
    ]
    lines = [f"{what}: {', '.join(names)}" for what, names in rows if names]
    return _wrap(lines or ["no integral is declared"], width, "  ")


def _level_words(name: str) -> str:
    return "coordinates and momenta" if name == "momenta" else name.replace(
        "coordinates", "coordinates and velocities"
    )  # fmt: skip


def _place(model: Model) -> Any:
    """The order of the system's own declaration; expressions after that."""
    system = model.system
    known = [*map(str, (*system.coordinates, *system.velocities)), *system.invariants]
    return lambda name: (known.index(name) if name in known else len(known), name)


def _count(n: int, what: str) -> str:
    return f"{n} {what}" if n == 1 else f"{n} {what}s"


def _wrap(lines: Iterable[str], width: int, indent: str) -> list[str]:
    return [part for line in lines for part in textwrap.wrap(line, width, subsequent_indent=indent)]


def _table(rows: Sequence[Sequence[str]], right: set[int]) -> list[str]:
    """Aligned lines, the columns of numbers at the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(
            word.rjust(w) if i in right else word.ljust(w)
            for i, (word, w) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]
