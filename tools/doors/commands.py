"""The doors of the command line: commands and options, plugin files, the environment."""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

from doors.values import HOSTILE, odd_text
from voronec.cli import main
from voronec.cli.arguments import command_parser

Door = tuple[str, Callable[[], Any]]
STATUSES = (0, 1, 2, 130)
LEAST = {
    "list": (), "show": ("sleigh",), "derive": ("sleigh",), "explain": ("sleigh",),
    "regenerate": ("demchenko", "--label", "nothing"), "run": ("sleigh", "--times", "0:1:3"),
    "check": ("x.py",), "compare": ("sleigh", "sleigh"), "graph": ("sleigh",),
    "section": ("sleigh", "--until", "1", "--crossings", "1"),
    "gallery": ("demchenko", "--only", "A"), "bench": ("sleigh", "--time", "x"),
    "hard": ("--list",), "search": ("integrals", "sleigh", "--degree", "1", "--positions", "1"),
    "new": ("some-name",), "cite": ("sleigh",), "view": ("sleigh",), "methods": ("sleigh",),
    "judge": ("sleigh", "v' = a w^2"), "audit": ("x.tex", "sleigh"),
    "steady": ("sleigh",), "stability": ("sleigh", "--over", "v", "--between=-1:1"),
    "periodic": ("sleigh",), "exponents": ("sleigh", "--until", "1"),
}  # fmt: skip
"""Every command with right arguments, or with one that ends it where the work itself is long."""
NO_BYTECODE = {"PYTHONDONTWRITEBYTECODE": "1"}
"""Where files must be short: a compiled module that is cut short would break what runs next."""
LONG = ("gallery", "bench", "check", "regenerate", "hard")
"""Commands whose work is long: they are tried with text that is wrong."""
SMALL = """
import sympy as sp
import voronec as vo
x, m = sp.symbols("x m")
SYSTEM = vo.System(
    name="{name}", fibration=vo.Fibration((x,)), lagrangian=m * vo.velocity(x) ** 2 / 2 - x**2,
    parameters=(vo.Parameter(m, 1, positive=True),),
    scenes={{"default": vo.Scene({{x: 1}}, (0, 1))}},
)
"""


class Wrong(Exception):
    """What is wrong with a door, in one line."""


def command_door(dice: Random, place: Path) -> Door:
    """A command with odd values of its options and arguments."""
    name = dice.choice([*LEAST])
    words = [name, *LEAST[name]]
    options = _options(name)
    for _ in range(dice.choice((1, 1, 2))):
        kind = dice.random()
        if kind < 0.6 and options:
            option, takes = dice.choice(options)
            words += [option, odd_text(dice)] if takes else [option]
        elif kind < 0.75:
            words.append(odd_text(dice))
        elif len(words) > 1:
            words[dice.randrange(1, len(words))] = odd_text(dice)
    if name in LONG and not any(w.startswith("--") and w != "--json" for w in words[2:]):
        words.append(odd_text(dice))
    if dice.random() < 0.2:
        words.append("--json")
    words = [w.replace("\0", "") for w in words]  # no shell hands these on
    (place / "x.py").write_text(SMALL.format(name="small"))
    (place / "x.json").write_text(dice.choice(["", "{}", "[]", "null", '{"a": NaN}', "\ufeff{"]))
    return " ".join(map(ascii, words)), lambda: _run_command(words)


def _run_command(words: list[str]) -> None:
    if words[0] in LONG and _would_work(words):
        return
    try:
        status: Any = main(words)
    except SystemExit as end:
        status = end.code
    if status not in STATUSES:
        raise Wrong(f"exit status: {status!r}")


def _would_work(words: list[str]) -> bool:
    """Whether a long command would begin its work; then it is not the door that is tried."""
    try:
        chosen = command_parser().parse_args(words)
    except SystemExit:
        return False
    given = vars(chosen)
    plain = {
        "check": ("names",),
        "hard": ("cases",),
        "gallery": ("only",),
    }
    if words[0] == "bench":  # its least arguments name a time that is none; a number begins it
        with suppress(ValueError):
            return given["time"] is None or float(given["time"]) > 0
        return False
    return all(given.get(k) in (None, [], "x") for k in plain.get(words[0], ()))


