"""What an integration returns."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import mpmath
import numpy as np

from voronec.algebra.arguments import PATH, require
from voronec.algebra.symbols import plain_name
from voronec.algebra.typeset import html_table
from voronec.declaration.reading import instants
from voronec.declaration.system import System
from voronec.equations.program import Program
from voronec.errors import DefinitionError
from voronec.motion.observables import (
    ObservedQuantities,
    evaluate_extras,
    evaluate_watch,
    shown_program,
)
from voronec.motion.request import Namespace, held_name
from voronec.motion.term_sizes import CANCELLATION, SMALL, term_slopes
from voronec.motion.tolerances import LOOSE, UNIT

if TYPE_CHECKING:
    from voronec.motion.storage import NamedArrays
    from voronec.motion.viewer.page import PageView

WORTH, FAR_LARGER = 1e-3, 1e6
"""An integral has no value in doubles where its rounding is more than the first part of it, and its
terms are so many times larger than at another instant."""
FEW = 12
"""So many outputs are named where a trajectory is shown in short."""
NO_INTEGRATOR = "the motion between the instants stayed with the integrator when this was sent"


@dataclass(frozen=True)
class Cost:
    """What a trajectory cost.

    ``method`` was chosen for ``reason``.  ``tolerance`` is the one in force.  ``setup`` (deriving
    and compiling) and ``run`` are seconds.  ``evaluations`` counts those of the right-hand side; a
    Taylor method expands it once a step, and then both numbers agree.  ``switches`` counts changes
    of chart, or of the side of a switching surface;
    ``formulation`` says in which variables the equations stood; ``cpu`` are the seconds of the
    processor that the run took.
    """

    method: str
    reason: str
    tolerance: float
    setup: float
    run: float
    steps: int
    evaluations: int
    switches: int = 0
    formulation: str = "coordinates"
    cpu: float = 0.0

    @property
    def seconds(self) -> float:
        """All of it."""
        return self.setup + self.run

    def __str__(self) -> str:
        return (
            f"{self.method} ({self.reason}), in {self.formulation}, tol {self.tolerance:.1e}: "
            f"set-up {self.setup:.2f} s, "
            f"run {self.run:.3g} s, {self.steps} steps, {self.evaluations} evaluations"
            + (f", {self.switches} changes of chart or of side" if self.switches else "")
        )


@dataclass(frozen=True, eq=False)
class Crossings:
    """The passages of one event: ``t`` (k,), ``state`` (k, n), and outputs by name.

    ``crossings["u"]`` is an array of shape (k,), for coordinates, velocities and the outputs of the
    trajectory.
    """

    t: np.ndarray
    state: np.ndarray
    names: tuple[str, ...]
    series: Mapping[str, np.ndarray]

    @classmethod
    def of(
        cls, t: np.ndarray, state: np.ndarray, names: tuple[str, ...], series: dict[str, np.ndarray]
    ) -> Crossings:
        """Passages at ``t`` (k,) with ``state`` (k, n), whose columns are ``names``, and outputs by
        name, ``series``, each (k,): arrays that nobody changes any more."""
        for array in (t, state, *series.values()):
            array.flags.writeable = False
        return cls(t, state, names, MappingProxyType(series))

    def __getitem__(self, key: Any) -> np.ndarray:
        name = held_name(key, (*self.series, *self.names), "the crossings hold")
        if name in self.series:
            return self.series[name]
        return self.state[:, self.names.index(name)]

    def __len__(self) -> int:
        return len(self.t)


@dataclass(frozen=True, eq=False)
class Conservation:
    """What ought to stay along a motion: the ``integrals`` and relations of ``watch``, evaluated
    when they are first asked for.

    ``evaluate`` gives them by the names under which the program computes them; ``sizes`` tells how
    large the terms of integrals would usually be, if that is known.
    """

    watch: ObservedQuantities
    tolerance: float
    evaluate: Callable[[], Mapping[str, np.ndarray]]
    sizes: _TermSizes | None = None

    @cached_property
    def _series(self) -> Mapping[str, np.ndarray]:
        return self.evaluate()

    @cached_property
    def integrals(self) -> Mapping[str, np.ndarray]:
        """See ``Trajectory``."""
        return MappingProxyType(_integrals(self.watch, self._series))

    @cached_property
    def drift(self) -> Mapping[str, float]:
        """See ``Trajectory``."""
        return MappingProxyType(_drifts(self.watch, self._series, self.tolerance, self.sizes))

    @cached_property
    def residuals(self) -> Mapping[str, float]:
        """See ``Trajectory``."""
        pairs = self.watch.relations.items()
        return MappingProxyType({r: float(np.abs(self._series[key]).max()) for r, key in pairs})

    def __getstate__(self) -> dict[str, Any]:
        """The values alone: what evaluates them lives with the run."""
        return {name: getattr(self, name) for name in ("integrals", "drift", "residuals")}


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory:
    """A motion on a grid of times; its arrays are read-only.

    ``t`` has shape (k,), ``state`` (k, number of coordinates and velocities) with columns
    ``names``.  ``outputs`` are the names asked for: ``traj["u"]`` is an array of shape (k,), by
    name, symbol or expression; integrals, coordinates and velocities are there as far as the model
    knows them.

    ``integrals`` has each integral of the system at every instant, nan where it has no value in
    doubles: in velocities that are no frame there.

    ``drift`` maps each integral I to max |I(t) - I(t0)| / |I(t0)|, over the instants
    at which I has a value, t0 the first of them.  Let S be the
    largest value along the motion of I with all its terms taken positive.  Where I starts at zero
    (below a millionth of S), the change is relative to S instead; and where S is less than
    the tolerance, a thousand times over, leaves of terms that vanish there, as of cos(theta) at
    pi/2, relative to what these would change by if their slopes went on.  ``residuals`` maps each
    relation between redundant coordinates to its largest value.

    ``events`` maps each event to its ``Crossings``; ``stopped`` names the one that ended the run,
    and then the last instant is that crossing.  ``interrupted`` says that the run was stopped by
    hand, ``halted`` why it could not go on (of the part that an ``IntegrationError`` keeps); the
    grid then ends where it came to.  ``notes`` say what was done to the initial data on request.
    Of the method ``flint`` all numbers are mpmath's, in arrays of objects.
    """

    system: System
    t: np.ndarray
    state: np.ndarray
    names: tuple[str, ...]
    outputs: tuple[str, ...]
    series: Mapping[str, np.ndarray]
    parameters: Mapping[str, float]
    conserved: Conservation
    cost: Cost
    interrupted: bool = False
    events: Mapping[str, Crossings] = field(default_factory=dict)
    stopped: str = ""
    halted: str = ""
    notes: tuple[str, ...] = ()
    within: Callable[[np.ndarray], Trajectory] | None = None

    @property
    def integrals(self) -> Mapping[str, np.ndarray]:
        """Each integral of the system at every instant, (k,)."""
        return self.conserved.integrals

    @property
    def drift(self) -> Mapping[str, float]:
        """By how much each integral changes, relative to its size."""
        return self.conserved.drift

    @property
    def residuals(self) -> Mapping[str, float]:
        """The largest value of each relation between redundant coordinates."""
        return self.conserved.residuals

    def at(self, times: Any) -> Trajectory:
        """The motion at any times (m,) between the first and the last, in any order; a run with
        ``dense=True`` knows them as accurately as its grid.

        Raises ``DefinitionError`` for times beyond, and where a run was not made so.
        """
        if self.within is None:
            raise DefinitionError("the trajectory knows its own instants only; integrate with "
                                  "dense=True")  # fmt: skip
        ends = sorted((self.t[0], self.t[-1]))
        wanted = np.atleast_1d(instants(times, "times", wide=self.t.dtype == object))
        sound = wanted.ndim == 1 and all(ends[0] <= time <= ends[1] for time in wanted)
        if not sound or not len(wanted):
            reach = f"from t = {float(ends[0]):.12g} to {float(ends[1]):.12g}"
            raise DefinitionError(
                f"the trajectory reaches {reach}; give times within"
                if len(wanted)
                else f"no times are given; give one at least, {reach}"
            )
        return self.within(wanted)

    def __getitem__(self, key: Any) -> np.ndarray:
        if isinstance(key, str) and key in self.series:
            return self.series[key]
        held = (*self.series, *self.names, *self.integrals)
        name = held_name(key, held, "the trajectory holds")
        if name in self.series:
            return self.series[name]
        if name in self.names:
            return self.state[:, self.names.index(name)]
        return self.integrals[name]

    def __len__(self) -> int:
        return len(self.t)

    def __repr__(self) -> str:
        span = f"t={float(self.t[0]):.6g}..{float(self.t[-1]):.6g}, {len(self.t)} instants"
        names = ", ".join(self.outputs[:FEW]) + (", ..." if len(self.outputs) > FEW else "")
        by_hand = "stopped by hand" if self.interrupted else ""
        ends = (self.stopped and f"stopped by {self.stopped}", self.halted, by_hand)
        more = "".join(f", {word}" for word in ends if word)
        return f"Trajectory({self.system.name!r}, {span}, outputs=({names}){more})"

    def _repr_html_(self) -> str:
        """For notebooks: where outputs begin and end, and how well integrals are kept."""
        rows = [
            (name, f"from {float(self[name][0]):.10g} to {float(self[name][-1]):.10g}")
            for name in self.outputs[:FEW]
        ]
        rows += [(f"drift of {name}", f"{float(x):.1e}") for name, x in self.drift.items()]
        rows += [("cost", str(self.cost)), *(("note", note) for note in self.notes)]
        return html_table(repr(self), rows)

    def __copy__(self) -> Trajectory:
        return self  # nothing of it can change

    def __deepcopy__(self, _: Any) -> Trajectory:
        return self

    def __getstate__(self) -> dict[str, Any]:
        """All but what lies between the instants, which lives in the integrator."""
        held = {f.name: getattr(self, f.name) for f in fields(self)}
        if self.within is None:
            return held
        return {**held, "within": None, "notes": (*self.notes, NO_INTEGRATOR)}

    def plot(self, names: Sequence[str] | None = None) -> Any:
        """Quantities against the time, by default the outputs, as a matplotlib ``Figure``: a
        notebook shows it, ``figure.savefig("motion.pdf")`` writes it.

        Raises ``DefinitionError`` for a name that the trajectory does not hold.
        """
        from voronec.motion.pictures.run_pictures import plot_trajectory

        return plot_trajectory(self, names, self.system.title or self.system.name)

    def animate(self, path: str | os.PathLike[str]) -> Path:
        """Write a film of the motion, ``FILE.gif``, ``FILE.webp``, or ``FILE.mp4`` where ffmpeg is
        installed.

        ``DefinitionError`` where the system has no ``shapes``, and where the trajectory does not
        hold the coordinates on which their places depend.
        """
        from voronec.motion.pictures.scene_film import ShapesInMotion, check_film, film

        require("animate", "path", path, PATH)
        target = Path(path)
        check_film(self.system, target)
        film(ShapesInMotion(self), target)
        return target

    def view(self, path: str | os.PathLike[str] | None = None) -> PageView:
        """One HTML page of the motion in space, which needs no network and integrates by itself.

        A notebook shows it; with ``path``, ``FILE.html``, it is written there.
        ``DefinitionError`` where the system has no ``shapes``, where the trajectory does not hold
        all coordinates and velocities, and where it is too long for a page.
        """
        from voronec.motion.viewer.page import view_of

        if path is not None:
            require("view", "path", path, PATH)
        return view_of(self, path)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the motion to ``path``: ``.npz``, ``.parquet`` or ``.zarr`` with all that is known,
        for ``voronec.open``, or ``.csv`` with the times and outputs.

        Numbers have full precision.  The file appears whole or not at all.  Raises
        ``DefinitionError`` for another ending, and where there is no such folder.
        """
        return self._arrays().save(path)

    def to_xarray(self) -> Any:
        """The motion as an ``xarray.Dataset`` along ``t``, its header as attributes."""
        return self._arrays().to_xarray()

    def to_pandas(self) -> Any:
        """The motion as a ``pandas.DataFrame``, a row for each instant."""
        return self._arrays().to_pandas()

    def _arrays(self) -> NamedArrays:
        """The motion along ``t``, the passages of each event along an axis of its own."""
        from voronec.motion.storage import NamedArrays, plain_numbers

        names = dict.fromkeys([*self.outputs, *self.names, *self.integrals])
        held = {"t": self.t, **{name: self[name] for name in names if name != "t"}}
        variables = {name: (("t",), plain_numbers(x)) for name, x in held.items()}
        for event, crossings in self.events.items():
            passages = {
                "t": crossings.t,
                **{n: crossings[n] for n in (*crossings.names, *crossings.series)},
            }
            axes = (f"{event}: number",)
            variables |= {f"{event}: {n}": (axes, plain_numbers(x)) for n, x in passages.items()}
        numbers = {name: {n: plain_numbers(x) for n, x in getattr(self, name).items()}
                   for name in ("parameters", "drift", "residuals")}  # fmt: skip
        also = {"state": plain_numbers(self.state), "names": np.array(self.names)}
        also |= {f"parameter {n}": np.array(x) for n, x in numbers["parameters"].items()}
        return NamedArrays.of(
            self.system, "Trajectory", variables, ("t",), ("t", *self.outputs), also,
            notes=list(self.notes), stopped=self.stopped, halted=self.halted,
            interrupted=self.interrupted, cost=asdict(self.cost), **numbers,
        )  # fmt: skip


