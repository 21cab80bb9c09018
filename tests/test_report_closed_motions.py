"""Phase portraits, stability charts, bifurcation sets and films."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from command_line import Call, refused
from tool_modules import tool

import voronec as vo
from voronec.errors import DefinitionError
from voronec.motion.pictures.run_pictures import save

phases, charts = tool("pages.phase_picture"), tool("pages.stability_picture")
PhaseLevel, phase_figure, phase_levels = (
    phases.PhaseLevel, phases.phase_figure, phases.phase_levels,
)  # fmt: skip
sets, rolling_of = tool("pages.bifurcation_picture"), tool("pages.rolling_animation").rolling_of

pytestmark = pytest.mark.slow

x, c = sp.symbols("x c")
WELLS = c - (x**2 - sp.Rational(1, 4)) ** 2
"""Two wells: points of rest at x = 1/2 and -1/2 for c = 0, a separatrix at x = 0 for c = 1/16."""
SIZE = 150_000


@pytest.fixture(scope="module")
def demchenko() -> vo.System:
    return vo.load("demchenko")


def written(figure: object, path: Path) -> bytes:
    save(figure, path)
    return path.read_bytes()


# -- phase portrait -----------------------------------------------------------------------------


def test_separatrices_and_points_of_rest_are_found() -> None:
    levels = phase_levels(WELLS, x, c, sp.Rational(1, 100))
    (separatrix,) = [level for level in levels if level.kind == "separatrix"]
    assert separatrix.double == pytest.approx(0, abs=1e-12)
    assert separatrix.roots == pytest.approx((-(0.5**0.5), 0, 0.5**0.5), abs=1e-9)
    rest = sorted(level.double or 0 for level in levels if level.kind == "rest")
    assert rest == pytest.approx([-0.5, 0.5], abs=1e-12)


@pytest.mark.parametrize(("value", "count"), [("1/100", 2), ("1/10", 1)])
def test_a_level_has_its_intervals(value: str, count: int) -> None:
    (motion,) = [v for v in phase_levels(WELLS, x, c, sp.Rational(value)) if v.kind == "motion"]
    assert len(motion.intervals) == count
    for a, b in motion.intervals:
        assert motion(np.array([a, b])) == pytest.approx([0, 0], abs=1e-12)
        assert (motion(np.linspace(a, b, 9)[1:-1]) > 0).all()


def test_only_the_interval_of_the_motion_is_marked() -> None:
    levels = phase_levels(WELLS, x, c, sp.Rational(1, 100), place=0.5)
    (motion,) = [level for level in levels if level.kind == "motion"]
    assert motion.own == (motion.intervals[1],)
    assert motion.own[0][0] > 0


def test_curves_of_a_portrait_obey_the_equation() -> None:
    level = PhaseLevel((0.25, 0.0, -1.0), "motion")
    (_, below) = phase_figure([level]).axes
    (curve,) = [line for line in below.lines if len(line.get_xdata()) > 100]
    place, rate = curve.get_data()
    assert rate**2 == pytest.approx(0.25 - place**2, abs=1e-12)
    assert rate.min() == pytest.approx(-0.5, abs=1e-3)


def test_a_portrait_is_the_same_bytes_and_small(tmp_path: Path) -> None:
    first, second = (
        written(phase_figure(phase_levels(WELLS, x, c, sp.Rational(1, 10))), tmp_path / "p.svg")
        for _ in range(2)
    )
    assert first == second
    assert len(first) < SIZE


def test_a_portrait_needs_numbers() -> None:
    with pytest.raises(DefinitionError, match="still holds symbols"):
        phase_levels(WELLS + sp.Symbol("k"), x, c, 1)


# -- charts -------------------------------------------------------------------------------------


def test_a_chart_shows_each_region_as_it_is(demchenko: vo.System, tmp_path: Path) -> None:
    from matplotlib.colors import to_hex

    from voronec.closed.special.stability_chart import chart_of

    chart = chart_of(demchenko, unit="k/A")
    figure = charts.stability_figure({"outer": chart}, labels=("$x$", "$w$"))
    (panel,) = figure.axes
    assert to_hex(panel.get_facecolor()) == charts.STABLE
    unstable = [region for region in chart.regions if not region.stable]
    assert 0 < len(unstable) < len(chart.regions)
    for patch, region in zip(panel.patches, unstable, strict=True):
        assert to_hex(patch.get_facecolor()) == charts.UNSTABLE
        assert patch.get_path().contains_point([float(c) for c in region.sample])
    assert len(written(figure, tmp_path / "chart.svg")) < SIZE
    # below k = b1 w lies a second region, which only an enlargement shows
    (corner,) = panel.child_axes
    small = min(unstable, key=lambda region: np.ptp(region.outline[:, 0]))
    assert np.ptp(small.outline[:, 0]) < 0.1
    for low, high, own in zip(*corner.viewLim.get_points(), small.outline.T, strict=True):
        assert low < own.min() and own.max() < high
        assert (high - low) < 2.1 * np.ptp(own)


def test_lines_lose_points_and_neither_shape_nor_ends() -> None:
    from scipy.spatial import cKDTree

    angle = np.linspace(0, 2 * np.pi, 401)
    ring = np.column_stack([np.cos(angle), 100 * np.sin(angle)])
    size = np.array([2.0, 200.0])
    few = charts.thin_line(ring, size)
    assert len(few) < 150
    assert np.array_equal(few[[0, -1]], ring[[0, -1]])
    dense = np.concatenate([np.linspace(a, b, 200) for a, b in pairwise(few)])
    assert cKDTree(dense / size).query(ring / size)[0].max() < 1.1 * charts.FINE


def test_shades_of_a_bifurcation_set_are_numbers_of_motions(demchenko: vo.System) -> None:
    from voronec.closed.special.bifurcation import bifurcation_set

    one = bifurcation_set(demchenko, ("S0", "h2"), {"C5": "1/2"})
    grid = np.array([-1.0, 4.0, 7.0, 11.0, 13.0, 18.0])
    least, second, ridge = sets.levels_of(one, grid)
    assert np.isfinite(ridge).sum() >= 3
    for i, across in enumerate(grid):
        level = sp.Rational(across)
        assert one.motions(level, sp.Rational(least[i]) - sp.Rational(1, 100)) == 0
        assert one.motions(level, sp.Rational(least[i]) + sp.Rational(1, 100)) == 1
        if np.isfinite(ridge[i]) and ridge[i] > second[i]:
            assert one.motions(level, sp.Rational((second[i] + ridge[i]) / 2)) == 2
            assert one.motions(level, sp.Rational(ridge[i]) + sp.Rational(1, 100)) == 1
    (panel,) = sets.bifurcation_figure({"outer": one}).axes
    curves = [line for line in panel.lines if len(line.get_xdata()) > 2]
    assert len(curves) == len(one.curves)


# -- films --------------------------------------------------------------------------------------


@pytest.fixture(scope="module", params=["default", "inner", "shell"])
def run(request: pytest.FixtureRequest, demchenko: vo.System) -> vo.Trajectory:
    times = np.linspace(0, 4, 801)
    return vo.integrate(demchenko, scene=request.param, times=times, method="scipy")


def test_the_ball_of_a_film_touches_and_does_not_slip(run: vo.Trajectory) -> None:
    rolling = rolling_of(run)
    turned = np.einsum("tij,tj->ti", rolling.attitude, rolling.body)
    assert np.allclose(turned, -rolling.fixed, atol=1e-12)
    # The ball's material point at the contact rests: d(centre)/dt = -omega x (contact - centre).
    step = rolling.times[1] - rolling.times[0]
    centres = rolling.centres
    moved = (centres[2:] - centres[:-2]) / (2 * step)
    change = (rolling.attitude[2:] - rolling.attitude[:-2]) / (2 * step)
    swept = rolling.radius * np.einsum("tij,tj->ti", change, rolling.body[1:-1])
    assert np.abs(moved + swept).max() < 2e-3 * np.abs(moved).max()
    kinds = {2.0: "outer", -3.0: "inner", -0.5: "shell"}
    assert rolling.kind == kinds[rolling.fixed_radius]


def test_the_places_of_a_film_are_those_of_the_ball(run: vo.Trajectory) -> None:
    """The ball's centre and attitude, from shapes, are those of Neumann's coordinates."""
    from voronec.motion.pictures.scene_film import ShapesInMotion

    shown, rolling = ShapesInMotion(run), rolling_of(run)
    poses = shown.poses[:, shown.body]
    assert np.allclose(poses[:, :3], rolling.centres, atol=1e-12)
    assert np.allclose(poses[:, 3:12].reshape(-1, 3, 3), rolling.attitude, atol=1e-12)
    # every corner of the ball's surface lies on the ball
    corners, _ = shown.meshes[shown.body]
    assert np.allclose(np.linalg.norm(corners, axis=-1), rolling.radius)


def test_bodies_in_front_hide_what_is_behind() -> None:
    """A ball before another of the same size: the farther one is not seen."""
    from voronec.motion.pictures.scene_film import ShapesInMotion, picture

    x = sp.Symbol("x")
    eye = np.array([np.cos(0.9) * np.cos(0.45), np.sin(0.9) * np.cos(0.45), np.sin(0.45)])
    for order in (1, -1):
        near, far = ([*map(float, sign * 3 * eye)] for sign in (order, -order))
        pair = vo.System(
            name="pair", fibration=vo.Fibration(x), lagrangian=vo.velocity(x) ** 2 / 2,
            shapes=(vo.Shape.ball(1, centre=(near[0] + 0 * x, near[1], near[2])),
                    vo.Shape.ball(1, centre=tuple(far), role="ground")),
        )  # fmt: skip
        run = vo.integrate(pair, initial={x: 0}, times=[0, 1])
        figure = picture(ShapesInMotion(run), 0)
        figure.canvas.draw()
        red, _, blue, _ = np.asarray(figure.canvas.buffer_rgba())[250, 240].astype(int)
        assert (blue > red) == (order > 0)  # the body is blue, the ground sand


def test_traces_do_not_shine_through_what_is_above_them() -> None:
    """A wheel below a wide low board: neither its trace on the ground nor that on it is seen."""
    from matplotlib.colors import to_rgb

    from voronec.declaration.figure_style import INK, MARK
    from voronec.motion.pictures.scene_film import ShapesInMotion, picture

    x = sp.Symbol("x")
    hidden = vo.System(
        name="board", fibration=vo.Fibration(x), lagrangian=vo.velocity(x) ** 2 / 2,
        shapes=(vo.Shape.box((4, 4, 0.05), centre=(x, 0, 0.65)),
                vo.Shape.wheel(0.3, 0, 4 * x, centre=(x, 0, 0.3), contact=(x, 0, 0)),
                vo.Shape.plane()),
    )  # fmt: skip
    run = vo.integrate(hidden, initial={x: 0, vo.velocity(x): 1}, times=np.linspace(0, 1.5, 40))
    figure = picture(ShapesInMotion(run), 39)
    figure.canvas.draw()
    seen = np.asarray(figure.canvas.buffer_rgba())[40:430, :, :3] / 255
    for colour in (INK, MARK):  # on the wheel, on the ground
        assert (np.abs(seen - to_rgb(colour)).max(axis=-1) > 0.1).all()


def test_a_film_has_its_frames(run: vo.Trajectory, tmp_path: Path) -> None:
    from PIL import Image

    from voronec.motion.pictures.scene_film import ShapesInMotion, film

    shares: list[float] = []
    (target,) = film(ShapesInMotion(run), tmp_path / "a.gif", frames=3, progress=shares.append)
    with Image.open(target) as picture:
        assert picture.n_frames == 3
    assert shares == pytest.approx([1 / 3, 2 / 3, 1])
    single = film(ShapesInMotion(run), tmp_path / "b.svg", frames=2)
    assert [p.name for p in single] == ["b-0001.svg", "b-0002.svg"]
    assert single[0].read_bytes() != single[1].read_bytes()


def test_films_that_cannot_be_are_refused_before_any_work(
    demchenko: vo.System, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from voronec.motion.pictures.scene_film import check_film

    bare = vo.System(
        name="bare", fibration=vo.Fibration(sp.Symbol("x")),
        lagrangian=vo.velocity(sp.Symbol("x")) ** 2,
    )  # fmt: skip
    monkeypatch.setattr("voronec.motion.pictures.scene_film.ffmpeg_program", lambda: "")
    for system, target, words in (
        (bare, "a.gif", "has no shape to be viewed"),
        (demchenko, "a.doc", "no film; write"),
        (demchenko, "a.mp4", "ffmpeg"),
        (demchenko, "nowhere/a.gif", "there is no"),
    ):
        with pytest.raises(DefinitionError, match=words):
            check_film(system, tmp_path / target)
    check_film(demchenko, tmp_path / "a.gif")


@pytest.mark.parametrize(
    ("words", "told"),
    [("demchenko --animate a.doc", "write FILE.gif"), ("sleigh --animate a.mp3", "is no film")],
)
def test_run_refuses_a_film_in_one_line(call: Call, words: str, told: str) -> None:
    assert told in refused(call("run", *words.split()))


def test_a_film_takes_what_it_needs_beside_the_outputs(call: Call) -> None:
    words = "two-wheeled-carriage --outputs v --times 0:1:3 --animate a.gif"
    assert call("run", *words.split()).status == 0
    assert Path("a.gif").read_bytes().startswith(b"GIF8")
    head = Path("two-wheeled-carriage-run/trajectory.csv").read_text().partition("\n")[0]
    assert head == "t,v,left,right,x,y,phi"


# -- traces of a closed form ----------------------------------------------------------------------


def test_traces_of_a_closed_form_run_between_its_ends(demchenko: vo.System) -> None:
    from voronec.closed.pictures.sphere_picture import motion_traces, shown_periods

    closed = vo.closed_form(demchenko)
    ball, fixed = motion_traces(closed, {"v": "on the ball"}, periods=6)
    assert ball.title == "on the ball"
    assert sorted(np.cos(ball.parallels)) == pytest.approx(sorted(closed.ends), abs=1e-4)
    assert len(ball.points) == len(fixed.points) == 6 * 600 + 1
    assert ball.times[-1] == pytest.approx(6 * closed.period)
    assert shown_periods(closed, "v") == shown_periods(closed, "v1") == 16
    assert shown_periods(closed, "theta") == 1


def test_no_motion_is_no_portrait() -> None:
    with pytest.raises(DefinitionError, match="no motion with c = -1"):
        phase_levels(WELLS, x, c, -1)
    with pytest.raises(DefinitionError, match="at x = 0: f < 0"):
        phase_levels(WELLS, x, c, sp.Rational(1, 100), place=0.0)


# -- what is committed ----------------------------------------------------------------------------


def test_pictures_of_the_documentation_are_small_and_vectors() -> None:
    folder = Path(__file__).parent.parent / "docs" / "closed-form"
    pictures = sorted(folder.iterdir())
    pictures = [p for p in pictures if not p.stem.startswith("class-")]  # the site makes these
    assert len(pictures) == 8
    for picture in pictures:
        content = picture.read_bytes()
        assert picture.suffix == ".svg"
        assert len(content) < SIZE, picture.name
        assert b"<image" not in content, picture.name
        assert b"<dc:date>" not in content, picture.name
