"""DOP853 and the program compiled by the machine's own C compiler: the loop of numba without it.

The stepping is the source that ``numba`` compiles (``dop853_source``), translated statement by
statement; the right side is the program as C.  Of what a user writes only printed expressions reach
the compiler, whose names and remarks are made harmless there.
"""

from __future__ import annotations

import ast
import ctypes
import inspect
import re
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from voronec.equations.program import Program, c_source, hoist
from voronec.motion.steppers.dop853_source import growth, stepping_key, stepping_source
from voronec.motion.steppers.kept_code import kept_library

ARRAYS = {
    "grid": "double *grid", "rows": "double (*rows)[N]", "clock": "double *clock",
    "counts": "integer *counts", "states": "double (*states)[N]", "bend": "double (*bend)[N]",
    "times": "double (*times)[2]", "ends": "double (*ends)[2][N]",
    "bends": "double (*bends)[7][N]", "scales": "double (*scales)[N]", "coarse": "integer *coarse",
    "parameters": "double *parameters", "given": "double *given",
}  # fmt: skip
"""What ``drive`` is given, in order, before three integers; its lengths come after them."""
LENGTHS = ("grid", "times", "coarse")
COUNTS = frozenset((
    "i", "j", "trial", "done", "steps", "evaluations", "kept", "outcome", "rejected", "happening",
    "searched", "good",
))  # fmt: skip
"""Names in ``drive`` that are integers; others are doubles."""
PARAMETERS = {
    **ARRAYS, "row": "double *row", "dense": "integer dense", "keep": "integer keep",
    "limit": "integer limit",
}  # fmt: skip
OPERATORS: dict[type, str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">",
    ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=", ast.And: "&&", ast.Or: "||", ast.USub: "-",
    ast.Not: "!",
}  # fmt: skip
CALLS = {"abs": "fabs", "min": "smaller", "max": "larger", "nextafter": "nextafter"}
SMALL = 60.0
"""A right side up to this weight is written into each stage; it takes longer to compile."""
BESIDE = "BESIDE"
INLINE = f"""#if defined(__GNUC__)
#define {BESIDE} static inline __attribute__((always_inline))
#else
#define {BESIDE} static
#endif
"""
EXTREMES = """#include <math.h>
static double smaller(double a, double b) { return b < a ? b : a; }
static double larger(double a, double b) { return b > a ? b : a; }
"""
HEAD = """#define N {n}
typedef long long integer;
void levels(double t, const double *state, const double *parameters, double *result);
"""


@lru_cache(maxsize=32)
def c_loop(program: Program, levels: Program | None = None) -> Callable[..., int]:
    """The function ``drive`` of ``dop853_source`` for a program and functions of events.

    Raises ``DefinitionError`` where there is no compiler, and ``EngineLimit`` where it fails.
    """
    texts = [c_source(hoist(program).program)] + ([c_source(levels)] if levels else [])
    key = "\n".join([*texts, stepping_key(), Path(__file__).read_text(encoding="utf-8")])
    drive = kept_library(key, lambda: _sources(texts, program, levels)).drive
    count = len(ARRAYS)
    drive.restype, integer = ctypes.c_longlong, ctypes.c_longlong
    drive.argtypes = [*([ctypes.c_void_p] * count), *([integer] * (3 + len(LENGTHS)))]
    places = [list(ARRAYS).index(name) for name in LENGTHS]

    def run(*arguments: Any) -> int:
        # arrays of known kinds, in one piece each: to have ctypes look at them takes longer than
        # most of what is asked for
        addresses = [array.ctypes.data for array in arguments[:count]]
        lengths = [len(arguments[place]) for place in places]
        return int(drive(*addresses, *arguments[count:], *lengths))

    return run


def growth_source() -> str:
    """The function ``growth`` of ``dop853_source`` in C, with what it calls."""
    tree = ast.parse(inspect.getsource(growth)).body[0]
    assert isinstance(tree, ast.FunctionDef)
    return EXTREMES + _Function(tree, 0).text()


