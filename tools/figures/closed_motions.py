"""The motions that the closed form is measured on: every class, and the hard cases, exactly.

A motion is its parameters and initial data as strings; where theta and u1 are not among them, they
are those that put K along the fixed axis z.
"""

from __future__ import annotations

from collections.abc import Iterator

Data = dict[str, str]
RADII = {"outer": "2", "inner": "-3", "shell": "-1/2"}
MOMENTS = {"outer": "2/5", "inner": "2/5", "shell": "3/5"}
"""Of a shell 2 A >= M R2^2."""
POWERS = (2, 4, 6, 8, 10, 12)
SMALL = {j: f"1/10**{j}" for j in POWERS}
ORDINARY = {
    "R1": "2", "R2": "1", "M": "1", "A": "2/5", "k": "3", "u": "1", "v": "1/3", "u1": "6/5",
    "v1": "1/5", "theta": "1", "s": "1/5", "tau": "3/10", "n": "3/2",
}  # fmt: skip

# rolling, class of the trace on the ball: k, cos u, s, tau, n, and theta, u1, v1 where K is not
# along z.  Found by drawing data at random.
CLASSES = """
outer A: -3 3/5 6/5 19/10 0; 9/5 13/5 -7/10
outer B: 6 4/5 -3/10 11/10 -5/2
outer C1: 2 -7/25 19/10 3/2 -1/5
outer C2: 4 -7/25 0 8/5 -21/10; 8/5 3/2 1/10
outer D1: -3 7/25 0 0 12/5; -3/5 19/10 -1/5
outer D2: 4 5/13 0 0 21/10
outer D3: -2 8/17 0 0 60/17
outer E1: -5 3/5 -1713/560 9/5 -12/5
outer E2: -2 -5/13 -2141/455 4/5 -9/5; 11/5 23/10 19/10
outer E1+E2: -2 4/5 -207/56 39/10 6
inner A: 3 20/29 -23/10 3/10 -5/2; 23/10 12/5 9/5
inner B: -5 5/13 -1/5 6/5 -3
inner C1: -2 20/29 3/10 9/10 1; -7/10 6/5 2
inner C2: -3 7/25 -1/2 7/5 5/2
inner D1: -2 -5/13 0 0 13/10; 27/10 11/5 -6/5
inner D2: -3 3/5 0 0 -6/5
inner D3: 2 3/5 0 0 -2
inner E1: -3 -3/5 -236/105 1/10 -29/10
inner E2: -3 7/25 -1336/315 4/5 -3/10; 1/2 7/5 1/10
inner E1+E2: -3 8/17 -275/119 17/5 40/17
shell A: 2 5/13 7/5 7/5 1; -17/10 7/10 27/10
shell B: 3 8/17 -3/10 3/10 -21/10
shell C1: -2 5/13 0 8/5 -11/5
shell C2: 2 5/13 0 8/5 11/5; 1 2 -1/2
shell D1: 3 4/5 0 0 9/10; 17/10 13/10 17/10
shell D2: 4 5/13 0 0 -14/5
shell D3: 2 20/29 0 0 200/87
shell E1: 4 8/17 -387/340 17/10 -2
shell E2: 2 5/13 -99/130 9/10 14/5; -3/5 9/5 -7/5
shell E1+E2: 4 -3/5 -1/3 27/5 -4
"""

# The same of motions near steady rolling, tau to be put in: unstable, and stable.
UNSTABLE = {
    "outer": "-3 20/29 -14/5 tau 1096/1281; -12/5 21/10 3/5",
}
STABLE = {
    "outer": "-5 7/25 -3/2 tau 119/232; 1 9/10 -7/10",
    "inner": "-5 -3/5 -19/10 tau -19/1280; -1 6/5 -7/5",
    "shell": "6 -3/5 -13/5 tau -78/365; -5/2 6/5 19/10",
}

# The trace meets the pole of the fixed sphere, K along z.
THROUGH = {
    "outer": "3 4/5 191/112 sqrt(6431/12544) -3/4",
    "inner": "3 5/13 5272/4095 sqrt(64388/2395575) 67/26",
    "shell": "3 7/25 31/30 sqrt(91/45) -1/10",
}

# Motions for ever towards steady rolling, or towards the pole of the ball: double roots.
ASYMPTOTIC = """
outer loop: 2 4/5 12753/7420 sqrt(780939/2202256) -2157/1060; 7/10 6/5 -2/5
inner pole: 4 8/17 8164/2975 sqrt(7689104/8850625) -12/5
shell pole: 6 20/29 -375/406 sqrt(353475/41209) 5/2; -1 2 1/5
"""


def _ordinary(**changed: str) -> Data:
    return {**ORDINARY, **changed}


def _read(roll: str, text: str) -> Data:
    own, _, outer = text.partition(";")
    names = ("k", "u", "s", "tau", "n")
    found = {**dict(zip(names, own.split(), strict=True)), "R1": RADII[roll], "v": "1/3"}
    found |= {"R2": ORDINARY["R2"], "M": ORDINARY["M"], "A": MOMENTS[roll]}
    if outer:
        found |= dict(zip(("theta", "u1", "v1"), outer.split(), strict=True))
    return {**found, "u": f"acos({found['u']})"}


def _table(text: str) -> dict[str, Data]:
    found = {}
    for line in text.strip().splitlines():
        name, _, data = line.partition(": ")
        found[name] = _read(name.partition(" ")[0], data)
    return found


def classes() -> dict[str, Data]:
    """A motion of each class on the ball, named by its rolling and the class."""
    return _table(CLASSES)


def asymptotic() -> dict[str, Data]:
    """Motions whose quartic has a double root at one end; they have no period."""
    return _table(ASYMPTOTIC)


def hard() -> dict[str, Data]:
    """The hard cases of the closed form."""
    found = {f"{about}, {size}": data for about, size, data in _families()}
    for roll, radius in RADII.items():
        found[f"no gyroscope, {roll}"] = _ordinary(R1=radius, A=MOMENTS[roll], k="0")
    for j in (3, 5, 7, 9):
        found[f"fast gyroscope, k = 1e{j}"] = _ordinary(k=f"10**{j}")
    upright = {n: x for n, x in ORDINARY.items() if n not in ("theta", "u1")}
    for j, e in SMALL.items():
        touching = {**upright, "tau": "0", "s": f"15/7*sin(1) + {e}"}
        found[f"near the pole of the sphere, 1e-{j}"] = touching
    for roll, text in THROUGH.items():
        found[f"through the pole of the sphere, {roll}"] = _read(roll, text)
    return found


def _families() -> Iterator[tuple[str, str, Data]]:
    for j, e in SMALL.items():
        small, large = f"1e-{j}", f"1e{j}"
        yield "near the pole of the ball", small, _ordinary(u=e, s="1/2", tau="0")
        yield "start near a turning point", small, _ordinary(tau=e)
        yield "slow gyroscope, outer", f"k = {small}", _ordinary(k=e)
        yield "slow gyroscope, inner", f"k = -{small}", _ordinary(k=f"-{e}", R1="-3")
        yield "nearly a plane, outer", f"R1 = {large}", _ordinary(R1=f"10**{j}")
        yield "nearly a plane, inner", f"R1 = -{large}", _ordinary(R1=f"-10**{j}")
        yield "nearly equal radii", f"-R1 - R2 = {small}", _ordinary(R1=f"-1 - {e}")
        for roll, text in UNSTABLE.items():
            yield f"near a separatrix, {roll}", small, _read(roll, text.replace("tau", e))
        for roll, text in STABLE.items():
            yield f"tiny nutation, {roll}", small, _read(roll, text.replace("tau", e))
