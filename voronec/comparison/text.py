"""Expressions read back from their text, without running it as code."""

from __future__ import annotations

from typing import Any

import sympy as sp

from voronec.algebra.text import printed
from voronec.errors import DefinitionError
from voronec.reading import shown

__all__ = ["read_expression"]


def read_expression(text: Any) -> sp.Expr:
    """What ``plain_text`` wrote; every name is a symbol but ``pi``, an unknown function a function.

    Raises ``DefinitionError`` for anything that is no expression.
    """
    if not isinstance(text, str):
        raise DefinitionError(f"'{shown(text)}' is no text of an expression")
    return printed(text, "a stored expression")
