"""The independent route: d'Alembert's principle with Lagrange multipliers, solved at a point.

The package shares no code with the connection: it is the referee of the Voronec equations.
"""

from voronec.equations.referee.route import Reactions, multiplier_acceleration, reaction_forces

__all__ = ["Reactions", "multiplier_acceleration", "reaction_forces"]
