"""The finest tolerances that make sense: below the table of methods and below its integrators."""

__all__ = ["EXACT", "FINEST"]

EXACT = 1e-16
"""Doubles have nothing to offer below this tolerance."""
FINEST = 2.3e-14
"""scipy refuses finer relative tolerances."""
