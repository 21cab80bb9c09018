"""Rotations as matrices of doubles, written by hand: what motions near poles are held against."""

from __future__ import annotations

import numpy as np


def about(i: int, angle: float) -> np.ndarray:
    """The rotation about axis ``i``."""
    j, k = (i + 1) % 3, (i + 2) % 3
    turn = np.eye(3)
    turn[j, j] = turn[k, k] = np.cos(angle)
    turn[k, j] = np.sin(angle)
    turn[j, k] = -turn[k, j]
    return turn


def euler(phi: float, theta: float, psi: float) -> np.ndarray:
    """The rotation Rz(phi) Rx(theta) Rz(psi), body to space."""
    return about(2, phi) @ about(0, theta) @ about(2, psi)
