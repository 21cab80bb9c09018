"""What motions do in the long run: steady motions, their stability, periodic orbits, exponents,
bifurcation diagrams."""

from typing import TYPE_CHECKING

from voronec.algebra.lazy_names import load_on_use

if TYPE_CHECKING:
    from voronec.dynamics.integral_map import integral_map_of as integral_map_of
    from voronec.dynamics.phase_space import PhaseSpace as PhaseSpace
    from voronec.dynamics.variational import variational_flow as variational_flow

__all__, __getattr__, __dir__ = load_on_use(
    __name__,
    {
        "integral_map": "integral_map_of",
        "phase_space": "PhaseSpace",
        "variational": "variational_flow",
    },
)
