"""The page of the hard cases: definitions, the table, and what is hard about each case.

Findings are lines of text, data, and rows of the page.
"""

from __future__ import annotations

from collections.abc import Sequence
from statistics import median
from typing import Any

from voronec.accuracy.hard.case import HardCase
from voronec.accuracy.hard.trial import CaseResult, Trial
from voronec.motion.methods import METHODS

__all__ = ["cells", "data", "head", "lines", "page", "summary", "tally"]


TOP = """# Hard cases

`voronec hard` runs every integrator on motions that are hard for numbers, and holds each against a
reference. This page is written by `tools/build.py hard-cases`; times are of the machine it ran on.

## What the columns say

- **error**: the largest difference from the reference over all outputs and instants, relative to
  the largest value of the output along the motion (absolute, where that is below 1e-20).
- **condition**: the largest condition number of the case,

      kappa(t) = 1 + sum_p |do(t)/dp| |p| / |o|
                   + max over s <= t of sum_i |do(t)/dx (t) Phi(t, s)|_i X_i / |o|,

  where Phi is the propagator of the variational equations, o an output, |o| its largest value, p
  the parameters and X_i the size of a state: an angle's largest value, but at least one radian; of
  other coordinates, and of velocities, the largest of them all. The second sum runs over errors
  made at any instant s of the grid: rounding errors are made all along, not only at the start.
- **roundings**: error / (u kappa) at its worst, u = 2^-53: the *error made*, in units of the last
  place, with the *error grown* taken away. In a chaotic motion the error is large and this is not.
- **drift**: the largest relative drift of a declared integral.
- **verdict**: *met*, the error is below max(1e-10, 100 u kappa) in every output at every instant;
  *missed*, it is not; *refused*, with the reason; *kept* and *lost*, past the horizon, where
  100 u kappa exceeds 1 in every output and no double determines the motion: there the integrals
  must hold to 1e-12.

Each method is asked for the finest tolerance that does it good, so that its best is seen: heyoka
1e-16, scipy's DOP853 2.3e-14, LSODA 1e-13, flint 1e-25. What the tool chooses by itself at 1e-16
is marked *(auto)*; it must meet the figure or refuse, and the others are shown as what they are.
*(default)* is the same choice at `tol=1e-13`, which is what a caller gets who asks for nothing. Its
local errors are a thousand roundings, so on an ill-conditioned or a long motion it may miss a
figure that is counted in roundings: **where the condition number is above 1e4, or the span above
1e4 units, give `tol=1e-16`**; it took up to twice
the time here.

A condition number says what any method in doubles must expect, so "met" with a large one means
that the digits are not in the data, not that they were kept: *near-a-separatrix* has four digits
left, and *tiny-nutation* seven. A row is well served when its *roundings* are of order one.
Near a separatrix errors of the data and errors made on the way are different things: coming back
to the saddle, the motion forgets the former and magnifies the latter, so both are counted.
"""

METHODS_TEXT = """## What each method does

Of *heyoka*, the cases are counted in which it was the tool's own choice. Roundings are errors in
units of u kappa.
"""


METHODS_READ = """
- **heyoka** (Taylor, order about 20): errors of a few roundings nearly everywhere. Passing
  a pole of the angles costs up to two digits more. States on which nothing depends (quadratures,
  angles that turn round) are kept small during the steps, so that they do not
  loosen its step control.
- **scipy** (DOP853): its tolerance has a floor of 2.3e-14, so a hundred or a thousand roundings are
  usual; that is enough on most cases, and not on *chaotic-ball* and *tiny-nutation*.
- **lsoda**: made for stiff equations, which these are not; it loses three to five digits, and
  drifts. Take it only where damping makes the equations stiff.
- **flint** (any precision): what is left of the error is the rounding of the answer. Slow, so
  it is shown on one case only: it keeps all digits of *near-a-separatrix*.
- **closed-form** ([not an integrator](closed-form.md), where a system declares its motion): nothing
  accumulates; what is left is the rounding of outputs such as u - 1.

From *long* to *very-long*, ten times the time, drift at the default tolerance grows tenfold, which
is linear: the error of a step has a sign there; at 1e-16 it is a twentieth of that, and
grows 7.6-fold.
"""


def page(findings: Sequence[CaseResult]) -> str:
    """The page as Markdown."""
    parts = [TOP, f"Of {summary(findings)}.\n", "## Method against case\n", _table(findings)]
    parts += ["", METHODS_TEXT, _grid([list(TALLY), *tally(findings)]), METHODS_READ]
    parts += ["## What is hard\n", _cases(findings)]
    return "\n".join(parts)


def _table(findings: Sequence[CaseResult]) -> str:
    rows = [["case", *HEADINGS]]
    for finding in findings:
        link = f"[{finding.case.name}](#{finding.case.name})"
        rows += [[link if i == 0 else "", *cells(t)] for i, t in enumerate(finding.trials)]
    return _grid(rows)


