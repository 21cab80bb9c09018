"""What LaTeX needs to compile at all: braces, environments, mathematics that begin and end."""

from __future__ import annotations

import re

_WORD = re.compile(
    r"\\(?P<begin>begin|end)\{(?P<name>[^}]*)\}|\\(?P<edge>left|right)(?![a-zA-Z])"
    r"|\\(?:[a-zA-Z]+|.)|[{}$]",
    re.DOTALL,
)
_PAIRS = {"}": "{", "\\]": "\\[", "\\)": "\\("}


def complaints(text: str) -> list[str]:
    """What does not match, in words; nothing for well-formed LaTeX."""
    waiting: list[str] = []
    found = []
    for match in _WORD.finditer(re.sub(r"(?<!\\)%[^\n]*", "", text)):
        opens, closes = _role(match, waiting)
        if opens:
            waiting.append(opens)
        elif closes:
            last = waiting.pop() if waiting else "nothing"
            if last != closes:
                at = text[max(0, match.start() - 30) : match.end()]
                found.append(f"{match.group()} closes {last}, at ...{at}")
    return found + [f"{word} is not closed" for word in waiting]


def _role(match: re.Match[str], waiting: list[str]) -> tuple[str, str]:
    """What a word opens, and what it closes."""
    word = match.group()
    if match["begin"]:
        return (match["name"], "") if match["begin"] == "begin" else ("", match["name"])
    if match["edge"]:
        return ("\\left", "") if match["edge"] == "left" else ("", "\\left")
    if word == "$":
        return ("", "$") if waiting and waiting[-1] == "$" else ("$", "")
    return (word, "") if word in _PAIRS.values() else ("", _PAIRS.get(word, ""))
