"""Bifurcation diagrams of integral maps: critical values, regions, tori, motions.

In the plane of two proved integrals, others held at their values, ``bifurcation_curves`` finds the
curves of critical values and ``bifurcation_regions`` what lies between them.  Where levels are
curves, or surfaces on which a proved measure makes all motions quasi-periodic (Euler and Jacobi),
their components are told: closed orbits and tori.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from voronec.algebra.arguments import COUNT, SEVERAL, VALUES, accepts
from voronec.algebra.memo import Memo
from voronec.algebra.symbols import plain_name
from voronec.declaration.reading import several
from voronec.declaration.system import System, require_system
from voronec.dynamics.bifurcation_curves import CriticalCurve, CriticalPoints, critical_curves
from voronec.dynamics.bifurcation_regions import (
    DiagramRegion,
    LevelComponents,
    Raster,
    level_components,
    regions_of,
)
from voronec.dynamics.integral_map import IntegralMap, integral_map_of
from voronec.dynamics.steady import SteadyMotion, steady
from voronec.equations.motions import Motions
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError, VoronecError, did_you_mean
from voronec.motion.prepared_problem import integrate
from voronec.motion.request import number
from voronec.motion.trajectory import Trajectory
from voronec.proof.measures import decide_measure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MORE = 1
"""Where levels of a region differ curves are looked for so many times more."""
SPREAD = (0.0, 50.0)
"""The window shows the values of random points between these percentiles, unless it is given."""
TRIES = 10
"""At so many points of a torus coordinates are looked for."""


@dataclass(frozen=True, eq=False, repr=False)
class BifurcationDiagram:
    """The critical values of two integrals, ``axes``, where others are ``held``.

    ``curves`` are those that were found in the ``window`` (2, 2) of low and high values;
    ``steady`` are steady motions with the values that are held, ``steady_values`` (k, 2) where they
    stand.  ``regions`` are told where levels are closed orbits or tori, ``is_integrable``, else
    there are none.  All of it is computed, not proved; that the integrals are integrals is proved,
    but for those ``without_formula``, which are computed along curves.
    """

    system: System
    axes: tuple[str, str]
    held: Mapping[str, float]
    parameters: Mapping[Any, Any]
    critical: CriticalPoints = field(repr=False)
    curves: tuple[CriticalCurve, ...]
    raster: Raster | None
    steady: tuple[SteadyMotion, ...]
    steady_values: np.ndarray
    memo: Memo = field(default_factory=Memo, init=False, repr=False)

    @property
    def map(self) -> IntegralMap:
        """The integrals as functions of the reduced variables."""
        return self.critical.map

    @property
    def window(self) -> np.ndarray:
        """The lowest and the highest value (2, 2) of both integrals."""
        return self.critical.window

    @property
    def is_integrable(self) -> bool:
        """Whether components of regular levels are closed orbits or tori."""
        return self.raster is not None

    @property
    def regions(self) -> tuple[DiagramRegion, ...]:
        """The regions between the curves; none where the system is not integrable."""
        return self.raster.regions if self.raster else ()

    @property
    def without_formula(self) -> tuple[str, ...]:
        """Integrals that have no formula; see ``integral_map``."""
        return self.map.carried.names if self.map.carried else ()

    @property
    def noun(self) -> str:
        """What components of levels are."""
        return "closed orbit" if self.critical.dimension == 1 else "torus"

    def level(self, x: float, y: float) -> LevelComponents:
        """The components of the level with these values, sampled."""
        place = number(x, f"the value of '{self.axes[0]}'"), number(y, f"that of '{self.axes[1]}'")
        return self.memo.once(place, lambda: level_components(self.critical, place))

    def kind(self, x: float, y: float) -> str:
        """What the diagram says of these values: ``no motions``, ``2 tori``, ``critical`` on a
        curve or nearer to one than a cell of the raster, and ``not told`` outside of the window,
        where levels of a region differ, and where the system is not integrable."""
        if self.raster is None:
            return "not told"
        place = self.raster.at((x, y))
        inside = ((self.window[:, 0] <= (x, y)) & ((x, y) <= self.window[:, 1])).all()
        if place < 0:
            return "critical" if inside else "not told"
        return self._words(self.regions[place].components)

    def _words(self, count: int | None) -> str:
        if count is None:
            return "not told"
        plural = {"torus": "tori"}.get(self.noun, f"{self.noun}s")
        return "no motions" if count == 0 else f"{count} {self.noun if count == 1 else plural}"

    def start(self, x: float, y: float, component: int = 0) -> dict[str, float]:
        """A start, coordinates and velocities by name, on one of the components of a level.

        ``DefinitionError`` where the level has no such component.
        """
        level = self.level(x, y)
        if not 0 <= component < level.count:
            what = self._words(level.count) if self.is_integrable else f"{level.count} components"
            raise DefinitionError(
                f"the level {self.axes[0]} = {float(x):g}, {self.axes[1]} = {float(y):g} of system "
                f"'{self.system.name}' has {what}: there is no number {component}"
            )
        points = level.points[level.labels == component]
        refusal: VoronecError | None = None
        for point in points[:: max(1, len(points) // TRIES)]:
            try:
                return self.map.home(point)
            except DefinitionError as error:
                refusal = error
        assert refusal is not None
        raise refusal

    def motion(self, x: float, y: float, component: int = 0, times: Any = None) -> Trajectory:
        """The motion from a ``start`` on the level with these values; ``times`` as for
        ``integrate``, by default those of the scene."""
        moving = {n: v for n, v in zip(self.axes, (x, y), strict=True)
                  if n in self.system.parameter_names}  # fmt: skip
        scene = self.system.scenes.get("default")
        instants = np.linspace(*scene.times, 501) if times is None and scene else times
        return integrate(
            self.system, initial=self.start(x, y, component), times=instants,
            parameters={**self.parameters, **moving},
        )  # fmt: skip

    def plot(self) -> Figure:
        """The curves with their stability in colours, regions with the number of tori in them,
        steady motions as dots."""
        from voronec.dynamics.bifurcation_picture import diagram_figure

        return diagram_figure(self)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the curves to ``path``, as ``Trajectory.save`` does: a row for each point."""
        from voronec.motion.storage import NamedArrays

        values = [c.values for c in self.curves] or [np.zeros((0, 2))]
        numbers = [np.full(len(c), i) for i, c in enumerate(self.curves)] or [np.zeros(0, int)]
        columns: dict[str, Any] = {"curve": np.concatenate(numbers)}
        columns |= dict(zip(self.axes, np.concatenate(values).T, strict=True))
        points = np.concatenate([c.points for c in self.curves] or [self.map.start[None][:0]])
        columns |= dict(zip(self.map.variables, points.T, strict=True)) | columns
        columns["kind"] = np.concatenate([c.kinds for c in self.curves] or [np.zeros(0, "U1")])
        rows = {name: (("point",), array) for name, array in columns.items()}
        arrays = NamedArrays.of(self.system, "BifurcationDiagram", rows, ("point",), (*columns,))
        return arrays.save(path)

    def __repr__(self) -> str:
        axes = " against ".join(map(repr, self.axes))
        return f"BifurcationDiagram({self.system.name!r}, {axes}, {len(self.curves)} curves)"

    def lines(self) -> list[str]:
        """What is found, in words."""
        held = ", ".join(f"{name} = {value:.6g}" for name, value in self.held.items())
        told = [f"{self.system.name}: {' against '.join(self.axes)}{f'; {held}' if held else ''}"]
        if self.without_formula:
            told.append(f"  without formulas, computed: {', '.join(self.without_formula)}")
        for curve in self.curves:
            kinds = ", ".join(dict.fromkeys(curve.kinds.tolist()))
            ends = [f"({x:.5g}, {y:.5g})" for x, y in curve.values[[0, -1]]]
            told.append(
                f"critical value {ends[0]}: {kinds}" if len(curve) == 1
                else f"critical values from {ends[0]} to {ends[1]}: {kinds}"
            )  # fmt: skip
        for region in self.regions:
            x, y = region.place
            words = self._words(region.components)
            told.append(f"region about ({x:.5g}, {y:.5g}): {words}, computed")
        if not self.is_integrable:
            poles = "its coordinates have poles, declare invariants to have tori counted"
            why = poles if self.map.has_poles else "not shown to be integrable"
            told.append(f"{why}: critical values only")
        for (x, y), motion in zip(self.steady_values, self.steady, strict=True):
            told.append(f"{motion.kind} at ({x:.5g}, {y:.5g}): {motion.verdict}")
        return told

    def as_dict(self) -> dict[str, Any]:
        """What JSON can hold of it."""
        return {
            "system": self.system.name, "axes": list(self.axes), "held": dict(self.held),
            "window": self.window.tolist(), "integrable": self.is_integrable,
            "integrals without formulas": list(self.without_formula),
            "curves": [
                {"values": c.values.tolist(), "kinds": c.kinds.tolist()} for c in self.curves
            ],
            "regions": [
                {"place": list(r.place), "share": r.share, "components": r.components}
                for r in self.regions
            ],
            "steady": [
                {"value": value.tolist(), **motion.as_dict()}
                for value, motion in zip(self.steady_values, self.steady, strict=True)
            ],
        }  # fmt: skip


