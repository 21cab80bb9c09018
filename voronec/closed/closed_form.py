"""One motion in closed form: a value that knows the state at any time.

On a grid of times, in doubles, nothing is computed that is not asked for.  Coordinates in space are
read off the frame of the motion turned upright.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy as sp

from voronec.algebra.arguments import COUNT, FLAG, require
from voronec.algebra.precision import SHARP
from voronec.algebra.symbols import plain_name
from voronec.algebra.typeset import html_table
from voronec.closed.arithmetic import ball, precise
from voronec.closed.balls import enclose_state, resting_values
from voronec.closed.clock import TURN, sample_in_own_time, whole_turns_off
from voronec.closed.compiled_motion import reading_of, velocities_in_doubles
from voronec.closed.inverted_motion import InvertedMotion, Turn, turns_of
from voronec.closed.planar_rotation import place_on_grid, steady_rates
from voronec.closed.problem import exact_instant
from voronec.closed.ratio import evaluate_form, less_turns, rounded_constants
from voronec.closed.winding import winding_of
from voronec.declaration.reading import doubles, several
from voronec.elliptic.many_times import Sample
from voronec.elliptic.panels import Panels
from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from voronec.closed.classes.trace_classes import TraceClass


@dataclass(frozen=True, eq=False, repr=False)
class ClosedForm(InvertedMotion):
    """A motion in closed form, from ``voronec.closed_form``.

    ``at`` and ``modulo`` give doubles on a grid of times, ``enclose`` balls of any precision at
    one time; the cost of both does not depend on the time.  The time counts from the start.
    """

    def __repr__(self) -> str:
        return f"ClosedForm({self.system.name!r}, period {self.period:.6g}, {self.kind})"

    def _repr_html_(self) -> str:
        """For notebooks: the constants, and what kind of motion it is."""
        rows = [(name, f"{value:.10g}") for name, value in self.constants.items()]
        low, high = self.ends
        rows.append((plain_name(self.quadratures.x), f"between {low:.10g} and {high:.10g}"))
        rows += [(f"trace {where}", f"class {c.label}") for where, c in self.classes.items()]
        return html_table(repr(self), rows)

    def __copy__(self) -> ClosedForm:
        return self  # nothing of it can change

    def __deepcopy__(self, _: Any) -> ClosedForm:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        """What was inverted is inverted again where it arrives."""
        return ClosedForm, (self.problem,)

    # -- what there is to know -------------------------------------------------------------

    @cached_property
    def turns(self) -> Mapping[str, Turn]:
        """Angle -> what it grows by in a period, in radians, and the fraction of a whole turn that
        this is; empty where there is no period."""
        return MappingProxyType(turns_of(self))

    @cached_property
    def classes(self) -> Mapping[str, TraceClass]:
        """The class of the trace on each sphere, by its title; ``EngineLimit`` where a number
        cannot be told from zero."""
        from voronec.closed.classes.trace_classes import classify

        return MappingProxyType(classify(self))

    # -- the motion ------------------------------------------------------------------------

    def at(self, times: Any, names: Sequence[Any] = ()) -> dict[str, np.ndarray]:
        """Coordinates and velocities at ``times`` since the start, an array of any shape: by name,
        for each of ``names`` or for all, an array of doubles of that shape.

        Angles are in radians and continuous from the start, whatever the other times are.  Raises
        ``DefinitionError`` for a name that the motion does not have, and for a time that is no
        finite number.  ``EngineLimit`` names the instant at which a pole of coordinates in space
        is passed: beyond it an angle has no number of turns.
        """
        return sample_coordinates(self, times, self._names(names), whole=True)

    def modulo(self, times: Any, names: Sequence[Any] = ()) -> dict[str, np.ndarray]:
        """Coordinates and velocities by name, of the shape of ``times``, with angles in (-pi, pi],
        as accurate however late, and beyond poles, too.  Raises ``DefinitionError`` as ``at`` does.
        """
        return sample_coordinates(self, times, self._names(names), whole=False)

    def enclose(self, t: Any, digits: int = 50, whole: bool = True) -> dict[str, Any]:
        """Coordinates and velocities at one time (an int, a double, a Fraction, a decimal as text,
        a ball), as flint's balls with radii below 10^-digits that contain the truth.

        Angles are continuous from the start; unless they are ``whole``, those in space may be whole
        turns off.  Raises ``DefinitionError`` for what is no time, ``EngineLimit`` where so many
        digits cannot be had, and where an angle that is to be whole has no number of turns.
        """
        require("enclose", "digits", digits, COUNT)
        require("enclose", "whole", whole, FLAG)
        return enclose_state(self, exact_instant(t), digits, whole)

    def _names(self, names: Sequence[Any]) -> tuple[str, ...]:
        known = [plain_name(q) for q in (*self.system.coordinates, *self.system.velocities)]
        given = several(names, "names", "name")
        asked = [n if isinstance(n, str) else plain_name(n) for n in given]
        asked = asked or known
        for name in asked:
            if name not in known:
                raise DefinitionError(
                    f"the closed form gives {', '.join(known)}; '{name}' is none of these"
                )
        return tuple(asked)


def _where_it_rests(
    form: InvertedMotion, grid: np.ndarray, names: Sequence[str], whole: bool
) -> dict[str, np.ndarray]:
    """Coordinates and velocities; angles continuous (``whole``) or modulo a turn."""
    system, given = form.system, form.problem.start_by_symbol(SHARP)
    straight, state = form.quadratures.lengths, {}
    for q, rate in zip(system.coordinates, steady_rates(form, SHARP), strict=True):
        if whole or q in straight:
            state[plain_name(q)] = float(given[q]) + float(rate) * grid
        else:
            with precise(SHARP):
                turn = less_turns(given[q])
            state[plain_name(q)] = 2 * np.pi * whole_turns_off(rate, grid) + turn
    if form.wheels:
        state |= {plain_name(q): x for q, x in place_on_grid(form, grid).items()}
    state |= _steady_velocities(form, grid, given)
    attitude = form.attitude
    in_space = {plain_name(q) for q in attitude.coordinates} if attitude is not None else set()
    if attitude is not None and not attitude.upright and in_space & {*names}:
        start = np.array([float(e) for e in attitude.start(SHARP)[0]]).reshape(3, 3)
        state |= _read_frame(form, _frames(start, attitude.spin(SHARP), grid), grid, names, whole)
    return state


def _steady_velocities(
    form: InvertedMotion, grid: np.ndarray, given: Mapping[Any, Any]
) -> dict[str, np.ndarray]:
    """Constant, where no moving coordinate is in them."""
    names = list(map(plain_name, form.system.velocities))
    values = [given[v] for v in form.system.velocities]
    read = reading_of(form.problem.prepared)
    if read.coordinates:
        rates = dict(zip(form.system.coordinates, steady_rates(form, SHARP), strict=True))
        with precise(SHARP):
            moved: dict[Any, Any] = dict.fromkeys(read.coordinates, ball(0))
            start = [less_turns(given[q]) for q in read.coordinates]
            numbers: list[Any] = [float(x) for x in resting_values(form, moved, SHARP)]
        for q, turn in zip(read.coordinates, start, strict=True):
            numbers[read.symbols.index(q)] = 2 * np.pi * whole_turns_off(rates[q], grid) + turn
        values = sp.lambdify(read.symbols, list(read.expressions), "numpy", cse=True)(*numbers)
    return {n: np.broadcast_to(x, grid.shape).astype(float) if np.ndim(x) else
            np.full(grid.shape, float(x)) for n, x in zip(names, values, strict=True)}  # fmt: skip


def _frames(start: np.ndarray, spin: Any, grid: np.ndarray) -> Any:
    """E0 exp(t Omega^) on the grid, entries as arrays."""
    with precise(SHARP):
        squared = sum((c * c for c in spin), ball(0))
        size = squared.sqrt() if squared > 0 else ball(0)
        axis = [float(c / size) for c in spin] if size > 0 else [0.0, 0.0, 1.0]
    angle = 2 * np.pi * whole_turns_off(size, grid) if size > 0 else np.zeros(grid.shape)
    a, b, c = axis
    cross = start @ np.array([[0, -c, b], [c, 0, -a], [-b, a, 0]])
    double = cross @ np.array([[0, -c, b], [c, 0, -a], [-b, a, 0]])
    sine, rest = np.sin(angle), 2 * np.sin(angle / 2) ** 2
    return [[start[i, j] + sine * cross[i, j] + rest * double[i, j] for j in range(3)]
            for i in range(3)]  # fmt: skip


MANY = 10_000
"""Times from which on a table is worth making."""


def _by_table(
    form: InvertedMotion,
    grid: np.ndarray,
    plain: Sequence[str],
    circles: Sequence[Any],
    whole: bool,
) -> Sequence[np.ndarray] | None:
    """What ``UprightView.rows`` gives, by a table; None where that is of no use."""
    if grid.size < MANY or not _repeats(form, plain):
        return None
    sample = Sample.of(form.solution, grid)
    angles = {plain_name(q): j for j, q in enumerate(form.quadratures.angles)}
    used = [angles[n] for n in (*plain, *map(plain_name, circles)) if n in angles]
    if any(sample.model.secular_terms[j].exact for j in used):
        return None
    panels = _panels(form, tuple(plain), tuple(circles), sample.model)
    if panels is None:
        return None
    counts, rows = panels.at(sample.times, sample.model.arguments.reduction)
    for name, row in zip(plain, rows, strict=False):
        if name in angles:
            first, part = rounded_constants(form).starts[angles[name]]
            if whole and first != part:
                row += first - part
            _add_growth(row, counts, sample.model.secular_terms[angles[name]], whole)
    for i, q in enumerate(circles):
        if plain_name(q) in angles:
            first = len(plain) + 2 * i
            secular_term = sample.model.secular_terms[angles[plain_name(q)]]
            _add_turns(rows[first], rows[first + 1], counts, secular_term)
    return list(rows)


def _panels(
    form: InvertedMotion, plain: tuple[str, ...], circles: tuple[Any, ...], model: Any
) -> Panels | None:
    """Tables of ``UprightView.rows``, with no whole half periods in them, nor whole turns in the
    angles at the start."""
    velocities = {plain_name(v) for v in form.system.velocities}
    angles = {plain_name(q) for q in form.quadratures.angles}
    sizes = ["largest" if n in velocities else "turn" if n in angles else "own" for n in plain]
    sizes += ["turn"] * (2 * len(circles))

    def work(at: Any) -> list[Any]:
        return UprightView(form, at, True, True).rows(plain, circles)

    return form.memo.once(("panels", plain, circles), lambda: Panels.of(model, work, sizes))


def _repeats(form: InvertedMotion, plain: Sequence[str]) -> bool:
    """Whether all that is asked for repeats itself, or grows by the same in each half period."""
    motion = form.quadratures
    traced = {t.colatitude for t in motion.traces}
    known = {plain_name(q) for q in (*traced, *motion.angles)}
    velocities = {plain_name(v) for v in form.system.velocities}
    asked = {*plain} - known
    if not asked <= velocities:
        return False
    return not asked or {*reading_of(form.problem.prepared).coordinates} <= traced


def _add_growth(row: np.ndarray, counts: np.ndarray, secular_term: Any, whole: bool) -> None:
    """The angle with what it has gained in whole half periods."""
    for part in _blocks(row.size):
        value, count = row[part], counts[part]
        if whole:
            # the only rounding of the size of the value is the last
            value += count * secular_term.second
            value += count * secular_term.first
        else:
            value /= TURN
            value += _gain_in_turns(count, secular_term)
            value -= np.ceil(value - 0.5)
            value *= TURN


def _add_turns(cosine: np.ndarray, sine: np.ndarray, counts: np.ndarray, secular_term: Any) -> None:
    """Cosine and sine of the angle with what it has gained."""
    least = counts.min()
    kinds = int(counts.max() - least) + 1
    few = 2 * kinds < counts.size
    if few:
        angles = TURN * _gain_in_turns(np.arange(kinds) + least, secular_term)
        known = np.cos(angles), np.sin(angles)
    for part in _blocks(counts.size):
        if few:
            places = (counts[part] - least).astype(np.intp)
            c, s = (table.take(places) for table in known)
        else:
            angles = TURN * _gain_in_turns(counts[part], secular_term)
            c, s = np.cos(angles), np.sin(angles)
        before = cosine[part].copy()
        cosine[part] *= c
        cosine[part] -= sine[part] * s
        sine[part] *= c
        sine[part] += before * s


def _gain_in_turns(count: np.ndarray, secular_term: Any) -> np.ndarray:
    """The gain in turns, less whole ones."""
    total = np.zeros(count.size)
    for share in secular_term.turns:
        if share:
            more = count * share
            more -= np.rint(more)
            total += more
    return total


def sample_coordinates(
    form: InvertedMotion, times: Any, names: Sequence[str], whole: bool
) -> dict[str, np.ndarray]:
    """Coordinates and velocities at times; angles continuous (``whole``) or in (-pi, pi]."""
    given = doubles(times, "times")
    grid = given.ravel()
    state = (
        _state_at_rest(form, grid, names, whole)
        if form.rests
        else _state_in_motion(form, grid, names, whole)
    )
    return {name: state[name].reshape(given.shape) for name in names}


def _state_at_rest(
    form: InvertedMotion, grid: np.ndarray, names: Sequence[str], whole: bool
) -> dict[str, np.ndarray]:
    state = _where_it_rests(form, grid, names, whole)
    if whole:
        return state
    straight = form.quadratures.lengths
    turning = {plain_name(q) for q in form.system.coordinates if q not in straight}
    return {n: _wrap_angle(x) if n in turning else x for n, x in state.items()}


def _state_in_motion(
    form: InvertedMotion, grid: np.ndarray, names: Sequence[str], whole: bool
) -> dict[str, np.ndarray]:
    if form.quadratures.clock != 1:
        return sample_in_own_time(form, grid, names, whole)
    attitude = form.attitude
    in_space = () if attitude is None or attitude.upright else attitude.coordinates
    circles = in_space if {*names} & {plain_name(q) for q in in_space} else ()
    turned = {plain_name(q) for q in circles}
    plain = [n for n in names if n not in turned]
    winding = _winding_coordinates(form, circles, names) if whole else ()
    turning = [*plain, *map(plain_name, winding)]
    rows = _by_table(form, grid, turning, circles, whole)
    if rows is None:
        sample = Sample.of(form.solution, grid)
        rows = sample.each(lambda at: UprightView(form, at, whole).rows(turning, circles))
    state = dict(zip(plain, rows, strict=False))
    if circles:
        moved = dict(zip(winding, rows[len(plain) : len(turning)], strict=True)) if whole else None
        state |= _read_circles(form, rows[len(turning) :], grid, names, moved)
    return state


def _winding_coordinates(
    form: InvertedMotion, circles: Sequence[Any], names: Sequence[str]
) -> tuple[Any, ...]:
    """The coordinates whose whole turns, of the motion turned upright, tell those in space."""
    traced = {t.colatitude for t in form.quadratures.traces}
    return winding_of(form).names if {*names} & {plain_name(q) for q in {*circles} - traced} else ()


@dataclass(frozen=True, eq=False)
class UprightView:
    """Coordinates and velocities of a motion turned upright.

    Attributes:
        form: the motion.
        at: the elliptic motion, a ``Stretch`` of a sample.
        whole: whether angles are continuous, else in (-pi, pi].
        in_first_turn: whether continuous angles start in (-pi, pi], whole turns less than they do.
    """

    form: InvertedMotion
    at: Any
    whole: bool
    in_first_turn: bool = False

    def rows(self, plain: Sequence[str], circles: Sequence[Any]) -> list[np.ndarray]:
        """Coordinates and velocities by name, then cosine and sine of each of ``circles``."""
        coordinates = {plain_name(q): q for q in self.form.system.coordinates}
        samples = [
            self.coordinate(coordinates[n]) if n in coordinates else self.velocities[n]
            for n in plain
        ]
        for q in circles:
            angle = self._near.coordinate(q)
            samples += [np.cos(angle), np.sin(angle)]
        return samples

    @cached_property
    def _near(self) -> UprightView:
        """The view whose angles have sines and cosines with all digits: continuous angles have lost
        some late; those that start small are of one period only."""
        whole = self.whole and not self.in_first_turn
        return UprightView(self.form, self.at, False) if whole else self

    def coordinate(self, q: Any) -> np.ndarray:
        """An angle that is an integral, a colatitude, the variable, or a place on a plane."""
        form, angles = self.form, self.form.quadratures.angles
        if q == form.quadratures.meaning:
            return np.asarray(self.at.x)
        if q in angles:
            j = angles.index(q)
            whole, part = rounded_constants(form).starts[j]
            if self.whole:
                return np.asarray(self.at.integral(j, part if self.in_first_turn else whole))
            return np.asarray(self.at.modulo(j, part))
        for i, trace in enumerate(form.quadratures.traces):
            if trace.colatitude == q:
                side, turns = rounded_constants(form).branches[i]
                plain = self.at.colatitude(*rounded_constants(form).reach[i])
                if (side, turns) == (1, 0):
                    return np.asarray(plain)
                moved = side * plain + turns * TURN
                return np.asarray(moved) if self.whole else _wrap_angle(moved)
        return self.place[q]

    @cached_property
    def place(self) -> dict[Any, np.ndarray]:
        """On a plane."""
        form, plane, x = self.form, self.form.quadratures.plane, self.at.x
        assert plane is not None
        start, origin, direction = rounded_constants(form).place
        gone, moved = self.at.affine(*rounded_constants(form).from_start), []
        for i, (a, b, c) in enumerate(rounded_constants(form).slides):
            whole = self.at.integral(len(form.quadratures.angles) + i)
            rest = gone * (a + b * (x + start) / 2 + c * (x * x + x * start + start**2) / 3)
            moved.append(whole + rest)
        return plane.at(origin, direction, moved)

    @cached_property
    def velocities(self) -> dict[str, np.ndarray]:
        """The velocities of the equations, accurate relative to their size near the poles."""
        form, compiled, x = self.form, self.form.problem.prepared, self.at.x
        values: list[Any] = [*rounded_constants(form).level, x, self.at.rate]
        for i in range(len(form.quadratures.traces)):
            south, north = (self.at.affine(*ends) for ends in rounded_constants(form).reach[i])
            offset, slope = rounded_constants(form).cosines[i]
            sine = rounded_constants(form).branches[i][0] * np.sqrt(south * north)
            with np.errstate(all="ignore"):
                values += [sine, offset + slope * x, -slope * self.at.rate / sine]
        rates = rounded_constants(form).rates(self.at, self._weights)
        values += rates[: len(form.quadratures.angles)]
        values += [self._near.coordinate(q) for q in reading_of(compiled).coordinates]
        values += [evaluate_form(p, *self._weights) for p in rounded_constants(form).polynomials]
        with np.errstate(all="ignore"):
            rows = velocities_in_doubles(compiled)(*values)
        names = map(plain_name, form.system.velocities)
        return {n: np.broadcast_to(e, x.shape) for n, e in zip(names, rows, strict=True)}

    @cached_property
    def _weights(self) -> tuple[np.ndarray, np.ndarray]:
        """Of both ends in x."""
        return self.at.affine(1.0, 0.0), self.at.affine(0.0, 1.0)


def _wrap_angle(angle: np.ndarray) -> np.ndarray:
    """In (-pi, pi]."""
    return np.asarray(angle - TURN * np.ceil(angle / TURN - 0.5))


STEEP = 1e-2
"""Where the sine of a colatitude read off a frame is smaller, balls are asked: a double that is
right to 8e-16 tell longitudes no better than to 1e-13."""
DIGITS = 20
"""Of such balls: a double's, and some to lose."""
BLOCK = 8192
"""Instants that are read at once, so few that they stay in the cache."""


