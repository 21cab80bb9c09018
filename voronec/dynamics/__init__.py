"""What motions do in the long run: steady motions, their stability, periodic orbits, exponents,
bifurcation diagrams."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from voronec.dynamics.integral_map import integral_map_of
    from voronec.dynamics.phase_space import PhaseSpace
    from voronec.dynamics.variational import variational_flow

__all__ = ["PhaseSpace", "integral_map_of", "variational_flow"]

_HOME = {
    "PhaseSpace": "phase_space",
    "integral_map_of": "integral_map",
    "variational_flow": "variational",
}


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(import_module(f"voronec.dynamics.{_HOME[name]}"), name)
    raise AttributeError(f"module 'voronec.dynamics' has no attribute '{name}'")
