"""All velocities at the start, where the declared ones need not be a frame.

    A w + a = 0,    F w + f = v,    w_k = what is given of it

is solved for w, in doubles and, by refinement, in any precision.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np

from voronec.algebra.symbols import plain_name, velocity
from voronec.errors import DefinitionError
from voronec.motion.exact_values import exact_number
from voronec.motion.initial_state import coordinates_of, numbers_of
from voronec.motion.request import StartData
from voronec.motion.singular_directions import POLE, blind_directions, open_beyond
from voronec.motion.split_models import SplitGround
from voronec.motion.velocity_conditions import CONSISTENT
from voronec.motion.vocabulary import Vocabulary

__all__ = ["WideStart"]

DETERMINED = 1e-9
"""Conditions whose least singular value is below this part of the largest leave w open."""
ROUNDS = 40
"""Each round of refinement gains the digits of a double, where conditions are not too bad."""


@dataclass(frozen=True)
class WideStart:
    """The start of a motion on the coordinates and all their velocities.

    ``rows`` are positions of the linear conditions that hold, ``targets`` the names of the
    velocities in them whose values are given, after the constraints and relations.
    """

    vocabulary: Vocabulary
    ground: SplitGround
    given: StartData
    wide: np.ndarray
    targets: tuple[str, ...]

    @classmethod
    def of(
        cls, vocabulary: Vocabulary, ground: SplitGround, given: StartData, project: bool
    ) -> WideStart:
        """Solve what is given; ``DefinitionError`` where it determines nothing, or contradicts."""
        old, new = (
            numbers_of(vocabulary, part, ground.constants)
            for part in (given.scene_initial, given.initial)
        )
        q, _ = coordinates_of(vocabulary, {**old, **new}, ground.constants, ground.time, project)
        system = ground.home.system
        names = {plain_name(x) for x in system.coordinates}
        later = {k: x for k, x in new.items() if k not in names}
        earlier = {k: x for k, x in old.items() if k not in names and k not in later}
        own = {plain_name(v): 0.0 for v in system.velocities}
        earlier = {**{k: x for k, x in own.items() if k not in later}, **earlier}
        found = _Conditions.at(ground, q)
        w = found.solve(later, earlier)
        wide = np.concatenate([q, w])
        all_given = {**old, **later}
        held = tuple(k for k in all_given if k not in names and found.holds(k, all_given[k], w))
        missed = [k for k in later if k not in held]
        if missed and not project and found.blind.shape[1] and missed[0] in own:
            raise DefinitionError(
                f"system '{system.name}': no velocities of the coordinates have '{missed[0]}' = "
                f"{later[missed[0]]:.12g}, since these are singular at the initial point; start "
                "beside it"
            )
        if missed and not project:
            raise DefinitionError(
                f"system '{system.name}': the initial velocities are off the constraints: "
                f"'{missed[0]}' = {later[missed[0]]:.12g} (residual "
                f"{found.residual(missed[0], later[missed[0]], w):.3g}); correct '{missed[0]}', "
                "leave it out, or give project=True"
            )
        spare = tuple(k for k in own if k not in held and found.holds(k, 0.0, w))
        return cls(vocabulary, ground, given, wide, (*held, *spare))

    @property
    def home(self) -> np.ndarray:
        """Coordinates and the declared velocities v, which are functions of w everywhere."""
        count = len(self.ground.home.definition.coordinates)
        q, w = self.wide[:count], self.wide[count:]
        found = _Conditions.at(self.ground, q)
        return np.concatenate([q, found.frame[:, :-1] @ w + found.frame[:, -1]])

    def exact(self, bits: int) -> tuple[np.ndarray, Mapping[str, Any]]:
        """The same, and the parameters by name, as mpmath's numbers."""
        with mpmath.workprec(bits):
            system, ground = self.ground.home.system, self.ground
            constants = {name: mpmath.mpf(x) for name, x in ground.constants.items()}
            for parameter in system.parameters:
                value = self.given.parameters.get(parameter.name, parameter.value)
                if value is not None:
                    constants[parameter.name] = exact_number(value, {}, bits)
            known = {self.vocabulary.symbols[name]: x for name, x in constants.items()}
            given = {
                name: exact_number(value, known, bits)
                for name, value in {**self.given.scene_initial, **self.given.initial}.items()
            }
            names = [plain_name(x) for x in system.coordinates]
            q = [given.get(name, mpmath.mpf(0)) for name in names]
            w = [mpmath.mpf(float(x)) for x in self.wide[len(names) :]]
            found = _Conditions.at(ground, np.array(q, dtype=object), constants)
            return np.array([*q, *found.refine(w, self.targets, given)], dtype=object), constants


