"""Motion by quadratures: one variable runs by a quartic, everything else by integrals over it.

    (dx/dtau)^2 = quartic(x),   d(angle)/dtau = rational in x,   dt/dtau = clock(x)     (23)

Declarations only; ``voronec check`` proves them, and ``voronec.closed`` evaluates the motion.
The number is that of docs/theory.md.
"""

from voronec.quadratures.declaration import Quadratures
from voronec.quadratures.places import Plane, Space, Trace

__all__ = ["Plane", "Quadratures", "Space", "Trace"]
