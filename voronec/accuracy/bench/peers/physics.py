"""MuJoCo on a ball that rolls on a plane: a free body, a sphere on a plane, friction.

It solves a more general problem, contact with friction of many bodies, and is none the worse for
losing here.  Rolling without slipping is only approached: the contact is a damped spring, which
the step size makes stiffer.  ``mujoco-default`` is what one gets without a thought (only friction
is made high enough to hold); ``mujoco-best`` is the best found in a search over integrators,
cones, solvers, stiffness, impedance, gravity, friction ratios and slip iterations.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from voronec.accuracy.bench.contender import (
    Contender,
    NotHere,
    Outcome,
    Run,
    level_for,
    require_outputs,
    time_fastest,
    without,
)
from voronec.accuracy.problem import ProblemLevel, ReferenceProblem

__all__ = ["BEST", "PHYSICS", "Setting", "model_text"]

OUTPUTS = ("gamma1", "gamma2", "gamma3", "omega1", "omega2", "omega3")
MOMENTS: Mapping[str, tuple[str, str, str]] = {
    "chaplygin-ball": ("I1", "I2", "I3"),
    "homogeneous-ball": ("A", "A", "A"),
}
"""The balls on a plane, with the parameters that are their principal moments."""
STEPS = (2e-2, 1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4)
"""Coarse to fine, to where rounding and the soft contact end all gain."""


@dataclass(frozen=True)
class Setting:
    """MuJoCo's options.

    ``stiffness`` is the time constant of the contact in steps, 0 for MuJoCo's own of 0.02;
    ``options`` and ``impedance`` are texts for its model file.
    """

    integrator: str = "Euler"
    cone: str = "pyramidal"
    stiffness: float = 0.0
    impedance: str = "0.9 0.95 0.001 0.5 2"
    options: str = ""
    flags: str = ""
    friction: float = 1.0


DEFAULT = Setting()
BEST = Setting(
    integrator="RK4",
    cone="elliptic",
    stiffness=0.75,  # with 0.72 the damping of the contact reaches RK4's limit of stability
    impedance="0.9999 0.9999 0.001 0.5 2",
    options='impratio="100" tolerance="1e-12" iterations="20"',
    flags='<flag refsafe="disable" eulerdamp="disable"/>',
    friction=10.0,
)


def model_text(setting: Setting, step: float, mass: float, radius: float, moments: Any) -> str:
    """The model as MuJoCo's XML: a ball of given moments (3,) on a horizontal plane."""
    time = setting.stiffness * step if setting.stiffness else 0.02
    contact = (
        f'condim="3" friction="{setting.friction} 0 0" solref="{time!r} 1" '
        f'solimp="{setting.impedance}"'
    )
    inertia = " ".join(repr(float(x)) for x in moments)
    return (
        f'<mujoco><option timestep="{step!r}" integrator="{setting.integrator}" '
        f'cone="{setting.cone}" {setting.options}>{setting.flags}</option><worldbody>'
        f'<geom type="plane" size="0 0 1" {contact}/><body pos="0 0 {radius!r}"><freejoint/>'
        f'<inertial pos="0 0 0" mass="{mass!r}" diaginertia="{inertia}"/>'
        f'<geom type="sphere" size="{radius!r}" {contact}/></body></worldbody></mujoco>'
    )


def _prepare(question: ReferenceProblem, setting: Setting) -> Run:
    """A run of MuJoCo with steps of a given length; ``NotHere`` for what it cannot do."""
    name = question.system.name
    if name not in MOMENTS:
        raise NotHere(f"only for a ball on a plane: {', '.join(MOMENTS)}")
    require_outputs(question.outputs, OUTPUTS)
    try:
        import mujoco
    except ImportError:
        raise without("mujoco") from None
    if question.grid[0] != 0 or question.grid[-1] < 0:
        raise NotHere("runs forward from time 0 only")
    return partial(_simulate, mujoco, question, setting, level_for(question, "invariants"))


def _simulate(
    mujoco: Any, question: ReferenceProblem, setting: Setting, at: ProblemLevel, step: float
) -> Outcome:
    """The motion in steps of at most a given length, as many as fit between two instants."""
    gap = float(question.grid[1] - question.grid[0])
    each = max(1, int(np.ceil(gap / step - 1e-9)))
    p = question.parameters
    moments = [p[x] for x in MOMENTS[question.system.name]]
    text = model_text(setting, gap / each, p["m"], p["R"], moments)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)

    def once() -> np.ndarray:
        mujoco.mj_resetData(model, data)
        _place(mujoco, data, at, p["R"])
        rows = [_state_of(mujoco, data)]
        for _ in question.grid[1:]:
            mujoco.mj_step(model, data, each)
            rows.append(_state_of(mujoco, data))
        return np.array(rows)

    rows, seconds = time_fastest(once)
    if not np.isfinite(rows).all():
        raise NotHere("the simulation became unstable")
    known = dict(zip(OUTPUTS, rows.T, strict=True))
    states = np.column_stack([known[str(s)] for s in at.field.variables])
    values, drift = at.outputs_and_drift(question.grid, states)
    steps = each * (len(question.grid) - 1)
    stages = 4 if setting.integrator == "RK4" else 1
    return Outcome(values, seconds, stages * steps, steps, drift)


def _place(mujoco: Any, data: Any, at: ProblemLevel, radius: float) -> None:
    """Set the ball turning, its centre moving so that the contact rests.

    Only the vertical in the body is given by gamma; the heading is of no consequence.
    """
    named = dict(zip(map(str, at.field.variables), at.state, strict=True))
    gamma = np.array([named[f"gamma{i}"] for i in (1, 2, 3)])
    spin = np.array([named[f"omega{i}"] for i in (1, 2, 3)])
    side = np.cross(gamma, np.eye(3)[int(np.argmin(np.abs(gamma)))])
    side /= np.linalg.norm(side)
    turn = np.array([side, np.cross(gamma, side), gamma])  # its last row is gamma
    mujoco.mju_mat2Quat(data.qpos[3:7], turn.flatten())
    in_space = turn @ spin
    data.qvel[:3] = (radius * in_space[1], -radius * in_space[0], 0.0)
    data.qvel[3:] = spin


def _state_of(mujoco: Any, data: Any) -> np.ndarray:
    turn = np.empty(9)
    mujoco.mju_quat2Mat(turn, data.qpos[3:7])
    return np.concatenate([turn[6:], data.qvel[3:]])


def _physics(name: str, setting: Setting, about: str) -> Contender:
    prepare = partial(_prepare, setting=setting)
    return Contender(name, about, STEPS, prepare, knob="step")


GENERAL = "; it solves a more general problem"
PHYSICS = (
    _physics("mujoco-best", BEST, "MuJoCo with its best settings" + GENERAL),
    _physics("mujoco-default", DEFAULT, "MuJoCo with its default settings" + GENERAL),
)
