"""What a user says of motions, and its meaning: names, scene, outputs, events, times, start."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import isfinite
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import sympy as sp

from voronec.algebra.arguments import COUNT, FLAG, SEQUENCE, SEVERAL, TEXT, require, takes_fields
from voronec.algebra.memo import Memo
from voronec.algebra.symbols import is_symbolic_name, plain_name, time, velocity
from voronec.algebra.text import as_expression, in_doubles, name_or_formula
from voronec.declaration.claims import right_of
from voronec.declaration.reading import (
    doubles,
    expression,
    fixed_mapping,
    quote_number,
    real_text,
    several,
    texts_read,
)
from voronec.declaration.scene import Scene
from voronec.declaration.system import System
from voronec.errors import DefinitionError, did_you_mean, quote
from voronec.motion.reactions import reactions_of_state

if TYPE_CHECKING:
    from voronec.equations.definition import Definition
    from voronec.equations.voronec_equations import VoronecEquations

T = TypeVar("T")
POINTS = 1001
"""How many points a scene's span is seen at."""
Values = Mapping[Any, Any]
"""Values of one motion, by symbol or name."""


@dataclass(frozen=True)
class StartData:
    """What is said of one start, by plain name: ``parameters``, and initial values, those of the
    scene (``scene_initial``) and those over them (``initial``)."""

    parameters: Mapping[str, Any]
    scene_initial: Mapping[str, Any]
    initial: Mapping[str, Any]

    @classmethod
    def of(
        cls,
        namespace: Namespace,
        scene: Scene | None,
        parameters: Values | None = None,
        initial: Values | None = None,
    ) -> StartData:
        """Scene and arguments put together; ``DefinitionError`` for names nobody knows."""
        constants, start = (scene.parameters, scene.initial) if scene else ({}, {})
        said = cls(
            parameters=name_values(namespace, constants, "parameter"),
            scene_initial=name_values(namespace, start, "initial value"),
            initial={},
        )
        return said.with_values(namespace, parameters, initial)

    def with_values(
        self, namespace: Namespace, parameters: Values | None, initial: Values | None
    ) -> StartData:
        """What a scene says, and over it what is given besides."""
        if not parameters and not initial:
            return self
        named = name_values(namespace, parameters or {}, "parameter")
        begun = name_values(namespace, initial or {}, "initial value")
        return StartData({**self.parameters, **named}, self.scene_initial, begun)


def kept_while_same(
    namespace: Namespace, what: str, of: Iterable[Mapping[str, Any]], make: Callable[[], T]
) -> T:
    """What is made of values by name, as it was made last where these are the same to the last bit;
    made anew where that is not to be told."""
    spelled = [[(name, _spelling(x)) for name, x in values.items()] for values in of]
    if any(x is None for part in spelled for _, x in part):
        return make()
    return namespace.memo.last(what, spelled, make)


def _spelling(value: Any) -> Hashable | None:
    """A number or a formula, told from all others; None for what may change, or is none."""
    if type(value) in (float, str, np.float64):
        return type(value).__name__, repr(value)  # zeros differ in sign
    # equal numbers of SymPy may differ in their precision
    exact = type(value) is int or (isinstance(value, sp.Expr) and not value.has(sp.Float))
    return (type(value).__name__, value) if exact else None


def quantity(namespace: Namespace, key: Any, role: str = "output") -> tuple[str, sp.Expr]:
    """What a name, a symbol or an expression is called, and what it is.

    The expression holds coordinates, velocities, parameters, the time and invariants by their
    symbols.  ``DefinitionError`` for a name that the system does not know.
    """
    system = namespace.equations.system
    known = {**namespace.reaction_terms, **namespace.known}
    if isinstance(key, str) and key not in known:
        key = name_or_formula(namespace.spell(key), f"system '{system.name}': the {role}")
    if isinstance(key, str):
        name = namespace.name(key, known, role)
        return name, as_expression(known[name])
    given = expression(key, f"system '{system.name}': the {role}")
    expr = given.xreplace(namespace.inputs)
    meaning = {}
    for symbol in sorted(expr.free_symbols, key=str):
        if str(symbol) not in known:
            raise DefinitionError(
                f"system '{system.name}': the {role} '{expr}' contains '{symbol}'"
                f"{did_you_mean(str(symbol), known)}"
            )
        meaning[symbol] = known[str(symbol)]
    return label(given), expr.xreplace(meaning)


