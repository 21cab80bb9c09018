"""The house in figures: rooms, circles, lines, lone modules, files on the way, CPU of commands and
of imports of systems.

    python tools/measure_house.py [--json] [--arrows] [--lone] [--files] [--quick] [--room ROOM]

Lines are those of code: docstrings, comments, blank lines and imports aside.  A circle is a set of
modules that import one another, names that only annotate and imports inside functions included.  A
file is on the way of a job where one of its functions runs: once the job has run before, so that
what is kept of systems and programs is there, and the first time, with all that makes it.  Of one
room: its lines without folders of pictures, its circles, and which files reach past the front of a
folder in it, its ``__init__``, from outside of that folder.
"""

from __future__ import annotations

import argparse
import ast
import collections
import importlib
import io
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
import tokenize
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "voronec"
ASIDE = {"__main__.py", "py.typed", "__pycache__"}
BEST_OF = 5
IMPORT_RUNS, LARGEST = 2, 8
PICTURES = {"pictures", "viewer"}
"""Folders of a room that show results; who shows them takes what they draw with."""
LISTS = {"arrows between rooms": "arrows", "imported by one": "lone"}
"""What is counted, and listed where its option asks for it."""
COMMANDS = {"list": ["list"], "check sleigh": ["check", "sleigh"]}


def main() -> int:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--arrows", action="store_true", help="list what rooms import of others")
    parser.add_argument("--lone", action="store_true", help="list modules with a single importer")
    parser.add_argument("--files", action="store_true", help="name the files on the way")
    parser.add_argument("--quick", action="store_true", help="run nothing, read the tree alone")
    parser.add_argument("--room", help="the figures of one room alone")
    chosen = parser.parse_args()
    graph = imports()
    if chosen.room:
        return _print_room(chosen.room, graph)
    found: dict[str, Any] = {
        "entries of voronec/": len([p for p in PACKAGE.iterdir() if p.name not in ASIDE]),
        "layers of the contract": _layers(),
        "modules": len(graph),
        "circles": [sorted(c) for c in circles(graph)],
        "arrows between rooms": arrows(graph),
        "lines of voronec/": sum(lines(p) for p in PACKAGE.rglob("*.py")),
        "lines of systems/ but demchenko": sum(map(lines, _systems())),
        "of these in sketches, shapes and words": sum(map(_picture_lines, _systems())),
        "imported by one": _lone(graph),
    }
    if not chosen.quick:
        found["files on the way"] = {job: _way(job, "again") for job in JOBS}
        found["files on the way the first time"] = {job: _way(job, "first") for job in JOBS}
        found["largest import costs, CPU ms"] = _import_costs()
        found["CPU seconds"] = {name: _seconds(words) for name, words in COMMANDS.items()}
    if chosen.json:
        print(json.dumps(found, indent=1))
        return 0
    for name, value in found.items():
        if isinstance(value, dict) and name not in LISTS:
            print(f"{name}: " + ", ".join(f"{k} {_count(v)}" for k, v in value.items()))
        else:
            print(f"{name}: {_count(value)}")
    for circle in found["circles"]:
        print("  circle: " + " ".join(circle))
    for name, option in LISTS.items():
        for item, told in found[name].items() if getattr(chosen, option) else ():
            print(f"  {item}: {told}")
    for job, files in found.get("files on the way", {}).items() if chosen.files else ():
        print(f"  {job}: " + " ".join(files))
    return 0


def _print_room(room: str, graph: dict[str, set[str]]) -> int:
    folder, whole = PACKAGE / room, f"voronec.{room}"
    files = [p for p in folder.rglob("*.py") if not PICTURES & {*p.relative_to(folder).parts}]
    print(f"code of {room}/ without {' and '.join(sorted(PICTURES))}: {sum(map(lines, files))}")
    inside = [c for c in circles(graph) if any(m.startswith(whole) for m in c)]
    print(f"circles: {len(inside)}")
    found = past_fronts(room, graph)
    print(f"imports past the front of a folder: {len(found)}")
    for a, b in found:
        print(f"  {a} -> {b}")
    return 0


