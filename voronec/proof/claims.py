"""Claims of a system, each proved, refuted or left undecided.

A field of dimension n with an invariant measure and n - 2 independent first integrals, neither
depending on the time, is integrated by quadratures.

A claim may hold of a case: the system under special values of its parameters.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import sympy as sp

from voronec.algebra.arguments import callback
from voronec.algebra.conditions import condition
from voronec.algebra.graphs import is_atom
from voronec.algebra.rank import generic_rank
from voronec.algebra.roots import known_sign
from voronec.algebra.symbols import plain_name
from voronec.algebra.sympy_bridge import SymPyBridge
from voronec.algebra.typeset import html_table
from voronec.algebra.verdicts import Verdict
from voronec.declaration.claims import (
    KINDS,
    Assertion,
    Case,
    Corrected,
    Equation,
    declared_claims,
    expressions_of,
    replace_symbols,
    right_of,
    without_claims,
)
from voronec.declaration.reading import expression
from voronec.declaration.scene import Parameter
from voronec.declaration.system import System, require_system
from voronec.equations.motions import Motions
from voronec.equations.vector_field import VectorField
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError, EngineLimit, quote
from voronec.proof.branch_cuts import across_cuts, not_vacuous
from voronec.proof.closure import decide_essential
from voronec.proof.decision import Decision, all_zero, verdict_on_failure
from voronec.proof.hamiltonian_form import decide_multiplier, decide_poisson
from voronec.proof.measures import binding, chosen_variables, decide_measure, measured_field
from voronec.proof.nondegeneracy import where_independent


def decide_integral(motions: Motions, function: sp.Expr) -> Decision:
    """dF/dt = 0 along the motion."""
    field = motions.field_for([function])
    named = field.read_with_momenta(function)
    inner = _innermost(named, frozenset(field.parameters))
    verdict = all_zero([("", field.derivative(inner))], field.hypotheses)
    if not verdict.proved and inner != named:
        verdict = all_zero([("", field.derivative(named))], field.hypotheses)
    inside = [("", field.read_branches(function))]
    return Decision(across_cuts(verdict, field, inside, constant=True), field.level)


def _decide_equation(motions: Motions, equation: Equation) -> Decision:
    """dF/dt = G along the motion, entry by entry; the first entry that fails is named."""
    field = motions.field_for([*expressions_of(equation)])
    functions = [field.read_with_momenta(f) for f in equation.function]
    rates = field.derivatives(functions)
    claimed = [field.read(g) for g in equation.rate]
    residuals = [a - b for a, b in zip(rates, claimed, strict=True)]
    verdict = all_zero(_number_residuals(residuals), field.hypotheses)
    inside = _number_residuals([field.read_branches(f) for f in equation.function])
    return Decision(across_cuts(verdict, field, inside, beyond=True), field.level)


def _innermost(function: Any, still: frozenset[Any]) -> Any:
    """G where a function is f(G): with G it is an integral, off the cuts of f."""
    while True:
        moving = [a for a in function.args if not a.free_symbols <= still]
        if len(moving) != 1 or is_atom(function):
            return function
        (function,) = moving


def _number_residuals(residuals: list[Any]) -> list[tuple[str, Any]]:
    if len(residuals) == 1:
        return [("", residuals[0])]
    return [(f"entry {i + 1}", r) for i, r in enumerate(residuals)]


def _decide_integrable(motions: Motions, known: _Known) -> Decision:
    """Whether integrals and a measure suffice for the theorem of Euler and Jacobi; where they do
    not, others may."""
    measure, measured = known.measure, known.verdict
    if measured is None:
        return Decision(Verdict("undecided", "no measure is declared"))
    if not measured.proved:
        return Decision(Verdict("undecided", f"the measure is {measured.status}"))
    field = measured_field(motions, measure)
    chosen = chosen_variables(field, measure)
    low, outside = field.level == "coordinates", _outside(motions, field, chosen)
    usable = [k for k in known.integrals if low or not motions.holds_coordinate([k[0]])]
    read = [(field.read(e), where) for e, where in usable]
    inside = [(f, where) for f, where in read if not f.free_symbols & outside]
    density = field.read(measure.density)
    # those that are integrals everywhere may suffice
    verdict = _count_integrals(field, chosen, [f for f, where in inside if not where], density)
    if (not verdict.proved or verdict.domain) and any(where for _, where in inside):
        every = _count_integrals(field, chosen, [f for f, _ in inside], density)
        if not (verdict.proved and every.domain):
            verdict = every.where(*(where for _, where in inside))
    return Decision(verdict.where(measured.domain), field.level)


def _outside(motions: Motions, field: VectorField, chosen: Sequence[Any]) -> set[Any]:
    """The state variables of either level that are not among the chosen ones."""
    definition = motions.equations.definition
    state = {
        *definition.coordinates,
        *definition.coordinate_velocities,
        *definition.velocities,
        *field.variables,
    }
    return state - {*chosen}


def _count_integrals(
    field: VectorField, chosen: Sequence[Any], functions: Sequence[Any], density: Any
) -> Verdict:
    relations = binding(field, chosen)
    rates = dict(zip(field.variables, field.components, strict=True))
    if any(field.time in e.free_symbols for e in (density, *(rates[x] for x in chosen))):
        return Verdict("undecided", "the time occurs; the theorem is one of autonomous fields")
    functions = [f for f in functions if field.time not in f.free_symbols]
    dimension = len(chosen) - len(relations)
    if len(functions) < dimension - 2:
        count = f"{len(functions)} integrals in {dimension} dimensions"
        return Verdict("undecided", f"{count}; the theorem asks for {dimension - 2}")
    slopes = [[f.diff(x) for x in chosen] for f in (*relations, *functions)]
    rank = generic_rank(slopes, field.hypotheses) if slopes else 0
    independent = rank - len(relations)
    if independent < dimension - 2:
        return Verdict("undecided", f"at the points tried {independent} integrals are independent")
    why = f"a measure and {independent} independent integrals in {dimension} dimensions"
    verdict = Verdict("proved", f"Euler and Jacobi: {why}")
    return where_independent(verdict, field, functions, chosen, relations, dimension - 2)


Decide = Callable[[Motions, Any], Decision]


@dataclass(frozen=True, repr=False)
class Claim:
    """One claim with its verdict.

    kind
        ``integral``, ``equation``, ``measure``, ``multiplier``, ``poisson``, ``essential``,
        ``integrable`` or ``descent``; or that of an ``Assertion``.
    name
        as declared, with the name of the case before it where it belongs to one.
    level
        ``coordinates`` or ``invariants``: the equations on which it was decided.
    seconds
        what the decision took.
    printed, source
        where a claim stands corrected: the verdict on the printed one, and who printed it.
    reason
        why the engine cannot decide it, as declared under ``undecided``.
    broken
        whether the engine failed on it by a mistake of its own, which the verdict tells.
    """

    kind: str
    name: str
    verdict: Verdict
    level: str = ""
    seconds: float = 0.0
    printed: Verdict | None = None
    source: str = ""
    reason: str = ""
    broken: bool = False

    def __repr__(self) -> str:
        return f"Claim({self.kind!r}, {self.name!r}, {self.standing!r})"

    def _repr_html_(self) -> str:
        """For notebooks: the claim and its verdict."""
        rows = [("verdict", self.standing), ("how", self.verdict.method), ("on", self.level)]
        if self.verdict.witness is not None:
            rows.append(("witness", str(self.verdict.witness)))
        return html_table(f"{self.kind}: {self.name}", rows)

    @property
    def is_admitted(self) -> bool:
        """Whether it is undecided, and declared to be so."""
        return bool(self.reason) and self.verdict.undecided

    @property
    def stale(self) -> bool:
        """Whether it is declared undecided, but has been decided."""
        return bool(self.reason) and not self.verdict.undecided

    @property
    def standing(self) -> str:
        """The verdict in words for a table."""
        words = " ".join(filter(None, (self.verdict.status, self.verdict.limits)))
        if self.printed is not None and self.verdict.proved:
            words += f"; refuted as printed in {self.source}"
        if self.is_admitted:
            words += f": {self.reason}"
        if self.stale:
            words += "; declared undecided, which is out of date"
        return words


@dataclass(frozen=True)
class _Known:
    """What a theorem may rest on: integrals that are proved, each with where, a measure and the
    verdict on it."""

    integrals: tuple[tuple[Any, str], ...] = ()
    measure: Any = None
    verdict: Verdict | None = None

    def with_claims(self, system: System, claims: list[Claim]) -> _Known:
        """With what has been decided of a system and is still declared."""
        proved = {c.name: c.verdict for c in claims if c.kind == "integral" and c.verdict.proved}
        added = (
            (right_of(e), proved[n].domain) for n, e in system.integrals.items() if n in proved
        )
        integrals = self.integrals + tuple(added)
        for claim in claims:
            if claim.kind == "measure" and system.measure is not None:
                return _Known(integrals, right_of(system.measure), claim.verdict)
        return replace(self, integrals=integrals)


def check_claims(
    system: System | VoronecEquations | Motions, progress: Callable[[str], None] | None = None
) -> list[Claim]:
    """Prove or refute every claim that a system declares, those of its cases included.

    ``progress`` is called with the words for each claim before it is decided.  Raises
    ``DefinitionError`` where the definition of the system makes no sense; a claim that makes none
    is refuted.  Where no equations can be derived the claims are undecided, or refuted where it is
    proved that there are no motions.
    """
    tell = callback("check_claims", "progress", progress) or (lambda _: None)
    declared = require_system(getattr(system, "system", system))
    try:
        motions = system if isinstance(system, Motions) else Motions.of(system)
        _ = motions.on_coordinates
    except EngineLimit as limit:
        claims = _claims_without_equations(declared, limit)
    else:
        claims = _claims_of(motions, _Known(), tell)
    known = [*claims]
    for name, case in declared.cases.items():
        claims += _claims_of_case(declared, name, case, known, tell)
    return [_with_reason(claim, declared) for claim in claims]


def _claims_without_equations(system: System, limit: EngineLimit) -> list[Claim]:
    """The claims of a system whose equations are beyond the engine, as of one whose relations no
    state meets: all of them have one verdict."""
    bridge = SymPyBridge(system.known_symbols(), system.inputs)
    relations = [(r, bridge.inward(r)) for r in system.fibration.relations]
    known = [*(condition(c, bridge.inward) for c in system.conditions), *bridge.hypotheses]
    empty = [r for r, inside in relations if known_sign(inside, known, strict=True) != 0]
    words = [f"there are no motions: {quote(r)} = 0 holds nowhere" for r in empty]
    verdict = Verdict("refuted", words[0]) if empty else Verdict("undecided", str(limit))
    named = [(c.kind, c.name) for c in declared_claims(system)]
    named += [("descent", ", ".join(system.invariants))] if system.invariants else []
    return [Claim(kind, name, verdict) for kind, name in named]


def _claims_of_case(
    system: System, name: str, case: Case, known: list[Claim], tell: Callable[[str], None]
) -> list[Claim]:
    """The claims of one case; that it makes no sense, or is too much, is found of it alone."""
    tell(f"case {name}")
    try:
        general = _Known().with_claims(specialise(system, case.parameters), known)
        claims = _claims_of(Motions.of(case_of(system, case)), general, tell)
    except DefinitionError as error:
        return [Claim("case", name, Verdict("refuted", str(error)))]
    except EngineLimit as limit:
        return [Claim("case", name, Verdict("undecided", str(limit)))]
    except Exception as error:  # a mistake of the engine
        how = " ".join(f"{type(error).__name__}: {error}".split())
        return [Claim("case", name, Verdict("undecided", how), broken=True)]
    return [replace(c, name=f"{name}: {c.name}") for c in claims if c.kind != "descent"]


def _claims_of(motions: Motions, general: _Known, tell: Callable[[str], None]) -> list[Claim]:
    """The claims of one system; ``general`` is what is known already."""
    system = motions.system
    _ = motions.on_coordinates  # the derivation belongs to no claim
    descent = _decide_claim("descent", ", ".join(system.invariants), _descends, motions, None)
    claims: list[Claim] = []
    for kind, name, _, _, value in declared_claims(system):
        decide = DECIDERS.get(kind, _decide_assertion)
        # a theorem rests on what has been decided before it
        about = general.with_claims(system, claims) if kind == "integrable" else value
        tell(f"{kind} {name}")
        claims.append(_decide_claim(kind, name, decide, motions, about))
    return [*claims, descent] if system.invariants else claims


def _decide_assertion(motions: Motions, claim: Assertion) -> Decision:
    """A claim of a kind of somebody's own, decided as it says."""
    verdict = claim.decide(motions, claim.expressions)
    if not isinstance(verdict, Verdict):
        raise DefinitionError(
            f"what decides '{claim.kind}' returned '{quote(verdict)}'; return a Verdict"
        )
    return Decision(verdict)


