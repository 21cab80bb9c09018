"""Source of DOP853 for one program, to be compiled as a whole: stages on scalars, dense output, and
a look for events.

The coefficients are those of [HairerNorsettWanner1993, sec. II.5] as scipy publishes them; the
choice of the step is scipy's, smoothed (``growth``).  Sums over steps are kept in two doubles, so
that long runs add little rounding.
"""

from __future__ import annotations

import inspect
import re
from textwrap import indent
from typing import Any

import numpy as np

from voronec.equations.program import Program, hoist, scalar_source

__all__ = ["END", "EVENT", "FIRST_GROWTH", "LIMIT", "NO_STEP", "growth", "kernel_source"]

END, LIMIT, EVENT, NO_STEP = range(4)
"""Why ``drive`` came back: the grid ended, so many trials were made, something may happen within
the last step, or no step was short enough."""
STAGES = 12
LOOKS = 8
"""Parts of a step at whose ends functions of events are looked at."""
FIRST_GROWTH = 2.8
"""What is taken for the factor of the step before the first."""
SHARE = 0.5
"""The part of the tolerance that a step may use up, where doubles allow it: steps err with the same
sign for long, and their errors add up."""


def growth(factor, last, rejected):  # type: ignore[no-untyped-def]
    """By how much longer the next step is to be, from the factor that the error of this one allows,
    0.9 err^(-1/8), and from that of the one before.

        f = 0.9 err^(-1/8 + 3b/4) err_last^b,  b = 0.04

    is control with an integral part [HairerNorsettWanner1993, sec. II.4]: few steps are rejected,
    and errors settle at 0.15 of the tolerance, not at 0.43, so that less adds up over many steps.
    """
    found = 0.9 * (factor / 0.9) ** 0.76 / (min(last, 2.8) / 0.9) ** 0.32
    return min(found, 1.0 if rejected else 10.0)


def kernel_source(program: Program, levels: Program | None) -> str:
    """Source of ``drive``, which goes along a grid until something asks for attention.

    ``levels`` has the functions of events as extra quantities.  ``drive`` takes parameters of the
    program with its constants (``hoisted``), and those of ``levels``; its arrays are described in
    ``numba_stepper``.
    """
    parts = [scalar_source(hoist(program).program)]
    if levels is not None:
        parts.append(scalar_source(levels, extras=True))
    count = 0 if levels is None else len(levels.names)
    parts.append(_drive(len(program.state), count))
    body = "\n\n".join([_SIGN, inspect.getsource(growth), *parts])
    return re.sub(r"^def ", "@jit\ndef ", body, flags=re.MULTILINE)


def _each(line: str, count: int) -> str:
    """A line for each component: its names have an index in place of @, its entries one of #."""
    return "\n".join(line.replace("@", f"_{i}").replace("#", str(i)) for i in range(count))


def _list_names(pattern: str, count: int) -> str:
    return ", ".join(pattern.replace("@", f"_{i}").replace("#", str(i)) for i in range(count))


def _weighted_sum(row: Any, slope: str = "k{}@") -> str:
    """The sum of slopes with the weights of a row of the table."""
    return " + ".join(f"{float(c)!r}*{slope.format(j)}" for j, c in enumerate(row) if c != 0)


def _stage(number: int, node: float, row: Any, n: int) -> str:
    trial = _each(f"z@ = y@ + h*({_weighted_sum(row)})", n)
    return f"{trial}\n{_slope(f'k{number}', f't + {float(node)!r}*h', 'z@', n)}"


def _slope(target: str, time: str, place: str, n: int) -> str:
    return f"{_list_names(target + '@', n)}, = rhs({time}, {_list_names(place, n)}, parameters)"


def _drive(n: int, m: int) -> str:
    """Source for a state of n numbers and m functions of events."""
    from scipy.integrate import DOP853

    stages = [_stage(s, DOP853.C[s], DOP853.A[s, :s], n) for s in range(1, STAGES)]
    pieces = {
        "begin": _each(_BEGIN, n),
        "rate": _slope("k0", "t", "y@", n),
        "first": _first_step(n),
        "stages": "\n".join(stages),
        "step": _each(f"s@ = h*({_weighted_sum(DOP853.B)}) + low@\nnew@ = y@ + s@", n),
        "last": _slope(f"k{STAGES}", "ahead", "new@", n),
        "errors": _each(
            "scale = atol@ + rtol@*max(abs(y@), abs(new@))\n"
            f"five += (({_weighted_sum(DOP853.E5)})/scale)**2\n"
            f"three += (({_weighted_sum(DOP853.E3)})/scale)**2",
            n,
        ),
        "bends": _bends(n),
        "accept": _each(_ACCEPT, n),
        "looks": _looks(n, m) if m else "pass",
        "after": _each("states[0, #] = y@\nstates[1, #] = low@\nstates[2, #] = k0@", n),
        "n": str(n),
        "m": str(max(m, 1)),
    }
    return _fill_template(_DRIVE, pieces)