@cache
def _options(name: str) -> list[tuple[str, bool]]:
    """The options of a command, and whether they take a value."""
    commands = next(
        a for a in command_parser()._actions if isinstance(a, argparse._SubParsersAction)
    )
    parser = commands.choices[name]
    inner = [a for a in parser._actions if isinstance(a, argparse._SubParsersAction)]
    parser = inner[0].choices["integrals"] if inner else parser
    return [(a.option_strings[-1], a.nargs != 0) for a in parser._actions if a.option_strings]


def plugin_door(dice: Random, place: Path) -> Door:
    """A file that defines a system, and is malformed, or of odd kinds, or says hostile things."""
    text = SMALL.format(name=dice.choice(["small", "small", "", "a" * 300, "θ", "x y", "sleigh"]))
    for _ in range(dice.choice((1, 1, 2))):
        text = dice.choice((_cut, _swap, _replace, _add, _add_noise))(dice, text)
    data = text.encode("utf-8", "surrogateescape")
    if dice.random() < 0.05:
        data = bytes(dice.randrange(256) for _ in range(40)) + data
    file = place / "plugin.py"
    file.write_bytes(data)
    command = dice.choice(
        ["show", "derive", "run", "explain", "check", "cite", "compare", "section"]
    )
    words = [command, str(file), *(["--out", "out"] if command in ("run", "section") else [])]
    if command == "section":
        words += ["--crossings", "2", "--until", "5"]
    words += [str(file)] if command == "compare" else []
    words += ["--jobs", "1", "--fresh"] if command == "check" else []
    return f"{command} of {ascii(text)[-300:]}", lambda: _run_command(words)


def _cut(dice: Random, text: str) -> str:
    return text[: dice.randrange(len(text) or 1)]


def _swap(dice: Random, text: str) -> str:
    words = text.split(" ")
    i, j = dice.randrange(len(words)), dice.randrange(len(words))
    words[i], words[j] = words[j], words[i]
    return " ".join(words)


def _replace(dice: Random, text: str) -> str:
    old = dice.choice(["m * vo.velocity(x) ** 2 / 2 - x**2", "(x,)", "vo.Scene({x: 1}, (0, 1))",
    '"x m"',
                       "vo.Parameter(m, 1, positive=True)", "{x: 1}", "(0, 1)", "x**2",
                       "SYSTEM"])  # fmt: skip
    new = dice.choice(["None", "1/0", "[]", "x", "{}", "sp.oo", "float('nan')", "lambda: x",
    "'x'", "()",
                       "1e400", "10**400", "1/x", "sp.sqrt(-x)", "object()", "exit(3)",
                       "sp.Symbol('')",
                       "sp.Function('f')(x)", repr(dice.choice(HOSTILE)), repr(odd_text(dice)),
                       "sp.Symbol(" + repr(dice.choice(HOSTILE)) + ")", "input()"])  # fmt: skip
    return text.replace(old, new)


def _add(dice: Random, text: str) -> str:
    return text + dice.choice([
        "MEMBERS = {'a': lambda: SYSTEM}\n", "MEMBERS = None\n", "MEMBERS = {1: 2}\n",
        "RELATIONS = 3\n",
        "RELATIONS = (None,)\n", "RELATIONS = (vo.Relation('a', 'b', {}),)\n", "SQUARES = 'x'\n",
        "raise SystemExit(5)\n", "raise KeyError('x')\n", "import os; os.chdir('/')\n",
        "SYSTEM = None\n",
        "SYSTEM = [SYSTEM]\n", "del SYSTEM\n", "raise ValueError('two\\nlines')\n",
        "class A: pass\n",
        "SYSTEM = vo.System(name='b', fibration=vo.Fibration((x,)), lagrangian=1/x)\n",
        "SYSTEM = vo.System(name='b', fibration=vo.Fibration((x,)), lagrangian='m*xdot**2')\n",
        "f = lambda n: f(n + 1)\nf(0)\n", "print('said')\n", "sp.pi.evalf = 3\n",
    ])  # fmt: skip