DECIDERS: dict[str, Decide] = {
    "integral": decide_integral,
    "equation": _decide_equation,
    "measure": decide_measure,
    "multiplier": decide_multiplier,
    "poisson": decide_poisson,
    "essential": decide_essential,
    "integrable": _decide_integrable,
}


def _descends(motions: Motions, _: Any) -> Decision:
    if not motions.system.invariants:
        return Decision(Verdict("undecided", "no invariants are declared"))
    try:
        _ = motions.reduction
    except DefinitionError as refusal:
        return Decision(Verdict("refuted", str(refusal)))
    verdict = Verdict("proved", "equations closed in the invariants, by elimination")
    field = motions.on_coordinates
    inside = [(f"'{name}'", field.read(g)) for name, g in motions.system.invariants.items()]
    return Decision(across_cuts(verdict, field, inside))


def _decide_claim(kind: str, name: str, decide: Decide, motions: Motions, claim: Any) -> Claim:
    """A claim, timed; a corrected one is two."""
    begin = clock.perf_counter()
    decision = _decide_within_limits(decide, motions, right_of(claim))
    decision = replace(decision, verdict=not_vacuous(decision.verdict, motions.on_coordinates))
    printed, source, verdict = None, "", decision.verdict
    if isinstance(claim, Corrected):
        printed = _decide_within_limits(decide, motions, claim.printed).verdict
        source = claim.source
        verdict = _correction_verdict(decision.verdict, printed)
    seconds = clock.perf_counter() - begin
    return Claim(kind, name, verdict, decision.level, seconds, printed, source)


