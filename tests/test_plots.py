"""Figures: what is drawn lies where the mathematics says, and labels are set as formulas."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sympy as sp
from matplotlib._pylab_helpers import Gcf

import voronec as vo
from voronec.report.plots import plot_sphere_traces, plot_trajectory, quantity_label

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


def drawn(axis: Any, color: str) -> np.ndarray:
    """All points of the lines of one colour, gaps left out."""
    from matplotlib.colors import to_hex

    lines = [line.get_xydata() for line in axis.lines if to_hex(line.get_color()) == color]
    points = np.vstack(lines)
    return points[np.isfinite(points).all(axis=1)]


def test_labels_are_formulas(motion: Any) -> None:
    assert quantity_label(motion, "theta1") == r"$\theta_{1}$"
    assert quantity_label(motion, "theta1dot") == r"$\dot{\theta_{1}}$"
    assert quantity_label(motion, "omega") == r"$\omega$"
    assert quantity_label(motion, "cos(theta1)**2") == r"$\cos^{2}{\left(\theta_{1} \right)}$"
    assert quantity_label(motion, "energy") == "energy"


def test_one_panel_an_output_on_one_time_axis(motion: Any) -> None:
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
    assert not Gcf.figs  # no window, no global state


def test_many_panels_stand_in_two_columns(motion: Any) -> None:
    figure = plot_trajectory(motion, ["theta1", "omega"] * 3 + ["energy"])
    columns = {round(p.get_position().x0, 1) for p in figure.axes if p.get_visible()}
    assert len(columns) == 2 and sum(p.get_visible() for p in figure.axes) == 7
    with pytest.raises(vo.DefinitionError, match="nothing to plot"):
        plot_trajectory(motion, [])


def test_a_trace_runs_between_its_parallels_and_splits_at_the_outline() -> None:
    v = np.linspace(0, 6 * np.pi, 400)
    u = 1.0 + 0.3 * np.cos(3.7 * v)
    figure = plot_sphere_traces({"ball": (u, v)}, height=0.4, longitudes=[0.0])
    (axis,) = figure.axes
    front, back = drawn(axis, "#1b3a5c"), drawn(axis, "#b4c0cd")
    for points in (front, back):
        assert (np.hypot(*points.T) <= 1 + 1e-12).all() and len(points) > 100
    # undo the projection: on the near side the depth is positive
    cos, sin = np.cos(0.4), np.sin(0.4)
    for points, side in ((front, 1), (back, -1)):
        depth = side * np.sqrt(1 - np.minimum(1, (points**2).sum(axis=1)))
        colatitude = np.arccos(points[:, 1] * cos + depth * sin)
        assert colatitude.min() > 0.7 - 1e-3 and colatitude.max() < 1.3 + 1e-3
    limits = [line for line in axis.lines if line.get_linestyle() == "--"]
    assert len(limits) == 4  # two parallels, each with a near and a far part


def test_the_start_is_marked_filled_in_front_and_open_behind() -> None:
    u, v = np.full(50, 1.2), np.linspace(0, 1, 50)
    for eye, face in ((0.0, "#b3361e"), (np.pi, "white")):
        (axis,) = plot_sphere_traces({"ball": (u, v)}, height=0.0, longitudes=[eye]).axes
        (dot,) = (line for line in axis.lines if line.get_marker() == "o")
        assert dot.get_markerfacecolor() == face
        side = np.cos(eye)
        assert np.allclose(dot.get_xydata(), [[-np.sin(eye), np.cos(1.2)]], atol=1e-12)
        assert side * 1.0 == pytest.approx(1 if face != "white" else -1)


def test_two_spheres_side_by_side_as_vector_graphics(tmp_path: Any) -> None:
    v = np.linspace(0, 20, 60)
    figure = plot_sphere_traces(
        {"moving ball": (0.6 + 0 * v, v), "fixed sphere": (2.5 + 0.2 * np.sin(v), -v)}
    )
    assert [a.get_title() for a in figure.axes] == ["moving ball", "fixed sphere"]
    figure.savefig(tmp_path / "traces.svg")
    text = (tmp_path / "traces.svg").read_text()
    assert "<path" in text and "<image" not in text
    # coarse data are drawn as smooth curves: no chord longer than a few degrees
    points = drawn(figure.axes[0], "#1b3a5c")
    assert len(points) > 400 and np.hypot(*np.diff(points, axis=0).T).max() < 0.06


def test_mistakes_in_traces_are_named() -> None:
    for traces, message in (
        ({}, "no trace to draw"),
        ({"ball": ([1.0, 2.0], [1.0])}, "'ball' needs two arrays"),
        ({"ball": ([1.0, np.nan], [1.0, 2.0])}, "'ball' holds values that are not finite"),
    ):
        with pytest.raises(vo.DefinitionError, match=message):
            plot_sphere_traces(traces)