def _add_noise(dice: Random, text: str) -> str:
    at = dice.randrange(len(text) or 1)
    return (
        text[:at]
        + dice.choice(["\0", "\t", "(", '"""', "\ufeff", "é", "\\", "\r", "if", "0x"])
        + text[at:]
    )


def environment_door(dice: Random, place: Path) -> Door:
    """A right command in an odd environment, in a process of its own."""
    command = dice.choice([
        "list", "list --json", "show sleigh", "show demchenko", "derive sleigh", "cite sleigh",
        "--help",
        "derive demchenko", "run sleigh --times 0:1:5 --out out", "explain sleigh --out out",
        "new a-b",
        "derive sleigh --store s.json", "graph sleigh --out g.svg", "explain demchenko",
        "show nobody",
        "section sleigh --until 2 --crossings 1 --out out", "derive sleigh --json",
    ])  # fmt: skip
    call = f"{sys.executable} -m voronec {command}"
    shell, env = dice.choice(_surroundings(place))
    told = shell.replace("@", f"voronec {command}") + f"  {env}"
    return told, lambda: _in_process(shell.replace("@", call), {**os.environ, **env}, place)


def _surroundings(place: Path) -> list[tuple[str, dict[str, str]]]:
    return [
        ("@ >&-", {}), ("@ 2>&-", {}), ("@ >&- 2>&-", {}), ("@ <&-", {}), ("@ >/dev/full", {}),
        ("@ 2>/dev/full", {}), ("@ | head -c 1", {}), ("@ | true", {}),
        ("trap '' INT; @", {}), ("trap '' PIPE; @ | true", {}),
        ("ulimit -f 0; @", NO_BYTECODE), ("ulimit -f 8; @", NO_BYTECODE), ("ulimit -n 64; @", {}),
        ("ulimit -s 256; @", {}),
        ("mkdir -p no; chmod 500 no; cd no; @", {}), ("echo x > out; @", {}),
        ("mkdir gone; cd gone; rmdir ../gone; @", {}),
        ("mkdir -p out s.json g.svg a-b.py; @", {}), ("unset HOME; @", {}), ("env -i @", {}),
        ("@", {"LC_ALL": "C", "PYTHONIOENCODING": "ascii"}), ("@",
        {"PYTHONIOENCODING": "ascii:strict"}),
        ("@", {"PYTHONIOENCODING": "latin-1"}), ("@", {"COLUMNS": "0"}), ("@", {"COLUMNS": "-5"}),
        ("@", {"COLUMNS": "odd"}), ("@", {"COLUMNS": "1"}), ("@", {"HOME": "/nowhere"}),
        ("@", {"HOME": "/dev/null", "XDG_CACHE_HOME": "/dev/null"}), ("@", {"TMPDIR": "/nowhere"}),
        ("@", {"MPLCONFIGDIR": "/dev/null"}), ("@", {"XDG_CACHE_HOME": str(place / "ro")}),
        ("@", {"PYTHONUTF8": "0", "LANG": "C"}), ("@", {"MPLBACKEND": "nonsense"}), ("@",
        {"TERM": "dumb"}),
    ]  # fmt: skip


def _in_process(line: str, env: dict[str, str], place: Path) -> None:
    work = subprocess.Popen(
        ["bash", "-c", f"ulimit -t 20; {line}"], env=env, cwd=place, stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, start_new_session=True,
    )  # fmt: skip
    try:
        out, told = work.communicate(timeout=180)
    except subprocess.TimeoutExpired:
        os.killpg(work.pid, signal.SIGKILL)
        raise Wrong("hang: over 180 s") from None
    if work.returncode in (152, -24):
        raise Wrong("hang: over 20 s")
    for text in (out, told):
        if b"Traceback" in text or b"Exception ignored" in text:
            lines = text.decode(errors="replace").strip().splitlines()
            raise Wrong(f"traceback: {lines[-1]}")
        if b"fault of voronec" in text:
            raise Wrong(f"untyped: {text.decode(errors='replace').strip()[-200:]}")
    if work.returncode not in STATUSES and not (work.returncode == 141 and "PIPE" not in line):
        raise Wrong(f"exit status: {work.returncode}")