@accepts(axes=SEVERAL, at=VALUES, parameters=VALUES, between=VALUES, starts=COUNT, seed=COUNT)
def bifurcation_diagram(
    system: System | VoronecEquations,
    axes: Any = (),
    at: Mapping[Any, Any] | None = None,
    parameters: Mapping[Any, Any] | None = None,
    between: Mapping[Any, Sequence[Any]] | None = None,
    scene: Any = None,
    starts: int = 60,
    seed: int = 1,
) -> BifurcationDiagram:
    """The bifurcation diagram of the integral map of a system, computed.

    axes
        two of the proved integrals, by default the first two that are independent; the second may
        be a parameter.
    at
        the values of the other integrals, by default those of the ``scene``.
    between
        the window, ``{name: (low, high)}``; by default where random points of the usual sizes lie.
    parameters, scene
        other values of parameters; the scene whose start gives the usual sizes.
    starts, seed
        how many searches for critical points, and which.

    Raises ``DefinitionError`` where the map is constant or has one integral alone, where the system
    depends on the time or its right side is not smooth, and for unknown names.
    """
    model = system.system if isinstance(system, VoronecEquations) else require_system(system)
    named = [*map(plain_name, several(axes, "axes", "'energy'"))]
    moving = [a for a in named if a in model.parameter_names]
    mapping = integral_map_of(system, scene, parameters or {}, moving)
    chosen, free = _choose(mapping, named)
    held = _values_of_others(mapping, free, at or {})
    rows = [*range(mapping.relations), *mapping.places([*held, *chosen])]
    targets = np.array([0.0] * mapping.relations + [*held.values()])
    window = _window(mapping, rows, targets, dict(between or {}), chosen)
    points = CriticalPoints(mapping, tuple(rows), targets, window)
    curves = critical_curves(points, starts, seed)
    raster = regions_of(points, curves) if _is_integrable(model, points) else None
    for more in range(1, MORE + 1):
        if raster is None or all(region.is_uniform for region in raster.regions):
            break  # else a curve was missed
        curves = critical_curves(points, starts, seed + more, curves)
        raster = regions_of(points, curves)
    motions, values = _steady(model, mapping, held, chosen, parameters or {}, starts, seed)
    return BifurcationDiagram(
        model, (chosen[0], chosen[1]), held, dict(parameters or {}), points, tuple(curves), raster,
        motions, values,
    )  # fmt: skip


