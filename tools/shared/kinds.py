"""One script, several kinds of work: the first word of a command says which."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from importlib import import_module

PARSERS = {"argparse", "campaign_parser"}
"""What a module has by whose options ``--help`` is one; of others it prints what they do."""


def run(about: str | None, modules: Mapping[str, str]) -> int:
    """The exit status of ``main`` of the module whose kind is the first word of the command.

    The module reads the words after it.  Without a word, or for ``--help``, ``about`` is printed.
    """
    script, *words = sys.argv
    if not words or words[0] in ("-h", "--help"):
        print((about or "").strip())
        return 0
    if words[0] not in modules:
        print(f"there is no kind '{words[0]}'; kinds are {', '.join(modules)}", file=sys.stderr)
        return 2
    sys.argv = [f"{script} {words[0]}", *words[1:]]
    module = import_module(modules[words[0]])
    if not PARSERS & vars(module).keys() and {"-h", "--help"} & {*words[1:]}:
        print((module.__doc__ or "").strip())
        return 0
    status: int = module.main()
    return status