def _decide_within_limits(decide: Decide, motions: Motions, claim: Any) -> Decision:
    try:
        return decide(motions, claim)
    except (EngineLimit, DefinitionError) as error:  # the other claims stand all the same
        return Decision(verdict_on_failure(error))


def _correction_verdict(right: Verdict, printed: Verdict) -> Verdict:
    """A correction is proved where the right form is proved and the printed one refuted."""
    if not right.proved or printed.refuted:
        return right
    if printed.proved:
        return Verdict("refuted", "the printed form is proved too; there is nothing to correct")
    return Verdict("undecided", f"the printed form is not refuted: {printed.method}")


def _with_reason(claim: Claim, system: System) -> Claim:
    """The claim with the reason why it is declared undecided, if it is."""
    case, _, _ = claim.name.rpartition(": ")
    kind = f"{case}: {claim.kind}" if case in system.cases else claim.kind
    reason = system.undecided.get(claim.name) or system.undecided.get(kind)
    return replace(claim, reason=reason) if reason else claim


def specialise(
    system: System, parameters: Mapping[Any, Any], new: tuple[Parameter, ...] = ()
) -> System:
    """The system with some parameters, and inputs, replaced everywhere by numbers or by functions
    of other parameters.

    ``new`` are parameters that these functions may hold besides those that remain.  Of the claims
    the integrals, equations and measure are kept that are defined at these values.
    """
    at = _case_values(system, parameters)
    kept = tuple(p for p in system.parameters if p.symbol not in at)
    names = {plain_name(s) for s in at}
    moved = ("lagrangian", "constraints", "forces", "invariants")
    return replace(
        system,
        fibration=_replace_in(system.fibration, at, "relations"),
        parameters=(*kept, *new),
        inputs=tuple(i for i in system.inputs if i not in at),
        possible=_still_possible(system, at),
        frame=_replace_in(system.frame, at, "expressions", "brackets", "rates"),
        **{name: replace_symbols(getattr(system, name), at) for name in moved},
        **without_claims() | _kept_claims(system, at),
        scenes={k: _without(scene, names) for k, scene in system.scenes.items()},
        drawing=None,
        shapes=(),
        bodies=(),
        motion=None,
    )


