"""What is recorded of the motions of a sweep, and how the numbers of a chunk are computed.

A record is a quantity at the end, its largest or least value at the instants, the drift of an
integral, the time of an event, the passages of a section, the class of a trace, the largest
Lyapunov exponents with their bars, or a function of a trajectory.  Each is a column, called as it
is asked for: ``final(x)``, ``max(x)``, ``drift(energy)``, ``time(x=1)``, ``section(x=0)``,
``class(ball)``, ``exponents(2)``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from voronec.algebra.symbols import plain_name
from voronec.algebra.text import exact_number
from voronec.declaration.reading import several
from voronec.declaration.system import System
from voronec.dynamics.exponents import exponents
from voronec.errors import DefinitionError, VoronecError, did_you_mean, quote
from voronec.motion.closed_form import closed_form
from voronec.motion.ensembles import ensemble
from voronec.motion.prepared_problem import integrate
from voronec.motion.request import Namespace, quantity
from voronec.motion.sections import section

FORM = re.compile(r"(final|max|min|drift|time|section|class|exponents)(?:\((.*)\))?", re.DOTALL)
EXTREMES: Mapping[str, Any] = {"max": np.fmax.reduce, "min": np.fmin.reduce}
MOST_EXPONENTS = 100
MOST_POINTS = 1000
"""Passages of a section that a motion gives at most."""


@dataclass(frozen=True)
class RecordColumn:
    """A column: its ``kind``, and what it is of: the name of an output or integral, a title of a
    trace, a function, or ``key`` = ``value`` of a surface."""

    column: str
    kind: str
    of: Any
    key: Any = None
    value: float = 0.0

    @property
    def is_text(self) -> bool:
        """Whether its values are words."""
        return self.kind == "class"

    @property
    def is_list(self) -> bool:
        """Whether a motion has any number of them."""
        return self.kind == "section"


class ChunkResult(NamedTuple):
    """The columns of a chunk, an entry each motion; ``reasons`` say why a motion failed, empty
    where it did not; ``points`` hold of each section arrays by name, ``row`` among them."""

    columns: dict[str, np.ndarray]
    reasons: np.ndarray
    points: dict[str, dict[str, np.ndarray]]


def read_records(namespace: Namespace, record: Any) -> tuple[RecordColumn, ...]:
    """The columns that ``record`` asks for: texts and functions, or a mapping of names to them.

    ``DefinitionError`` for what the system does not have.
    """
    named = record if isinstance(record, Mapping) else None
    alone = (record,) if callable(record) else record
    asked = [*named.values()] if named else several(alone, "record", "'final'")
    if not asked:
        raise DefinitionError("record: name what is to be recorded, such as 'final' or 'max(x)'")
    columns: dict[str, RecordColumn] = {}
    for i, one in enumerate(asked):
        parts = _read(namespace, one)
        for part in parts:
            name = part.column
            if named is not None:
                name = [*named][i] if len(parts) == 1 else f"{[*named][i]}: {name}"
            if name in columns and named is not None:
                raise DefinitionError(f"record: '{name}' stands twice; give it another name")
            columns[name] = RecordColumn(name, part.kind, part.of, part.key, part.value)
    return tuple(columns.values())


def _read(namespace: Namespace, one: Any) -> list[RecordColumn]:
    system = namespace.equations.system
    if callable(one) and not hasattr(one, "free_symbols"):
        name = getattr(one, "__name__", type(one).__name__)
        return [RecordColumn(name, "function", one)]
    form = FORM.fullmatch(one.strip()) if isinstance(one, str) else None
    kind, inside = (form[1], form[2]) if form else ("final", one)
    if kind in ("time", "section"):
        return [_surface(namespace, kind, inside or "", one)]
    if kind == "exponents":
        count = inside or "1"
        if not count.isdecimal() or not 0 < int(count) <= MOST_EXPONENTS:
            raise DefinitionError(f"record '{one}': say how many, as in 'exponents(2)'")
        return [RecordColumn(f"{what}({j + 1})", kind, (what, j), value=float(count))
                for what in ("exponent", "bar") for j in range(int(count))]  # fmt: skip
    if kind == "drift":
        known = _among(inside, [*system.integrals], f"system '{system.name}': integral")
        return [RecordColumn(f"drift({n})", kind, n) for n in known]
    if kind == "class":
        if system.motion is None or not system.motion.traces:
            raise DefinitionError(f"record 'class': system '{system.name}' declares no traces")
        titles = [trace.title for trace in system.motion.traces]
        return [RecordColumn(f"class({n})", kind, n) for n in _among(inside, titles, "trace")]
    if inside is None and kind == "final":
        state = (*system.coordinates, *system.velocities)
        return [RecordColumn(f"final({plain_name(q)})", kind, plain_name(q)) for q in state]
    if inside is None:
        raise DefinitionError(f"record '{kind}': say of what, as in '{kind}(x)'")
    name, _ = quantity(namespace, inside, "record")
    return [RecordColumn(f"{kind}({name})", kind, name, inside)]


def _among(inside: str | None, known: Sequence[str], kind: str) -> Sequence[str]:
    if inside is None:
        return known
    if inside not in known:
        raise DefinitionError(f"{kind} '{quote(inside)}' is unknown{did_you_mean(inside, known)}")
    return [inside]


def _surface(namespace: Namespace, kind: str, inside: str, one: str) -> RecordColumn:
    left, _, right = inside.partition("=")
    if not left.strip():
        raise DefinitionError(f"record '{kind}': say where, as in '{kind}(x=1)'")
    name, _ = quantity(namespace, left.strip(), "record")
    value = float(exact_number(right, f"record '{one}'")) if right else 0.0
    return RecordColumn(f"{kind}({name}={value:g})", kind, name, left.strip(), value)


@dataclass(frozen=True, eq=False)
class Task:
    """What is computed of every motion, and how: all that a process needs beside the starts."""

    system: System
    scene: str | None
    parameters: Mapping[str, Any]
    initial: Mapping[str, Any]
    inputs: Mapping[str, Any]
    times: np.ndarray
    records: tuple[RecordColumn, ...]
    method: str
    tol: float

    def compute(
        self, columns: Mapping[str, np.ndarray], rows: np.ndarray,
        progress: Callable[[float], Any] | None = None,
    ) -> ChunkResult:  # fmt: skip
        """The numbers of motions ``rows`` that start from ``columns``; ``KeyboardInterrupt`` where
        they are stopped by hand."""
        recorded, reasons = dict[str, np.ndarray](), dict[int, str]()
        points = dict[str, dict[str, np.ndarray]]()
        parameters = {*self.system.parameter_names}
        given = {
            "parameters": {
                **self.parameters,
                **{n: x for n, x in columns.items() if n in parameters},
            },
            "starts": {**self.initial, **{n: x for n, x in columns.items() if n not in parameters}},
        }
        self._ensemble(given, recorded, reasons, progress)
        for record in self.records:
            if record.kind in ("time", "section"):
                self._passages(record, given, rows, recorded, reasons, points)
        if wanted := [r for r in self.records if r.kind == "exponents"]:
            self._exponents(wanted, given, recorded, reasons)
        if alone := [r for r in self.records if r.kind in ("class", "function")]:
            for r in alone:
                empty = ("", object) if r.is_text else (np.nan, float)
                recorded[r.column] = np.full(len(rows), *empty)
            for i in range(len(rows)):
                row = {n: x[i].item() for n, x in columns.items()}
                self._alone(alone, i, row, recorded, reasons)
        told = np.full(len(rows), "", dtype=object)
        told[[*reasons]] = [*reasons.values()]
        for column in recorded.values():
            column[told != ""] = "" if column.dtype == object else np.nan
        order = [r.column for r in self.records if not r.is_list]
        return ChunkResult({name: recorded[name] for name in order}, told, points)

    def _ensemble(self, given: Any, found: Any, reasons: dict[int, str], progress: Any) -> None:
        """What an ensemble tells: quantities at the end and along the instants, and drifts."""
        records = [r for r in self.records if r.kind in ("final", "drift", *EXTREMES)]
        if not records:
            return
        outputs = {r.of: r.key if r.key is not None else r.of for r in records if r.kind != "drift"}
        run = ensemble(
            self.system, given["starts"], given["parameters"], self.times,
            [*outputs.values()], self.scene, self.method, self.tol, progress=progress,
            inputs=self.inputs or None, strict=False,
        )  # fmt: skip
        _enter_errors(run, reasons)
        for record in records:
            if record.kind == "drift":
                if record.of not in run.drift:
                    raise DefinitionError(
                        f"record '{record.column}': the equations of what is recorded do not hold "
                        "this integral; record 'final' too"
                    )
                found[record.column] = np.array(run.drift[record.of])
                continue
            series = run[record.of]
            found[record.column] = (
                series[:, -1].copy() if record.kind == "final"
                else EXTREMES[record.kind](series, axis=1)
            )  # fmt: skip
            for i in np.flatnonzero(~np.isfinite(found[record.column])):
                reasons.setdefault(int(i), f"{record.column} has no value in real numbers")

    def _passages(
        self, record: RecordColumn, given: Any, rows: np.ndarray, found: Any,
        reasons: dict[int, str], points: Any,
    ) -> None:  # fmt: skip
        """The first time at a surface, in either direction; or all passages upwards."""
        first = record.kind == "time"
        run = section(
            self.system, record.key, (record.key,) if first else (), self.scene,
            parameters=given["parameters"], starts=given["starts"],
            crossings=1 if first else MOST_POINTS, direction=0 if first else 1,
            value=record.value, until=float(self.times[-1]), method=self.method, tol=self.tol,
            inputs=self.inputs or None, strict=False,
        )  # fmt: skip
        _enter_errors(run, reasons)
        if first:
            found[record.column] = np.full(len(rows), np.nan)
            found[record.column][run.start] = run.t
        else:
            held = {name: run[name] for name in run.outputs}
            points[record.column] = {"row": rows[run.start], "t": run.t, **held}

    def _exponents(
        self, records: Sequence[RecordColumn], given: Any, found: Any, reasons: dict[int, str]
    ) -> None:
        """The largest exponents and their bars, followed over the times of the sweep at most."""
        run = exponents(
            self.system, self.scene, starts=given["starts"], parameters=given["parameters"],
            count=int(max(r.value for r in records)), until=float(np.ptp(self.times)),
            inputs=self.inputs or None,
        )  # fmt: skip
        _enter_errors(run, reasons)
        for record in records:
            what, j = record.of
            found[record.column] = (run.values if what == "exponent" else run.bars)[:, j].copy()

    def _alone(
        self, records: Sequence[RecordColumn], i: int, row: Mapping[str, float], found: Any,
        reasons: dict[int, str],
    ) -> None:  # fmt: skip
        """What each motion tells by itself: the class of a trace, functions of its trajectory."""
        parameters = {*self.system.parameter_names}
        given: dict[str, Any] = {
            "scene": self.scene,
            "parameters": {**self.parameters, **{n: x for n, x in row.items() if n in parameters}},
            "initial": {**self.initial, **{n: x for n, x in row.items() if n not in parameters}},
        }
        run: Any = None
        for record in records:
            try:
                if record.is_text:
                    classes = closed_form(self.system, **given).classes
                    found[record.column][i] = str(classes[record.of])
                    continue
                run = run or integrate(
                    self.system, times=self.times, method=self.method, tol=self.tol,
                    inputs=self.inputs or None, **given,
                )  # fmt: skip
            except VoronecError as error:
                reasons.setdefault(i, str(error))
                return
            if run.interrupted:
                raise KeyboardInterrupt
            found[record.column][i] = _number_of(record, run)


def _enter_errors(run: Any, reasons: dict[int, str]) -> None:
    """Why motions failed, the first time; ``KeyboardInterrupt`` where they were stopped by hand."""
    if run.interrupted:
        raise KeyboardInterrupt
    for i, error in run.errors.items():
        reasons.setdefault(i, str(error))


def _number_of(record: RecordColumn, run: Any) -> float:
    """What a function says of a trajectory; ``DefinitionError`` where that is no number."""
    try:
        return float(record.of(run))
    except Exception as error:
        what = quote(f"{type(error).__name__}: {error}")
        raise DefinitionError(f"record '{record.column}': the function failed: {what}") from error
