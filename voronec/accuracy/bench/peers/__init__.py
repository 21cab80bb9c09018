"""Peers: what somebody else would do, in the same process.  None is needed to install or test."""

from voronec.accuracy.bench.peers.hand_programs import CONTENDERS_BY_HAND
from voronec.accuracy.bench.peers.numba_dop853 import BY_NUMBA
from voronec.accuracy.bench.peers.physics import PHYSICS
from voronec.accuracy.bench.peers.scipy_lambdify import BY_LAMBDIFY

__all__ = ["PEERS"]

PEERS = (*CONTENDERS_BY_HAND, *BY_NUMBA, *BY_LAMBDIFY, *PHYSICS)
"""Every peer, fastest kind first."""
