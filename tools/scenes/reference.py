"""The referee of the fuzzer: Lagrange's equations with multipliers, in extended precision.

The system is taken as its author wrote it, in SymPy.  SymPy alone differentiates; the equations
become C, and ``reference.c`` beside this file integrates them in ``long double`` or
``__float128``.  Nothing here is shared with the engine that is judged.

    d/dt dL/dw_a - X_a L + C_ab^c w^b dL/dw_c = Q_a + (A^T lambda)_a,    A wdot = b

for velocities w with qdot = rates(q, w), which are the velocities of the coordinates unless the
system stands on a group.  Constraints and relations of redundant coordinates are differentiated.
"""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, reduce
from pathlib import Path
from typing import Any

import mpmath as mp
import numpy as np
import sympy as sp
from sympy.core.function import AppliedUndef

HERE = Path(__file__).with_suffix(".c")
PRECISIONS = {
    "long double": {
        "REAL": "long double", "tail": "l", "header": "", "library": "-lm",
        "epsilon": "1.1e-19L", "negligible": "1e-15L", "ratio": "1",
    },
    "quad": {
        "REAL": "__float128", "tail": "q", "header": "#include <quadmath.h>",
        "library": "-lquadmath", "epsilon": "2e-34Q", "negligible": "1e-26Q", "ratio": "1e-10",
    },
}  # fmt: skip
OUTCOMES = ("done", "singular", "stuck", "budget", "ambiguous")
NEWTON = 50
"""Steps of Newton's method to a relation at most: what a start is off stays so all along."""


class NoReferee(Exception):
    """The system holds something that the referee cannot judge."""


@dataclass(frozen=True)
class Mechanics:
    """A system in the referee's own symbols: q0.. coordinates, w0.. velocities, p0.. parameters."""

    coordinates: tuple[str, ...]
    velocities: tuple[str, ...]
    parameters: tuple[str, ...]
    q: tuple[sp.Symbol, ...]
    w: tuple[sp.Symbol, ...]
    p: tuple[sp.Symbol, ...]
    rates: tuple[sp.Expr, ...]
    brackets: Mapping[tuple[int, int], Mapping[int, sp.Expr]]
    lagrangian: sp.Expr
    forces: tuple[sp.Expr, ...]
    constraints: tuple[sp.Expr, ...]
    relations: tuple[sp.Expr, ...]
    independent: tuple[sp.Expr, ...]
    names: Mapping[Any, sp.Expr]

    def own(self, expr: sp.Expr) -> sp.Expr:
        """An expression in the system's symbols, in the referee's."""
        return sp.sympify(expr).xreplace(dict(self.names)).xreplace(dict(self.names))

    def meaning(self, system: Any, name: str) -> sp.Expr:
        """A coordinate, a velocity or an invariant by name, in the referee's symbols."""
        if name in self.coordinates:
            return self.q[self.coordinates.index(name)]
        if name in self.velocities:
            return self.independent[self.velocities.index(name)]
        return self.own(system.invariants[name])


time = sp.Symbol("t")


def mechanics_of(system: Any, inputs: Mapping[Any, sp.Expr] | None = None) -> Mechanics:
    """Read a system's declarations; functions of the time among them take the place of inputs."""
    coordinates = tuple(system.coordinates)
    frame = system.frame
    group = frame is not None and frame.is_group
    q = sp.symbols(f"q0:{len(coordinates)}", real=True)
    ambient = tuple(frame.ambient) if group else tuple(map(_rate_of, coordinates))
    w = sp.symbols(f"w0:{len(ambient)}", real=True)
    given = dict(inputs or {})
    parameters = tuple(p.symbol for p in system.parameters if p.symbol not in given)
    p = sp.symbols(f"p0:{len(parameters)}", real=True)
    names: dict[Any, sp.Expr] = dict(given)
    names |= dict(zip(parameters, p, strict=True))
    names |= dict(zip(coordinates, q, strict=True)) | dict(zip(ambient, w, strict=True))
    rates, independent = _named_velocities(system, w, names)
    directions = ambient if group else coordinates

    def read(expr: Any) -> sp.Expr:
        return sp.sympify(expr).xreplace(names)

    brackets = {
        (ambient.index(a), ambient.index(b)): {ambient.index(c): read(e) for c, e in parts.items()}
        for (a, b), parts in ((frame.brackets or {}) if group else {}).items()
    }

    return Mechanics(
        coordinates=tuple(map(_text, coordinates)),
        velocities=tuple(map(_text, system.velocities)),
        parameters=tuple(map(_text, parameters)),
        q=q, w=w, p=p, rates=rates, brackets=brackets,
        lagrangian=read(system.lagrangian),
        forces=tuple(read(system.forces.get(x, 0)) for x in directions),
        constraints=tuple(map(read, system.constraints)),
        relations=tuple(map(read, system.fibration.relations)),
        independent=independent, names=names,
    )  # fmt: skip


