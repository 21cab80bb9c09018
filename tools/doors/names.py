"""The doors of Python: every public name, with odd arguments among right ones."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

import sympy as sp

import voronec as vo
from doors.values import odd_value

X, Y, M, K, V, EPS = sp.symbols("x y m k v eps")
SPAN = [0.0, 0.5, 1.0]


def python_door(dice: Random, place: Path) -> tuple[str, Callable[[], Any]]:
    """A public name with right arguments, one or two of which are odd; or a method of a result."""
    table = _table()
    name = dice.choice([*table])
    function, right = table[name]
    arguments = dict(right)
    optional = _optional(name)
    for _ in range(dice.choice((1, 1, 1, 2))):
        key = dice.choice([*right, *optional])
        arguments[key] = _oddly(dice, right.get(key))
    told = ", ".join(f"{k}={_words_of(v)}" for k, v in arguments.items() if right.get(k) is not v)
    return f"{name}({told})", lambda: _use(name, function(**arguments))


def _oddly(dice: Random, right: Any) -> Any:
    """An odd value, or a right one with an odd part."""
    if isinstance(right, dict) and right and dice.random() < 0.6:
        key = dice.choice([*right])
        if dice.random() < 0.3:
            return {**right, dice.choice(["x", X, "no", "", None, 3, _hashable(dice)]): 1}
        return {**right, key: odd_value(dice)}
    if isinstance(right, (tuple, list)) and right and dice.random() < 0.6:
        parts = list(right)
        parts[dice.randrange(len(parts))] = odd_value(dice)
        return type(right)(parts) if dice.random() < 0.8 else parts * 2
    return odd_value(dice)


def _hashable(dice: Random) -> Any:
    value = odd_value(dice)
    try:
        hash(value)
    except TypeError:
        return "odd"
    return value


def _words_of(value: Any) -> str:
    try:
        text = repr(value)
    except Exception:
        text = f"an object of {type(value)}"
    return ascii(text)[1:-1][:120]


def _use(name: str, result: Any) -> None:
    """What came out is used a little: a system is derived, equations are written."""
    if isinstance(result, vo.System):
        eqs = vo.derive(result)
        for source in (eqs.latex, eqs.python, eqs.c, eqs.as_dict):
            source()
        if name == "System":
            vo.integrate(
                eqs, times=SPAN, initial={"x": 0.1} if "x" in str(result.coordinates) else {}
            )
    elif isinstance(result, vo.Scene):
        vo.integrate(_system("oscillator"), scene=result, times=SPAN)
    elif isinstance(result, vo.Parameter):
        vo.derive(_oscillator(parameters=(result, K), lagrangian=None))
    elif isinstance(result, vo.Fibration):
        vo.derive(vo.System(name="s", fibration=result, lagrangian=vo.velocity(X) ** 2))
    elif isinstance(result, vo.Case):
        vo.check_claims(_oscillator(cases={"case": result}))
    elif isinstance(result, vo.Event):
        vo.integrate(_system("oscillator"), times=SPAN, events=result)


def _oscillator(**changes: Any) -> vo.System:
    own: dict[str, Any] = {
        "name": "oscillator",
        "fibration": vo.Fibration((X,)),
        "lagrangian": M * vo.velocity(X) ** 2 / 2 - K * X**2 / 2,
        "parameters": (vo.Parameter(M, 1, positive=True), vo.Parameter(K, 2)),
        "integrals": {"energy": M * vo.velocity(X) ** 2 / 2 + K * X**2 / 2},
        "scenes": {"default": vo.Scene({X: 1}, (0, 1), outputs=(X,))},
    }
    own |= {k: v for k, v in changes.items() if v is not None}
    return vo.System(**own)


@cache
def _system(name: str) -> vo.System:
    return _oscillator() if name == "oscillator" else vo.load(name)


@cache
def _trajectory() -> Any:
    return vo.integrate(_system("oscillator"), times=SPAN, dense=True)


@cache
def _closed_form() -> Any:
    return vo.closed_form(_system("demchenko"))


@cache
def _equations() -> Any:
    return vo.derive(_system("sleigh"))


def _optional(name: str) -> list[str]:
    function = _table()[name][0]
    found = inspect.signature(function).parameters.values()
    return [p.name for p in found if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)]


@cache
def _table() -> dict[str, tuple[Callable[..., Any], dict[str, Any]]]:
    """Every door: what is called, and right arguments."""
    x, sleigh = _system("oscillator"), _system("sleigh")
    motion = {"system": x, "times": SPAN, "initial": {"x": 1}, "parameters": {"m": 1}}
    point = {"x": 0, "y": 0, "phi": 0.3, "v": 1, "w": 2}
    return _declarations() | {
        "integrate": (vo.integrate, {**motion, "outputs": ("x",), "tol": 1e-9, "method": "scipy"}),
        "prepare": (vo.prepare, {"system": x, "outputs": ("x",), "tol": 1e-9, "method": "scipy"}),
        "run": (vo.prepare(x).run, {n: e for n, e in motion.items() if n != "system"}),
        "integrate heyoka": (vo.integrate, {**motion, "method": "heyoka"}),
        "integrate flint": (vo.integrate, {**motion, "method": "flint", "tol": 1e-25}),
        "integrate sleigh": (vo.integrate, {"system": sleigh, "times": SPAN, "events": ()}),
        "ensemble": (vo.ensemble, {
            "system": x, "starts": {"x": [0.0, 1.0]}, "times": SPAN, "outputs": ("x",)}),
        "section": (vo.section, {
            "system": x, "plane": "x", "crossings": 3, "until": 20.0, "initial": {"xdot": 1}}),
        "explain": (vo.explain, {"system": sleigh, "outputs": ("x",)}),
        "derive": (vo.derive, {"system": x}),
        "descend": (vo.descend, {"system": x, "invariants": {"g": X}}),
        "multiplier_acceleration": (vo.multiplier_acceleration, {"system": sleigh, "point": point}),
        "reaction_forces": (vo.reaction_forces, {
            "system": sleigh, "point": point, "digits": 20}),
        "acceleration": (_equations().acceleration, {"point": point, "digits": 20}),
        "prove_equal": (vo.prove_equal, {"a": X + 1, "b": 1 + X * 2 / 2, "relations": ()}),
        "prove_inequality": (vo.prove_inequality, {
            "a": X**2 + 1, "relation": ">", "b": 0, "positive": (), "real": (X,)}),
        "velocity": (vo.velocity, {"coordinate": X}),
        "load": (vo.load, {"name": "sleigh"}),
        "graph": (vo.graph, {"names": ("sleigh",)}),
        "check_claims": (vo.check_claims, {"system": x}),
        "check_relation": (vo.check_relation, {
            "relation": vo.Relation("a", "b", {}), "systems": (x,)}),
        "compare": (vo.compare, {"first": x, "second": x}),
        "divergence": (vo.divergence, {"density": X, "flow": {X: X**2}}),
        "search_integrals": (vo.search_integrals, {"system": x, "degree": 1, "positions": 1}),
        "search_measures": (vo.search_measures, {"system": x, "factors": (X,), "exponent": 1}),
        "search_reducing_multipliers": (vo.search_reducing_multipliers, {
            "system": x, "factors": (X,)}),
        "search_symmetries": (vo.search_symmetries, {"system": x, "at": {}}),
        "search_gauge_momenta": (vo.search_gauge_momenta, {
            "system": x, "positions": 1, "integrals": (), "fields": {}}),
        "exclude_rational_integrals": (vo.exclude_rational_integrals, {
            "system": x, "degree": 1, "body": (X,)}),
        "closed_form": (vo.closed_form, {"system": _system("demchenko"), "initial": {"s": 1}}),
        "precessions": (vo.precessions, {"system": _system("demchenko"), "parameters": {}}),
        "closed.at": (_closed_form().at, {"times": SPAN, "names": ("u", "v")}),
        "closed.enclose": (_closed_form().enclose, {"t": 1, "digits": 20}),
        "trajectory.at": (_trajectory().at, {"times": SPAN}),
        "trajectory[]": (_trajectory().__getitem__, {"key": "x"}),
        "trajectory.save": (_trajectory().save, {"path": "x.csv"}),
    }  # fmt: skip


def _declarations() -> dict[str, tuple[Callable[..., Any], dict[str, Any]]]:
    def plain(thing: Any) -> tuple[Any, dict[str, Any]]:
        return thing

    rate = vo.velocity(X)
    return {
        "System": plain((_oscillator, {
            "name": "s", "fibration": vo.Fibration((X,), (Y,)),
            "constraints": (vo.velocity(Y) - X * rate,),
            "lagrangian": M * (rate**2 + vo.velocity(Y) ** 2) / 2, "forces": {X: -K * X},
            "parameters": (vo.Parameter(M, 1), vo.Parameter(K, 2)),
            "integrals": {"energy": rate**2},
            "scenes": {"default": vo.Scene({X: 1})}, "frame": vo.Frame((V,), (rate,)),
            "invariants": {"g": X}, "references": ("Voronec1901",), "title": "t",
            "description": "d"})),
        "Fibration": (vo.Fibration, {"base": (X,), "fibre": (), "relations": ()}),
        "Frame": (vo.Frame, {"velocities": (V,), "expressions": (rate,)}),
        "Frame.quasi": (vo.Frame.quasi, {"definitions": {V: rate}}),
        "Scene": (vo.Scene, {"initial": {X: 1}, "times": (0.0, 1.0), "parameters": {M: 2},
                             "outputs": (X,), "caption": "c"}),
        "Parameter": (vo.Parameter, {"symbol": M, "value": 1, "positive": True, "lower": 0,
        "upper": 9}),
        "Case": (vo.Case, {"parameters": {K: 0}, "integrals": {"p": M * rate}}),
        "Measure": (vo.Measure, {"density": X, "variables": (X,)}),
        "Equation": (vo.Equation, {"function": (X,), "rate": (rate,)}),
        "Corrected": (vo.Corrected, {"right": X, "printed": Y, "source": "here"}),
        "Poisson": (vo.Poisson, {"variables": {X: X}, "bracket": {(X, Y): 1}, "hamiltonian": X}),
        "Relation": (vo.Relation, {"source": "a", "target": "b", "state": {X: X},
        "parameters": {M: M}}),
        "Limit": (vo.Limit, {"small": EPS, "parameters": {M: EPS}, "order": 1}),
        "Square": (vo.Square, {"first": ("a -> b",), "second": ("c -> d",)}),
        "Chart": (vo.Chart, {"state": {X: X}, "singular": X, "changes": {}, "back": {X: X}}),
        "Event": (vo.Event, {"function": X, "name": "e", "direction": 0, "stop": True}),
        "Trace": (vo.Trace, {"colatitude": X, "longitude": Y, "cosine": sp.cos(X)}),
        "Plane": (vo.Plane, {"place": (X, Y), "direction": (X, Y), "length": 1}),
        "Quadratures": (vo.Quadratures, {"variable": {X: X}, "constants": {K: X}, "quartic": X**4,
                                         "integrals": {Y: X}}),
        "HardCase": (vo.HardCase, {"name": "n", "system": "sleigh", "scene": vo.Scene({X: 1})}),
        **_geometry(),
    }  # fmt: skip


def _geometry() -> dict[str, tuple[Callable[..., Any], dict[str, Any]]]:
    """Constructors and functions of the kinematics, with no right arguments known but symbols."""
    found: dict[str, tuple[Callable[..., Any], dict[str, Any]]] = {}
    for name in sorted(set(dir(vo.kinematics))):
        thing = getattr(vo.kinematics, name)
        if name.startswith("_") or not callable(thing):
            continue
        try:
            needed = inspect.signature(thing).parameters.values()
        except (TypeError, ValueError):
            continue
        right = {p.name: (X, Y, K) for p in needed if p.default is p.empty and p.kind < 2}
        if right:
            found[f"kinematics.{name}"] = (thing, right)
    return found