def _late(name: str) -> Any:
    """A field of a ``LateTrajectory`` that is read off ``everything``."""
    return cached_property(lambda self: getattr(self._full, name))


class LateTrajectory(Trajectory):
    """A trajectory that knows its outputs, and evaluates the rest when that is first read.

    ``everything`` gives the same motion as a ``Trajectory``: from there come ``state``,
    ``conserved`` and ``notes``.
    """

    everything: Callable[[], Trajectory]

    @classmethod
    def of(cls, everything: Callable[[], Trajectory], **known: Any) -> LateTrajectory:
        """A trajectory of the fields that are known, beside those that come late."""
        made = cls.__new__(cls)
        for name, value in {"everything": everything, **known}.items():
            object.__setattr__(made, name, value)
        return made

    @cached_property
    def _full(self) -> Trajectory:
        return self.everything()

    state = _late("state")
    conserved = _late("conserved")
    notes = _late("notes")


def make_trajectory(
    namespace: Namespace,
    watch: ObservedQuantities,
    program: Program,
    t: np.ndarray,
    states: np.ndarray,
    constants: Mapping[str, float],
    cost: Cost,
    **ends: Any,
) -> Trajectory:
    """The trajectory of states on a grid; ``ends`` are further fields of it."""
    values = [constants.get(str(p), np.nan) for p in program.parameters]
    bits = mpmath.mp.prec

    def everything() -> Mapping[str, np.ndarray]:
        with mpmath.workprec(bits):
            return evaluate_extras(program, t, states, values)

    return assemble_trajectory(
        namespace, watch, t, tuple(map(str, program.state)), states,
        evaluate_watch(watch, shown_program(program, watch.for_conservation), t, states, values),
        constants, cost,
        Conservation(
            watch, cost.tolerance, everything, _TermSizes(watch, program, t, states, values)
        ),
        **ends,
    )  # fmt: skip


