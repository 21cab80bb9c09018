r"""A LaTeX file as it is: comments, ``\input`` and macros resolved, every character with its place.

``\newcommand`` (with arguments, one of them with a default), ``\def`` (with arguments, delimited or
not), ``\let`` and ``\DeclareMathOperator`` are carried out; a few commands that say how something
looks are macros from the beginning.  What a macro writes stands where it is called; its arguments
keep their own places.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import accumulate
from pathlib import Path
from typing import NoReturn

from voronec.errors import DefinitionError, file_errors

EXPANSIONS = 100_000
"""How many macros are carried out: many times what a long paper has."""
CHARACTERS = 5_000_000
"""How long a paper may be, with all that it puts in."""

Origin = tuple[int, int]
"""A file by its number, and a character of it."""


@dataclass(frozen=True)
class MarkedText:
    """A text of which every character knows its origin."""

    text: str
    origins: tuple[Origin, ...]

    def __getitem__(self, part: slice) -> MarkedText:
        return MarkedText(self.text[part], self.origins[part])

    def __add__(self, other: MarkedText) -> MarkedText:
        return MarkedText(self.text + other.text, self.origins + other.origins)

    def put(self, start: int, end: int, text: str) -> MarkedText:
        """With other characters in a range, which all stand where the range begins."""
        at = self.origins[min(start, len(self.origins) - 1)]
        return self[:start] + MarkedText(text, (at,) * len(text)) + self[end:]


@dataclass(frozen=True)
class TexSource:
    """The whole text of a paper, and its files by number: name and offsets of their lines."""

    body: MarkedText
    files: tuple[tuple[str, tuple[int, ...]], ...]

    def place(self, origin: Origin) -> tuple[str, int, int]:
        """File, line and column, from one."""
        name, starts = self.files[origin[0]]
        line = sum(start <= origin[1] for start in starts)
        return name, line, origin[1] - starts[line - 1] + 1


@dataclass(frozen=True)
class _Macro:
    """What a command stands for; ``pattern`` is what ends each of its parameters, nothing for one
    in braces, and ``prefix`` what stands before them."""

    body: str
    pattern: tuple[str, ...] = ()
    default: str | None = None
    prefix: str = ""


def _plain(arguments: int) -> tuple[str, ...]:
    return ("",) * arguments


_LOOKS = {
    **dict.fromkeys("boxed fbox ensuremath mathop mathrel mathbin mathclap".split(), ("#1", 1)),
    **dict.fromkeys("phantom hphantom vphantom hspace vspace color index".split(), ("", 1)),
    **dict.fromkeys("stackrel overset underset textcolor".split(), ("#2", 2)),
    **dict.fromkeys("bm pmb".split(), (r"\boldsymbol{#1}", 1)),
    **dict.fromkeys("intertext shortintertext textrm textit".split(), (r"\text{#1}", 1)),
    **dict.fromkeys("coloneqq coloneq triangleq doteq".split(), ("=", 0)),
    **dict.fromkeys(
        "mathstrut strut allowbreak hfill hfil noindent displaylimits".split(), ("", 0)
    ),
    "mathscr": (r"\mathcal{#1}", 1),
    "mathsf": (r"\mathrm{#1}", 1),
    "dv": (r"\frac{d#1}{d#2}", 2),
    "pdv": (r"\frac{\partial #1}{\partial #2}", 2),
}
"""Macros that are known from the beginning: what they say is how something looks."""
_FONTS = ("cal", "rm", "bf")
"""Fonts that reach to the end of a group."""
_NEW = {"newcommand", "renewcommand", "providecommand", "DeclareRobustCommand"}
_FILES = {"input", "include", "subfile"}
_PREAMBLE = {"newenvironment": 3, "renewenvironment": 3, "newtheorem": 2, "usepackage": 1,
            "bibliographystyle": 1, "bibliography": 1}  # fmt: skip


def _known_macros() -> dict[str, _Macro]:
    """The macros that every paper has."""
    macros = {name: _Macro(body, _plain(count)) for name, (body, count) in _LOOKS.items()}
    return macros | {name: _Macro(f"\\math{name}{{#1}}}}", ("}",)) for name in _FONTS}


def read_tex(path: str | Path) -> TexSource:
    """The paper in a file; ``DefinitionError`` with the place where it cannot be read."""
    return _Expander(Path(path)).source()


@dataclass
class _Expander:
    """What is still to be read lies on a pile, the next character on top."""

    path: Path
    pile: list[tuple[str, Origin]] = field(default_factory=list)
    files: list[tuple[str, tuple[int, ...]]] = field(default_factory=list)
    macros: dict[str, _Macro] = field(default_factory=_known_macros)
    count: int = 0

    def source(self) -> TexSource:
        self._open(self.path)
        characters: list[tuple[str, Origin]] = []
        while self.pile:
            character, origin = self.pile.pop()
            if character == "%":
                while self.pile and self.pile[-1][0] != "\n":
                    self.pile.pop()
            elif character != "\\":
                characters.append((character, origin))
            else:
                characters += self._command(origin)
            if len(characters) + len(self.pile) > CHARACTERS:
                self._refuse(origin, f"more than {CHARACTERS} characters; audit its parts apart")
        text = "".join(c for c, _ in characters)
        return TexSource(MarkedText(text, tuple(o for _, o in characters)), tuple(self.files))

    def _open(self, path: Path, origin: Origin | None = None) -> None:
        if origin is not None and not path.is_file():
            path = path if path.suffix == ".tex" else path.with_name(path.name + ".tex")
            if not path.is_file():
                name = path.relative_to(self.path.parent)
                self._refuse(origin, f"there is no file '{name}' to be put in; put it there")
            if len(self.files) > 1000:
                self._refuse(origin, "files put one another in without end")
        with file_errors(path, "the LaTeX file of a paper"):
            text = path.read_text("utf-8", errors="replace")
        if "\0" in text:
            raise DefinitionError(f"'{path}' is no LaTeX: it holds zero bytes; give a .tex file")
        lines = [0, *accumulate(map(len, text.splitlines(keepends=True)))]
        number = len(self.files)
        self.files.append((path.name, tuple(lines)))
        self.pile += [(c, (number, i)) for i, c in reversed([*enumerate(text)])]

    def _refuse(self, origin: Origin, what: str) -> NoReturn:
        name, line, column = TexSource(MarkedText("", ()), tuple(self.files)).place(origin)
        raise DefinitionError(f"{name}, line {line}, column {column}: {what}")

    def _command(self, origin: Origin) -> list[tuple[str, Origin]]:
        """Carry out a command whose backslash is taken; what stays in the text of it."""
        name = self._name()
        bare = name.rstrip("*")
        if bare in _NEW:
            self._new(origin)
        elif name in ("def", "gdef", "edef"):
            self._define(origin)
        elif name == "let":
            new, other = self._single(origin), self._single(origin)
            self.macros[new.lstrip("\\")] = _Macro(self._single(origin) if other == "=" else other)
        elif bare == "DeclareMathOperator":
            new, words = (_text_of(self._argument(origin)) for _ in range(2))
            self.macros[new.lstrip("\\")] = _Macro(f"\\operatorname{{{words}}}")
        elif name in _FILES:
            self._open(self.path.parent / _text_of(self._argument(origin)).strip(), origin)
        elif bare in _PREAMBLE:
            for _ in range(_PREAMBLE[bare]):
                self._optional()
                self._argument(origin)
            self._optional()
        elif name in self.macros:
            self._call(self.macros[name], origin)
        else:
            return [(c, origin) for c in "\\" + name]
        return []

    def _name(self) -> str:
        name = ""
        while self.pile and (self.pile[-1][0].isalpha() or self.pile[-1][0] == "@"):
            name += self.pile.pop()[0]
        if name in _NEW | {"DeclareMathOperator"} and self.pile[-1:] and self.pile[-1][0] == "*":
            self.pile.pop()
        if not name and self.pile:
            name = self.pile.pop()[0]
        return name

    def _skip(self) -> None:
        while self.pile and self.pile[-1][0].isspace():
            self.pile.pop()

    def _single(self, origin: Origin) -> str:
        """The next command or character, as written."""
        self._skip()
        if not self.pile:
            self._refuse(origin, "the file ends in a definition")
        character = self.pile.pop()[0]
        return "\\" + self._name() if character == "\\" else character

    def _argument(self, origin: Origin) -> list[tuple[str, Origin]]:
        """A group without its braces, or the next command or character."""
        self._skip()
        if not self.pile:
            self._refuse(origin, "the file ends where an argument is missing")
        if self.pile[-1][0] != "{":
            first = self.pile.pop()
            if first[0] != "\\":
                return [first]
            return [first, *((c, first[1]) for c in self._name())]
        return self._until("}", origin)

    def _until(self, closing: str, origin: Origin) -> list[tuple[str, Origin]]:
        """What stands to the bracket that closes the one on top, without both."""
        self.pile.pop()
        characters: list[tuple[str, Origin]] = []
        depth = 0
        while self.pile:
            top = self.pile.pop()
            if depth == 0 and top[0] == closing:
                break
            characters.append(top)
            if top[0] == "\\" and self.pile:
                characters.append(self.pile.pop())
            depth += (top[0] == "{") - (top[0] == "}")
        else:
            self._refuse(origin, f"'{closing}' is missing behind this command")
        return characters

    def _optional(self) -> list[tuple[str, Origin]] | None:
        self._skip()
        if not self.pile or self.pile[-1][0] != "[":
            return None
        return self._until("]", self.pile[-1][1])

    def _new(self, origin: Origin) -> None:
        name = _text_of(self._argument(origin)).strip().lstrip("\\")
        number, default = self._optional(), self._optional()
        count = _text_of(number or []).strip() or "0"
        if not count.isdecimal():
            self._refuse(origin, f"'{count}' is no number of arguments")
        body = _text_of(self._argument(origin))
        given = None if default is None else _text_of(default)
        self.macros[name] = _Macro(body, _plain(int(count)), given)

    def _define(self, origin: Origin) -> None:
        name, pattern = self._single(origin).lstrip("\\"), ""
        while self.pile and self.pile[-1][0] != "{":
            pattern += self.pile.pop()[0]
        ends = tuple(re.split(r"#\d", pattern))
        self.macros[name] = _Macro(_text_of(self._argument(origin)), ends[1:], prefix=ends[0])

    def _call(self, macro: _Macro, origin: Origin) -> None:
        self.count += 1
        if self.count > EXPANSIONS:
            self._refuse(origin, "macros are carried out without end; does one call itself?")
        if macro.prefix:
            self._argument_before(macro.prefix, origin)
        arguments: list[list[tuple[str, Origin]]] = []
        for position, end in enumerate(macro.pattern):
            if position == 0 and macro.default is not None:
                given = self._optional()
                arguments.append([(c, origin) for c in macro.default] if given is None else given)
            else:
                arguments.append(
                    self._argument_before(end, origin) if end else self._argument(origin)
                )
        written: list[tuple[str, Origin]] = []
        for part in re.split(r"(#\d)", macro.body):
            if re.fullmatch(r"#\d", part):
                number = int(part[1]) - 1
                written += arguments[number] if number < len(arguments) else []
            else:
                written += [(c, origin) for c in part]
        if written and written[-1][0].isalpha() and self.pile and self.pile[-1][0].isalpha():
            written.append((" ", origin))  # a command at the end must not swallow a letter
        self.pile += reversed(written)

    def _argument_before(self, end: str, origin: Origin) -> list[tuple[str, Origin]]:
        characters: list[tuple[str, Origin]] = []
        while self.pile and _text_of(characters[-len(end) :]) != end:
            characters.append(self.pile.pop())
        if _text_of(characters[-len(end) :]) != end:
            self._refuse(origin, f"'{end}' is missing behind this command")
        return characters[: -len(end)]


def _text_of(marked: Iterable[tuple[str, Origin]]) -> str:
    return "".join(character for character, _ in marked)
