"""Tolerances: the finest that make sense, and those of single steps, whose errors add up.

Steps err with the same sign for long: what is asked for is that of a run, and a step may use up a
part of it alone.
"""

EXACT = 1e-16
"""Doubles have nothing to offer below this tolerance."""
FINEST = 2.3e-14
"""scipy refuses finer relative tolerances."""
LOOSE = 1000.0
"""An integral may change by so many tolerances in a step, in units of what its terms, or its slopes
times the state, are: integrators hold their tolerance only roughly."""
UNIT = 2.0**-52
"""The relative spacing of doubles."""
SHARE, ROUNDING = 0.1, 5e-14
"""The part of the tolerance that a step of DOP853 may use up: the errors of a thousand steps add up
to some ten times the tolerance. Below the other, rounding of a right side that cancels may keep any
step from coming; no less is asked for than half of the tolerance there."""
TERM = 0.1353352832366127
"""exp(-2): Taylor series for a tolerance finer by this have one term more, and steps as long as
before err by a part of it."""


def dop853_tolerance(tol: float) -> float:
    """The tolerance of a step of DOP853, for one of a run."""
    return max(SHARE * tol, min(tol / 2, ROUNDING), FINEST)


def taylor_tolerance(tol: float, terms: int = 1) -> float:
    """The tolerance of a step of Taylor's method in doubles, for one of a run: finer by terms."""
    return max(tol * TERM**terms, min(tol, EXACT))
