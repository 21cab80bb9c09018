"""The bibliography: BibTeX entries by key, from ``docs/references.bib`` or beside a plugin."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Iterator
from importlib import resources
from pathlib import Path

from voronec.errors import DefinitionError

FILE = "references.bib"
_NAME = re.compile(r"[,\s]*([\w-]+)\s*=\s*")
_ACCENT = re.compile(r"\\(?P<sign>['`^\"~=.]|[uvcHk](?![A-Za-z]))\s*\{?(?P<letter>\\?[A-Za-z])\}?")
_SIGNS = dict(
    zip(
        "'`^\"~uvcHk=.",
        "\u0301\u0300\u0302\u0308\u0303\u0306\u030c\u0327\u030b\u0328\u0304\u0307",
        strict=True,
    )
)
_LETTER = re.compile(r"\\(o|O|l|L|ss|ae|AE|oe|OE|aa|AA)(?![A-Za-z])\s*")
_LETTERS = dict(zip("o O l L ss ae AE oe OE aa AA".split(), "øØłŁßæÆœŒåÅ", strict=True))
_START = re.compile(r"@(\w+)\s*\{\s*([^,\s{}]+)\s*,")


def bibtex(keys: Iterable[str], folder: Path | None = None) -> dict[str, str]:
    """Key -> BibTeX entry, in the order of the keys.

    Looked up in ``references.bib`` of ``folder``, where a plugin brings its own, then in that of
    the project.  Raises ``DefinitionError`` for a key that neither has.
    """
    known = read_entries(resources.files("voronec.docs").joinpath(FILE).read_text("utf-8"))
    path = folder / FILE if folder is not None else None
    if path is not None and path.is_file():
        known |= read_entries(path.read_text("utf-8"))
    wanted = list(keys)
    for key in wanted:
        if key not in known:
            raise DefinitionError(f"the reference '{key}' is not in {path or FILE}; add its entry")
    return {key: known[key] for key in wanted}


def citation(entry: str) -> str:
    """A BibTeX entry as a line of text: authors (year), title, where it appeared."""
    fields = {name.lower(): _plain(value) for name, value in _fields(entry)}
    who = fields.get("author") or fields.get("editor", "")
    names = [" ".join(reversed(a.split(", ", 1))) for a in who.split(" and ")]
    listed = " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))
    numbers = ", ".join(fields[k] for k in ("volume", "pages") if k in fields)
    homes = ("journal", "booktitle", "publisher", "school")
    home = next((fields[k] for k in homes if k in fields), "")
    parts = [f"{listed} ({fields.get('year', 'n. d.')})", fields.get("title", "")]
    parts += [f"{home} {numbers}".strip(), fields.get("note", "")]
    return ". ".join(filter(None, parts)) + "."


def _fields(entry: str) -> Iterator[tuple[str, str]]:
    """The names and values of an entry; a value stands in braces, in quotation marks, or bare."""
    at = entry.find(",") + 1
    while match := _NAME.match(entry, at):
        begin = at = match.end()
        # A bare value ends at the comma behind it or with the entry.
        ends = {"{": "}", '"': '"'}.get(entry[at : at + 1], ",}")
        begin += ends != ",}"
        depth, at = 0, begin
        while at < len(entry) and (depth or entry[at] not in ends):
            depth += {"{": 1, "}": -1}.get(entry[at], 0)
            at += 1
        yield match[1], entry[begin:at]
        at += ends != ",}"


def _plain(value: str) -> str:
    """A field without the marks of TeX."""

    def accent(match: re.Match[str]) -> str:
        letter = match["letter"].lstrip("\\")
        return unicodedata.normalize("NFC", letter + _SIGNS[match["sign"]])

    text = _LETTER.sub(lambda match: _LETTERS[match[1]], _ACCENT.sub(accent, value))
    for mark, sign in (("--", "\u2013"), ("~", " "), ("\\&", "&"), ("{", ""), ("}", "")):
        text = text.replace(mark, sign)
    return " ".join(text.split())


def read_entries(text: str) -> dict[str, str]:
    """The entries of a BibTeX text by key; an entry ends where its braces are balanced."""
    entries, at = {}, 0
    while start := _START.search(text, at):  # what stands within an entry is none
        depth = 0
        for at in range(start.start(), len(text)):
            depth += {"{": 1, "}": -1}.get(text[at], 0)
            if depth == 0 and text[at] == "}":
                entries[start[2]] = text[start.start() : at + 1]
                break
        else:
            raise DefinitionError(f"the reference '{start[2]}' has unbalanced braces; close them")
    return entries
