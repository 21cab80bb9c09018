"""Equations at a point: accelerations to any number of digits, in ball arithmetic."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import flint
import mpmath as mp
import symengine as se
import sympy as sp

from voronec.algebra.arguments import require_digits
from voronec.algebra.points import sample_evaluable
from voronec.algebra.precision import SHARP
from voronec.algebra.stable import stable_all
from voronec.algebra.symbols import plain_name, time
from voronec.algebra.sympy_bridge import RATES
from voronec.algebra.tape import Tape, as_ball, middle
from voronec.algebra.verdicts import all_vanish
from voronec.declaration.reading import quote
from voronec.declaration.system import System
from voronec.equations.definition import read
from voronec.equations.derivation import Derivation
from voronec.equations.point_values import named_point
from voronec.errors import DefinitionError, EngineLimit

ON_RELATIONS = 1e-9
"""How far a point may lie off the relations between redundant coordinates."""


def jets(system: System) -> dict[str, Any]:
    """The inputs and their rates in the engine's symbols, by the names under which values are
    given."""
    clock, functions = se.Symbol(plain_name(time)), {}
    for u in map(plain_name, system.inputs):
        function = se.Function(u)(clock)
        for order in range(RATES):
            functions[u + "dot" * order] = function
            function = function.diff(clock)
    return functions


def _check(system: System, name: str, value: Any) -> Any:
    """A value as it stands, if it is a finite real number."""
    try:
        sound = as_ball(value).is_finite()
    except (DefinitionError, EngineLimit):
        sound = False
    if not sound:
        raise DefinitionError(
            f"system '{system.name}': the point gives '{name}' = '{quote(value)}', which is not a "
            "real number; give a finite one"
        )
    return value


def acceleration(
    system: System, raw: Derivation, tape: Tape, point: Mapping[Any, Any], digits: int
) -> dict[sp.Expr, sp.Float]:
    """See ``VoronecEquations.acceleration``; ``tape`` is the ``acceleration_tape`` of ``raw``."""
    require_digits(f"system '{system.name}'", digits)
    others = {plain_name(time), *jets(system)}
    values = named_point(system, point, others, _check)
    values |= {str(f): values[name] for name, f in jets(system).items() if name in values}
    result = _accelerations(raw, tape, values, digits)
    if result is None:  # a pivot may vanish just here: solve the constraints for this point
        here = Derivation(read(system, values), False)
        result = _accelerations(here, acceleration_tape(here), values, digits)
    if result is None:
        raise DefinitionError(
            f"system '{system.name}' has no accelerations at this point: its mass matrix is "
            "singular, its equations are not defined there, or it lies just where they switch"
        )
    group = system.directions if system.on_group else ()
    return dict(zip((*system.coordinates, *group), result, strict=True))


def acceleration_tape(raw: Derivation) -> Tape:
    """Mass matrix, force, lift to the coordinates (on a group to its frame, too), drifts of their
    rates and relations, row by row."""
    n, connection = raw.connection.n, raw.connection
    rows, drifts = list(connection.coordinate_lift), list(raw.rate_drift)
    if connection.group is not None:
        rows, drifts = rows + list(connection.lift), drifts + raw.dot_drift
    mass, lift = ([e for row in matrix for e in row[:n]] for matrix in (raw.mass, rows))
    return Tape(stable_all([*mass, *raw.force, *lift, *drifts, *raw.definition.relations]))


def _accelerations(
    raw: Derivation, tape: Tape, values: dict[str, Any], digits: int
) -> list[sp.Float] | None:
    """Accelerations to ``digits`` digits; None where the equations give none."""
    system, n = raw.definition.system, raw.connection.n
    total = len(raw.rate_drift) + (len(raw.dot_drift) if raw.connection.group is not None else 0)
    unknown = [a for a in tape.atoms if str(a) not in values]
    if unknown:
        name = next((n for n, f in jets(system).items() if f == unknown[0]), None)
        mend = "add it to the point" if unknown[0].is_Symbol else "put a formula in its place"
        mend = f"add '{name}' to the point" if name is not None else mend
        raise DefinitionError(
            f"system '{system.name}' cannot be evaluated without a value for '{unknown[0]}'; {mend}"
        )
    bits, doubtful = int(3.33 * digits) + 64, False
    for _ in range(7):
        numbers = iter(tape.arb(values, bits))
        with flint.ctx.workprec(bits):
            m = flint.arb_mat(n, n, [next(numbers) for _ in range(n * n)])
            f = flint.arb_mat(n, 1, [next(numbers) for _ in range(n)])
            h = flint.arb_mat(total, n, [next(numbers) for _ in range(total * n)])
            drift = flint.arb_mat(total, 1, [next(numbers) for _ in range(total)])
            _check_relations(system, list(numbers))
            result = _solve(m, f, h, drift)
        if result is not None and _accurate(result, digits):
            if doubtful or all(a.is_zero() or not a.contains(0) for a in result):
                return [_float(a, digits) for a in result]
            doubtful = True  # what still holds zero at four times the precision counts as zero
            bits *= 2
        bits *= 2
    return None


def _float(ball: Any, digits: int) -> sp.Float:
    """The middle of a ball, bit by bit: Python reads no text of more than 4300 digits."""
    if ball.contains(0):
        return sp.Float(0, digits)
    with mp.workdps(digits):
        return sp.Float(middle(ball), digits)


def _solve(m: Any, f: Any, h: Any, drift: Any) -> list[Any] | None:
    try:
        vdot = m.solve(f) if f.nrows() else f
    except ZeroDivisionError:
        return None
    return list((h * vdot + drift).entries()) if f.nrows() else list(drift.entries())


def _accurate(result: list[Any], digits: int) -> bool:
    """Whether every entry is known to the digits asked for, but for those that may be zero, which
    are so to as many digits: what a sign is of that may be zero is no number at all."""
    small = flint.arb(2) ** -int(3.33 * digits)
    return all(
        a.is_finite()
        and (a.rad() < small if a.contains(0) else a.rel_accuracy_bits() > 3.33 * digits)
        for a in result
    )


def _check_relations(system: System, residuals: list[Any]) -> None:
    for relation, residual in zip(system.fibration.relations, residuals, strict=True):
        if not abs(residual) < ON_RELATIONS:
            raise DefinitionError(
                f"the point does not satisfy the relation {relation} = 0 of system "
                f"'{system.name}' (residual {float(residual.mid()):.3g}); correct the coordinates"
            )


def check_added_mass(raw: Derivation) -> None:
    """Raise ``DefinitionError`` where accelerations in forces make no symmetric mass matrix."""
    n = raw.connection.n
    gaps = [
        raw.added_mass[i][j] - raw.added_mass[j][i]
        for i in range(n if raw.added_mass else 0)
        for j in range(i)
    ]
    try:
        symmetric = all_vanish(gaps, raw.definition.relations)
    except EngineLimit:
        symmetric = False
    if not symmetric:
        raise DefinitionError(
            f"system '{raw.definition.system.name}': the forces hold accelerations, but not as an "
            "added mass does: the matrix of their coefficients on the velocities is not symmetric; "
            "solve the equations for the accelerations, and give forces without them"
        )


def check_inertia(raw: Derivation) -> None:
    """Raise ``DefinitionError`` where the mass matrix is singular at generic points."""
    n = raw.connection.n
    if n == 0:
        return
    entries = [e for row in raw.mass for e in row]
    try:
        for first in (0, 1, 2):  # one regular point is enough; a singular one may be bad luck
            samples = sample_evaluable(
                Tape(entries), raw.definition.relations, SHARP, first=12 * first, count=1
            )
            if not samples:
                return
            with flint.ctx.workprec(SHARP):
                if not flint.arb_mat(n, n, samples[0][1]).det().contains(0):
                    return
    except EngineLimit:
        return
    names = [plain_name(v) for v in raw.definition.system.velocities]
    empty = [names[i] for i in range(n) if all(e == 0 for e in raw.mass[i])]
    taken = ", less what accelerations in the forces take away," if raw.definition.added else ""
    where = f"the Lagrangian{taken} gives '{empty[0]}' no inertia" if empty else (
        f"no inertia resists some combination of {', '.join(names)}"
    )  # fmt: skip
    raise DefinitionError(
        f"system '{raw.definition.system.name}': the mass matrix is singular: {where}; "
        + ("change these forces, " if taken else "")
        + "add its kinetic energy, or remove the coordinate"
    )
