"""What pictures and pages need of a motion."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np

from voronec.declaration.system import System


class MotionRecord(Protocol):
    """Quantities of one motion at instants; a ``Trajectory`` is one.

    ``t`` has shape (k,), and ``record["u"]`` too.
    """

    @property
    def system(self) -> System:
        """The system that moves."""

    @property
    def t(self) -> np.ndarray:
        """The instants."""

    @property
    def outputs(self) -> tuple[str, ...]:
        """The names asked for."""

    @property
    def parameters(self) -> Mapping[str, Any]:
        """Values of parameters by name."""

    @property
    def cost(self) -> Any:
        """What it cost, a ``Cost``."""

    def __getitem__(self, key: Any) -> np.ndarray: ...
