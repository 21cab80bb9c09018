"""The command ``voronec``: arguments here, each command in a module of its own, loaded on use.

Exit status: 0 good; 1 a check failed or the engine came to a limit; 2 the input is wrong, with one
line that names the place and the mend; 130 stopped by Ctrl-C.
"""

from __future__ import annotations

import contextlib
import gc
import os
import sys
import warnings
from collections.abc import Iterator, Sequence
from importlib import import_module
from pathlib import Path
from traceback import extract_tb

from voronec.cli.arguments import as_options, command_parser
from voronec.errors import DefinitionError, VoronecError, printable

__all__ = ["OBJECTS", "command_parser", "main"]

FIRST_STEPS = """\
Three things to try:

  voronec derive sleigh    the equations of motion of a sleigh, exact, with what is proved of them
  voronec view sleigh      a page that integrates its motion and shows it, for any browser
  voronec new my-coin      a file with a small system of your own, to start from

'voronec --help' lists all commands, 'voronec list' all systems."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command line and return its exit status; nothing is raised but ``SystemExit``."""
    _print_any_letter()
    try:
        try:
            return _execute(arguments)
        finally:
            sys.stdout.flush()
    except DefinitionError as error:
        return _fail(as_options(str(error)), 2)
    except VoronecError as error:
        return _fail(as_options(str(error)), 1)
    except BrokenPipeError:
        _abandon_output()  # the reader (say, head) has what it wanted
        return 0
    except KeyboardInterrupt:
        return _fail("stopped", 130)
    except OSError as error:
        where = f"'{error.filename}': " if error.filename else "write error: "
        if not error.filename:  # the output itself: its end must not complain again
            _abandon_output()
        return _fail(f"{where}{error.strerror or error}; mend that, or choose another place", 2)
    except (RecursionError, MemoryError) as error:
        return _fail(f"the input is too large: {type(error).__name__} {error}", 1)
    except Exception as error:
        return _fail(_own_fault(error), 1)


def _execute(arguments: Sequence[str] | None) -> int:
    parser = command_parser()
    if "_ARGCOMPLETE" in os.environ:  # a shell asks what may stand at its cursor
        with contextlib.suppress(ImportError):
            import argcomplete

            argcomplete.autocomplete(parser)
    chosen = parser.parse_args(arguments)
    if chosen.module is None:
        print(FIRST_STEPS)
        return 0
    with _files_alone(), _rare_collection(), _plain_warnings():
        status: int = import_module(chosen.module).execute(chosen)
    return status


@contextlib.contextmanager
def _plain_warnings() -> Iterator[None]:
    """Warnings are one line for people, without the line of code that gave them."""
    before = warnings.formatwarning
    warnings.formatwarning = lambda message, *_: f"voronec: warning: {message}\n"
    try:
        yield
    finally:
        warnings.formatwarning = before


OBJECTS = 100_000
"""So many new ones a command makes before garbage is searched for; Python's own number is 700."""


@contextlib.contextmanager
def _rare_collection() -> Iterator[None]:
    """A search for garbage only now and then inside: a command is over soon."""
    before = gc.get_threshold()
    gc.set_threshold(OBJECTS, *before[1:])
    try:
        yield
    finally:
        gc.set_threshold(*before)


@contextlib.contextmanager
def _files_alone() -> Iterator[None]:
    """Pictures go to files: whatever the environment names to show them in is not asked for."""
    before = os.environ.get("MPLBACKEND")
    os.environ["MPLBACKEND"] = "agg"
    try:
        yield
    finally:
        if before is None:
            del os.environ["MPLBACKEND"]
        else:
            os.environ["MPLBACKEND"] = before


def _print_any_letter() -> None:
    """A terminal without Greek letters costs letters, not the run.  What was closed before the
    start is a stream again: errors are lost then, while output that is lost is itself an error."""
    for name, mode in (("stdout", os.O_RDONLY), ("stderr", os.O_WRONLY)):
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(os.open(os.devnull, mode), "w"))
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")


def _abandon_output() -> None:
    """Standard output leads nowhere from here on."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _fail(message: str, status: int) -> int:
    text = printable(message)
    with contextlib.suppress(OSError, ValueError):
        print(f"voronec: {text}", file=sys.stderr, flush=True)
    return status


def _own_fault(error: Exception) -> str:
    """An error that nobody foresaw, in one line; ``VORONEC_TRACEBACK=1`` lets it through."""
    if os.environ.get("VORONEC_TRACEBACK"):
        raise error
    last = extract_tb(error.__traceback__)[-1]
    what = f"{type(error).__name__} in {Path(last.filename).name}, line {last.lineno}: {error}"
    return f"a fault of voronec: {what}; please report it, with what VORONEC_TRACEBACK=1 prints"