def begin_of(scene: Scene | None) -> float:
    """Where motions begin that no span of time is given for."""
    return 0.0 if scene is None else number(scene.times[0], "the span's beginning")


def scene_of(
    system: System, scene: str | Scene | None, needed: bool, instead: str = "initial={...}"
) -> Scene | None:
    """The scene meant by a name; where none is named and one is needed, the one called ``default``.

    ``DefinitionError`` where there is none; ``instead`` is what would do in place of a scene.
    """
    if isinstance(scene, Scene) or (scene is None and not needed):
        return scene
    if scene is not None and not isinstance(scene, str):
        raise DefinitionError(
            f"system '{system.name}': scene = {quote(scene)} is no scene; give its name, or a "
            "voronec.Scene"
        )
    if scene is None:
        if "default" not in system.scenes:
            raise DefinitionError(
                f"system '{system.name}' has no scene 'default'; give {instead}, or scene= one of "
                f"its scenes ({', '.join(system.scenes) or 'there are none'})"
            )
        return system.scenes["default"]
    if scene not in system.scenes:
        raise DefinitionError(
            f"system '{system.name}' has no scene '{scene}'{did_you_mean(scene, system.scenes)}"
        )
    return system.scenes[scene]


def outputs_of(scene: Scene | None, outputs: Any) -> tuple[Any, ...]:
    """The outputs asked for, one alone among them; by default those of the scene."""
    asked = several(outputs, "outputs", "name")
    return asked or (scene.outputs if scene else ())


@dataclass(frozen=True)
class Starts:
    """Many starts, as they were given: in ``rows``, a mapping each, or in ``columns``, by name or
    symbol, arrays (count,) and values that stand for all."""

    count: int
    columns: Values
    rows: Sequence[Values] | None = None

    def __len__(self) -> int:
        return self.count

    def __getitem__(self, i: int) -> Values:
        if self.rows is not None:
            return self.rows[i]
        given = self.columns.items()
        return {k: x[i].item() if isinstance(x, np.ndarray) else x for k, x in given}

    def __iter__(self) -> Iterator[Values]:
        return (self[i] for i in range(self.count))

    @classmethod
    def of(cls, rows: Sequence[Values]) -> Starts:
        """Those of rows."""
        return cls(len(rows), {}, rows)

    def over(self, common: Values) -> Starts:
        """With what each of them does not give itself."""
        rows = None if self.rows is None else [{**common, **row} for row in self.rows]
        return Starts(self.count, {**common, **self.columns}, rows)


def spread_starts(
    starts: Values | Sequence[Values] | None, parameters: Values
) -> tuple[Starts, dict[Any, Any]]:
    """The starts, and parameters whose arrays are as long as these are many."""
    columns = _columns(parameters, "parameter")
    lengths = {f"parameter '{k}'": x for k, x in columns.items()}
    given = starts if isinstance(starts, Mapping) else {}
    long = _columns(given, "start")
    lengths |= {f"start '{k}'": x for k, x in long.items()}
    rows = None if starts is None or isinstance(starts, Mapping) else starts
    if rows is not None:
        if not SEQUENCE.holds(rows) or not all(isinstance(s, Mapping) for s in rows):
            raise DefinitionError(
                "starts: give arrays by name, {'x': [0, 1]}, or a list of mappings, [{'x': 0}]"
            )
        lengths["list of starts"] = np.zeros(len(rows))
    sizes = {what: len(x) for what, x in lengths.items()}
    count = max(sizes.values(), default=1)
    for what, size in sizes.items():
        if not size:
            raise DefinitionError(f"the {what} has no entries; give one for each motion")
        if size != count:
            raise DefinitionError(f"the {what} has {size} entries, where others have {count}")
    return Starts(count, {**given, **long}, rows), {**parameters, **columns}