def _grid(rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown, headings first."""
    ruled = [rows[0], ["---"] * len(rows[0]), *rows[1:]]
    return "\n".join(f"| {' | '.join(_plain(cell) for cell in row)} |" for row in ruled)


def _cases(findings: Sequence[CaseResult]) -> str:
    return "\n".join(line for finding in findings for line in _case(finding))


def _case(finding: CaseResult) -> list[str]:
    case, known = finding.case, finding.reference
    start, end = case.scene.times
    settings = [f"{k} = {x}" for k, x in {**case.scene.parameters, **case.scene.initial}.items()]
    made = "No reference: only a refusal is right."
    if known is not None:
        made = f"Reference: {known.provenance}; the two agree to {known.accuracy:.0e}."
    growth = " Errors grow exponentially." if case.chaotic else ""
    return [
        f"### {case.name}\n",
        f"{case.hard}{growth}\n",
        f"- [{case.system}](systems/{case.system}.md), t from {start} to {end}, outputs "
        f"{', '.join(f'`{o}`' for o in case.scene.outputs)}",
        f"- {', '.join(f'`{s}`' for s in settings)}",
        f"- {made}\n",
    ]


def _plain(cell: str) -> str:
    return cell.replace("|", "\\|")


HEADINGS = ("method", "error", "condition", "roundings", "drift", "seconds", "verdict")
VERDICTS = ("met", "kept", "refused", "missed", "lost")
TALLY = ("method", "cases", *VERDICTS, "roundings, median", "roundings, worst", "missed or lost")
WIDTHS = (16, 9, 9, 9, 9, 9)
"""Of columns of the table in a terminal; the last has the rest of the line."""


def cells(trial: Trial) -> list[str]:
    """One trial under ``HEADINGS``; a refusal has its reason in place of numbers."""
    own = trial.method in ("auto", "default") and trial.chosen
    method = f"{trial.chosen} ({trial.method})" if own else trial.method
    told = f"{trial.verdict}: {trial.reason}" if trial.reason else trial.verdict
    if trial.verdict == "missed" and trial.worst:
        told += f" in {trial.worst}"
    numbers = (trial.error, trial.condition, trial.roundings, trial.drift)
    return [method, *(_show(x, ".1e") for x in numbers), _show(trial.seconds, ".2g"), told]


def _show(x: float, digits: str) -> str:
    return "-" if x != x else format(x, digits)


def head(cases: Sequence[HardCase]) -> str:
    """The line above the table."""
    return _align(_width(cases), "case", HEADINGS)


def lines(finding: CaseResult, cases: Sequence[HardCase]) -> list[str]:
    """The rows of one case, aligned with those of the others."""
    width = _width(cases)
    return [_align(width, finding.case.name, cells(t)) for t in finding.trials]


def _width(cases: Sequence[HardCase]) -> int:
    return max((len(c.name) for c in cases), default=0)


def _align(width: int, name: str, row: Sequence[str]) -> str:
    inner = (w.ljust(n) for w, n in zip(row, WIDTHS, strict=False))
    return "  ".join([name.ljust(width), *inner, row[-1]])


def data(finding: CaseResult) -> dict[str, Any]:
    """One case for JSON."""
    case, known = finding.case, finding.reference
    return {
        "case": case.name,
        "system": case.system,
        "hard": case.hard,
        "chaotic": case.chaotic,
        "times": [float(t) for t in case.scene.times],
        "reference": None if known is None else known.provenance,
        "agreed": None if known is None else known.accuracy,
        "good": finding.good,
        "trials": [t.as_dict() for t in finding.trials],
    }


def summary(findings: Sequence[CaseResult]) -> str:
    """What came out, in a line."""
    own = [t for f in findings for t in f.trials if t.automatic]
    counts = {v: sum(t.verdict == v for t in own) for v in ("met", "kept", "refused")}
    wrong = [t.case for t in own if not t.good]
    if not own:
        return "the tool's own choice took no part"
    told = ", ".join(f"{n} {v}" for v, n in counts.items() if n)
    silent = f"silently wrong: {', '.join(wrong)}" if wrong else "nothing silently wrong"
    return f"the tool's own choice on {len(own)} cases: {told or 'none good'}; {silent}"


def tally(findings: Sequence[CaseResult]) -> list[list[str]]:
    """For every method: on how many cases it was tried, and what came out, with the worst."""
    groups: dict[str, list[Trial]] = {}
    for trial in (t for f in findings for t in f.trials):
        groups.setdefault(trial.method, []).append(trial)
        if trial.automatic and trial.chosen in METHODS:
            groups.setdefault(trial.chosen, []).append(trial)
    rows = []
    for method in ("auto", "default", *METHODS):
        found = groups.get(method, [])
        counts = [sum(t.verdict == v for t in found) for v in VERDICTS]
        made = [t.roundings for t in found if t.roundings == t.roundings]
        numbers = (f"{median(made):.1e}", f"{max(made):.1e}") if made else ("-", "-")
        missed = ", ".join(t.case for t in found if t.verdict in ("missed", "lost"))
        if found:
            rows.append([method, *map(str, (len(found), *counts)), *numbers, missed or "-"])
    return rows
