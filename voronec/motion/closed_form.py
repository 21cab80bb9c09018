"""``vo.closed_form``: from a system, a scene and values to a motion in closed form."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, Any

import sympy as sp

from voronec.algebra.arguments import VALUES, accepts
from voronec.algebra.symbols import plain_name
from voronec.closed import ClosedForm, InversionProblem, prepare
from voronec.closed.arithmetic import exact
from voronec.closed.compiled_motion import motion_of
from voronec.declaration.scene import Scene
from voronec.declaration.system import System, require_possible, require_system
from voronec.errors import DefinitionError
from voronec.motion.request import Namespace, StartData, Values, number, scene_of

if TYPE_CHECKING:
    from voronec.equations.voronec_equations import VoronecEquations
    from voronec.motion.motion_start import InitialState


@accepts(parameters=VALUES, initial=VALUES)
def closed_form(
    system: System | VoronecEquations,
    scene: str | Scene | None = None,
    parameters: Values | None = None,
    initial: Values | None = None,
) -> ClosedForm:
    """The motion of a system in closed form, from initial data at time 0.

    Arguments are those of ``integrate``.  Values given exactly are used exactly, floats as the
    doubles they are.  Raises ``DefinitionError`` for a system that declares no motion
    (``System.motion``), for input that makes no sense, and for parameters that no body has.
    """
    from voronec.equations.voronec_equations import VoronecEquations

    own = system.system if isinstance(system, VoronecEquations) else require_system(system)
    motion_of(own)
    chosen = scene_of(own, scene, initial is None)
    told = _plainly(own, chosen, parameters, initial)
    if told is not None:
        return _form(own, *told)
    from voronec.equations.voronec_equations import derive
    from voronec.motion.motion_start import InitialState

    equations = system if isinstance(system, VoronecEquations) else derive(own)
    namespace = Namespace.of(equations)
    given = StartData.of(namespace, chosen, parameters, initial)
    return closed_form_of_start(namespace, given, InitialState.of(namespace, given, 0.0, False))


def closed_form_of_start(
    namespace: Namespace, given: StartData, outset: InitialState
) -> ClosedForm:
    """The motion in closed form, from what ``integrate`` has read."""
    system = namespace.equations.system
    motion_of(system)
    names = {plain_name(q) for q in (*system.coordinates, *system.velocities)}
    initial = {**given.scene_initial, **given.initial}
    if {*initial} <= names and not outset.notes:
        return _form(system, given.parameters, initial)
    values: dict[Any, Any] = {
        p.symbol: given.parameters.get(p.name, p.value) for p in system.parameters
    }
    state = (*system.coordinates, *system.velocities)
    values |= {s: _digits(outset, i) for i, s in enumerate(state)}
    return _check(InversionProblem(prepare(system, values), values))


def _digits(outset: InitialState, i: int) -> Any:
    """Entry i of the start as a function of bits to a ball."""

    @cache
    def at(bits: int) -> Any:
        from voronec.closed.arithmetic import ball

        return ball(outset.exactly.problem(bits)[0][i])

    return at


def _plainly(
    system: System, scene: Scene | None, parameters: Any, initial: Any
) -> tuple[dict[str, Any], dict[str, Any]] | None:
    """Parameters and initial values by name, where all are coordinates and velocities of the
    equations; None where the system's equations are needed to read them."""
    own = {plain_name(q) for q in (*system.coordinates, *system.velocities)}
    constants = {*system.parameter_names}
    found: list[dict[str, Any]] = []
    told = (scene.parameters, scene.initial) if scene else ({}, {})
    given = ((told[0], parameters), (told[1], initial))
    for among, layers in zip((constants, own), given, strict=True):
        merged: dict[str, Any] = {}
        for layer in layers:
            if layer is not None and not isinstance(layer, Mapping):
                return None
            named = {k if isinstance(k, str) else _name(k): v for k, v in (layer or {}).items()}
            if not {*named} <= among or len(named) < len(layer or {}):
                return None
            merged |= named
        found.append(merged)
    return None if system.fibration.relations else (found[0], found[1])


def _name(key: Any) -> str:
    try:
        return plain_name(key)
    except (DefinitionError, AttributeError):
        return ""


def _form(system: System, given: Mapping[str, Any], initial: Mapping[str, Any]) -> ClosedForm:
    _require_ranges(system, given)
    values: dict[Any, Any] = {}
    for name, parameter in zip(system.parameter_names, system.parameters, strict=True):
        value = given.get(name, parameter.value)
        if value is None:
            raise DefinitionError(
                f"system '{system.name}': no value for the parameter {name}; give "
                f"parameters={{'{name}': ...}}"
            )
        values[parameter.symbol] = value
    own = dict(values)
    known: dict[Any, Any] = {}
    for q in (*system.coordinates, *system.velocities):
        value = initial.get(plain_name(q), 0)
        if isinstance(value, sp.Expr) and value.free_symbols:
            known = known or {s: exact(x) for s, x in own.items()}
            value = value.xreplace(known)
        if not isinstance(value, int | float):
            number(value, f"system '{system.name}': initial value '{plain_name(q)}'")
        elif value != value or value in (float("inf"), float("-inf")):
            raise DefinitionError(
                f"system '{system.name}': initial value '{plain_name(q)}' = {value} is not finite"
            )
        values[q] = value
    return _last(system, values)


def _last(system: System, values: Mapping[Any, Any]) -> ClosedForm:
    """The motion with these values: the last of a system is kept, with all that was computed of
    it, which takes longer than to evaluate it."""
    if not all(isinstance(x, int | float | sp.Expr) for x in values.values()):
        return _check(InversionProblem(prepare(system, values), values))
    key = frozenset((symbol, type(x).__name__, x) for symbol, x in values.items())
    kept: dict[Any, ClosedForm] = system.memo.once("last closed form", dict)
    found = kept.get(key)
    if found is None:
        found = _check(InversionProblem(prepare(system, values), values))
        kept.clear()
        kept[key] = found
    return found


def _check(problem: InversionProblem) -> ClosedForm:
    problem.check()
    return ClosedForm(problem)


def _require_ranges(system: System, given: Mapping[str, Any]) -> None:
    """Parameters within their ranges, and such as a body can have."""
    key = tuple(sorted((n, type(x).__name__, x) for n, x in given.items() if _plain(x)))
    whole = len(key) == len(given)
    good: list[Any] = system.memo.once("good parameters", list)  # the last; many motions share them
    if whole and key in good:
        return
    for parameter in system.parameters:
        value = given.get(parameter.name, parameter.value)
        if value is not None:
            number(value, f"system '{system.name}': parameter '{parameter.name}'")
            try:
                parameter.check(value)
            except DefinitionError as error:
                raise DefinitionError(f"system '{system.name}': {error}") from None
    require_possible(system, given)
    if whole:
        good[:] = [key]


def _plain(value: Any) -> bool:
    return isinstance(value, int | float)
