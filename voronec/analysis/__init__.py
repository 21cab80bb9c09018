"""What is true of a motion: claims proved or refuted."""

from voronec.analysis.cases import specialised
from voronec.analysis.claims import Claim, check_claims
from voronec.analysis.measures import divergence

__all__ = ["Claim", "check_claims", "divergence", "specialised"]