def _choose(found: IntegralMap, named: Sequence[str]) -> tuple[list[str], list[str]]:
    """The two axes, and further integrals that are independent of them and of one another."""
    system = found.phase.system.name
    for name in named:
        if name not in found.integrals:
            near = did_you_mean(name, found.integrals)
            raise DefinitionError(f"system '{system}': '{name}' is no proved integral{near}")
    if len(named) not in (0, 2) or len({*named}) < len(named):
        raise DefinitionError("axes: name two different integrals, such as ('energy', 'momentum')")
    order = [*named, *(n for n in found.integrals if n not in named)]
    rows, independent = [*range(found.relations)], list[str]()
    for name in order:
        wider = [*rows, *found.places([name])]
        if found.rank(wider) == len(wider):
            rows, independent = wider, [*independent, name]
    if named and named != independent[:2]:
        raise DefinitionError(
            f"system '{system}': {' and '.join(named)} depend on one another; take another axis"
        )
    if len(independent) < 2:
        one = next(iter(found.phase.system.parameter_names), "")
        other = f": axes=('{independent[0]}', '{one}')" if one and independent else ""
        raise DefinitionError(
            f"system '{system}': its proved integrals are functions of one alone, "
            f"{', '.join(independent) or 'which is constant'}; take a parameter for the other "
            f"axis{other}"
        )
    return independent[:2], independent[2:]


