"""Voronec equations of nonholonomic systems, exact and without multipliers.

Public names load on first use, so that ``import voronec`` costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from voronec.accuracy.hard import HardCase as HardCase
    from voronec.algebra.signs import prove_inequality as prove_inequality
    from voronec.algebra.symbols import time as time
    from voronec.algebra.symbols import velocity as velocity
    from voronec.algebra.verdicts import Verdict as Verdict
    from voronec.algebra.verdicts import Witness as Witness
    from voronec.algebra.verdicts import prove_equal as prove_equal
    from voronec.audit.file_audit import PaperAudit as PaperAudit
    from voronec.audit.file_audit import audit_paper as audit_paper
    from voronec.audit.lessons.judgement import Judgement as Judgement
    from voronec.audit.lessons.judgement import judge as judge
    from voronec.audit.lessons.lesson import lesson as lesson
    from voronec.audit.lessons.methods import by_methods as by_methods
    from voronec.closed import ClosedForm as ClosedForm
    from voronec.closed.special.precessions import Precessions as Precessions
    from voronec.closed.special.precessions import precessions as precessions
    from voronec.declaration.bodies import Body as Body
    from voronec.declaration.catalogue import load as load
    from voronec.declaration.catalogue import names as names
    from voronec.declaration.charts import Chart as Chart
    from voronec.declaration.claims import Assertion as Assertion
    from voronec.declaration.claims import Case as Case
    from voronec.declaration.claims import Corrected as Corrected
    from voronec.declaration.claims import Equation as Equation
    from voronec.declaration.claims import Measure as Measure
    from voronec.declaration.claims import Poisson as Poisson
    from voronec.declaration.geometry import Fibration as Fibration
    from voronec.declaration.geometry import Frame as Frame
    from voronec.declaration.mechanics import from_mechanics as from_mechanics
    from voronec.declaration.quadratures import Plane as Plane
    from voronec.declaration.quadratures import Quadratures as Quadratures
    from voronec.declaration.quadratures import Space as Space
    from voronec.declaration.quadratures import Trace as Trace
    from voronec.declaration.relation import Limit as Limit
    from voronec.declaration.relation import Relation as Relation
    from voronec.declaration.relation import Square as Square
    from voronec.declaration.scene import Parameter as Parameter
    from voronec.declaration.scene import Scene as Scene
    from voronec.declaration.shapes import Shape as Shape
    from voronec.declaration.sketch import Sketch as Sketch
    from voronec.declaration.system import System as System
    from voronec.dynamics.bifurcation import BifurcationDiagram as BifurcationDiagram
    from voronec.dynamics.bifurcation import bifurcation_diagram as bifurcation_diagram
    from voronec.dynamics.charts import SteadyChart as SteadyChart
    from voronec.dynamics.exponents import Exponents as Exponents
    from voronec.dynamics.exponents import exponents as exponents
    from voronec.dynamics.families import SteadyFamily as SteadyFamily
    from voronec.dynamics.orbits import OrbitFamily as OrbitFamily
    from voronec.dynamics.orbits import PeriodicOrbit as PeriodicOrbit
    from voronec.dynamics.periodic import periodic as periodic
    from voronec.dynamics.rotation import rotation_numbers as rotation_numbers
    from voronec.dynamics.section_portrait import SectionPortrait as SectionPortrait
    from voronec.dynamics.section_portrait import section_portrait as section_portrait
    from voronec.dynamics.steady import SteadyMotion as SteadyMotion
    from voronec.dynamics.steady import SteadyMotions as SteadyMotions
    from voronec.dynamics.steady import stability as stability
    from voronec.dynamics.steady import steady as steady
    from voronec.equations.linearisation import Linearisation as Linearisation
    from voronec.equations.linearisation import linearise as linearise
    from voronec.equations.reduction import Reduction as Reduction
    from voronec.equations.reduction import descend as descend
    from voronec.equations.referee import multiplier_acceleration as multiplier_acceleration
    from voronec.equations.referee import reaction_forces as reaction_forces
    from voronec.equations.voronec_equations import VoronecEquations as VoronecEquations
    from voronec.equations.voronec_equations import derive as derive
    from voronec.errors import DefinitionError as DefinitionError
    from voronec.errors import EngineLimit as EngineLimit
    from voronec.errors import IntegrationError as IntegrationError
    from voronec.errors import VoronecError as VoronecError
    from voronec.motion import Crossings as Crossings
    from voronec.motion import Ensemble as Ensemble
    from voronec.motion import Event as Event
    from voronec.motion import PreparedProblem as PreparedProblem
    from voronec.motion import Sampled as Sampled
    from voronec.motion import Section as Section
    from voronec.motion import Table as Table
    from voronec.motion import Trajectory as Trajectory
    from voronec.motion import ensemble as ensemble
    from voronec.motion import integrate as integrate
    from voronec.motion import prepare as prepare
    from voronec.motion import section as section
    from voronec.motion.closed_form import closed_form as closed_form
    from voronec.motion.explanation import explain as explain
    from voronec.motion.formulation import Model as Model
    from voronec.motion.storage import open as open
    from voronec.proof.check import check_catalogue as check_catalogue
    from voronec.proof.check import check_relation as check_relation
    from voronec.proof.check import graph as graph
    from voronec.proof.claims import Claim as Claim
    from voronec.proof.claims import check_claims as check_claims
    from voronec.proof.comparison import compare as compare
    from voronec.proof.measures import divergence as divergence
    from voronec.proof.search import DensitySearch as DensitySearch
    from voronec.proof.search import FoundIntegral as FoundIntegral
    from voronec.proof.search import GaugeSearch as GaugeSearch
    from voronec.proof.search import IntegralSearch as IntegralSearch
    from voronec.proof.search import RationalBound as RationalBound
    from voronec.proof.search import SymmetrySearch as SymmetrySearch
    from voronec.proof.search import exclude_rational_integrals as exclude_rational_integrals
    from voronec.proof.search import search_gauge_momenta as search_gauge_momenta
    from voronec.proof.search import search_integrals as search_integrals
    from voronec.proof.search import search_measures as search_measures
    from voronec.proof.search import search_reducing_multipliers as search_reducing_multipliers
    from voronec.proof.search import search_symmetries as search_symmetries
    from voronec.sweeps import Draws as Draws
    from voronec.sweeps import Sweep as Sweep
    from voronec.sweeps import sweep as sweep

__version__ = "1.0.0"

_HOME = {
    name: f"voronec.{module}"
    for module, names in {
        "accuracy.hard": "HardCase",
        "algebra.signs": "prove_inequality",
        "algebra.symbols": "time velocity",
        "algebra.verdicts": "prove_equal Verdict Witness",
        "audit.file_audit": "audit_paper PaperAudit",
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
        "dynamics.bifurcation": "BifurcationDiagram bifurcation_diagram",
        "dynamics.charts": "SteadyChart",
        "dynamics.exponents": "Exponents exponents",
        "dynamics.families": "SteadyFamily",
        "dynamics.orbits": "OrbitFamily PeriodicOrbit",
        "dynamics.periodic": "periodic",
        "dynamics.rotation": "rotation_numbers",
        "dynamics.section_portrait": "SectionPortrait section_portrait",
        "dynamics.steady": "stability steady SteadyMotion SteadyMotions",
        "equations.linearisation": "Linearisation linearise",
        "equations.reduction": "descend Reduction",
        "equations.referee": "multiplier_acceleration reaction_forces",
        "equations.voronec_equations": "derive VoronecEquations",
        "errors": "DefinitionError EngineLimit IntegrationError VoronecError",
        "kinematics": "kinematics",
        "motion": "Crossings Ensemble ensemble Event integrate prepare PreparedProblem Section "
        "Sampled section Table Trajectory",
        "motion.closed_form": "closed_form",
        "motion.explanation": "explain",
        "motion.formulation": "Model",
        "motion.storage": "open",
        "proof.check": "check_catalogue check_relation graph",
        "proof.claims": "check_claims Claim",
        "proof.comparison": "compare",
        "proof.measures": "divergence",
        "proof.search": "DensitySearch exclude_rational_integrals FoundIntegral GaugeSearch "
        "IntegralSearch RationalBound search_gauge_momenta search_integrals search_measures "
        "search_reducing_multipliers search_symmetries SymmetrySearch",
        "sweeps": "Draws Sweep sweep",
    }.items()
    for name in names.split()
}
"""Where the names are that load on first use."""

__all__ = sorted(_HOME)


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
