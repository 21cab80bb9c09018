"""Systems of textbooks as somebody writes them down from the documentation of text files alone.

Their equations were derived by hand: they are claimed, and proved.  Their motions are compared with
closed forms, or with numbers from the equations derived by hand.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import voronec as vo

pytestmark = pytest.mark.slow

CARRIAGE = """
name = "carriage"
title = "Two-wheeled carriage on an incline"
lagrangian = "kinetic - potential"
constraints = [
  "xdot*sin(phi) = ydot*cos(phi)",
  "R*theta1dot = xdot*cos(phi) + ydot*sin(phi) - b*phidot",
  "R*theta2dot = xdot*cos(phi) + ydot*sin(phi) + b*phidot",
]
fibre = ["y", "theta1", "theta2"]

[coordinates]
x = "downhill"
y = "across"
phi = "heading"
theta1 = "left wheel"
theta2 = "right wheel"

[velocities]
v = "xdot*cos(phi) + ydot*sin(phi)"
w = "phidot"

[parameters]
m = { value = 2, positive = true }
J = { value = 1, positive = true }
I = { value = 0.1, positive = true }
R = { value = 0.3, positive = true }
b = 0.5
l = 0.2
g = 9.81
alpha = 0.1

[definitions]
body = "m*((xdot - l*phidot*sin(phi))^2 + (ydot + l*phidot*cos(phi))^2)/2 + J*phidot^2/2"
kinetic = "body + I*(theta1dot^2 + theta2dot^2)/2"
potential = "-m*g*sin(alpha)*(x + l*cos(phi))"

[integrals]
energy = "kinetic + potential"

[equations]
speed = { function = "(m + 2*I/R^2)*v", rate = "m*l*w^2 + m*g*sin(alpha)*cos(phi)" }
turning = { function = "(J + m*l^2 + 2*I*b^2/R^2)*w", rate = "-m*l*(v*w + g*sin(alpha)*sin(phi))" }

[scenes.default]
initial = { w = 1 }
times = [0, 10]
"""

BAR = """
name = "bar"
title = "Skate on an incline with a mass at its side"
lagrangian = "kinetic - potential"
constraints = ["xdot*sin(phi) = ydot*cos(phi)"]
fibre = ["y"]

[coordinates]
x = "downhill"
y = "across"
phi = "heading"

[velocities]
v = "xdot*cos(phi) + ydot*sin(phi)"
w = "phidot"

[parameters]
m1 = 1
m2 = 0.5
J = 1
d = 0.4
g = 9.81
alpha = "5*pi/180"

[definitions]
u1 = "xdot - d*phidot*cos(phi)"
u2 = "ydot - d*phidot*sin(phi)"
kinetic = "m1*(xdot^2 + ydot^2)/2 + J*phidot^2/2 + m2*(u1^2 + u2^2)/2"
potential = "-g*sin(alpha)*(m1*x + m2*(x - d*sin(phi)))"

[integrals]
energy = "kinetic + potential"

[equations]
along = { function = "(m1 + m2)*v - m2*d*w", rate = "(m1 + m2)*g*sin(alpha)*cos(phi)" }
turning = { function = "(J + m2*d^2)*w - m2*d*v", rate = "-m2*g*d*sin(alpha)*cos(phi)" }

[scenes.default]
initial = { w = 1 }
times = [0, 10]
"""

CYLINDER = """
name = "ball-in-cylinder"
title = "Ball that rolls inside a vertical cylinder"
lagrangian = "m*((rho*phidot)^2 + zdot^2)/2 + I*(o1^2 + o2^2 + o3^2)/2 - m*g*z"
constraints = ["rho*phidot + r*o3 = 0", "zdot - r*ot = 0"]
fibre = ["phi", "z"]

[coordinates]
psi = "precession"
theta = "nutation"
chi = "own rotation"
phi = "angle of the centre about the axis"
z = "height of the centre"

[parameters]
m = { value = 1, positive = true }
r = { value = 1, positive = true }
rho = { value = 3, positive = true }
I = { value = "2/5", positive = true }
g = 9.81

