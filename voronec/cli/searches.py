"""``voronec search KIND``: measures, multipliers, symmetries, gauge momenta, rational integrals."""

from __future__ import annotations

from argparse import Namespace
from typing import Any

from voronec.algebra.columns import columns
from voronec.algebra.text import formula
from voronec.cli.output import answer, plain
from voronec.cli.search import special_value
from voronec.cli.subject import resolve


def execute(arguments: Namespace) -> int:
    """Search and print; 1 where nothing is proved."""
    from voronec.proof import search

    system, _ = resolve(arguments.system)
    options: dict[str, Any] = {"at": dict(special_value(text) for text in arguments.at)}
    for name in ("exponent", "positions", "degree"):
        if hasattr(arguments, name):
            options[name] = getattr(arguments, name)
    for name, option in (
        ("factors", "--factor"), ("integrals", "--integral"), ("body", "--body"),
    ):  # fmt: skip
        if hasattr(arguments, name):
            options[name] = [formula(text, option) for text in getattr(arguments, name)]
    if hasattr(arguments, "velocities"):
        options["momenta"] = not arguments.velocities
    function, lines = KINDS[arguments.kind]
    result = getattr(search, function)(system, **options)
    text = [f"{system.name}: {arguments.kind}", "", *lines(result), "", result.statement]
    answer(arguments.json, result.as_dict, [line.replace("**", "^") for line in text])
    return 0 if result.is_decided else 1


def _density(result: Any) -> list[str]:
    rows = [["factors", ", ".join(map(plain, result.factors)) or "none"]]
    if result.found is not None:
        rows.append([result.kind, plain(result.found.expression)])
    if result.found is not None and result.found.variables:
        rows.append(["variables", ", ".join(map(plain, result.found.variables))])
    return columns(rows)


def _symmetries(result: Any) -> list[str]:
    return columns([[str(f), f.verdict.status] for f in (*result.fields, *result.maps)])


def _gauge(result: Any) -> list[str]:
    from voronec.proof.search.gauge import write_field

    lines = columns([[name, f"= {write_field(y)}"] for name, y in result.symmetries.items()])
    for m in result.momenta:
        lines += ["", f"  {plain(m.expression)}", f"  {m.verdict.status}, {result.words(m)}"]
    return lines


def _rational(result: Any) -> list[str]:
    counts = {
        "monomials": result.monomials,
        "independent along an orbit": result.rank,
        "multiples of known integrals": result.explained,
        "excess": result.excess,
    }
    return columns([[name, str(number)] for name, number in counts.items()])


KINDS = {
    "measures": ("search_measures", _density),
    "multipliers": ("search_reducing_multipliers", _density),
    "symmetries": ("search_symmetries", _symmetries),
    "gauge": ("search_gauge_momenta", _gauge),
    "rational": ("exclude_rational_integrals", _rational),
}
"""Of each kind the function of ``voronec.proof.search``, and what is printed besides."""