def assemble_trajectory(
    namespace: Namespace,
    watch: ObservedQuantities,
    t: np.ndarray,
    names: tuple[str, ...],
    states: np.ndarray,
    series: Mapping[str, np.ndarray],
    constants: Mapping[str, float],
    cost: Cost,
    conserved: Conservation | None = None,
    **ends: Any,
) -> Trajectory:
    """The trajectory of states (k, n) called ``names`` and of what is watched along them.

    What is ``conserved`` stands in the ``series`` too, unless it is given; ``ends`` are further
    fields of the trajectory.
    """
    system = namespace.equations.system
    variables = [plain_name(x) for x in (*system.coordinates, *system.velocities)]
    if variables != list(names) and set(variables) <= set(watch.outputs):
        # what was integrated is another set of variables; these are what the user knows
        names, states = tuple(variables), np.stack([series[name] for name in variables], axis=-1)
    for array in (t, states, *series.values()):
        array.flags.writeable = False
    still = {n: x for n, x in constants.items() if np.ndim(x) == 0}  # others are inputs
    # what is no number is not equal to itself
    known = {n for n in system.parameter_names if n in still and still[n] == still[n]}
    kept = conserved or Conservation(watch, cost.tolerance, lambda: series)
    return Trajectory(
        system=system,
        t=t,
        state=states,
        names=names,
        outputs=watch.outputs,
        series=MappingProxyType(
            {n: kept.integrals[n] if n in watch.integrals else series[n] for n in watch.known}
        ),
        parameters=MappingProxyType({n: x for n, x in constants.items() if n in known}),
        conserved=kept,
        cost=cost,
        **ends,
    )