@dataclass(frozen=True)
class _Conditions:
    """The conditions at one point: rows of constraints and relations, and of the frame, each with
    its offset; names of velocities w and v.  ``blind`` (N, k) are directions that are no motion."""

    system: Any
    conditions: np.ndarray
    frame: np.ndarray
    dots: list[str]
    own: list[str]
    blind: np.ndarray

    @classmethod
    def at(cls, ground: SplitGround, q: np.ndarray, constants: Any = None) -> _Conditions:
        """The conditions at coordinates q, of doubles or mpmath's numbers."""
        d, system = ground.home.definition, ground.home.system
        rest = (
            np.array([q[0] * 0] * len(d.dots), dtype=q.dtype) if len(q) else np.zeros(len(d.dots))
        )
        wide = np.concatenate([q, rest])
        conditions, frame = ground.rows(ground.time, wide, constants)
        if not all(mpmath.isfinite(x) for x in (*conditions.ravel(), *frame.ravel())):
            raise DefinitionError(
                f"system '{system.name}': the constraints are not defined at the initial point, "
                "where no motion exists in these coordinates; start elsewhere"
            )
        dots = system.directions if d.group is not None else map(velocity, system.coordinates)
        names = [plain_name(x) for x in dots]
        own = [plain_name(v) for v in system.velocities]
        return cls(system, conditions, frame, names, own, blind_directions(ground, wide))

    def row(self, name: str) -> np.ndarray:
        """The row of a velocity by name, with its offset."""
        if name in self.own:
            return np.asarray(self.frame[self.own.index(name)])
        if name not in self.dots:
            raise DefinitionError(
                f"system '{self.system.name}': '{name}' cannot be given where the frame is "
                "singular; give velocities of its group"
            )
        found = np.zeros(len(self.dots) + 1)
        found[self.dots.index(name)] = 1.0
        return found

    def solve(self, given: Mapping[str, float], otherwise: Mapping[str, float]) -> np.ndarray:
        """The w that meet the constraints and what is given, and, as far as these leave it open,
        the rest."""
        left, right = self._pose(self.conditions, given)
        further, wanted = self._pose(self.conditions[:0], otherwise)
        ways = open_beyond(np.vstack([left, further]), self.blind)
        if np.abs(ways).max(initial=0.0) > POLE:
            free = self.dots[int(np.argmax(np.abs(ways).max(axis=1)))]
            raise DefinitionError(
                f"system '{self.system.name}': the velocities {', '.join(self.own)} are no frame "
                "at the initial point, and do not determine the motion; give velocities of "
                f"coordinates, such as '{free}'"
            )
        found = np.linalg.pinv(left, DETERMINED) @ right
        _, sizes, basis = np.linalg.svd(left)
        free_ways = basis[int((sizes > DETERMINED * sizes.max(initial=0.0)).sum()) :].T
        rest = np.linalg.pinv(further @ free_ways, DETERMINED) @ (wanted - further @ found)
        return np.asarray(found + free_ways @ rest)

    def _pose(self, first: np.ndarray, given: Mapping[str, float]) -> tuple[np.ndarray, np.ndarray]:
        """Rows of unit length and right sides: left w = right."""
        rows = np.vstack([first, *(self.row(k)[None, :] for k in given)]).astype(float)
        right = np.concatenate([np.zeros(len(first)), [*given.values()]]) - rows[:, -1]
        sizes = np.linalg.norm(rows[:, :-1], axis=1)
        sizes[sizes == 0] = 1.0
        return rows[:, :-1] / sizes[:, None], right / sizes

    def residual(self, name: str, value: float, w: np.ndarray) -> float:
        """How far a given velocity is from that of w."""
        row = self.row(name)
        return float(abs(row[:-1].astype(float) @ w + float(row[-1]) - value))

    def holds(self, name: str, value: float, w: np.ndarray) -> bool:
        """Whether w has the velocity given."""
        return self.residual(name, value, w) <= CONSISTENT * (1.0 + np.abs(w).max(initial=0.0))

    def refine(self, w: list[Any], names: tuple[str, ...], given: Mapping[str, Any]) -> list[Any]:
        """w moved until the conditions hold to the last digit."""
        rows = np.vstack([self.conditions, *(self.row(k)[None, :] for k in names)])
        wanted = [mpmath.mpf(0)] * len(self.conditions)
        wanted += [given.get(k, mpmath.mpf(0)) for k in names]
        inverse = np.linalg.pinv(rows[:, :-1].astype(float))
        found = np.array(w, dtype=object)
        for _ in range(ROUNDS):
            gap = np.array(wanted, dtype=object) - rows[:, -1] - rows[:, :-1].dot(found)
            if max(map(abs, gap), default=0) <= mpmath.eps * 8 * (1 + max(map(abs, found))):
                break
            found = found + inverse.dot(gap)
        return list(found)