def _columns(given: Values, role: str) -> dict[Any, np.ndarray]:
    """The arrays among some values, in numbers."""
    columns = {}
    for key, values in given.items():
        place = f"{role} '{quote(key)}'"
        try:
            column = np.asarray(values)
        except (TypeError, ValueError):  # rows of several lengths
            column = np.empty((0, 0))
        if column.ndim == 0:
            continue
        if column.ndim != 1 or not len(column):
            raise DefinitionError(f"{place}: give a number or a one-dimensional array")
        if column.dtype.kind not in "fiu":
            column = np.array([number(x, place) for x in column])
        columns[key] = column
    return columns


GRID = (
    "times must be a strictly monotonic, finite, one-dimensional array, such as "
    "numpy.linspace(0, 10, 1001), or one number, the end of a span of some length"
)


def grid_of(system: System, scene: Scene | None, times: Any) -> np.ndarray:
    """The grid of times, by default over the span of the scene; it must be strictly monotonic.

    One number is the end of a span that begins where the scene does, or at zero.
    """
    known = scene or system.scenes.get("default")
    if times is None:
        if known is None:
            raise DefinitionError(
                f"system '{system.name}' has no scene to take the span from; give times"
            )
        times = number(known.times[1], "the span's end")
    try:
        grid = doubles(times, "times")
    except DefinitionError as error:
        raise DefinitionError(f"{error}; {GRID}") from None
    if grid.ndim == 0 and np.isfinite(grid):
        begin, end = begin_of(known), float(grid)
        _require_span(begin, end)
        grid = np.linspace(begin, end, POINTS)
    if grid.ndim != 1 or grid.size == 0 or not np.isfinite(grid).all():
        raise DefinitionError(f"times = {quote(grid)}: {GRID}")
    _require_span(float(grid[0]), float(grid[-1]))
    steps = np.diff(grid)
    if not ((steps > 0).all() or (steps < 0).all()):
        raise DefinitionError(f"times = {quote(grid)}: {GRID}")
    return grid


def _require_span(start: float, end: float) -> None:
    if not isfinite(end - start):
        raise DefinitionError("times have a span that no double holds; use another unit of time")


CONFIGURATION = "configuration"
"""The output that stands for all coordinates: what an animation needs."""


def number(value: Any, place: str) -> float:
    """A finite real number as a double, or ``DefinitionError`` naming the place."""
    try:
        double = float(value) if isinstance(value, float | int) else _double(value, place)
    except (TypeError, ValueError, AttributeError):
        double = math.nan
    except OverflowError:
        raise DefinitionError(
            f"{place} = {quote_number(value)} is not a real number that a double holds"
        ) from None
    if math.isfinite(double):
        return double
    raise DefinitionError(
        f"{place} = {quote(value)} is not {'finite' if math.isinf(double) else 'a real number'}"
    )


def _double(value: Any, place: str) -> float:
    try:
        read = real_text(value, place) if isinstance(value, str) else as_expression(value, place)
    except DefinitionError:
        if isinstance(value, str):
            raise
        return math.nan
    in_doubles(read)  # refuses what could not be computed
    exact = read.evalf(25)
    # what is not zero must not pass for it: zeros may be frozen
    return float(exact) or math.copysign(5e-324, exact) if exact != 0 else 0.0


def label(expr: sp.Expr) -> str:
    """What a symbol, a velocity or an expression is called."""
    bare = expr.expr if isinstance(expr, sp.Derivative) else expr
    return plain_name(expr) if is_symbolic_name(bare) else str(expr)


