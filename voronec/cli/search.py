"""``voronec search integrals``: first integrals of a given form, and what there is not."""

from __future__ import annotations

import sys
from argparse import Namespace
from typing import TYPE_CHECKING, Any

from voronec.algebra.columns import columns
from voronec.algebra.text import formula
from voronec.cli.output import answer, plain, progress
from voronec.cli.subject import resolve
from voronec.cli.values import name_and_value
from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from voronec.proof.search import IntegralSearch


def execute(arguments: Namespace) -> int:
    """Search and print; stopped by Ctrl-C, print what was found until then."""
    from voronec.proof.search import searches

    system, _ = resolve(arguments.system)
    plain = ("degree", "positions", "power", "momenta", "again", "limit")
    options = {
        **{name: getattr(arguments, name) for name in plain},
        "denominators": [_denominator(text) for text in arguments.denominator],
        "functions": dict(_function(text) for text in arguments.functions),
        "at": dict(special_value(text) for text in arguments.at),
    }
    result, stopped = None, False
    try:
        for result in searches(system, **options):
            progress(f"{system.name}: {result.examined} of {result.monomials} monomials, "
                     f"{len(result.integrals)} found")  # fmt: skip
    except KeyboardInterrupt:
        stopped = True
    progress("")
    if result is None:
        raise KeyboardInterrupt
    answer(arguments.json, result.as_dict, _lines(result))
    if stopped:
        print("voronec: stopped", file=sys.stderr)
        return 130
    return 0 if result.complete else 1


def _denominator(text: str) -> Any:
    return text if text == "mass" else formula(text, "--denominator")


def _function(text: str) -> tuple[str, Any]:
    """NAME=EXPRESSION, or the name of a declared equation."""
    name, equals, value = (part.strip() for part in text.partition("="))
    if not equals:
        return name, None
    if not name.isidentifier():
        raise DefinitionError(f"--with {text}: give NAME=EXPRESSION, such as r=sqrt(1+x^2)")
    return name, formula(value, f"--with {name}")


def special_value(text: str) -> tuple[str, Any]:
    """PARAMETER=VALUE of ``--at``."""
    name, value = name_and_value(text, "--at", "PARAMETER=VALUE, such as R2=-2*R1 or m=1")
    return name, formula(value, f"--at {name}")


def _lines(result: IntegralSearch) -> list[str]:
    where = ", ".join(f"{s} = {plain(v)}" for s, v in result.at.items())
    lines = [f"{result.system}: first integrals" + (f" at {where}" if where else ""), ""]
    rows = [["form", result.form]]
    rows += [["letter", f"{name} = {plain(e)}"] for name, e in result.letters.items()]
    size = f"{result.monomials} monomials, {result.functions} independent functions"
    rows.append(["ansatz", f"{size}, in {result.classes} classes, {result.seconds:.2f} s"])
    rows.append(["known", ", ".join(result.known) or "none"])
    if result.ignored:
        rows.append(["not used", f"{', '.join(result.ignored)} (no integrals in these variables)"])
    lines += [*columns(rows), "", "found"]
    integrals = [
        [f.name, f"= {plain(f.short)}", _verdict(f.standing, f.independent)]
        for f in result.integrals
    ]
    for name, equation, verdict in integrals:
        lines += [f"  {name} {equation}", f"  {' ' * len(name)} {verdict}"]
    if not integrals:
        lines.append("  nothing new")
    return [*lines, "", result.statement]


def _verdict(standing: str, independent: bool) -> str:
    return standing if independent else f"{standing}, a function of those before"
