"""``voronec new``: a file that defines a system, commented for a newcomer, and already runs.

The mechanisms with which a newcomer begins stand in ``mechanisms/``, as Python and as TOML.
"""

from __future__ import annotations

import re
from argparse import Namespace
from pathlib import Path
from typing import NamedTuple

from voronec.cli.files import create
from voronec.cli.output import answer
from voronec.declaration.catalogue import names
from voronec.errors import DefinitionError


def execute(arguments: Namespace) -> int:
    """Write the file into the current folder; an existing one is refused."""
    name = arguments.name
    if not re.fullmatch(r"[a-z][a-z0-9]*(-[a-z0-9]+)*", name):
        raise DefinitionError(
            f"'{name}' is no name for a system; use lower-case letters, digits and single hyphens, "
            "a letter first, such as 'rolling-coin'"
        )
    if name in names():
        raise DefinitionError(
            f"there is a system '{name}' already: 'voronec show {name}' shows it; choose "
            f"another name, such as 'my-{name}'"
        )
    mechanism = _mechanism_of(name)
    path = Path(name.replace("-", "_") + (".toml" if arguments.toml else ".py"))
    text = mechanism.toml if arguments.toml else mechanism.python
    create(path, text.replace("@NAME@", name))
    told = f"wrote {path}, {mechanism.title}; now try: "
    told += "; ".join(f"voronec {command} {path}" for command in ("derive", "run", "view"))
    data = {"system": name, "file": str(path), "mechanism": mechanism.title}
    answer(arguments.json, lambda: data, [told])
    return 0


class Mechanism(NamedTuple):
    """A mechanism in words, the words of a name that mean it, and what its two files are called in
    ``mechanisms/``; there ``@NAME@`` stands for the name of the system."""

    title: str
    words: tuple[str, ...]
    stem: str

    @property
    def python(self) -> str:
        """The file in Python."""
        return self._text("py.txt")

    @property
    def toml(self) -> str:
        """The file in TOML."""
        return self._text("toml")

    def _text(self, ending: str) -> str:
        folder = Path(__file__).with_name("mechanisms")
        return (folder / f"{self.stem}.{ending}").read_text("utf-8")


def _mechanism_of(name: str) -> Mechanism:
    """The mechanism that a name such as ``rolling-coin`` means; a skate where it means none."""
    words = {*name.split("-")}
    return next((m for m in MECHANISMS if words & {*m.words}), MECHANISMS[0])


MECHANISMS = (
    Mechanism("a skate on an inclined plane", (), "skate"),
    Mechanism(
        "a coin that rolls upright on a table", ("coin", "disc", "disk", "penny", "wheel"), "coin"
    ),
)