def held_name(key: Any, held: Iterable[str], holder: str) -> str:
    """The name of something that a result holds, asked for by name, symbol or expression.

    ``DefinitionError`` where it is not there; ``holder`` begins the message: "the section holds".
    """
    known = list(held)
    name = key if isinstance(key, str) else label(as_expression(key, "what is asked for"))
    if isinstance(key, str) and key not in known:
        with suppress(DefinitionError):  # "x+5" is "x + 5"
            spelled = label(as_expression(key))
            name = spelled if spelled in known else key
    if name not in known:
        raise DefinitionError(
            f"{holder} no '{quote(name)}', ask for it in outputs=(...){did_you_mean(name, known)}"
        )
    return name


@dataclass(frozen=True)
class OutputTerms:
    """Outputs spelled out.

    ``names`` in the order asked for, each once; what each is: ``terms``, in the user's symbols,
    those of invariants among them; or ``reactions``, positions of constraints, which need the
    accelerations too (``voronec.motion.reactions.Multipliers``).  ``inward`` leads in the engine's
    symbols.
    """

    names: tuple[str, ...]
    terms: Mapping[str, sp.Expr]
    inward: Callable[[Any], Any]
    reactions: Mapping[str, int]

    @cached_property
    def expressions(self) -> Mapping[str, Any]:
        """The terms in the engine's symbols, in coordinates, velocities, time and parameters:
        not asked for where a model has been written for them before."""
        return {name: self.inward(e) for name, e in self.terms.items()}


def state_names(system: System) -> tuple[str, ...]:
    """The names of the coordinates and velocities of a system."""
    return tuple(map(plain_name, (*system.coordinates, *system.velocities)))


