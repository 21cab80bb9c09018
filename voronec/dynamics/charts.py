"""Charts of stability over two quantities."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from voronec.algebra.symbols import plain_name
from voronec.declaration.reading import several
from voronec.declaration.system import System
from voronec.dynamics.families import curve_of
from voronec.dynamics.newton import solve
from voronec.dynamics.spectrum import Deflation, unstable_count
from voronec.dynamics.steady_equations import check_parameters
from voronec.errors import DefinitionError
from voronec.motion.request import number

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False, repr=False)
class SteadyChart:
    """How many eigenvalues lie right of the imaginary axis, ``unstable`` (rows of y, columns of x),
    at ``xs`` and ``ys``; -1 where there is no motion of the family."""

    system: System
    x: str
    y: str
    xs: np.ndarray
    ys: np.ndarray
    unstable: np.ndarray
    held: tuple[str, ...]

    def __repr__(self) -> str:
        rows, columns = self.unstable.shape
        return f"SteadyChart({self.system.name!r}, {columns} of {self.x} by {rows} of {self.y})"

    def plot(self) -> Figure:
        """The chart, a colour for each number."""
        from voronec.dynamics.pictures import chart_figure

        return chart_figure(self)


def chart(motion: Any, x: Any, y: Any, count: int, hold: Any) -> SteadyChart:
    """The chart about one motion, as ``SteadyMotion.chart`` has it: from the node that is nearest
    to it each node is reached from a neighbour."""
    (x_name, xs), (y_name, ys) = _axis(x, "x", count), _axis(y, "y", count)
    ends = ((name, end) for name, line in ((x_name, xs), (y_name, ys)) for end in line[[0, -1]])
    check_parameters(motion.system, *ends)
    given = curve_of(motion, x_name, several(hold, "hold", "name"), (y_name,))
    curve, begin = given.curve, given.begin
    equations, exprs = curve.equations, dict(curve.equations.held)
    counts = np.full((len(ys), len(xs)), -1)
    here = curve.value(begin), float(equations.targets[y_name])
    order = sorted(
        np.ndindex(len(ys), len(xs)),
        key=lambda node: (
            abs(ys[node[0]] - here[1]) / np.ptp(ys) + abs(xs[node[1]] - here[0]) / np.ptp(xs)
        ),
    )
    points: dict[tuple[int, ...], np.ndarray] = {}
    matrices: dict[tuple[int, ...], np.ndarray] = {}
    for i, j in order:
        near = [points[n] for n in ((i, j - 1), (i, j + 1), (i - 1, j), (i + 1, j)) if n in points]
        at = {x_name: float(xs[j]), y_name: float(ys[i])}
        node = equations.fix({name: (exprs[name], value) for name, value in at.items()})
        solution = solve(node.at, near[0] if near else begin, curve.units)
        if solution is not None:
            points[i, j], matrices[i, j] = solution, node.matrix(solution)
    deflation = Deflation.of_family([*matrices.values()])
    for place, matrix in matrices.items():
        counts[place] = unstable_count(deflation.eigenvalues(matrix))
    return SteadyChart(motion.system, x_name, y_name, xs, ys, counts, given.held)


def _axis(given: Any, which: str, count: int) -> tuple[str, np.ndarray]:
    if not isinstance(given, Sequence) or isinstance(given, str) or len(given) != 3:
        raise DefinitionError(f"{which}: give (name, low, high), such as ('speed', 0, 10)")
    low, high = (number(v, which) for v in given[1:])
    if not low < high or count < 2:
        raise DefinitionError(f"{which}: give low below high, and a count of two or more")
    return plain_name(given[0]), np.linspace(low, high, count)
