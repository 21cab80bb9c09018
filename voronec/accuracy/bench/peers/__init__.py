"""Peers: what somebody else would do, in the same process.  None is needed to install or test."""

from voronec.accuracy.bench.peers.hand_programs import HANDWRITTEN
from voronec.accuracy.bench.peers.numba_dop853 import JITTED
from voronec.accuracy.bench.peers.physics import PHYSICS
from voronec.accuracy.bench.peers.scipy_lambdify import LAMBDIFIED

__all__ = ["PEERS"]

PEERS = (*HANDWRITTEN, *JITTED, *LAMBDIFIED, *PHYSICS)
"""Every peer, fastest kind first."""
