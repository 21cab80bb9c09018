"""The words of LaTeX mathematics, each with its place; spacing and sizes are left out."""

from __future__ import annotations

import re
from dataclasses import dataclass

from voronec.errors import DefinitionError

ELEMENTARY = frozenset(
    r"\sin \cos \tan \cot \sec \csc \ln \log \exp \sinh \cosh \tanh \arcsin \arccos \arctan".split()
)
ACCENTS = frozenset(
    r"\tilde \bar \hat \vec \mathbf \mathrm \mathfrak \mathcal \mathbb \boldsymbol".split()
)
GREEK = frozenset(
    r"\alpha \beta \gamma \delta \epsilon \varepsilon \zeta \eta \theta \vartheta \iota \kappa"
    r" \lambda \mu \nu \xi \pi \rho \sigma \tau \phi \varphi \chi \psi \omega \Gamma \Delta"
    r" \Theta \Lambda \Xi \Pi \Sigma \Phi \Psi \Omega \wp \ell \top".split()
)
"""Commands that are letters by themselves."""
FUNCTION_NAMES = {name: name for name in "abs sgn atan2 floor ceiling Heaviside".split()}
FUNCTION_NAMES |= {"Abs": "abs", "sign": "sgn", "signum": "sgn"}
"""Functions by name, ``\\operatorname{sgn}``, and what they are called here."""
FUNCTIONS = frozenset(r"\diag \det \tr".split()) | frozenset(FUNCTION_NAMES.values())
"""Names of functions, to be followed by their arguments."""
ELLIPSES = frozenset(r"\dots \ldots \cdots".split())


_WORD = re.compile(
    r"(?P<space>\s+|%[^\n]*)|(?P<command>\\(?:[a-zA-Z]+\*?|.))|(?P<number>\d+(?:(?:\.|\{,\})\d+)?)"
    r"|(?P<letter>[a-zA-Z])|(?P<sign>[-+*/=<>()\[\]{}^_,.:;'|&\"!~])",
    re.DOTALL,
)
_THOUSANDS = re.compile(r"[1-9]\d{0,2}\{,\}\d{3}")
"""A comma that may stand before decimals, or part thousands: the reader refuses such a number."""
_SILENT = set(
    r"\, \; \! \: \> \  ~ & \nonumber \notag \displaystyle \textstyle \limits \nolimits"
    r" \hline".split()
) | {"\\ "}
_SAME = {
    **{f"\\{name}": f"\\{other}" for name, other in (
        ("tg", "tan"), ("ctg", "cot"), ("cotg", "cot"), ("arctg", "arctan"), ("asin", "arcsin"),
        ("acos", "arccos"), ("atan", "arctan"), ("sh", "sinh"), ("ch", "cosh"), ("th", "tanh"),
        ("dfrac", "frac"), ("tfrac", "frac"), ("ast", "cdot"),
    )},
    "*": "\\cdot", "\\equiv": "=", "\\lvert": "|", "\\rvert": "|", "\\vert": "|",
    "\\prime": "'",
}  # fmt: skip
"""Several words for one thing, and the one that the reader knows."""
_CONSTANT = ("const", "constant")
_SIZES = set(r"\big \Big \bigg \Bigg \bigl \bigr \Bigl \Bigr \biggl \biggr \left \right".split())
_WITH_ARGUMENT = {"\\label", "\\tag"}
_ENVIRONMENT = re.compile(r"\\(?:begin|end)\s*\{([a-zA-Z]+\*?)\}")
_COLUMNS = re.compile(r"(?:\[[tbc]\])?\{[^{}]*\}")
"""What stands behind the name of an array."""
_SKIP = re.compile(r"\*?\s*\[-?[\d.]+\s*[a-z\\]+\]|\*")
"""What may stand behind the end of a row."""


@dataclass(frozen=True)
class Token:
    r"""One word: ``kind`` is command, number, letter, name (upright, ``\mathrm{abs}``), sign or
    text."""

    kind: str
    text: str
    start: int
    end: int


class Misprint(DefinitionError):
    """A bracket, a term or an order that is wrong in print, whatever the letters mean."""


class Unfamiliar(Misprint):
    """What breaks a rule that not every paper keeps: a fault only where all its signs are known."""