def _read_circles(
    form: InvertedMotion,
    circles: Sequence[np.ndarray],
    grid: np.ndarray,
    names: Sequence[str],
    moved: Mapping[Any, np.ndarray] | None,
) -> dict[str, np.ndarray]:
    """Coordinates in space from cosines and sines of those of the motion turned upright.

    ``moved`` has longitude and third angle of that, with whole turns, where these are asked for.
    """
    attitude = form.attitude
    assert attitude is not None
    read, turn = _reader(attitude.space), rounded_constants(form).turn
    rows = np.empty((len(attitude.coordinates), grid.size))
    for part in _blocks(grid.size):
        rows[:, part] = read(*turn, *(c[part] for c in circles))
    return _on_branches(form, rows, grid, names, moved)


def _read_frame(
    form: InvertedMotion, entries: Any, grid: np.ndarray, names: Sequence[str], whole: bool
) -> dict[str, np.ndarray]:
    """Coordinates in space from the entries of the frame there, which turns evenly."""
    attitude = form.attitude
    assert attitude is not None
    read = _plain_reader(attitude.space)
    rows = read(*(np.ravel(entries[i][j]) for i in range(3) for j in range(3)))
    flat = np.array([np.broadcast_to(x, grid.size) for x in rows], dtype=float)
    settled = _on_branches(form, flat, np.ravel(grid), names, {} if whole else None)
    return {name: x.reshape(grid.shape) for name, x in settled.items()}


