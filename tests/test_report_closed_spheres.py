"""Curves on spheres as smooth arcs: cusps, poles, the horizon, the eye, and the figures."""

from __future__ import annotations

import io
from itertools import pairwise

import numpy as np
import pytest

from voronec.closed.pictures.sphere_curves import (
    FINE,
    Arcs,
    View,
    best_view,
    great_arcs,
    is_resolved,
    meridian,
    on_sphere,
    parallel,
    smooth_arcs,
)
from voronec.closed.pictures.sphere_picture import SphereTrace, traces_figure
from voronec.errors import DefinitionError
from voronec.motion.pictures.run_pictures import save

pytestmark = pytest.mark.slow

TIMES = np.linspace(0, 6 * np.pi, 6001)


def cusped(times: np.ndarray) -> np.ndarray:
    """A cycloid on the sphere: cusps at t = 0, 2 pi, 4 pi, ... with u = 1."""
    return on_sphere(1.0 - 0.2 * (1 - np.cos(times)), 0.3 * (times - np.sin(times)))


def sampled(arcs: Arcs, count: int = 40) -> np.ndarray:
    """Points along arcs."""
    s = np.linspace(0, 1, count)[None, :, None]
    a, b, c, d = (arcs.handles[:, i][:, None] for i in range(4))
    points = (1 - s) ** 3 * a + 3 * s * (1 - s) ** 2 * b + 3 * s**2 * (1 - s) * c + s**3 * d
    return points.reshape(-1, 3)


def distance(points: np.ndarray, curve: np.ndarray) -> float:
    """The largest distance of points from a curve."""
    from scipy.spatial import cKDTree

    return float(cKDTree(curve).query(points)[0].max())


def test_few_arcs_follow_a_curve_with_cusps() -> None:
    arcs = smooth_arcs(cusped(TIMES), TIMES)
    fine = cusped(np.linspace(0, 6 * np.pi, 400_001))
    assert len(arcs.handles) < 100
    assert distance(sampled(arcs), fine) < 1.5 * FINE


def test_a_cusp_is_reached_and_not_rounded_off() -> None:
    arcs = smooth_arcs(cusped(TIMES), TIMES)
    cusp = cusped(np.array([2 * np.pi]))
    assert distance(cusp, sampled(arcs, 400)) < FINE


def test_uneven_steps_are_taken_by_their_times() -> None:
    uneven = 6 * np.pi * np.sort(np.random.default_rng(5).random(8000))
    uneven[[0, -1]] = 0, 6 * np.pi
    arcs = smooth_arcs(cusped(uneven), uneven)
    assert len(arcs.handles) < 150
    assert distance(sampled(arcs), cusped(np.linspace(0, 6 * np.pi, 400_001))) < 1.5 * FINE


def test_a_passage_through_the_pole_is_straight() -> None:
    t = np.linspace(-1, 1, 801)
    arcs = smooth_arcs(on_sphere(np.abs(t), np.where(t < 0, 0.4 + np.pi, 0.4)), t)
    across = sampled(arcs) @ [-np.sin(0.4), np.cos(0.4), 0]
    assert np.abs(across).max() < 1e-12
    assert len(arcs.handles) < 20


def test_coarse_points_of_a_smooth_curve_make_arcs_on_the_sphere() -> None:
    coarse = np.linspace(0, 6 * np.pi, 121)
    arcs = smooth_arcs(cusped(coarse), coarse)
    assert distance(sampled(arcs), cusped(np.linspace(0, 6 * np.pi, 400_001))) < 2e-3
    few = on_sphere(np.pi / 2, np.linspace(0, 2 * np.pi, 15))
    assert is_resolved(few)
    assert np.allclose(np.linalg.norm(sampled(smooth_arcs(few)), axis=1), 1, atol=1.5 * FINE)


@pytest.mark.parametrize(("count", "told"), [(1201, True), (121, True), (13, False), (4, False)])
def test_points_tell_their_curve_or_not(count: int, told: bool) -> None:
    times = np.linspace(0, 6 * np.pi, count)
    assert is_resolved(cusped(times), times) is told


def test_shortest_ways_are_great_circles_through_the_points() -> None:
    points = on_sphere(np.array([0.3, 1.5, 2.0, 2.0]), np.array([0.0, 2.0, -1.0, -1.0 + np.pi]))
    arcs = great_arcs(points)
    assert np.allclose(arcs.handles[::4, 0], points[:-1], atol=1e-12)
    assert np.allclose(arcs.handles[3::4, 3], points[1:], atol=1e-12)
    assert np.allclose(np.linalg.norm(sampled(arcs), axis=1), 1, atol=1e-3)
    normal = np.cross(points[0], points[1])
    assert np.abs(sampled(Arcs(arcs.handles[:4])) @ normal).max() < 1e-12


def test_a_contact_at_rest_is_seen_from_in_front() -> None:
    points = on_sphere(np.full(9, 1.2), np.full(9, 2.0))
    assert best_view(points).project(points)[0, 2] > 0.7


def test_arcs_end_at_the_horizon() -> None:
    parts = smooth_arcs(cusped(TIMES), TIMES).project(View(2.0, 0.1)).parts()
    assert {front for _, front in parts} == {True, False}
    for arcs, front in parts:
        depth = sampled(arcs)[:, 2]
        assert (depth > -1e-9).all() if front else (depth < 1e-9).all()
    for (before, _), (after, _) in pairwise(parts):
        assert before.handles[-1, 3, 2] == after.handles[0, 0, 2] == 0
        assert np.allclose(before.handles[-1, 3], after.handles[0, 0], atol=1e-9)


