"""The page of a motion: what it computes is what Python computes; no browser is needed."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp

import voronec as vo
from voronec.cli import main
from voronec.equations.program import compile_program
from voronec.motion.pictures.scene_film import ShapesInMotion
from voronec.motion.viewer.page import LARGEST, Page

NODE = shutil.which("node")
needs_node = pytest.mark.skipif(NODE is None, reason="node is not installed")
SHAPELESS = {
    *("ball-on-sphere-in-rn", "chaplygin-ball-in-rn", "rubber-ball-in-rn"),
    *("rubber-ball-on-sphere-in-rn", "veselova-in-rn"),  # in four dimensions
    *("rolling-body", "gyroscopic-rolling-body", "symmetric-body-on-sphere"),  # of any surface
    *("symmetric-body-on-plane", "ball-on-surface-of-revolution"),
}
SHAPED = "gyroscopic-ball-on-sphere", "rubber-ball-on-plane"


SHOWN = [name for name in vo.names() if vo.load(name).shapes]
KINDS = (
    *("bicycle", "bychkov-ball", "demchenko", "falling-disc", "gyroscopic-torus-on-ellipsoid"),
    *("rattleback", "robot-with-two-trailers", "rubber-ball-in-new-time", "sleigh-in-time"),
    *("snakeboard", "spheroid-on-sphere", "suslov", "two-wheeled-carriage", "veselova"),
)
QUICK = "bychkov-ball", "vertical-disc", "two-wheeled-carriage"
# a body has the shapes and the contact of the one with a rotor
BODIES = [name for name in SHOWN if f"gyroscopic-{name}" not in SHOWN]
every = pytest.mark.parametrize(
    "name", [n if n in QUICK else pytest.param(n, marks=pytest.mark.slow) for n in BODIES]
)


@cache
def page_of(name: str, **given: Any) -> Page:
    return Page(vo.integrate(vo.load(name), outputs=everything(name), **given))


def everything(name: str) -> tuple[Any, ...]:
    system = vo.load(name)
    return (*system.coordinates, *system.velocities)


@cache
def page_at_start(name: str) -> Page:
    """The first instant of a scene alone: that scenes run is in ``test_conformance``."""
    return page_of(name, times=(0.0,))


def in_node(page: Page, last: str) -> Any:
    """What the scripts of the page give for an expression."""
    assert NODE is not None
    script = f"{page.motion_script}\nprocess.stdout.write(JSON.stringify({last}));"
    done = subprocess.run([NODE, "-"], input=script, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_all_that_lies_in_space_has_a_shape() -> None:
    """But for bodies of four dimensions, and those whose surface is a function not given."""
    assert {*vo.names()} - {*SHOWN} == SHAPELESS


@needs_node
def test_names_are_written_by_hand() -> None:
    names = ["theta", "phidot", "omega1", "v1", "beta_R", "kappa_12", "lean", "thetadotdot", "x"]
    hand = ["θ", "φ\u0307", "ω₁", "v₁", "β_R", "κ₁₂", "lean", "θ\u0307\u0307", "x"]
    assert in_node(page_at_start("sleigh"), f"{json.dumps(names)}.map(letters)") == hand


@pytest.mark.slow
@needs_node
def test_an_address_holds_the_instant_the_start_and_parameters() -> None:
    """What it says is read back to the last bit; what the page does not take is named."""
    page = page_at_start("sleigh")
    parameters = [entry["name"] for entry in page.data["parameters"]]
    there = "DATA.start.map((e) => e.value + 1 / 3)", "DATA.parameters.map((e) => 7 * e.value / 3)"
    read = in_node(page, f"readAddress(addressOf(2.5, {there[0]}, {there[1]}))")
    assert read["time"] == 2.5 and read["wrong"] == ""
    assert read["start"] == in_node(page, there[0])
    assert read["parameters"] == in_node(page, there[1])
    plain = in_node(page, 'readAddress("")')
    assert plain["time"] is None
    assert plain["parameters"] == [e["value"] for e in page.data["parameters"]]
    assert (
        in_node(page, "addressOf(null, readAddress('').start, readAddress('').parameters)") == "#"
    )
    for part in (f"{parameters[0]}=-1", "nobody=1", f"{parameters[0]}=2;alert(1)", "%=1", "t="):
        found = in_node(page, f"readAddress({json.dumps('#' + part)})")
        assert found["wrong"] == part and found["parameters"] == plain["parameters"]


@pytest.mark.slow
@needs_node
@pytest.mark.parametrize("name", KINDS)
def test_rates_places_and_integrals_are_those_of_python(name: str) -> None:
    """At five random states of each, with parameters as random."""
    page, random = page_at_start(name), np.random.default_rng(19)
    program = page.program
    first = np.array([page.trajectory.parameters[str(p)] for p in program.parameters])
    states = page.states[0] + random.uniform(-0.05, 0.05, (5, len(program.state)))
    values = first * random.uniform(0.95, 1.05, (5, len(first)))
    pairs = json.dumps([[*map(list, pair)] for pair in zip(states, values, strict=True)])
    both = f"{pairs}.map(([y, p]) => [...program.rhs(0.7, y, p), ...program.extras(0.7, y, p)])"
    rates, extras = compile_program(program)
    for row, y, p in zip(in_node(page, both), states, values, strict=True):
        ours = [*rates(0.7, list(y), list(p)), *extras(0.7, list(y), list(p))]
        np.testing.assert_allclose(row, ours, rtol=1e-12, atol=1e-12)


@pytest.mark.slow
@needs_node
@pytest.mark.parametrize("name", SHAPED)
def test_the_page_integrates_as_python_does(name: str) -> None:
    page = page_of(name)
    start, values = page.states[0].tolist(), [e["value"] for e in page.data["parameters"]]
    motion = in_node(page, f"motionOf({json.dumps(start)}, {json.dumps(values)})")
    assert motion["why"] == "" and len(motion["times"]) == len(page.trajectory.t)
    np.testing.assert_allclose(motion["states"], page.states, rtol=1e-9, atol=1e-9)
    assert {i["name"] for i in motion["integrals"]} == {*page.system.integrals}
    assert all(i["drift"] < 1e-11 for i in motion["integrals"])


@pytest.mark.slow
@needs_node
def test_another_start_and_other_parameters_as_sliders_give_them() -> None:
    page = page_of("vertical-disc")
    start, values = page.states[0].copy(), [e["value"] for e in page.data["parameters"]]
    start[-1], values = 0.9 * start[-1] + 0.1, [1.25 * value for value in values]
    motion = in_node(page, f"motionOf({json.dumps(start.tolist())}, {json.dumps(values)})")
    names = [e["name"] for e in page.data["parameters"]]
    system = page.system
    ours = vo.integrate(
        system,
        outputs=everything(system.name),
        times=page.trajectory.t,
        initial=dict(zip(map(str, page.program.state), start, strict=True)),
        parameters=dict(zip(names, values, strict=True)),
    )
    np.testing.assert_allclose(motion["states"], Page(ours).states, rtol=1e-8, atol=1e-8)
    assert not np.allclose(motion["states"], page.states, atol=1e-2)


@pytest.mark.slow
@needs_node
def test_the_contact_lies_on_both_bodies() -> None:
    """The ball of radius R2 touches the sphere of radius R1 where the page says so."""
    page = page_of("gyroscopic-ball-on-sphere")
    poses = in_node(page, "Array.from(motionOf(DATA.start.map((e) => e.value), "
                    "DATA.parameters.map((e) => e.value)).poses)")  # fmt: skip
    ball = np.reshape(poses, (-1, 2, 15))[:, 0]
    centre, attitude, contact = ball[:, :3], ball[:, 3:12].reshape(-1, 3, 3), ball[:, 12:]
    values = page.trajectory.parameters
    np.testing.assert_allclose(np.linalg.norm(contact, axis=1), values["R1"], rtol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(contact - centre, axis=1), values["R2"], rtol=1e-12)
    identity = np.broadcast_to(np.eye(3), attitude.shape)
    np.testing.assert_allclose(attitude @ attitude.transpose(0, 2, 1), identity, atol=1e-13)
    # rolling: both traces are equally long
    own = np.einsum("kji,kj->ki", attitude, contact - centre)
    lengths = [np.linalg.norm(np.diff(x, axis=0), axis=1).sum() for x in (own, contact)]
    assert lengths[0] == pytest.approx(lengths[1], rel=3e-4)


@pytest.mark.slow
@every
def test_what_touches_rests_on_the_ground_there(name: str) -> None:
    """Bodies of round shape do not slip where they are drawn to touch, and blades not sideways."""
    page, step = page_at_start(name), 1e-6
    rates, extras = compile_program(page.program)
    numbers = [page.trajectory.parameters[str(p)] for p in page.program.parameters]
    state, inputs = page.states[0], page.program.inputs
    values = (numbers, [0.0] * len(inputs)) if inputs else (numbers,)
    flow = np.array(rates(0.0, list(state), *values), dtype=float)

    def poses(time: float) -> np.ndarray:
        count = 15 * len(page.system.shapes)
        there = extras(time, list(state + time * flow), *values)[:count]
        return np.array(there, dtype=float).reshape(-1, 15)

    here, change = poses(0.0), (poses(step) - poses(-step)) / (2 * step)

    def carried(k: int, place: np.ndarray) -> np.ndarray:
        """The velocity of what is fixed in shape k at a place."""
        turned, turning = here[k, 3:12].reshape(3, 3), change[k, 3:12].reshape(3, 3)
        return change[k, :3] + turning @ turned.T @ (place - here[k, :3])

    grounds = [k for k, shape in enumerate(page.system.shapes) if shape.role == "ground"]
    for k, shape in enumerate(page.system.shapes):
        turned = here[k, 3:12].reshape(3, 3)
        np.testing.assert_allclose(turned @ turned.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(turned) > 0
        particle = shape.contact == shape.centre  # which slides
        if shape.contact is None or particle or not grounds:
            continue
        slip = turned.T @ (carried(k, here[k, 12:]) - carried(grounds[0], here[k, 12:]))
        blade = len(shape.patches) == 6  # a box stands for one, along its first axis
        assert np.abs(slip[1] if blade else slip).max() < 1e-6, (name, slip)


@pytest.mark.slow
@needs_node
def test_the_quartic_is_the_square_of_the_rate() -> None:
    page = page_of("demchenko")
    quartic = (
        "motionOf(DATA.start.map((e) => e.value), DATA.parameters.map((e) => e.value)).quartic"
    )
    found = in_node(page, f"{quartic}.map(([x, ...values]) => [x, quarticAt(values, x)])")
    (x, value), t = np.transpose(found), page.trajectory.t
    # of the fourth order in the step
    rate = (8 * (x[3:-1] - x[1:-3]) - (x[4:] - x[:-4])) / (12 * (t[1] - t[0]))
    np.testing.assert_allclose(rate**2, value[2:-2], atol=1e-3 * np.max(value))
    assert "on the ball: class" in page.data["quartic"]["classes"]


@needs_node
def test_a_motion_that_cannot_go_on_says_where() -> None:
    page = page_of("rubber-ball-on-plane")
    pole = "integrate((t, y) => [y[0] * y[0]], [0, 0.5, 2], [1], [])"
    found = in_node(page, pole)
    assert len(found["states"]) == 2 and re.search(r"at t = (1\.0000|0\.99999)", found["why"])


def test_the_page_holds_all_that_it_needs() -> None:
    text = page_of("gyroscopic-ball-on-sphere").text
    assert len(text.encode()) < LARGEST
    assert "default-src 'none'; script-src 'sha256-" in text and "unsafe" not in text[:2000]
    assert not re.search(r"<(link|img|iframe)|\bsrc=|@import|url\(", text.split("<script>")[0])
    assert "Permission is hereby granted" in text  # the licence of three.js


def test_what_cannot_be_integrated_is_played_and_said_so() -> None:
    system = vo.load("demchenko")
    both = (*system.coordinates, *system.velocities)
    page = Page(vo.integrate(system, times=[0, 1e5], outputs=both, method="closed-form"))
    assert page.recording_reason == "the motion is longer than a page integrates"
    assert page.data["recorded"] and not any(e["slides"] for e in page.data["start"])


def test_a_title_ends_no_script() -> None:
    x = sp.Symbol("x")
    system = vo.System(
        name="slide", title="</script><!--", fibration=vo.Fibration((x,)),
        lagrangian=vo.velocity(x) ** 2 / 2, shapes=vo.Shape.ball(1, centre=(x, 0, 0)),
    )  # fmt: skip
    text = Page(vo.integrate(system, times=1.0, initial={vo.velocity(x): 1})).text
    assert text.count("</script>") == 1 and "<!--" not in text


def test_a_title_that_holds_the_marks_of_the_page_is_shown_as_it_is() -> None:
    x = sp.Symbol("x")
    marks = "@SCRIPT@ @TITLE@ @STYLE@"
    system = vo.System(
        name="marks", title=marks, fibration=vo.Fibration((x,)),
        lagrangian=vo.velocity(x) ** 2 / 2, shapes=(vo.Shape.ball(1, centre=(x, 0, 0)),),
    )  # fmt: skip
    text = Page(vo.integrate(system, times=1.0, initial={vo.velocity(x): 1})).text
    assert f"<title>{marks}</title>" in text and text.count("</script>") == 1
    assert text.count(marks) == 2, "in the head, and in what the script shows"


def test_shapes_of_one_line_stand_on_the_ground() -> None:
    """Where blade, cart and rod are, in their own axes; a height over the plane is a surface."""
    x, y = sp.symbols("x y")
    shapes = {
        vo.Shape.blade(4): ((-2, -0.05, 0), (2, 0.05, 1)),
        vo.Shape.cart(8): ((-4, -2.1, 0), (4, 2.1, 4)),
        vo.Shape.rod(4): ((-2, -0.1, -0.1), (2, 0.1, 0.1)),
        vo.Shape.surface((x, y), x * y, ((-1, 1), (0, 2))): ((-1, 0, -2), (1, 2, 2)),
    }
    system = vo.System(
        name="things", fibration=vo.Fibration((x,)), lagrangian=vo.velocity(x) ** 2 / 2,
        shapes=tuple(shapes),
    )  # fmt: skip
    shown = ShapesInMotion(vo.integrate(system, initial={x: 1}, times=[0, 1]))
    for patches, (low, high) in zip(shown.finite_patches, shapes.values(), strict=True):
        points = np.concatenate([quads for quads, _ in patches]).reshape(-1, 3)
        np.testing.assert_allclose(points.min(axis=0), low, atol=1e-12)
        np.testing.assert_allclose(points.max(axis=0), high, atol=1e-12)


@pytest.mark.slow
def test_what_has_no_page_is_refused_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["view", "veselova-in-rn", "--out", str(tmp_path)]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "has no shape to be viewed; declare one" in said
    assert 'in a text file a table [[shapes]] with kind = "ball"' in said
    long = ["--times", "0:5000:20000", "--out", str(tmp_path)]
    assert main(["view", "demchenko", *long]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "too long for a page" in said
    with pytest.raises(vo.DefinitionError, match=r"needs u, v, .* integrate with outputs="):
        vo.integrate(vo.load("rubber-ball-on-plane"), outputs=("omega1",)).view()


def test_a_page_is_written_and_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["view", "rubber-ball-on-plane", "--out", str(tmp_path), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert Path(said["file"]).stat().st_size == said["bytes"] < LARGEST
    shown = page_of("rubber-ball-on-plane").trajectory.view()
    assert 'sandbox="allow-scripts"' in shown._repr_html_()
    with pytest.raises(vo.DefinitionError, match=r"must end in \.html"):
        page_of("rubber-ball-on-plane").trajectory.view(tmp_path / "page.txt")


@pytest.mark.parametrize(
    ("given", "wrong"),
    [
        ({"role": "star"}, "role 'star'; give one of body, ground"),
        ({"centre": (1, 2)}, "centre of a shape has 2 components; give three"),
        ({"attitude": sp.eye(2)}, "3 x 3 matrix"),
        ({"centre": (sp.Symbol("z"), 0, 0)}, "contains 'z'"),
    ],
)
def test_wrong_shapes_are_refused(given: dict[str, Any], wrong: str) -> None:
    x = sp.Symbol("x")
    with pytest.raises(vo.DefinitionError, match=wrong):
        vo.System(
            name="slide", fibration=vo.Fibration((x,)), lagrangian=vo.velocity(x) ** 2,
            shapes=(vo.Shape.ball(1, **given),),
        )  # fmt: skip
