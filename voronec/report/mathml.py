"""LaTeX mathematics as MathML: typeset formulas that need neither network nor script.

This is layout only; it understands no formula.  What it does not know it shows as its source.
"""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from voronec.audit.tokens import Token, tokenize
from voronec.errors import DefinitionError

__all__ = ["mathml"]

_GREEK = dict(
    zip(
        "alpha beta gamma delta epsilon varepsilon zeta eta theta vartheta iota kappa lambda mu nu"
        " xi pi rho sigma tau upsilon phi varphi chi psi omega Gamma Delta Theta Lambda Xi Pi"
        " Sigma Phi Psi Omega wp ell partial".split(),
        "αβγδϵεζηθϑικλμνξπρστυϕφχψωΓΔΘΛΞΠΣΦΨΩ℘ℓ∂",
        strict=True,
    )
)
_OPERATORS = {
    "cdot": "⋅",
    "times": "×",
    "dots": "…",
    "ldots": "…",
    "cdots": "⋯",
    "ne": "≠",
    "neq": "≠",
    "le": "≤",
    "leq": "≤",
    "ge": "≥",
    "geq": "≥",
    "pm": "±",
    "in": "∈",
    "to": "→",
    "int": "∫",
    "sum": "∑",
    "infty": "∞",
    "{": "{",
    "}": "}",
}
_FUNCTIONS = set("sin cos tan cot ln log exp sinh cosh tanh arcsin arccos".split())
_ACCENTS = {"dot": "˙", "ddot": "¨", "tilde": "~", "bar": "¯", "hat": "^", "vec": "→"}
_FONTS = {  # where the alphabet starts: capitals, small letters
    "mathbf": (0x1D400, 0x1D41A),
    "mathcal": (0x1D4D0, 0x1D4EA),
    "mathfrak": (0x1D504, 0x1D51E),
    "mathbb": (0x1D538, 0x1D552),
}
_DOUBLE_STRUCK = dict(zip("CHNPQRZ", "ℂℍℕℙℚℝℤ", strict=True))
_FRAKTUR = dict(zip("CHIRZ", "ℭℌℑℜℨ", strict=True))
_PAIRS = {"(": ")", "[": "]"}
_SPACES = {"quad": "1em", "qquad": "2em"}


def mathml(latex: str, marks: Sequence[tuple[int, int]] = (), mark: str = "changed") -> str:
    """A ``<math>`` element; characters of ``latex`` in ``marks`` get the class ``mark``."""
    try:
        body = _Setter(tokenize(latex), marks, mark).row(())
    except (DefinitionError, IndexError):
        return f'<code class="latex">{escape(latex)}</code>'
    return f'<math display="block"><mrow>{body}</mrow></math>'


