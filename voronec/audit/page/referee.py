"""What a referee wants to know of a paper: what is right, what is wrong and how to mend it, what
was not looked at; for a terminal, and in Markdown for a mail."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from voronec.audit.record import Audit, Record

_RIGHT = {
    "proved": "proved",
    "definition": "definitions and conditions, which claim nothing",
}
_OPEN = {
    "convention": "in conflict with a definition of the paper",
    "undecided": "beyond the engine",
    "unknown letters": "with letters that nothing explains",
    "not read": "not read",
}
"""What is neither right nor wrong, by its verdict."""


def _several(audit: Audit) -> str:
    """How many formulas and sentences were compared."""
    number = sum(record.verdict != "unaudited" for record in audit.records)
    words = sum(bool(r.decisive.says) and r.verdict != "unaudited" for r in audit.records)
    said = f" and {words} sentence{'s' * (words != 1)}" if words else ""
    return f"{number - words} formula{'s' * (number - words != 1)}{said}"


def _left_aside(audit: Audit) -> str:
    """How many sentences were not compared."""
    number = sum(record.verdict == "unaudited" for record in audit.records)
    what = "what the text claims in words is left to the reader"
    return f"{number} sentence{'s are' if number != 1 else ' is'} not audited: {what}"


def _groups(audit: Audit, kinds: Mapping[str, str]) -> Iterator[tuple[str, list[Record]]]:
    for verdict, words in kinds.items():
        records = [record for record in audit.records if record.verdict == verdict]
        if records:
            yield words, records


def _state(record: Record) -> str:
    """The point at which a formula fails, with the values of its sides."""
    witness = record.decisive.witness or {}
    point = ", ".join(f"{name} = {value}" for name, value in witness.get("point", {}).items())
    sides = f"{witness.get('printed')} and {witness.get('derived')}"
    return f"at {point} its sides are {sides}" if point and "printed" in witness else ""


def referee_lines(audit: Audit, letters: Mapping[str, list[str]], system: str) -> list[str]:
    """The summary for a terminal."""
    lines = [f"{audit.title}: {_several(audit)} beside the system '{system}'", "right"]
    lines += [f"  {len(records)} {words}" for words, records in _groups(audit, _RIGHT)]
    lines += [f"wrong: {len(audit.errata)}"]
    for record in audit.errata:
        head = record.decisive
        lines += [f"  {record.label}", f"    for   {head.says or head.printed}"]
        lines += [f"    read  {head.correction}"] if head.correction else []
        lines += [f"    {text}" for text in (_state(record) or head.method,)]
    lines += ["not decided"]
    for words, records in _groups(audit, _OPEN):
        lines += [f"  {len(records)} {words}"]
        lines += [f"    {r.label}: {r.decisive.method}" for r in records]
    if letters:
        lines += [f"letters that nothing explains: {', '.join(letters)}"]
    return [*lines, _left_aside(audit)]


def referee_markdown(audit: Audit, letters: Mapping[str, list[str]], system: str) -> str:
    """The summary as Markdown."""
    said = f"{_several(audit)}, compared with what follows from the Lagrangian and the"
    lines = [f"# {audit.title}", "", f"{said} constraints of `{system}`.", "", "## Right", ""]
    lines += [f"- {len(records)} {words}" for words, records in _groups(audit, _RIGHT)]
    lines += ["", f"## Wrong: {len(audit.errata)}", ""]
    for number, record in enumerate(audit.errata, 1):
        head = record.decisive
        lines += [f"{number}. {record.label}: for {head.says or f'${head.printed}$'}"]
        lines += [f"   read ${head.correction}$"] if head.correction else []
        lines += [f"   ({_state(record) or head.method})"]
    lines += ["", "## Not decided", ""]
    for words, records in _groups(audit, _OPEN):
        lines += [f"- {len(records)} {words}: {'; '.join(r.label or '' for r in records)}"]
    if letters:
        lines += ["- letters: " + ", ".join(f"${letter}$" for letter in letters)]
    return "\n".join([*lines, f"- {_left_aside(audit)}", ""])
