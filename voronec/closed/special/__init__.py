"""Special motions of a system with quadratures: precessions, their stability, limits."""

from __future__ import annotations

from voronec.closed.special.bifurcation import BifurcationSet, bifurcation_set
from voronec.closed.special.elementary import Elementary, elementary
from voronec.closed.special.precessions import (
    Branch,
    End,
    Precessions,
    essential_rates,
    linear_matrix,
    precessions,
)
from voronec.closed.special.pseudo_regular import PseudoRegular, pseudo_regular
from voronec.closed.special.remarkable import Remarkable, remarkable
from voronec.closed.special.stability import Stability
from voronec.closed.special.stability_chart import StabilityChart, chart_of

__all__ = [
    "BifurcationSet",
    "Branch",
    "Elementary",
    "End",
    "Precessions",
    "PseudoRegular",
    "Remarkable",
    "Stability",
    "StabilityChart",
    "bifurcation_set",
    "chart_of",
    "elementary",
    "essential_rates",
    "linear_matrix",
    "precessions",
    "pseudo_regular",
    "remarkable",
]
