"""How long families of steady motions take, with their spectra and critical values, and how exact
they are.

python tools/bench.py dynamics

Seconds are those of the clock, in a new process for each row, from loading the system on; models
that are kept on disk are left out of account by an empty cache.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from time import perf_counter, process_time
from typing import Any

import mpmath as mp

import voronec as vo


def motion_of(name: str, at: dict[str, Any], starts: int = 20) -> vo.SteadyMotion:
    """A motion with these values, one that moves where there is one."""
    found = vo.steady(vo.load(name), at=at, starts=starts)
    return next((m for m in found if not m.is_rest), found[0])


def bicycle() -> str:
    """The bicycle: hands-free turns with spectra; straight ahead 11 speeds and critical speeds."""
    turns = motion_of("bicycle", {"delta": "1/2"}, 5).along("delta", (0.02, 1.2), count=99)
    family = motion_of("bicycle", {"phi": 0, "delta": 0, "speed": 5}, 5).along("speed", (0, 10))
    spectra = [family.at(speed).spectrum for speed in range(11)]
    weave, capsize = (c.value for c in family.critical)
    gap = max(abs(weave - 4.29238253634111), abs(capsize - 6.02426201538837))
    return (
        f"{len(turns)} turns of {turns.eigenvalues.shape[1]} eigenvalues, {len(spectra)} speeds; "
        f"critical speeds off the published ones by {gap:.1e}"
    )


def disc() -> str:
    """The critical spin of the disc, in digits and exactly."""
    motion = motion_of("falling-disc", {"gamma3": 0, "q": 0, "s": 2})
    (critical,) = motion.along("s", (0, 3), hold="q").critical
    exact = vo.steady(motion.system, at={"gamma3": 0, "q": 0}, starts=20, exact=True)
    with mp.workdps(30):
        gap = abs(critical.exact - 1 / mp.sqrt(3))
    return f"off by {mp.nstr(gap, 2)}; {exact.families[-1].conditions['real'][-1]}"


def routh_sphere() -> str:
    """The critical spin of Routh's sphere upright, in digits and exactly."""
    motion = motion_of("routh-sphere", {"gamma3": 1, "omega3": 2}, 5)
    (critical,) = motion.along("omega3", (0, 2)).critical
    exact = vo.steady(motion.system, at={"gamma1": 0, "gamma3": 1}, starts=5, exact=True)
    ends = exact.families[0].ranges("omega3")
    with mp.workdps(30):
        gap = abs(critical.exact - mp.sqrt(mp.mpf(1472) / 1000) * 10 / 17)
    return f"off by {mp.nstr(gap, 2)}; {ends[-1].low}"


def rattleback() -> str:
    """The two thresholds of the rattleback."""
    motion = motion_of("rattleback", {"gamma3": 1, "omega3": "1/2"})
    low, high = motion.along("omega3", (-2, 2)).critical
    return f"{mp.nstr(low.exact, 15)}, {mp.nstr(high.exact, 15)}"


def suslov() -> str:
    """Where the turning of Suslov's body changes its stability, in numbers and exactly."""
    (critical,) = motion_of("suslov", {"omega2": 1}).along("omega2", (-2, 2)).critical
    exact = vo.steady(vo.load("suslov"), starts=20, exact=True)
    return f"{critical.value:g}; {exact.families[0].conditions['real'][0]}"


ROWS: dict[str, Callable[[], str]] = {
    row.__name__: row for row in (bicycle, disc, routh_sphere, rattleback, suslov)
}


def main() -> int:
    """Measure all rows, or, as a process of its own, one."""
    if len(sys.argv) > 1:
        begin, busy = perf_counter(), process_time()
        said = ROWS[sys.argv[1]]()
        print(json.dumps([perf_counter() - begin, process_time() - busy, said]))
        return 0
    for name, row in ROWS.items():
        with tempfile.TemporaryDirectory() as cache:
            words = [sys.executable, "tools/bench.py", "dynamics", name]
            here = {**os.environ, "XDG_CACHE_HOME": cache}
            done = subprocess.run(words, env=here, capture_output=True, text=True, check=True)
        seconds, busy, said = json.loads(done.stdout)
        print(f"{seconds:6.2f} s ({busy:.2f} s of computing)  {row.__doc__} {said}")
    return 0