def _replace_in(holder: Any, at: Mapping[Any, Any], *names: str) -> Any:
    """What holds declarations, with symbols replaced in some of them."""
    if holder is None:
        return None
    return replace(holder, **{name: replace_symbols(getattr(holder, name), at) for name in names})


def _still_possible(system: System, at: Mapping[Any, Any]) -> dict[str, Any]:
    """What the remaining parameters must meet, the ranges of the replaced ones among it.

    What a value contradicts, as a mass of zero, is dropped: it is the case that says so.
    """
    ranges = {f"{c}": c for p in system.parameters if p.symbol in at for c in p.conditions}
    moved = {words: c.xreplace(at) for words, c in (*system.possible.items(), *ranges.items())}
    known = {p.symbol for p in system.parameters if p.symbol not in at}
    known |= {s for value in at.values() for s in value.free_symbols} - at.keys()
    open_ones = {words: c for words, c in moved.items() if c not in (sp.true, sp.false)}
    return {words: c for words, c in open_ones.items() if c.free_symbols <= known}


def case_of(system: System, case: Case) -> System:
    """The specialised system with the claims of the case alone."""
    at = _case_values(system, case.parameters)
    bare = replace(system, **without_claims())
    fields = [kind.field for kind in KINDS if hasattr(case, kind.field)]
    claims = {field: replace_symbols(getattr(case, field), at) for field in fields}
    return replace(specialise(bare, case.parameters), **claims)