def past_fronts(room: str, graph: dict[str, set[str]]) -> list[tuple[str, str]]:
    """Modules that import from inside of a folder of a room and lie outside of it, with what they
    import; folders of pictures aside."""
    fronts = [_name(p) for p in (PACKAGE / room).rglob("__init__.py")]
    fronts = [f for f in fronts if f != f"voronec.{room}" and f.rpartition(".")[2] not in PICTURES]
    pairs = ((a, b, f) for a in graph for b in graph[a] for f in fronts if b.startswith(f + "."))
    return sorted((a, b) for a, b, f in pairs if not f"{a}.".startswith(f + "."))


def _count(value: Any) -> Any:
    return len(value) if isinstance(value, list | dict) else value


def imports() -> dict[str, set[str]]:
    """Module -> modules of the package that it imports, wherever the import stands."""
    files = {_name(p): p for p in PACKAGE.rglob("*.py")}
    return {name: set(_imports_of(name, path, files)) for name, path in files.items()}


def _name(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _imports_of(name: str, path: Path, files: dict[str, Path]) -> Iterator[str]:
    for node in _statements(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            yield from (a.name for a in node.names if a.name in files)
        elif isinstance(node, ast.ImportFrom) and node.module in files:
            for alias in node.names:
                inner = f"{node.module}.{alias.name}"
                found = inner if inner in files else node.module
                if found != name:
                    yield found


def _statements(node: ast.AST) -> Iterator[ast.AST]:
    """What stands below a node, expressions aside."""
    for inner in ast.iter_child_nodes(node):
        if not isinstance(inner, ast.expr):
            yield inner
            yield from _statements(inner)


def _room(module: str) -> str:
    return [*module.split("."), ""][1]


def arrows(graph: dict[str, set[str]]) -> dict[str, int]:
    """Which room imports of which other one, and by how many imports of modules, the fewest first.

    What a room imports of itself is no arrow; the package's own names are a room.
    """
    rooms = ((_room(a) or "voronec", _room(b) or "voronec") for a in graph for b in graph[a])
    found = collections.Counter(f"{a} -> {b}" for a, b in rooms if a != b)
    return dict(sorted(found.items(), key=lambda item: (item[1], item[0])))


def circles(graph: dict[str, set[str]]) -> list[set[str]]:
    """Sets of modules that import one another."""
    import networkx as nx

    edges = [(a, b) for a in graph for b in graph[a]]
    return [c for c in nx.strongly_connected_components(nx.DiGraph(edges)) if len(c) > 1]


def _lone(graph: dict[str, set[str]]) -> dict[str, str]:
    """Modules that exactly one other imports, with that other and the idea that each holds."""
    importers: dict[str, list[str]] = collections.defaultdict(list)
    for a in graph:
        for b in graph[a]:
            importers[b].append(a)
    files = {_name(p): p for p in PACKAGE.rglob("*.py")}
    return {
        f"{m} <- {importers[m][0]}": _idea(files[m])
        for m in sorted(graph)
        if len(importers[m]) == 1 and files[m].name != "__init__.py"
    }


def _idea(path: Path) -> str:
    return (ast.get_docstring(ast.parse(path.read_text("utf-8"))) or "").partition("\n")[0]


def _layers() -> int:
    import tomllib

    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    contracts = project["tool"]["importlinter"]["contracts"]
    return sum(len(c["layers"]) for c in contracts if c["type"] == "layers")


def lines(path: Path) -> int:
    """Lines of code of a file: docstrings, comments, blank lines and imports aside."""
    text = path.read_text("utf-8")
    skip: set[int] = set()
    for node in ast.walk(ast.parse(text)):
        bare = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        if isinstance(node, ast.Import | ast.ImportFrom) or (
            bare and isinstance(node.value.value, str)  # type: ignore[attr-defined]
        ):
            skip.update(range(node.lineno, (node.end_lineno or node.lineno) + 1))  # type: ignore[attr-defined]
    kept: set[int] = set()
    void = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT}
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type not in void | {tokenize.ENDMARKER}:
            kept.update(range(token.start[0], token.end[0] + 1))
    return len(kept - skip)


def _systems() -> list[Path]:
    return [p for p in (ROOT / "systems").rglob("*.py") if "demchenko" not in p.parts]


def _picture_lines(path: Path) -> int:
    """Lines of a file that declare what is drawn of a system, and what its letters are in words."""
    kept: set[int] = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        named = isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "SKETCH"
        if named or (
            isinstance(node, ast.keyword) and node.arg in ("sketch", "shapes", "meanings")
        ):
            kept.update(range(node.lineno, (node.end_lineno or 0) + 1))  # type: ignore[attr-defined]
    return len(kept)


def _derive() -> None:
    import voronec as vo

    vo.derive(vo.load("sleigh"))


def _integrate() -> None:
    import voronec as vo

    vo.integrate(vo.load("vertical-disc"), times=[0.0, 1.0])


def _closed_form() -> None:
    import voronec as vo

    vo.closed_form(vo.load("demchenko")).at([0.5])


def _check() -> None:
    import voronec as vo

    vo.check_catalogue(["sleigh"])


JOBS: dict[str, Callable[[], None]] = {
    "derive sleigh": _derive,
    "integrate vertical-disc": _integrate,
    "closed form to a number": _closed_form,
    "check sleigh": _check,
}


def _way(job: str, when: str) -> list[str]:
    """The files of the package that a job runs through, in a process of its own."""
    return _alone(f"*m.files_of({job!r}, {when!r})").split()


def _alone(call: str) -> str:
    """What a function of this file gives in a process of its own, as a line."""
    command = [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(ROOT / 'tools')!r}); "
               f"import measure_house as m; print({call})"]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return done.stdout.splitlines()[-1]


