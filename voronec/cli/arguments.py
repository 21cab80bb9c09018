"""The arguments of every command; loads nothing heavy, so that ``--help`` answers at once."""

from __future__ import annotations

import argparse
from typing import Any, NoReturn

import voronec

__all__ = ["command_parser"]

SUMMARY = "Exact equations of nonholonomic systems, and the papers that print them."
EXITS = "exit status: 0 good, 1 a check failed, 2 the input is wrong, 130 stopped by Ctrl-C"


class _OneLineParser(argparse.ArgumentParser):
    """A parser that refuses in one line; overriding ``error`` is argparse's documented way."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {message}; see '{self.prog} --help'\n")


def command_parser() -> argparse.ArgumentParser:
    """The parser of ``voronec``; ``module`` is where the chosen command lives."""
    parser = _OneLineParser(
        prog="voronec", description=SUMMARY, epilog=EXITS, allow_abbrev=False,
        formatter_class=_formatter,
    )  # fmt: skip
    parser.add_argument("--version", action="version", version=f"voronec {voronec.__version__}")
    parser.set_defaults(module=None)
    commands = parser.add_subparsers(title="commands", metavar="COMMAND")
    for add in (_list, _show, _derive, _regenerate, _run, _new, _cite):
        add(commands)
    return parser


def _formatter(prog: str) -> argparse.HelpFormatter:
    return argparse.HelpFormatter(prog, max_help_position=16)


def _command(commands: Any, name: str, module: str, summary: str) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = commands.add_parser(
        name, help=summary, description=summary, allow_abbrev=False
    )
    parser.set_defaults(module=f"voronec.cli.{module}")
    parser.add_argument("--json", action="store_true", help="print the result as JSON")
    return parser


def _list(commands: Any) -> None:
    parser = _command(commands, "list", "listing", "list the systems and papers")
    parser.add_argument(
        "--names", action="store_true", help="the names only; runs no system's code"
    )


def _show(commands: Any) -> None:
    parser = _command(commands, "show", "declaration", "show what a system declares")
    _system(parser)


def _derive(commands: Any) -> None:
    parser = _command(commands, "derive", "derivation", "derive the equations of motion")
    _system(parser)
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--latex", action="store_true", help="the equations as LaTeX")
    form.add_argument("--python", action="store_true", help="the right-hand side as Python")
    form.add_argument("--c", action="store_true", help="the right-hand side as C")


def _regenerate(commands: Any) -> None:
    summary = "derive every formula of a paper and compare it with print"
    parser = _command(commands, "regenerate", "regeneration", summary)
    parser.add_argument(
        "paper", metavar="NAME|FILE", help="a paper of 'voronec list', or a file that defines PAPER"
    )
    parser.add_argument(
        "--out", metavar="DIR", help="write HTML, LaTeX, report.json and pictures there"
    )
    parser.add_argument(
        "--label", metavar="L", help="only the display or the section with this label"
    )
    parser.add_argument("--fresh", action="store_true", help="reuse no verdict of an earlier audit")


def _run(commands: Any) -> None:
    parser = _command(commands, "run", "motion", "integrate a motion, draw and save it")
    _system(parser)
    parser.add_argument("--scene", metavar="S", help="the scene; 'default' unless told")
    parser.add_argument(
        "--times",
        metavar="[START:]END[:N]",
        help="other times than the scene's, at N instants (1001)",
    )
    parser.add_argument(
        "--set",
        metavar="NAME=VALUE",
        action="append",
        default=[],
        help="another value of a parameter, or of a coordinate or velocity at the start; "
        "may be given several times",
    )
    parser.add_argument(
        "--method", choices=("auto", "heyoka", "scipy"), default="auto", help="the integrator"
    )
    parser.add_argument("--tol", metavar="TOL", help="the integrator's tolerance (1e-13)")
    parser.add_argument(
        "--out", metavar="DIR", help="folder for trajectory.csv and pictures (./NAME-run)"
    )


def _new(commands: Any) -> None:
    parser = _command(commands, "new", "template", "write NAME.py, a system that already runs")
    parser.add_argument("name", metavar="NAME", help="lower-case letters, digits and hyphens")


def _cite(commands: Any) -> None:
    parser = _command(commands, "cite", "citation", "print the references of a system as BibTeX")
    _system(parser)


def _system(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "system", metavar="NAME|FILE", help="a system's name, or a Python file defining SYSTEM"
    )
