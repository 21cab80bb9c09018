"""Source of DOP853 for one program, to be compiled as a whole: stages on scalars, dense output, and
a look for events.

The coefficients are those of [HairerNorsettWanner1993, sec. II.5] as scipy publishes them; the
choice of the step is scipy's, smoothed (``growth``).  Sums over steps are kept in two doubles, so
that long runs add little rounding.
"""

from __future__ import annotations

import inspect
import re
from math import sqrt
from pathlib import Path
from textwrap import indent
from typing import NamedTuple

from voronec.equations.program import Program, hoist, scalar_source
from voronec.motion import crossings
from voronec.motion.crossings import BERNSTEIN, HIGHEST, NOISE
from voronec.motion.crossings import NODES as PLACES

END, LIMIT, EVENT, NO_STEP = range(4)
"""Why ``drive`` came back: the grid ended, so many trials were made, something may happen within
the last step, or no step was short enough."""
STAGES = 12
FIRST_GROWTH = 2.8
"""What is taken for the factor of the step before the first."""


# fmt: off
STAGE_NODES = (
    0.0, 0.05260015195876773, 0.0789002279381516, 0.1183503419072274, 0.2816496580927726,
    0.3333333333333333, 0.25, 0.3076923076923077, 0.6512820512820513, 0.6, 0.8571428571428571,
    1.0, 0.1, 0.2, 0.7777777777777778,
)
"""Where stages stand in a step; the last three are those of the dense output alone."""
WEIGHTS: tuple[dict[int, float], ...] = (
    {},
    {0: 0.05260015195876773},
    {0: 0.0197250569845379, 1: 0.0591751709536137},
    {0: 0.02958758547680685, 2: 0.08876275643042054},
    {0: 0.2413651341592667, 2: -0.8845494793282861, 3: 0.924834003261792},
    {0: 0.037037037037037035, 3: 0.17082860872947386, 4: 0.12546768756682242},
    {0: 0.037109375, 3: 0.17025221101954405, 4: 0.06021653898045596, 5: -0.017578125},
    {0: 0.03709200011850479, 3: 0.17038392571223998, 4: 0.10726203044637328,
     5: -0.015319437748624402, 6: 0.008273789163814023},
    {0: 0.6241109587160757, 3: -3.3608926294469414, 4: -0.868219346841726,
     5: 27.59209969944671, 6: 20.154067550477894, 7: -43.48988418106996},
    {0: 0.47766253643826434, 3: -2.4881146199716677, 4: -0.590290826836843,
     5: 21.230051448181193, 6: 15.279233632882423, 7: -33.28821096898486,
     8: -0.020331201708508627},
    {0: -0.9371424300859873, 3: 5.186372428844064, 4: 1.0914373489967295,
     5: -8.149787010746927, 6: -18.52006565999696, 7: 22.739487099350505,
     8: 2.4936055526796523, 9: -3.0467644718982196},
    {0: 2.273310147516538, 3: -10.53449546673725, 4: -2.0008720582248625,
     5: -17.9589318631188, 6: 27.94888452941996, 7: -2.8589982771350235, 8: -8.87285693353063,
     9: 12.360567175794303, 10: 0.6433927460157636},
    {0: 0.056167502283047954, 6: 0.25350021021662483, 7: -0.2462390374708025,
     8: -0.12419142326381637, 9: 0.15329179827876568, 10: 0.00820105229563469,
     11: 0.007567897660545699, 12: -0.008298},
    {0: 0.03183464816350214, 5: 0.028300909672366776, 6: 0.053541988307438566,
     7: -0.05492374857139099, 10: -0.00010834732869724932, 11: 0.0003825710908356584,
     12: -0.00034046500868740456, 13: 0.1413124436746325},
    {0: -0.42889630158379194, 5: -4.697621415361164, 6: 7.683421196062599,
     7: 4.06898981839711, 8: 0.3567271874552811, 12: -0.0013990241651590145,
     13: 2.9475147891527724, 14: -9.15095847217987},
)
"""What stages add to the start of the step, slope by slope; slope 12 is that of its end."""
STEP = {
    0: 0.054293734116568765, 5: 4.450312892752409, 6: 1.8915178993145003,
    7: -5.801203960010585, 8: 0.3111643669578199, 9: -0.1521609496625161,
    10: 0.20136540080403034, 11: 0.04471061572777259,
}
"""What the step adds."""
FIFTH = {
    0: 0.01312004499419488, 5: -1.2251564463762044, 6: -0.4957589496572502,
    7: 1.6643771824549864, 8: -0.35032884874997366, 9: 0.3341791187130175,
    10: 0.08192320648511571, 11: -0.022355307863886294,
}
THIRD = {
    0: -0.18980075407240762, 5: 4.450312892752409, 6: 1.8915178993145003,
    7: -5.801203960010585, 8: -0.4226823213237919, 9: -0.1521609496625161,
    10: 0.20136540080403034, 11: 0.02265179219836082,
}
"""Its errors against methods of orders five and three."""
BENDS: tuple[dict[int, float], ...] = (
    {0: -8.428938276109013, 5: 0.5667149535193777, 6: -3.0689499459498917,
     7: 2.38466765651207, 8: 2.117034582445028, 9: -0.871391583777973, 10: 2.2404374302607883,
     11: 0.6315787787694688, 12: -0.08899033645133331, 13: 18.148505520854727,
     14: -9.194632392478356, 15: -4.436036387594894},
    {0: 10.427508642579134, 5: 242.28349177525817, 6: 165.20045171727028,
     7: -374.5467547226902, 8: -22.113666853125306, 9: 7.733432668472264,
     10: -30.674084731089398, 11: -9.332130526430229, 12: 15.697238121770845,
     13: -31.139403219565178, 14: -9.35292435884448, 15: 35.81684148639408},
    {0: 19.985053242002433, 5: -387.0373087493518, 6: -189.17813819516758,
     7: 527.8081592054236, 8: -11.57390253995963, 9: 6.8812326946963, 10: -1.0006050966910838,
     11: 0.7777137798053443, 12: -2.778205752353508, 13: -60.19669523126412,
     14: 84.32040550667716, 15: 11.99229113618279},
    {0: -25.69393346270375, 5: -154.18974869023643, 6: -231.5293791760455,
     7: 357.6391179106141, 8: 93.40532418362432, 9: -37.45832313645163, 10: 104.0996495089623,
     11: 29.8402934266605, 12: -43.53345659001114, 13: 96.32455395918828,
     14: -39.17726167561544, 15: -149.72683625798564},
)
"""The last four coefficients of the dense output."""
# fmt: on


