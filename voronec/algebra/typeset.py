"""LaTeX of SymPy expressions, with dots over coordinates and indices below letters."""

from __future__ import annotations

import re
from collections.abc import Iterable
from html import escape
from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef

from voronec.algebra.symbols import is_symbolic_name, plain_name, time, velocity
from voronec.algebra.text import as_expression

_GREEK = (
    "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi pi rho sigma tau "
    "upsilon phi chi psi omega"
).split()


def symbol_latex(name: str) -> str:
    """LaTeX of a bare name: ``theta`` is a Greek letter, ``u1`` has an index."""
    match = re.fullmatch(r"([A-Za-z]+?)_?(\d*)", name)
    if match is None:
        return str(sp.latex(sp.Symbol(name)))
    letters, digits = match.groups()
    if letters.lower() in _GREEK:
        letters = "\\" + letters
    elif len(letters) > 1:
        letters = r"\mathrm{" + letters + "}"
    return f"{letters}_{{{digits}}}" if digits else letters


def latex_of(expr: Any, coordinates: Iterable[sp.Expr], velocities: Iterable[sp.Expr] = ()) -> str:
    """LaTeX of an expression in a system's symbols; derivatives of coordinates get dots."""
    plain: dict[Any, Any] = {}
    names: dict[Any, str] = {}
    for thing in (*coordinates, *velocities):
        for order, dots in enumerate(("", r"\dot", r"\ddot")):
            symbol = thing
            for _ in range(order):
                symbol = velocity(symbol)
            stand_in = sp.Symbol(plain_name(symbol))
            plain[symbol] = stand_in
            bare = symbol_latex(plain_name(thing))
            names.setdefault(stand_in, f"{dots}{{{bare}}}" if dots else bare)
    expr = as_expression(expr)
    if isinstance(expr, sp.MatrixBase):
        expr = expr.applyfunc(lambda e: e.xreplace(plain))
    else:
        expr = expr.xreplace(plain)
    for symbol in expr.free_symbols:
        names.setdefault(symbol, symbol_latex(symbol.name))
    names[time] = "t"
    return str(sp.latex(expr, symbol_names=names))


def plain_text(expr: Any) -> str:
    """An expression in one line of Python, coordinates ``x(t)`` and velocities by bare names."""
    expr = as_expression(expr)
    motions = expr.atoms(AppliedUndef, sp.Derivative)
    bare = {f: sp.Symbol(plain_name(f)) for f in motions if is_symbolic_name(getattr(f, "expr", f))}
    return str(expr.xreplace(bare))


def caret_text(expr: Any) -> str:
    """An expression in one line for people: powers as ``x^2``."""
    return plain_text(expr).replace("**", "^")


def html_table(caption: str, rows: Iterable[tuple[str, str]]) -> str:
    """A table of two columns for a notebook: words, and what may hold formulas between dollars."""
    lines = "".join(
        f'<tr><th style="text-align:left">{escape(name)}</th>'
        f'<td style="text-align:left">{escape(value)}</td></tr>'
        for name, value in rows
        if value
    )
    return f"<table><caption>{escape(caption)}</caption>{lines}</table>"