class _Setter:
    """Recursive descent over the words; every method returns MathML."""

    def __init__(self, tokens: list[Token], marks: Sequence[tuple[int, int]], mark: str) -> None:
        self.tokens, self.marks, self.mark = tokens, marks, mark
        self.position, self.font = 0, ""

    def peek(self) -> str:
        return self.tokens[self.position].text if self.position < len(self.tokens) else ""

    def take(self) -> Token:
        self.position += 1
        return self.tokens[self.position - 1]

    def row(self, stops: Sequence[str]) -> str:
        parts = []
        while self.position < len(self.tokens) and self.peek() not in stops:
            parts.append(self.item())
        return "".join(parts)

    def item(self) -> str:
        """An atom with its scripts."""
        start = self.peek()
        base = self.atom()
        below = above = ""
        primes = 0
        while self.peek() in ("_", "^", "'"):
            sign = self.take().text
            if sign == "'":
                primes += 1
            elif sign == "_":
                below = self.argument()
            else:
                above = self.argument()
        if primes:  # the glyph is raised by itself: as a superscript it would float
            base = f'<mrow>{base}<mo lspace="0" rspace="0">{"′" * primes}</mo></mrow>'
        if not (below or above):
            return base
        limits = start in ("\\sum",)
        names = ("munderover", "munder", "mover") if limits else ("msubsup", "msub", "msup")
        inside = [f"<mrow>{x}</mrow>" for x in (below, above) if x]
        name = names[0] if below and above else names[1] if below else names[2]
        return f"<{name}>{base}{''.join(inside)}</{name}>"

    def argument(self) -> str:
        if self.peek() == "{":
            self.take()
            body = self.row(("}",))
            self.take()
            return f"<mrow>{body}</mrow>"
        token = self.tokens[self.position]
        if token.kind == "number" and len(token.text) > 1:
            head = Token("number", token.text[0], token.start, token.start + 1)
            tail = Token("number", token.text[1:], token.start + 1, token.end)
            self.tokens[self.position : self.position + 1] = [head, tail]
        return self.atom()

    def atom(self) -> str:
        token = self.take()
        text = token.text
        if text == "{":
            body = self.row(("}",))
            self.take()
            return f"<mrow>{body}</mrow>"
        if text in _PAIRS and self.closed(text):
            return self.fenced(token)
        if token.kind == "number":
            return self.leaf("mn", text, token)
        if token.kind == "text":
            return self.leaf("mtext", text, token)
        if token.kind == "letter":
            return self.leaf("mi", text, token)
        if token.kind == "command":
            return self.command(token)
        return self.leaf("mo", "−" if text == "-" else text, token)

    def closed(self, opening: str) -> bool:
        """Whether the bracket just taken is closed before the group it stands in ends."""
        depth, braces = 1, 0
        for token in self.tokens[self.position :]:
            braces += (token.text == "{") - (token.text == "}")
            depth += (token.text == opening) - (token.text == _PAIRS[opening])
            if depth == 0 or braces < 0:
                break
        return depth == 0 and braces == 0

    def fenced(self, token: Token) -> str:
        """A row of its own, so that the brackets grow with what they enclose, and no further."""
        body = self.row((_PAIRS[token.text],))
        closing = self.take()
        opening, end = self.leaf("mo", token.text, token), self.leaf("mo", closing.text, closing)
        return f"<mrow>{opening}{body}{end}</mrow>"

    def command(self, token: Token) -> str:
        name = token.text[1:]
        if name in _GREEK:
            return self.leaf("mi", _GREEK[name], token)
        if name in _OPERATORS:
            return self.leaf("mo", _OPERATORS[name], token)
        if name in _FUNCTIONS:
            space = '<mspace width="0.17em"/>'  # browsers leave none around a function's name
            return space + self.leaf("mi", name, token) + "<mo>&#x2061;</mo>" + space
        if name in ("frac", "dfrac", "tfrac"):
            top = self.argument()
            return f"<mfrac><mrow>{top}</mrow><mrow>{self.argument()}</mrow></mfrac>"
        if name == "sqrt":
            return f"<msqrt>{self.argument()}</msqrt>"
        if name in _ACCENTS:
            return f'<mover accent="true">{self.argument()}<mo>{_ACCENTS[name]}</mo></mover>'
        if name in (*_FONTS, "boldsymbol"):
            return self.in_font(name)
        if name in _SPACES:
            return f'<mspace width="{_SPACES[name]}"/>'
        return self.leaf("mtext", token.text, token)

    def in_font(self, name: str) -> str:
        outer, self.font = self.font, name
        body = self.argument()
        self.font = outer
        return f"<mrow>{body}</mrow>"

    def leaf(self, element: str, text: str, token: Token) -> str:
        marked = any(a <= token.start and token.end <= b for a, b in self.marks)
        kind = f' class="{self.mark}"' if marked else ""
        if element == "mi" and self.font:
            text = _lettered(text, self.font)
        return f"<{element}{kind}>{escape(text)}</{element}>"


def _lettered(text: str, font: str) -> str:
    """A letter in another alphabet."""
    special = {"mathbb": _DOUBLE_STRUCK, "mathfrak": _FRAKTUR}.get(font, {})
    if text in special:
        return special[text]
    capitals, small = _FONTS.get(font, (0, 0))
    if not capitals or not (text.isascii() and text.isalpha() and len(text) == 1):
        return text
    return chr(ord(text) + (capitals - 65 if text.isupper() else small - 97))
