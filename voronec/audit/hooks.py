"""The functions that a paper brings along, asked so that an error in them is told as theirs."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

from voronec.declaration.plugin_files import failure
from voronec.errors import DefinitionError, VoronecError


class HookError(DefinitionError):
    """A function of the paper failed: its author must act, and no verdict can be given."""


def call_hook(hook: Callable[..., Any], *arguments: Any) -> Any:
    """What a function of the paper answers; ``HookError`` names the line in which it failed."""
    try:
        return hook(*arguments)
    except VoronecError:
        raise
    except Exception as error:
        raise HookError(
            failure(error, inspect.getsourcefile(inspect.unwrap(hook)) or "")
        ) from error
