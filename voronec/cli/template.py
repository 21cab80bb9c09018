"""``voronec new``: a file that defines a system, commented for a newcomer, and already runs."""

from __future__ import annotations

import re
from argparse import Namespace
from pathlib import Path

from voronec.cli.files import create
from voronec.cli.mechanisms import mechanism_of
from voronec.cli.output import print_json
from voronec.errors import DefinitionError

__all__ = ["execute"]


def execute(arguments: Namespace) -> int:
    """Write the file into the current folder; an existing one is refused."""
    name = arguments.name
    if not re.fullmatch(r"[a-z][a-z0-9]*(-[a-z0-9]+)*", name):
        raise DefinitionError(
            f"'{name}' is no name for a system; use lower-case letters, digits and single hyphens, "
            "a letter first, such as 'rolling-coin'"
        )
    mechanism = mechanism_of(name)
    path = Path(name.replace("-", "_") + (".toml" if arguments.toml else ".py"))
    text = mechanism.toml if arguments.toml else mechanism.python
    create(path, text.replace("@NAME@", name))
    if arguments.json:
        print_json({"system": name, "file": str(path), "mechanism": mechanism.title})
    else:
        print(
            f"wrote {path}, {mechanism.title}; now try: voronec derive {path}; voronec run {path}; "
            f"voronec view {path}"
        )
    return 0