def _on_branches(
    form: InvertedMotion,
    found: np.ndarray,
    grid: np.ndarray,
    names: Sequence[str],
    moved: Mapping[Any, np.ndarray] | None,
) -> dict[str, np.ndarray]:
    """On their branches; at the few instants at which a colatitude is near a pole, and doubles
    lose digits, from balls."""
    attitude = form.attitude
    assert attitude is not None
    traces = {t.colatitude for t in form.quadratures.traces}
    rows = dict(zip(attitude.coordinates, found, strict=True))
    near = np.zeros(grid.size, dtype=bool)
    for q in traces & {*rows}:
        for part in _blocks(grid.size):
            place = rows[q][part] / np.pi
            place -= np.rint(place)
            near[part] |= ~(np.abs(place) >= STEEP / np.pi)
    asked = {q: row for q, row in rows.items() if plain_name(q) in names}
    whole = moved is not None and bool({*asked} - traces)
    if moved is not None and whole:
        winding_of(form).unwind(
            grid, moved, {q: row for q, row in asked.items() if q not in traces}
        )
    for (q, row), (side, turns) in zip(rows.items(), attitude.branches, strict=True):
        if (q in traces or moved is None) and (side, turns) != (1, 0):
            row *= side
            row += turns * np.pi
    for place in np.flatnonzero(near):
        exact = enclose_state(form, exact_instant(float(grid[place])), DIGITS, whole)
        for q, row in asked.items():
            row[place] = float(exact[plain_name(q)])
    if moved is None:
        return {plain_name(q): _wrap_angle(row) for q, row in asked.items()}
    return {plain_name(q): row for q, row in asked.items()}


