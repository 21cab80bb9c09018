"""The command ``voronec``: arguments here, each command in a module of its own, loaded on use.

Exit status: 0 good; 1 a check failed or the engine came to a limit; 2 the input is wrong, with one
line that names the place and the mend; 130 stopped by Ctrl-C.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib import import_module

from voronec.cli.arguments import command_parser
from voronec.errors import DefinitionError, VoronecError

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command line and return its exit status."""
    parser = command_parser()
    chosen = parser.parse_args(arguments)
    if chosen.module is None:
        parser.print_help()
        return 0
    try:
        status: int = import_module(chosen.module).execute(chosen)
        sys.stdout.flush()
        return status
    except DefinitionError as error:
        return _fail(error, 2)
    except VoronecError as error:
        return _fail(error, 1)
    except BrokenPipeError:
        # The reader (say, head) has what it wanted; closing stdout must not complain again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt:
        print("voronec: stopped", file=sys.stderr)
        return 130


def _fail(error: VoronecError, status: int) -> int:
    print(f"voronec: {' '.join(str(error).split())}", file=sys.stderr)
    return status
