"""The draft of a system file from a paper: its Lagrangian, its constraints, its definitions."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any

import sympy as sp

from voronec.algebra.symbols import velocity
from voronec.audit.latex.document import Document
from voronec.audit.latex.nodes import Dot, Name, walk
from voronec.audit.latex.tokens import FUNCTIONS
from voronec.audit.letters import names_in
from voronec.audit.meaning import SENSELESS, evaluate
from voronec.audit.printed_claims import PrintedClaim, claims_of, has_primes
from voronec.audit.study import Motion, Study, key_of
from voronec.errors import DefinitionError

_BOUND = re.compile(
    r"constrain|slip|roll|nonholonomic|condition|knife|blade|skid|edge|vanish", re.IGNORECASE
)
_NO_LETTERS = ("const", "t", "\\pi", "e", "d")


def draft_system(document: Document, name: str) -> str:
    """A TOML text to be looked over, with what the paper defines in comments.

    Raises ``DefinitionError`` where the paper has neither a Lagrangian nor a kinetic energy.
    """
    study = Study({}, primes=has_primes(document))
    return _Draft(document, claims_of(document, study)).text(name)


@dataclass(frozen=True)
class _Draft:
    document: Document
    claims: list[PrintedClaim]

    @cached_property
    def study(self) -> Study:
        """Every letter is a symbol of its own, those with dots are coordinates."""
        names: dict[str, Any] = {}
        moving: dict[Any, Any] = {}
        for claim in self.claims:
            for name in names_in(claim.chain) if claim.chain else ():
                if not name.sup and name.head not in {*_NO_LETTERS, *FUNCTIONS}:
                    names.setdefault(key_of(name), sp.Symbol(_plain(key_of(name))))
            for node in walk(claim.chain) if claim.chain else ():
                if isinstance(node, Dot) and isinstance(node.body, Name):
                    symbol = sp.Symbol(_plain(key_of(node.body)))
                    moving[velocity(symbol)] = velocity(symbol)
                    moving[velocity(velocity(symbol))] = velocity(velocity(symbol))
        spelled = {re.sub(r"_(.*)", r"_{\1}", key): value for key, value in names.items()}
        return Study({**spelled, "\\pi": sp.pi}, motion=Motion(constrained=moving))

    def _equations(self) -> Iterator[tuple[PrintedClaim, list[Any]]]:
        for claim in self.claims:
            if claim.chain is None or {*claim.chain.relations} != {"="}:
                continue
            try:
                values = [evaluate(part, self.study) for part in claim.chain.parts]
            except SENSELESS:
                continue
            if all(isinstance(value, sp.Expr) for value in values):
                yield claim, values

    def _definitions(self) -> dict[Any, Any]:
        """What stands alone on a left side, and the first thing that it is equal to."""
        definitions: dict[Any, Any] = {}
        for _, (left, right, *_) in self._equations():
            number, letters = left.as_coeff_Mul()
            if letters.is_Symbol and not right.has(letters):
                definitions.setdefault(letters, right / number)
        return definitions

    def _lagrangian(self) -> Any:
        known = {symbol.name: value for symbol, value in self._definitions().items()}

        def one(letters: str) -> Any:
            return next((known[x] for x in letters.split() if x in known), None)

        value, kinetic, potential = one("L mathcalL"), one("T mathcalT K"), one("V U Pi")
        if value is None and kinetic is None:
            raise DefinitionError(
                "the paper has no formula 'L = ...' or 'T = ...' that is read; write a system file "
                "by hand, from 'voronec new NAME --toml'"
            )
        forces = any(
            re.search("force function", c.display.before, re.IGNORECASE) for c in self.claims
        )
        if value is None:
            value = kinetic + (potential or 0) * (1 if forces else -1)
        for _ in range(3):
            value = value.xreplace(
                {s: v for s, v in self._definitions().items() if s.name in "TVUK"}
            )
        return value

    def _constraints(self, coordinates: list[Any]) -> list[tuple[Any, Any]]:
        dots = [velocity(q) for q in coordinates]
        constraints = []
        for claim, values in self._equations():
            gap = sp.expand(values[0] - values[-1])
            mine = [dot for dot in dots if gap.has(dot)]
            others = gap.free_symbols & {*self.study.motion.constrained} - {*dots}
            linear = mine and not any(sp.diff(gap, dot).has(*dots) for dot in mine)
            said = _BOUND.search(claim.display.before) and len(values) == 2
            velocity_alone = claim.chain is not None and isinstance(claim.chain.parts[0], Name)
            if linear and not others and said and not velocity_alone:
                constraints.append((values[0], values[1]))
        return constraints

    def text(self, name: str) -> str:
        """The file."""
        lagrangian = self._lagrangian()
        dots = {velocity(s): s for s in self.study.table.values() if isinstance(s, sp.Symbol)}
        coordinates = sorted({dots[d] for d in lagrangian.free_symbols & dots.keys()}, key=str)
        constraints = self._constraints(coordinates)
        moving = {*coordinates, *map(velocity, coordinates)}
        held = lagrangian.free_symbols.union(
            *(side.free_symbols for pair in constraints for side in pair)
        )
        parameters = sorted((held - moving) - {sp.Symbol("t")}, key=str)
        fibre = _fibre(constraints, coordinates)
        lines = [
            f"# A draft from '{self.document.source.files[0][0]}': look it over, line by line."
        ]
        lines += [f"# the paper defines {s} = {v}" for s, v in self._definitions().items()]
        lines += [f'name = "{name}"', f'lagrangian = "{lagrangian}"']
        lines += ["constraints = [" + ", ".join(f'"{a} = {b}"' for a, b in constraints) + "]"]
        lines += ["fibre = [" + ", ".join(f'"{q}"' for q in fibre) + "]", "", "[coordinates]"]
        lines += [f'{q} = "coordinate"' for q in coordinates] + ["", "[parameters]"]
        return "\n".join([*lines, *(f"{p} = 1" for p in parameters), ""])


def _fibre(constraints: list[tuple[Any, Any]], coordinates: list[Any]) -> tuple[Any, ...]:
    """Coordinates for whose velocities the constraints can be solved, the last ones first."""
    dots, gaps = [velocity(q) for q in coordinates], [a - b for a, b in constraints]
    table = sp.Matrix([[sp.diff(gap, dot) for dot in dots] for gap in gaps])
    for chosen in combinations(reversed(range(len(dots))), len(gaps)):
        if not gaps or sp.expand(table[:, list(chosen)].det()) != 0:
            return tuple(coordinates[i] for i in sorted(chosen))
    return ()


def _plain(key: str) -> str:
    """A letter as a system file spells it."""
    return re.sub(
        r"[^A-Za-z0-9_]", "", key.replace("\\var", "").replace(",", "_").replace("'", "_prime")
    )
