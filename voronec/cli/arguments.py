"""The arguments of every command; loads nothing heavy, so that ``--help`` answers at once.

Errors name arguments of Python; on the command line the options that mean them stand in their
place.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NoReturn

import voronec
from voronec.equations.printers import PRINTERS
from voronec.errors import did_you_mean, printable
from voronec.motion.methods import method_names

__all__ = ["as_options", "command_parser"]


SUMMARY = "Exact equations of nonholonomic systems, and the papers that print them."
EXITS = "exit status: 0 good, 1 a check failed, 2 the input is wrong, 130 stopped by Ctrl-C"


class _OneLineParser(argparse.ArgumentParser):
    """A parser that refuses in one line, and tells of help that cannot be written.

    Overriding ``error`` is argparse's documented way.
    """

    def error(self, message: str) -> NoReturn:
        choice = re.fullmatch(r"(.*): invalid choice: '(.*)' \(choose from (.*)\)", message)
        if choice is not None:
            near = did_you_mean(choice[2], re.findall(r"[\w-]+", choice[3]))
            message = f"{choice[1]}: there is no '{choice[2]}'{near}".removesuffix("?")
        message = re.sub(r"invalid int value: ('.*')", r"\1 is not a whole number", message)
        self.exit(2, f"{self.prog}: {printable(message)}; see '{self.prog} --help'\n")

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """The same; arguments that a command does not know are refused by that command."""
        chosen, unknown = super().parse_known_args(args, namespace)
        if unknown and unknown[0].startswith("-"):
            name = unknown[0].partition("=")[0]
            near = did_you_mean(name, re.findall(r"--[\w-]+", self.format_help()))
            self.error(f"there is no option '{name}'{near}".removesuffix("?"))
        if unknown:
            self.error(f"'{unknown[0]}' is one argument too many")
        return chosen, unknown

    def print_help(self, file: Any = None) -> None:
        (file or sys.stdout).write(self.format_help())  # argparse would pass over a full disk


def command_parser() -> argparse.ArgumentParser:
    """The parser of ``voronec``; ``module`` is where the chosen command lives."""
    parser = _OneLineParser(
        prog="voronec", description=SUMMARY, epilog=EXITS, allow_abbrev=False,
        formatter_class=_formatter,
    )  # fmt: skip
    parser.add_argument("--version", action="version", version=f"voronec {voronec.__version__}")
    parser.set_defaults(module=None)
    commands = parser.add_subparsers(title="commands", metavar="COMMAND")
    for add in (
        _list, _show, _derive, _explain, _methods, _judge, _regenerate, _run, _view, _check,
        _compare, _graph, _section, _gallery, _bench, _hard, _search, _new, _cite,
    ):  # fmt: skip
        add(commands)
    return parser


def _formatter(prog: str) -> argparse.HelpFormatter:
    return argparse.HelpFormatter(prog, max_help_position=16)


def _command(commands: Any, name: str, module: str, summary: str) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = commands.add_parser(
        name, help=summary, description=summary, allow_abbrev=False
    )
    parser.set_defaults(module=f"voronec.cli.{module}")
    _argument(parser, "--json", "print the result as JSON")
    return parser


def _argument(parser: Any, form: str, meaning: str, **settings: Any) -> None:
    """Add ``name NAME``, ``--out DIR``, or an option that takes no value, as ``--json``."""
    name, _, value = form.partition(" ")
    if value:
        settings["metavar"] = value
    elif "choices" not in settings:
        settings["action"] = "store_true"
    parser.add_argument(name, help=meaning, **settings)


def _list(commands: Any) -> None:
    parser = _command(commands, "list", "listing", "list the systems and papers")
    _argument(parser, "--names", "only the names; no system's code is run")


def _show(commands: Any) -> None:
    parser = _command(commands, "show", "declaration", "show what a system declares")
    _system(parser)
    _argument(parser, "--out FILE", "draw its sketch instead: a .svg, .png or .pdf")


def _derive(commands: Any) -> None:
    parser = _command(commands, "derive", "derivation", "derive the equations of motion")
    _system(parser)
    form = parser.add_mutually_exclusive_group()
    for name, printer in PRINTERS.items():
        _argument(form, f"--{name}", printer.about)
    _argument(parser, "--jacobian", "also print its derivatives with respect to state and inputs")
    _argument(form, "--store FILE.json", "store the derivation, for 'compare'")


def _explain(commands: Any) -> None:
    summary = "show what has to be integrated to get given outputs, and why"
    parser = _command(commands, "explain", "explain", summary)
    _system(parser)
    _argument(
        parser, "--derivation",
        "instead, derive the equations step by step, with the formulas of the theory",
    )  # fmt: skip
    _argument(parser, "--latex", "print the derivation as LaTeX")
    _outputs(parser)
    _setting(parser)
    _argument(parser, "--out DIR", "folder for the text and its pictures, or pages")


def _methods(commands: Any) -> None:
    summary = "solve one problem by six methods, and prove that they agree"
    _system(_command(commands, "methods", "methods", summary))


def _judge(commands: Any) -> None:
    summary = "prove or refute an equation"
    parser = _command(commands, "judge", "judgement", summary)
    _system(parser)
    _argument(
        parser, "equation EQUATION",
        r"LaTeX or plain text, as '\dot v = a w^2', 'd/dt(m v) = m a w^2', 'v^2 = const'",
    )  # fmt: skip


def _regenerate(commands: Any) -> None:
    summary = "check every formula of a paper against what is derived"
    parser = _command(commands, "regenerate", "regeneration", summary)
    _argument(parser, "paper NAME|FILE", "a paper of 'voronec list', or a file that defines PAPER")
    _argument(parser, "--out DIR", "folder for HTML, LaTeX, JSON, pictures")
    _argument(parser, "--label L", "only this label, or what the page calls 'text 3'")
    _argument(parser, "--details", "print one line for each record, and every erratum in full")
    _argument(parser, "--fresh", "do not reuse verdicts of an earlier audit")


def _run(commands: Any) -> None:
    parser = _command(commands, "run", "motion", "integrate a motion, draw it and save it")
    _system(parser)
    _outputs(parser)
    _setting(parser)
    _argument(
        parser, "--times [START:]END[:N]", "times instead of those of the scene, N of them (1001)"
    )
    _argument(parser, "--method", "the integrator", choices=method_names(), default="auto")
    _argument(parser, "--tol TOL", "the integrator's tolerance (1e-13)")
    _argument(parser, "--out DIR", "folder for trajectory.csv and pictures (./NAME-run)")
    _argument(
        parser, "--animate FILE",
        "an animation of a ball rolling on a sphere: .gif, .mp4, or .png for single frames",
    )  # fmt: skip


def _view(commands: Any) -> None:
    summary = "write an HTML page that integrates a motion and shows it in space"
    parser = _command(commands, "view", "view", summary)
    _system(parser)
    _setting(parser)
    _argument(
        parser, "--times [START:]END[:N]", "other times than the scene's, at N instants (1001)"
    )
    _argument(parser, "--out DIR", "folder for the page NAME.html (the current folder)")


def _check(commands: Any) -> None:
    summary = "prove or refute all claims, relations and squares"
    parser = _command(commands, "check", "check", summary)
    _argument(
        parser, "names NAME|FILE", "only these systems, with their relations and squares", nargs="*"
    )
    _argument(parser, "--fresh", "do not reuse verdicts of an earlier check")
    _argument(parser, "--jobs N", "number of processes (one for each processor)", type=int)


def _compare(commands: Any) -> None:
    summary = "compare two systems, or a stored derivation with today's"
    parser = _command(commands, "compare", "comparison", summary)
    for side in ("first", "second"):
        _argument(
            parser, f"{side} NAME|FILE",
            "a system, a .py or .toml file of one, or a .json of 'derive --store'",
        )  # fmt: skip


def _graph(commands: Any) -> None:
    summary = "draw the systems and their relations"
    parser = _command(commands, "graph", "graph", summary)
    _argument(parser, "names NAME", "only these systems and their neighbours", nargs="*")
    _argument(parser, "--out FILE", "a .svg, .png, .pdf, .dot or .json file, instead of text")


def _section(commands: Any) -> None:
    summary = "draw a Poincare section: where motions pass through a surface"
    parser = _command(commands, "section", "section", summary)
    _system(parser)
    _argument(
        parser, "--plane EXPR=VALUE",
        "the surface, such as omega1=0 (by default, something that oscillates)",
    )  # fmt: skip
    _argument(parser, "--outputs A,B", "what is recorded; the first two are drawn")
    _setting(parser)
    for name, default, meaning in (
        ("starts", 1, "motions on one level of all integrals"),
        ("crossings", 1000, "points of each motion"),
    ):
        _argument(parser, f"--{name} N", f"{meaning} ({default})", type=int, default=default)
    _argument(
        parser, "--direction", "direction of crossing", choices=("up", "down", "both"), default="up"
    )
    _argument(parser, "--until T", "give a motion up after this time")
    _argument(parser, "--method", "the integrator", choices=method_names(many=True), default="auto")
    _argument(parser, "--tol TOL", "the integrator's tolerance (1e-13)")
    _argument(parser, "--out DIR", "folder for points.csv and section.svg (./NAME-section)")


def _gallery(commands: Any) -> None:
    summary = "draw a motion of every class of traces; without NAME, pages of a dozen motions"
    parser = _command(commands, "gallery", "gallery", summary)
    _system(parser, nargs="?")
    _argument(parser, "--only A,B", "only these classes, such as A,C1,D3")
    _argument(
        parser, "--set NAME=VALUE",
        "hold a parameter at this value; may be given several times", action="append", default=[],
    )  # fmt: skip
    _argument(
        parser, "--out DIR|FILE",
        "folder, or one .svg, .png or .pdf (./NAME-gallery; without NAME ./gallery)",
    )  # fmt: skip


def _bench(commands: Any) -> None:
    summary = "measure the speed and the error of our methods and of others"
    parser = _command(commands, "bench", "benchmark", summary)
    _system(parser)
    _setting(parser)
    _argument(
        parser, "--outputs A,B",
        "what is compared (by default invariants and velocities, where their equations close)",
    )  # fmt: skip
    _argument(parser, "--time T", "length of the motion (the scene's)")
    _argument(parser, "--methods A,B", "only these methods and peers")
    _argument(parser, "--tols X,Y", "these tolerances instead of each method's own")
    _argument(
        parser, "--setup",
        "instead, show where the time of a whole call goes, at the first of --tols (1e-9)",
    )  # fmt: skip
    _argument(parser, "--out DIR", "folder for bench.json, the table and a plot (./NAME-bench)")


def _hard(commands: Any) -> None:
    summary = "try every integrator on numerically hard cases"
    parser = _command(commands, "hard", "hard", summary)
    _argument(parser, "cases CASE", "only these cases (all)", nargs="*")
    _argument(
        parser, "--method M",
        "auto, heyoka, scipy, numba, c, python, lsoda, flint or closed-form; may be given "
        "several times", action="append", default=[],
    )  # fmt: skip
    _argument(parser, "--quick", "a short selection of the cases")
    _argument(parser, "--list", "list the cases without running them")
    _argument(parser, "--out DIR", "write hard-cases.md and hard.json there")


def _search(commands: Any) -> None:
    summary = "search for first integrals of a given form, or prove that there are none"
    parser = commands.add_parser("search", help=summary, description=summary, allow_abbrev=False)
    kinds = parser.add_subparsers(title="what is searched", metavar="KIND", required=True)
    parser = _command(kinds, "integrals", "search", summary)
    _system(parser)
    for name, default, meaning in (
        ("degree", 2, "the degree in the velocities"),
        ("positions", 3, "the degree in the positions: in the invariants, where there are some"),
        ("power", 1, "the power of each denominator"),
        ("limit", 2000, "how many monomials of one class of symmetry are taken on"),
    ):
        _argument(parser, f"--{name} N", f"{meaning} ({default})", type=int, default=default)
    for name, target, value, meaning in (
        ("denominator", "denominator", "G", "divide by G too; 'mass': the mass determinant"),
        ("with", "functions", "F=EXPR", "a further letter F; without '=', a declared equation's"),
        ("at", "at", "P=VALUE", "a special value of a parameter, such as R2=-2*R1"),
    ):
        _argument(
            parser, f"--{name} {value}",
            f"{meaning}; may be given several times", dest=target, action="append", default=[],
        )  # fmt: skip
    _argument(parser, "--momenta", "use momenta instead of velocities")
    _argument(parser, "--again", "also find the integrals that are declared")


def _new(commands: Any) -> None:
    parser = _command(commands, "new", "template", "write a file with a small system to start from")
    _argument(parser, "--toml", "write NAME.toml, a text file, instead of NAME.py")
    _argument(parser, "name NAME", "lower-case letters, digits and hyphens")


def _cite(commands: Any) -> None:
    parser = _command(commands, "cite", "citation", "print the references of a system as BibTeX")
    _system(parser)


def _setting(parser: argparse.ArgumentParser) -> None:
    """Which motion is meant."""
    _argument(parser, "--scene S", "the scene ('default')")
    _argument(
        parser,
        "--set NAME=VALUE",
        "another value of a parameter, or of a coordinate or velocity at the start; "
        "may be given several times",
        action="append",
        default=[],
    )
    _argument(
        parser,
        "--input NAME=VALUE",
        "an input: a formula of t and of the state, or a file of times and values, "
        "FILE.csv[:held|:linear|:cubic]",
        action="append",
        default=[],
    )


def _outputs(parser: argparse.ArgumentParser) -> None:
    meaning = "what to compute: names or formulas (those of the scene)"
    _argument(parser, "--outputs A,B", meaning)


def _system(parser: argparse.ArgumentParser, nargs: str | None = None) -> None:
    _argument(
        parser, "system NAME|FILE",
        "a system's name, or a file: Python defining SYSTEM, or TOML", nargs=nargs,
    )  # fmt: skip


OPTIONS: Mapping[str, str] = MappingProxyType(
    {
        r"inputs=\{'(\w+)': \.\.\.\}": r"--input \1=VALUE",
        r"(?:parameters|initial)=\{'(\w+)': \.\.\.\}": r"--set \1=VALUE",
        r"(?:parameters|initial)=\{\.\.\.\}": "--set NAME=VALUE",
        r"outputs=\(?\.\.\.\)?": "--outputs",
        r"\bmethod='([\w-]+)'": r"--method \1",
        r"\btol=(?=\S)": "--tol ",
        r"\btol (?=>=)": "--tol ",
        r"\bscene= one of": "--scene with one of",
        r"\bgive times$": "give --times 0:10",
        r"\bgive until=": "give --until T",
        r",? or give project=True": "",
    }
)
"""What an error advises in Python -> what one types instead."""


def as_options(message: str) -> str:
    """The message of an error with options in the place of arguments of Python."""
    for pattern, option in OPTIONS.items():
        message = re.sub(pattern, option, message)
    return message
