"""LaTeX mathematics as MathML: typeset formulas that need neither network nor script."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from html import escape

from voronec.audit.page.boxes import (
    BINARY,
    RELATIONS,
    Box,
    Marks,
    read_boxes,
    stretches,
)
from voronec.audit.page.phrases import typeset_words
from voronec.errors import DefinitionError

_SIDES = {"r": "right", "c": "center", "l": "left"}
_CLOSING = frozenset(")]}|!⟩")
_TALL = frozenset({"fraction", "table"})
_THIN = '<mspace width="0.17em"/>'


def mathml(
    latex: str, marks: Sequence[tuple[int, int]] = (), mark: str = "changed", inline: bool = False
) -> str:
    """A formula, or a display with its delimiters, as ``<math>`` elements in one ``<div>``.

    A browser may end a line between two of them; a formula ``inline`` is one without the ``<div>``.
    Characters of ``latex`` in ``marks`` get the class ``mark``.  What is no formula is shown as its
    source.
    """
    try:
        box = read_boxes(latex)
    except DefinitionError:
        return f'<code class="latex">{escape(latex)}</code>'
    setter = _Setter(Marks.of(marks, box), mark)
    if inline:
        return f"<math>{setter.set(box)}</math>"
    several, before = list[str](), None
    for parts in stretches(box):
        several.append(f'<math displaystyle="true">{setter.run(parts, before)}</math>')
        before = parts[-1] if parts else None
    return f'<div class="math">{"<wbr/>".join(several)}</div>'


def prose(text: str) -> str:
    """Words with formulas between dollar signs, as HTML."""
    return typeset_words(text, escape, lambda formula: mathml(formula, inline=True))


@dataclass(frozen=True)
class _Setter:
    """Turns boxes into MathML; ``small`` is in force in scripts."""

    marks: Marks
    mark: str
    small: bool = False

    def set(self, box: Box) -> str:
        """The MathML of one box."""
        methods = {
            "row": self.element,
            "sign": self.sign,
            "fence": self.fence,
            "scripts": self.scripts,
            "primed": self.prime,
            "fraction": self.fraction,
            "root": self.root,
            "accent": self.accent,
            "over": self.accent,
            "table": self.table,
        }
        return methods.get(box.kind, _leaf)(box)

    def element(self, box: Box) -> str:
        """A box as exactly one element."""
        parts = box.parts if box.kind == "row" else (box,)
        body = self.run(parts)
        single = len(parts) == 1 and parts[0].kind not in ("row", "function", "scripts")
        return body if single else f"<mrow>{body}</mrow>"

    def run(self, parts: Sequence[Box], before: Box | None = None) -> str:
        """Boxes one after the other; what is marked as a whole is one element of that class."""
        elements = []
        for group, marked in self.marks.groups(parts):
            setter = replace(self, marks=Marks(())) if marked else self
            body = ""
            for box in group:
                body += setter.place(box, before)
                before = box
            elements.append(f'<mrow class="{self.mark}">{body}</mrow>' if marked else body)
        return "".join(elements)

    def place(self, box: Box, before: Box | None) -> str:
        """A box in a row: signs between two things keep their spaces wherever they stand."""
        if box.kind == "sign" and box.text in BINARY | RELATIONS:
            first = before is None or (before.kind == "sign" and before.text not in _CLOSING)
            form = "prefix" if first and box.text in BINARY else "infix"
            tight = ' lspace="0.1em" rspace="0.1em"' if self.small and form == "infix" else ""
            return f'<mo form="{form}"{tight}>{escape(box.text)}</mo>'
        name = box.parts[0] if box.kind == "scripts" else box
        if name.kind == "function":  # browsers leave no space around a function's name
            space = "" if before is None or before.kind == "sign" else _THIN
            return f"{space}{self.set(box)}<mo>&#x2061;</mo>{_THIN}"
        return self.set(box)

    def sign(self, box: Box) -> str:
        """A sign by itself; brackets and dots keep their size and take no space."""
        alone = box.text in "()[]{}|‖⟨⟩" and box.text
        quiet = ' lspace="0" rspace="0"' if alone or box.text in "…⋯" else ""
        still = ' stretchy="false"' if alone else ""
        return f"<mo{still}{quiet}>{escape(box.text)}</mo>"

    def fence(self, box: Box) -> str:
        """Brackets that grow with what they enclose, where that is tall."""
        opening, body, closing = box.parts
        if not _tall(body):
            ends = [self.mark_box(self.sign(x), x) for x in (opening, closing)]
            return f"<mrow>{ends[0]}{self.run(_row(body))}{ends[1]}</mrow>"
        signs = [
            self.mark_box(
                f'<mo stretchy="true" form="{form}" lspace="0" rspace="0">{escape(sign.text)}</mo>',
                sign,
            )
            if sign.text
            else ""
            for form, sign in (("prefix", opening), ("postfix", closing))
        ]
        return f"<mrow>{signs[0]}{self.run(_row(body))}{signs[1]}</mrow>"

    def mark_box(self, element: str, box: Box) -> str:
        """An element in the class of the marks, where they cover its box."""
        return f'<mrow class="{self.mark}">{element}</mrow>' if self.marks.cover(box) else element

    def scripts(self, box: Box) -> str:
        """A base with what stands below and above it."""
        base, below, above = box.parts
        primes = ""
        if base.kind == "primed" and above.end == above.start:
            base, primes = base.parts[0], _primes(base.text)
        small = replace(self, small=True)
        names = ("msub", "msup", "msubsup")
        if box.text == "limits":
            names = ("munder", "mover", "munderover")
        inside = [_leaf(base) if base.kind == "function" else self.element(base)]
        inside += [small.element(x) for x in (below, above) if x.end > x.start]
        name = names[2] if len(inside) == 3 else names[below.end == below.start]
        element = f"<{name}>{''.join(inside)}</{name}>"
        return f"<mrow>{element}{primes}</mrow>" if primes else element

    def prime(self, box: Box) -> str:
        return f"<mrow>{self.element(box.parts[0])}{_primes(box.text)}</mrow>"

    def fraction(self, box: Box) -> str:
        top, bottom = box.parts
        return f"<mfrac>{self.element(top)}{self.element(bottom)}</mfrac>"

    def root(self, box: Box) -> str:
        parts = "".join(self.element(part) for part in box.parts)
        return f"<msqrt>{parts}</msqrt>" if len(box.parts) == 1 else f"<mroot>{parts}</mroot>"

    def accent(self, box: Box) -> str:
        grows = "true" if box.kind == "over" else "false"
        sign = f'<mo class="accent" stretchy="{grows}">{box.text}</mo>'
        return f'<mover accent="true">{self.element(box.parts[0])}{sign}</mover>'

    def table(self, box: Box) -> str:
        rows = []
        for row in box.parts:
            cells = (
                _cell(box.text[column % len(box.text)], self.element(cell))
                for column, cell in enumerate(row.parts)
            )
            rows.append(f"<mtr>{''.join(cells)}</mtr>")
        return f'<mtable displaystyle="true">{"".join(rows)}</mtable>'


def _row(box: Box) -> tuple[Box, ...]:
    return box.parts if box.kind == "row" else (box,)


def _tall(box: Box) -> bool:
    """Whether a box is much higher than a line."""
    if box.kind in _TALL or (box.kind == "scripts" and box.text == "limits"):
        return True
    inside = box.parts[:1] if box.kind == "scripts" else box.parts
    return any(_tall(part) for part in inside)


def _primes(text: str) -> str:
    # the glyph is raised by itself: as a superscript it would float
    return f'<mo lspace="0" rspace="0">{text}</mo>'


def _cell(side: str, body: str) -> str:
    return f'<mtd style="text-align:{_SIDES[side]}">{body}</mtd>'


def _leaf(box: Box) -> str:
    text = escape(box.text)
    if box.kind == "space":
        return f'<mspace width="{text}em"/>'
    if box.kind == "letter":
        return f"<mi>{text}</mi>"
    if box.kind in ("upright", "function"):
        return f'<mi mathvariant="normal">{text}</mi>'
    if box.kind == "number":
        return f"<mn>{text}</mn>"
    if box.kind == "unknown":  # a command of the paper's own, as \diag
        return f'<mi mathvariant="normal">{text.lstrip(chr(92))}</mi>'
    return f"<mtext>{text.replace(' ', '&#xa0;')}</mtext>"