class Tableau(NamedTuple):
    """The coefficients of the step: nodes and weights of its stages, what it adds, its errors."""

    nodes: tuple[float, ...]
    weights: tuple[dict[int, float], ...]
    step: dict[int, float]
    fifth: dict[int, float]
    third: dict[int, float]


DOP853 = Tableau(STAGE_NODES[:STAGES], WEIGHTS[:STAGES], STEP, FIFTH, THIRD)
"""That of this method, for those who write its stages otherwise."""


def growth(factor, last, rejected):  # type: ignore[no-untyped-def]
    """By how much longer the next step is to be, from the factor that the error of this one allows,
    0.9 err^(-1/8), and from that of the one before.

        f = 0.887 err^(-1/8 + b) err_last^b,  b = 1/32

    is control with an integral part [HairerNorsettWanner1993, sec. II.4]: few steps are rejected,
    and errors settle at 0.887^16 = 0.15 of the tolerance, not at 0.43, so that less adds up over
    many steps.  Powers that roots give take a tenth of the time of others.
    """
    before = 1 / (0.81 * min(last, 2.8))  # it is known long before the factor is
    ratio = 0.887 * sqrt(sqrt(factor * factor * factor * before))
    return min(ratio, 1.0 if rejected else 10.0)


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
    parts.append(stepping_source(len(program.state), count))
    return re.sub(r"^def ", "@jit\ndef ", "\n\n".join([_SIGN, *parts]), flags=re.MULTILINE)