def _integrals(
    watch: ObservedQuantities, series: Mapping[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """The integrals along the grid; nan at instants at which they are rounding, as in velocities
    that are no frame there."""
    integrals = {}
    for name, key in watch.integrals.items():
        values = series[key]
        lost = _is_rounding(values, series[watch.sizes[name]])
        integrals[name] = np.where(lost, np.nan, values) if lost.any() else values
        integrals[name].flags.writeable = False
    return integrals


def _is_rounding(values: np.ndarray, terms: np.ndarray) -> np.ndarray:
    """At which instants the terms of an integral are so much larger than at others that what is
    left of them in doubles says nothing of its value."""
    if values.dtype == object:
        return np.zeros(values.shape, dtype=bool)
    with np.errstate(all="ignore"):
        least = np.min(terms, where=terms > 0, initial=np.inf)
        lost = UNIT * terms > WORTH * np.max(np.abs(values), where=np.isfinite(values), initial=0.0)
        return np.asarray(lost & (terms > FAR_LARGER * least))


@np.errstate(all="ignore")  # what is beyond doubles ends the run, in words of its own
def _drifts(
    watch: ObservedQuantities,
    series: Mapping[str, np.ndarray],
    tol: float,
    usual: _TermSizes | None,
) -> dict[str, float]:
    """See ``Trajectory.drift``."""
    pairs = {}
    for name, key in watch.integrals.items():
        values, terms = series[key], series[watch.sizes[name]]
        # at a pole of coordinates, where a run may begin, an integral may have no value
        sound = np.isfinite(values.astype(float)) & np.isfinite(terms.astype(float))
        sound &= ~_is_rounding(values, terms)
        pairs[name] = (values[sound], terms[sound]) if sound.any() else (values, terms)
    drifts, left = {}, LOOSE * max(tol, UNIT)
    for name, (values, terms) in pairs.items():
        size, start = terms.max(), abs(values[0])
        scale = start if start > CANCELLATION * size else size
        change = np.abs(values - values[0]).max()
        if usual and change > SMALL * scale and size <= left * usual.slopes[name]:
            scale = usual.slopes[name]
        drifts[name] = float(change / scale) if change else 0.0
    return drifts


@dataclass(frozen=True)
class _TermSizes:
    """How large the terms of integrals would usually be along a motion, by name."""

    watch: ObservedQuantities
    program: Program
    t: np.ndarray
    states: np.ndarray
    values: Sequence[Any]

    @cached_property
    def slopes(self) -> dict[str, float]:
        """See ``term_slopes``."""
        given = [np.broadcast_to(np.asarray(x, dtype=float), self.t.shape) for x in self.values]
        values = np.stack(given, axis=-1) if given else np.empty((len(self.t), 0))
        sizes = self.watch.sizes
        largest = term_slopes(self.program, sizes.values(), self.t, self.states[None], values[None])
        return {name: float(largest[key][0]) for name, key in sizes.items()}