def _blocks(size: int) -> Iterator[slice]:
    return (slice(i, min(i + BLOCK, size)) for i in range(0, size, BLOCK))


def _angle(y: np.ndarray, x: np.ndarray) -> np.ndarray:
    """``atan2(y, x)`` in half of the time of numpy's; NaN where both are zero."""
    with np.errstate(all="ignore"):
        angle = np.divide(x, y)
    np.arctan(angle, out=angle)
    return np.asarray(np.subtract(np.copysign(np.pi / 2, y), angle, out=angle))


def _reader(space: Any) -> Any:
    """From a turn (9, row by row), then cosine and sine of each coordinate, turned upright."""
    return space.memo.once("circles", lambda: _read(space))


def _read(space: Any) -> Any:
    turn, circles = sp.symbols("turn:9", cls=sp.Dummy), []
    meaning: dict[Any, Any] = {}
    for q in space.coordinates:
        cosine, sine = sp.symbols("cosine sine", cls=sp.Dummy)
        circles += [cosine, sine]
        meaning |= {sp.cos(q): cosine, sp.sin(q): sine, q: sp.atan2(sine, cosine)}
    frame = sp.Matrix(3, 3, turn) * space.frame.xreplace(meaning)
    entries = dict(zip(space.entries, frame, strict=True))
    formulas = [e.xreplace(entries) for e in space.coordinates.values()]
    return sp.lambdify((*turn, *circles), formulas, [{"arctan2": _angle}, "numpy"], cse=True)


def _plain_reader(space: Any) -> Any:
    return space.memo.once(
        "coordinates",
        lambda: sp.lambdify(tuple(space.entries), list(space.coordinates.values()), "numpy"),
    )  # fmt: skip