def _values_of_others(
    found: IntegralMap, free: Sequence[str], at: Mapping[Any, Any]
) -> dict[str, float]:
    given = {plain_name(k): x for k, x in at.items()}
    for name in given:
        if name not in free:
            near = did_you_mean(name, free)
            raise DefinitionError(f"at: '{name}' is no integral that is held{near}")
    here = dict(zip(found.constants, found.jet(found.start[None], 0)[0][0].tolist(), strict=True))
    return {n: number(given.get(n, here[n]), f"the value of '{n}'") for n in free}


def _window(
    found: IntegralMap, rows: Sequence[int], targets: np.ndarray, between: dict[Any, Any],
    axes: Sequence[str],
) -> np.ndarray:  # fmt: skip
    """The lowest and the highest values (2, 2) of what is shown."""
    x = found.project(found.random_points(400), rows[:-2], targets[found.relations :])
    x = np.vstack([x, found.start])
    values = found.jet(x, 0)[0][:, rows[-2:]]
    values = values[np.isfinite(values).all(axis=1)]
    window = np.percentile(values, SPREAD, axis=0).T
    window = np.array(
        [np.minimum(window[:, 0], values[-1]), np.maximum(window[:, 1], values[-1])]
    ).T
    window += 0.08 * np.ptp(window, axis=1)[:, None] * [-1, 1]
    for name, span in between.items():
        key = plain_name(name)
        if key not in axes or len(span) != 2 or not span[0] < span[1]:
            raise DefinitionError(
                f"between: '{key}': give a low and a high value of {axes[0]} or {axes[1]}"
            )
        window[axes.index(key)] = [number(x, f"between: '{key}'") for x in span]
    return window


def _is_integrable(system: System, points: CriticalPoints) -> bool:
    """Whether regular levels are curves, or surfaces with a proved measure of the motion, in
    variables that cover them once."""
    mapping = points.map
    if mapping.has_poles or any(n in system.parameter_names for n in mapping.constants):
        return False
    if points.dimension == 2:
        measure = system.measure
        return measure is not None and decide_measure(Motions.of(system), measure).verdict.proved
    return points.dimension == 1


def _steady(
    system: System, found: IntegralMap, held: Mapping[str, float], axes: Sequence[str],
    parameters: Mapping[Any, Any], starts: int, seed: int,
) -> tuple[tuple[SteadyMotion, ...], np.ndarray]:  # fmt: skip
    """Isolated steady motions with the values that are held, and their values of the axes."""
    if not {*held, *axes} <= {*system.integrals}:
        return (), np.zeros((0, 2))
    try:
        motions = steady(system, at=held, parameters=parameters, starts=starts, seed=seed)
    except DefinitionError:
        return (), np.zeros((0, 2))
    isolated = tuple(m for m in motions if not m.dimension and {*found.variables} >= {*m.point})
    if not isolated:
        return (), np.zeros((0, 2))
    x = np.array([[m.point.get(n, 0.0) for n in found.variables] for m in isolated])
    return isolated, found.jet(x, 0)[0][:, found.places(axes)]
