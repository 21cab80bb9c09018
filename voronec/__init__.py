"""Voronec equations of nonholonomic systems, exact and without multipliers.

Public names load on first use, so that ``import voronec`` costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from voronec.algebra.signs import prove_inequality
    from voronec.algebra.symbols import time, velocity
    from voronec.algebra.verdicts import Verdict, Witness, prove_equal
    from voronec.analysis import Claim, check_claims, divergence
    from voronec.analysis.search import FoundIntegral, IntegralSearch, search_integrals
    from voronec.catalogue import load, names
    from voronec.charts import Chart
    from voronec.checking import check_catalogue, check_relation, graph
    from voronec.claims import Case, Corrected, Equation, Measure, Poisson
    from voronec.closed import ClosedForm
    from voronec.closed.special.family import Precessions, precessions
    from voronec.comparison import compare
    from voronec.equations import VoronecEquations, derive
    from voronec.errors import (
        DefinitionError,
        EngineLimit,
        IntegrationError,
        VoronecError,
    )
    from voronec.flow import (
        Crossings,
        Ensemble,
        Event,
        Section,
        Table,
        Trajectory,
        ensemble,
        integrate,
        section,
    )
    from voronec.flow.closed_form import closed_form
    from voronec.flow.explanation import explain
    from voronec.geometry import Fibration, Frame
    from voronec.hard import HardCase
    from voronec.model import Model
    from voronec.multipliers import multiplier_acceleration, reaction_forces
    from voronec.quadratures import Plane, Quadratures, Space, Trace
    from voronec.reduction import Reduction, descend
    from voronec.relations import Limit, Relation, Square
    from voronec.scene import Parameter, Scene
    from voronec.system import System

__version__ = "0.1.0"

_HOME = {
    "time": "voronec.algebra.symbols",
    "velocity": "voronec.algebra.symbols",
    "prove_inequality": "voronec.algebra.signs",
    "Verdict": "voronec.algebra.verdicts",
    "Witness": "voronec.algebra.verdicts",
    "prove_equal": "voronec.algebra.verdicts",
    "Chart": "voronec.charts",
    "check_catalogue": "voronec.checking",
    "check_relation": "voronec.checking",
    "ClosedForm": "voronec.closed",
    "compare": "voronec.comparison",
    "Precessions": "voronec.closed.special",
    "precessions": "voronec.closed.special",
    "load": "voronec.catalogue",
    "names": "voronec.catalogue",
    "graph": "voronec.checking",
    "VoronecEquations": "voronec.equations",
    "derive": "voronec.equations",
    "DefinitionError": "voronec.errors",
    "EngineLimit": "voronec.errors",
    "IntegrationError": "voronec.errors",
    "VoronecError": "voronec.errors",
    "Crossings": "voronec.flow",
    "Ensemble": "voronec.flow",
    "Event": "voronec.flow",
    "Section": "voronec.flow",
    "Trajectory": "voronec.flow",
    "ensemble": "voronec.flow",
    "integrate": "voronec.flow",
    "Table": "voronec.flow",
    "section": "voronec.flow",
    "closed_form": "voronec.flow.closed_form",
    "explain": "voronec.flow.explanation",
    "Model": "voronec.model",
    "Fibration": "voronec.geometry",
    "Frame": "voronec.geometry",
    "HardCase": "voronec.hard",
    "multiplier_acceleration": "voronec.multipliers",
    "reaction_forces": "voronec.multipliers",
    "Claim": "voronec.analysis",
    "FoundIntegral": "voronec.analysis.search",
    "IntegralSearch": "voronec.analysis.search",
    "search_integrals": "voronec.analysis.search",
    "check_claims": "voronec.analysis",
    "divergence": "voronec.analysis",
    "Reduction": "voronec.reduction",
    "descend": "voronec.reduction",
    "Case": "voronec.claims",
    "Corrected": "voronec.claims",
    "Equation": "voronec.claims",
    "Measure": "voronec.claims",
    "Poisson": "voronec.claims",
    "Limit": "voronec.relations",
    "Relation": "voronec.relations",
    "Square": "voronec.relations",
    "Plane": "voronec.quadratures",
    "Quadratures": "voronec.quadratures",
    "Space": "voronec.quadratures",
    "Trace": "voronec.quadratures",
    "Parameter": "voronec.scene",
    "Scene": "voronec.scene",
    "System": "voronec.system",
    "kinematics": "voronec.kinematics",
}

__all__ = [
    "Case",
    "Chart",
    "Claim",
    "ClosedForm",
    "Corrected",
    "Crossings",
    "DefinitionError",
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
    "Limit",
    "Measure",
    "Model",
    "Parameter",
    "Plane",
    "Poisson",
    "Precessions",
    "Quadratures",
    "Reduction",
    "Relation",
    "Scene",
    "Section",
    "Space",
    "Square",
    "System",
    "Table",
    "Trace",
    "Trajectory",
    "Verdict",
    "VoronecEquations",
    "VoronecError",
    "Witness",
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
    "graph",
    "integrate",
    "kinematics",
    "load",
    "multiplier_acceleration",
    "names",
    "precessions",
    "prove_equal",
    "prove_inequality",
    "reaction_forces",
    "search_integrals",
    "section",
    "time",
    "velocity",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'voronec' has no attribute '{name}'")
    module = import_module(_HOME[name])
    value = module if name == "kinematics" else getattr(module, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOME})
