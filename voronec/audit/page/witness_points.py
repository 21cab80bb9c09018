"""The point of a witness for readers: its names in LaTeX, its values cut."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from voronec.audit.page.symbols import FUNCTIONS, LETTERS

__all__ = ["DIGITS", "plain", "point", "readable", "short"]

DIGITS = 12
"""Digits of a decimal that are shown; the plain data hold them all."""
_ZERO = re.compile(r"(?<![\w.])-?0(?:\.0*)?(?:e[+-]?\d+)?(?![\w.])")
_DERIVATIVE = re.compile(r"Derivative\((.*?), ((?:\w+'*, )*\w+'*)\)")
_WORD = re.compile(
    r"(?P<head>[A-Za-z]+?)(?P<digits>\d*)(?:_(?P<under>\w+?))?(?P<dots>(?:dot){0,2})(?P<tilde>~?)"
    r"(?!\w)|_(?P<sub>\w+)"
)


def plain(value: str) -> str:
    """A value in which a zero with exponents, as ``0e-44``, is ``0``."""
    return _ZERO.sub("0", value)


def short(value: str, digits: int = DIGITS) -> str:
    """A value with its decimals cut after ``digits`` significant digits, and dots for the rest."""

    def cut(match: re.Match[str]) -> str:
        whole, rest = match[1], match[2].rstrip("0")
        leading = len(rest) - len(rest.lstrip("0")) if not whole.strip("0") else 0
        kept = max(digits - len(whole.lstrip("0")), 1) + leading
        if len(rest) <= kept:
            return f"{whole}.{rest}" if rest else whole
        return f"{whole}.{rest[:kept]}..."

    return re.sub(r"(\d+)\.(\d+)", cut, plain(value))


def readable(name: str) -> str:
    """The name of a witness's coordinate as LaTeX: a derivative, a letter, its dots and index."""
    derivative = _DERIVATIVE.fullmatch(name)
    if derivative is not None:
        by = derivative[2].split(", ")
        order = f"^{len(by)}" if len(by) > 1 else ""
        below = "".join(rf"\partial {readable(x)}" for x in by)
        return rf"\partial{order} {readable(derivative[1])}/{below}"
    return _WORD.sub(_spell_name, re.sub(r"[\\{}]", "", name)).strip()


def _spell_name(match: re.Match[str]) -> str:
    """One word of a name: ``q1dot`` is ``\\dot{q}_{1}``."""
    head, below = match["head"], match["digits"] or match["under"] or match["sub"]
    script = f"_{{{_WORD.sub(_spell_name, below).strip()}}}" if below else ""
    if head is None:
        return script
    known = head in LETTERS or head in FUNCTIONS or head == "dot"
    letter = f"\\{head} " if known else head if len(head) == 1 else rf"\text{{{head}}}"
    accent = {"dot": "\\dot", "dotdot": "\\ddot"}.get(
        match["dots"], "\\tilde" * len(match["tilde"])
    )
    return f"{accent}{{{letter.strip()}}}{script}" if accent else letter + script


def point(witness: Mapping[str, Any]) -> str:
    """The point of a witness on one line, its names between dollar signs."""
    return ", ".join(
        f"${readable(name)}$ = {short(str(v), 6)}" for name, v in witness["point"].items()
    )
