"""A numerically hard case: a motion of a system of the catalogue, and what is hard about it;
its problem in many digits."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from voronec.accuracy.problem import (
    ProblemFormulation,
    ReferenceProblem,
    formulation,
    precise_number,
)
from voronec.algebra.arguments import COUNT, SEQUENCE, TEXT, require
from voronec.algebra.symbols import plain_name
from voronec.declaration.scene import Scene
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError, quote
from voronec.motion.methods import METHODS
from voronec.motion.request import Namespace

ARITHMETICS = {"quadruple": 33, "extended": 19}
"""What a reference is computed in, with its decimal digits."""


@dataclass(frozen=True)
class HardCase:
    """A motion on which methods are tried, with outputs that are compared with a reference.

    name
        lower-case words joined by hyphens.
    system
        the name of a system of the catalogue; nothing is imported until the case is run.
    scene
        initial data (coordinates and velocities of the equations only), parameters, span and
        outputs; every output is compared, and the caption says what is hard.
    points
        how many instants of the span are compared, the start included.
    formulation
        where the reference is computed: ``coordinates``, ``invariants`` (free of poles), or ``""``
        where no motion starts and only a refusal is right.
    period
        a state of the closed system that vanishes at the start and after every period: the
        reference then follows one period and counts the rest; ``""`` where there is none.
    arithmetic
        of the reference, ``quadruple`` (33 digits) or ``extended`` (19 digits, for long spans).
    methods
        which of heyoka, scipy, numba, c, lsoda and flint are worth waiting for; the closed form is
        tried wherever the system declares one.
    chaotic
        whether errors grow exponentially; said in the table.
    """

    name: str
    system: str
    scene: Scene
    points: int = 41
    formulation: str = "coordinates"
    period: str = ""
    arithmetic: str = "quadruple"
    methods: tuple[str, ...] = ("heyoka", "scipy", "lsoda")
    chaotic: bool = False

    def __post_init__(self) -> None:
        for name in ("name", "system", "formulation", "period", "arithmetic"):
            require("hard case", name, getattr(self, name), TEXT)
        require(f"hard case '{self.name}'", "points", self.points, COUNT)
        require(f"hard case '{self.name}'", "methods", self.methods, SEQUENCE)
        if not isinstance(self.scene, Scene):
            raise self._wrong(f"scene = {quote(self.scene)}", "a voronec.Scene")
        if self.formulation not in ("coordinates", "invariants", ""):
            raise self._wrong(
                f"formulation = '{self.formulation}'", "coordinates, invariants or ''"
            )
        if self.arithmetic not in ARITHMETICS:
            raise self._wrong(f"arithmetic = '{self.arithmetic}'", " or ".join(ARITHMETICS))
        if unknown := [m for m in self.methods if m not in [*METHODS]]:
            raise self._wrong(f"method '{quote(unknown[0])}'", ", ".join(METHODS))
        if self.points < 2:
            raise self._wrong(f"points = {self.points}", "2 or more")
        if not self.scene.outputs:
            raise self._wrong("no outputs", "a scene with outputs=(...)")

    def _wrong(self, what: str, mend: str) -> DefinitionError:
        return DefinitionError(f"hard case '{self.name}': {what}; give {mend}")

    @property
    def hard(self) -> str:
        """What is hard, in a sentence."""
        return self.scene.caption

    @property
    def grid(self) -> np.ndarray:
        """The instants at which outputs are compared, shape (points,)."""
        start, end = self.scene.times
        return np.linspace(float(start), float(end), self.points)

    @property
    def digest(self) -> str:
        """A digest of all that the reference depends on."""
        scene = self.scene
        told: list[Any] = [self.system, self.points, self.formulation, self.period, self.arithmetic]
        told += [*map(str, scene.times), *map(str, scene.outputs)]
        for mapping in (scene.initial, scene.parameters):
            told.append(sorted((str(k), str(v)) for k, v in mapping.items()))
        return hashlib.sha256(repr(told).encode()).hexdigest()[:16]


def case_formulation(
    case: HardCase, equations: VoronecEquations, raw: bool = False
) -> ProblemFormulation:
    """The problem of a case in its formulation, on coordinates by the cheapest form of the
    equations; ``raw`` takes the unsimplified form, an independent program."""
    problem, high = _problem(case, equations), case.formulation == "coordinates"
    at = formulation(problem, case.formulation, equations.raw.form if raw and high else None)
    state = {str(s) for s in at.program.state}
    for key in problem.initial:
        if high and key not in state:
            raise DefinitionError(
                f"hard case '{case.name}': '{key}' is neither a coordinate nor a velocity of the "
                "equations; give those"
            )
    known = {p.name for p in equations.system.parameters if p.value is not None}
    known |= {*map(_name, case.scene.parameters)}
    missing = [str(p) for p in at.program.parameters if str(p) not in known]
    if {*missing} & {str(s) for s in at.program.derivative.symbols}:
        raise DefinitionError(f"hard case '{case.name}': no value for {', '.join(missing)}")
    return at


def _problem(case: HardCase, equations: VoronecEquations) -> ReferenceProblem:
    """What is wanted of a case, from numbers of many digits; parameters without a value are 0."""
    scene = case.scene
    constants = {p.name: p.value or 0 for p in equations.system.parameters}
    return ReferenceProblem(
        equations,
        case.name,
        dict(map(Namespace.of(equations).read_condition, scene.outputs)),
        case.grid,
        {n: precise_number(x) for n, x in (constants | _values_by_name(scene.parameters)).items()},
        {n: precise_number(x) for n, x in _values_by_name(scene.initial).items()},
    )


def _values_by_name(values: Mapping[Any, Any]) -> dict[str, Any]:
    return {_name(key): value for key, value in values.items()}


def _name(key: Any) -> str:
    return key if isinstance(key, str) else plain_name(key)
