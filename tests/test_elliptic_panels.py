"""Functions of the phase on panels against the functions themselves."""

import math

import numpy as np
import pytest
from elliptic_problems import problem, working_precision
from test_elliptic_doubles import near_pole
from test_elliptic_inversion import SHAPES
from test_elliptic_limits import MULTIPLE

from voronec.elliptic import invert
from voronec.elliptic.many_times import Sample
from voronec.elliptic.panels import Panels

pytestmark = pytest.mark.slow


_bits = working_precision(300)


def tabulated(source, times, work, sizes):
    """The panels, whole half periods, the functions by panels, and they themselves."""
    sample = Sample.of(invert(source), times)
    panels = Panels.of(sample.model, work, sizes)
    counts, rows = panels.at(sample.times, sample.model.arguments.reduction)
    return panels, sample, counts, rows


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("latest", [30.0, 1e9])
def test_panels_give_what_the_motion_gives_however_late(name, latest):
    times = np.random.default_rng(6).uniform(-latest, latest, 3000)

    def work(at):
        return at.x, at.rate, at.affine(1.0, 0.0), at.integral(0, 0.25)

    panels, sample, counts, rows = tabulated(
        SHAPES[name], times, work, ("largest", "largest", "largest", "turn")
    )
    assert len(panels.middles) < 300
    x, rate, near, first = sample.each(work)
    assert np.abs(rows[0] - x).max() < 1e-14 * np.abs(x).max()
    assert np.abs(rows[1] - rate).max() < 2e-14 * np.abs(rate).max()
    assert np.abs(rows[2] - near).max() < 1e-14
    secular_term = sample.model.secular_terms[0]
    whole = rows[3] + counts * secular_term.second + counts * secular_term.first
    assert (np.abs(whole - first) < 2e-14 + 4 * np.spacing(np.abs(first))).all()


def test_what_is_small_near_a_pole_is_right_in_all_its_digits():
    source = near_pole("1e-10")
    solution = invert(source)
    constants = solution.constants(300)
    pole = constants.turn + (40 + constants.phases[0].side) * constants.half
    steps = np.concatenate([[0.0], np.geomspace(1e-13, 1.0, 2000)])
    times = float(pole.mid()) + np.concatenate([-steps, steps])
    place = float((constants.base if constants.phases[0].side == 0 else constants.other).mid())
    ends = [float(x.mid()) for x in (constants.base, constants.other)]
    far = 1e-10 / 0.9
    south = tuple(far if x == place else 1 - x / place for x in ends)
    north = tuple(1 + x / place for x in ends)

    def work(at):
        return (at.colatitude(south, north),)

    panels, sample, _, rows = tabulated(source, times, work, ("own",))
    (angle,) = sample.each(work)
    assert angle.min() < 2e-5
    assert np.abs(rows[0] / angle - 1).max() < 1e-14
    assert 0 < np.count_nonzero(panels.places >= len(panels.middles)) < 0.01 * panels.places.size


def test_a_jump_is_left_to_the_function_itself():
    """A step is no polynomial on any panel: only where it lies the function is asked."""

    def work(at):
        return (np.where(at.arguments.phase_reduction[1] > 0.1, 1.0, -1.0) * at.x,)

    times = np.linspace(0, 20, 5000)
    _, sample, _, rows = tabulated(SHAPES["cubic"], times, work, ("turn",))
    assert np.abs(rows[0] - sample.each(work)[0]).max() < 1e-14
    assert np.abs(np.diff(rows[0])).max() > 0.1


def test_where_panels_are_of_no_use_there_are_none():
    def noise(at):
        return (np.sin(1e9 * at.arguments.phase_reduction[1]),)

    resting = next(source for name, (_, source) in MULTIPLE.items() if name == "rest")
    assert Panels.of(Sample.of(invert(resting), [0.0]).model, noise, ("turn",)) is None
    cubic = invert(SHAPES["cubic"])
    assert Panels.of(Sample.of(cubic, [0.0]).model, noise, ("turn",)) is None


@pytest.mark.parametrize("start", ["0.9", "-0.3"])
def test_panels_count_half_periods_from_the_turning_point_of_the_start(start):
    """Whichever end that is, x is at it when the count is even and no time is left."""
    source = problem("-1", start, 0, "-1.5 -0.3 0.2 0.9") if start == "0.9" else None
    source = source or problem("1", start, 0, "-1.5 -0.3 0.2 0.9")
    half = invert(source).period / 2
    times = half * np.arange(6)
    _, sample, counts, rows = tabulated(source, times, lambda at: (at.x,), ("turn",))
    assert counts.tolist() == list(range(6))
    assert np.abs(rows[0][::2] - float(start)).max() < 1e-14
    assert np.abs(rows[0] - sample.x).max() < 1e-14
    assert math.isclose(rows[0][1], rows[0][3], rel_tol=1e-13)
