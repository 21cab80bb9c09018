"""Six exponents of the non-symmetric gyroscopic ball on a sphere by pynamicalsys, its equations and
their Jacobian by hand; microseconds for a unit of time, compiled before.

    python tools/figures/exponents_by_pynamicalsys.py     (where pynamicalsys is installed)
"""

from time import perf_counter
from typing import Any

import numpy as np
from numba import njit
from pynamicalsys import ContinuousDynamicalSystem  # type: ignore[import-not-found]

VALUES = np.array([2.0, 1.0, 1.0, 0.4, 0.5, 0.7, 0.3, -0.2, 0.5])
START = np.array([-0.90929743, 0.0, 0.41614684, 0.66499034, 1.5, 1.71602243])
TOLERANCE, SPAN, REPEATS = 1e-9, 100.0, 3


@njit
def parts(u: Any, p: Any) -> Any:
    """A, gamma, A gamma, c, omega and G + kappa; D and the scale 1/(1 - D (gamma, A gamma))."""
    d = p[2] * p[1] ** 2
    a, g, momentum = 1 / (p[3:6] + d), u[:3], u[3:]
    ag = a * g
    low = 1 / (1 - d * np.dot(g, ag))
    c = d * np.dot(momentum, ag) * low
    return a, g, ag, c, a * (momentum + c * g), momentum + p[6:9], d, low


@njit
def rates(t: float, u: Any, p: Any) -> Any:
    """gamma' = e gamma x omega, G' = (G + kappa) x omega."""
    _, g, _, _, w, h, _, _ = parts(u, p)
    e = p[0] / (p[0] + p[1])
    return np.concatenate((e * np.cross(g, w), np.cross(h, w)))


@njit
def jacobian(t: float, u: Any, p: Any) -> Any:
    """Its slopes, column by column."""
    a, g, ag, c, w, h, d, low = parts(u, p)
    e, found = p[0] / (p[0] + p[1]), np.zeros((6, 6))
    for j in range(3):
        unit = np.zeros(3)
        unit[j] = 1.0
        by_g = a * (d * (a[j] * u[3 + j] + 2 * c * ag[j]) * low * g + c * unit)
        by_momentum = a * (d * ag[j] * low * g + unit)
        found[:3, j] = e * (np.cross(unit, w) + np.cross(g, by_g))
        found[3:, j] = np.cross(h, by_g)
        found[:3, 3 + j] = e * np.cross(g, by_momentum)
        found[3:, 3 + j] = np.cross(unit, w) + np.cross(h, by_momentum)
    return found


if __name__ == "__main__":
    system = ContinuousDynamicalSystem(
        equations_of_motion=rates, jacobian=jacobian, system_dimension=6, number_of_parameters=9
    )
    system.integrator("rk45", atol=TOLERANCE, rtol=TOLERANCE)
    system.lyapunov(START, 1.0, parameters=VALUES)
    times = []
    for _ in range(REPEATS):
        began = perf_counter()
        system.lyapunov(START, SPAN, parameters=VALUES)
        times.append(perf_counter() - began)
    print(f"{min(times) / SPAN * 1e6:.1f} us for a unit of time at a tolerance of {TOLERANCE:g}")
