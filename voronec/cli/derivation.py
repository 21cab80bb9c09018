"""``voronec derive``: the equations of motion, and what kind of system they belong to."""

from __future__ import annotations

import shutil
from argparse import Namespace
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from voronec.cli.output import columns, plain, print_json
from voronec.cli.subject import resolve
from voronec.equations.printers import PRINTERS
from voronec.errors import DefinitionError, EngineLimit, VoronecError

if TYPE_CHECKING:
    from voronec.equations.reduction import Reduction
    from voronec.equations.vector_field import Motions
    from voronec.equations.voronec_equations import VoronecEquations
    from voronec.proof.claims import Claim

__all__ = ["execute"]


def execute(arguments: Namespace) -> int:
    """Derive and print; the options of ``PRINTERS`` print source only."""
    from voronec.equations.vector_field import Motions
    from voronec.equations.voronec_equations import derive
    from voronec.proof.claims import check_claims

    system, _ = resolve(arguments.system)
    eqs = derive(system)
    if arguments.store is not None:
        return _store(eqs, Path(arguments.store), arguments.json)
    for name, printer in PRINTERS.items():
        if getattr(arguments, name):
            text = printer.text(eqs)
            print_json({name: text}) if arguments.json else print(text.rstrip("\n"))
            return 0
    motions = Motions(eqs)
    reduction = _reduction(motions)
    claims = check_claims(motions)
    if arguments.json:
        found = {"claims": [_claim_data(claim) for claim in claims]}
        print_json(eqs.as_dict() | _descent_data(reduction) | found)
    else:
        print("\n".join([*_lines(eqs), *_descent(eqs, reduction), *_claims(claims)]))
    return 1 if any(claim.verdict.refuted for claim in claims) else 0


def _store(eqs: VoronecEquations, path: Path, as_json: bool) -> int:
    """Write the derivation into a file, for ``voronec compare``; an old one is replaced."""
    from voronec.declaration.whole_files import replace_file
    from voronec.proof.comparison import Derived

    replace_file(path, Derived.of(eqs).text())
    if as_json:
        print_json({"system": eqs.system.name, "file": str(path)})
    else:
        print(f"wrote {path}; now try: voronec compare {path} {eqs.system.name}")
    return 0


def _claims(claims: Sequence[Claim]) -> list[str]:
    rows = [[claim.kind, claim.name, claim.standing] for claim in claims]
    return ["", "claims", *columns(rows, "  ")] if rows else []


def _claim_data(claim: Claim) -> dict[str, Any]:
    data = {
        "kind": claim.kind,
        "name": claim.name,
        "verdict": claim.verdict.status,
        "why": claim.verdict.method,
        "level": claim.level,
        "seconds": round(claim.seconds, 3),
    }
    if claim.printed is not None:
        data |= {"printed": claim.printed.status, "source": claim.source}
    return data | ({"reason": claim.reason} if claim.reason else {})


def _reduction(motions: Motions) -> Reduction | VoronecError | None:
    """The descent to the invariants that a system declares; the refusal where there is none."""
    if not motions.system.invariants:
        return None
    try:
        return motions.reduction
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
    more = ", ..." if eqs.distribution.cut else ""
    growth = "(" + ", ".join(map(str, eqs.growth)) + more + ")"
    timed = ", the time included" if eqs.distribution.timed else ""
    rows = [["kind", eqs.kind]]
    rows.append(["growth vector", f"{growth} of {eqs.distribution.dimension}{timed}"])
    if count:
        none = "undecided" if eqs.distribution.cut else f"none of {count}"
        rows.append(["integrable constraints", whole or none])
    frame = eqs.system.frame
    if frame is None or frame.is_group:
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
    base, fibres = eqs.definition.split
    size, found = range(len(base)), []
    for nu, fibre in enumerate(fibres):
        entries = [(i, j, eqs.curvature[nu, i, j]) for i in size for j in size if i < j]
        found += [(f"A^{fibre}[{base[i]}, {base[j]}]", plain(e)) for i, j, e in entries if e != 0]
        moving = [(i, eqs.curvature.time[nu, i]) for i in size]
        found += [(f"A^{fibre}[{base[i]}]", plain(e)) for i, e in moving if e != 0]
    return _equations(found) or ["  vanishes"]
