"""Inputs: functions of the time whose values are given when a motion is computed.

An expression takes the place of its input before anything is derived, so it is differentiated
exactly.  Any other input becomes a polynomial about an instant s,

    u(t) = u + udot (t - s) + udotdot (t - s)^2/2 + ...,

whose coefficients are parameters: of a number they are constant, of a table they change at its
knots, of a function of Python's they are its values at the instant s = t itself, and of a
controller, a function of the time and the state, what it gives there.

A table holds values at instants, held or interpolated between them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from inspect import Parameter as Argument
from inspect import signature
from math import ceil, factorial, inf, lcm
from typing import Any

import sympy as sp

from voronec.algebra.arguments import takes_fields
from voronec.algebra.symbols import names_in, plain_name, time, unused_name, velocity
from voronec.algebra.text import formula
from voronec.declaration.claims import right_of, without_claims
from voronec.declaration.reading import (
    doubles,
    expression,
    fixed_mapping,
    namesake_hint,
    quote,
)
from voronec.declaration.scene import Parameter
from voronec.declaration.system import System
from voronec.declaration.table_file import KINDS, require_table
from voronec.equations.jumps import require_continuous
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.errors import DefinitionError, did_you_mean
from voronec.motion.input_samples import SAMPLES, breaks
from voronec.motion.steppers import Feedback, Signal, Signals

MOST_SAMPLES = 10**7
"""A controller is asked no more often in one run: as many instants take half a gigabyte."""


@dataclass(frozen=True)
class Drive:
    """A system with its inputs replaced.

    ``original`` is the system as it was declared; ``meaning`` what stands for each input and its
    rates; ``constants`` the values of inputs that are numbers; ``changing`` the parameters that
    change in time, None where none does; ``notes`` tell of functions that change too fast.
    """

    original: System
    equations: VoronecEquations
    meaning: Mapping[sp.Expr, sp.Expr] = field(default_factory=dict)
    constants: Mapping[str, Any] = field(default_factory=dict)
    changing: Signals | None = None
    notes: tuple[str, ...] = ()

    def parameters(self, start: float, end: float) -> dict[str, Any]:
        """Values of the parameters that stand for inputs, where a motion starts."""
        changing = {} if self.changing is None else self.changing.on(start, end)
        return {**self.constants, **changing}

    def over(self, start: float, end: float) -> Drive:
        """Inputs on a span, on which functions of Python's are asked where they change fast;
        times at which a table has no value are refused."""
        if self.changing is None:
            return self
        for signal in self.changing.signals:
            low, high = min(start, end), max(start, end)
            if low < signal.first or high > signal.last:
                raise DefinitionError(
                    f"system '{self.original.name}': the table of the input '{signal.name}' goes "
                    f"from t = {signal.first:g} to {signal.last:g}, the motion from {low:g} to "
                    f"{high:g}; give a longer table, or other times"
                )
        signals, notes = [], []
        for signal in self.changing.signals:
            if signal.feedback is not None:
                signals.append(self._in_one_run(signal, start, end))
                continue
            splits = [breaks(f, start, end) for f in signal.functions]
            if None in splits:
                notes.append(
                    f"the input '{signal.name}' changes faster than it is sampled, every "
                    f"{abs(end - start) / SAMPLES:.3g}; what happens between may be lost: give an "
                    "expression or a table, or run over shorter spans"
                )
            elif splits:
                known = [one for one in splits if one is not None]
                knots = sorted({Fraction(t) for instants, _ in known for t in instants})
                sharp = sorted({part for _, parts in known for part in parts})
                signal = replace(signal, instants=tuple(knots), sharp=tuple(sharp))
            signals.append(signal)
        return replace(self, changing=Signals(tuple(signals)), notes=tuple(notes))

    def _in_one_run(self, signal: Signal, start: float, end: float) -> Signal:
        """A controller on a span: asked at start + k period, each rounded once."""
        assert signal.feedback is not None
        instants: tuple[float, ...] = ()
        if end < start:
            raise DefinitionError(
                f"system '{self.original.name}': the controller of '{signal.name}' runs into the "
                f"future, the motion from t = {start:g} back to {end:g}; let the times grow"
            )
        if signal.period is not None:
            begin, period = Fraction(start), signal.period
            whole = lcm(begin.denominator, period.denominator)
            first, every = int(begin * whole), int(period * whole)
            count = max(ceil((Fraction(end) - begin) / period), 1)
            if count > MOST_SAMPLES:
                raise DefinitionError(
                    f"system '{self.original.name}': the controller of '{signal.name}' would be "
                    f"asked {count:.3g} times; give a longer period, or a shorter run"
                )
            instants = tuple((first + k * every) / whole for k in range(count))
        feedback = Feedback(signal.parameters[0], signal.feedback.function, instants)
        return replace(signal, feedback=feedback, instants=instants)


def drive(
    system: System | VoronecEquations,
    inputs: Mapping[Any, Any] | None = None,
    scene: Any = None,
    steady: str = "",
    unknown: bool = False,
) -> Drive:
    """The system with values for its inputs; ``DefinitionError`` names one that has none.

    ``steady`` says who asks, where inputs that change with the time otherwise than by a formula
    are refused; with ``unknown`` an input without a value is carried along as a parameter without
    one, with as many rates as the equations hold.
    """
    original = system.system if isinstance(system, VoronecEquations) else system
    if not original.inputs and not inputs:
        return Drive(original, system if isinstance(system, VoronecEquations) else derive(system))
    values = _name_inputs(original, {**getattr(scene, "inputs", {}), **(inputs or {})})
    stand_ins = [_stand_in(original, u, values, unknown) for u in original.inputs]
    signals = tuple(each.signal for each in stand_ins if each.signal is not None)
    if signals and steady:
        raise DefinitionError(
            f"system '{original.name}': {steady} takes numbers and expressions of t for inputs, "
            f"not what '{signals[0].name}' is given; give one of these, or integrate "
            "the motions one by one"
        )
    meaning = {thing: expr for each in stand_ins for thing, expr in each.meaning.items()}
    constants = {name: x for each in stand_ins for name, x in each.constants.items()}
    symbols = [s for each in stand_ins for s in each.symbols]
    shapes = tuple(each.shape for each in stand_ins)
    changing = Signals(signals) if signals and not unknown else None
    driven = original.memo.once(  # once for each shape of the inputs
        ("driven", shapes), lambda: _with_meaning(original, meaning, symbols, bool(signals))
    )
    return Drive(original, derive(driven), meaning, constants, changing)


@dataclass(frozen=True)
class _StandIn:
    """What stands for one input: the ``meaning`` of it and its rates, in ``symbols`` of its own
    where it is no expression; inputs of one ``shape`` have one meaning."""

    shape: Any
    meaning: Mapping[sp.Expr, sp.Expr]
    symbols: Sequence[sp.Symbol] = ()
    constants: Mapping[str, Any] = field(default_factory=dict)
    signal: Signal | None = None


def _stand_in(system: System, u: sp.Expr, values: Mapping[str, Any], unknown: bool) -> _StandIn:
    name = plain_name(u)
    if name not in values and unknown:
        values = {name: Signal(name, derive(system).orders.get(name, 0), "an unknown input")}
    if name not in values:
        raise DefinitionError(
            f"system '{system.name}': no value for the input '{name}'; give "
            f"inputs={{'{name}': ...}}: a number, an expression, a table or a function of t"
        )
    read = _read(system, u, values)
    if not (isinstance(read, Signal) or read.is_number):
        return _StandIn((name, read), _rates(u, _jet_of_expression(system, u, read)))
    degree = read.degree if isinstance(read, Signal) else 0
    symbols, jet = _polynomial(system, u, degree)
    shape, meaning = (name, (degree, len(symbols))), _rates(u, jet)
    if not isinstance(read, Signal):
        return _StandIn(shape, meaning, symbols, {name: read})
    _require_rates(system, u, read)
    signal = replace(read, parameters=tuple(map(str, symbols)))
    return _StandIn(shape, meaning, symbols, signal=signal)


def _name_inputs(system: System, given: Mapping[Any, Any]) -> dict[str, Any]:
    """Values by the names of inputs, and of their rates."""
    known = [plain_name(u) + "dot" * k for u in system.inputs for k in range(3)]
    named: dict[str, Any] = {}
    for key, value in fixed_mapping(given, "inputs", "name: value").items():
        name = key if isinstance(key, str) else plain_name(key)
        if name not in known:
            raise DefinitionError(
                f"system '{system.name}' has no input '{quote(name)}'; declare it, "
                f"System(..., inputs=({quote(name)},)){did_you_mean(name, known)}"
            )
        named[name] = value
    return named


def _read(system: System, u: sp.Expr, values: Mapping[str, Any]) -> sp.Expr | Signal:
    """The value of an input: an expression, or a signal that has yet to be named."""
    name = plain_name(u)
    value, place = values[name], f"system '{system.name}': the input '{name}'"
    if isinstance(value, Signal):
        return value
    if isinstance(value, str):
        known = {plain_name(s): s for s in system.known_symbols()}
        value = formula(value, place, known)
    elif isinstance(value, tuple) and len(value) in (2, 3):
        value = Table(*value)
    rates = [values[k] for k in (f"{name}dot", f"{name}dotdot") if k in values]
    if isinstance(value, Sampled) or _takes_state(value):
        return _controller(system, u, value)
    if isinstance(value, Table) or not callable(value):
        if rates:
            raise DefinitionError(f"{place} is no function of Python's; it brings its own rates")
        if isinstance(value, Table):
            return value.signal(name)
        # an array without dimensions is iterable by its type alone
        if isinstance(value, Iterable) and getattr(value, "ndim", 1) > 0:
            raise DefinitionError(
                f"{place} = {quote(value)} is no value; give a number, an expression, a function "
                "of t, the pair (times, values), or voronec.Table(times, values)"
            )
        return expression(value, place)
    if not all(map(callable, rates)) or (f"{name}dotdot" in values and len(rates) < 2):
        raise DefinitionError(f"{place}: its rates are functions of t too, none left out")
    return Signal.of_functions(name, (value, *rates))


def _jet_of_expression(system: System, u: sp.Expr, value: sp.Expr) -> list[sp.Expr]:
    """An expression and its rates, as far as it has any."""
    constants = {p.symbol for p in system.parameters}
    state = names_in(value) - constants - {time}
    if not state:
        return _jet_in_time(system, u, value)
    place = f"system '{system.name}': the input '{plain_name(u)}' = {quote(value)}"
    known = {*system.known_symbols()} - {*system.inputs}
    foreign = sorted(state - known, key=str)
    if foreign:
        raise DefinitionError(
            f"{place} contains '{foreign[0]}', which is neither coordinate, velocity, parameter "
            f"nor the time{namesake_hint(foreign[0], known)}"
        )
    if not _is_force(system, u):
        raise DefinitionError(
            f"{place} holds '{min(map(str, state))}', but the input stands outside of the forces, "
            "or with its rate: there it is a function of the time alone; write it into the system"
        )
    return [value]


def _is_force(system: System, u: sp.Expr) -> bool:
    """Whether an input stands in forces alone, without its rates."""
    held = [system.lagrangian, *system.constraints, *system.fibration.relations]
    held += system.frame.expressions if system.frame is not None else ()
    jets = {u, velocity(u)}
    forced = {n for e in system.forces.values() for n in names_in(e)} - {u}
    rated = any(n in jets or (isinstance(n, sp.Derivative) and n.expr == u) for n in forced)
    return not (rated or any(names_in(e) & jets for e in held))


def _takes_state(value: Any) -> bool:
    """Whether something is a function of the time and the state: it wants two arguments."""
    if not callable(value) or isinstance(value, type):
        return False
    try:
        arguments = signature(value).parameters.values()
    except (TypeError, ValueError):  # a function of C's
        return False
    places = (Argument.POSITIONAL_ONLY, Argument.POSITIONAL_OR_KEYWORD)
    return sum(a.kind in places and a.default is Argument.empty for a in arguments) == 2


def _controller(system: System, u: sp.Expr, value: Any) -> Signal:
    """The signal of a controller, which stands in forces alone."""
    name = plain_name(u)
    if not _is_force(system, u):
        raise DefinitionError(
            f"system '{system.name}': the input '{name}' is given by a controller, but stands "
            "outside of the forces, or with its rate; give a table or an expression of t"
        )
    sampled = isinstance(value, Sampled)
    return Signal(
        name, 0, "a sampled controller" if sampled else "a function of Python's",
        feedback=Feedback(name, value.controller if sampled else value),
        period=Fraction(value.period) if sampled else None,
    )  # fmt: skip


def _jet_in_time(system: System, u: sp.Expr, value: sp.Expr) -> list[sp.Expr]:
    """A function of the time and its rates; what the equations hold a rate of may not jump.

    The time is real, so that |t| has a slope, and beside where it jumps a step has none.
    """
    name = plain_name(u)
    real = {s: sp.Dummy(s.name, real=True) for s in value.free_symbols if s.is_real is None}
    back = {d: s for s, d in real.items()}
    jet = [value.xreplace(real)]
    for _ in range(2):
        rate = jet[-1].diff(real.get(time, time))
        jet.append(rate.replace(sp.DiracDelta, lambda *_: sp.Integer(0)))
    jet = [e.xreplace(back) for e in jet]
    for k in range(derive(system).orders.get(name, 0)):
        place = f"system '{system.name}': the equations hold a rate of '{name + 'dot' * k}', which"
        require_continuous(place, jet[k])
    return jet


def _rates(u: sp.Expr, jet: Sequence[sp.Expr]) -> dict[sp.Expr, sp.Expr]:
    """What stands for an input and for its rates."""
    return dict(zip((u, velocity(u), velocity(velocity(u))), jet, strict=False))


def _polynomial(system: System, u: sp.Expr, degree: int) -> tuple[list[sp.Symbol], list[sp.Expr]]:
    """Parameters for the values of an input and its rates, and for the instant s that they are of;
    and u + udot (t - s) + ..., with its derivatives."""
    name = plain_name(u)
    values = [sp.Symbol(name + "dot" * k) for k in range(degree + 1)]
    if not degree:
        return values, [values[0], sp.Integer(0), sp.Integer(0)]
    taken = {plain_name(s) for s in system.known_symbols()}
    since = sp.Symbol(unused_name(f"{name}_since", taken))
    whole = sp.Add(*[c * (time - since) ** k / factorial(k) for k, c in enumerate(values)])
    return [*values, since], [whole, whole.diff(time), whole.diff(time, 2)]


def _require_rates(system: System, u: sp.Expr, signal: Signal) -> None:
    """Refuse a signal that lacks a derivative which the equations hold."""
    needed = derive(system).orders.get(plain_name(u), 0)
    if needed > signal.degree:
        rate = plain_name(u) + "dot" * (signal.degree + 1)
        raise DefinitionError(
            f"system '{system.name}': the equations hold '{rate}', a derivative of the input "
            f"'{plain_name(u)}' that {signal.kind} does not have; give {signal.mend(rate)}"
        )


def _with_meaning(
    original: System, meaning: Mapping[sp.Expr, sp.Expr], symbols: Sequence[sp.Symbol], moving: bool
) -> System:
    """The system with expressions in the place of its inputs.

    What was claimed of the original is not claimed of it, but for integrals: those with an input in
    them only where that does not jump.
    """

    def on(expr: Any) -> Any:
        return expr.xreplace(meaning)

    jumping = {*meaning} if moving else set()
    integrals = {name: right_of(e) for name, e in original.integrals.items()}
    kept = {n: on(e) for n, e in integrals.items() if not names_in(e) & jumping}
    frame = original.frame
    if frame is not None:
        frame = replace(frame, expressions=tuple(map(on, frame.expressions)))
    constants = [p for p in original.parameters if isinstance(p.symbol, sp.Symbol)]
    return replace(
        original,
        lagrangian=on(original.lagrangian),
        constraints=tuple(map(on, original.constraints)),
        forces={q: on(e) for q, e in original.forces.items()},
        fibration=replace(
            original.fibration, relations=tuple(map(on, original.fibration.relations))
        ),
        frame=frame,
        parameters=(*constants, *map(Parameter, symbols)),
        invariants={n: on(e) for n, e in original.invariants.items()},
        inputs=(),
        charts={},
        bodies=(),
        motion=None,
        **without_claims() | {"integrals": kept},
    )


DEGREES = dict(zip(KINDS, (0, 1, 3), strict=True))
"""The degree of the polynomial between two instants."""


@takes_fields
@dataclass(frozen=True)
class Table:
    """An input by its ``values`` (k,) at ``times`` (k,), which grow.

    ``kind``
        ``held``: each value holds until the next instant, the last one for ever; ``linear``:
        straight lines between the values; ``cubic``: the spline with two continuous derivatives
        (scipy's ``CubicSpline``).

    At the instants a run starts anew, so that no step goes over a corner.  Raises
    ``DefinitionError`` for times that do not grow, and for another number of values.
    """

    times: Any
    values: Any
    kind: str = "linear"

    def __post_init__(self) -> None:
        if not isinstance(self.kind, str) or self.kind not in DEGREES:
            raise DefinitionError(
                f"a table is of kind '{quote(self.kind)}'; kinds are {', '.join(DEGREES)}"
            )
        times = doubles(self.times, "the times of a table")
        values = doubles(self.values, "the values of a table")
        for name, array in (("times", times), ("values", values)):
            if array.ndim != 1:
                shape = " x ".join(map(str, array.shape)) or "a single number"
                raise DefinitionError(
                    f"the {name} of a table are {shape}; give a list of numbers, such as [0, 1, 2]"
                )
        require_table(times.tolist(), values.tolist(), self.kind)
        for name, array in (("times", times), ("values", values)):
            array.flags.writeable = False
            object.__setattr__(self, name, array)

    def signal(self, name: str) -> Signal:
        """The polynomials between the instants, exactly as the doubles give them."""
        times = tuple(map(Fraction, self.times.tolist()))
        values = tuple(map(Fraction, self.values.tolist()))
        last = inf if self.kind == "held" else float(times[-1])
        if self.kind == "held":
            pieces: tuple[Any, ...] = tuple((v,) for v in values)
        elif self.kind == "linear":
            pieces = tuple(
                (values[k], (values[k + 1] - values[k]) / (times[k + 1] - times[k]))
                for k in range(len(times) - 1)
            )
        else:
            from scipy.interpolate import CubicSpline

            highest_first = CubicSpline(self.times, self.values).c
            factors = (1, 1, 2, 6)
            pieces = tuple(
                tuple(Fraction(float(c)) * f for c, f in zip(column[::-1], factors, strict=True))
                for column in highest_first.T
            )
        return Signal(
            name, DEGREES[self.kind], f"a {self.kind} table", first=float(times[0]), last=last,
            instants=times, pieces=pieces,
        )  # fmt: skip


@takes_fields
@dataclass(frozen=True)
class Sampled:
    """An input that a ``controller`` gives every ``period``: u(t) = f(t_k, state(t_k)) for
    t_k <= t < t_k + period, where t_k = t_0 + k period, rounded once, and t_0 is where the run
    begins.

    The state is a mapping of coordinates and velocities by name, to floats.  A run ends a step
    at each t_k, and takes any method between them.  Raises ``DefinitionError`` for a period that is
    no positive number, and for what cannot be called.
    """

    controller: Any
    period: Any

    def __post_init__(self) -> None:
        if not callable(self.controller):
            raise DefinitionError(
                f"Sampled: the controller {quote(self.controller)} is no function; give "
                "lambda t, state: ..., and the period"
            )
        period = doubles(self.period, "the period of a controller")
        if period.ndim or not 0 < period < inf:
            raise DefinitionError(
                f"Sampled: the period {quote(self.period)} is no positive number; give seconds, "
                "such as 0.01"
            )
        object.__setattr__(self, "period", float(period))
