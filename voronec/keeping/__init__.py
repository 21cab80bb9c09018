"""Finished verdicts are kept, and reused while nothing that they rest on has changed."""

from voronec.keeping.sources import closure, digest, engine_digest, engine_folder
from voronec.keeping.store import Store

__all__ = ["Store", "closure", "digest", "engine_digest", "engine_folder"]