def stepping_key() -> str:
    """All that the stepping source comes from: this file, and that of the finder of crossings."""
    files = (__file__, crossings.__file__)
    return "\n".join(Path(file).read_text(encoding="utf-8") for file in files)


def stepping_source(n: int, m: int) -> str:
    """Source of ``drive`` and of what it calls but ``rhs`` and ``extras``, for a state of n numbers
    and m functions of events.  ``c_stepper`` translates it too: it keeps to few words, and assigns
    numbers alone: rows of arrays would cost numba two seconds more of compiling."""
    return "\n\n".join([inspect.getsource(growth), _drive(n, m)])


def _each(line: str, count: int) -> str:
    """A line for each component: its names have an index in place of @, its entries one of #."""
    return "\n".join(line.replace("@", f"_{i}").replace("#", str(i)) for i in range(count))


def _list_names(pattern: str, count: int) -> str:
    return ", ".join(pattern.replace("@", f"_{i}").replace("#", str(i)) for i in range(count))


def _weighted_sum(row: dict[int, float], slope: str = "k{}@") -> str:
    """The sum of slopes with the weights of a row of the table."""
    return " + ".join(f"{c!r}*{slope.format(j)}" for j, c in row.items())


def _stage(number: int, n: int) -> str:
    *known, last = WEIGHTS[number].items()
    begin = f"(y@ + h*({_weighted_sum(dict(known))}))" if known else "y@"
    # the rest is there before the latest slope is: a step takes as long as what waits for it
    trial = f"w = {last[1]!r}*h\n" + _each(f"z@ = {begin} + w*k{last[0]}@", n)
    return f"{trial}\n{_slope(f'k{number}', f't + {STAGE_NODES[number]!r}*h', 'z@', n)}"


def _slope(target: str, time: str, place: str, n: int) -> str:
    return f"{_list_names(target + '@', n)}, = rhs({time}, {_list_names(place, n)}, parameters)"


