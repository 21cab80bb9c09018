"""Voronec equations of nonholonomic systems, exact and without multipliers.

Public names load on first use, so that ``import voronec`` costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from voronec.accuracy.hard import HardCase
    from voronec.algebra.signs import prove_inequality
    from voronec.algebra.symbols import time, velocity
    from voronec.algebra.verdicts import Verdict, Witness, prove_equal
    from voronec.audit.lessons.judgement import Judgement, judge
    from voronec.audit.lessons.lesson import lesson
    from voronec.audit.lessons.methods import by_methods
    from voronec.closed import ClosedForm
    from voronec.closed.special.precessions import Precessions, precessions
    from voronec.declaration.bodies import Body
    from voronec.declaration.catalogue import load, names
    from voronec.declaration.charts import Chart
    from voronec.declaration.claims import Assertion, Case, Corrected, Equation, Measure, Poisson
    from voronec.declaration.geometry import Fibration, Frame
    from voronec.declaration.mechanics import from_mechanics
    from voronec.declaration.quadratures import Plane, Quadratures, Space, Trace
    from voronec.declaration.relation import Limit, Relation, Square
    from voronec.declaration.scene import Parameter, Scene
    from voronec.declaration.shapes import Shape
    from voronec.declaration.sketch import Sketch
    from voronec.declaration.system import System
    from voronec.equations.linearisation import Linearisation, linearise
    from voronec.equations.reduction import Reduction, descend
    from voronec.equations.referee import multiplier_acceleration, reaction_forces
    from voronec.equations.voronec_equations import VoronecEquations, derive
    from voronec.errors import DefinitionError, EngineLimit, IntegrationError, VoronecError
    from voronec.motion import (
        Crossings,
        Ensemble,
        Event,
        PreparedProblem,
        Section,
        Table,
        Trajectory,
        ensemble,
        integrate,
        prepare,
        section,
    )
    from voronec.motion.closed_form import closed_form
    from voronec.motion.explanation import explain
    from voronec.motion.model import Model
    from voronec.motion.storage import open
    from voronec.proof.check import check_catalogue, check_relation, graph
    from voronec.proof.claims import Claim, check_claims
    from voronec.proof.comparison import compare
    from voronec.proof.measures import divergence
    from voronec.proof.search import FoundIntegral, IntegralSearch, search_integrals
    from voronec.sweeps import Draws, Sweep, sweep

__version__ = "0.9.0"

_HOME = {
    name: f"voronec.{module}"
    for module, names in {
        "accuracy.hard": "HardCase",
        "algebra.signs": "prove_inequality",
        "algebra.symbols": "time velocity",
        "algebra.verdicts": "prove_equal Verdict Witness",
        "audit.lessons.judgement": "judge Judgement",
        "audit.lessons.lesson": "lesson",
        "audit.lessons.methods": "by_methods",
        "closed": "ClosedForm",
        "closed.special": "Precessions precessions",
        "declaration.bodies": "Body",
        "declaration.catalogue": "load names",
        "declaration.charts": "Chart",
        "declaration.claims": "Assertion Case Corrected Equation Measure Poisson",
        "declaration.geometry": "Fibration Frame",
        "declaration.mechanics": "from_mechanics",
        "declaration.quadratures": "Plane Quadratures Space Trace",
        "declaration.relation": "Limit Relation Square",
        "declaration.scene": "Parameter Scene",
        "declaration.shapes": "Shape",
        "declaration.sketch": "Sketch",
        "declaration.system": "System",
        "equations.linearisation": "Linearisation linearise",
        "equations.reduction": "descend Reduction",
        "equations.referee": "multiplier_acceleration reaction_forces",
        "equations.voronec_equations": "derive VoronecEquations",
        "errors": "DefinitionError EngineLimit IntegrationError VoronecError",
        "kinematics": "kinematics",
        "motion": "Crossings Ensemble ensemble Event integrate prepare PreparedProblem Section "
        "section Table Trajectory",
        "motion.closed_form": "closed_form",
        "motion.explanation": "explain",
        "motion.model": "Model",
        "motion.storage": "open",
        "proof.check": "check_catalogue check_relation graph",
        "proof.claims": "check_claims Claim",
        "proof.comparison": "compare",
        "proof.measures": "divergence",
        "proof.search": "FoundIntegral IntegralSearch search_integrals",
        "sweeps": "Draws Sweep sweep",
    }.items()
    for name in names.split()
}
"""Where the names are that load on first use."""

__all__ = [
    "Assertion",
    "Body",
    "Case",
    "Chart",
    "Claim",
    "ClosedForm",
    "Corrected",
    "Crossings",
    "DefinitionError",
    "Draws",
    "EngineLimit",
    "Ensemble",
    "Equation",
    "Event",
    "Fibration",
    "FoundIntegral",
    "Frame",
    "HardCase",
    "IntegralSearch",
    "IntegrationError",
    "Judgement",
    "Limit",
    "Linearisation",
    "Measure",
    "Model",
    "Parameter",
    "Plane",
    "Poisson",
    "Precessions",
    "PreparedProblem",
    "Quadratures",
    "Reduction",
    "Relation",
    "Scene",
    "Section",
    "Shape",
    "Sketch",
    "Space",
    "Square",
    "Sweep",
    "System",
    "Table",
    "Trace",
    "Trajectory",
    "Verdict",
    "VoronecEquations",
    "VoronecError",
    "Witness",
    "by_methods",
    "check_catalogue",
    "check_claims",
    "check_relation",
    "closed_form",
    "compare",
    "derive",
    "descend",
    "divergence",
    "ensemble",
    "explain",
    "from_mechanics",
    "graph",
    "integrate",
    "judge",
    "kinematics",
    "lesson",
    "linearise",
    "load",
    "multiplier_acceleration",
    "names",
    "open",
    "precessions",
    "prepare",
    "prove_equal",
    "prove_inequality",
    "reaction_forces",
    "search_integrals",
    "section",
    "sweep",
    "time",
    "velocity",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        from voronec.errors import did_you_mean

        hint = "" if name.startswith("_") else did_you_mean(name, _HOME)
        near = hint if "mean" in hint else ""
        raise AttributeError(f"module 'voronec' has no attribute '{name}'{near}")
    from voronec.declaration.catalogue import no_collection

    with no_collection():
        module = import_module(_HOME[name])
        value = module if name == "kinematics" else getattr(module, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOME})
