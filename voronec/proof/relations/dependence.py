"""Whether parameters and unknown functions of a target have values that such things can have.

A parameter is a number: along each motion of the source its value is constant.  An unknown
function is one of its arguments: the value V(a, x) of f(a) may hold other state x of the source
only where d V(a(x), x) is a combination of the d a_i, modulo the relations; then V is a function of
a where the map leads.  Its derivatives are taken at constant x, which is right only where the part
of dV that comes from x vanishes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import symengine as se

from voronec.algebra.elimination import solve_linear
from voronec.algebra.verdicts import Verdict, decide_zero
from voronec.errors import EngineLimit
from voronec.proof.relations.parameters import applications
from voronec.proof.relations.statemap import StateMap

__all__ = ["foreign", "moving_parameters", "unsound_functions"]


def foreign(statemap: StateMap, symbol: Any, value: Any) -> list[Any]:
    """What the value of a parameter or a function holds of the state and the time of the source."""
    arguments = () if symbol.is_Symbol else symbol.args
    own = {*arguments, *statemap.source.parameters, statemap.small}
    return sorted(value.free_symbols - own, key=str)


def moving_parameters(statemap: StateMap) -> Iterator[tuple[str, Any]]:
    """The rates of parameters that hold state or time: they have to vanish."""
    for symbol, value in statemap.parameters.items():
        if symbol.is_Symbol and foreign(statemap, symbol, value):
            yield f"the parameter '{symbol}'", statemap.derivative(value)


def unsound_functions(statemap: StateMap) -> Iterator[Verdict]:
    """Why the value of an unknown function is none, or was not proved to be one."""
    for function, value in statemap.parameters.items():
        if function.is_Symbol:
            continue
        held = [z for z in foreign(statemap, function, value) if not _is_constant(statemap, z)]
        if held:
            try:
                why = _unsound(statemap, function, value, held)
            except EngineLimit as limit:
                why = Verdict("undecided", f"the function '{function.get_name()}': {limit}")
            if why is not None:
                yield why


def _is_constant(statemap: StateMap, variable: Any) -> bool:
    return decide_zero(statemap.derivative(variable), statemap.hypotheses).proved


def _unsound(statemap: StateMap, function: Any, value: Any, held: Sequence[Any]) -> Verdict | None:
    name = function.get_name()
    places = applications(statemap.target)[name]
    if len(places) > 1:
        raise EngineLimit("it holds state, and is taken of several arguments")
    images = [statemap.pull_back(a) for a in places[0].args]
    at = dict(zip(function.args, images, strict=True))
    variables = (*statemap.source.variables, statemap.source.time)
    slopes = {z: value.diff(z).xreplace(at) for z in held}
    part = [slopes.get(x, se.Integer(0)) for x in variables]
    if _is_spanned(statemap, part, (), variables):
        return None
    if _is_differentiated(statemap, name):
        why = "holds state, and the target differentiates it"
    elif _is_spanned(statemap, part, images, variables):
        return None
    else:
        why = "holds state that is no function of its arguments"
    return Verdict("refuted", f"the value of '{name}' {why}")


def _is_spanned(
    statemap: StateMap, part: Sequence[Any], functions: Sequence[Any], variables: Sequence[Any]
) -> bool:
    """Whether a differential is a combination of those of functions and of the relations."""
    rows = [[f.diff(x) for f in (*functions, *statemap.relations)] for x in variables]
    if not rows[0]:
        return all(decide_zero(e, statemap.hypotheses).proved for e in part)
    solved = solve_linear(rows, [[e] for e in part], statemap.hypotheses)
    return not solved.contradictory


def _is_differentiated(statemap: StateMap, name: str) -> bool:
    target = statemap.target
    inner = [
        d for e in (*target.entries, *target.relations) for d in e.atoms(se.Derivative, se.Subs)
    ]
    return any(f.get_name() == name for d in inner for f in d.atoms(se.FunctionSymbol))
