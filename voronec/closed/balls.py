"""The whole motion at one time as balls that contain the truth."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from flint import acb, ctx

from voronec.algebra.symbols import plain_name
from voronec.closed.arithmetic import angle, ball, compile_expressions, precise, root
from voronec.closed.clock import clock_of
from voronec.closed.compiled_motion import CompiledMotion, reading_of
from voronec.closed.inverted_motion import InvertedMotion
from voronec.closed.planar_rotation import rolled_in_balls, steady_rates
from voronec.closed.ratio import ratios
from voronec.closed.space import product
from voronec.closed.winding import winding_of
from voronec.elliptic.solution import exact_time
from voronec.errors import EngineLimit


def _rotation_about(spin: Sequence[Any], t: Any) -> list[Any]:
    """exp(t Omega^) = I + t sinc(w t) Omega^ + t^2/2 sinc^2(w t/2) Omega^^2, row by row."""
    a, b, c = spin
    angle = (a * a + b * b + c * c).nonnegative_part().sqrt() * t
    if not angle.is_finite():
        angle = ball(0).union((a * a + b * b + c * c).abs_upper().sqrt() * t)
    first, half = angle.sinc() * t, (angle / 2).sinc() * t
    second = half * half / 2
    return [
        1 - second * (b * b + c * c),
        second * a * b - first * c,
        second * a * c + first * b,
        second * a * b + first * c,
        1 - second * (a * a + c * c),
        second * b * c - first * a,
        second * a * c - first * b,
        second * b * c + first * a,
        1 - second * (a * a + b * b),
    ]


GUARD = 32
"""Bits that an evaluation may lose before it is begun anew with more."""
MOST = 1 << 15
"""Bits beyond which an enclosure is given up."""


def enclose_state(form: InvertedMotion, t: Any, digits: int, whole: bool = True) -> dict[str, Any]:
    """Coordinates and velocities at a time, each with a radius below 10^-digits; angles continuous
    (``whole``), or those in space up to whole turns.

    Raises ``EngineLimit`` where that cannot be had: at a time that is itself a wide ball, or at
    the instant of a passage through a pole of the coordinates, or beyond one where whole turns are
    asked for.
    """
    if not isinstance(t, str) and t == 0:
        with precise(int(digits * 3.33) + 2 * GUARD):
            given, system = form.problem.start_by_symbol(ctx.prec), form.system
            return {plain_name(q): given[q] for q in (*system.coordinates, *system.velocities)}
    bits = int(digits * 3.33) + GUARD
    wide: list[str] = []
    while bits <= MOST:
        with precise(bits):
            state = (
                _state_at_rest(form, t, bits, whole) if form.rests
                else _state_in_motion(form, t, digits + 5, bits, whole)
            )  # fmt: skip
            least = ball(10) ** -digits
            wide = [name for name, x in state.items() if not (x.is_finite() and x.rad() < least)]
        if not wide:
            return state
        bits *= 2
    if not wide:
        most = int((MOST - GUARD) / 3.33)
        raise EngineLimit(f"enclose: digits = {digits} is more than {most}; ask for fewer")
    raise EngineLimit(
        f"{', '.join(wide)} at t = {t} cannot be given to {digits} digits; give the time exactly,  "
        "and none at which a pole of the coordinates is passed"
    )


def _state_in_motion(
    form: InvertedMotion, t: Any, digits: int, bits: int, whole: bool
) -> dict[str, Any]:
    compiled, problem = form.problem.prepared, form.problem
    digits = max(digits, int((bits - GUARD) / 3.33))
    timed = form.quadratures.clock != 1
    at = clock_of(form).moment(t, digits) if timed else form.solution.enclose(t, digits)
    table, x = problem.table(bits), at.x
    shares = list(_shares(table, len(compiled.poles), at))
    pace = ratios(compiled)[-1].value(problem, x, bits) if timed else ball(1)
    rates = [
        rate / pace for rate in _rates(compiled, table, shares, x)[: len(compiled.motion.angles)]
    ]
    angles = dict(zip(compiled.motion.angles, form.begin(bits), strict=True))
    coordinates = {compiled.motion.meaning: x}
    coordinates |= {q: a + at.integrals[j] for j, (q, a) in enumerate(angles.items())}
    values = [*problem.level(bits), x, at.rate / pace]
    for i, trace in enumerate(compiled.motion.traces):
        south, north, cosine, fall = (_values_at_ratio if timed else _straight)(
            form, table, i, at, bits
        )
        side, turns = form.branch(i)
        colatitude = 2 * angle(root(south), root(north))
        coordinates[trace.colatitude] = side * colatitude + 2 * turns * ball(1).pi()
        sine = side * root(south * north)
        values += [sine, cosine, -fall * at.rate / (sine * pace)]
    values += rates
    values += [coordinates[q] for q in reading_of(compiled).coordinates]
    values += _polynomials(form, x, bits)
    if form.attitude is not None and not form.attitude.upright:
        coordinates |= _turn_back(form, coordinates, exact_time(t), bits, whole)
    if compiled.motion.plane is not None:
        coordinates |= place_on_plane(form, table, at.integrals, x, bits)
    return _name_values(form, coordinates, _velocities(compiled, values))


def _straight(
    form: InvertedMotion, table: list[Any], i: int, at: Any, bits: int
) -> tuple[Any, ...]:
    """1 - cosine and 1 + cosine of a trace, the cosine, and its slope by x, which is constant."""
    first = form.problem.prepared.cosine_at + 2 * i
    offset, slope = table[first : first + 2]
    south, north = (
        at.affine(1 + s * (offset + slope * at.base), 1 + s * (offset + slope * at.other))
        for s in (-1, 1)
    )
    return south.nonnegative_part(), north.nonnegative_part(), offset + slope * at.x, slope


def _values_at_ratio(
    form: InvertedMotion, _: list[Any], i: int, at: Any, bits: int
) -> tuple[Any, ...]:
    """1 - cosine and 1 + cosine of a trace, the cosine p/q, and its slope by x."""
    ratio, problem = ratios(form.problem.prepared)[i], form.problem
    p, q, south, north, bend = (
        part.value(problem, at.x, bits)
        for part in (ratio.above, ratio.below, ratio.south, ratio.north, ratio.bend)
    )
    south, north = (south / q).nonnegative_part(), (north / q).nonnegative_part()
    return south, north, p / q, bend / (q * q)


def _state_at_rest(form: InvertedMotion, t: Any, bits: int, whole: bool) -> dict[str, Any]:
    problem, compiled = form.problem, form.problem.prepared
    time, given = exact_time(t), dict(zip(compiled.inputs, problem.start_balls(bits), strict=True))
    coordinates = {q: given[q] for q in compiled.system.coordinates}
    turned = form.attitude is not None and not form.attitude.upright
    for q, rate in zip(compiled.system.coordinates, steady_rates(form, bits), strict=True):
        coordinates[q] = coordinates[q] + rate * time
    if form.wheels:
        coordinates |= rolled_in_balls(form, time, bits)
    if turned and form.attitude is not None:
        motion = _rotation_about(form.attitude.spin(bits), time)
        frame = product(form.attitude.start(bits)[0], motion)
        coordinates |= _read(form, frame, None, time, bits, whole)
    return _name_values(form, coordinates, _velocities_at_rest(form, coordinates, given, bits))


def _velocities_at_rest(
    form: InvertedMotion, found: dict[Any, Any], given: dict[Any, Any], bits: int
) -> Any:
    """The velocities where the variable rests: constant, if they hold no moving coordinate."""
    compiled = form.problem.prepared
    if not reading_of(compiled).coordinates:
        return [given[v] for v in compiled.system.velocities]
    return _velocities(compiled, resting_values(form, found, bits))


def place_on_plane(
    form: InvertedMotion, table: list[Any], integrals: Any, x: Any, bits: int
) -> dict[Any, Any]:
    """The place on a plane: along and across a constant direction."""
    plane, compiled = form.quadratures.plane, form.problem.prepared
    assert plane is not None
    start, moved = form.problem.place(bits), []
    for i in range(2):
        a, b, c = table[compiled.slope_at + 3 * i : compiled.slope_at + 3 * i + 3]
        rest = (x - start) * (a + b * (x + start) / 2 + c * (x * x + x * start + start * start) / 3)
        for place, residues in form.problem.others(bits):
            residue = residues[len(compiled.rates) + i]
            if not isinstance(residue, int):
                rest += acb(residue * acb((x - place) / (start - place)).log()).real
        moved.append(integrals[len(compiled.motion.angles) + i] + rest)
    return plane.at([form.exact(q)(bits) for q in plane.place], form.direction(bits), moved)


def _turn_back(
    form: InvertedMotion, upright: dict[Any, Any], time: Any, bits: int, whole: bool
) -> dict[Any, Any]:
    assert form.attitude is not None
    frame = form.attitude.machines[2]([upright[q] for q in form.attitude.coordinates])
    turned = product(form.attitude.turn(bits), frame)
    return _read(form, turned, upright, time, bits, whole)


def _read(
    form: InvertedMotion, frame: list[Any], upright: Any, time: Any, bits: int, whole: bool
) -> dict[Any, Any]:
    """Coordinates off the frame in space, on the branches on which they start."""
    attitude = form.attitude
    assert attitude is not None
    plain = attitude.machines[1](frame)
    coordinates = attitude.shift_to_branch(plain, bits)
    if whole:
        read = dict(zip(attitude.coordinates, plain, strict=True))
        coordinates |= winding_of(form).continuous(time, upright, read, bits)
    return coordinates


def _shares(table: list[Any], count: int, at: Any) -> Iterator[Any]:
    for i in range(count):
        place, weight = table[5 + 2 * i : 7 + 2 * i]
        if weight.is_zero():
            yield weight
        else:
            yield weight / at.affine(at.base - place, at.other - place)


def _rates(own: Any, table: list[Any], shares: list[Any], x: Any) -> list[Any]:
    rates, first = [], 5 + 2 * len(shares)
    for j, row in enumerate(own.shares):
        a, b, c = table[first + 3 * j : first + 3 * j + 3]
        rate = a + x * (b + x * c)
        for share, part in zip(row, shares, strict=True):
            if share:
                rate += share * part
        rates.append(rate)
    return rates


def resting_values(form: InvertedMotion, moved: Mapping[Any, Any], bits: int) -> list[Any]:
    """Values of the symbols of a ``Reading`` where the variable rests, with coordinates that have
    moved."""
    compiled, x = form.problem.prepared, form.problem.place(bits)
    read, values = reading_of(compiled), [*form.problem.level(bits), x, ball(0)]
    rates = dict(zip(form.system.coordinates, steady_rates(form, bits), strict=True))
    with precise(bits):
        for trace in form.quadratures.traces:
            colatitude = form.exact(trace.colatitude)(bits)
            values += [colatitude.sin(), colatitude.cos(), ball(0)]
        values += [rates[q] for q in form.quadratures.angles]
        values += [moved[q] for q in read.coordinates]
        return values + _polynomials(form, x, bits)


def _polynomials(form: InvertedMotion, x: Any, bits: int) -> list[Any]:
    """The polynomials in x that velocities hold."""
    compiled = form.problem.prepared
    kept = reading_of(compiled).polynomials
    if not kept:
        return []
    symbols = (*compiled.level, compiled.motion.x)
    function = compiled.memo.once(
        "polynomials of velocities", lambda: compile_expressions(kept, symbols)
    )
    return function([*form.problem.level(bits), x])


def _velocities(own: CompiledMotion, values: list[Any]) -> list[Any]:
    read = reading_of(own)
    made = own.memo.once("velocities", lambda: compile_expressions(read.expressions, read.symbols))
    return made(values)


def _name_values(
    form: InvertedMotion, found: dict[Any, Any], velocities: list[Any]
) -> dict[str, Any]:
    system = form.problem.prepared.system
    named = {plain_name(q): found[q] for q in system.coordinates}
    return named | dict(zip(map(plain_name, system.velocities), velocities, strict=True))
