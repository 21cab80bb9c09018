"""``voronec exponents``: the Lyapunov exponents of a motion, with error bars."""

from __future__ import annotations

from argparse import Namespace

from voronec.cli.output import answer, progress_line, warn
from voronec.cli.values import finite, motion_of, outputs_of, tolerance


def execute(arguments: Namespace) -> int:
    """Follow the motion and report; 1 where an exponent has not settled."""
    tol = 1e-9 if arguments.tol is None else tolerance(arguments.tol)
    bar, until = (
        None if text is None else finite(text, option)
        for text, option in ((arguments.bar, "--bar"), (arguments.until, "--until"))
    )
    variables = outputs_of(arguments.variables)
    system, given = motion_of(arguments)
    from voronec.dynamics.exponents import exponents

    with progress_line(f"{system.name}: following the motion ..."):
        spectrum = exponents(
            system, variables=variables, count=arguments.count, bar=bar, until=until, tol=tol,
            **given,
        )  # fmt: skip
    if spectrum.interrupted:
        raise KeyboardInterrupt
    data = {
        "system": system.name, "scene": given["scene"], "variables": list(spectrum.variables),
        "exponents": spectrum.values[0].tolist(), "bars": spectrum.bars[0].tolist(),
        "settled": bool(spectrum.is_settled[0]), "bar_asked": spectrum.bar,
        "zeros": int(spectrum.zeros[0]), "zeros_at_least": int(spectrum.least_zeros[0]),
        "constants": list(spectrum.constants), "sum": float(spectrum.values[0].sum()),
        "mean_divergence": float(spectrum.divergence[0]), "drift": float(spectrum.drift[0]),
        "reversal": spectrum.reversal and list(spectrum.reversal), "time": float(spectrum.time[0]),
        "seconds": spectrum.seconds,
    }  # fmt: skip
    lines = [f"{system.name}: exponents in {', '.join(spectrum.variables)}", *spectrum.lines(0)]
    answer(arguments.json, lambda: data, lines)
    if not spectrum.is_settled[0]:
        warn("not all exponents have settled; give --until a longer time, or --bar a larger one")
        return 1
    return 0