[definitions]
o1 = "thetadot*cos(psi) + chidot*sin(theta)*sin(psi)"
o2 = "thetadot*sin(psi) - chidot*sin(theta)*cos(psi)"
o3 = "psidot + chidot*cos(theta)"
ot = "-o1*sin(phi) + o2*cos(phi)"
on = "o1*cos(phi) + o2*sin(phi)"

[integrals]
energy = "m*((rho*phidot)^2 + zdot^2)/2 + I*(o1^2 + o2^2 + o3^2)/2 + m*g*z"
turning = "phidot"

[equations]
normal = { function = "on", rate = "phidot*zdot/r" }
height = { function = "zdot", rate = "-(m*g*r^2 + I*r*on*phidot)/(m*r^2 + I)" }

[scenes.default]
initial = { theta = 1, psidot = 2}
times = [0, 20]
outputs = ["z", "phi"]
"""


def read(folder: Path, text: str) -> vo.System:
    file = folder / "system.toml"
    file.write_text(text, "utf-8")
    return vo.load(file)


@pytest.mark.parametrize("text", [CARRIAGE, BAR, CYLINDER], ids=["carriage", "bar", "cylinder"])
def test_the_equations_by_hand_are_proved(tmp_path: Path, text: str) -> None:
    found = vo.check_claims(read(tmp_path, text))
    assert len(found) >= 3 and all(claim.verdict.proved for claim in found)


def test_a_carriage_goes_down_a_slope(tmp_path: Path) -> None:
    run = vo.integrate(read(tmp_path, CARRIAGE), times=np.linspace(0, 10, 21))
    m, J, wheel, R, b, before, slope = 2, 1, 0.1, 0.3, 0.5, 0.2, 9.81 * np.sin(0.1)

    def rates(_: float, s: np.ndarray) -> list[float]:
        phi, v, w = s[2:]
        along = m * before * w**2 + m * slope * np.cos(phi)
        turning = -m * before * v * w - m * before * slope * np.sin(phi)
        inertia = J + m * before**2 + 2 * wheel * b**2 / R**2
        speeds = [v * np.cos(phi), v * np.sin(phi), w]
        return [*speeds, along / (m + 2 * wheel / R**2), turning / inertia]

    agree(run, rates, ("x", "y", "phi", "v", "w"))


def test_a_skate_with_a_mass_at_its_side_goes_down_a_slope(tmp_path: Path) -> None:
    run = vo.integrate(read(tmp_path, BAR), times=np.linspace(0, 10, 21))
    first, second, J, aside, slope = 1, 0.5, 1, 0.4, 9.81 * np.sin(np.pi / 36)
    mass = [[first + second, -second * aside], [-second * aside, J + second * aside**2]]

    def rates(_: float, s: np.ndarray) -> list[float]:
        phi, v, w = s[2:]
        force = slope * np.cos(phi) * np.array([first + second, -second * aside])
        return [v * np.cos(phi), v * np.sin(phi), w, *np.linalg.solve(mass, force)]

    agree(run, rates, ("x", "y", "phi", "v", "w"))


def test_a_ball_in_a_vertical_cylinder_goes_up_and_down(tmp_path: Path) -> None:
    """It does not fall out: its height swings at sqrt(2/7) of the rate at which it goes around."""
    run = vo.integrate(read(tmp_path, CYLINDER))
    around = -2 / 3  # r psidot / rho, backwards
    swing = np.sqrt(2 / 7) * abs(around)
    height = -(5 / 7) * 9.81 / swing**2 * (1 - np.cos(swing * run.t))
    assert run["phi"] == pytest.approx(around * run.t, abs=1e-10)
    assert run["z"] == pytest.approx(height, abs=1e-8 * np.abs(height).max())


def agree(run: vo.Trajectory, rates: object, names: tuple[str, ...]) -> None:
    start = [float(run[name][0]) for name in names]
    span = run.t[0], run.t[-1]
    found = solve_ivp(rates, span, start, t_eval=run.t, rtol=1e-12, atol=1e-12, method="DOP853")
    for name, values in zip(names, found.y, strict=True):
        assert run[name] == pytest.approx(values, abs=1e-8)
