"""Tolerances: the finest that make sense, and those of single steps, whose errors add up.

Steps err with the same sign for long: what is asked for is that of a run, and a step may use up a
part of it alone.
"""

__all__ = ["EXACT", "FINEST", "SHARE", "taylor_tolerance"]

EXACT = 1e-16
"""Doubles have nothing to offer below this tolerance."""
FINEST = 2.3e-14
"""scipy refuses finer relative tolerances."""
SHARE = 0.1
"""The part of the tolerance that a step of DOP853 may use up, where doubles allow it: the errors of
a thousand steps add up to some ten times the tolerance."""
TERM = 0.1353352832366127
"""exp(-2): Taylor series for a tolerance finer by this have one term more, and steps as long as
before err by a part of it."""


def taylor_tolerance(tol: float, terms: int = 1) -> float:
    """The tolerance of a step of Taylor's method in doubles, for one of a run: finer by terms."""
    return max(tol * TERM**terms, min(tol, EXACT))