def test_a_parallel_is_a_circle() -> None:
    points = sampled(parallel(0.7, 0.2))
    assert np.allclose(points[:, 2], np.cos(0.7), atol=1e-12)
    assert np.allclose(np.hypot(points[:, 0], points[:, 1]), np.sin(0.7), atol=1e-5)


def test_a_meridian_is_half_a_great_circle() -> None:
    points = sampled(meridian(0.7))
    assert np.allclose(np.linalg.norm(points, axis=1), 1, atol=1e-5)
    assert np.allclose(points @ [-np.sin(0.7), np.cos(0.7), 0], 0, atol=1e-12)
    assert np.allclose(points[[0, -1], 2], [1, -1])


@pytest.mark.parametrize("colatitude", [0.3, 1.2, 2.0, 2.9])
@pytest.mark.parametrize("longitude", [-2.0, 0.5, 3.0])
def test_a_small_loop_is_seen_from_in_front(colatitude: float, longitude: float) -> None:
    t = np.linspace(0, 2 * np.pi, 400)
    loop = on_sphere(colatitude + 0.1 * np.cos(t), longitude + 0.1 * np.sin(t))
    assert best_view(loop).project(loop)[:, 2].min() > 0.6


def test_the_view_is_a_rotation() -> None:
    frame = View(0.7, -0.3).project(np.eye(3))
    assert np.allclose(frame @ frame.T, np.eye(3))
    assert np.linalg.det(frame) == pytest.approx(1)
    assert frame[2, 0] == pytest.approx(0)  # the axis is upright


def trace(**changes: object) -> SphereTrace:
    u, v = 1.0 - 0.2 * (1 - np.cos(TIMES)), 0.3 * (TIMES - np.sin(TIMES))
    settings: dict = {"colatitude": u, "longitude": v, "times": TIMES, **changes}
    return SphereTrace(**settings)


def patches(figure: object, colour: str) -> list:
    from matplotlib.colors import to_hex
    from matplotlib.patches import PathPatch

    (axis,) = figure.axes  # type: ignore[attr-defined]
    found = [p for p in axis.patches if isinstance(p, PathPatch)]
    return [p for p in found if to_hex(p.get_edgecolor()) == colour]


def test_the_limiting_parallels_are_the_extremes() -> None:
    assert trace().parallels == pytest.approx((0.6, 1.0), abs=1e-6)
    assert trace(limits=(0.5, 0.5)).parallels == (0.5,)
    assert trace(limits=()).parallels == ()


def test_what_is_behind_is_pale_and_its_parallels_are_dashed() -> None:
    from voronec.closed.pictures.sphere_picture import PALE_MARK
    from voronec.declaration.figure_style import INK, MARK, PALE

    figure = traces_figure([trace(view=View(2.0, 0.1))])
    (front,), (back,) = patches(figure, INK), patches(figure, PALE)
    assert back.get_zorder() < front.get_zorder()
    assert back.get_linewidth() < front.get_linewidth()
    assert all(p.get_linestyle() in ("solid", "-") for p in patches(figure, MARK))
    hidden = patches(figure, PALE_MARK)
    assert len(hidden) == 2
    assert all(p.get_linestyle() not in ("solid", "-") for p in hidden)


def test_curves_are_arcs_and_no_polygons() -> None:
    from matplotlib.path import Path

    from voronec.declaration.figure_style import INK

    (front,) = patches(traces_figure([trace()]), INK)
    assert set(front.get_path().codes) == {Path.MOVETO, Path.CURVE4}


@pytest.mark.parametrize(("longitude", "filled"), [(0.0, True), (np.pi, False)])
def test_the_start_is_open_where_it_is_behind(longitude: float, filled: bool) -> None:
    from voronec.declaration.figure_style import MARK

    (axis,) = traces_figure([trace(view=View(longitude, 0.1))]).axes
    (start,) = [line for line in axis.lines if line.get_markeredgecolor() == MARK]
    assert start.get_markerfacecolor() == (MARK if filled else "white")


def test_points_that_tell_no_curve_are_dots() -> None:
    from voronec.declaration.figure_style import INK, PALE

    t = TIMES[::1000]
    given = trace(colatitude=1.0 - 0.2 * np.sin(t) ** 2, longitude=0.3 * t, times=t)
    (axis,) = traces_figure([given]).axes
    marked = [m for m in axis.lines if m.get_color() in (INK, PALE) and m.get_marker() == "o"]
    assert sum(len(m.get_xydata()) for m in marked) == len(t)


def test_an_axis_without_a_name_has_no_words() -> None:
    (axis,) = traces_figure([trace(axis="", view=View(2.0, -0.4))]).axes
    assert not any(words.get_text() for words in axis.texts)


def test_pictures_are_the_same_bytes_and_small() -> None:
    texts = []
    for _ in range(2):
        stream = io.BytesIO()
        save(traces_figure([trace(title="A"), trace(title="B")], title="both"), stream, ".svg")
        texts.append(stream.getvalue())
    assert texts[0] == texts[1]
    assert len(texts[0]) < 150_000
    assert b"<dc:date>" not in texts[0]
    assert b"<image" not in texts[0]


@pytest.mark.parametrize(
    ("colatitude", "longitude", "words"),
    [
        ([1.0], [0.0], "two or more"),
        ([1.0] * 5, [0.0] * 4, "one length"),
        ([1.0, np.nan, 1.0, 1.0], [0.0] * 4, "not finite"),
    ],
)
def test_bad_traces_are_refused(colatitude: list, longitude: list, words: str) -> None:
    with pytest.raises(DefinitionError, match=words):
        SphereTrace(colatitude, longitude)


def test_nothing_is_no_figure() -> None:
    with pytest.raises(DefinitionError, match="no trace"):
        traces_figure([])