def _named_velocities(system: Any, w: Any, names: dict[Any, sp.Expr]) -> tuple[Any, Any]:
    """The rates of the coordinates and the independent velocities; what names them is added."""
    frame = system.frame
    if frame is None:
        return w, tuple(w[: len(system.velocities)])
    if frame.is_group:
        rates = tuple(sp.sympify(frame.rates[x]).xreplace(names) for x in system.coordinates)
        names |= {_rate_of(x): r for x, r in zip(system.coordinates, rates, strict=True)}
        return rates, tuple(names[v] for v in frame.velocities)
    own = tuple(sp.sympify(e).xreplace(names) for e in frame.expressions)
    names |= dict(zip(frame.velocities, own, strict=True))
    return w, own


def _rate_of(x: sp.Expr) -> sp.Expr:
    """The symbol of a coordinate's velocity, as the engine's users write it."""
    return sp.Symbol(f"{x}dot") if isinstance(x, sp.Symbol) else sp.Derivative(x, time)


def _text(x: sp.Expr) -> str:
    if isinstance(x, sp.Derivative):
        return _text(x.expr) + "dot"
    return str(x.func) if isinstance(x, sp.core.function.AppliedUndef) else str(x)


@dataclass
class _Switches:
    """Functions whose signs stand for what is not smooth."""

    functions: list[sp.Expr] = field(default_factory=list)

    def sign(self, expr: sp.Expr) -> sp.Expr:
        for k, known in enumerate(self.functions):
            if known == expr:
                return sp.Symbol(f"g{k}")
            if known == -expr:
                return -sp.Symbol(f"g{k}")
        self.functions.append(expr)
        return sp.Symbol(f"g{len(self.functions) - 1}")

    def smooth(self, expr: sp.Expr) -> sp.Expr:
        """The same expression on one side of each switch."""
        if not expr.args or not expr.has(
            sp.Abs, sp.sign, sp.Heaviside, sp.Max, sp.Min, sp.Piecewise, sp.floor, sp.ceiling
        ):
            return expr
        if isinstance(expr, sp.Piecewise):
            return self._piecewise(expr)
        args = [self.smooth(a) for a in expr.args]
        if isinstance(expr, sp.Abs):
            return args[0] * self.sign(args[0])
        if isinstance(expr, sp.sign):
            return self.sign(args[0])
        if isinstance(expr, sp.Heaviside):
            return (1 + self.sign(args[0])) / 2
        if isinstance(expr, sp.Max):
            return reduce(lambda a, b: (a + b + self.sign(a - b) * (a - b)) / 2, args)
        if isinstance(expr, sp.Min):
            return reduce(lambda a, b: (a + b - self.sign(a - b) * (a - b)) / 2, args)
        if isinstance(expr, sp.floor | sp.ceiling):
            raise NoReferee(f"{expr.func}")
        return expr.func(*args)

    def _piecewise(self, expr: sp.Piecewise) -> sp.Expr:
        *pieces, (rest, otherwise) = expr.args
        if otherwise != sp.true:
            raise NoReferee("a piecewise function without an end")
        value = self.smooth(rest)
        for piece, condition in reversed(pieces):
            if not isinstance(condition, sp.Gt | sp.Ge | sp.Lt | sp.Le):
                raise NoReferee(f"the condition {condition}")
            side = self.sign(self.smooth(condition.gts - condition.lts))
            value = (1 + side) / 2 * self.smooth(piece) + (1 - side) / 2 * value
        return value


