"""The phase space of a system: its smallest closed equations, starts in them, and what is known to
stay constant there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import product
from typing import Any

import numpy as np
import symengine as se

from voronec.declaration.reading import several
from voronec.declaration.system import System, require_system
from voronec.dynamics.angles import SAME, are_angles
from voronec.dynamics.variational import VariationalFlow, variational_flow
from voronec.equations.program import Block, Program, compile_program
from voronec.equations.program.jacobian import joint_block
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError, did_you_mean
from voronec.motion.inputs import drive
from voronec.motion.motion_pool import Many, many
from voronec.motion.request import Namespace, quantity, scene_of, spread_starts
from voronec.motion.state_probe import quantities
from voronec.motion.steppers import units_of_many
from voronec.motion.verify import is_proved

RANK = 1e-9
"""Gradients depend on one another where they do so to this part of their size."""
FEW_STATES = 10
"""Of so many states all changes of signs are tried as reversals."""


@dataclass(frozen=True, eq=False)
class PhaseSpace:
    """The smallest closed equations of some variables, and starts in them.

    ``motions`` holds the program, the starts and the parameters; ``constants`` are the proved
    integrals and the relations between the variables, by name; ``is_driven`` tells whether the
    time stands in the equations.  Parameters that are ``moving`` stand among the variables, and
    are constants of the motion.
    """

    motions: Many
    constants: Mapping[str, Any]
    is_driven: bool
    moving: tuple[str, ...] = ()

    @classmethod
    def of(
        cls, system: System | VoronecEquations, scene: Any, starts: Any, parameters: Any,
        inputs: Any, variables: Any,
    ) -> PhaseSpace:  # fmt: skip
        """Of the named variables, by default the velocities of the equations; ``DefinitionError``
        where these make no sense, where an input has no constant value, or where the right side is
        not smooth."""
        declared = system.system if isinstance(system, VoronecEquations) else require_system(system)
        chosen = scene_of(declared, scene, starts is None, "starts")
        single, columns = spread_starts(starts, parameters or {})
        driven = drive(system, inputs, chosen).over(0.0, 1.0)
        if driven.changing is not None:
            raise DefinitionError(
                f"system '{declared.name}': variations take no table and no function of Python as "
                "an input; give an expression of the time"
            )
        columns = {**columns, **driven.parameters(0.0, 1.0)}
        namespace = Namespace.of(driven.equations, driven.meaning)
        asked = several(variables, "variables", "'omega1'") or driven.equations.system.velocities
        wanted = dict(quantity(namespace, key) for key in asked)
        motions = many(driven.equations, chosen, single, columns, wanted, 0.0, False)
        if not motions.sound:
            raise motions.wrong[0]
        program = motions.program
        if program.has_corners:
            raise DefinitionError(
                f"system '{declared.name}': its right side is not smooth (signs, steps or corners "
                "stand in it), so that its variations have no equations"
            )
        is_driven = program.time in program.derivative.symbols
        return cls(motions, _constants(namespace, motions), is_driven)

    @property
    def system(self) -> System:
        """The system."""
        return self.motions.namespace.equations.system

    @property
    def names(self) -> tuple[str, ...]:
        """The variables."""
        return tuple(map(str, self.motions.program.state))

    def with_variable(self, name: str) -> PhaseSpace:
        """With a parameter among the variables; ``DefinitionError`` where there is none."""
        motions, program = self.motions, self.motions.program
        known = [str(p) for p in program.parameters]
        if name not in known:
            near = did_you_mean(name, [*self.constants, *known])
            raise DefinitionError(
                f"along: '{name}' is neither a proved integral nor a parameter here{near}"
            )
        i = known.index(name)
        symbol, rest = (
            program.parameters[i],
            (*program.parameters[:i], *program.parameters[i + 1 :]),
        )
        still = Block(program.derivative.assignments, (*program.derivative.results, se.Integer(0)))
        wide = replace(
            program, velocities=(*program.velocities, symbol), parameters=rest, derivative=still
        )
        states = np.column_stack([motions.states, motions.values[:, i]])
        values = np.delete(motions.values, i, axis=1)
        moved = replace(motions, program=wide, states=states, values=values)
        return replace(self, motions=moved, constants={**self.constants, name: symbol},
                       moving=(*self.moving, name))  # fmt: skip

    def _rates(self, i: int, states: np.ndarray) -> np.ndarray:
        """The rates (m, n) at states (m, n) with the parameters of start i, at some instant."""
        rhs = compile_program(self.motions.program)[0]
        with np.errstate(all="ignore"):
            rates = rhs(np.float64(0.3), [*states.T], [*self.motions.values[i]])
        return np.stack([np.broadcast_to(r, len(states)) for r in rates], axis=-1)

    def _states_around(self, i: int) -> np.ndarray:
        """Random states (3, n) around start i."""
        start = self.motions.states[i]
        return start + 0.3 * np.random.default_rng(1).standard_normal((3, len(start)))

    def angles(self) -> np.ndarray:
        """Which variables are angles: a whole turn of them changes no rate at random states."""
        states = self._states_around(0)
        return are_angles(partial(self._rates, 0), states, len(self.names))

    def flow(self, k: int | None = None) -> VariationalFlow:
        """The flow with k variations, by default all."""
        return variational_flow(self.motions.program, k)

    def units(self, i: int) -> np.ndarray:
        """The sizes of the variables (n,) of start i."""
        rows = self.motions.states[i : i + 1], self.motions.values[i : i + 1]
        return np.asarray(units_of_many(self.motions.program, *rows)[0])

    @cached_property
    def _gradients(self) -> tuple[Program, tuple[tuple[int, int], ...]]:
        """What computes the constants and their slopes, and where these stand."""
        program = quantities(self.motions.ground.form, self.constants)
        state = self.motions.program.state
        block, places = joint_block(program, program.extras, state)
        names = (*program.names, *(f"slope {i}" for i in range(len(places))))
        return replace(program, names=names, extras=block), places

    def constants_at(self, x: Any, values: Any) -> tuple[np.ndarray, np.ndarray]:
        """The constants of the motion (c,) and their gradients (c, n) at a state."""
        (program, places), flow = self._gradients, self.motions.program
        given = dict(zip(map(str, (*flow.state, *flow.parameters)), (*x, *values), strict=True))
        here = [
            [float(given[str(s)]) for s in part] for part in (program.state, program.parameters)
        ]
        outputs = compile_program(program, scalar=True)[1](0.0, *here)
        count = len(self.constants)
        gradients = np.zeros((count, len(flow.state)))
        for place, slope in zip(places, outputs[count:], strict=True):
            gradients[place] = slope
        constants = np.array(outputs[:count], dtype=float)
        rounding = np.abs(gradients).max(axis=1, initial=0.0) <= RANK * np.abs(constants)
        gradients[rounding] = 0.0
        return constants, gradients

    def rank(self, x: Any, values: Any) -> int:
        """How many constants of the motion are independent at a state."""
        if not self.constants:
            return 0
        gradients = self.constants_at(x, values)[1]
        sizes = np.linalg.norm(gradients, axis=1)
        rows = gradients[sizes > 0] / sizes[sizes > 0, None]
        return int(np.linalg.matrix_rank(rows, RANK)) if len(rows) else 0

    def reversals(self, i: int) -> Iterator[tuple[int, ...]]:
        """Signs r with f(r x) = -r f(x) for the parameters of start i, as found at random states:
        with them every motion is run through backwards by another."""
        n, states = len(self.names), self._states_around(i)
        if n > FEW_STATES:
            return
        there = self._rates(i, states)
        for signs in product((1, -1), repeat=n):
            wrong = np.abs(self._rates(i, states * signs) + there * signs).max()
            if -1 in signs and wrong <= SAME * np.abs(there).max():
                yield signs

    def reversal(self, i: int) -> tuple[int, ...] | None:
        """The first of the ``reversals``; None where there are none."""
        return next(self.reversals(i), None)


def _constants(namespace: Namespace, motions: Many) -> dict[str, Any]:
    """The proved integrals and the relations, in the variables of the program."""
    ground, equations = motions.ground, namespace.equations
    known = {*motions.program.parameters, *(name for name, _ in ground.form.stages)}
    state = {*motions.program.state}
    inside = {n: e for n, e in ground.integrals.items() if e.free_symbols <= known | state}
    proved = {n: e for n, e in inside.items() if is_proved(equations, n)}
    relations = {f"relation {i + 1}": r for i, r in enumerate(ground.form.relations)}
    plain = {*motions.program.parameters} | state  # what stages solve holds of itself
    return proved | {n: r for n, r in relations.items() if r.free_symbols <= plain}
