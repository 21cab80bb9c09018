"""Results in files: arrays with names and axes, and a header that says what they are.

A trajectory, an ensemble, a section and a sweep are each made ``NamedArrays`` first; from there one
way leads to NPZ, Parquet, Zarr and CSV, to pandas and to xarray, and one back.  The header
is JSON: what kind of result it is, of which system, the version of the format, the versions of
voronec and of what computes, and the command.  Nothing that a file holds is evaluated, and nothing
is unpickled.
"""

from __future__ import annotations

import csv
import json
import os
import shlex
import shutil
import sys
from collections.abc import Callable, Iterable, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any
from zipfile import BadZipFile

import mpmath
import numpy as np

from voronec.algebra.arguments import PATH, accepts, require
from voronec.declaration.whole_files import draft, unwritable, workshop
from voronec.errors import DefinitionError, file_errors, quote

if TYPE_CHECKING:
    from collections.abc import Iterator

    from voronec.declaration.system import System

FORMAT = 1
"""The version of what a header says, and of how arrays are laid out."""
HEADER = "voronec"
"""Under this name the header stands in a file."""
LIBRARIES = ("voronec", "numpy", "scipy", "heyoka", "sympy", "symengine", "python-flint")
"""What may change the digits of a result with its version."""


@dataclass(frozen=True, eq=False)
class NamedArrays:
    """Arrays, each with the names of its axes.

    ``axes`` are those of the table that a result is, and ``shown`` the columns of it that a CSV
    has; ``meanings`` say of variables what they are.  ``header`` is what JSON can hold; ``beside``
    are arrays that an NPZ holds besides, for who reads it with numpy alone.
    """

    variables: Mapping[str, tuple[tuple[str, ...], np.ndarray]]
    axes: tuple[str, ...]
    shown: tuple[str, ...]
    header: Mapping[str, Any]
    meanings: Mapping[str, str] = field(default_factory=dict)
    beside: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of(
        cls, system: System, kind: str, variables: Mapping[str, Any], axes: tuple[str, ...],
        shown: Iterable[str], beside: Mapping[str, Any] | None = None, **more: Any,
    ) -> NamedArrays:  # fmt: skip
        """Arrays of a result of this ``kind``; ``more`` is what its header says of it."""
        header, meanings = header_of(system, kind, **more), meanings_of(system)
        return cls(variables, axes, tuple(dict.fromkeys(shown)), header, meanings, beside or {})

    @property
    def sizes(self) -> dict[str, int]:
        """How long each axis is."""
        return {
            axis: length
            for axes, array in self.variables.values()
            for axis, length in zip(axes, array.shape, strict=True)
        }

    def columns(self) -> dict[str, np.ndarray]:
        """The table: for each variable along its axes one long column, the axes first."""
        sizes = self.sizes
        shape = tuple(sizes[axis] for axis in self.axes)
        table = {}
        for name in dict.fromkeys([*self.axes, *self.variables]):
            axes, array = self.variables.get(name) or ((name,), np.arange(sizes[name]))
            if axes and {*axes} <= {*self.axes}:
                aligned = array.reshape([sizes[a] if a in axes else 1 for a in self.axes])
                table[name] = np.broadcast_to(aligned, shape).reshape(-1)
        return table

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the arrays to ``path``, whole or not at all: ``.npz``, ``.parquet``, ``.zarr`` or
        ``.csv``.

        Raises ``DefinitionError`` for another ending, where there is no such folder, and where
        what is there is something else.
        """
        require("save", "path", path, PATH)
        target = Path(path)
        if target.suffix not in WRITERS:
            raise DefinitionError(f"'{target.name}' must end in {', '.join(WRITERS)}")
        if not target.parent.is_dir():
            raise DefinitionError(f"there is no folder '{target.parent}' to write into")
        with draft(target) if target.suffix != ".zarr" else _draft_of_folder(target) as new:
            WRITERS[target.suffix](self, new)
        return target

    def to_xarray(self) -> Any:
        """An ``xarray.Dataset`` of variables with their meanings, the header as attributes."""
        xarray = require_library("xarray")
        held = {
            name: xarray.Variable(axes, _object_text(array), self._attributes(name))
            for name, (axes, array) in self.variables.items()
        }
        along = {name for name, (axes, _) in self.variables.items() if axes == (name,)}
        return xarray.Dataset(
            {n: x for n, x in held.items() if n not in along},
            {n: held[n] for n in along}, {**self.header},
        )  # fmt: skip

    def _attributes(self, name: str) -> dict[str, str]:
        return {"long_name": self.meanings[name]} if name in self.meanings else {}

    def to_pandas(self) -> Any:
        """A ``pandas.DataFrame`` of the table; ``attrs`` holds the header."""
        pandas, columns = require_library("pandas"), self.columns()
        frame = pandas.DataFrame({n: x for n, x in columns.items() if n not in self.axes})
        where = [pandas.Index(columns[axis], name=axis) for axis in self.axes]
        frame.index = where[0] if len(where) == 1 else pandas.MultiIndex.from_arrays(where)
        frame.attrs = {**self.header}
        return frame


def require_library(module: str) -> Any:
    """A library of the extra ``sweeps``; ``DefinitionError`` where it is not installed."""
    try:
        return import_module(module)
    except ImportError:
        name = module.partition(".")[0]
        raise DefinitionError(
            f"{name} is not installed; install it with: pip install 'voronec[sweeps]'"
        ) from None


def versions() -> dict[str, str]:
    """The versions of voronec, of Python and of what computes."""
    releases = {"python": sys.version.partition(" ")[0]}
    for name in LIBRARIES:
        try:
            releases[name] = version(name)
        except PackageNotFoundError:  # heyoka is not everywhere
            continue
    return releases


def header_of(system: System, kind: str, **more: Any) -> dict[str, Any]:
    """What every file says of a result of this ``kind``, and ``more`` of this one."""
    command = [Path(sys.argv[0]).name, *sys.argv[1:]] if sys.argv else []
    return {
        "kind": kind, "format": FORMAT, "system": system.name, "title": system.title,
        "versions": versions(), "command": shlex.join(command), **more,
    }  # fmt: skip


def meanings_of(system: System) -> dict[str, str]:
    """What the quantities of a system are in words, by name, as far as it is declared."""
    from voronec.algebra.symbols import plain_name  # imports sympy, which no reader needs

    said = {p.name: p.meaning for p in system.parameters}
    things = {plain_name(k): m for k, m in system.meanings.items()}
    return {name: words for name, words in {**said, **things}.items() if words}


def plain_numbers(value: Any) -> Any:
    """An array or number that is stored without pickling: mpmath's numbers as text, with all their
    digits."""
    if isinstance(value, mpmath.mpf):
        return str(plain_numbers(np.array([value], dtype=object))[0])
    if isinstance(value, np.ndarray) and value.dtype == object:
        flat = list(value.ravel())
        digits = max((int(x._mpf_[3] * 0.302) + 2 for x in flat), default=17)
        return np.array([mpmath.nstr(x, max(digits, 17)) for x in flat]).reshape(value.shape)
    return value


def _object_text(array: np.ndarray) -> np.ndarray:
    """Text of any length, which has one meaning in all versions of Zarr."""
    return array.astype(object) if array.dtype.kind in "UT" else array


def of_motions(
    count: int, errors: Mapping[int, Any], *told: Mapping[str, Any], drift: Mapping[str, Any]
) -> dict[str, Any]:
    """Variables along ``motion``: the error of each, what is ``told`` of all by name, and their
    drifts."""
    error = np.array([str(errors.get(i, "")) for i in range(count)])
    each = {"error": error, **{name: x for part in told for name, x in part.items()}}
    each |= {f"drift {name}": x for name, x in drift.items()}
    return {name: (("motion",), np.broadcast_to(x, (count,))) for name, x in each.items()}


def variables_of(asked: Mapping[str, Any], *told: Mapping[str, Any]) -> dict[str, Any]:
    """What was asked for and what is told beside; of two with one name what was asked for."""
    return {name: x for part in (asked, *told) for name, x in part.items()} | {**asked}


@contextmanager
def _draft_of_folder(target: Path) -> Iterator[Path]:
    """A folder to write, which takes the place of ``target``, a saved result or nothing, when it is
    done."""
    try:
        if target.exists() and "kind" not in attributes_of(target):
            raise DefinitionError(
                f"'{target}' is no saved result that could be replaced; choose another name"
            )
        with workshop(target.parent) as made:
            yield made / target.name
            if target.exists():
                os.replace(target, made / "old")
            os.replace(made / target.name, target)
            shutil.rmtree(made / "old", ignore_errors=True)
    except (OSError, UnicodeEncodeError) as error:
        raise unwritable(target, error) from None


def attributes_of(folder: Path) -> dict[str, Any]:
    """The header of a Zarr group, empty where a folder or file is none."""
    try:
        said = json.loads((folder / "zarr.json").read_bytes())
    except (OSError, ValueError):
        return {}
    return dict(said.get("attributes", {})) if isinstance(said, dict) else {}


def _header(arrays: NamedArrays) -> dict[str, Any]:
    """The header of a file that knows no axes by itself."""
    axes = {name: list(axes) for name, (axes, _) in arrays.variables.items()}
    return {**arrays.header, "meanings": dict(arrays.meanings), "axes": axes}


def _write_npz(arrays: NamedArrays, path: Path) -> None:
    held = {array_key(name): x for name, (_, x) in arrays.variables.items()}
    np.savez(path, **{HEADER: np.array(json.dumps(_header(arrays))), **arrays.beside, **held})


def _write_parquet(arrays: NamedArrays, path: Path) -> None:
    arrow, parquet = require_library("pyarrow"), require_library("pyarrow.parquet")
    columns, sizes = arrays.columns(), arrays.sizes
    header = _header(arrays)
    header["table"] = {axis: sizes[axis] for axis in arrays.axes}
    header["beside"] = {  # what has other axes than the table
        name: array.tolist() for name, (_, array) in arrays.variables.items() if name not in columns
    }
    table = arrow.table({n: arrow.array(x.tolist() if x.dtype.kind == "U" else x)
                         for n, x in columns.items()})  # fmt: skip
    parquet.write_table(table.replace_schema_metadata({HEADER: json.dumps(header)}), path)


def _write_zarr(arrays: NamedArrays, path: Path) -> None:
    require_library("zarr")
    dataset = arrays.to_xarray()
    dataset = dataset.rename({name: array_key(str(name)) for name in dataset.variables})
    dataset.to_zarr(path, mode="w", consolidated=False)


def _write_csv(arrays: NamedArrays, path: Path) -> None:
    columns = arrays.columns()
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(arrays.shown)
        writer.writerows(zip(*(columns[n].tolist() for n in arrays.shown), strict=True))


WRITERS: Mapping[str, Callable[[NamedArrays, Path], None]] = {
    ".npz": _write_npz, ".parquet": _write_parquet, ".zarr": _write_zarr, ".csv": _write_csv,
}  # fmt: skip
"""What files of results end in, and what writes them."""


def array_key(name: str) -> str:
    """The name of a variable where a slash would mean a folder."""
    return name.replace("%", "%25").replace("/", "%2F")


def _as_name(key: str) -> str:
    return key.replace("%2F", "/").replace("%25", "%")


@accepts(path=PATH)
def open(path: str | os.PathLike[str]) -> Any:
    """What was saved to ``path``, or a folder that a sweep has written, as an ``xarray.Dataset``.

    Variables have names, axes and, as ``long_name``, their meanings; ``attrs`` has the rest: the
    kind of result, the system, versions, what was asked, and the command.  Zarr is read when
    values are asked for.  Raises ``DefinitionError`` where there is no such file, where it holds
    something else or is damaged, and where a newer version of voronec has written it.
    """
    source = Path(path)
    if source.suffix not in READERS:
        raise DefinitionError(f"'{source.name}' must end in {', '.join(READERS)} to be opened")
    with file_errors(source, "a saved result"):
        try:
            return READERS[source.suffix](source)
        except (ValueError, KeyError, TypeError, AttributeError, EOFError, BadZipFile) as error:
            what = quote(f"{type(error).__name__} {error}")
            raise DefinitionError(f"'{source}' is damaged or not voronec's: {what}") from None


def _require_format(header: Any, source: Path) -> dict[str, Any]:
    """A header, refused unless this version of voronec reads what it stands for."""
    if not isinstance(header, dict) or not isinstance(header.get("format"), int):
        raise DefinitionError(f"'{source}' holds no result that voronec has saved")
    if header["format"] > FORMAT:
        by = quote(header.get("versions", {}).get("voronec"))
        raise DefinitionError(
            f"'{source}' was saved by voronec {by}, in a newer format; update voronec to open it"
        )
    return header


def _dataset(header: dict[str, Any], arrays: Mapping[str, np.ndarray]) -> Any:
    """The dataset of a header that came with arrays."""
    axes, meanings = header.pop("axes"), header.pop("meanings")
    held = {name: (tuple(axes[name]), arrays[name]) for name in axes}
    return NamedArrays(held, (), (), header, meanings).to_xarray()


def _read_npz(source: Path) -> Any:
    with np.load(source, allow_pickle=False) as data:
        arrays = {_as_name(key): data[key] for key in data.files}
    if HEADER in arrays:
        return _dataset(_require_format(json.loads(str(arrays.pop(HEADER))), source), arrays)
    if not {"t", "state", "names"} <= arrays.keys():
        return _require_format(None, source)
    # a trajectory of version 0.9 or before: columns of the state, and a number each parameter
    state, names = arrays.pop("state"), arrays.pop("names")
    given = {n: arrays.pop(n).item() for n in [*arrays] if n.startswith("parameter ")}
    held = arrays | dict(zip(names.tolist(), state.T, strict=True))
    given = {name.removeprefix("parameter "): x for name, x in given.items()}
    header = {"kind": "Trajectory", "format": 0, "parameters": given, "meanings": {}}
    return _dataset({**header, "axes": {key: ["t"] for key in held}}, held)


def _read_parquet(source: Path) -> Any:
    table = require_library("pyarrow.parquet").read_table(source)
    said = (table.schema.metadata or {}).get(HEADER.encode())
    header = _require_format(None if said is None else json.loads(said), source)
    sizes, beside = header.pop("table"), header.pop("beside")
    arrays = {name: np.array(x) for name, x in beside.items()}
    for name, axes in header["axes"].items():
        if name not in beside:
            column = table[name].to_numpy().reshape([*sizes.values()])
            arrays[name] = column[tuple(slice(None) if a in axes else 0 for a in sizes)]
    return _dataset(header, arrays)


def _read_zarr(source: Path) -> Any:
    require_library("zarr")
    _require_format(attributes_of(source), source)
    dataset = require_library("xarray").open_zarr(source, consolidated=False, chunks=None)
    return dataset.rename({key: _as_name(str(key)) for key in dataset.variables})


READERS: Mapping[str, Callable[[Path], Any]] = {
    ".npz": _read_npz, ".parquet": _read_parquet, ".zarr": _read_zarr,
}  # fmt: skip
"""What opens files of results."""
