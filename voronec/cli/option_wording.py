"""Errors name arguments of Python; on the command line the options that mean them stand there."""

from __future__ import annotations

import re
from collections.abc import Mapping
from types import MappingProxyType

__all__ = ["as_options"]

OPTIONS: Mapping[str, str] = MappingProxyType(
    {
        r"inputs=\{'(\w+)': \.\.\.\}": r"--input \1=VALUE",
        r"(?:parameters|initial)=\{'(\w+)': \.\.\.\}": r"--set \1=VALUE",
        r"(?:parameters|initial)=\{\.\.\.\}": "--set NAME=VALUE",
        r"outputs=\(?\.\.\.\)?": "--outputs",
        r"\bmethod='([\w-]+)'": r"--method \1",
        r"\btol=(?=\S)": "--tol ",
        r"\btol (?=>=)": "--tol ",
        r"\bscene= one of": "--scene with one of",
        r"\bgive times$": "give --times 0:10",
        r"\bgive until=": "give --until T",
        r",? or give project=True": "",
    }
)
"""What an error advises in Python -> what one types instead."""


def as_options(message: str) -> str:
    """The message of an error with options in the place of arguments of Python."""
    for pattern, option in OPTIONS.items():
        message = re.sub(pattern, option, message)
    return message