def _bends(n: int) -> str:
    """The dense output of a step: three more stages, in loops since few steps need it."""
    from scipy.integrate import DOP853

    weights, own = np.vstack([DOP853.A_EXTRA, DOP853.D]), f"for i in range({n}):"
    used = [s for s in range(STAGES + 1) if weights[:, s].any()]
    rows = [_each(f"slopes[#, {s}] = k{s}@", n) for s in used]
    for i, (node, row) in enumerate(zip(DOP853.C_EXTRA, DOP853.A_EXTRA, strict=True)):
        rows += [own, f"    z[i] = states[0, i] + h*({_weighted_sum(row, 'slopes[i, {}]')})"]
        rows.append(_slope("g", f"t + {float(node)!r}*h", "z[#]", n))
        rows.append(_each(f"slopes[#, {STAGES + 1 + i}] = g@", n))
    rows += [_each(_CHANGES, n), own]
    for i, row in enumerate(DOP853.D):
        rows.append(f"    bend[{3 + i}, i] = h*({_weighted_sum(row, 'slopes[i, {}]')})")
    return "\n".join(rows)


def _fill_template(template: str, pieces: dict[str, str]) -> str:
    """A template whose lines ``<name>`` give way to pieces, indented as they stand, and ``{name}``
    within lines to short ones."""
    rows = []
    for row in template.strip("\n").split("\n"):
        found = re.fullmatch(r"( *)<(\w+)>", row)
        rows.append(indent(pieces[found[2]], found[1]) if found else row)
    text = "\n".join(rows) + "\n"
    return text.replace("{n}", pieces.get("n", "")).replace("{m}", pieces.get("m", ""))


def _first_step(n: int) -> str:
    """The length of the first step [HairerNorsettWanner1993, sec. II.4]."""
    slopes = _each("below += (y@/(atol@ + rtol@*abs(y@)))**2", n)
    slopes += "\n" + _each("slope += (k0@/(atol@ + rtol@*abs(y@)))**2", n)
    trial = _each("z@ = y@ + order*size*k0@", n) + "\n" + _slope("k1", "t + order*size", "z@", n)
    bend = _each("steep += ((k1@ - k0@)/(atol@ + rtol@*abs(y@)))**2", n)
    return _fill_template(_FIRST, {"slopes": slopes, "trial": trial, "bend": bend, "n": str(n)})


def _looks(n: int, m: int) -> str:
    """Which functions of events may vanish within the step: what ``crossings`` finds lies there."""

    def level(row: str, time: str, place: str) -> str:
        return (
            f"{_list_names('g@', m)}, = extras({time}, {_list_names(place, n)}, given)\n"
            + _each(f"look[{row}, #] = g@", m)
        )  # fmt: skip

    pieces = {
        "ends": "\n".join(
            [
                level("0", "t", "states[3, #]"),
                level("1", "t + shift", "states[3, #] + shift*states[4, #]"),
                level("2", "ahead", "states[0, #]"),
                level("3", "ahead + shift", "states[0, #] + shift*states[2, #]"),
            ]
        ),
        "level": level("i", "t + h*x", "z[#]"),
        "m": str(m),
    }
    return _fill_template(_LOOKS, pieces)


_SIGN = "def sign(x):\n    return float((x > 0) - (x < 0))\n"
_BEGIN = """y@, low@, k0@ = states[0, #], states[1, #], states[2, #]
atol@, rtol@ = scales[0, #], scales[1, #]"""
_CHANGES = """change = new@ - y@
bend[0, #] = change
bend[1, #] = h*k0@ - change
bend[2, #] = 2.0*change - h*(k12@ + k0@)"""
_ACCEPT = """states[3, #], states[4, #] = y@, k0@
low@ = s@ - (new@ - y@)
y@, k0@ = new@, k12@
states[0, #], states[2, #] = y@, k0@"""