@dataclass(frozen=True)
class Namespace:
    """Names of one system: coordinates, velocities, parameters; what follows from these, such as
    integrals, invariants, and the dependent velocities and momenta of a group.  Reactions are those
    of ``home`` where these equations are its own, free of constraints."""

    equations: VoronecEquations
    inputs: Mapping[sp.Expr, sp.Expr] = field(default_factory=dict)
    home: VoronecEquations | None = None
    memo: Memo = field(default_factory=Memo, init=False, repr=False, compare=False)

    @classmethod
    def of(
        cls, equations: VoronecEquations, inputs: Mapping[sp.Expr, sp.Expr] | None = None
    ) -> Namespace:
        """The vocabulary of a system's equations; ``inputs`` are what stands for those that the
        system was declared with, and for their rates.  Without these it is kept with the equations.
        """
        if not inputs:
            return equations.memo.once("vocabulary", lambda: cls(equations))
        return cls(equations, dict(inputs))

    @cached_property
    def symbols(self) -> Mapping[str, sp.Expr]:
        """Coordinates, velocities, parameters and the time."""
        system = self.equations.system
        dots = map(velocity, system.coordinates)
        constants = (p.symbol for p in system.parameters)
        things = (*system.coordinates, *system.velocities, *dots, *constants, time)
        return {plain_name(s): s for s in things}

    @cached_property
    def claims(self) -> Mapping[str, sp.Expr]:
        """What follows from these: invariants, velocities and momenta of a group, integrals."""
        system, frame = self.equations.system, self.equations.system.frame
        others = (*frame.fibre, *frame.momenta) if frame is not None else ()
        integrals = {name: right_of(claim) for name, claim in system.integrals.items()}
        return {**system.invariants, **{plain_name(x): x for x in others}, **integrals}

    @cached_property
    def rate_names(self) -> tuple[str, ...]:
        """The names of the velocities that follow from those of the equations: of the coordinates,
        and of the fibre of a group."""
        system = self.equations.system
        fibre = system.frame.fibre if system.frame is not None else ()
        return tuple(map(plain_name, (*map(velocity, system.coordinates), *fibre)))

    @cached_property
    def start_names(self) -> tuple[str, ...]:
        """The names of coordinates, of the equations' velocities, and of those that follow."""
        constants = {*self.equations.system.parameter_names, "t"}
        moving = (name for name in self.symbols if name not in constants)
        return tuple(dict.fromkeys((*moving, *self.rate_names)))

    @cached_property
    def known(self) -> dict[str, sp.Expr]:
        """Everything that has a name, but for reactions and groups."""
        system = self.equations.system
        invariants = dict(zip(system.invariants, system.invariant_symbols, strict=True))
        driven = {plain_name(u): e for u, e in self.inputs.items()}
        return {**self.claims, **invariants, **self.symbols, **driven}

    @cached_property
    def reactions(self) -> dict[str, int]:
        """``reaction k`` is lambda_k of constraint k; positions count from 0.

        It is the multiplier of ``voronec.reaction_forces``: A^T lambda is what the constraints do,
        in units of dL/dq.
        """
        return {
            f"reaction {k + 1}": k for k in range(len(self.reaction_definition.constraints.matrix))
        }

    @cached_property
    def reaction_definition(self) -> Definition:
        """The definition with the constraints that react."""
        d = self.equations.definition if self.home is None else self.home.definition
        return d if self.home is None else replace(d, frame=None, velocities=d.dots)

    @property
    def home_names(self) -> tuple[str, ...]:
        """The coordinates and velocities that users know."""
        return state_names((self.home or self.equations).system)

    @cached_property
    def conditions(self) -> tuple[Any, ...]:
        """What vanishes along the motion, where constraints are held by reactions: these, as they
        are in the velocities of the coordinates or of the group, and what declares others."""
        if self.home is None:
            return ()
        home, definition = self.home.definition, self.equations.definition
        frame = () if definition.frame is None else definition.frame.expressions(definition.dots)
        return (
            *home.constraints.expressions(home.dots), *home.differentiated.expressions(home.dots),
            *definition.constraints.expressions(definition.dots),
            *(e - v for e, v in zip(frame, definition.velocities, strict=False)),
        )  # fmt: skip

    @cached_property
    def _reaction_symbols(self) -> tuple[sp.Symbol, ...]:
        """What stands for reactions in expressions; no system has such symbols."""
        return tuple(map(sp.Symbol, self.reactions))

    @cached_property
    def _in_formulas(self) -> dict[str, sp.Symbol]:
        """The reactions by their names in formulas, where names hold no spaces, ``reaction_1``, but
        for names that the system has given."""
        taken = {*self.symbols, *self.equations.system.invariants}
        names = {symbol.name.replace(" ", "_"): symbol for symbol in self._reaction_symbols}
        return {name: symbol for name, symbol in names.items() if name not in taken}

    def spell(self, text: str) -> str:
        """A formula in which reactions may be called as they are among outputs."""
        for name, symbol in self._in_formulas.items():
            text = re.sub(rf"\b{symbol}\b", name, text)
        return text

    @property
    def reaction_terms(self) -> dict[str, sp.Symbol]:
        """The symbols of reactions by all their names."""
        return {symbol.name: symbol for symbol in self._reaction_symbols} | self._in_formulas

    def holds_reactions(self, exprs: Iterable[sp.Expr]) -> bool:
        """Whether some are functions of the state that only accelerations tell, in coordinates."""
        symbols = {*self._reaction_symbols}
        return any(e.free_symbols & symbols for e in exprs)

    @cached_property
    def groups(self) -> dict[str, tuple[Any, ...]]:
        """Outputs that stand for several: the whole configuration, and each trace of a contact that
        the system draws."""
        system = self.equations.system
        drawing = system.drawing if isinstance(system.drawing, Mapping) else {}
        traces = {title: tuple(names) for title, names in drawing.items() if isinstance(title, str)}
        return {CONFIGURATION: system.coordinates, **traces}

    def read_outputs(self, outputs: Iterable[Any]) -> OutputTerms:
        """Outputs spelled out; where there are none, all coordinates and velocities.

        Each is a name, a symbol or an expression; ``reaction k``, ``configuration``, or the title
        of a contact's trace.  A quantity of the system comes before these where names agree.
        """
        system = self.equations.system
        reactions, groups = self.reactions, self.groups
        known = self.known
        keys = tuple(outputs) or (*system.coordinates, *system.velocities)
        spelled: dict[str, sp.Expr | None] = {}
        chosen: dict[str, int] = {}
        for key in keys:
            name = key if isinstance(key, str) and key not in known else ""
            if name in reactions:
                chosen[name] = reactions[name]
                spelled[name] = None
            else:
                spelled |= map(self.read_condition, groups.get(name, (key,)))
        given = {name: e for name, e in spelled.items() if e is not None}
        return OutputTerms(tuple(spelled), given, self.inward, chosen)

    def name(self, key: Any, among: Iterable[str], role: str) -> str:
        """The plain name of a symbol or name, which must be among some."""
        name = key if isinstance(key, str) else self._plain(key, role)
        allowed = list(among)
        if name not in allowed:
            raise DefinitionError(
                f"system '{self.equations.system.name}' has no {role} '{quote(name)}'"
                f"{did_you_mean(name, allowed)}"
            )
        return name

    def read_condition(self, key: Any) -> tuple[str, sp.Expr]:
        """A single output, with its expression in the user's symbols, those of invariants among
        them.

        What was read before is known: to spell long expressions takes as long as a short run.
        """
        if isinstance(key, str | sp.Basic):
            return self.memo.once((type(key), key), lambda: self._read_condition(key))
        return self._read_condition(key)

    def _read_condition(self, key: Any) -> tuple[str, sp.Expr]:
        system, known = self.equations.system, self.known
        if isinstance(key, str) and key not in (*known, *self.reactions, *self.groups):
            key = name_or_formula(self.spell(key), f"system '{system.name}': an output")
        if isinstance(key, str):
            name = self.name(key, [*known, *self.reactions, *self.groups], "output")
            if name in self.reactions:
                return name, self._reaction_symbols[self.reactions[name]]
            if name not in known:
                raise DefinitionError(
                    f"system '{system.name}': '{name}' stands for several quantities, where events "
                    "and formulas take one; ask for it as an output of its own"
                )
            return name, known[name]
        given = expression(key, f"system '{system.name}': an output")
        if given in self.inputs:
            return plain_name(given), self.inputs[given]
        short = {sp.Symbol(name): symbol for name, symbol in self._in_formulas.items()}
        expr = given.xreplace(self.inputs).xreplace(short)
        for symbol in sorted(expr.free_symbols, key=str):
            if str(symbol) not in {*self.symbols, *system.invariants, *self.reactions}:
                among = [*self.symbols, *system.invariants, *self._in_formulas]
                raise DefinitionError(
                    f"system '{system.name}': the output '{given}' contains '{symbol}'"
                    f"{did_you_mean(str(symbol), among)}"
                )
        name = label(given)
        if expr in self._reaction_symbols:
            return str(expr), expr
        if expr not in system.invariant_symbols and (name != str(given) or name in self.symbols):
            name = self.name(name, self.symbols, "output")
            return name, self.symbols[name]
        return name, expr

    def inward(self, expr: Any) -> Any:
        """A user's expression in the engine's symbols, its invariants and reactions spelled out."""
        system, bridge = self.equations.system, self.equations.definition.bridge
        meaning = dict(zip(system.invariant_symbols, system.invariants.values(), strict=True))
        spelled = as_expression(expr).xreplace(meaning)
        inside = bridge.inward(spelled)
        if not self.holds_reactions([spelled]):
            return inside
        reactions = self.equations.memo.once(
            "reactions of the state",
            lambda: reactions_of_state(self.equations, self.reaction_definition),
        )
        return inside.xreplace(
            dict(zip(map(bridge.inward, self._reaction_symbols), reactions, strict=True))
        )

    def _plain(self, key: Any, role: str) -> str:
        try:
            return plain_name(as_expression(key, f"the {role}"))
        except DefinitionError:
            raise DefinitionError(
                f"system '{self.equations.system.name}': '{quote(key)}' names no {role}; give a "
                "symbol or its name"
            ) from None


