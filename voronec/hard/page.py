"""The page of the hard cases: definitions, the table, and what is hard about each case."""

from __future__ import annotations

from collections.abc import Sequence

from voronec.hard.run import Finding
from voronec.hard.table import HEADINGS, cells, summary

__all__ = ["page"]

TOP = """# Hard cases

`voronec hard` runs every integrator on motions that are hard for numbers, and holds each against a
reference. This page is written by `tools/build_hard_cases.py`; times are of the machine it ran on.

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

The integrator that the tool chooses by itself is marked *(auto)*. It must meet the figure or
refuse; the others are shown as what they are. Each is asked for the finest tolerance that does it
good, so that its best is seen.
"""


def page(findings: Sequence[Finding]) -> str:
    """The page as Markdown."""
    parts = [TOP, f"Of {summary(findings)}.\n", "## Method against case\n", _table(findings)]
    parts += ["\n## What is hard\n", _cases(findings)]
    return "\n".join(parts)


def _table(findings: Sequence[Finding]) -> str:
    rows = [["case", *HEADINGS], ["---"] * (1 + len(HEADINGS))]
    for finding in findings:
        link = f"[{finding.case.name}](#{finding.case.name})"
        rows += [[link if i == 0 else "", *cells(t)] for i, t in enumerate(finding.trials)]
    return "\n".join(f"| {' | '.join(_plain(cell) for cell in row)} |" for row in rows)


def _cases(findings: Sequence[Finding]) -> str:
    return "\n".join(line for finding in findings for line in _case(finding))


def _case(finding: Finding) -> list[str]:
    case, known = finding.case, finding.reference
    start, end = case.scene.times
    settings = [f"{k} = {x}" for k, x in {**case.scene.parameters, **case.scene.initial}.items()]
    made = "No reference: only a refusal is right."
    if known is not None:
        made = f"Reference: {known.made}; the two agree to {known.agreed:.0e}."
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
