"""The charts of a system as far as a program keeps what they map, inside the door."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import symengine as se

from voronec.algebra.angles import Angles, holds_angles
from voronec.algebra.symbols import velocity
from voronec.charts import system_in
from voronec.equations import VoronecEquations, derive
from voronec.scene import Scene

if TYPE_CHECKING:
    from voronec.derivation import FirstOrderForm

_KEPT = "_equations_in_charts"
"""Where equations keep those in their system's charts."""

__all__ = ["KeptChart", "kept_charts", "own_singular"]


@dataclass(frozen=True)
class KeptChart:
    """One chart on the variables that are kept.

    ``there`` and ``back`` map every variable, of the chart and of the system; ``twins`` give
    other values for the same state of the system, where there are some; ``singular`` is a function
    in the chart.  ``factors`` vanish where the system's own coordinates are singular.
    """

    name: str
    equations: VoronecEquations
    kept: FirstOrderForm
    there: Mapping[Any, Any]
    back: Mapping[Any, Any]
    twins: tuple[Mapping[Any, Any], ...]
    singular: Any
    factors: tuple[Any, ...]

    @cached_property
    def form(self) -> FirstOrderForm:
        """The equations in the chart, of what is kept."""
        equations = _equations_in(self.equations, self.name)
        # pivots of straight-line forms may vanish at a pole; normal forms hold what is needed
        exact = self.equations.system.charts[self.name].near and equations.in_normal_form
        form = equations.exact.form if exact else equations.form
        rows = {q: i for i, q in enumerate(form.coordinates)}
        order = [rows[q] for q in self.kept.coordinates]
        dropped = [i for i in range(len(rows)) if i not in order]
        # what a function of the motion says of velocities holds for those that are dropped, too
        others = [(form.velocity_symbols[i], form.rates[i]) for i in dropped]
        return replace(
            form,
            coordinates=self.kept.coordinates,
            rates=tuple(form.rates[i] for i in order),
            velocity_symbols=tuple(form.velocity_symbols[i] for i in order),
            dependent=(*form.dependent, *others),
        )

    @cached_property
    def angles(self) -> set[Any]:
        """Variables that are angles, known up to whole turns."""
        return {x for x, e in self.back.items() if holds_angles([Angles().resolved(e)])}

    @cached_property
    def sides(self) -> tuple[Any, ...]:
        """Functions in the chart that change sign wherever an angle of the system comes from one
        quadrant into another: y and x of each atan2(y, x) in ``back``."""
        found: dict[Any, None] = {}
        for e in self.back.values():
            for angle in sorted(Angles().resolved(e).atoms(se.atan2), key=str):
                # a root is never negative: its angle stays where it is
                found |= {part: None for part in angle.args if not _is_root(part)}
        return tuple(found)

    def moved(self, function: Any) -> Any:
        """A function of the system's state as one of the state in the chart."""
        door, system = self.equations.door, self.equations.system
        dots = {door.inward(q): door.inward(velocity(q)) for q in system.coordinates}
        rates = {
            own: se.Add(*[self.back[q].diff(x) * dot for x, dot in dots.items()])
            for q, own in dots.items()
            if q in self.back
        }
        return Angles().resolved(se.sympify(function).xreplace({**rates, **self.back}))


def kept_charts(equations: VoronecEquations, form: FirstOrderForm) -> tuple[KeptChart, ...]:
    """The charts that map the variables of a form among themselves, each map once.

    There is none where the form has other velocities than the system's, or other variables.
    """
    system, door = equations.system, equations.door
    names = {door.inward(x): x for x in (*system.coordinates, *system.velocities)}
    state = (*form.coordinates, *form.velocities)
    if not {*state} <= {*names} or len(form.velocities) != len(system.velocities):
        return ()
    dots = {door.inward(velocity(q)) for q in system.coordinates}
    # a coordinate that a model holds fast is a parameter of its form, but not of the chart's
    closed = {*state, *dots, *(door.inward(p.symbol) for p in system.parameters)}
    found: dict[Any, KeptChart] = {}
    for name, chart in system.charts.items():
        maps = [chart.values(system), chart.values(system, "back"), *chart.twin_values(system)]
        there, back, *twins = ({x: door.inward(e[names[x]]) for x in state} for e in maps)
        images = [*there.values(), *back.values(), *(e for twin in twins for e in twin.values())]
        own, others = (
            tuple(f for f in _factors(door.inward(e)) if f.free_symbols <= closed)
            for e in (chart.singular, chart.singular_there)
        )
        moves = any(x != e for x, e in there.items())
        if own and moves and all(e.free_symbols <= closed for e in images):
            kept = KeptChart(name, equations, form, there, back, (*twins,), se.Mul(*others), own)
            found.setdefault(tuple(there.values()), kept)
    return tuple(found.values())


def _equations_in(equations: VoronecEquations, name: str) -> VoronecEquations:
    """The equations in a chart, derived once."""
    known: dict[str, VoronecEquations] = equations.__dict__.setdefault(_KEPT, {})
    if name not in known:
        near = equations.system.charts[name].near
        scenes = {"default": Scene(initial=near)} if near else {}
        known[name] = derive(replace(system_in(equations.system, name), scenes=scenes))
    return known[name]


def own_singular(charts: tuple[KeptChart, ...]) -> Any:
    """What vanishes where the own chart is singular: all factors that charts name, each once."""
    return se.Mul(*dict.fromkeys(f for chart in charts for f in chart.factors))


def _is_root(expr: Any) -> bool:
    return isinstance(expr, se.Pow) and expr.args[1].is_Rational and expr.args[1].q == 2


def _factors(product: Any) -> tuple[Any, ...]:
    return tuple(product.args) if isinstance(product, se.Mul) else (product,)