def name_values(namespace: Namespace, given: Mapping[Any, Any], role: str) -> dict[str, Any]:
    """Values by plain name; ``role`` is ``parameter`` or ``initial value``."""
    system = namespace.equations.system
    among = system.parameter_names if role == "parameter" else namespace.start_names
    result: dict[str, Any] = {}
    argument = "parameters" if role == "parameter" else "initial"
    for key, value in texts_read(fixed_mapping(given, argument, "name: value"), role).items():
        if argument == "initial" and str(key) in system.parameter_names:
            told = f"'{key}', a parameter; give parameters={{'{key}': ...}}"
            raise DefinitionError(f"system '{system.name}' has no {role} {told}")
        name = namespace.name(key, among, role)
        if name in result:
            raise DefinitionError(f"system '{system.name}': the {role} '{name}' is given twice")
        result[name] = value
    return result


@takes_fields
@dataclass(frozen=True)
class Event:
    """Where ``function`` passes through zero, or jumps through it.

    ``function`` is a name, a symbol or an expression, as for outputs, reactions among them
    (``reaction 1``, in expressions ``reaction_1``); ``name`` says how the trajectory calls it (by
    default as the function reads).  ``direction`` 1 asks for
    passages where the function grows with time, -1 for those where it falls, 0 for both.  ``stop``
    ends the run at the first one.  A zero at the start of the motion is none, nor is one that the
    function touches without a change of sign; one at the last instant counts, whatever would come
    after it.
    Another ``direction`` raises ``DefinitionError``.
    """

    function: Any
    name: str = ""
    direction: int = 0
    stop: bool = False

    def __post_init__(self) -> None:
        require("event", "name", self.name, TEXT)
        require("event", "stop", self.stop, FLAG)
        if not COUNT.holds(self.direction) or self.direction not in (-1, 0, 1):
            raise DefinitionError(
                f"event '{quote(self.name or self.function)}': direction = "
                f"{quote(self.direction)} must be 1 (upwards), -1 (downwards) or 0 (both)"
            )


