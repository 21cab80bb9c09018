"""Figures: what is drawn lies where the mathematics says, and labels are set as formulas."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import sympy as sp
from matplotlib._pylab_helpers import Gcf

import voronec as vo
from voronec.declaration.figure_style import INK, PALE
from voronec.motion.pictures.run_pictures import drawing, pictures, plot_trajectory, quantity_label

pytestmark = pytest.mark.slow

theta1, omega, energy = sp.symbols("theta1 omega E")
PENDULUM = vo.System(
    name="pendulum-to-draw",
    fibration=vo.Fibration(base=(theta1,)),
    frame=vo.Frame.quasi({omega: vo.velocity(theta1)}),
    lagrangian=vo.velocity(theta1) ** 2 / 2 + sp.cos(theta1),
    integrals={"energy": omega**2 / 2 - sp.cos(theta1)},
)
GRID = np.linspace(0.0, 10.0, 201)
NAMES = ("theta1", omega, vo.velocity(theta1), "energy", sp.cos(theta1) ** 2, "omega")


@pytest.fixture(scope="module")
def motion() -> Any:
    return vo.integrate(PENDULUM, times=GRID, initial={theta1: 1}, outputs=NAMES, method="scipy")


def test_labels_are_formulas(motion: Any) -> None:
    assert quantity_label(motion, "theta1") == r"$\theta_{1}$"
    assert quantity_label(motion, "theta1dot") == r"$\dot{\theta_{1}}$"
    assert quantity_label(motion, "omega") == r"$\omega$"
    assert quantity_label(motion, "cos(theta1)**2") == r"$\cos^{2}{\left(\theta_{1} \right)}$"
    assert quantity_label(motion, "energy") == "energy"


def test_one_panel_an_output_on_one_time_axis(motion: Any) -> None:
    open_before = {*Gcf.figs}  # other tests may have windows
    figure = plot_trajectory(motion, title="A pendulum")
    panels = [p for p in figure.axes if p.get_visible()]
    assert len(panels) == len(motion.outputs) == 5
    for panel, name in zip(panels, motion.outputs, strict=True):
        assert np.array_equal(panel.lines[0].get_xydata(), np.column_stack([GRID, motion[name]]))
        assert panel.get_ylabel() == quantity_label(motion, name)
        assert panel.get_xlim() == (0, 10)
    # a conserved quantity is a level line: rounding is not blown up to fill the panel
    low, high = panels[motion.outputs.index("energy")].get_ylim()
    assert high - low > 0.1
    assert {*Gcf.figs} == open_before  # no window, no global state


def test_one_name_stands_for_a_tuple_of_it(motion: Any) -> None:
    visible = [panel for panel in motion.plot("theta1").axes if panel.get_visible()]
    assert [panel.get_ylabel() for panel in visible] == [quantity_label(motion, "theta1")]
    with pytest.raises(vo.DefinitionError, match="holds no 'zz'"):
        motion.plot("zz")
    with pytest.raises(vo.DefinitionError, match="names = 5 is not a tuple"):
        motion.plot(5)


def test_many_panels_stand_in_two_columns(motion: Any) -> None:
    figure = plot_trajectory(motion, ["theta1", "omega"] * 3 + ["energy"])
    columns = {round(p.get_position().x0, 1) for p in figure.axes if p.get_visible()}
    assert len(columns) == 2 and sum(p.get_visible() for p in figure.axes) == 7
    with pytest.raises(vo.DefinitionError, match="nothing to plot"):
        plot_trajectory(motion, [])


# -- a run's own drawing: the traces on spheres ------------------------------------------------

BALL = vo.load("demchenko")
SPAN = 12.0


def drawn(count: int) -> list[Any]:
    """The spheres of a run with so many times."""
    run = vo.integrate(BALL, scene="default", times=np.linspace(0.0, SPAN, count), method="scipy")
    return list(drawing(run).axes)


def curve(axis: Any) -> np.ndarray:
    """Points along the whole curve, in front and behind."""
    from matplotlib.colors import to_hex
    from matplotlib.patches import PathPatch
    from matplotlib.transforms import Affine2D

    own = [p for p in axis.patches if isinstance(p, PathPatch)]
    paths = [p.get_path() for p in own if to_hex(p.get_edgecolor()) in (INK, PALE)]
    large = Affine2D().scale(1e5)
    return np.vstack([q for p in paths for q in p.to_polygons(large, closed_only=False)]) / 1e5


def dots(axis: Any) -> int:
    """How many points of the curve are marked, its start left out."""
    marked = [line for line in axis.lines if line.get_marker() == "o"]
    return sum(len(m.get_xydata()) for m in marked if m.get_color() in (INK, PALE))


def apart(one: np.ndarray, other: np.ndarray) -> float:
    from scipy.spatial import cKDTree

    return float(max(cKDTree(one).query(other)[0].max(), cKDTree(other).query(one)[0].max()))


@pytest.fixture(scope="module")
def fine() -> list[Any]:
    return drawn(1201)


def test_the_traces_of_a_run_are_drawn_without_marks(fine: list[Any]) -> None:
    assert [a.get_title() for a in fine] == ["on the ball", "on the sphere"]
    for axis in fine:
        assert dots(axis) == 0
        assert np.hypot(*curve(axis).T).max() < 1 + 1e-3


def test_coarser_times_that_tell_the_curve_give_the_same_curve(fine: list[Any]) -> None:
    for one, other in zip(fine, drawn(61), strict=True):
        assert dots(other) == 0
        assert apart(curve(one), curve(other)) < 0.02


def test_times_too_coarse_for_a_curve_show_their_points() -> None:
    for axis in drawn(16):
        assert dots(axis) == 16


def test_a_drawing_shows_what_the_run_holds() -> None:
    some = vo.integrate(BALL, times=(0.0, 1.0), outputs=("u1", "v1"), method="scipy")
    assert [a.get_title() for a in drawing(some).axes] == ["on the sphere"]
    none = vo.integrate(BALL, times=(0.0, 1.0), outputs=("u", "u1"), method="scipy")
    with pytest.raises(vo.DefinitionError):
        drawing(none)


@pytest.mark.parametrize("output", [1 / sp.Symbol("x"), sp.log(sp.Symbol("x"))])
def test_an_output_with_a_pole_on_the_way_is_drawn_where_it_is_finite(output: Any) -> None:
    x = sp.Symbol("x")
    free = vo.System(
        name="free", fibration=vo.Fibration((x,)), lagrangian=vo.velocity(x) ** 2 / 2
    )  # fmt: skip
    run = vo.integrate(
        free, times=[0, 0.5, 1, 2], initial={x: 1, vo.velocity(x): -1}, outputs=(output,)
    )
    (panel,) = plot_trajectory(run).axes
    assert np.isfinite(panel.get_ylim()).all()


@pytest.mark.parametrize("across", [0.0, 0.01, 0.4, 1.0, 1e3])
def test_the_numbers_at_a_path_stand_apart(across: float) -> None:
    """A path that is long and narrow, or a line, has room for the numbers of both axes."""
    x, y = sp.symbols("x y")
    moved = vo.System(
        name="two-free-particles",
        fibration=vo.Fibration(base=(x, y)),
        lagrangian=(vo.velocity(x) ** 2 + vo.velocity(y) ** 2) / 2,
    )
    start = {vo.velocity(x): across, vo.velocity(y): 1}
    run = vo.integrate(moved, initial=start, times=np.linspace(0, 10, 11))
    figure = pictures(run)["path"]
    (panel,) = figure.axes
    for axis, low, high in ((panel.xaxis, "x0", "x1"), (panel.yaxis, "y0", "y1")):
        boxes = [label.get_window_extent() for label in axis.get_ticklabels()]
        shown = [b for b, at in zip(boxes, axis.get_ticklocs(), strict=True)
                 if axis.get_view_interval()[0] <= at <= axis.get_view_interval()[1]]  # fmt: skip
        assert len(shown) >= 2
        gaps = [getattr(b, low) - getattr(a, high) for a, b in pairwise(shown)]
        assert min(gaps) > 2.0


def test_numbers_at_ticks_are_text_and_powers_of_ten_formulas() -> None:
    x = sp.Symbol("x")
    free = vo.System(
        name="free", fibration=vo.Fibration(base=(x,)), lagrangian=vo.velocity(x) ** 2 / 2
    )
    run = vo.integrate(free, initial={vo.velocity(x): "1e-7"}, times=[0, 1, 2])
    panel = pictures(run)["plot"].axes[0]
    assert not [t for t in panel.yaxis.get_ticklabels() if "$" in t.get_text()]
    assert "10^{" in panel.yaxis.get_offset_text().get_text()
