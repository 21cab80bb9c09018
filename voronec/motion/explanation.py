"""What a scene needs of a system's equations: the smallest model, made to be looked at.

In words: what is integrated, what is not, and why.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import zip_longest
from typing import TYPE_CHECKING, Any

import sympy as sp

from voronec.algebra.arguments import SEVERAL, VALUES, accepts
from voronec.algebra.columns import columns
from voronec.algebra.symbols import plain_name
from voronec.algebra.verdicts import decide_zero
from voronec.declaration.claims import right_of
from voronec.declaration.scene import Scene
from voronec.declaration.system import System, require_system
from voronec.equations.motions import Motions
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.errors import DefinitionError, VoronecError
from voronec.motion.formulation import Model, smallest_model
from voronec.motion.initial_conditions import parameter_values, start_of
from voronec.motion.inputs import drive
from voronec.motion.motion_start import rates_at
from voronec.motion.numeric_model import numbers_at
from voronec.motion.reactions import Multipliers
from voronec.motion.request import Namespace, StartData, begin_of, outputs_of, scene_of

if TYPE_CHECKING:
    from voronec.motion.formulation import Role


@accepts(outputs=SEVERAL, parameters=VALUES, inputs=VALUES, initial=VALUES)
def explain(
    system: System | VoronecEquations,
    scene: str | Scene | None = None,
    outputs: Sequence[Any] = (),
    parameters: Mapping[Any, Any] | None = None,
    initial: Mapping[Any, Any] | None = None,
    inputs: Mapping[Any, Any] | None = None,
) -> Model:
    """The smallest model in which the outputs of a scene can be computed, and why it is that one.

    Arguments are those of ``integrate``, but an input need not have a value: outputs are names,
    symbols or expressions, those of the scene unless told, else all coordinates and velocities.
    Where there is no scene ``default`` and none is named, and nothing is said of the start, the
    model holds for all starts; else what is zero in that one motion is frozen.

    ``model.roles`` says of each variable whether it is integrated, a quadrature, a constant, given
    by a first integral, read off or dropped, and why; ``model.candidates`` which formulations of
    the equations were weighed; ``model.states``, ``model.form``, ``model.outputs`` are what is
    left; ``model.graph`` is a networkx graph of which rate holds which variable.  Raises
    ``DefinitionError`` for input that makes no sense.
    """
    declared = system.system if isinstance(system, VoronecEquations) else require_system(system)
    driven = drive(system, inputs, scene_of(declared, scene, False), unknown=True)
    equations = driven.equations
    namespace = Namespace.of(equations, driven.meaning)
    usual = initial is None and "default" in equations.system.scenes
    chosen = scene_of(equations.system, scene, usual)
    wanted = _output_expressions(namespace, outputs_of(chosen, outputs))
    start = None
    if chosen is not None or initial is not None:
        given = StartData.of(namespace, chosen, parameters, initial)
        start = _start(namespace, chosen, given, driven.constants)
    elif parameters:
        raise DefinitionError(
            f"system '{equations.system.name}': parameters without a start; name a scene, or give "
            "initial={...}"
        )
    motions = Motions.of(equations)
    refuted = _refuted_integrals(motions)
    names = [name for name in equations.system.integrals if name not in refuted]
    integrals = {name: namespace.claims[name] for name in names}
    model = smallest_model(motions, wanted, integrals, start, thorough=True)
    return replace(model, refuted=refuted)


def _refuted_integrals(motions: Motions) -> tuple[str, ...]:
    """The declared integrals whose rate along the motion is proved not to vanish."""
    refuted = []
    for name, integral in motions.system.integrals.items():
        function = right_of(integral)
        try:
            field = motions.field_for([function])
            rate = field.derivative(field.read_with_momenta(function))
            if decide_zero(rate, field.relations).refuted:
                refuted.append(name)
        except VoronecError:  # beyond the budget: nothing is known of it
            continue
    return tuple(refuted)


def _output_expressions(namespace: Namespace, outputs: Sequence[Any]) -> dict[str, sp.Expr]:
    """Outputs in the user's symbols; a reaction is what its multiplier is computed from."""
    spelled = namespace.read_outputs(outputs)
    expressions = {n: e for n, e in spelled.terms.items() if not namespace.holds_reactions([e])}
    if spelled.reactions or len(expressions) < len(spelled.terms):
        equations = namespace.equations
        entries = Multipliers.of(equations.definition).entries.values()
        held = {equations.bridge.outward(s) for e in entries for s in e.free_symbols}
        # accelerations stand in them too, so every velocity is needed
        coordinates = [q for q in equations.system.coordinates if q in held]
        for x in (*coordinates, *equations.system.velocities):
            expressions.setdefault(plain_name(x), x)
    return expressions


