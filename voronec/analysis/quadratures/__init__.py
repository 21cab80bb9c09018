"""Motions by quadratures proved: each statement of a declaration is a claim."""

from voronec.analysis.quadratures.ground import Ground
from voronec.analysis.quadratures.statements import check_motion, statements

__all__ = ["Ground", "check_motion", "statements"]
