"""What is true of a motion: claims proved or refuted."""

from voronec.analysis.claims import Claim, check_claims, measure_defect, rate_of_change

__all__ = ["Claim", "check_claims", "measure_defect", "rate_of_change"]