class Ambiguous(DefinitionError):
    """What may be printed well, and can be read in two ways."""


def complain(
    source: str, at: int, what: str, kind: type[DefinitionError] = DefinitionError
) -> DefinitionError:
    """An error of a kind that shows the place in the formula."""
    before = " ".join(source[max(0, at - 25) : at].split())
    after = " ".join(source[at : at + 25].split())
    return kind(f"formula, character {at + 1}: {what}, at '{before} >>> {after}'")


def tokenize(source: str, offset: int = 0, end: int | None = None) -> list[Token]:
    """The words of ``source[offset:end]``; a label with its argument and spacing are skipped.

    ``\\text{...}`` and ``\\mathrm{...}`` become one word of kind text, or name.  A bracket starts
    where the command for its size does.
    """
    tokens: list[Token] = []
    size: int | None = None
    depth = 0
    position, end = offset, len(source) if end is None else end
    while position < end:
        match = _WORD.match(source, position, end)
        if match is None:  # what the reader does not understand
            tokens.append(Token("sign", source[position], position, position + 1))
            position += 1
            continue
        text, position = match.group(), match.end()
        kind = str(match.lastgroup)
        if text in _SIZES:
            size = match.start()
            position += source.startswith(".", position)  # a bracket that is not printed
        if depth and (text in ("&", "\\end") or text.startswith("\\\\")):
            while tokens[-1].text in (",", ".", ";"):  # at the end of a cell
                tokens.pop()
        if depth and text == "&":
            tokens.append(Token("sign", text, match.start(), position))
        if kind == "space" or text in _SILENT or text in _SIZES:
            continue
        if text in ("\\begin", "\\end") and (
            named := _ENVIRONMENT.match(source, match.start(), end)
        ):
            depth += 1 if text == "\\begin" else -1
            text, position = f"{text}{{{named[1]}}}", named.end()
            if text == "\\begin{array}" and (columns := _COLUMNS.match(source, position, end)):
                position = columns.end()
        elif text == "\\\\" and (skip := _SKIP.match(source, position, end)):
            position = skip.end()
        if text in _WITH_ARGUMENT:
            position = _argument(source, position, end)[1]
            continue
        if text in ("\\text", "\\mathrm", "\\mbox", "\\operatorname"):
            inner, position = _argument(source, position, end)
            upright = text in ("\\mathrm", "\\operatorname")
            tokens.append(_word(inner, upright, match.start(), position))
            continue
        if text == "c" and source.startswith("const", match.start()):
            position = match.start() + 5
            tokens.append(Token("text", "const", match.start(), position))
            continue
        if kind == "number" and not _THOUSANDS.fullmatch(text):
            text = text.replace("{,}", ".")
        start, size = match.start() if size is None else size, None
        function = FUNCTION_NAMES.get(text[1:]) if kind == "command" else None
        kind, text = ("name", function) if function else (kind, _SAME.get(text, text))
        tokens.append(Token(kind, text, start, position))
    return tokens


def _word(text: str, upright: bool, start: int, end: int) -> Token:
    r"""Words of text; one without spaces may be a name, a letter or a function: ``\mathrm{d}``."""
    spaced, text = re.search(r"\s|~", text) is not None, text.strip()
    if text.rstrip(".") in _CONSTANT:
        return Token("text", "const", start, end)
    command = _SAME.get(f"\\{text}", f"\\{text}")
    if upright and command in ELEMENTARY:
        return Token("command", command, start, end)
    if spaced and not upright:
        return Token("text", text, start, end)
    return Token("letter" if len(text) == 1 else "name", FUNCTION_NAMES.get(text, text), start, end)


def _argument(source: str, position: int, end: int) -> tuple[str, int]:
    """The braced argument that starts at ``position``, and where it ends."""
    while position < end and source[position].isspace():
        position += 1
    if position >= end or source[position] != "{":
        return (source[position : position + 1], min(position + 1, end))
    depth = 0
    for i in range(position, end):
        depth += {"{": 1, "}": -1}.get(source[i], 0)
        if depth == 0:
            return source[position + 1 : i], i + 1
    raise complain(source, position, "a brace is not closed")
