"""What there is of a sweep in its folder, finished or not: read, drawn, and saved once more.

Nothing that computes is imported here, so that a sweep is soon opened.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from voronec.algebra.arguments import PATH, require
from voronec.errors import DefinitionError, did_you_mean
from voronec.motion.storage import NamedArrays, array_key, attributes_of, require_library
from voronec.motion.storage import open as open_saved


@dataclass(frozen=True)
class Sweep:
    """The folder of a sweep, finished or not: ``Sweep("run.zarr")`` is one that is there.

    ``interrupted`` says that the call which returned it was stopped by hand.
    """

    path: Path
    interrupted: bool = False

    def __post_init__(self) -> None:
        require("Sweep", "path", self.path, PATH)
        object.__setattr__(self, "path", Path(self.path))
        if attributes_of(self.path).get("kind") != "Sweep":
            raise DefinitionError(f"'{self.path}' is no folder of a sweep")

    def to_xarray(self) -> Any:
        """The numbers as an ``xarray.Dataset``, read when they are asked for; its axes are those of
        the grid, and ``start``."""
        return open_saved(self.path)

    def to_pandas(self) -> Any:
        """The numbers as a ``pandas.DataFrame``, a row for each motion."""
        return self._arrays().to_pandas()

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the numbers once more, to one file or folder, as ``Trajectory.save`` does."""
        return self._arrays().save(path)

    def _arrays(self) -> NamedArrays:
        data = self.to_xarray().load()
        held = {n: x.values for n, x in data.variables.items()}
        held |= {n: np.array(x.tolist()) for n, x in held.items() if x.dtype.kind in "OT"}
        variables = {str(n): (tuple(data[n].dims), x) for n, x in held.items()}
        meanings = {n: x.attrs["long_name"] for n, x in data.variables.items() if x.attrs}
        axes = tuple(map(str, data["finished"].dims))
        return NamedArrays(
            variables, axes, (*axes, *map(str, data.data_vars)), data.attrs, meanings
        )

    def points(self, name: str) -> Any:
        """The passages of a section, ``section(x=0)``, as a ``pandas.DataFrame``: ``row`` is the
        number of the motion in C order of the axes, ``t`` the time of the passage."""
        dataset, folder = require_library("pyarrow.dataset"), self.path / array_key(name)
        parts = sorted(folder.glob("*.parquet"))
        if not parts:
            known = sorted(p.parent.name for p in self.path.glob("*/*.parquet"))
            told = did_you_mean(name, {*known})
            raise DefinitionError(f"'{self.path}' holds no passages '{name}'{told}")
        require_library("pandas")
        paths = [str(p) for p in parts]
        return dataset.dataset(paths, format="parquet").to_table().to_pandas()

    def plot(self, names: Sequence[str] | None = None) -> Any:
        """What is recorded, by default the first columns, as a matplotlib ``Figure``: charts over
        two parameters, curves over one, histograms of draws, clouds of points of sections."""
        from voronec.sweeps.pictures import plot_sweep

        return plot_sweep(self.to_xarray(), self.points, names)

    def counts(self) -> dict[str, int]:
        """How many ``motions`` there are, and how many of them are ``finished`` or ``failed``."""
        data = self.to_xarray()
        finished, failed = data["finished"].values, data["reason"].values != ""
        return {
            "motions": finished.size,
            "finished": int(finished.sum()),
            "failed": int(failed.sum()),
        }

    def __repr__(self) -> str:
        told = ", ".join(f"{count} {what}" for what, count in self.counts().items())
        by_hand = ", stopped by hand" if self.interrupted else ""
        return f"Sweep({str(self.path)!r}, {told}{by_hand})"
