"""The functions of a program in any precision, on arrays of mpmath's numbers."""

from __future__ import annotations

import hashlib
import linecache
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import mpmath
import numpy as np

from voronec.equations.program.dialect import code
from voronec.equations.program.python import WORDS, mpmath_source
from voronec.equations.program.straight import Program

__all__ = ["compiled_digits", "precision"]

SPARE = 16
"""Bits beyond those of the numbers that come in."""


def precision(numbers: Any) -> int:
    """How many bits the longest of some numbers has, at least those of a double."""
    if isinstance(numbers, np.ndarray) and numbers.dtype != object:
        return 53
    flat = np.ravel(np.asarray(numbers, dtype=object))
    return max([53, *(x._mpf_[3] for x in flat if isinstance(x, mpmath.mpf))])


@lru_cache(maxsize=64)  # which way a motion goes at a wall is asked of the same few programs
def compiled_digits(program: Program) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """``rhs`` and ``extras`` of ``(t, state, parameters)``, for mpmath's numbers or arrays of them.

    They compute with the precision of time and state, and with that in force where it is finer.
    """
    source = mpmath_source(program)
    filename = f"<voronec digits {hashlib.sha256(source.encode()).hexdigest()[:12]}>"
    linecache.cache[filename] = (len(source), None, source.splitlines(keepends=True), filename)
    namespace: dict[str, Any] = {}
    exec(code(source, filename), namespace)
    for name in namespace.keys() & WORDS:
        number = 2 if name in ("atan2", "power", "hypot") else 1
        namespace[name] = np.frompyfunc(namespace[name], number, 1)
    return _careful(namespace["rhs"]), _careful(namespace.get("extras", lambda *_: []))


def _careful(function: Callable[..., Any]) -> Callable[..., Any]:
    def compute(t: Any, state: Any, parameters: Any) -> Any:
        columns = [np.ravel(np.asarray(x, dtype=object)) for x in (t, *state)]
        # short numbers, such as 1, say nothing of the precision that they are meant with
        bits = max(precision(np.concatenate(columns)), mpmath.mp.prec)
        with mpmath.workprec(bits + SPARE):
            moments = np.frompyfunc(mpmath.mpf, 1, 1)(t)
            return function(moments, state, parameters)

    return compute