@dataclass(frozen=True)
class Guard:
    """A function that a run looks at for zeros, told as of an ``Event``.

    ``owner`` is the event of the user for whom it looks, None where it looks for itself.  ``name``
    is what the function is called on the way, by what watches it; how users call their events
    plays no part there.
    """

    name: str
    direction: int = 0
    stop: bool = False
    owner: Event | None = None


def events_of(events: Any) -> tuple[Event, ...]:
    """Events as they are given: one or several, or what they watch alone."""
    single = isinstance(events, str | sp.Basic | Event)
    if not SEVERAL.holds(events) and not isinstance(events, Event):
        raise DefinitionError(f"events = {quote(events)} are no events; give voronec.Event(...)")
    given: Sequence[Any] = (events,) if single else tuple(events)
    return tuple(item if isinstance(item, Event) else Event(item) for item in given)


def name_events(namespace: Namespace, events: Any) -> tuple[tuple[Guard, ...], dict[str, Any]]:
    """Guards for events with their names filled in, and functions in the user's symbols by the
    guards' names."""
    guards: list[Guard] = []
    inside, names = dict[str, Any](), set[str]()
    for event in events_of(events):
        spelling, function = namespace.read_condition(event.function)
        name = event.name or spelling
        if name in names:
            raise DefinitionError(
                f"system '{namespace.equations.system.name}': two events are called '{name}'; "
                "give Event(..., name=)"
            )
        names.add(name)
        called = f"event {len(guards)}"
        guards.append(Guard(called, event.direction, event.stop, replace(event, name=name)))
        inside[called] = _simple(function)
    return tuple(guards), inside


def _simple(function: Any) -> Any:
    """A function of the same sign with simple zeros, where the given one is a product of powers:
    roots of series are known to a part of their digits where they are multiple."""
    simple, touches = sp.S.One, True
    for factor in sp.Mul.make_args(function):
        base, exponent = factor.as_base_exp()
        if exponent.is_Integer and exponent > 1:
            factor = base if exponent % 2 else sp.S.One
        simple *= factor
        touches = touches and factor.is_number
    return function if touches else simple