@dataclass(frozen=True)
class Motion:
    """A motion at the instants asked for: rows (q, w), in mpmath; how it ended, and where, and at
    which instant it was fastest."""

    states: list[list[Any]]
    outcome: str
    reached: float
    pivot: float
    steps: int
    crossings: int
    slides: int
    fastest: float


class Referee:
    """The multiplier equations of one system, compiled when they are first needed."""

    def __init__(self, mechanics: Mechanics) -> None:
        self.mechanics = m = mechanics
        self.switches = _Switches()
        L = self.switches.smooth(m.lagrangian)
        forces = [self.switches.smooth(f) for f in m.forces]
        # the rates of a group keep its relations
        kept = (r for r in map(self._rate, m.relations) if r.expand() != 0)
        rows = [*m.constraints, *kept]
        unknown = {f for e in (L, *forces, *rows) for f in e.atoms(AppliedUndef)}
        if unknown:
            raise NoReferee(f"the unknown function {min(unknown, key=str)}")
        if any(r.has(sp.Abs, sp.sign, sp.Max, sp.Min, sp.Heaviside, sp.Piecewise) for r in rows):
            raise NoReferee("a constraint that is not smooth")
        momenta = [L.diff(v) for v in m.w]
        turn = [sp.Integer(0)] * len(m.w)
        for (a, b), parts in m.brackets.items():
            for c, coefficient in parts.items():
                turn[a] += coefficient * m.w[b] * momenta[c]
                turn[b] -= coefficient * m.w[a] * momenta[c]
        self._mass = [p.diff(v) for p in momenta for v in m.w]
        along = [sum(L.diff(q) * r.diff(v) for q, r in zip(m.q, m.rates, strict=True)) for v in m.w]
        self._force = [
            f + x - self._rate(p) - s
            for f, x, p, s in zip(forces, along, momenta, turn, strict=True)
        ]
        self._rows = rows
        self._matrix = [r.diff(v) for r in rows for v in m.w]
        self._right = [-self._rate(r) for r in rows]
        self._libraries: dict[str, Any] = {}
        self._folder = tempfile.TemporaryDirectory(prefix="voronec-fuzz-")
        self._kinematics = sp.lambdify(
            (time, m.q, m.p),
            self._affine([*rows, *m.independent]),
            "mpmath",
        )
        self._relations = sp.lambdify(
            (m.q, m.p),
            [list(m.relations), [[r.diff(q) for q in m.q] for r in m.relations]],
            "mpmath",
        )

    def _rate(self, expr: sp.Expr) -> sp.Expr:
        """The time derivative, without accelerations."""
        m = self.mechanics
        moving = (expr.diff(q) * r for q, r in zip(m.q, m.rates, strict=True))
        return expr.diff(time) + sum(moving)

    def _affine(self, rows: Sequence[sp.Expr]) -> list[Any]:
        still = dict.fromkeys(self.mechanics.w, sp.Integer(0))
        return [
            [[r.diff(v).xreplace(still) for v in self.mechanics.w] for r in rows],
            [r.xreplace(still) for r in rows],
        ]

    def start(self, q: Sequence[Any], v: Sequence[Any], p: Sequence[Any], t: Any) -> list[Any]:
        """(q, w) on the relations and the constraints, in 40 digits."""
        with mp.workdps(max(40, mp.mp.dps)):
            q, p = self.onto_relations(q, p), _exact(p)
            matrix, offsets = self._kinematics(mp.mpf(t), q, p)
            sought = [mp.mpf(0)] * len(self._rows) + [mp.mpf(x) for x in v]
            right = mp.matrix([s - o for s, o in zip(sought, offsets, strict=True)])
            A = mp.matrix(matrix)
            w = mp.lu_solve(A, right) if A.rows == A.cols else _least(A, right)
            off = mp.norm(A * w - right, mp.inf)
            if not off < mp.mpf("1e-25") * (1 + mp.norm(w, mp.inf)) * 1e6:
                raise NoReferee("the constraints disagree at the start")
            return [*q, *w]

    def start_of_rates(
        self, q: Sequence[Any], w: Sequence[Any], p: Sequence[Any], t: Any
    ) -> list[Any]:
        """(q, w) of velocities of the coordinates, moved onto the constraints: declared velocities,
        which may be singular there, are not asked."""
        with mp.workdps(max(40, mp.mp.dps)):
            q, w, p = self.onto_relations(q, p), mp.matrix([mp.mpf(x) for x in w]), _exact(p)
            matrix, offsets = self._kinematics(mp.mpf(t), q, p)
            count = len(self._rows)
            if count:
                A = mp.matrix(matrix)[:count, :]
                off = A * w + mp.matrix([mp.mpf(x) for x in offsets[:count]])
                w -= A.T * mp.lu_solve(A * A.T, off)
            return [*q, *w]

    def onto_relations(self, q: Sequence[Any], p: Sequence[Any]) -> list[Any]:
        """Redundant coordinates moved onto their relations."""
        q, p = _exact(q), _exact(p)
        for _ in range(NEWTON if self.mechanics.relations else 0):
            values, slopes = self._relations(q, p)
            if max(map(abs, values)) < 4 * mp.eps:
                break
            A, b = mp.matrix(slopes), mp.matrix(values)
            q = [x - d for x, d in zip(q, A.T * mp.lu_solve(A * A.T, b), strict=True)]
        return q

    def reader(self, wanted: Sequence[sp.Expr]) -> Any:
        """A function of the time, a state (q, w) and the parameters: what is wanted, in mpmath."""
        m = self.mechanics
        read = sp.lambdify((time, m.q, m.w, m.p), list(wanted), "mpmath")
        return lambda t, state, p: read(mp.mpf(t), state[: len(m.q)], state[len(m.q) :], _exact(p))

    def equations(self, state: Sequence[Any], p: Sequence[float], t: Any) -> tuple[Any, ...]:
        """M (N, N), f (N, 1), A (k, N) and b (k, 1) of M wdot = f + A^T lambda, A wdot = b at a
        state (q, w), in mpmath."""
        found = self._parts(
            mp.mpf(t), state[: len(self.mechanics.q)], state[len(self.mechanics.q) :], _exact(p)
        )
        n, k = len(self.mechanics.w), len(self._rows)
        shapes = ((n, n), (n, 1), (k, n), (k, 1))
        return tuple(
            mp.matrix(rows, columns)
            if not rows
            else mp.matrix(np.array(part).reshape(rows, columns).tolist())
            for part, (rows, columns) in zip(found, shapes, strict=True)
        )

    @cached_property
    def _parts(self) -> Any:
        m = self.mechanics
        parts = [self._mass, self._force, self._matrix, self._right]
        return sp.lambdify((time, m.q, m.w, m.p), parts, "mpmath", cse=True)

    def motion(
        self,
        start: Sequence[Any],
        p: Sequence[float],
        t0: float,
        times: Sequence[float],
        tolerance: float,
        precision: str = "long double",
        budget: int = 2_000_000,
    ) -> Motion:
        """The motion from (q, w) at the instants, which lie on one side of t0 in order."""
        library, size = self._library(precision), len(start)
        high = np.array([float(x) for x in start])
        low = np.array([float(x - mp.mpf(float(x))) for x in start])
        out, report = np.zeros((len(times), size, 2)), np.zeros(7)
        longest = 0.05 if self.switches.functions else 0.0
        code = library.motion(
            _doubles(p), _doubles(high), _doubles(low), ctypes.c_double(t0), len(times),
            _doubles(times), ctypes.c_double(tolerance), ctypes.c_double(longest),
            ctypes.c_long(budget), out.ctypes.data_as(ctypes.c_void_p),
            report.ctypes.data_as(ctypes.c_void_p),
        )  # fmt: skip
        states = [[mp.mpf(hi) + mp.mpf(lo) for hi, lo in row] for row in out]
        steps, crossings, slides = map(int, report[[2, 4, 5]])
        return Motion(
            states, OUTCOMES[code], report[0], report[1], steps, crossings, slides, report[6]
        )

    def rate_rows(self, state: Sequence[Any], p: Sequence[float]) -> np.ndarray:
        """Rows by which the kinetic energy and the conditions see velocities, at time zero."""
        return self._multipliers(state, p, 0.0)[:, : len(self.mechanics.w)]

    def _multipliers(self, state: Sequence[Any], p: Sequence[float], t: float) -> np.ndarray:
        """The matrix of the multiplier equations."""
        n = len(self.mechanics.w) + len(self._rows)
        high = np.array([float(x) for x in state])
        low = np.array([float(x - mp.mpf(float(x))) for x in state])
        K = np.zeros((n, n))
        self._library("long double").matrix_at(
            _doubles(p), ctypes.c_double(t), _doubles(high), _doubles(low),
            K.ctypes.data_as(ctypes.c_void_p),
        )  # fmt: skip
        return K

    def condition(self, state: Sequence[Any], p: Sequence[float], t: float) -> float:
        """The condition number of the multiplier equations there, rows and columns scaled."""
        K = self._multipliers(state, p, t)
        if not np.isfinite(K).all():
            return np.inf
        for _ in range(3):
            scale = 1 / np.sqrt(np.abs(K).max(axis=1, initial=1e-300))
            K = scale[:, None] * K * scale[None, :]
        values = np.linalg.svd(K, compute_uv=False)
        rank = len(K) - self._dependent
        return float(values[0] / values[rank - 1]) if values[rank - 1] > 0 else np.inf

    @property
    def _dependent(self) -> int:
        """How many rows of the constraints follow from others, at any point."""
        m = self.mechanics
        return max(0, len(self._rows) + len(m.independent) - len(m.w))

    def _library(self, precision: str) -> Any:
        if precision not in self._libraries:
            kind = PRECISIONS[precision]
            source = Path(self._folder.name, f"{kind['tail']}.c")
            target = source.with_suffix(".so")
            source.write_text(self._code(kind), encoding="utf-8")
            command = ["gcc", "-O1", "-w", "-shared", "-fPIC", str(source), "-o", str(target)]
            subprocess.run([*command, kind["library"]], check=True, capture_output=True)
            self._libraries[precision] = ctypes.CDLL(str(target))
        return self._libraries[precision]

    def _code(self, kind: Mapping[str, str]) -> str:
        m, s, tail = self.mechanics, self.switches.functions, kind["tail"]
        y = [*m.q, *m.w]
        slopes = [f.diff(x) for f in s for x in (time, *y)]
        defined = {
            "NQ": len(m.q), "NW": len(m.w), "NC": len(self._rows), "NP": len(m.p), "NS": len(s),
            "NG": max(len(s), 1), "REAL": kind["REAL"], "EPSILON": kind["epsilon"],
            "NEGLIGIBLE": kind["negligible"], "EPSILON_RATIO": kind["ratio"],
            "FABS": f"fabs{tail}", "POW": f"pow{tail}",
        }  # fmt: skip
        parts = {
            "M": self._mass, "f": self._force, "A": self._matrix, "b": self._right,
            "qd": list(m.rates),
        }  # fmt: skip
        writer = _Writer(m, tail)
        arguments = "REAL t, const REAL *y, const REAL *p, const REAL *g"
        return "\n".join(
            [
                "#include <math.h>",
                kind["header"],
                *(f"#define {name} {value}" for name, value in defined.items()),
                *writer.function(
                    f"parts({arguments}, " + ", ".join(f"REAL *{k}" for k in parts) + ")", parts
                ),
                *writer.function(f"switches({arguments}, REAL *s)", {"s": s}),
                *writer.function(f"slopes({arguments}, REAL *ds)", {"ds": slopes}),
                HERE.read_text(encoding="utf-8"),
            ]
        )


