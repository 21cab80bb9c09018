"""The claims of a system in words, as ``show`` prints them: nothing is decided."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

from voronec.cli.output import plain

if TYPE_CHECKING:
    from voronec.claims import Poisson
    from voronec.quadratures import Plane, Quadratures
    from voronec.system import System

__all__ = ["declared_claims"]


def declared_claims(system: System) -> list[dict[str, str]]:
    """Every claim: kind, name and statement; where corrected, what is printed and its source."""
    claims = [*_held(system, "")]
    if system.poisson is not None:
        claims.append(_claim("poisson", "bracket", _bracket(system.poisson)))
    if system.essential:
        claims.append(_claim("essential", "closed", _list(system.essential)))
    for name, case in system.cases.items():
        values = ", ".join(f"{plain(k)} = {plain(v)}" for k, v in case.parameters.items())
        claims.append(_claim("case", name, ": ".join(filter(None, (values, case.note)))))
        claims += _held(case, f"{name}: ")
    if system.motion is not None:
        claims += _by_quadratures(system.motion)
    claims += [_claim("undecided", name, why) for name, why in system.undecided.items()]
    claims += [_claim("invariant", name, plain(e)) for name, e in system.invariants.items()]
    return claims


def _claim(kind: str, name: str, statement: str) -> dict[str, str]:
    return {"kind": kind, "name": name, "statement": statement}


def _held(holder: Any, case: str) -> Iterator[dict[str, str]]:
    """The claims that a system and a case have in common."""
    named = [("integral", name, claim) for name, claim in holder.integrals.items()]
    named += [("equation", name, claim) for name, claim in holder.equations.items()]
    if holder.measure is not None:
        named.append(("measure", "density", holder.measure))
    for kind, name, claim in named:
        yield _claim(kind, case + name, _statement(claim)) | _correction(claim)
    if holder.multiplier is not None:
        yield _claim("multiplier", case + "dtau = N dt", "N = " + plain(holder.multiplier))
    if holder.integrable:
        yield _claim("integrable", case + holder.integrable, "by quadratures")


def _by_quadratures(motion: Quadratures) -> Iterator[dict[str, str]]:
    """The rates of the variable and of the angles, and what the symbols in them stand for."""
    x, time = motion.x, "t" if motion.clock == 1 else "tau"
    yield _claim("motion", f"{x}", f"{x} = {plain(motion.meaning)}")
    for symbol, meaning in motion.constants.items():
        yield _claim("motion", f"{symbol}", f"{symbol} = {plain(meaning)}, constant")
    if motion.clock != 1:
        yield _claim("motion", "clock", f"dt/dtau = {plain(motion.clock)}")
    yield _claim("motion", f"rate of {x}", f"(d{x}/d{time})^2 = {plain(motion.quartic)}")
    for q, rate in motion.integrals.items():
        yield _claim("motion", f"rate of {plain(q)}", f"d{plain(q)}/d{time} = {plain(rate)}")
    for trace in motion.traces:
        name = plain(trace.colatitude)
        yield _claim("motion", f"cosine of {name}", f"cos({name}) = {plain(trace.cosine)}")
    if motion.space is not None:
        space = motion.space
        vector = f"({_list(space.frame * space.vector)})"
        yield _claim("motion", "space", f"{_list(space.coordinates)}: where {vector} is upright")
    if motion.plane is not None:
        plane = motion.plane
        yield _claim("motion", "plane", _run(plane, x, time))


def _run(plane: Plane, x: Any, time: str) -> str:
    """How a contact moves over a plane, in units of a vector there."""
    forward, left = (
        f"({plain(rate)}) d{time} + ({plain(slope)}) d{x}"
        for rate, slope in zip(plane.rates, plane.slopes, strict=True)
    )
    place, vector = _list(plane.place), _list(plane.direction)
    return f"({place}) by {forward} along ({vector}), {left} to its left"


def _correction(claim: Any) -> dict[str, str]:
    from voronec.claims import Corrected

    if not isinstance(claim, Corrected):
        return {}
    return {"printed": _statement(claim.printed), "source": claim.source}


def _statement(claim: Any) -> str:
    from voronec.claims import Equation, Measure, right_of

    claim = right_of(claim)
    if isinstance(claim, Equation):
        pairs = zip(claim.function, claim.rate, strict=True)
        return "; ".join(f"d/dt ({plain(f)}) = {plain(g)}" for f, g in pairs)
    if isinstance(claim, Measure):
        variables = f" in {_list(claim.variables)}" if claim.variables else ""
        return plain(claim.density) + variables
    return plain(claim)


def _bracket(claim: Poisson) -> str:
    pairs = [f"{{{plain(a)}, {plain(b)}}} = {plain(e)}" for (a, b), e in claim.bracket.items()]
    meanings = [f"{plain(z)} = {plain(e)}" for z, e in claim.variables.items() if z != e]
    clock = [] if claim.clock == 1 else [f"clock {plain(claim.clock)}"]
    return "; ".join([*meanings, *pairs, f"H = {plain(claim.hamiltonian)}", *clock])


def _list(things: Iterable[Any]) -> str:
    return ", ".join(map(plain, things))
