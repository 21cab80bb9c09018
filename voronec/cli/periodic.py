"""``voronec periodic``: a periodic orbit, or a family of them, with multipliers."""

from __future__ import annotations

import re
from argparse import Namespace

from voronec.algebra.columns import columns
from voronec.cli.output import answer, progress, progress_line
from voronec.cli.values import BETWEEN, finite, motion_of, name_and_value, outputs_of, tolerance


def execute(arguments: Namespace) -> int:
    """Look for the orbit near the start, follow its family, and report."""
    tol = tolerance(arguments.tol)
    period = None if arguments.period is None else finite(arguments.period, "--period")
    along, to = None, None
    if arguments.along is not None:
        along, value = name_and_value(arguments.along, "--along", "NAME=VALUE")
        to = finite(value, "--along")
    variables = outputs_of(arguments.variables)
    hold = [part.strip() for part in re.split(BETWEEN, arguments.hold or "") if part.strip()]
    system, given = motion_of(arguments)
    from voronec.dynamics.periodic import periodic

    with progress_line(f"{system.name}: looking for an orbit ..."):
        family = periodic(
            system, period=period, variables=variables, hold=hold, along=along, to=to,
            points=arguments.points, segments=arguments.segments, tol=tol,
            progress=lambda share: progress(f"{system.name}: {share:.0%} of the family"), **given,
        )  # fmt: skip
    data = {**family.as_dict(), "scene": given["scene"], "along": along}
    lines = [f"{system.name}: a periodic orbit", *family.orbits[0].lines()]
    if along is not None:
        rows = [[f"{along} = {orbit[along]:.8g}", f"period {orbit.period:.10g}", orbit.stability,
                 f"largest multiplier {abs(orbit.multipliers).max(initial=0.0):.6g}"]
                for orbit in family]  # fmt: skip
        lines = [repr(family), *columns(rows)]
        for c in family.bifurcations:
            doubles = ": the period doubles" if c.at == -1 else ""
            lines.append(f"a multiplier passes {c.at} at {along} = {c.value:.12g}{doubles}")
    answer(arguments.json, lambda: data, lines)
    return 0
