"""A TOML text with places: every value knows the line and the column at which it stands.

``tomllib`` says what a text holds, but not where.  A second, smaller reading of the text, which
is TOML by then, finds the places.  Nothing in a text is ever run.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn

from voronec.algebra.text import NotAFormula
from voronec.errors import DefinitionError, did_you_mean, file_errors, quote

CHARACTERS = 1_000_000
"""How long a file may be."""
_STRING = re.compile(
    r'"""(?:[^"\\]|\\.|"(?!""))*"""(?:"{0,2})'
    r"|'''.*?'''(?:'{0,2})"
    r'|"(?:[^"\\\n]|\\.)*"'
    r"|'[^'\n]*'",
    re.DOTALL,
)
_BLANK = re.compile(r"(?:[ \t\n]|#[^\n]*)*")
_BARE = re.compile(r"[\w-]+")
_SCALAR = re.compile(r"[^,\]}\n#]*")
_AT = re.compile(r" \(at (?:line (\d+), column (\d+)|end of document)\)$")
Keys = tuple[str | int, ...]


class Decimal(str):
    """A decimal as it is written, so that none of its digits is lost."""

    __slots__ = ()


@dataclass(frozen=True)
class _Source:
    """A text and where its values and keys stand in it, from 0."""

    name: str
    text: str
    values: dict[Keys, int]
    keys: dict[Keys, int]

    def refuse(self, offset: int, what: str) -> NoReturn:
        line = self.text.count("\n", 0, offset) + 1
        column = offset - self.text.rfind("\n", 0, offset)
        raise DefinitionError(f"{self.name}, line {line}, column {column}: {what}")


@dataclass(frozen=True)
class Item:
    """A value of the text, by the keys that lead to it."""

    value: Any
    keys: Keys
    source: _Source

    @property
    def title(self) -> str:
        """What a message calls it: ``scenes.default.times``, ``constraints, entry 2``."""
        words = ".".join(str(k) for k in self.keys if isinstance(k, str))
        return words + "".join(f", entry {k + 1}" for k in self.keys if isinstance(k, int))

    def wrong(self, what: str, at: int | None = None) -> NoReturn:
        """Refuse the value; ``at`` is a place in its text, from 0."""
        offset = self.source.values.get(self.keys, 0)
        if at is not None and isinstance(self.value, str):
            offset = self._start(offset) + at if self._verbatim(offset) else offset
        self.source.refuse(offset, f"{self.title}: {what}" if self.keys else what)

    def wrong_key(self, what: str) -> NoReturn:
        """Refuse the key by which the value stands."""
        self.source.refuse(self.source.keys.get(self.keys, 0), what)

    def wrong_somewhere(self, what: str) -> NoReturn:
        """Refuse the text at the first of the words that a message quotes, else at its head."""
        for word in re.findall(r"'([^']+)'", what):
            place = re.search(rf"(?<!\w){re.escape(word)}(?!\w)", self.source.text)
            if place:
                self.source.refuse(place.start(), what)
        self.source.refuse(0, what)

    def _start(self, offset: int) -> int:
        """Where the letters of a text begin."""
        text = self.source.text
        if text.startswith(('"""', "'''"), offset):
            return offset + 3 + text.startswith("\n", offset + 3)
        return offset + text.startswith(('"', "'"), offset)

    def _verbatim(self, offset: int) -> bool:
        """Whether the text stands in the file letter for letter, without escapes."""
        return self.source.text.startswith(self.value, self._start(offset))

    def table(self, known: tuple[str, ...] = ()) -> dict[str, Item]:
        """The entries of a table by their keys; ``known`` are those that it may have."""
        if not isinstance(self.value, dict):
            self.wrong(
                f"{self._location()}; expected a table, such as [{self.title}] or {{ a = 1 }}"
            )
        entries = {k: Item(v, (*self.keys, k), self.source) for k, v in self.value.items()}
        for key, item in entries.items() if known else ():
            if key not in known:
                item.wrong_key(
                    f"'{quote(key)}' means nothing "
                    f"{f'in {self.title}' if self.keys else 'here'}{did_you_mean(key, known)}"
                )
        return entries

    def several(self) -> list[Item]:
        """The entries of an array; a single value stands for an array of it."""
        if not isinstance(self.value, list):
            return [self]
        return [Item(v, (*self.keys, i), self.source) for i, v in enumerate(self.value)]

    def text(self) -> str:
        """Words."""
        if not isinstance(self.value, str) or isinstance(self.value, Decimal):
            self.wrong(f'{self._location()}; expected words in quotes, such as "mass"')
        return self.value

    def flag(self) -> bool:
        """``true`` or ``false``."""
        if not isinstance(self.value, bool):
            self.wrong(f"{self._location()}; expected true or false")
        return self.value

    def scalar(self) -> str:
        """A number, or a formula in quotes, as text."""
        if isinstance(self.value, bool) or not isinstance(self.value, str | int):
            self.wrong(
                f'{self._location()}; expected a number or a formula in quotes, such as "m*g*x"'
            )
        return str(self.value)

    def refuse(self, error: DefinitionError, start: int = 0) -> NoReturn:
        """An error about this value, or what stands in it from ``start`` on, with its place."""
        if isinstance(error, NotAFormula):
            near = f" at '{quote(error.near)}'" if error.near else ""
            self.wrong(f"not a formula{near}: {error.why}", start + error.column - 1)
        self.wrong(str(error).removeprefix(f"{self.title}: "))

    def _location(self) -> str:
        kinds = {dict: "a table", list: "an array", bool: "true or false", int: "a number"}
        kind = kinds.get(type(self.value)) or (
            "a decimal" if isinstance(self.value, Decimal) else "text"
        )
        return kind if isinstance(self.value, dict | list) else f"'{quote(self.value)}' is {kind}"


def read_toml(path: Path) -> Item:
    """The table that a file holds; ``DefinitionError`` with line and column where it is no TOML."""
    try:
        with file_errors(path, "a file"):
            text = path.read_bytes().decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        raise DefinitionError(
            f"'{path}' is no text: its byte {error.start + 1} is not UTF-8; save it as UTF-8"
        ) from None
    except ValueError:  # a letter that no name of a file has
        raise DefinitionError(f"'{path}' cannot be the name of a file; correct it") from None
    if len(text) > CHARACTERS:
        raise DefinitionError(f"'{path}' has {len(text)} characters; {CHARACTERS} are read at most")
    source = _Source(str(path), text, {}, {})
    try:
        value = tomllib.loads(text, parse_float=Decimal)
        _Scan(text, source.values, source.keys).all()
    except tomllib.TOMLDecodeError as error:
        _refuse_syntax(source, str(error))
    except (RecursionError, MemoryError):
        source.refuse(0, "its arrays or tables are nested too deeply; a system needs four levels")
    except ValueError:  # Python reads no integer of more than 4300 digits
        source.refuse(0, "it holds a number that is too long; write it as a power of ten")
    return Item(value, (), source)


def _refuse_syntax(source: _Source, message: str) -> NoReturn:
    """What ``tomllib`` says, with its place in front."""
    place = _AT.search(message)
    what = "not TOML: " + _AT.sub("", message)
    if place is None or place[1] is None:
        source.refuse(len(source.text), f"{what}; something is missing at the end")
    lines = source.text.split("\n")
    before = sum(len(line) + 1 for line in lines[: int(place[1]) - 1])
    source.refuse(
        before + int(place[2]) - 1,
        f'{what}; expected lines such as name = "my-system" or [parameters]',
    )


@dataclass
class _Scan:
    """The places of keys and values in a text that is TOML."""

    text: str
    values: dict[Keys, int]
    keys: dict[Keys, int]
    at: int = 0
    arrays: dict[Keys, int] = field(default_factory=dict)
    """Of arrays written as ``[[name]]``: the number of the entry at hand."""

    def all(self) -> None:
        base: Keys = ()
        while self._blank() < len(self.text):
            if self.text[self.at] == "[":
                several = self.text.startswith("[[", self.at)
                self.at += 1 + several
                base = self._header(several)
                self.at += 1 + several
            else:
                self._pair(base)

    def _header(self, several: bool) -> Keys:
        """The keys of a table; one in an array counts as the last of its entries."""
        keys: Keys = ()
        said = self._dotted_key()
        for position, (part, start) in enumerate(said, 1):
            keys = (*keys, part)
            self._stands(keys, start)
            if several and position == len(said):
                self.arrays[keys] = self.arrays.get(keys, -1) + 1
            if keys in self.arrays:
                keys = (*keys, self.arrays[keys])
                self.values.setdefault(keys, start)
        return keys

    def _pair(self, base: Keys) -> None:
        keys = self._key(base)
        self.at += 1  # the equals sign
        self._value(keys)

    def _key(self, base: Keys) -> Keys:
        """A dotted key; every table on the way stands where it is first named."""
        keys = base
        for part, start in self._dotted_key():
            keys = (*keys, part)
            self._stands(keys, start)
        return keys

    def _stands(self, keys: Keys, start: int) -> None:
        self.keys.setdefault(keys, start)
        self.values.setdefault(keys, start)

    def _dotted_key(self) -> list[tuple[str, int]]:
        """The parts of a dotted key, each with its place."""
        parts = []
        while True:
            start = self._blank()
            match = _STRING.match(self.text, start) or _BARE.match(self.text, start)
            raw = match[0] if match else ""
            self.at = start + len(raw)
            part = tomllib.loads(f"k = {raw}")["k"] if raw[:1] in "\"'" else raw
            parts.append((part, start))
            self._blank()
            if not self.text.startswith(".", self.at):
                return parts
            self.at += 1

    def _value(self, keys: Keys) -> None:
        self.values[keys] = start = self._blank()
        opening = self.text[start]
        if opening in "[{":
            self.at += 1
            for i in self._entries("]" if opening == "[" else "}"):
                self._value((*keys, i)) if opening == "[" else self._pair(keys)
            return
        pattern = _STRING if opening in "\"'" else _SCALAR
        match = pattern.match(self.text, start)
        self.at = match.end() if match else len(self.text)

    def _entries(self, closing: str) -> Iterator[int]:
        """Before each entry of an array or a table in one line, its number; then past the end."""
        number = 0
        while self.text[self._blank()] != closing:
            yield number
            number += 1
            if self.text[self._blank()] == ",":
                self.at += 1
        self.at += 1

    def _blank(self) -> int:
        """Where the next sign is."""
        match = _BLANK.match(self.text, self.at)
        self.at = match.end() if match else self.at
        return self.at
