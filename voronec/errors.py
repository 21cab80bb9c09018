"""What can go wrong, sorted by who must act.

``DefinitionError``: the user mends the input.  ``EngineLimit``: the input is sound, but beyond
what the engine decides.  ``IntegrationError``: the numbers failed on the way.
"""

from __future__ import annotations

import os
import stat
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

__all__ = [
    "DefinitionError",
    "EngineLimit",
    "IntegrationError",
    "VoronecError",
    "did_you_mean",
    "file_errors",
    "printable",
    "quote",
]

LONGEST = 60
"""How much of an object a message quotes."""


class VoronecError(Exception):
    """Base of every error this package raises on purpose; the message is one printable line."""

    def __init__(self, message: object = "") -> None:
        super().__init__(printable(str(message)))


class DefinitionError(VoronecError):
    """The input is wrong: the message names the object and the mend."""


class EngineLimit(VoronecError):
    """The input is meaningful, but exceeds what the exact algebra can do in its budget."""


class IntegrationError(VoronecError):
    """A trajectory could not be continued; ``time`` and ``state`` say how far it came, and
    ``trajectory`` is the part up to there, where there is one; ``singular`` that the mass matrix is
    singular there."""

    def __init__(
        self,
        message: str,
        time: Any = None,
        state: Any = None,
        trajectory: Any = None,
        singular: bool = False,
    ) -> None:
        super().__init__(message)
        self.time = time
        self.state = state
        self.trajectory = trajectory
        self.singular = singular


def quote(thing: Any) -> str:
    """An object as a message quotes it: on one line, printable, and not too long."""
    try:
        text = str(thing)
    except Exception:  # somebody's own class, or a number too long for Python to print
        text = f"an object of kind {type(thing).__name__}"
    text = printable(text[: 20 * LONGEST])
    return text if len(text) <= LONGEST else text[: LONGEST - 3] + "..."


def printable(text: str) -> str:
    """A text on one line, letters that cannot be printed by their numbers."""
    line = " ".join(text.split())
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in line)


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """``; did you mean 'theta'?`` where known names are near, else which names there are."""
    import difflib  # `voronec --help` has no need of it

    listed = sorted(set(known))
    near = difflib.get_close_matches(name, listed, n=3, cutoff=0.5)
    near = near or difflib.get_close_matches(name.lower(), listed, n=3, cutoff=0.5)
    part = name.lower() if len(name) > 1 else ""
    near += [other for other in listed if part and part in other and other not in near]
    if near:
        return f"; did you mean {' or '.join(map(repr, near))}?"
    return f"; there are: {', '.join(listed) or 'none'}"


@contextmanager
def file_errors(path: Path, what: str) -> Iterator[None]:
    """While a file is read: that it is not there, or cannot be read, as a ``DefinitionError``; so
    is a device, which may have no end."""
    try:
        mode = os.stat(path).st_mode
        if stat.S_ISCHR(mode) or stat.S_ISBLK(mode):
            raise DefinitionError(f"'{path}' is a device; name {what}")
        yield
    except FileNotFoundError:
        raise DefinitionError(f"there is no file '{path}'") from None
    except IsADirectoryError:
        raise DefinitionError(f"'{path}' is a folder; name {what}") from None
    except OSError as error:
        raise DefinitionError(f"'{path}' cannot be read: {error.strerror}") from None
