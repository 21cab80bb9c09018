"""Faults planted into the engine one at a time, and whether the tests notice.

    python tools/planted_faults.py [TEST FILES ...] [--seed 1] [--count 60] [--hours 2]
                                   [--within motion/steppers ...] [--fast] [--jobs 2]

Faults are drawn by seed: a sign turned, an index or a bound moved by one, a condition turned, a
term dropped.  First the tests (all, where no file is named) run once with a probe in place of each
fault, which writes down the tests that come by.  Then each fault is planted by itself, and those
tests run, first those that come by few faults, up to the first failure or for ``--seconds`` of CPU;
where none fails, their whole files run, since what is kept within a process is computed for the
first test that wants it.  The last line counts what was caught.  All happens in a copy of the tree.
"""

from __future__ import annotations

import argparse
import ast
import os
import random
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PARTS = (".ci", "docs", "systems", "tests", "tools", "voronec")
PYTEST = (sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider")
PROBE = """
import os
import pytest

def told(*words, seen=set()):
    if words not in seen:
        seen.add(words)
        with open(os.environ["PLANTED_PROBES"], "a") as file:
            file.write("\\t".join(words) + "\\n")

def reached(number):
    test = os.environ.get("PYTEST_CURRENT_TEST", "").rpartition(" ")[0]
    if test:
        told(str(number), test)

def pytest_runtest_logreport(report):
    if report.failed:
        told("fails", report.nodeid)
"""
"""A module for the copy of the tree: what probes call, and a plug-in of pytest."""
MOVES: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
}
JOINS: dict[type[ast.boolop], type[ast.boolop]] = {ast.And: ast.Or, ast.Or: ast.And}
TURNS: dict[type[ast.operator], type[ast.operator]] = {ast.Add: ast.Sub, ast.Sub: ast.Add}


@dataclass(frozen=True)
class Fault:
    """A piece of a module's text, from one offset to another, and what it is replaced by."""

    module: str
    line: int
    kind: str
    begin: int
    end: int
    text: str

    def plant_in(self, source: bytes) -> bytes:
        """The source of the module with the fault."""
        return source[: self.begin] + self.text.encode() + source[self.end :]

    def probe_in(self, source: bytes, number: int) -> bytes:
        """The source of the module, which tells when the place of the fault is reached."""
        call = f"(__import__('planted_probe').reached({number}) or "
        old = source[self.begin : self.end]
        return source[: self.begin] + call.encode() + old + b")" + source[self.end :]

    def tell(self, source: bytes) -> str:
        """Where it is, and what is changed."""
        old = source[self.begin : self.end].decode()
        return f"{self.module}:{self.line} {self.kind}: {_short(old)} -> {_short(self.text)}"


def _short(text: str) -> str:
    words = " ".join(text.split())
    return words if len(words) <= 50 else words[:47] + "..."


def variants(node: ast.AST) -> Iterator[tuple[str, ast.expr, str]]:
    """Faults of one expression: their kind, what is replaced, by what."""
    if isinstance(node, ast.BinOp) and type(node.op) in TURNS:
        yield "sign", node, ast.unparse(ast.BinOp(node.left, TURNS[type(node.op)](), node.right))
        yield "dropped term", node, ast.unparse(node.left)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        yield "sign", node, ast.unparse(node.operand)
    elif isinstance(node, ast.Subscript) and _is_whole(node.slice):
        yield "index", node.slice, f"{ast.unparse(node.slice)} + 1"
    elif isinstance(node, ast.Compare) and type(node.ops[0]) in MOVES:
        kind = "condition" if isinstance(node.ops[0], ast.Eq | ast.NotEq) else "bound"
        ops = [MOVES[type(node.ops[0])](), *node.ops[1:]]
        yield kind, node, ast.unparse(ast.Compare(node.left, ops, node.comparators))
    elif isinstance(node, ast.BoolOp):
        yield "condition", node, ast.unparse(ast.BoolOp(JOINS[type(node.op)](), node.values))
    elif isinstance(node, ast.If | ast.IfExp | ast.While):
        yield "condition", node.test, f"not ({ast.unparse(node.test)})"


