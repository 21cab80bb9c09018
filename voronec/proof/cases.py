"""A system under special values of its parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import sympy as sp

from voronec.algebra.symbols import plain_name
from voronec.declaration.claims import (
    KINDS,
    Case,
    expressions_of,
    replace_in_claims,
    without_claims,
)
from voronec.declaration.geometry import Fibration, Frame
from voronec.declaration.reading import expression
from voronec.declaration.scene import Parameter
from voronec.declaration.system import System
from voronec.errors import DefinitionError

__all__ = ["case_of", "case_values", "specialise"]


def specialise(
    system: System, parameters: Mapping[Any, Any], new: tuple[Parameter, ...] = ()
) -> System:
    """The system with some parameters replaced everywhere by numbers or by functions of others.

    ``new`` are parameters that these functions may hold besides those that remain.  Of the claims
    the integrals, equations and measure are kept that are defined at these values.
    """
    at = case_values(system, parameters)
    kept = tuple(p for p in system.parameters if p.symbol not in at)
    names = {plain_name(s) for s in at}
    return replace(
        system,
        fibration=_replaced_fibration(system.fibration, at),
        lagrangian=system.lagrangian.xreplace(at),
        constraints=tuple(c.xreplace(at) for c in system.constraints),
        parameters=(*kept, *new),
        possible=_still_possible(system, at),
        forces={q: e.xreplace(at) for q, e in system.forces.items()},
        frame=_replaced_frame(system.frame, at),
        invariants={k: e.xreplace(at) for k, e in system.invariants.items()},
        **without_claims() | _kept_claims(system, at),
        scenes={k: _without(scene, names) for k, scene in system.scenes.items()},
        drawing=None,
        shapes=(),
        bodies=(),
        motion=None,
    )


def _still_possible(system: System, at: Mapping[Any, Any]) -> dict[str, Any]:
    """What the remaining parameters must meet, the ranges of the replaced ones among it.

    What a value contradicts, as a mass of zero, is dropped: it is the case that says so.
    """
    ranges = {f"{c}": c for p in system.parameters if p.symbol in at for c in p.conditions}
    moved = {words: c.xreplace(at) for words, c in (*system.possible.items(), *ranges.items())}
    known = {p.symbol for p in system.parameters if p.symbol not in at}
    known |= {s for value in at.values() for s in value.free_symbols} - at.keys()
    open_ones = {words: c for words, c in moved.items() if c not in (sp.true, sp.false)}
    return {words: c for words, c in open_ones.items() if c.free_symbols <= known}


def case_of(system: System, case: Case) -> System:
    """The specialised system with the claims of the case alone."""
    at = case_values(system, case.parameters)
    bare = replace(system, **without_claims())
    fields = [kind.field for kind in KINDS if hasattr(case, kind.field)]
    own = {field: replace_in_claims(getattr(case, field), at) for field in fields}
    return replace(specialise(bare, case.parameters), **own)


def case_values(system: System, parameters: Mapping[Any, Any]) -> dict[sp.Expr, sp.Expr]:
    """Values by symbols of the system; keys may be names."""
    known = {p.name: p.symbol for p in system.parameters}
    values = {}
    for key, value in parameters.items():
        name = plain_name(key)
        if name not in known:
            raise DefinitionError(
                f"system '{system.name}' has no parameter '{name}' to give a value to; "
                f"its parameters are {', '.join(known)}"
            )
        values[known[name]] = expression(value, f"the value of '{name}'")
    return values


def _kept_claims(system: System, at: Mapping[Any, Any]) -> dict[str, Any]:
    """The integrals, equations and measure at some values of parameters."""
    density = {} if system.measure is None else {"": system.measure}
    return {
        "integrals": _finite_claims(system.integrals, at),
        "equations": _finite_claims(system.equations, at),
        "measure": _finite_claims(density, at).get(""),
    }


def _finite_claims(claims: Mapping[str, Any], at: Mapping[Any, Any]) -> dict[str, Any]:
    """Claims with parameters replaced, but for those that this makes infinite."""
    found = {}
    for name, claim in claims.items():
        try:
            special = replace_in_claims(claim, at)
        except DefinitionError:
            continue
        if not any(e.has(sp.zoo, sp.nan, sp.oo, -sp.oo) for e in expressions_of(special)):
            found[name] = special
    return found


def _replaced_fibration(fibration: Fibration, at: Mapping[Any, Any]) -> Fibration:
    """The fibration with parameters in its relations replaced."""
    return replace(fibration, relations=tuple(r.xreplace(at) for r in fibration.relations))


def _replaced_frame(frame: Frame | None, at: Mapping[Any, Any]) -> Frame | None:
    if frame is None:
        return None
    brackets = None
    if frame.brackets is not None:
        brackets = {
            pair: {c: e.xreplace(at) for c, e in parts.items()}
            for pair, parts in frame.brackets.items()
        }
    return replace(
        frame,
        expressions=tuple(e.xreplace(at) for e in frame.expressions),
        brackets=brackets,
        rates={q: e.xreplace(at) for q, e in frame.rates.items()},
    )


def _without(scene: Any, names: set[str]) -> Any:
    """A scene that sets none of the replaced parameters."""
    kept = {k: v for k, v in scene.parameters.items() if plain_name(k) not in names}
    return replace(scene, parameters=kept)
