"""Outcomes of searches as what JSON can hold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import sympy as sp

from voronec.algebra.typeset import plain_text
from voronec.algebra.verdicts import Verdict


def plain_data(value: Any) -> Any:
    """Numbers and texts as they are, expressions as text, verdicts by status and limits, data
    classes by their fields."""
    if isinstance(value, Verdict):
        return " ".join(filter(None, (value.status, value.limits)))
    if isinstance(value, sp.Basic):
        return plain_text(value)
    if isinstance(value, float):
        return round(value, 3)
    if is_dataclass(value):
        return {f.name: plain_data(getattr(value, f.name)) for f in fields(value)}
    if isinstance(value, Mapping):
        return {str(k): plain_data(v) for k, v in value.items()}
    return [*map(plain_data, value)] if isinstance(value, tuple | list) else value
