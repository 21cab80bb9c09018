"""What can go wrong, sorted by who must act.

``DefinitionError``: the user mends the input.  ``EngineLimit``: the input is sound, but beyond
what the engine decides.  ``IntegrationError``: the numbers failed on the way.
"""

from __future__ import annotations

__all__ = ["DefinitionError", "EngineLimit", "IntegrationError", "VoronecError"]


class VoronecError(Exception):
    """Base of every error this package raises on purpose; the message is one line."""


class DefinitionError(VoronecError):
    """The input is wrong: the message names the object and the mend."""


class EngineLimit(VoronecError):
    """The input is meaningful, but exceeds what the exact algebra can do in its budget."""


class IntegrationError(VoronecError):
    """A trajectory could not be continued; ``time`` and ``state`` say how far it came."""

    def __init__(self, message: str, time: float | None = None, state: object = None) -> None:
        super().__init__(message)
        self.time = time
        self.state = state
