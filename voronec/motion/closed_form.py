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
from voronec.declaration.system import System, require_system
from voronec.errors import DefinitionError
from voronec.motion.request import Namespace, StartData, Values, scene_of, state_names

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
    from voronec.equations.voronec_equations import VoronecEquations, derive
    from voronec.motion.motion_start import InitialState

    declared = system.system if isinstance(system, VoronecEquations) else require_system(system)
    motion_of(declared)
    chosen = scene_of(declared, scene, initial is None)
    equations = system if isinstance(system, VoronecEquations) else derive(declared)
    namespace = Namespace.of(equations)
    given = StartData.of(namespace, chosen, parameters, initial)
    return closed_form_of_start(namespace, given, InitialState.of(namespace, given, 0.0, False))


def closed_form_of_start(
    namespace: Namespace, given: StartData, outset: InitialState
) -> ClosedForm:
    """The motion in closed form, from what ``integrate`` has read."""
    system = namespace.equations.system
    motion_of(system)
    values: dict[Any, Any] = {}
    for parameter in system.parameters:
        value = given.parameters.get(parameter.name, parameter.value)
        if value is None:
            raise DefinitionError(
                f"system '{system.name}': no value for the parameter {parameter.name}; give "
                f"parameters={{'{parameter.name}': ...}}"
            )
        values[parameter.symbol] = value
    initial, constants = {**given.scene_initial, **given.initial}, dict(values)
    plain = {*initial} <= {*state_names(system)} and not outset.notes
    for i, q in enumerate((*system.coordinates, *system.velocities)):
        value = initial.get(plain_name(q), 0) if plain else _digits(outset, i)
        if isinstance(value, sp.Expr) and value.free_symbols:
            value = value.xreplace(
                {s: exact(constants[s]) for s in constants.keys() & value.free_symbols}
            )
        values[q] = value
    return _last(system, values)


def _digits(outset: InitialState, i: int) -> Any:
    """Entry i of the start as a function of bits to a ball."""

    @cache
    def at(bits: int) -> Any:
        from voronec.closed.arithmetic import ball

        return ball(outset.exactly.problem(bits)[0][i])

    return at


def _last(system: System, values: Mapping[Any, Any]) -> ClosedForm:
    """The motion with these values: the last of a system is kept, with all that was computed of
    it, which takes longer than to evaluate it."""

    def make() -> ClosedForm:
        problem = InversionProblem(prepare(system, values), values)
        problem.check()
        return ClosedForm(problem)

    if not all(isinstance(x, int | float | sp.Expr) for x in values.values()):
        return make()
    key = frozenset((symbol, type(x).__name__, x) for symbol, x in values.items())
    return system.memo.last("last closed form", key, make)
