"""Faults planted into the engine one at a time, and whether the tests notice.

    python tools/planted_faults.py map MAP [TEST FILES ...] [--fast]
    python tools/planted_faults.py plant MAP [--seed 1] [--count 60] [--within motion/steppers ...]

``map`` runs each test file in a process of its own under coverage and writes which lines of
``voronec/`` it runs, and its CPU seconds.  ``plant`` draws faults by seed: a sign turned, an index
or a bound moved by one, a condition turned, a term dropped.  Of each it runs the test files that
reach its line, those first of which the faulty module is the largest part, up to the first failure
or for ``--seconds`` of CPU; the last line counts those that were caught.  Faults live in a copy of
the tree.  It needs ``coverage`` (``pip install coverage``).
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import random
import resource
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
PARTS = (".ci", "docs", "systems", "tests", "tools", "voronec")
PYTEST = (sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider")
FAST = ("-m", "not slow")
NOTHING_TO_RUN = 5
"""What pytest returns where all tests of a file are left out."""
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
    """All faults that can be planted into one module, but into what only annotates."""
    starts = [0]
    for line in source.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    found = []
    for node in ast.walk(ast.parse(source)):
        for kind, part, text in variants(node):
            begin = starts[part.lineno - 1] + part.col_offset
            end = starts[(part.end_lineno or 0) - 1] + (part.end_col_offset or 0)
            if "TYPE_CHECKING" not in text and not _joins_text(part):
                found.append(Fault(module, part.lineno, kind, begin, end, f"({text})"))
    return found


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

    environment = {**os.environ, "PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1"}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        words, cwd=folder, env=environment, preexec_fn=bound,
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False,
    )  # fmt: skip
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return done.returncode, spent


def make_map(target: Path, files: Sequence[str], fast: bool) -> None:
    """Write what each test file reaches; what fails without a fault is told and left out."""
    from coverage import CoverageData

    reached: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as place:
        tree = Path(place).resolve() / "tree"
        copy_of_tree(tree)
        chosen = files or sorted(str(p.relative_to(ROOT)) for p in ROOT.glob("tests/test_*.py"))
        data = tree / "data.coverage"
        cover = [sys.executable, "-m", "coverage", "run", f"--data-file={data}"]
        cover += [f"--source={tree / 'voronec'}", "-m", *PYTEST[2:]]
        for file in chosen:
            data.unlink(missing_ok=True)
            status, spent = run([*cover, file, *(FAST if fast else ())], tree, 3600)
            if status:
                said = "nothing to run" if status == NOTHING_TO_RUN else "fails without a fault"
                print(f"{file}: {said}", flush=True)
                continue
            kept = CoverageData(str(data))
            kept.read()
            lines = {
                str(Path(f).relative_to(tree)): sorted(kept.lines(f) or ())
                for f in kept.measured_files()
            }
            reached[file] = {"seconds": spent, "lines": lines, "fast": fast}
            print(f"{file}: {spent:.1f} s", flush=True)
    target.write_text(json.dumps(reached))


def tests_of(fault: Fault, reached: dict[str, Any]) -> list[str]:
    """Test files that run its line, those that are most about its module first."""

    def part(file: str) -> float:
        lines = reached[file]["lines"]
        return len(lines[fault.module]) / sum(map(len, lines.values()))

    meeting = [f for f, r in reached.items() if fault.line in r["lines"].get(fault.module, ())]
    return sorted(meeting, key=part, reverse=True)


def draw(seed: int, count: int, within: Sequence[str]) -> list[Fault]:
    """As many faults of each kind as of any other, each in a module drawn by its size."""
    generator, by_kind = random.Random(seed), dict[str, list[Fault]]()
    for path in sorted((ROOT / "voronec").rglob("*.py")):
        module = str(path.relative_to(ROOT))
        if not within or any(module.startswith(f"voronec/{w}") for w in within):
            for fault in faults_in(module, path.read_bytes()):
                by_kind.setdefault(fault.kind, []).append(fault)
    kinds = sorted(by_kind)
    return [generator.choice(by_kind[kinds[i % len(kinds)]]) for i in range(count)]


def plant(
    target: Path, seed: int, count: int, within: Sequence[str], seconds: float
) -> Counter[str]:
    """Plant faults one after the other, and print of each what became of it."""
    reached, told = json.loads(target.read_text()), Counter[str]()
    with tempfile.TemporaryDirectory() as place:
        tree = Path(place).resolve() / "tree"
        copy_of_tree(tree)
        for fault in draw(seed, count, within):
            file = tree / fault.module
            source = file.read_bytes()
            file.write_bytes(fault.plant_in(source))
            outcome, by = outcome_of(fault, reached, tree, seconds)
            file.write_bytes(source)
            told[outcome] += 1
            print(f"{outcome:12} {fault.tell(source)}  {by}", flush=True)
    return told


def outcome_of(
    fault: Fault, reached: dict[str, Any], tree: Path, seconds: float
) -> tuple[str, str]:
    """What became of a fault, and the test file that caught it."""
    files, left = tests_of(fault, reached), seconds
    for file in files:
        words = [*PYTEST, file, *(FAST if reached[file]["fast"] else ())]
        status, spent = run(words, tree, left)
        left -= spent
        if status and left > 0:
            return "caught", file
        if left <= 0:
            return "out of time", f"after {seconds:g} s"
    return ("missed" if files else "not reached"), f"{len(files)} test files reach it"


def main() -> int:
    """Make a map, or plant faults; status 1 where one of them was not caught."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    jobs = parser.add_subparsers(dest="job", required=True)
    mapping, planting = jobs.add_parser("map"), jobs.add_parser("plant")
    for one in (mapping, planting):
        one.add_argument("map", type=Path)
    mapping.add_argument("files", nargs="*")
    mapping.add_argument("--fast", action="store_true", help="leave slow tests out")
    planting.add_argument("--seed", type=int, default=1)
    planting.add_argument("--count", type=int, default=60)
    planting.add_argument("--seconds", type=float, default=120.0, help="CPU for one fault")
    planting.add_argument("--within", nargs="*", default=[], help="parts of voronec/")
    chosen = parser.parse_args()
    if chosen.job == "map":
        if find_spec("coverage") is None:
            parser.error("coverage is not installed; 'pip install coverage' gets it")
        make_map(chosen.map, chosen.files, chosen.fast)
        return 0
    told = plant(chosen.map, chosen.seed, chosen.count, chosen.within, chosen.seconds)
    counts = ", ".join(f"{n} {outcome}" for outcome, n in sorted(told.items()))
    print(f"seed {chosen.seed}, {chosen.count} faults: {counts}")
    return int(told["caught"] < chosen.count)


if __name__ == "__main__":
    sys.exit(main())