def _import_costs() -> dict[str, int]:
    """The systems that take longest to import, the better of two runs of each."""
    import voronec as vo

    runs = {n: [float(_alone(f"m.import_cost({n!r})")) for _ in range(IMPORT_RUNS)]
            for n in vo.names()}  # fmt: skip
    largest = sorted(runs, key=lambda name: min(runs[name]), reverse=True)[:LARGEST]
    return {name: round(min(runs[name])) for name in largest}


def import_cost(name: str) -> float:
    """Milliseconds of CPU that a system takes beyond the engine and the modules that it names."""
    import sympy  # noqa: F401

    import voronec as vo
    from voronec.declaration.catalogue import entry_of

    vo.load("vertical-disc" if name == "sleigh" else "sleigh")
    files = {_name(p): p for p in PACKAGE.rglob("*.py")}
    path = entry_of(name).origin
    for module in _imports_of("", path, files) if path else ():
        importlib.import_module(module)
    before = time.process_time()
    vo.load(name)
    return 1000 * (time.process_time() - before)


def files_of(job: str, when: str) -> list[str]:
    """The files of the package in which functions run during a job, imports aside: ``first`` or
    ``again``."""
    if when == "again":
        JOBS[job]()
    seen: set[str] = set()

    def profile(frame: Any, event: str, _: Any) -> None:
        if event == "call" and frame.f_code.co_name != "<module>":
            seen.add(frame.f_code.co_filename)

    sys.setprofile(profile)
    try:
        JOBS[job]()
    finally:
        sys.setprofile(None)
    own = {Path(s) for s in seen if Path(s).is_relative_to(PACKAGE)}
    return sorted(str(p.relative_to(PACKAGE)) for p in own)


def _seconds(words: list[str]) -> float:
    """CPU of a command, the best of several, with a folder for results that is known to it."""
    best = float("inf")
    with tempfile.TemporaryDirectory() as home:
        environment = {**os.environ, "XDG_CACHE_HOME": home}
        for _ in range(BEST_OF + 1):
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run(
                [sys.executable, "-m", "voronec", *words],
                env=environment,
                capture_output=True,
                check=False,
            )
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            best = min(best, after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime)
    return round(best, 2)


if __name__ == "__main__":
    sys.exit(main())
