"""Demchenko's ball without poles: its regular functions, and a reference of 38 digits for them."""

import flint
import numpy as np

R1, R2, M, A, K = 2.0, 1.0, 1.0, 0.4, 0.3
VALUES = {"R1": R1, "R2": R2, "M": M, "A": A, "k": K}


def moving_frame(u, v):
    e_u = [np.cos(u) * np.cos(v), np.cos(u) * np.sin(v), -np.sin(u)]
    e_v = [-np.sin(v), np.cos(v), 0 * v]
    n = [np.sin(u) * np.cos(v), np.sin(u) * np.sin(v), np.cos(u)]
    return np.array([e_u, e_v, n]).T


def without_poles(state):
    """Attitude, gamma and omega along the ball's axes: regular functions of the state."""
    u, v, theta, u1, v1, *spin = state
    body, space = moving_frame(u, v), moving_frame(u1, v1)
    c, s = np.cos(theta), np.sin(theta)
    turn = np.array([[-s, c, 0], [c, s, 0], [0, 0, -1]])
    return np.concatenate([(space @ turn @ body.T).ravel(), -body[:, 2], body @ np.array(spin)])


def reference(state, time, order=24, steps=10):
    """The same functions after a time, by Taylor's series of the equations along the ball's axes.

    G' = (G + k e3) x omega,  gamma' = epsilon gamma x omega,  R' = R [omega],
    omega = (G + (D/A)(gamma, G) gamma) / (A + D),  D = M R2^2: 38 digits, and no poles.
    """
    before = flint.ctx.prec, flint.ctx.cap
    flint.ctx.prec, flint.ctx.cap = 128, order + 1
    try:
        now = [*pole_free(state)]
        for _ in range(steps):
            series = [flint.arb_series([x]) for x in now]
            for _ in range(order):  # Picard's iteration wins one order a time
                rates = polynomial_rates(series)
                series = [x + rate.integral() for x, rate in zip(now, rates, strict=True)]
            now = [horner(x, flint.arb(time) / steps) for x in series]
        return np.array([float(x.mid()) for x in (*now[:12], *spin_of(now[9:12], now[12:]))])
    finally:
        flint.ctx.prec, flint.ctx.cap = before


def pole_free(state):
    """R by rows, gamma and G: a double would lose digits of the state near a pole."""
    u, v, theta, u1, v1, *spin = (flint.arb(float(x)) for x in state)

    def frame(u, v):
        return flint.arb_mat(
            [
                [u.cos() * v.cos(), -v.sin(), u.sin() * v.cos()],
                [u.cos() * v.sin(), v.cos(), u.sin() * v.sin()],
                [-u.sin(), 0, u.cos()],
            ]
        )

    turn = flint.arb_mat(
        [[-theta.sin(), theta.cos(), 0], [theta.cos(), theta.sin(), 0], [0, 0, -1]]
    )
    body = frame(u, v)
    attitude = (frame(u1, v1) * turn * body.transpose()).entries()
    # along (e_u, e_v, n), G is ((A + D) s, (A + D) tau, A n)
    moments = [A + M * R2**2, A + M * R2**2, A]
    own = flint.arb_mat([[flint.arb(m) * x] for m, x in zip(moments, spin, strict=True)])
    return [*attitude, *(-body[i, 2] for i in range(3)), *(body * own).entries()]


def spin_of(gamma, momentum):
    carried = flint.arb(M) * flint.arb(R2) ** 2
    along = dot(gamma, momentum) * (carried / flint.arb(A))
    total = flint.arb(A) + carried
    return [(g + along * c) / total for g, c in zip(momentum, gamma, strict=True)]


def polynomial_rates(series):
    gamma, momentum = series[9:12], series[12:]
    omega = spin_of(gamma, momentum)
    rows = [x for i in (0, 3, 6) for x in cross(series[i : i + 3], omega)]
    epsilon = flint.arb(R1) / (flint.arb(R1) + flint.arb(R2))
    whole = [momentum[0], momentum[1], momentum[2] + flint.arb(K)]
    return [*rows, *(epsilon * x for x in cross(gamma, omega)), *cross(whole, omega)]


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def horner(series, at):
    total = flint.arb(0)
    for i in reversed(range(len(series))):
        total = total * at + series[i]
    return total