def _drive(n: int, m: int) -> str:
    """Source for a state of n numbers and m functions of events."""
    stages = [_stage(s, n) for s in range(1, STAGES)]
    pieces = {
        "begin": _each(_BEGIN, n),
        "rate": _slope("k0", "t", "y@", n),
        "first": _first_step(n),
        "stages": "\n".join(stages),
        "step": _each(f"s@ = h*({_weighted_sum(STEP)}) + low@\nnew@ = y@ + s@", n),
        "last": _slope(f"k{STAGES}", "ahead", "new@", n),
        "errors": _each(
            "share = 1.0/(atol@ + rtol@*max(abs(y@), abs(new@)))\n"
            f"five += (({_weighted_sum(FIFTH)})*share)**2\n"
            f"three += (({_weighted_sum(THIRD)})*share)**2",
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
    loop, extra = f"for i in range({n}):", range(STAGES, len(STAGE_NODES))
    used = {j for row in (*WEIGHTS[STAGES:], *BENDS) for j in row if j <= STAGES}
    rows = [_each(f"slopes[#, {j}] = k{j}@", n) for j in sorted(used)]
    for s in extra:
        rows += [
            loop,
            f"    z[i] = states[0, i] + h*({_weighted_sum(WEIGHTS[s], 'slopes[i, {}]')})",
        ]
        rows.append(_slope("g", f"t + {STAGE_NODES[s]!r}*h", "z[#]", n))
        rows.append(_each(f"slopes[#, {s + 1}] = g@", n))
    rows += [_each(_CHANGES, n), loop]
    for i, row in enumerate(BENDS):
        rows.append(f"    bend[{3 + i}, i] = h*({_weighted_sum(row, 'slopes[i, {}]')})")
    return "\n".join(rows)


def _fill_template(template: str, pieces: dict[str, str]) -> str:
    """A template whose lines ``<name>`` give way to pieces, indented as they stand, and ``{name}``
    within lines to short ones."""
    rows = []
    for row in template.strip("\n").split("\n"):
        slot = re.fullmatch(r"( *)<(\w+)>", row)
        rows.append(indent(pieces[slot[2]], slot[1]) if slot else row)
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
    """Which functions of events may vanish within the step: what ``crossings`` finds lies there.
    Where they have no zero by the rule of ``Pieces.signs`` no step is handed over."""

    def level(row: str, time: str, place: str) -> str:
        return (
            f"{_list_names('g@', m)}, = extras({time}, {_list_names(place, n)}, given)\n"
            + _each(f"look[{row}, #] = g@", m)
        )  # fmt: skip

    rows = [
        f"share = {_weighted_sum(dict(enumerate(row)), 'look[{}, j]')}\n"
        "low, high = min(low, share), max(high, share)"
        for row in BERNSTEIN[1:-1].tolist()
    ]
    highest = (_weighted_sum(dict(enumerate(r)), "look[{}, j]") for r in HIGHEST.tolist())
    pieces = {
        "nodes": "\n".join(f"nodes[{i}] = {x!r}" for i, x in enumerate(PLACES.tolist())),
        "coefficients": "\n".join(rows),
        "off": f"off = {' + '.join(f'abs({e})' for e in highest)} + {NOISE!r}*most",
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
below, slope = sqrt(below/{n}), sqrt(slope/{n})
size = 1e-6 if below < 1e-5 or slope < 1e-5 else 0.01*below/slope
span = abs(last - t)
size = min(size, span)
<trial>
<bend>
steep = sqrt(steep/{n})/size
evaluations += 2
if slope <= 1e-15 and steep <= 1e-15:
    size = min(100.0*size, max(1e-6, size*1e-3), span)
else:
    size = min(100.0*size, (0.01/max(slope, steep))**0.125, span)
"""

_LOOKS = """
shift = 1e-6*h
<ends>
searched = False
for j in range({m}):
    active[j] = coarse[j] == 0
    if not active[j]:
        first, second = (look[1, j] - look[0, j])/1e-6, (look[3, j] - look[2, j])/1e-6
        fall = max(abs(first), abs(second)) + abs(second - first)
        good = look[0, j] > 0.0 and look[2, j] > 0.0
        active[j] = not good or look[0, j] + look[2, j] <= fall
    searched = searched or active[j]
if searched:
    <nodes>
    for i in range(9):
        x = nodes[i]
        between(bend, states, x, z)
        <level>
    for j in range({m}):
        most, low, high = 0.0, min(look[0, j], look[8, j]), max(look[0, j], look[8, j])
        for i in range(9):
            most = max(most, abs(look[i, j]))
        <coefficients>
        <off>
        if active[j] and most != 0.0 and not (low > off or high < -off):
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
    nodes = np.empty(9)
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
        least = 0.0
        if size < 3e-15*abs(t) + 1e-300:  # may be less than ten units in the last place
            least = 10.0*abs(np.nextafter(t, order*np.inf) - t)
        if not rejected:
            size = max(size, least)
        if not size >= least:  # nor is a step that is no number
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
        # the error squared is the second by the first: a quotient before four roots, none after
        wrong, error = (five + 0.01*three)*{n}, size*five*size*five
        ease = 0.9*sqrt(sqrt(sqrt(sqrt(wrong/error)))) if error > 0.0 else 10.0
        if not (error < wrong or wrong == 0.0):
            size *= max(0.2, ease) if error == error else 0.2
            rejected = True
            continue
        factor = min(1.0 if rejected else 10.0, ease)
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
            for i in range({n}):
                ends[kept, 0, i], ends[kept, 1, i] = states[3, i], states[0, i]
                if dense:
                    for j in range(7):
                        bends[kept, j, i] = bend[j, i]
            kept += 1
        clock[2] = t
        if happening:
            t, outcome = ahead, 2
            break
        while done < len(grid) and order*grid[done] <= order*ahead:
            if grid[done] == ahead:
                for i in range({n}):
                    rows[done, i] = states[0, i]
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
