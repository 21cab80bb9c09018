"""The outputs of the smallest model held against those of the full equations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import symengine as se
from scipy.integrate import solve_ivp

import voronec as vo
from voronec.algebra.symbols import plain_name
from voronec.equations.program import Program, compile_program
from voronec.motion.observables import AngleBranch
from voronec.motion.request import Namespace

ERROR = 2e-9


def kinds(model: vo.Model) -> dict[str, str]:
    return {role.variable: role.kind for role in model.roles}


def names(model: vo.Model) -> set[str]:
    return {str(x) for x in model.states}


def start_of(motion: vo.Trajectory) -> dict[Any, float]:
    """Numbers of coordinates, velocities, parameters and the time at a full motion's start."""
    state = zip(motion.names, motion.state[0], strict=True)
    given = (*state, *motion.parameters.items(), ("t", motion.t[0]))
    return {se.Symbol(n): float(x) for n, x in given}


def followed(model: vo.Model, start: Mapping[Any, float], t: np.ndarray) -> dict[str, np.ndarray]:
    """The outputs along the model's own motion; nothing of the full one is used but its start."""
    own = model.cut
    values = dict(start)
    for x, meaning in model.full.start.items():
        values[x] = float(meaning.subs(dict(start)).n(53, real=True))
    for x, meaning in model.frozen.items():
        values[x] = float(meaning.subs(values).n(53, real=True))
    sides = {f"cos {n}": a.cosine for n, a in own.angles.items()}
    sides |= {f"sin {n}": a.sine for n, a in own.angles.items()}
    program = Program.of(own.form, {**own.outputs, **sides})
    rates, extras = compile_program(program)
    constants = [values[p] for p in program.parameters]
    begin = [values[x] for x in program.state]
    states = np.zeros((0, len(t)))
    if begin:
        run = solve_ivp(
            lambda at, y: np.array(rates(at, list(y), constants), dtype=float), (t[0], t[-1]),
            begin, method="DOP853", rtol=1e-12, atol=1e-14, t_eval=t,
        )  # fmt: skip
        assert run.success, run.message
        states = run.y
    series = [np.broadcast_to(np.asarray(s, float), t.shape) for s in
              extras(t, list(states), constants)]  # fmt: skip
    found = dict(zip(program.names, series, strict=True))
    for n, angle in own.angles.items():
        branch = AngleBranch(f"cos {n}", f"sin {n}", angle.signs(start), start[angle.coordinate])
        found[n] = branch.along(found)
    return {n: found[n] for n in (*own.outputs, *own.angles)}


def agreed(
    system: vo.System | vo.VoronecEquations,
    outputs: Sequence[Any],
    end: float = 1.0,
    **setting: Any,
) -> vo.Model:
    """The model, its outputs held against those of the full equations."""
    equations = system if isinstance(system, vo.VoronecEquations) else vo.derive(system)
    system = equations.system
    model = vo.explain(equations, outputs=outputs, **setting)
    t = np.linspace(0.0, end, 41)
    scene = setting.pop("scene", None if "initial" in setting else "default")
    bare = None if scene is None else replace(system.scenes[scene], outputs=())
    full = vo.integrate(equations, scene=bare, times=t, method="scipy", **setting)
    assert {*full.names} == {*map(plain_name, (*system.coordinates, *system.velocities))}
    found, right = followed(model, start_of(full), t), read(equations, outputs, full)
    assert {*found} == {*right}
    for name in right:
        size = max(1.0, float(np.abs(right[name]).max()))
        assert np.abs(found[name] - right[name]).max() < ERROR * size, name
    return model


def read(
    equations: vo.VoronecEquations, outputs: Sequence[Any], full: vo.Trajectory
) -> dict[str, np.ndarray]:
    """Outputs from the states of a full motion."""
    wanted = Namespace.of(equations).read_outputs(outputs).expressions
    program = Program.of(equations.form, wanted)
    values = {**full.parameters}
    series = compile_program(program)[1](
        full.t, list(full.state.T), [values[str(p)] for p in program.parameters]
    )
    return {
        name: np.broadcast_to(np.asarray(x, float), full.t.shape)
        for name, x in zip(program.names, series, strict=True)
    }