def _sources(texts: Sequence[str], program: Program, levels: Program | None) -> dict[str, str]:
    """Files of C by name: the loop with the right side, and functions of events apart."""
    n, m = len(program.state), len(levels.names) if levels is not None else 0
    kind = BESIDE if program.weight <= SMALL else "static"
    right = re.sub(r"^void ", f"{kind} void ", texts[0], flags=re.MULTILINE)
    tree = ast.parse(stepping_source(n, m))
    functions = [f for f in tree.body if isinstance(f, ast.FunctionDef)]
    body = "\n".join(_Function(f, max(n, m)).text() for f in functions)
    files = {"drive.c": INLINE + right + EXTREMES + HEAD.format(n=n) + body}
    if levels is not None:  # its own rates are not wanted
        files["levels.c"] = "#define rhs rates_of_levels\n#define extras levels\n" + texts[1]
    return files


class _Function:
    """One function, translated: its names are doubles, or ``COUNTS``."""

    def __init__(self, tree: ast.FunctionDef, room: int) -> None:
        self.tree, self.room = tree, room
        self.arguments = [a.arg for a in tree.args.args]
        self.local: dict[str, str] = {}

    def text(self) -> str:
        """The function in C."""
        body = [row for line in self.tree.body for row in self.statement(line)]
        names = sorted({*self._targets()} - {*self.arguments} - self.local.keys())
        declared = [*self.local.values(), f"double answers[{max(self.room, 1)}];"]
        declared += [f"{'integer' if n in COUNTS else 'double'} {n} = 0;" for n in names]
        arguments = [PARAMETERS.get(n, f"double {n}") for n in self.arguments]
        is_loop = self.tree.name == "drive"
        if is_loop:
            arguments += [f"integer {n}_count" for n in LENGTHS]
        returns = "integer" if is_loop else "void" if "row" in self.arguments else "double"
        opening = (
            f"{'' if is_loop else 'static '}{returns} {self.tree.name}({', '.join(arguments)})"
        )
        return "\n".join([opening + " {", *declared, "(void)answers;", *body, "}\n"])

    def _targets(self) -> Iterator[str]:
        """Names that are assigned."""
        for node in ast.walk(self.tree):
            if isinstance(node, ast.For):
                yield ast.unparse(node.target)
            elif isinstance(node, ast.Assign):
                yield from (t.id for t, _ in _pairs(node) if isinstance(t, ast.Name))

    def statement(self, node: ast.stmt) -> list[str]:
        """A statement as lines."""
        if isinstance(node, ast.Assign):
            return self.assignment(node)
        if isinstance(node, ast.AugAssign):
            sign = OPERATORS[type(node.op)]
            return [f"{self.value(node.target)} {sign}= {self.value(node.value)};"]
        if isinstance(node, ast.If):
            rows = [f"if ({self.value(node.test)}) {{", *self.block(node.body)]
            return [*rows, *(["} else {", *self.block(node.orelse)] if node.orelse else []), "}"]
        if isinstance(node, ast.While):
            return [f"while ({self.value(node.test)}) {{", *self.block(node.body), "}"]
        if isinstance(node, ast.For) and isinstance(node.iter, ast.Call):
            name, limits = self.value(node.target), [self.value(a) for a in node.iter.args]
            first, last = limits if len(limits) == 2 else ("0", limits[0])
            head = f"for ({name} = {first}; {name} < {last}; {name}++) {{"
            return [head, *self.block(node.body), "}"]
        if isinstance(node, ast.Break | ast.Continue):
            return ["break;" if isinstance(node, ast.Break) else "continue;"]
        if isinstance(node, ast.Return) and node.value is not None:
            return [f"return {self.value(node.value)};"]
        if isinstance(node, ast.Expr):  # a docstring says nothing to the compiler
            return [] if isinstance(node.value, ast.Constant) else [f"{self.value(node.value)};"]
        if isinstance(node, ast.Pass):
            return []
        raise TypeError(f"no C for '{ast.unparse(node)}'")

    def block(self, body: Sequence[ast.stmt]) -> list[str]:
        return [row for node in body for row in self.statement(node)]

    def assignment(self, node: ast.Assign) -> list[str]:
        """What is assigned at once is computed before any of it changes."""
        pairs = _pairs(node)
        if pairs[0][1] is None:
            return self.call(pairs, node.value)
        made = [p for p in pairs if _array(p[1]) is not None]
        for target, value in made:
            kind, sizes = _array(value) or ("", [])
            bounds = "".join(f"[{size}]" for size in sizes)
            self.local[ast.unparse(target)] = f"{kind} {ast.unparse(target)}{bounds} = {{0}};"
        if made:
            return []
        if len(pairs) == 1:
            return [f"{self.value(pairs[0][0])} = {self.value(pairs[0][1])};"]
        rows = [f"const double next_{i} = {self.value(b)};" for i, (_, b) in enumerate(pairs)]
        rows += [f"{self.value(a)} = next_{i};" for i, (a, _) in enumerate(pairs)]
        return ["{", *rows, "}"]

    def call(self, pairs: Sequence[tuple[Any, Any]], call: Any) -> list[str]:
        """The program at a state, whose entries are arguments of their own."""
        time, *place, parameters = (self.value(a) for a in call.args)
        rows = [f"const double here[] = {{{', '.join(place)}}};"]
        name = "rhs" if call.func.id == "rhs" else "levels"  # the program has extras of its own
        rows.append(f"{name}({time}, here, {parameters}, answers);")
        rows += [f"{self.value(target)} = answers[{i}];" for i, (target, _) in enumerate(pairs)]
        return ["{", *rows, "}"]

    def value(self, node: Any) -> str:
        """An expression."""
        if isinstance(node, ast.Constant):
            return repr(int(node.value) if isinstance(node.value, bool) else node.value)
        if isinstance(node, ast.Name):
            return node.id
        if isinstance(node, ast.Attribute) and node.attr == "inf":
            return "INFINITY"
        if isinstance(node, ast.UnaryOp):
            return f"({OPERATORS[type(node.op)]}{self.value(node.operand)})"
        if isinstance(node, ast.BoolOp):
            return f"({f' {OPERATORS[type(node.op)]} '.join(map(self.value, node.values))})"
        if isinstance(node, ast.Compare):
            sign = OPERATORS[type(node.ops[0])]
            return f"({self.value(node.left)} {sign} {self.value(node.comparators[0])})"
        if isinstance(node, ast.IfExp):
            parts = (self.value(p) for p in (node.test, node.body, node.orelse))
            return "({} ? {} : {})".format(*parts)
        if isinstance(node, ast.BinOp):
            return self.operation(node)
        if isinstance(node, ast.Subscript):
            return self.value(node.value) + "".join(
                f"[{self.index(node, i)}]" for i in _indices(node)
            )
        if isinstance(node, ast.Call):
            return self.function(node)
        raise TypeError(f"no C for '{ast.unparse(node)}'")

    def operation(self, node: ast.BinOp) -> str:
        left, right = self.value(node.left), self.value(node.right)
        if isinstance(node.op, ast.Pow):
            return f"sqrt({left})" if right == "0.5" else f"pow({left}, {right})"
        if isinstance(node.op, ast.Div):
            return f"((double)({left})/({right}))"
        return f"({left} {OPERATORS[type(node.op)]} {right})"

    def function(self, node: ast.Call) -> str:
        name = node.func.attr if isinstance(node.func, ast.Attribute) else ast.unparse(node.func)
        values = [self.value(a) for a in node.args]
        if name == "len":
            return f"{values[0]}_count"
        while name in ("min", "max") and len(values) > 2:
            values[:2] = [f"{CALLS[name]}({values[0]}, {values[1]})"]
        return f"{CALLS.get(name, name)}({', '.join(values)})"

    def index(self, node: ast.Subscript, place: ast.expr) -> str:
        text = self.value(place)
        return f"{self.value(node.value)}_count - 1" if text == "(-1)" else text


def _indices(node: ast.Subscript) -> list[ast.expr]:
    return node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]


def _pairs(node: ast.Assign) -> list[tuple[ast.expr, Any]]:
    """Targets with values, which are none where one call gives all of them."""
    target, value = node.targets[0], node.value
    if not isinstance(target, ast.Tuple):
        return [(target, value)]
    if isinstance(value, ast.Tuple):
        return list(zip(target.elts, value.elts, strict=True))
    return [(each, None) for each in target.elts]


def _array(node: Any) -> tuple[str, list[str]] | None:
    """The kind and sizes of a fresh array; None for anything else."""
    if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Attribute):
        return None
    if node.func.attr not in ("empty", "zeros"):
        return None
    shape = node.args[0]
    sizes = shape.elts if isinstance(shape, ast.Tuple) else [shape]
    return "integer" if node.func.attr == "zeros" else "double", [ast.unparse(s) for s in sizes]