def _is_whole(node: ast.expr) -> bool:
    inner = node.operand if isinstance(node, ast.UnaryOp) else node
    return isinstance(inner, ast.Constant) and type(inner.value) is int


def faults_in(module: str, source: bytes) -> list[Fault]:
    """All faults that can be planted into the functions of one module."""
    starts = [0]
    for line in source.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    found = []
    tree = ast.parse(source)
    bodies = [s for f in ast.walk(tree) if isinstance(f, ast.FunctionDef) for s in f.body]
    for node in dict.fromkeys(node for body in bodies for node in _walk(body)):
        for kind, part, text in variants(node):
            begin = starts[part.lineno - 1] + part.col_offset
            end = starts[(part.end_lineno or 0) - 1] + (part.end_col_offset or 0)
            if not _joins_text(part):
                found.append(Fault(module, part.lineno, kind, begin, end, f"({text})"))
    return found


def _walk(node: ast.AST) -> Iterator[ast.AST]:
    """All nodes but those of texts, whose places Python 3.11 does not know, and of patterns."""
    yield node
    for inner in ast.iter_child_nodes(node):
        if not isinstance(inner, ast.JoinedStr | ast.pattern):
            yield from _walk(inner)


def _joins_text(node: ast.expr) -> bool:
    """A sum of texts has no sign."""
    return isinstance(node, ast.BinOp) and any(
        isinstance(n, ast.JoinedStr) or (isinstance(n, ast.Constant) and isinstance(n.value, str))
        for n in (node.left, node.right)
    )


def copy_of_tree(folder: Path) -> None:
    """All that tests read; in the copy systems and documentation lie inside the package, as where
    it is installed."""
    for part in PARTS:
        skip = shutil.ignore_patterns("__pycache__", "site")
        shutil.copytree(ROOT / part, folder / part, ignore=skip)
    for file in ROOT.iterdir():
        if file.is_file():
            shutil.copy(file, folder)
    for inner in ("systems", "docs"):
        (folder / "voronec" / inner).symlink_to(folder / inner)


def run(words: Sequence[str], folder: Path, limit: float) -> tuple[int, float]:
    """The status of a command in a folder and its CPU seconds, of which it has so many."""

    def bound() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (int(limit) + 1, int(limit) + 2))

    probes = str(folder.parent / "probes")
    environment = {**os.environ, "PYTHONPATH": str(folder), "PLANTED_PROBES": probes}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        words, cwd=folder, env=environment, preexec_fn=bound,
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False,
    )  # fmt: skip
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return done.returncode, spent


def draw(seed: int, count: int, within: Sequence[str]) -> list[Fault]:
    """As many faults of each kind as of any other, each in a module drawn by its size; none
    within another."""
    generator, by_kind = random.Random(seed), dict[str, list[Fault]]()
    for path in sorted((ROOT / "voronec").rglob("*.py")):
        module = str(path.relative_to(ROOT))
        if not within or any(module.startswith(f"voronec/{w}") for w in within):
            for fault in faults_in(module, path.read_bytes()):
                by_kind.setdefault(fault.kind, []).append(fault)
    kinds = sorted(by_kind)
    drawn = [generator.choice(by_kind[kinds[i % len(kinds)]]) for i in range(count)]
    ordered = sorted(drawn, key=lambda fault: (fault.module, fault.begin))
    inner = {b for a, b in pairwise(ordered) if a.module == b.module and b.begin < a.end}
    return [fault for fault in dict.fromkeys(drawn) if fault not in inner]


def change(file: Path, source: bytes, moment: int) -> None:
    """Write a module; Python compiles anew what has another time."""
    file.write_bytes(source)
    os.utime(file, (moment, moment))


