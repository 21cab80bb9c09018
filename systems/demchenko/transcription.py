"""The print of a section and how each piece of it is checked, from a file of LaTeX.

A line ``%% display``, ``%% inline`` or ``%% sentence`` opens a piece; what follows, letter for
letter, is its print.  Behind the kind stand its checks, between bars: the name of a check of the
module, or fields as ``study=rolling; cited=...``.  Of a sentence, what decides it comes first.
``@name`` is a value of the module.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from voronec.audit import Check, Display, Sentence

_HEAD = re.compile(r"^%% (\w+)(.*)\n", re.MULTILINE)


def displays(module: str, names: Mapping[str, Any], kind: str = "display") -> tuple[Display, ...]:
    """The displays of the file beside a module, or what stands in its lines (``inline``)."""
    return tuple(
        Display(text, tuple(_checks(head, names)) or (Check(),))
        for own, head, text in _pieces(module)
        if own == kind
    )


def sentences(module: str, names: Mapping[str, Any]) -> tuple[Sentence, ...]:
    """The sentences of the file beside a module."""
    return tuple(Sentence(text, **_fields(head, names)) for _, head, text in _pieces(module))


def _pieces(module: str) -> Iterator[tuple[str, str, str]]:
    """Kind, head and print of each piece."""
    _, *parts = _HEAD.split(Path(module).with_suffix(".tex").read_text("utf-8"))
    for kind, head, text in zip(parts[::3], parts[1::3], parts[2::3], strict=True):
        yield kind, head.strip(), text.removesuffix("\n")


def _checks(head: str, names: Mapping[str, Any]) -> Iterator[Check]:
    for words in filter(None, head.split(" | ")):
        value = Check(**_fields(words, names)) if "=" in words else names[words]
        yield from value if isinstance(value, tuple) else (value,)


def _fields(head: str, names: Mapping[str, Any]) -> dict[str, Any]:
    """Fields by their names; what decides stands without one."""
    found: dict[str, Any] = {}
    for words in re.split(r"; (?=\w+=)", head):
        key, sign, value = words.partition("=")
        if not sign:
            found["decide"] = names[key]
        elif value.startswith("@"):
            found[key] = names[value[1:]]
        elif key in ("within", "also", "given"):
            found[key] = tuple(value.split(", "))
        else:
            found[key] = int(value) if value.isdigit() else value
    return found