_FIRST = """
below, slope, steep = 0.0, 0.0, 0.0
<slopes>
below, slope = (below/{n})**0.5, (slope/{n})**0.5
size = 1e-6 if below < 1e-5 or slope < 1e-5 else 0.01*below/slope
span = abs(last - t)
size = min(size, span)
<trial>
<bend>
steep = (steep/{n})**0.5/size
evaluations += 2
if slope <= 1e-15 and steep <= 1e-15:
    size = min(100.0*size, max(1e-6, size*1e-3), span)
else:
    size = min(100.0*size, (0.01/max(slope, steep))**0.125, span)
"""

_LOOKS = """
shift = 1e-6*h
<ends>
for j in range({m}):
    active[j] = coarse[j] == 0
    if not active[j]:
        first, second = (look[1, j] - look[0, j])/1e-6, (look[3, j] - look[2, j])/1e-6
        fall = max(abs(first), abs(second)) + abs(second - first)
        good = look[0, j] > 0.0 and look[2, j] > 0.0
        active[j] = not good or look[0, j] + look[2, j] <= fall
if active.any():
    for i in range(9):
        x = i/8
        between(bend, states, x, z)
        <level>
    for j in range({m}):
        low, high, least, most = look[0, j], look[0, j], abs(look[0, j]), abs(look[0, j])
        for i in range(1, 9):
            low, high = min(low, look[i, j]), max(high, look[i, j])
            least, most = min(least, abs(look[i, j])), max(most, abs(look[i, j]))
        whole = low > 0.0 or high < 0.0
        # a parabola that comes near zero between looks has one of them below half the largest
        if active[j] and most != 0.0 and not (whole and least > 0.5*most):
            happening = True
"""

_DRIVE = """
def between(bend, states, x, row):
    # dense output at the part x of the step
    w = 1.0 - x
    for i in range({n}):
        row[i] = states[3, i] + x*(bend[0, i] + w*(bend[1, i] + x*(bend[2, i] + w*(
            bend[3, i] + x*(bend[4, i] + w*(bend[5, i] + x*bend[6, i]))))))


def drive(grid, rows, clock, counts, states, bend, times, ends, bends, scales, coarse, parameters,
          given, dense, keep, limit):
    slopes = np.empty(({n}, 16))
    z, look, active = np.empty({n}), np.empty((9, {m})), np.zeros({m}, np.bool_)
    <begin>
    t, size, last_factor, last = clock[0], clock[1], clock[3], grid[-1]
    done, steps, evaluations = counts[0], counts[1], counts[2]
    order = 1.0 if last >= t else -1.0
    rejected, kept, outcome = counts[3] != 0, 0, 1
    if steps == 0 and size == 0.0:
        <rate>
        <first>
    for trial in range(limit):
        if done == len(grid) or kept == len(times):
            outcome = 0 if done == len(grid) else 1
            break
        least = 10.0*abs(np.nextafter(t, order*np.inf) - t)
        if not rejected:
            size = max(size, least)
        if size < least:
            outcome = 3
            break
        ahead = t + order*size
        if order*(ahead - last) > 0.0:
            ahead = last
        h = ahead - t
        size = abs(h)
        <stages>
        <step>
        <last>
        evaluations += 12
        five, three = 0.0, 0.0
        <errors>
        wrong = five + 0.01*three
        error = size*five/(wrong*{n})**0.5 if wrong > 0.0 else wrong
        if not error < 1.0:
            size *= max(0.2, 0.9*error**-0.125) if error == error else 0.2
            rejected = True
            continue
        factor = 10.0 if error == 0.0 else min(10.0, 0.9*error**-0.125)
        factor = min(1.0, factor) if rejected else factor
        size *= growth(factor, last_factor, rejected)
        last_factor, rejected, happening = factor, False, False
        steps += 1
        if dense or len(coarse) > 0 or order*grid[done] <= order*ahead:
            <bends>
            evaluations += 3
        <accept>
        <looks>
        if keep and not happening:
            times[kept, 0], times[kept, 1] = t, ahead
            ends[kept, 0], ends[kept, 1] = states[3], states[0]
            if dense:
                bends[kept] = bend
            kept += 1
        clock[2] = t
        if happening:
            t, outcome = ahead, 2
            break
        while done < len(grid) and order*grid[done] <= order*ahead:
            if grid[done] == ahead:
                rows[done] = states[0]
            else:
                between(bend, states, (grid[done] - t)/h, rows[done])
            done += 1
        t = ahead
    <after>
    clock[0], clock[1], clock[3] = t, size, last_factor
    counts[0], counts[1], counts[2] = done, steps, evaluations
    counts[3], counts[4] = rejected, kept
    return outcome
"""