def _exact(values: Sequence[Any]) -> list[Any]:
    """Numbers for mpmath: what Python made of two doubles alone would be rounded."""
    return [mp.mpf(x) for x in values]


def _doubles(values: Any) -> Any:
    array = np.ascontiguousarray(values, dtype=float)
    return (ctypes.c_double * max(array.size, 1))(*array.ravel())


def _least(A: Any, b: Any) -> Any:
    return mp.lu_solve(A, b) if A.rows >= A.cols else A.T * mp.lu_solve(A * A.T, b)


@dataclass(frozen=True)
class _Writer:
    """SymPy to C, in any of its kinds of real numbers."""

    mechanics: Mechanics
    tail: str

    def function(self, head: str, arrays: Mapping[str, Sequence[sp.Expr]]) -> Iterator[str]:
        """A function that fills arrays."""
        everything = [sp.sympify(e) for array in arrays.values() for e in array]
        shared, reduced = sp.cse(everything, symbols=sp.numbered_symbols("x_"), order="none")
        yield f"static void {head}\n{{"
        for name, expr in shared:
            yield f"    REAL {name} = {self.text(expr)};"
        values = iter(reduced)
        for array, entries in arrays.items():
            for i in range(len(entries)):
                yield f"    {array}[{i}] = {self.text(next(values))};"
        yield "}"

    def text(self, e: sp.Expr) -> str:
        """One expression."""
        if isinstance(e, sp.Symbol):
            return self._symbol(e.name)
        if isinstance(e, sp.Integer):
            return f"((REAL){int(e)})" if abs(int(e)) < 2**31 else self._number(e)
        if isinstance(e, sp.Rational):
            return f"({self._number(sp.Integer(e.p))} / {self._number(sp.Integer(e.q))})"
        if isinstance(e, sp.Float) or e.is_NumberSymbol:
            return self._number(e)
        if isinstance(e, sp.Add | sp.Mul):
            sign = " + " if isinstance(e, sp.Add) else " * "
            return "(" + sign.join(map(self.text, e.args)) + ")"
        if isinstance(e, sp.Pow):
            return self._power(*e.args)
        known = {
            sp.sin: "sin", sp.cos: "cos", sp.tan: "tan", sp.exp: "exp", sp.log: "log",
            sp.asin: "asin", sp.acos: "acos", sp.atan: "atan", sp.atan2: "atan2", sp.sinh: "sinh",
            sp.cosh: "cosh", sp.tanh: "tanh", sp.asinh: "asinh", sp.erf: "erf",
        }  # fmt: skip
        if e.func in known:
            return f"{known[e.func]}{self.tail}({', '.join(map(self.text, e.args))})"
        raise NoReferee(f"the function {e.func}")

    def _symbol(self, name: str) -> str:
        if name == "t" or name.startswith("x_"):
            return name
        kind, place = name[0], int(name[1:])
        return {
            "q": f"y[{place}]", "w": f"y[NQ + {place}]", "p": f"p[{place}]", "g": f"g[{place}]",
        }[kind]  # fmt: skip

    def _number(self, e: sp.Expr) -> str:
        return f"((REAL){sp.N(e, 40)}{self.tail.upper()})".replace(".e", ".0e")

    def _power(self, base: sp.Expr, exponent: sp.Expr) -> str:
        text = self.text(base)
        if exponent == sp.S.Half:
            return f"sqrt{self.tail}({text})"
        if exponent == -sp.S.Half:
            return f"(1 / sqrt{self.tail}({text}))"
        if exponent.is_Integer and 0 < abs(int(exponent)) <= 8:
            product = "(" + " * ".join([text] * abs(int(exponent))) + ")"
            return product if exponent > 0 else f"(1 / {product})"
        return f"pow{self.tail}({text}, {self.text(exponent)})"
