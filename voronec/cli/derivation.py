"""``voronec derive``: the equations of motion, and what kind of system they belong to."""

from __future__ import annotations

import shutil
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from voronec.algebra.columns import columns
from voronec.cli.output import answer, plain, progress, progress_line
from voronec.cli.subject import resolve
from voronec.equations.printers import PRINTERS
from voronec.errors import DefinitionError, EngineLimit, VoronecError

if TYPE_CHECKING:
    from voronec.equations.motions import Motions
    from voronec.equations.reduction import Reduction
    from voronec.equations.voronec_equations import VoronecEquations
    from voronec.proof.claims import Claim


def execute(arguments: Namespace) -> int:
    """Derive and print; the options of ``PRINTERS`` print source only."""
    from voronec.equations.voronec_equations import derive

    chosen = next((name for name in PRINTERS if getattr(arguments, name)), None)
    _require_program(chosen, arguments.jacobian)
    system, _ = resolve(arguments.system)
    with progress_line(f"{system.name}: the equations of motion"):
        return _execute(arguments, derive(system), chosen)


def _execute(arguments: Namespace, eqs: VoronecEquations, chosen: str | None) -> int:
    """Write what is asked for."""
    from voronec.equations.motions import Motions
    from voronec.equations.voronec_equations import derivation_parts
    from voronec.proof.claims import check_claims

    if arguments.store is not None:
        return _store(eqs, Path(arguments.store), arguments.system, arguments.json)
    if chosen is not None:
        printer = PRINTERS[chosen]
        write = printer.with_jacobian if arguments.jacobian else None
        text = (write or printer.text)(eqs)
        progress("")
        answer(arguments.json, lambda: {chosen: text}, [text.rstrip("\n")])
        return 0
    motions, name = Motions(eqs), eqs.system.name
    if not arguments.json:  # what is found is printed before anything that may take longer
        for lines in derivation_parts(eqs, shutil.get_terminal_size((100, 24)).columns):
            progress("")
            print("\n".join(lines), flush=True)
            progress(f"{name}: kind, growth and curvature")
    reduction = _reduction(motions)
    claims = check_claims(motions, lambda what: progress(f"{name}: {what}"))
    if arguments.json:
        progress(f"{name}: the short form of the equations")
    data = eqs.as_dict() | _descent_data(reduction) if arguments.json else {}
    progress("")
    answer(
        arguments.json,
        lambda: data | {"claims": [_claim_data(claim) for claim in claims]},
        [*_descent(eqs, reduction), *_claims(claims)],
    )
    return 1 if any(claim.verdict.refuted for claim in claims) else 0


def _require_program(chosen: str | None, jacobian: bool) -> None:
    """Refuse ``--jacobian`` where nothing is printed that could hold it."""
    if jacobian and (chosen is None or PRINTERS[chosen].with_jacobian is None):
        able = ", ".join(f"--{n}" for n, p in PRINTERS.items() if p.with_jacobian is not None)
        raise DefinitionError(f"--jacobian: it is printed with a program; add one of {able}")


def _store(eqs: VoronecEquations, path: Path, subject: str, as_json: bool) -> int:
    """Write the derivation of a subject into a file, for ``voronec compare``; an old one is
    replaced."""
    from voronec.declaration.whole_files import replace_file
    from voronec.proof.comparison import StoredDerivation

    replace_file(path, StoredDerivation.of(eqs).text())
    progress("")
    told = f"wrote {path}; now try: voronec compare {path} {subject}"
    answer(as_json, lambda: {"system": eqs.system.name, "file": str(path)}, [told])
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
    from voronec.equations.readable import equation_rows

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
    return lines + equation_rows(rows + [(f"d{g}/dt", plain(rate)) for g, rate in rates])
