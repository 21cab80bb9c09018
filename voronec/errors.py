"""What can go wrong, sorted by who must act.

``DefinitionError``: the user mends the input.  ``EngineLimit``: the input is sound, but beyond
what the engine decides.  ``IntegrationError``: the numbers failed on the way.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

__all__ = ["DefinitionError", "EngineLimit", "IntegrationError", "VoronecError", "did_you_mean"]


class VoronecError(Exception):
    """Base of every error this package raises on purpose; the message is one line."""


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


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """``; did you mean 'theta'?`` where known names are near, else which names there are."""
    import difflib  # `voronec --help` has no need of it

    listed = sorted(set(known))
    near = difflib.get_close_matches(name, listed, n=3, cutoff=0.5)
    near = near or difflib.get_close_matches(name.lower(), listed, n=3, cutoff=0.5)
    near += [other for other in listed if name and name.lower() in other and other not in near]
    if near:
        return f"; did you mean {' or '.join(map(repr, near))}?"
    return f"; there are: {', '.join(listed) or 'none'}"