def _case_values(system: System, parameters: Mapping[Any, Any]) -> dict[sp.Expr, sp.Expr]:
    """Values by symbols of the system; keys may be names."""
    known = {p.name: p.symbol for p in system.parameters}
    known |= {plain_name(i): i for i in system.inputs}
    values = {}
    for key, value in parameters.items():
        name = plain_name(key)
        if name not in known:
            raise DefinitionError(
                f"system '{system.name}' has no parameter '{name}' to give a value to; "
                f"its parameters are {', '.join(known)}"
            )
        values[known[name]] = expression(value, f"the value of '{name}'")
    return values


def _kept_claims(system: System, at: Mapping[Any, Any]) -> dict[str, Any]:
    """The integrals, equations and measure at some values of parameters."""
    density = {} if system.measure is None else {"": system.measure}
    return {
        "integrals": _finite_claims(system.integrals, at),
        "equations": _finite_claims(system.equations, at),
        "measure": _finite_claims(density, at).get(""),
    }


def _finite_claims(claims: Mapping[str, Any], at: Mapping[Any, Any]) -> dict[str, Any]:
    """Claims with parameters replaced, but for those that this makes infinite."""
    finite = {}
    for name, claim in claims.items():
        try:
            special = replace_symbols(claim, at)
        except DefinitionError:
            continue
        if not any(e.has(sp.zoo, sp.nan, sp.oo, -sp.oo) for e in expressions_of(special)):
            finite[name] = special
    return finite


def _without(scene: Any, names: set[str]) -> Any:
    """A scene that sets none of the replaced parameters and inputs."""

    def others(given: Mapping[Any, Any]) -> dict[Any, Any]:
        return {k: v for k, v in given.items() if plain_name(k) not in names}

    return replace(scene, parameters=others(scene.parameters), inputs=others(scene.inputs))
