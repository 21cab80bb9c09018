"""MuJoCo on a ball that rolls on a plane: a free body, a sphere on a plane, friction.

It solves a more general problem, contact with friction of many bodies, and is none the worse for
losing here.  Rolling without slipping is only approached: the contact is a damped spring, which
the step size makes stiffer.  ``mujoco-default`` is what one gets without a thought (only friction
is made high enough to hold); ``mujoco-best`` is the best found in a search over integrators,
cones, solvers, stiffness, impedance, gravity, friction ratios and slip iterations.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from voronec.accuracy.bench import ReferenceProblem, time_fastest

OUTPUTS = ("gamma1", "gamma2", "gamma3", "omega1", "omega2", "omega3")
MUJOCO: Mapping[str, tuple[str, str, str]] = {
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


BEST = Setting(
    integrator="RK4",
    cone="elliptic",
    stiffness=0.75,  # with 0.72 the damping of the contact reaches RK4's limit of stability
    impedance="0.9999 0.9999 0.001 0.5 2",
    options='impratio="100" tolerance="1e-12" iterations="20"',
    flags='<flag refsafe="disable" eulerdamp="disable"/>',
    friction=10.0,
)
SETTINGS = {"best": BEST, "default": Setting()}


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


Run = Callable[[float], tuple[tuple[int, int, dict[str, np.ndarray]], float]]
"""At a step: steps, evaluations, values by name, and the seconds of the fastest repetition."""


def ball_run(values: Mapping[str, float], problem: ReferenceProblem, setting: Setting) -> Run:
    """The ball in steps of at most a given length, as many as fit between two instants; gamma and
    omega at the start are among the ``values``.  Raises ``ImportError`` without MuJoCo."""
    import mujoco

    p, gap = problem.parameters, float(problem.grid[1] - problem.grid[0])
    moments = [p[x] for x in MUJOCO[problem.system.name]]

    def run(step: float) -> tuple[tuple[int, int, dict[str, np.ndarray]], float]:
        each = max(1, int(np.ceil(gap / step - 1e-9)))
        text = model_text(setting, gap / each, p["m"], p["R"], moments)
        model = mujoco.MjModel.from_xml_string(text)
        data = mujoco.MjData(model)

        def once() -> np.ndarray:
            mujoco.mj_resetData(model, data)
            _place(mujoco, data, values, p["R"])
            rows = [_state_of(mujoco, data)]
            for _ in problem.grid[1:]:
                mujoco.mj_step(model, data, each)
                rows.append(_state_of(mujoco, data))
            return np.array(rows)

        rows, seconds = time_fastest(once)
        steps = each * (len(problem.grid) - 1)
        stages = 4 if setting.integrator == "RK4" else 1
        return (steps, stages * steps, dict(zip(OUTPUTS, rows.T, strict=True))), seconds

    return run


def _place(mujoco: Any, data: Any, values: Mapping[str, float], radius: float) -> None:
    """Set the ball turning, its centre moving so that the contact rests.

    Only the vertical in the body is given by gamma; the heading is of no consequence.
    """
    gamma = np.array([values[n] for n in OUTPUTS[:3]])
    spin = np.array([values[n] for n in OUTPUTS[3:]])
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
