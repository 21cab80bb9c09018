"""``voronec derive``: the equations of motion, and what kind of system they belong to."""

from __future__ import annotations

import shutil
from argparse import Namespace
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from voronec.cli.output import columns, plain, print_json
from voronec.cli.subject import resolve
from voronec.errors import DefinitionError, EngineLimit, VoronecError

if TYPE_CHECKING:
    from voronec.analysis import Claim
    from voronec.equations import VoronecEquations
    from voronec.reduction import Reduction

__all__ = ["execute"]


def execute(arguments: Namespace) -> int:
    """Derive and print; ``--latex``, ``--python`` and ``--c`` print source only."""
    from voronec.analysis import check_claims
    from voronec.equations import derive

    system, _ = resolve(arguments.system)
    eqs = derive(system)
    for language in ("latex", "python", "c"):
        if getattr(arguments, language):
            text = getattr(eqs, language)()
            print_json({language: text}) if arguments.json else print(text.rstrip("\n"))
            return 0
    reduction = _reduction(eqs)
    claims = check_claims(eqs)
    if arguments.json:
        found = [
            {"kind": c.kind, "name": c.name, "verdict": c.verdict.status, "why": c.verdict.method}
            for c in claims
        ]
        print_json(eqs.as_dict() | _descent_data(reduction) | {"claims": found})
    else:
        print("\n".join([*_lines(eqs), *_descent(eqs, reduction), *_claims(claims)]))
    return 1 if any(claim.verdict.refuted for claim in claims) else 0


def _claims(claims: Sequence[Claim]) -> list[str]:
    rows = [[claim.kind, claim.name, claim.verdict.status] for claim in claims]
    return ["", "claims", *columns(rows, "  ")] if rows else []


def _reduction(eqs: VoronecEquations) -> Reduction | VoronecError | None:
    """The descent to the invariants that a system declares; the refusal where there is none."""
    if not eqs.system.invariants:
        return None
    from voronec.reduction import descend

    try:
        return descend(eqs)
    except (DefinitionError, EngineLimit) as refusal:
        return refusal


def _descent_data(reduction: Reduction | VoronecError | None) -> dict[str, Any]:
    if reduction is None:
        return {}
    if isinstance(reduction, VoronecError):
        return {"descent": {"refused": str(reduction)}}
    return {"descent": reduction.as_dict()}


def _descent(eqs: VoronecEquations, reduction: Reduction | VoronecError | None) -> list[str]:
    if reduction is None:
        return []
    if isinstance(reduction, VoronecError):
        verdict = "undecided" if isinstance(reduction, EngineLimit) else "refuted"
        return ["", f"descent to {', '.join(eqs.system.invariants)}: {verdict}", f"  {reduction}"]
    size = range(len(eqs.velocities))
    names = ", ".join(map(str, reduction.invariants))
    lines = ["", f"descent to {names}: closed equations, proved"]
    pairs = zip(reduction.invariants, reduction.definitions, strict=True)
    rows = [(str(g), plain(definition)) for g, definition in pairs]
    rows += [("0", plain(relation)) for relation in reduction.relations]
    mass = [(i, j, reduction.mass[i, j]) for i in size for j in size if i <= j]
    rows += [(f"mass[{i + 1}, {j + 1}]", plain(e)) for i, j, e in mass if e != 0]
    rows += [(f"force[{i + 1}]", plain(reduction.force[i])) for i in size]
    rates = zip(reduction.invariants, reduction.rates, strict=True)
    return lines + _equations(rows + [(f"d{g}/dt", plain(rate)) for g, rate in rates])


def _lines(eqs: VoronecEquations) -> list[str]:
    system = eqs.system
    lines = [f"{system.name}: {system.title}" if system.title else system.name, ""]
    lines += columns(_facts(eqs))
    if not eqs.in_normal_form:
        return [
            *lines,
            "",
            f"too large for the exact normal form: a program of {eqs.operations} operations, "
            "printed by --python or --c",
        ]
    lines += ["", "motion of the coordinates"]
    rates = zip(eqs.coordinates, eqs.rates, strict=True)
    lines += _equations((f"d{plain(q)}/dt", plain(rate)) for q, rate in rates)
    lines += ["", f"equations of motion, mass * d({_names(eqs)})/dt = force", *_motion(eqs)]
    if eqs.has_coordinate_frame:
        lines += ["", "curvature", *_curvature(eqs)]
    return lines


def _facts(eqs: VoronecEquations) -> list[list[str]]:
    count = len(eqs.system.constraints)
    whole = ", ".join(f"{i + 1}" for i in eqs.integrable)
    growth = "(" + ", ".join(map(str, eqs.growth)) + ")"
    timed = ", the time included" if eqs.distribution.timed else ""
    rows = [["kind", eqs.kind]]
    rows.append(["growth vector", f"{growth} of {eqs.distribution.dimension}{timed}"])
    if count:
        rows.append(["integrable constraints", whole or f"none of {count}"])
    frame = eqs.system.frame
    if frame is None:
        return [*rows, ["velocities", _names(eqs)]]
    pairs = zip(frame.velocities, frame.expressions, strict=True)
    return [*rows, *(["quasi-velocity", f"{plain(v)} = {plain(e)}"] for v, e in pairs)]


def _motion(eqs: VoronecEquations) -> list[str]:
    """The rows of mass * vdot = force; where they are too wide, the entries one by one."""
    size = range(len(eqs.velocities))
    rates = [f"d{plain(v)}/dt" for v in eqs.velocities]
    left = [" + ".join(_terms(eqs.mass.row(i), rates)) or "0" for i in size]
    rows = _equations(zip(left, map(plain, eqs.force), strict=True))
    if all(len(row) < shutil.get_terminal_size((100, 24)).columns for row in rows):
        return rows
    mass = [(i, j, eqs.mass[i, j]) for i in size for j in size if i <= j and eqs.mass[i, j] != 0]
    pairs = [(f"mass[{i + 1}, {j + 1}]", plain(e)) for i, j, e in mass]
    return _equations(pairs + [(f"force[{i + 1}]", plain(eqs.force[i])) for i in size])


def _terms(row: Any, rates: list[str]) -> Iterator[str]:
    for entry, rate in zip(row, rates, strict=True):
        if entry == 1:
            yield rate
        elif entry != 0:
            yield f"({plain(entry)})*{rate}" if entry.is_Add else f"{plain(entry)}*{rate}"


def _names(eqs: VoronecEquations) -> str:
    return ", ".join(plain(v) for v in eqs.velocities)


def _equations(pairs: Any) -> list[str]:
    return columns(([left, "= " + right] for left, right in pairs), "  ")


def _curvature(eqs: VoronecEquations) -> list[str]:
    """The components A_ij^(nu) and A_i^(nu) that do not vanish, by the names of coordinates."""
    base = [plain(q) for q in eqs.system.fibration.base]
    size, found = range(len(base)), []
    for nu, fibre in enumerate(map(plain, eqs.system.fibration.fibre)):
        entries = [(i, j, eqs.curvature[nu, i, j]) for i in size for j in size if i < j]
        found += [(f"A^{fibre}[{base[i]}, {base[j]}]", plain(e)) for i, j, e in entries if e != 0]
        moving = [(i, eqs.curvature.time[nu, i]) for i in size]
        found += [(f"A^{fibre}[{base[i]}]", plain(e)) for i, e in moving if e != 0]
    return _equations(found) or ["  vanishes"]
