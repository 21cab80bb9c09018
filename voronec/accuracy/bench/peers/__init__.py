"""Peers: what somebody else would do, in the same process.  None is needed to install or test."""

from voronec.accuracy.bench.peers.handwritten import HANDWRITTEN
from voronec.accuracy.bench.peers.jitted import JITTED
from voronec.accuracy.bench.peers.lambdified import LAMBDIFIED
from voronec.accuracy.bench.peers.physics import PHYSICS

__all__ = ["PEERS"]

PEERS = (*HANDWRITTEN, *JITTED, *LAMBDIFIED, *PHYSICS)
"""Every peer, fastest kind first."""
