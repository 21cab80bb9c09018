"""The arguments of every command; loads nothing heavy, so that ``--help`` answers at once.

Errors name arguments of Python; on the command line the options that mean them stand in their
place.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from glob import escape, glob
from os.path import isdir
from types import MappingProxyType
from typing import Any, NamedTuple, NoReturn

import voronec
from voronec.equations.printers import PRINTERS
from voronec.errors import did_you_mean, printable
from voronec.motion.methods import method_names

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
        """Parse arguments; those that a command does not know are refused by that command."""
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
        formatter_class=partial(argparse.HelpFormatter, max_help_position=16),
    )  # fmt: skip
    parser.add_argument("--version", action="version", version=f"voronec {voronec.__version__}")
    parser.set_defaults(module=None)
    commands = parser.add_subparsers(title="commands", metavar="COMMAND")
    kinds: dict[str, Any] = {}
    for words, (module, summary, *options) in COMMANDS.items():
        name, _, kind = words.partition(" ")
        if kind and name not in kinds:
            command = commands.add_parser(
                name, help=SEARCHES, description=SEARCHES, allow_abbrev=False
            )
            kinds[name] = command.add_subparsers(
                title="what is searched", metavar="KIND", required=True
            )
        command = kinds.get(name, commands).add_parser(
            kind or name, help=summary, description=summary, allow_abbrev=False
        )
        command.set_defaults(module=f"voronec.cli.{module}", kind=kind)
        given = [*_flatten((Option("--json", "print the result as JSON"), *options))]
        group = command.add_mutually_exclusive_group() if any(o.alone for o in given) else command
        for option in given:
            option.add_to(group if option.alone else command)
    return parser


class Option(NamedTuple):
    """``name NAME``, ``--out DIR``, or an option that takes no value, as ``--json``; of those that
    stand ``alone`` a command takes one."""

    form: str
    meaning: str
    settings: Mapping[str, Any] = MappingProxyType({})
    alone: bool = False

    def add_to(self, parser: Any) -> None:
        """Have a parser take it."""
        (name, _, value), settings = self.form.partition(" "), dict(self.settings)
        if value:
            settings["metavar"] = value
        elif "choices" not in settings:
            settings["action"] = "store_true"
        argument = parser.add_argument(name, help=self.meaning, **settings)
        if "NAME" in value.split("|"):
            argument.completer = _system_names


def _system_names(prefix: str, **_: Any) -> list[str]:
    """What a shell offers for a NAME or a FILE: systems, without running anybody's code, files of
    systems, and folders."""
    from voronec.declaration.catalogue import SUFFIXES, names

    paths = sorted(glob(f"{escape(prefix)}*"))
    files = [path for path in paths if path.endswith(SUFFIXES) or isdir(path)]
    return [name for name in names() if name.startswith(prefix)] + [
        f"{path}/" if isdir(path) else path for path in files
    ]


def _flatten(items: Iterable[Any]) -> Iterator[Option]:
    """Options, those that tables of others give when they are asked for among them."""
    for item in items:
        if isinstance(item, Option):
            yield item
        else:
            yield from item() if callable(item) else item


def _printers() -> Iterator[Option]:
    return (Option(f"--{name}", printer.about, alone=True) for name, printer in PRINTERS.items())


def _method(many: bool = False) -> tuple[Option]:
    settings = {"choices": method_names(many=many), "default": "auto"}
    return (Option("--method", "the integrator", settings),)


def _number(name: str, default: int, meaning: str) -> Option:
    return Option(f"--{name} N", f"{meaning} ({default})", {"type": int, "default": default})


def _several(form: str, meaning: str, **settings: Any) -> Option:
    return Option(form, meaning, {"action": "append", "default": [], **settings})


OFTEN = "; may be given several times"
SYSTEM = Option(
    "system NAME|FILE", "a system's name, or a file: Python defining SYSTEM, or TOML"
)  # fmt: skip
OUTPUTS = Option("--outputs A,B", "what to compute: names or formulas (those of the scene)")
VARIABLES = Option(
    "--variables A,B", "what the equations are closed for (the velocities of the equations)"
)
TOLERANCE = Option("--tol TOL", "the integrator's tolerance (1e-13)")
MOTION = (
    Option("--scene S", "the scene ('default')"),
    _several(
        "--set NAME=VALUE",
        "another value of a parameter, or of a coordinate or velocity at the start" + OFTEN,
    ),
    _several(
        "--input NAME=VALUE",
        "an input: a formula of t and of the state, or a file of times and values, "
        "FILE.csv[:held|:linear|:cubic]",
    ),
)
"""Which motion is meant."""
STEADY = (
    _several("--at NAME=VALUE", "a variable, an integral or a formula that has this value" + OFTEN),
    _several("--set NAME=VALUE", "another value of a parameter, or an input's" + OFTEN),
    Option("--free A,B", "parameters or inputs that are to be found"),
    _number("starts", 100, "number of searches"), _number("seed", 1, "seed of the random starts"),
)  # fmt: skip
"""Which steady motions are meant."""
AT = _several("--at P=VALUE", "a special value of a parameter, such as R2=-2*R1" + OFTEN)
FACTOR = _several("--factor G", "a further factor" + OFTEN, dest="factors")
SEARCHES = "search for integrals, measures, multipliers, symmetries, or prove that there are none"
COMMANDS: Mapping[str, tuple[Any, ...]] = {
    "list": (
        "listing", "list the systems and papers",
        Option("--names", "only the names; no system's code is run"),
    ),
    "show": (
        "declaration", "show what a system declares", SYSTEM,
        Option("--out FILE", "draw its sketch instead: a .svg, .png or .pdf"),
    ),
    "derive": (
        "derivation", "derive the equations of motion", SYSTEM, _printers,
        Option("--jacobian", "also print its derivatives with respect to state and inputs"),
        Option("--store FILE.json", "store the derivation, for 'compare'", alone=True),
    ),
    "explain": (
        "explain", "show what has to be integrated to get given outputs, and why", SYSTEM,
        Option("--derivation",
               "instead, derive the equations step by step, with the formulas of the theory"),
        Option("--latex", "print the derivation as LaTeX"), OUTPUTS, MOTION,
        Option("--out DIR", "folder for the text and its pictures, or pages"),
    ),
    "methods": (
        "methods", "solve one problem by six methods, and prove that they agree", SYSTEM,
    ),
    "judge": (
        "judgement", "prove or refute an equation", SYSTEM,
        Option("equation EQUATION",
               r"LaTeX or plain text, as '\dot v = a w^2', 'd/dt(m v) = m a w^2', 'v^2 = const'"),
    ),
    "regenerate": (
        "regeneration", "check every formula of a paper against what is derived",
        Option("paper NAME|FILE", "a paper of 'voronec list', or a file that defines PAPER"),
        Option("--out DIR", "folder for HTML, LaTeX, JSON and pictures"),
        Option("--label L", "only this label, or what the page calls 'text 3'"),
        Option("--details", "print one line for each record, and every erratum in full"),
        Option("--fresh", "do not reuse verdicts of an earlier audit"),
    ),
    "audit": (
        "paper", "check the formulas of a LaTeX file against a system, or draft its system",
        Option("paper FILE.tex|NAME", "the paper, as it is; a paper of the catalogue by its name"),
        SYSTEM._replace(settings={"nargs": "?"}),
        Option("--dictionary FILE", "what letters of the paper mean in the system, a TOML file; "
               "one that does not exist is written, to be filled in"),
        Option("--format", "the summary for a terminal, or as Markdown",
               {"choices": ("text", "md"), "default": "text"}),
        Option("--out DIR", "folder for a page, LaTeX and JSON"),
    ),
    "run": (
        "motion", "integrate a motion, draw it and save it", SYSTEM, OUTPUTS, MOTION,
        Option("--times [START:]END[:N]",
               "times instead of those of the scene, N of them (1001)"),
        _method, TOLERANCE,
        Option("--out DIR", "folder for trajectory.csv and pictures (./NAME-run)"),
        Option("--animate FILE",
               "a film of a system with shapes: .gif, .webp, .mp4, or .png for single frames"),
    ),
    "view": (
        "view", "write an HTML page that integrates a motion and shows it in space", SYSTEM, MOTION,
        Option("--times [START:]END[:N]", "other times than the scene's, at N instants (1001)"),
        Option("--out DIR", "folder for the page NAME.html (the current folder)"),
    ),
    "check": (
        "check", "prove or refute all claims, relations and squares",
        Option("names NAME|FILE", "only these systems, with their relations and squares",
               {"nargs": "*"}),
        Option("--fresh", "do not reuse verdicts of an earlier check"),
        Option("--jobs N", "number of processes (one for each processor)", {"type": int}),
    ),
    "compare": (
        "comparison", "compare two systems, or a stored derivation with today's",
        [Option(f"{side} NAME|FILE",
                "a system, a .py or .toml file of one, or a .json of 'derive --store'")
         for side in ("first", "second")],
    ),
    "graph": (
        "graph", "draw the systems and their relations",
        Option("names NAME", "only these systems and their neighbours", {"nargs": "*"}),
        Option("--out FILE", "a .svg, .png, .pdf, .dot or .json file, instead of text"),
    ),
    "section": (
        "section", "draw a Poincare section: where motions pass through a surface", SYSTEM,
        Option("--plane EXPR=VALUE",
               "the surface, such as omega1=0 (by default, something that oscillates)"),
        Option("--outputs A,B", "what is recorded; the first two are drawn"), MOTION,
        _number("starts", 1, "motions on one level of all integrals"),
        _number("crossings", 1000, "points of each motion"),
        Option("--direction", "direction of crossing",
               {"choices": ("up", "down", "both"), "default": "up"}),
        Option("--until T", "give up on a motion after this time"), partial(_method, many=True),
        TOLERANCE, Option("--out DIR", "folder for points.csv and section.svg (./NAME-section)"),
    ),
    "periodic": (
        "periodic", "find a periodic orbit, or a family, with its multipliers", SYSTEM, MOTION,
        Option("--period T", "a guess of the period (when the motion is back near its start)"),
        VARIABLES,
        Option("--hold A,B", "integrals that keep the values of the start"),
        Option("--along NAME=VALUE", "follow the family along an integral or a parameter up to "
               "this value"),
        _number("points", 21, "largest number of orbits of the family"),
        Option("--segments N", "number of parts of the period in multiple shooting", {"type": int}),
        TOLERANCE,
    ),
    "exponents": (
        "exponents", "compute Lyapunov exponents with error bars", SYSTEM, MOTION, VARIABLES,
        Option("--count N", "only the N largest", {"type": int}),
        Option("--bar X", "the error bar at which to stop (a thousandth of the motion's pace)"),
        Option("--until T", "the longest time for which the motion is followed"),
        Option("--tol TOL", "the integrator's tolerance (1e-9)"),
    ),
    "steady": (
        "steady", "find steady motions, with their spectra", SYSTEM, STEADY,
        Option("--exact", "also all families exactly, by elimination"),
    ),
    "stability": (
        "stability", "follow steady motions over a quantity: spectra, critical values", SYSTEM,
        Option("--over NAME", "a parameter, a variable, or a formula", {"required": True}),
        Option("--between A:B", "the range of that quantity", {"required": True}),
        Option("--hold A,B", "what else keeps its value"), STEADY,
        _number("count", 100, "number of steps"),
        Option("--out DIR", "folder for family.csv and family.svg"),
    ),
    "bifurcation": (
        "bifurcation", "draw the bifurcation diagram of the integrals: critical values, tori",
        SYSTEM,
        Option("--axes A,B", "two proved integrals, or one and a parameter (the first two)"),
        _several("--at NAME=VALUE", "the value of another integral" + OFTEN),
        _several("--set NAME=VALUE", "another value of a parameter" + OFTEN),
        _several("--between NAME=A:B", "the range of an axis" + OFTEN),
        Option("--scene S", "the scene whose start gives the usual sizes ('default')"),
        _number("starts", 60, "number of searches"),
        _number("seed", 1, "seed of the random starts"),
        Option("--out DIR", "folder for bifurcation.csv and bifurcation.svg"),
    ),
    "sweep": (
        "sweep", "compute many motions over grids, lists and draws, into a folder", SYSTEM,
        _several("--grid NAME=A:B:N|A,B,C",
                 "values of a parameter, or of a coordinate or velocity at the start" + OFTEN),
        Option("--starts FILE.csv", "starts, one in each line, below a line of names"),
        Option("--draws N", "number of random starts", {"type": int}),
        _several("--range NAME=LOW:HIGH", "the range from which values are drawn" + OFTEN),
        Option("--sampling", "how: Sobol' points, uniformly, or on one level of all integrals",
               {"choices": ("sobol", "uniform", "level"), "default": "sobol"}),
        Option("--record A,B",
               "final, drift, max(x), min(x), time(x=1), section(x=0), class, exponents(2), or "
               "quantities at the end (final,drift)", {"default": "final,drift"}), MOTION,
        Option("--times [START:]END[:N]", "the end, or instants, instead of those of the scene"),
        partial(_method, many=True), TOLERANCE,
        _number("seed", 1, "seed of the random draws"),
        Option("--jobs N", "number of processes (one for each processor)", {"type": int}),
        Option("--scheduler ADDRESS|FILE", "compute on a cluster: a scheduler of Dask"),
        Option("--chunk N", "how many motions are kept together (up to 16384)", {"type": int}),
        Option("--resume", "resume a sweep that was stopped"),
        Option("--plot FILE", "draw what is recorded: a .svg, .png or .pdf"),
        Option("--out DIR", "the folder, in .zarr (./NAME-sweep.zarr)"),
    ),
    "gallery": (
        "gallery", "draw a motion of every class of traces; without NAME, pages of a dozen motions",
        SYSTEM._replace(settings={"nargs": "?"}),
        Option("--only A,B", "only these classes, such as A,C1,D3"),
        _several("--set NAME=VALUE", "hold a parameter at this value" + OFTEN),
        Option("--out DIR|FILE",
               "folder, or one .svg, .png or .pdf (./NAME-gallery; without NAME ./gallery)"),
    ),
    "bench": (
        "benchmark", "measure the speed and the error of every method", SYSTEM, MOTION,
        Option("--outputs A,B", "what is compared (by default invariants and velocities, where "
               "their equations close)"),
        Option("--time T", "length of the motion (the scene's)"),
        Option("--methods A,B", "only these methods and peers"),
        Option("--tols X,Y", "these tolerances instead of each method's own"),
        Option("--setup", "instead, show where the time of a whole call goes, at the first of "
               "--tols (1e-9)"),
        Option("--out DIR", "folder for bench.json, the table and a plot (./NAME-bench)"),
    ),
    "hard": (
        "hard", "try every integrator on numerically hard cases",
        Option("cases CASE", "only these cases (all)", {"nargs": "*"}),
        _several("--method M",
                 "auto, heyoka, scipy, numba, c, lsoda, flint or closed-form" + OFTEN),
        Option("--quick", "a short selection of the cases"),
        Option("--list", "list the cases without running them"),
        Option("--out DIR", "write hard-cases.md and hard.json there"),
    ),
    "search integrals": (
        "search", "search for first integrals of a given form, or prove that there are none",
        SYSTEM, _number("degree", 2, "the degree in the velocities"),
        _number("positions", 3,
                "the degree in the positions: in the invariants, where there are some"),
        _number("power", 1, "the power of each denominator"),
        _number("limit", 2000, "the largest number of monomials of one class of symmetry"),
        _several("--denominator G", "divide by G too; 'mass': the mass determinant" + OFTEN),
        _several("--with F=EXPR", "a further letter F; without '=', a declared equation's" + OFTEN,
                 dest="functions"),
        AT,
        Option("--momenta", "use momenta instead of velocities"),
        Option("--again", "also find the integrals that are declared"),
    ),
    "search measures": (
        "searches", "search for an invariant measure, its density a product of powers", SYSTEM,
        FACTOR, _number("exponent", 2, "the degree of a polynomial whose exponential is a factor"),
        AT,
    ),
    "search multipliers": (
        "searches", "search for a reducing multiplier, a product of powers", SYSTEM, FACTOR, AT,
    ),
    "search symmetries": ("searches", "search for linear symmetries and reversors", SYSTEM, AT),
    "search gauge": (
        "searches", "say which linear integrals are gauge momenta, and of which fields", SYSTEM,
        _number("positions", 3, "the degree of the integrals in the positions"),
        _several("--integral F", "a further linear integral" + OFTEN, dest="integrals"), AT,
    ),
    "search rational": (
        "searches", "prove that there is no further rational integral of bounded degree", SYSTEM,
        _number("degree", 4, "the degree of numerator and denominator"),
        Option("--velocities", "use the velocities of the equations instead of momenta"), AT,
        _several("--body EXPR", "negative for no body, such as I2+I3-I1" + OFTEN),
    ),
    "new": (
        "template", "write a file with a small system to start from",
        Option("--toml", "write NAME.toml, a text file, instead of NAME.py"),
        Option("name NAME", "lower-case letters, digits and hyphens"),
    ),
    "cite": ("citation", "print the references of a system as BibTeX", SYSTEM),
}  # fmt: skip
"""Of each command its module, what it does, and what it takes."""


OPTIONS: Mapping[str, str] = MappingProxyType(
    {
        r"inputs=\{'(\w+)': \.\.\.\}": r"--input \1=VALUE",
        r"(?:parameters|initial)=\{'(\w+)': \.\.\.\}": r"--set \1=VALUE",
        r"(?:parameters|initial)=\{\.\.\.\}": "--set NAME=VALUE",
        r"outputs=\(?\.\.\.\)?": "--outputs",
        r"\bmethod='([\w-]+)'": r"--method \1",
        r"\btol=(?=\S)": "--tol ",
        r"\btol (?=>=)": "--tol ",
        r"\bjobs=(?=\d)": "--jobs ",
        r"\bout = (?=')": "--out ",
        r"\bchunk = ": "--chunk ",
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
