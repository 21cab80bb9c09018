"""The folder of a sweep: a Zarr group with an array for each column, whose shards are the chunks.

A chunk is written to drafts on the same disk, each synced and moved to its place; last of all its
entry in ``log`` appears.  A chunk with an entry is whole, and one without is computed again, so
that the folder tells what is left to do.  The entry has the digests of what was written.  Passages
of sections are lists: of these each chunk has a Parquet file.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from voronec.declaration.whole_files import lock_file, unwritable, workshop
from voronec.errors import DefinitionError, quote
from voronec.motion.storage import array_key, attributes_of, require_library
from voronec.sweeps.plan import SweepPlan
from voronec.sweeps.records import ChunkResult, RecordColumn

LOG = "log"
STATUS, REASON = "finished", "reason"
"""The arrays that say of each motion whether it went well, and why not."""
POINT_BYTES = 200
"""About what the passage of a motion takes on the disk."""


@dataclass(frozen=True)
class SweepFolder:
    """The folder of one sweep, which is known by its ``digest``."""

    path: Path
    plan: SweepPlan
    records: tuple[RecordColumn, ...]
    digest: str

    @contextmanager
    def drafts(self, header: Mapping[str, Any], meanings: Any) -> Iterator[Drafts]:
        """The folder, made if need be, while no other process writes in it.

        ``DefinitionError`` where it holds another sweep or something else, where another process
        writes in it, and where it cannot be written.
        """
        with ExitStack() as stack:
            try:
                if not self.path.exists():
                    self._make(header, meanings)
                self._require_same(header)
                lock = lock_file(self.path / LOG / "lock", os.O_CREAT)
                if lock is not None:
                    stack.callback(os.close, lock)
                made = stack.enter_context(workshop(self.path / LOG))
                drafts = Drafts(self, made, {name: self._draft(made, name) for name in self.names})
            except BlockingIOError:
                raise DefinitionError(
                    f"'{self.path}': another process writes this sweep; wait for it, or end it"
                ) from None
            except OSError as error:
                raise unwritable(self.path, error) from None
            yield drafts

    @property
    def names(self) -> list[str]:
        """The names of the arrays along all axes."""
        return [*(r.column for r in self.records if not r.is_list), STATUS, REASON]

    def kept_chunks(self) -> set[int]:
        """The numbers of the chunks that are whole, as their entries in the log tell."""
        entries = (json.loads(f.read_bytes()) for f in (self.path / LOG).glob("[0-9]*.json"))
        return {e["chunk"] for e in entries if e["digest"] == self.chunk_digest(e["chunk"])}

    def chunk_digest(self, chunk: int) -> str:
        """Under which name a chunk is known: the digest of the sweep, and its number."""
        return sha256(f"{self.digest} {chunk}".encode()).hexdigest()[:32]

    def _make(self, header: Mapping[str, Any], meanings: Mapping[str, str]) -> None:
        """An empty folder of this sweep, which appears whole."""
        zarr = require_library("zarr")
        parent = self.path.absolute().parent
        if not parent.is_dir():
            raise DefinitionError(f"there is no folder '{parent}' to write into")
        plan, texts = self.plan, {REASON, *(r.column for r in self.records if r.is_text)}
        with workshop(parent) as made:
            root = zarr.create_group(made / "sweep", attributes=dict(header))
            for name in (LOG, *(array_key(r.column) for r in self.records if r.is_list)):
                root.create_group(name)
            known = [(n, x, (n,)) for n, x in plan.axes.items()]
            known += [(n, x, (plan.dimensions[-1],)) for n, x in plan.starts.items()]
            for name, values, axes in known:
                about = {"long_name": meanings[name]} if name in meanings else {}
                array = root.create_array(
                    array_key(name), shape=values.shape, dtype="f8", dimension_names=axes,
                    attributes=about, chunks=(min(len(values), 2**20),),
                )  # fmt: skip
                array[:] = values
            for name in self.names:
                kind, empty = (str, "") if name in texts else (float, np.nan)
                if name == STATUS:
                    kind, empty = bool, False
                root.create_array(
                    array_key(name), shape=plan.shape, shards=plan.box, chunks=plan.box,
                    dtype=kind, fill_value=empty, dimension_names=plan.dimensions,
                )  # fmt: skip
            os.replace(made / "sweep", self.path)

    def _require_same(self, header: Mapping[str, Any]) -> None:
        there = attributes_of(self.path)
        if there.get("kind") != "Sweep":
            raise DefinitionError(
                f"'{self.path}' is there, and is no folder of a sweep; choose another name"
            )
        if there.get("digest") != self.digest:
            theirs, ours = there.get("digests"), header["digests"]
            theirs = theirs if isinstance(theirs, dict) else {}
            other = ", ".join(quote(k) for k in ours if theirs.get(k) != ours[k]) or "its digest"
            raise DefinitionError(
                f"'{self.path}' holds another sweep, which differs in {other}; choose another name"
            )

    def _draft(self, made: Path, name: str) -> Any:
        """An array like the one of that name, in which shards are written first."""
        key = array_key(name)
        (made / key).mkdir()
        shutil.copyfile(self.path / key / "zarr.json", made / key / "zarr.json")
        return require_library("zarr").open_array(made / key, mode="r+")


@dataclass(frozen=True)
class Drafts:
    """Where chunks of a folder are written before they take their places."""

    folder: SweepFolder
    made: Path
    arrays: Mapping[str, Any]

    def keep(self, chunk: int, found: ChunkResult) -> None:
        """Write a chunk; it is there whole once its entry in the log is.

        ``DefinitionError`` where the disk is full.
        """
        try:
            self._keep(chunk, found)
        except OSError as error:
            raise unwritable(self.folder.path, error) from None

    def _keep(self, chunk: int, found: ChunkResult) -> None:
        plan, reasons = self.folder.plan, found.reasons
        place = plan.place(chunk)
        shape = tuple(part.stop - part.start for part in place)
        at = [str(part.start // k) for part, k in zip(place, plan.box, strict=True)]
        columns = {**found.columns, STATUS: reasons == "", REASON: reasons}
        files = {}
        for name, array in self.arrays.items():
            if name == REASON and columns[STATUS].all():
                continue
            array[place] = columns[name].reshape(shape)
            shard = Path(array_key(name), "c", *at)
            if (self.made / shard).exists():  # what is empty all over has none
                files[str(shard)] = self._move(shard)
        for name, points in found.points.items():
            part = Path(array_key(name), f"{chunk:06d}.parquet")
            _write_points(self.made / part, points)
            files[str(part)] = self._move(part)
        entry = Path(LOG, f"{chunk:06d}.json")
        (self.made / LOG).mkdir(exist_ok=True)
        (self.made / entry).write_text(json.dumps({
            "chunk": chunk, "digest": self.folder.chunk_digest(chunk), "motions": len(reasons),
            "failed": int((reasons != "").sum()), "files": files,
        }, indent=1))  # fmt: skip
        self._move(entry)

    def _move(self, part: Path) -> str:
        """Move a file that is written to its place, once it is on the disk; its digest."""
        draft, target = self.made / part, self.folder.path / part
        with draft.open("rb") as file:
            os.fsync(file.fileno())
            digest = sha256(file.read()).hexdigest()
        target.parent.mkdir(parents=True, exist_ok=True)
        os.replace(draft, target)
        if hasattr(os, "O_DIRECTORY"):  # so that the name outlives a loss of power, too
            opened = os.open(target.parent, os.O_RDONLY | os.O_DIRECTORY)
            os.fsync(opened)
            os.close(opened)
        return digest


def _write_points(path: Path, points: Mapping[str, np.ndarray]) -> None:
    arrow, parquet = require_library("pyarrow"), require_library("pyarrow.parquet")
    path.parent.mkdir(exist_ok=True)
    parquet.write_table(arrow.table(dict(points)), path)


def require_room(path: Path, plan: SweepPlan, records: Sequence[RecordColumn]) -> None:
    """``DefinitionError`` where the disk has no room for what a sweep is likely to write."""
    each = 16 + sum(POINT_BYTES if r.is_list else 8 for r in records)
    wanted, parent = each * len(plan), path.absolute().parent
    free = shutil.disk_usage(parent).free if os.path.isdir(parent) else wanted
    if wanted > free:
        raise DefinitionError(
            f"{len(plan)} motions take about {wanted / 1e9:.3g} GB, and '{parent}' has "
            f"{free / 1e9:.3g} GB; record less, or choose another disk"
        )