def _start(
    namespace: Namespace, scene: Scene | None, given: StartData, inputs: Mapping[str, Any]
) -> dict[Any, float]:
    """Numbers of coordinates, velocities, parameters, time; what has no value is left out."""
    equations = namespace.equations
    constants = parameter_values(namespace, {**given.parameters, **inputs}, set())
    time, form = begin_of(scene), equations.raw.form
    rates = rates_at(equations, form, constants, time)
    start = start_of(namespace, given.scene_initial, given.initial, constants, rates, time)
    return numbers_at(form, start.state, constants, time)


KINDS = (
    "integrated", "quadrature", "constant", "zero", "integral", "read off", "replaced", "dropped",
)  # fmt: skip
"""What may become of a variable, in the order of being told."""
WIDTH = 96
"""Letters in a line of text."""
LONGEST = 60
"""A formula with more characters is not written out."""


def model_text(model: Model, width: int = WIDTH) -> str:
    """The explanation of a model, a few lines of plain text."""
    cut = model.cut
    wanted = sorted({*cut.outputs, *cut.angles}, key=_place(model))
    head = f"{model.system.name}: the smallest model for {', '.join(wanted)}"
    count, words = len(model.states), _formulation_words(model.formulation)
    size = f"{count} state{'' if count == 1 else 's'}, in {words}"
    parts = [*_wrap([head], width, ""), size, "", *_roles(model, width), ""]
    parts += ["what was weighed", *_formulations(model), ""]
    limit = derive(model.system).limit
    if limit is not None:
        parts += [*_wrap([f"normal forms were left: {limit}"], width, "  "), ""]
    return "\n".join([*parts, *_followed_integrals(model, width)])


def _roles(model: Model, width: int) -> list[str]:
    """The variables of one kind and one reason together, reasons on the right."""
    rows: dict[tuple[str, str], list[str]] = {}
    for role in model.roles:
        rows.setdefault((role.kind, _why(model, role)), []).append(role.variable)
    table = [
        ("by an integral" if kind == "integral" else kind, ", ".join(names), why)
        for (kind, why), names in sorted(rows.items(), key=lambda row: KINDS.index(row[0][0]))
    ]
    first = max(len(kind) for kind, *_ in table)
    second = min(max(len(names) for _, names, _ in table), width // 3)
    lines: list[str] = []
    before = ""
    for kind, names, why in table:
        shown = textwrap.wrap(names, second) or [""]
        said = textwrap.wrap(why, max(width - first - second - 4, 20))
        for row in zip_longest(["" if kind == before else kind], shown, said, fillvalue=""):
            lines.append(f"{row[0]:{first}}  {row[1]:{second}}  {row[2]}".rstrip())
        before = kind
    return lines


def _why(model: Model, role: Role) -> str:
    """The reason, with the formula where a first integral gives the variable."""
    if role.kind != "integral":
        return role.why.replace("**", "^")
    formula = next((e for x, e in model.cut.stages if str(x) == role.variable), None)
    text = "" if formula is None else str(formula).replace("**", "^")
    return f"{role.why}: {role.variable} = {text}" if 0 < len(text) <= LONGEST else role.why


def _formulations(model: Model) -> list[str]:
    """A table of the formulations with their cost; the weight counts products of moving
    quantities."""
    head = ["variables", "states", "operations", "weight", ""]
    rows = [
        [
            _formulation_words(c.formulation), str(c.states), str(c.operations), f"{c.weight:.1f}",
            "chosen" if c.chosen else "",
        ]
        for c in model.candidates
    ]  # fmt: skip
    return columns([head, *rows], right={1, 2, 3})


def _followed_integrals(model: Model, width: int) -> list[str]:
    """Which declared integrals the model can still compute."""
    instead = model.eliminating_integrals
    able = [name for name in model.integrals if name not in instead]
    told = {*able, *instead, *model.refuted}
    lost = [name for name in model.system.integrals if name not in told]
    rows = [
        ("declared integrals that can be followed", able),
        ("integrals in place of equations", instead),
        ("integrals that need more variables", lost),
        ("declared integrals that are not constant, which is proved", model.refuted),
    ]
    lines = [f"{what}: {', '.join(names)}" for what, names in rows if names]
    return _wrap(lines or ["no integral is declared"], width, "  ")


def _formulation_words(name: str) -> str:
    return "coordinates and momenta" if name == "momenta" else name.replace(
        "coordinates", "coordinates and velocities"
    )  # fmt: skip


def _place(model: Model) -> Any:
    """The order of the system's own declaration; expressions after that."""
    system = model.system
    known = [*map(str, (*system.coordinates, *system.velocities)), *system.invariants]
    return lambda name: (known.index(name) if name in known else len(known), name)


def _wrap(lines: Iterable[str], width: int, indent: str) -> list[str]:
    return [part for line in lines for part in textwrap.wrap(line, width, subsequent_indent=indent)]
