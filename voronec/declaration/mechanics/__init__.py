"""From objects of ``sympy.physics.mechanics`` to a system."""

from voronec.declaration.mechanics.system import from_mechanics

__all__ = ["from_mechanics"]
