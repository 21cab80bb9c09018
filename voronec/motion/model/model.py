"""What a scene needs of the equations: what is integrated, what follows, what is left out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

from voronec.algebra.typeset import html_table
from voronec.declaration.system import System
from voronec.equations.derivation import FirstOrderForm
from voronec.equations.program import Program
from voronec.motion.model.dependence import dependence
from voronec.motion.model.level import Level
from voronec.motion.model.special import level_of

if TYPE_CHECKING:
    import networkx as nx

__all__ = ["Candidate", "Model", "Role"]


@dataclass(frozen=True)
class Role:
    """What became of one variable, and why.

    ``kind`` is ``integrated``, ``quadrature``, ``constant``, ``zero``, ``integral`` (given by a
    first integral), ``read off`` (an angle from invariants), ``replaced`` (the level has other
    variables) or ``dropped``.
    """

    variable: str
    kind: str
    why: str


@dataclass(frozen=True)
class Candidate:
    """One level that was weighed, cut down to what the outputs need: its number of states, and
    operations and weight of its right-hand side."""

    level: str
    states: int
    operations: int
    weight: float
    chosen: bool = False


@dataclass(frozen=True, eq=False, repr=False)
class Model:
    """The equations that a scene needs.

    ``level`` says in which variables they stand; ``roles`` what became of each variable;
    ``candidates`` which levels were weighed.  ``form`` is what programs are made of, ``outputs``
    and ``integrals`` are expressions on it; ``frozen`` maps symbols that became parameters to what
    they are at the start, in coordinates and velocities, as ``start`` does for the states.
    ``full`` is the level that was chosen, ``cut`` what is left of it.  ``refuted`` names the
    declared integrals that are proved not to be constant.
    """

    cut: Level
    full: Level
    roles: tuple[Role, ...]
    candidates: tuple[Candidate, ...]
    frozen: Mapping[Any, Any] = field(default_factory=dict)
    refuted: tuple[str, ...] = ()

    def __repr__(self) -> str:
        states = ", ".join(map(str, self.states))
        return f"Model({self.system.name!r}, in {self.level}, states=({states}))"

    def _repr_html_(self) -> str:
        """For notebooks: what became of each variable, and why."""
        rows = [(role.variable, f"{role.kind}: {role.why}") for role in self.roles]
        return html_table(repr(self), rows)

    @property
    def system(self) -> System:
        """The system."""
        system: System = self.cut.system
        return system

    @property
    def level(self) -> str:
        """``coordinates``, maybe with relative angles, ``invariants``, or these with momenta."""
        return self.cut.name

    @property
    def form(self) -> FirstOrderForm:
        """What a ``Program`` is made of."""
        return self.cut.form

    @property
    def outputs(self) -> Mapping[str, Any]:
        """The wanted quantities by name, but those that are angles read off."""
        return self.cut.outputs

    @property
    def integrals(self) -> Mapping[str, Any]:
        """The first integrals that can be followed, by name."""
        return self.cut.integrals

    @property
    def eliminating_integrals(self) -> tuple[str, ...]:
        """The first integrals that stand in for equations."""
        return tuple(name for name in self.system.integrals if level_of(name) in self.frozen)

    @property
    def states(self) -> tuple[Any, ...]:
        """The variables that are integrated."""
        return self.cut.variables

    @property
    def start(self) -> dict[Any, Any]:
        """Each state in terms of coordinates and velocities of the equations."""
        return {x: self.cut.start[x] for x in self.states}

    @cached_property
    def program(self) -> Program:
        """Right-hand side, outputs and integrals as one straight-line program."""
        return Program.of(self.form, self.outputs)

    @property
    def graph(self) -> nx.DiGraph:
        """A networkx graph with an edge x -> y where the rate of y holds x, on the full level;
        nodes carry their ``kind``."""
        import networkx as nx

        graph = nx.DiGraph()
        kinds = {role.variable: role.kind for role in self.roles}
        for x in self.full.variables:
            graph.add_node(x, kind=kinds.get(str(x), "dropped"))
        for y, sources in dependence(self.full).items():
            graph.add_edges_from((x, y) for x in sources)
        return graph

    def as_dict(self) -> dict[str, Any]:
        """What JSON can hold of it."""
        return {
            "system": self.system.name,
            "level": self.level,
            "states": [str(x) for x in self.states],
            "variables": [
                {"name": r.variable, "kind": r.kind, "why": r.why} for r in self.roles
            ],
            "integrals": list(self.integrals),
            "refuted": list(self.refuted),
            "levels": [
                {
                    "name": c.level, "states": c.states, "operations": c.operations,
                    "weight": c.weight, "chosen": c.chosen,
                }
                for c in self.candidates
            ],
            "edges": [[str(a), str(b)] for a, b in self.graph.edges],
        }  # fmt: skip
