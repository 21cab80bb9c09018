"""Where switching surfaces meet a motion: which way it goes on.

From the fields on all sides of the switching surfaces it is seen where they lead: away on one side
(the motion goes on there), back from every side (it goes on along the switching surfaces
[Filippov1988]), or away on several (nothing tells which).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from itertools import combinations, product
from typing import Any

import mpmath
import numpy as np
import symengine as se

from voronec.equations.program import Block, Program
from voronec.equations.program.python import compiled_digits
from voronec.equations.program.switches import Switch
from voronec.errors import DefinitionError
from voronec.motion.mode_set import GUARD, Mode, ModeSet
from voronec.motion.modes import LevelSurface, SmoothBranch
from voronec.motion.steppers import natural_units

NEAR = 6
"""A switching surface's function counts as zero where it is smaller than its terms by all bits but
these."""
MOST = 4
"""So many switching surfaces may meet at an instant."""
FREE = "the motion is not determined: it may leave {} on either side"
PAST = "the past is not determined: the motion may have come along {}, or from either side"
TOUCH = "the motion is not determined: it touches {}, and may turn there or go on beyond"
NO_WAY_ON = "all fields lead back to {}, and switches would follow one another ever faster"
GRAZE = 1e-9
"""A switching surface is touched where its function is smaller than this part of its terms, and
turns."""
CLEAR = 1e-4
"""Off a surface is where a switching surface's function misses its level by more than this part of
its reach."""
UNSURE = 0.7
"""A run to the tolerance tol may miss a switching surface by tol to this power."""
CANCELLATION = 1e-12
"""Fields on the sides cancel where so much is left of them, in units of the largest: rounding."""
NEGLIGIBLE = 1e-3
"""A push of less than this part of what it is a moment later, some 1e-8, vanishes just there."""
STEEP = 16.0
"""Fields whose slopes grow by this from one place to another that is 2^20 times nearer to where
they vanish have none there."""
SHORTER = (1.0, 2.0**-6, 2.0**-12)
"""Parts of a moment, for where the next switching surface is nearer than that."""
NOWHERE: Mapping[LevelSurface, int] = {}
"""The sides of a state that lies on no switching surface."""
NO_VALUE = (ZeroDivisionError, ValueError, TypeError)
"""What mpmath raises where a function has no value, or none that is real."""
SENSELESS = "the equations, or what switches in them, are not defined"
TOGETHER = f"more than {MOST} switching surfaces meet"


class Crossroads(ModeSet):
    """Which of the modes of a problem a motion goes on in."""

    @cached_property
    def units(self) -> np.ndarray:
        """The natural sizes of the states (n,), asked for at every switch."""
        return natural_units(self.problem)

    # -- which way ------------------------------------------------------------------------

    def next_mode(
        self, time: Any, state: np.ndarray, sides: Mapping[Switch, int], hit: Sequence[LevelSurface]
    ) -> Mode | str:
        """The mode in which the motion goes on, or the reason why it does not.

        ``sides`` are those of the mode that ended, ``hit`` the surfaces at which it did.
        """
        try:
            return self._way_on(time, state, sides, hit)
        except NO_VALUE:
            return SENSELESS

    def _way_on(
        self, time: Any, state: np.ndarray, sides: Mapping[Switch, int], hit: Sequence[LevelSurface]
    ) -> Mode | str:
        met, corners = self._corners(time, state, sides, hit)
        if len(met) > MOST:
            return TOGETHER
        ways = {
            above: tuple(self._sides_ahead(corner.program, time, state, values, met))
            for above, (corner, values) in corners.items()
        }
        open_ways = {
            above: corners[above]
            for above, way in ways.items()
            if all(s in (0, side) for s, side in zip(way, above, strict=True))
        }
        leaving = [*open_ways.values()]
        different = {(corner, frozenset(values.items())) for corner, values in leaving}
        names = " and ".join(map(str, met))
        still = self._vanish(time, state, corners)
        if met and still and self._leads_away(time, state, corners):
            return FREE.format(names)
        one_way = not still and len({ways[above] for above in open_ways}) == 1
        if len(different) == 1 or (one_way and self._agree(time, state, open_ways)):
            return self.mode((leaving[0][0],), leaving[0][1], ())
        if leaving:
            rest = self._rest_mode(time, state, met, corners) if still else None
            return rest or (FREE if self.order > 0 else PAST).format(names)
        for count in range(1, len(met) + 1):
            for along in combinations(met, count):
                mode = self._along(time, state, met, along, corners)
                if mode is not None:
                    return mode
        rest = self._rest_mode(time, state, met, corners)
        return NO_WAY_ON.format(names) if rest is None else rest

    def _corners(
        self, time: Any, state: np.ndarray, sides: Mapping[Switch, int], hit: Sequence[LevelSurface]
    ) -> tuple[list[LevelSurface], dict[tuple[int, ...], tuple[SmoothBranch, dict[Switch, int]]]]:
        """The surfaces that meet at a state, and the equations on each side of all of them.  Those
        of the time alone are passed."""
        met, ahead, more = [], dict[Switch, int](), list(hit)
        while True:
            ahead |= {s.switch: self._side_after(s, time, state) for s in more if self._is_timed(s)}
            met += [s for s in more if s.switch not in ahead]
            corners, more = {}, []
            switches = {s.switch for s in met}
            # beyond a floor other floors and signs of it are others
            new = switches | ahead.keys()
            kept = {w: n for w, n in sides.items() if new.isdisjoint(self.modes.inner_switches(w))}
            for above in product((1, -1), repeat=len(met)):
                beside = dict(zip(met, above, strict=True))
                corner, values = self._corner(time, state, {**kept, **ahead}, beside)
                corners[above] = corner, values
                for switch in corner.switches:
                    if switch not in ahead and (switch not in switches or switch.floors):
                        touched = self._touched_surfaces(switch, time, state, values)
                        more += [s for s in touched if s not in (*met, *more)]
            if not more or len(met) > MOST:
                return met, corners

    def _is_timed(self, surface: LevelSurface) -> bool:
        """Whether a surface is an instant, whatever the state is."""
        held = surface.switch.function.free_symbols - {*self.modes.form.parameters}
        return held == {self.modes.form.time} and self.problem.changing is None

    def _side_after(self, surface: LevelSurface, time: Any, state: np.ndarray) -> int:
        """What stands for the switching surface of an instant a moment later along the run."""
        unit = max(1, abs(time))
        slope = self._measure(surface.switch, time, state, {})[1] * self.order
        if abs(slope) * unit < mpmath.mpf(2) ** (-(self.bits // 4)):  # it may turn there
            later = time + self.order * unit * mpmath.mpf(2) ** (-(self.bits // 2))
            slope = self._measure(surface.switch, later, state, {})[0] - surface.level
        return surface.value(1 if slope >= 0 else -1)

    def _corner(
        self, time: Any, state: np.ndarray, given: Mapping[Switch, int],
        beside: Mapping[LevelSurface, int] = NOWHERE,
    ) -> tuple[SmoothBranch, dict[Switch, int]]:  # fmt: skip
        """The equations, and the sides of all switching surfaces: those ``given``, and above (1) or
        below (-1) the surfaces ``beside`` which the state lies."""
        values: dict[Switch, int] = {}

        def number(switch: Switch) -> Any:
            for inner in self.modes.inner_switches(switch):
                number(inner)
            if switch not in values:
                near = [
                    s.value(side) for s, side in beside.items()
                    if s.switch == switch and self._is_near(s, time, state, values)
                ]  # fmt: skip
                known = [*near, *([given[switch]] if switch in given else [])]
                values[switch] = known[0] if known else self._value(switch, time, state, values)
            return values[switch]

        corner = self.modes.corner(number)
        for switch in corner.switches:
            number(switch)
        return corner, {switch: values[switch] for switch in corner.switches}

    def _value(
        self, switch: Switch, time: Any, state: np.ndarray, values: Mapping[Switch, int]
    ) -> int:
        g = self._measure(switch, time, state, values)[0]
        if switch.whole:
            return int(mpmath.floor(g))
        return int(mpmath.sign(g)) if switch.fixed else 1 if g >= 0 else -1

    def _is_near(
        self, surface: LevelSurface, time: Any, state: np.ndarray, values: Mapping[Switch, int]
    ) -> bool:
        """Whether a state that lay on a surface does so with other values of the floors in it."""
        if not surface.switch.floors:
            return True
        g, size = self._value_and_size(surface.switch, time, state, values)
        return bool(abs(g - surface.level) <= CLEAR * size)

    def _touched_surfaces(
        self, switch: Switch, time: Any, state: np.ndarray, values: Mapping[Switch, int]
    ) -> list[LevelSurface]:
        """The surface of a switching surface on which a state lies, to rounding."""
        if switch.fixed:
            return []
        g, size = self._value_and_size(switch, time, state, values, abs(state))
        level = int(mpmath.nint(g)) if switch.whole else 0
        if abs(g - level) > size * mpmath.mpf(2) ** (NEAR - self.bits):
            return []
        return [LevelSurface(switch, level)]

    def _value_and_size(
        self, switch: Switch, time: Any, state: np.ndarray, values: Mapping[Switch, int],
        sizes: np.ndarray | None = None,
    ) -> tuple[Any, Any]:  # fmt: skip
        """The value of a switching surface's function, and the size of its terms for ``sizes`` of
        the states, by default at least natural ones: a state that is zero at the switching surface
        has errors of its usual size."""
        g, slope, *slopes = self._measure(switch, time, state, values)
        sizes = np.maximum(abs(state), self.units) if sizes is None else sizes
        return g, abs(slope * time) + sum(abs(a) * x for a, x in zip(slopes, sizes, strict=True))

    def _measure(
        self, switch: Switch, time: Any, state: np.ndarray, values: Mapping[Switch, int]
    ) -> list[Any]:
        return self.modes.gauge(switch)(time, state, self.name_parameters(values, time))

    def _rates(
        self, program: Program, sides: Mapping[Switch, int], time: Any, state: np.ndarray
    ) -> list[Any]:
        """The rates of the states by a mode's program."""
        right = compiled_digits(program)[0]
        return list(right(time, list(state), self.values(program, sides, time)))

    def _sides_ahead(
        self, program: Program, time: Any, state: np.ndarray, sides: Mapping[Switch, int],
        surfaces: Sequence[LevelSurface], along: Sequence[LevelSurface] = (),
    ) -> list[int]:  # fmt: skip
        """On which side of each surface a short motion along the run leads, 0 for none.

        It is so short that rounding of the state is seen no more than the second derivative, and is
        followed with twice as many digits.
        """
        try:
            later, there = self._short_way(program, time, state, sides, (*surfaces, *along))
        except NO_VALUE:
            return [0] * len(surfaces)
        signs = []
        for surface in surfaces:
            if surface.switch not in sides or not self._is_near(surface, time, state, sides):
                signs.append(0)
                continue
            a = self._measure(surface.switch, time, state, sides)[0]
            b = self._measure(surface.switch, later, there, sides)[0]
            tiny = mpmath.mpf(2) ** (-2 * self.bits - GUARD // 2) * max(abs(a), abs(surface.level))
            signs.append(0 if abs(b - a) <= tiny else 1 if b > a else -1)
        return signs

    def _short_way(
        self, program: Program, time: Any, state: np.ndarray, sides: Mapping[Switch, int],
        met: Sequence[LevelSurface],
    ) -> tuple[Any, np.ndarray]:  # fmt: skip
        """Time and state a moment along the run, or such a part of it later that no other switching
        surface than those that are met is crossed: beyond one the equations are others."""
        switches = {s.switch for s in met}
        others = [w for w in sides if not w.fixed and w not in switches]
        ways = (self._follow(program, time, state, sides, self.order * part) for part in SHORTER)
        clear = (
            way for way in ways if all(self._value(w, *way, sides) == sides[w] for w in others)
        )
        return next(clear, None) or self._follow(program, time, state, sides, self.order)

    def _follow(
        self,
        program: Program,
        time: Any,
        state: np.ndarray,
        sides: Mapping[Switch, int],
        way: float,
    ) -> tuple[Any, np.ndarray]:
        """Time and state a moment later (``way`` 1) or before, or a part of a moment."""

        def rates(t: Any, x: np.ndarray) -> np.ndarray:
            field = self._rates(program, sides, t, x)
            return np.array([mpmath.mpf(r) for r in field], dtype=object)

        pairs = zip(rates(time, state), state, strict=True)
        pace = max((abs(f) / max(1, abs(x)) for f, x in pairs), default=0)
        h = way * mpmath.mpf(2) ** (-(self.bits // 2)) / max(pace, 1)
        return time + h, runge_kutta(rates, mpmath.mpf(time), state, h)

    def moment(self, mode: Mode, time: Any, state: np.ndarray, way: int) -> tuple[Any, np.ndarray]:
        """Time and state a moment after (1) or before (-1) along the run, in a mode."""
        if way == 0:
            return mpmath.mpf(time), state
        return self._follow(mode.program, time, state, mode.sides, way * self.order)

    def on_surfaces(
        self,
        time: Any,
        state: np.ndarray,
        surfaces: Sequence[LevelSurface],
        sides: Mapping[Switch, int],
    ) -> np.ndarray:
        """The state moved onto surfaces that it has reached, to rounding: the nearest there.  Where
        that is farther than the tolerance, as it is where a switching surface's function is hardly
        more than rounding, the state stays."""
        measured = [self._measure(s.switch, time, state, sides) for s in surfaces]
        pairs = [(g - s.level, row) for s, (g, _, *row) in zip(surfaces, measured, strict=True)]
        pairs = [(g, row) for g, row in pairs if any(row)]
        if not pairs:
            return state
        rows = mpmath.matrix([row for _, row in pairs])
        try:
            shift = rows.T * mpmath.lu_solve(rows * rows.T, mpmath.matrix([g for g, _ in pairs]))
        except ZeroDivisionError:
            return state
        moved = state - np.array(list(shift), dtype=object)
        usual = np.maximum(1, self.units)
        if any(abs(moved - state) > self.problem.tol * np.maximum(usual, abs(state))):
            return state
        tiny = mpmath.mpf(2) ** (-self.bits - GUARD // 2)
        return np.where(abs(moved) <= tiny * abs(state), mpmath.mpf(0), moved)

    def _along(
        self, time: Any, state: np.ndarray, met: Sequence[LevelSurface],
        along: tuple[LevelSurface, ...],
        corners: Mapping[tuple[int, ...], tuple[SmoothBranch, dict[Switch, int]]],
    ) -> Mode | None:  # fmt: skip
        """The motion along some of the surfaces that meet, if there is one."""
        self._require_rates(along)
        free = [s for s in met if s not in along]
        for rest in product((1, -1), repeat=len(free)):
            other = dict(zip(free, rest, strict=True))

            def at(below: LevelSurface | None, other: Mapping[LevelSurface, int] = other) -> Any:
                sides = (other.get(s, -1 if s == below else 1) for s in met)
                return corners[tuple(sides)]

            chosen = [at(None), *(at(s) for s in along)]
            there = chosen[0][1]
            if any(
                s.switch not in there or not self._is_near(s, time, state, there) for s in along
            ):
                continue
            mode = self.mode(tuple(c for c, _ in chosen), chosen[0][1], along)
            weights = None if mode is None else self._weights(mode, time, state)
            if (
                mode is None
                or weights is None
                or not self._affine(time, state, mode, weights, other, corners, met)
            ):
                continue
            moved = self._sides_ahead(mode.program, time, state, mode.sides, free, along)
            if all(s in (0, side) for s, side in zip(moved, rest, strict=True)):
                return mode
        return None

    def _rest_mode(
        self, time: Any, state: np.ndarray, met: Sequence[LevelSurface],
        corners: Mapping[tuple[int, ...], tuple[SmoothBranch, dict[Switch, int]]],
    ) -> Mode | None:  # fmt: skip
        """The state of rest, where the fields on the sides cancel and hold no time, until a
        switching surface that holds it is reached: something may set in there."""
        first, sides = next(iter(corners.values()))
        rows, later, merged = [], dict[Switch, int](), dict[Switch, int]()
        for corner, beside in corners.values():
            clock, switches = corner.program.time, (*corner.switches, *(s.switch for s in met))
            if self.problem.changing is not None or self._holds_time(corner.program, beside, time):
                return None
            timed = [w for w in switches if w.function.has(clock)]
            strange = {w for w in timed if w.whole or w.floors}.difference(first.switches)
            if strange or any(s.switch in timed for s in met):
                return None
            later |= {w: beside[w] for w in timed if not w.fixed}
            merged |= beside
            rows.append([float(x) for x in self._rates(corner.program, beside, time, state)])
        from scipy.optimize import nnls

        matrix = np.vstack([np.array(rows).T, np.ones(len(rows))])
        scale = max(1.0, np.abs(matrix).max())
        _, rest = nnls(matrix / scale, np.array([0.0] * len(state) + [1.0]) / scale)
        if rest > CANCELLATION:
            return None
        zero = Block((), (se.Integer(0),) * len(state))
        program = replace(first.program, derivative=zero)
        still = replace(first, program=program, switches=(*later,), signs=later, rims=())
        return self.mode((still,), {**merged, **sides}, ())

    def _holds_time(self, program: Program, sides: Mapping[Switch, int], time: Any) -> bool:
        """Whether rates hold the time, other than times a parameter that is zero, as the slope of
        an input is before its table begins to grow."""
        pairs = zip(program.parameters, self.values(program, sides, time), strict=True)
        nothing = {p: se.Integer(0) for p, value in pairs if value == 0}
        rates = (se.sympify(e).xreplace(nothing) for e in program.derivative.expressions)
        return any(program.time in e.free_symbols for e in rates)

    def _agree(
        self, time: Any, state: np.ndarray,
        corners: Mapping[tuple[int, ...], tuple[SmoothBranch, dict[Switch, int]]],
    ) -> bool:  # fmt: skip
        """Whether the fields on some sides are one at a state that moves on along the switching
        surfaces between them, and nothing leads away there: a body may rest on a switching surface
        while others move."""
        fields = (self._rates(c.program, sides, time, state) for c, sides in corners.values())
        rows = np.array([list(map(mpmath.mpf, field)) for field in fields], dtype=object)
        rounding = mpmath.mpf(2) ** (NEAR - self.bits) * abs(rows).max()
        same = bool((abs(rows - rows[0]) <= rounding).all())
        return same and self.order > 0 and not self._leads_away(time, state, corners)

    def _vanish(
        self, time: Any, state: np.ndarray,
        corners: Mapping[tuple[int, ...], tuple[SmoothBranch, dict[Switch, int]]],
    ) -> bool:  # fmt: skip
        """Whether the fields on all sides vanish at a state."""
        rates = (self._rates(c.program, sides, time, state) for c, sides in corners.values())
        return not any(map(any, rates))

    def _leads_away(
        self, time: Any, state: np.ndarray,
        corners: Mapping[tuple[int, ...], tuple[SmoothBranch, dict[Switch, int]]],
    ) -> bool:  # fmt: skip
        """Whether fields change beside a state more slowly than in proportion to the way from it,
        and push on: else nothing leaves its way, as |x'| <= L |x|, or what is beside returns.

        What moves is pushed by its own rate, or, where that is none, by the rate of its rate.
        """
        near, far = mpmath.mpf(2) ** -40, mpmath.mpf(2) ** -20
        ways = np.vstack([np.diag(self.units), -np.diag(self.units), self.units, -self.units])
        for (corner, sides), way in product(corners.values(), ways):
            beside, here = state + way * near, way / self.units**2
            if any(
                self._value(w, time, beside, sides) != n for w, n in sides.items() if not w.fixed
            ):
                continue

            def rates(there: np.ndarray, corner: Any = corner, sides: Any = sides) -> Any:
                return np.array(self._rates(corner.program, sides, time, there), dtype=object)

            field = rates(state)
            moved = rates(beside) - field
            usual = max(abs(rates(state + way * far) - field)) / far
            if max(abs(moved)) / near > STEEP * max(usual, 1):
                push = here.dot(moved)
                later = rates(beside + moved * near**2) - field - moved
                if push > 0 or (push == 0 and here.dot(later) > 0):
                    return True
        return False

    def is_open(
        self, time: Any, state: np.ndarray, surface: LevelSurface, sides: Mapping[Switch, int]
    ) -> bool:
        """Whether a motion into the past ``touches`` a switching surface, or one into the future
        ``grazes`` it: then it is open on which side it goes on.  What has no value there says
        nothing of it."""
        look = self.grazes if self.order > 0 else self.touches
        try:
            return look(time, state, surface, sides)
        except NO_VALUE:
            return False

    def touches(
        self, time: Any, state: np.ndarray, surface: LevelSurface, sides: Mapping[Switch, int]
    ) -> bool:
        """Whether a switching surface is touched, not crossed, from a side while the other side
        leads to it, in the sense of time: then the motion may have come along it."""
        g, size = self._value_and_size(surface.switch, time, state, sides)
        side = 1 if sides[surface.switch] == surface.value(1) else -1
        rate, scale = self._rate(time, state, surface, sides)
        if abs(g - surface.level) > GRAZE * size or abs(rate) > mpmath.sqrt(GRAZE) * scale:
            return False
        other, _ = self._rate(time, state, surface, {**sides, surface.switch: surface.value(-side)})
        return bool(other * side > 0)

    def grazes(
        self, time: Any, state: np.ndarray, surface: LevelSurface, sides: Mapping[Switch, int]
    ) -> bool:
        """Whether a motion that comes to a switching surface turns within its error of it, while
        the other side leads away: then that error decides on which side it goes on."""
        g, size = self._value_and_size(surface.switch, time, state, sides)
        if abs(g - surface.level) > self.problem.tol**UNSURE * size:
            return False
        side = 1 if sides[surface.switch] == surface.value(1) else -1
        rate, bend = self._rate_and_bend(time, state, surface, sides)
        if bend * side <= 0 or rate**2 / (2 * bend * side) > self.problem.tol**UNSURE * size:
            return False
        beyond = {**sides, surface.switch: surface.value(-side)}
        other, bend = self._rate_and_bend(time, state, surface, beyond)
        return not (other * self.order * side > 2 * abs(rate) or bend * side > 0)

    def _rate_and_bend(
        self, time: Any, state: np.ndarray, surface: LevelSurface, sides: Mapping[Switch, int]
    ) -> tuple[Any, Any]:
        """How fast a switching surface's function grows on given sides, and how fast that does."""
        rate, _ = self._rate(time, state, surface, sides)
        corner, values = self._corner(time, state, sides)
        later, there = self._follow(corner.program, time, state, values, self.order)
        return rate, (self._rate(later, there, surface, sides)[0] - rate) / (later - time)

    def _rate(
        self, time: Any, state: np.ndarray, surface: LevelSurface, sides: Mapping[Switch, int]
    ) -> tuple[Any, Any]:
        """How fast a switching surface's function grows on given sides, and the size of the terms
        of that."""
        self._require_rates((surface,))
        corner, values = self._corner(time, state, sides)
        field = self._rates(corner.program, values, time, state)
        _, slope, *slopes = self._measure(surface.switch, time, state, sides)
        terms = [slope, *(a * b for a, b in zip(slopes, field, strict=True))]
        speeds = [
            abs(a) * max(abs(b), abs(x)) for a, b, x in zip(slopes, field, state, strict=True)
        ]
        return sum(terms), sum(speeds) + abs(slope)

    def _require_rates(self, surfaces: Sequence[LevelSurface]) -> None:
        """Refuse to follow a switching surface that holds a function of Python's whose rate is not
        known."""
        changing = self.problem.changing
        for surface in surfaces if changing is not None else ():
            assert changing is not None
            lacking = changing.without_rates(map(str, surface.switch.function.free_symbols))
            if lacking is not None:
                raise DefinitionError(
                    f"the equations switch where {surface}, and nothing tells how the input "
                    f"'{lacking.name}', a function of Python's, changes there; give "
                    f"{lacking.mend(f'{lacking.name}dot')}, or a table"
                )

    def _weights(self, mode: Mode, time: Any, state: np.ndarray) -> list[Any] | None:
        """The weights of the sides along surfaces; None where the motion is not held there.

        Where nothing pushes to a surface just now, as friction does not whose lever vanishes, the
        push of a moment later tells.
        """
        later = None
        with suppress(*NO_VALUE):
            later = self._holds(mode, *self.moment(mode, time, state, 1))
        try:
            weights, returns = self._holds(mode, time, state)
        except NO_VALUE:  # 0/0, as where a load sets in
            if later is None:
                return None
            weights, returns = later
        later = later or (weights, returns)
        pairs = zip(returns, later[1], strict=True)
        pushes = [b if abs(a) < NEGLIGIBLE * abs(b) else a for a, b in pairs]
        if all(abs(w) <= 1 for w in weights) and all(self.order * r < 0 for r in pushes):
            return weights
        return None

    def begin(self, mode: Mode, time: Any, state: np.ndarray) -> tuple[Any, np.ndarray]:
        """Time and state from which a motion along surfaces is followed: a moment later where its
        weights are 0/0, or the rates of what is integrated beside the state have no value, as that
        of sqrt|x| where x sets out."""
        if not mode.along:
            return time, state
        try:
            self._holds(mode, time, state)
            wide, values = mode.wide_program, self.values(mode.program, mode.sides, time)
            beside = [1] * (len(wide.state) - len(state))
            compiled_digits(wide)[0](time, [*state, *beside], values)
        except NO_VALUE:
            return self.moment(mode, time, state, 1)
        return time, state

    def _holds(self, mode: Mode, time: Any, state: np.ndarray) -> tuple[list[Any], list[Any]]:
        """Along surfaces, the weights of the sides, and how far the push of each leads back."""
        values = self.values(mode.program, mode.sides, time)
        levels = compiled_digits(mode.levels)[1](time, list(state), values)
        named = dict(zip(mode.levels.names, levels, strict=True))
        weights, returns = (
            [named[f"{kind} {i}"] for i in range(len(mode.along))] for kind in ("weight", "return")
        )
        return weights, returns

    def _affine(
        self, time: Any, state: np.ndarray, mode: Mode, weights: Sequence[Any],
        other: Mapping[LevelSurface, int], corners: Mapping[tuple[int, ...], Any],
        met: Sequence[LevelSurface],
    ) -> bool:  # fmt: skip
        """Whether the field is affine in the sides of several surfaces, so that it is known what
        leads along all of them."""
        if len(weights) < 2:
            return True
        rows = {}
        for above, (corner, sides) in corners.items():
            if all(above[met.index(s)] == side for s, side in other.items()):
                key = tuple(above[met.index(s)] for s in mode.along)
                rows[key] = np.array(self._rates(corner.program, sides, time, state), dtype=object)
        top = (1,) * len(weights)
        for key, row in rows.items():
            flips = [i for i, side in enumerate(key) if side < 0]
            single = [tuple(-1 if j == i else 1 for j in range(len(key))) for i in flips]
            guess = rows[top] + sum((rows[s] - rows[top] for s in single), 0 * rows[top])
            size = max(abs(x) for r in rows.values() for x in r) or 1
            if max(abs(x) for x in row - guess) > size * mpmath.mpf(2) ** (16 - self.bits):
                return False
        return True


def runge_kutta(
    field: Callable[[Any, np.ndarray], np.ndarray], time: Any, state: np.ndarray, h: Any
) -> np.ndarray:
    """One step of the classical method of order four."""
    a = field(time, state)
    b = field(time + h / 2, state + a * (h / 2))
    c = field(time + h / 2, state + b * (h / 2))
    d = field(time + h, state + c * h)
    return state + (a + 2 * b + 2 * c + d) * (h / 6)