def reach(
    faults: Sequence[Fault], tree: Path, words: Sequence[str], seconds: float
) -> list[list[str]]:
    """The tests that come by each fault, and pass without it, those of few faults first."""
    originals = {fault.module: (tree / fault.module).read_bytes() for fault in faults}
    probed = dict(originals)
    for number, fault in sorted(enumerate(faults), key=lambda pair: -pair[1].begin):
        probed[fault.module] = fault.probe_in(probed[fault.module], number)
    for module, source in probed.items():
        change(tree / module, source, 1)
    run([*PYTEST, "-p", "planted_probe", *words], tree, seconds)
    for module, source in originals.items():
        change(tree / module, source, 2)
    lines = (tree.parent / "probes").read_text().splitlines()
    return tests_of(len(faults), dict.fromkeys(tuple(line.split("\t")) for line in lines))


def tests_of(count: int, told: dict[tuple[str, ...], None]) -> list[list[str]]:
    """Of what probes told, (number of the fault or 'fails', test), the tests of each fault."""
    failing = {test for said, test in told if said == "fails"}
    pairs = [(said, test) for said, test in told if test not in failing]
    faults = Counter(test for _, test in pairs)
    return [
        sorted((test for said, test in pairs if said == str(n)), key=lambda t: faults[t])
        for n in range(count)
    ]


def plant(
    faults: Sequence[Fault], tests: Sequence[list[str]], tree: Path, seconds: float, end: float
) -> Counter[str]:
    """Plant faults one after the other, and print of each what became of it."""
    told = Counter[str]()
    for moment, (fault, those) in enumerate(zip(faults, tests, strict=True), 3):
        file = tree / fault.module
        source = file.read_bytes()
        change(file, fault.plant_in(source), 2 * moment)
        outcome = "not tried" if time.monotonic() > end else outcome_of(those, tree, seconds)
        change(file, source, 2 * moment + 1)
        told[outcome] += 1
        print(f"{outcome:12} {fault.tell(source)}  {len(those)} tests come by", flush=True)
    return told


def outcome_of(tests: Sequence[str], tree: Path, seconds: float) -> str:
    """What became of a fault that is planted in the tree."""
    if not tests:
        return "not reached"
    names = tree.parent / "tests"
    for chosen in (tests, dict.fromkeys(test.partition("::")[0] for test in tests)):
        names.write_text("\n".join(chosen))
        status, spent = run([*PYTEST, "-x", f"@{names}"], tree, seconds)
        seconds -= spent
        if seconds <= 0:
            return "out of time"
        if status:
            return "caught"
    return "missed"


def main() -> int:
    """Plant faults; status 1 where one of them was not caught."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("files", nargs="*", help="of tests")
    parser.add_argument("--fast", action="store_true", help="leave slow tests out")
    parser.add_argument("--jobs", type=int, default=1, help="processes of the first run")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--hours", type=float, default=2.0, help="in all")
    parser.add_argument("--seconds", type=float, default=120.0, help="CPU for one fault")
    parser.add_argument("--within", nargs="*", default=[], help="parts of voronec/")
    chosen = parser.parse_args()
    limit = 3600 * chosen.hours
    end = time.monotonic() + limit
    faults = draw(chosen.seed, chosen.count, chosen.within)
    words = [*chosen.files, *(("-m", "not slow") if chosen.fast else ())]
    if chosen.jobs > 1:
        words += ["-n", str(chosen.jobs), "--dist", "worksteal"]
    with tempfile.TemporaryDirectory() as place:
        tree = Path(place).resolve() / "tree"
        copy_of_tree(tree)
        (tree / "planted_probe.py").write_text(PROBE)
        tests = reach(faults, tree, words, limit)
        told = plant(faults, tests, tree, chosen.seconds, end)
    counts = ", ".join(f"{n} {outcome}" for outcome, n in sorted(told.items()))
    print(f"seed {chosen.seed}, {len(faults)} faults: {counts}")
    return int(told["caught"] < len(faults))


if __name__ == "__main__":
    sys.exit(main())
