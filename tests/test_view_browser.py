"""The page of a motion in a browser without network: drawn, moving, led by mouse, keys and fingers.

The page is played by Chromium, where it is installed; what needs no browser is in ``test_view.py``.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import browser
import numpy as np
import pytest

import voronec as vo
from voronec.motion.viewer.gallery import MOTIONS, STARTS
from voronec.motion.viewer.page import LARGEST, Page, PageView

pytestmark = pytest.mark.skipif(browser.PROGRAM is None, reason="chromium is not installed")
QUICK = "rubber-ball-on-plane", "vertical-disc", "sleigh"
OTHERS = "ellipsoid-on-sphere", "ball-on-paraboloid", "suslov", "veselova-in-new-time"
"""Of kinds of body and ground that the gallery has not: what touches in all is in ``test_view``."""
SHOWN = [(name, scene) for name, scene, _ in MOTIONS]
kinds = pytest.mark.parametrize(
    ("name", "scene"),
    [
        *((name, "default") for name in QUICK),
        *(pytest.param(n, "default", marks=pytest.mark.slow) for n in OTHERS),
        *(pytest.param(*motion, marks=pytest.mark.slow) for motion in SHOWN),
    ],
)
BALL = "rubber-ball-on-plane"


@pytest.fixture(scope="module")
def window(tmp_path_factory: pytest.TempPathFactory) -> Iterator[browser.Tab]:
    with browser.tab(tmp_path_factory.mktemp("browser")) as one:
        one.send("Performance.enable", timeDomain="threadTicks")
        yield one


@pytest.fixture
def tab(window: browser.Tab) -> Iterator[browser.Tab]:
    """A page is left when its test ends: it would draw on while the next motion is integrated."""
    yield window
    window.send("Page.navigate", url="about:blank")


@cache
def text_of(name: str, scene: str = "default") -> str:
    system, initial = vo.load(name), STARTS.get((name, scene))
    everything = (*system.coordinates, *system.velocities)
    return Page(vo.integrate(system, scene, initial=initial, outputs=everything)).text


def opened(tab: browser.Tab, folder: Path, text: str) -> None:
    """A page shown without network: it asks for its own file alone."""
    file = folder / "page.html"
    file.write_text(text, "utf-8")
    offline: dict[str, Any] = {"latency": 0, "downloadThroughput": 0, "uploadThroughput": 0}
    tab.send("Network.emulateNetworkConditions", offline=True, **offline)
    tab.events.clear()
    tab.open(file)
    asked = [p["request"]["url"] for m, p in tab.events if m == "Network.requestWillBeSent"]
    assert asked == [f"file://{file}"]


def complaints(tab: browser.Tab) -> list[Any]:
    """Errors and refusals that the page has met."""
    tab.value("0")
    thrown = [p for m, p in tab.events if m == "Runtime.exceptionThrown"]
    logged = [p["entry"] for m, p in tab.events if m == "Log.entryAdded"]
    asked = [p for m, p in tab.events if m == "Network.requestWillBeSent"][1:]
    return [*thrown, *(entry for entry in logged if entry["level"] == "error"), *asked]


def stands_at(tab: browser.Tab, share: float) -> np.ndarray:
    """The pixels of the stage at a part of the time, by the slider."""
    tab.value(
        "{ const s = document.getElementById('time'); "
        f"s.value = {share} * s.max; s.dispatchEvent(new Event('input')); }}"
    )
    return drawn_anew(tab)


def drawn_anew(tab: browser.Tab) -> np.ndarray:
    """The stage when all that was asked for is drawn."""
    tab.wait("!now.dirty")
    return stage(tab)


def stage(tab: browser.Tab) -> np.ndarray:
    """The pixels of the picture in space."""
    box = "document.getElementById('stage').getBoundingClientRect()"
    left, top, right, bottom = tab.value(f"(b => [b.left, b.top, b.right, b.bottom])({box})")
    return tab.pixels()[int(top) + 2 : int(bottom) - 2, int(left) + 2 : int(right) - 2]


def changed(one: np.ndarray, other: np.ndarray) -> float:
    """The part of the pixels that differ."""
    return float((np.abs(one - other) > 20).any(axis=-1).mean())


@kinds
def test_a_page_is_drawn_and_moves_without_network(
    name: str, scene: str, tab: browser.Tab, tmp_path: Path
) -> None:
    """No error and no request; and at most 5 ms of the processor a frame, GL's calls included.

    Five units of time after the start of a motion of the gallery the box of its traces spans 30 %
    of the height, and half of them is seen.
    """
    text = text_of(name, scene)
    assert len(text.encode()) < LARGEST
    opened(tab, tmp_path, text)
    assert tab.value("document.documentElement.dataset.webgl") is None
    first, before = int(tab.value("document.documentElement.dataset.drawn")), script(tab)
    tab.wait(f"document.documentElement.dataset.drawn >= {first + 10}")
    frames = int(tab.value("document.documentElement.dataset.drawn")) - first
    assert (script(tab) - before) / frames < 5e-3
    early, late = stands_at(tab, 0.0), stands_at(tab, 0.37)
    assert (np.abs(early - 255) > 20).any(axis=-1).mean() > 0.005, "nothing is drawn"
    assert changed(early, late) > 0.0005, "nothing moves"
    if (name, scene) in SHOWN:
        tab.value("document.getElementById('home').click(); arrive(5)")
        assert tab.value("document.getElementById('clock').textContent") == "t = 5.00"
        height, seen = sight_of_traces(tab)
        assert height > 0.3 and seen > 0.5, (height, seen)
    assert not complaints(tab)


def sight_of_traces(tab: browser.Tab) -> tuple[float, float]:
    """The share of the picture's height that the traces' box spans, and the share of them before
    bodies, or behind such as are of glass; faint lines through bodies do not count."""
    whole, bodies, both = (drawn_with(tab, *asked) for asked in ((1, 0), (0, 1), (1, 1)))
    traces = (np.abs(whole - (255, 0, 255)) < 60).all(axis=-1)
    rows = np.flatnonzero(traces.any(axis=1))
    seen = traces & (np.abs(both - bodies) > 60).any(axis=-1)
    return (rows[-1] - rows[0] + 1) / len(traces), seen.sum() / traces.sum()


def drawn_with(tab: browser.Tab, traces: int, bodies: int) -> np.ndarray:
    """The picture in space with the traces, in magenta, with the bodies, or with both."""
    tab.value(
        "drawn.forEach((d) => [...d.group.children, ...d.beside].forEach((m) => {"
        "const own = d.traces.includes(m.geometry), faint = !m.material.depthTest;"
        f"m.visible = Boolean(m !== d.spot && (own ? {traces} && !faint : {bodies}));"
        "if (own) { m.material.color.set(0); m.material.emissive.set(0xff00ff); }"
        "})); now.dirty = true"
    )
    return drawn_anew(tab)


def script(tab: browser.Tab) -> float:
    """Seconds of the processor that the page's thread has spent in scripts."""
    found = tab.send("Performance.getMetrics")["metrics"]
    return float(next(m["value"] for m in found if m["name"] == "ScriptDuration"))


@pytest.mark.slow
def test_the_page_may_not_ask_a_network(tab: browser.Tab, tmp_path: Path) -> None:
    opened(tab, tmp_path, text_of(BALL))
    tab.value("void fetch('http://127.0.0.1:9/').catch(() => { window.refused = true; })")
    tab.wait("window.refused")
    assert any("Content Security Policy" in str(c) for c in complaints(tab))


@pytest.mark.slow
def test_sliders_integrate_in_the_page(tab: browser.Tab, tmp_path: Path) -> None:
    """A start and a parameter dragged with the mouse: the motion is Python's from there."""
    system = vo.load(BALL)
    opened(tab, tmp_path, text_of(BALL))
    tab.value("document.getElementById('parameter-box').open = true")
    for box in ("#start", "#parameters"):
        selector = f"{box} .slider:last-child input[type=range]"
        tab.value(f"document.querySelector({json.dumps(selector)}).scrollIntoView()")
        x, y = tab.middle(selector)
        frames = tab.value("document.documentElement.dataset.computed")
        for kind, along in (("mousePressed", 0), ("mouseMoved", 20), ("mouseReleased", 20)):
            tab.mouse(kind, x + along, y)
        tab.wait(f"document.documentElement.dataset.computed != {frames}")
    start, values = tab.value("now.start"), tab.value("now.parameters")
    given = tab.value("[...DATA.start, ...DATA.parameters].map((e) => e.value)")
    assert sum(a != b for a, b in zip([*start, *values], given, strict=True)) == 2
    states, times = tab.value("now.motion.states"), tab.value("now.motion.times")
    names = tab.value("DATA.start.map((e) => e.name)")
    ours = vo.integrate(
        system,
        times=times,
        initial=dict(zip(names, start, strict=True)),
        parameters=dict(zip(tab.value("DATA.parameters.map((e) => e.name)"), values, strict=True)),
        outputs=(*system.coordinates, *system.velocities),
    )
    expected = np.stack([ours[name] for name in names], axis=1)
    np.testing.assert_allclose(states, expected, rtol=1e-6, atol=1e-6)
    said = [row["text"] for row in tab.value("curveRows()")]
    scale = r"changes by [-\d.e]+ of [-+\d.e]+, the size of its terms$"
    assert any(re.search(scale, one) for one in said), said
    tab.value("document.getElementById('restore').click()")
    assert tab.value("[...now.start, ...now.parameters]") == given
    assert not complaints(tab)


@pytest.mark.slow
def test_keys(tab: browser.Tab, tmp_path: Path) -> None:
    opened(tab, tmp_path, text_of(BALL))
    said = "document.getElementById('play').textContent"
    clock, at = "document.getElementById('clock').textContent", "document.getElementById('time')"
    assert tab.value(said) == "Pause"
    tab.key(" ")
    tab.wait(f"{said} === 'Play'")
    stands_at(tab, 0.5)
    place = tab.value(f"Math.round({at}.value)")
    tab.key("ArrowRight")
    tab.wait(f"Number({at}.value) === {place + 1}")
    later = tab.value(clock)
    tab.key("ArrowLeft")
    tab.wait(f"Number({at}.value) === {place} && {clock} !== {json.dumps(later)}")
    for key in ("a", "w", "q"):
        before = stage(tab)
        tab.key(key)
        assert changed(before, drawn_anew(tab)) > 0.001, key
    pace = tab.value("document.getElementById('pace').textContent")
    tab.key("+")
    faster = tab.value("document.getElementById('pace').textContent")
    assert float(faster.split()[0]) > float(pace.split()[0])
    tab.key(" ")
    tab.wait(f"{said} === 'Pause' && Number({at}.value) > {place}")
    assert not complaints(tab)


def test_mouse_and_fingers(tab: browser.Tab, tmp_path: Path) -> None:
    """Dragging turns, by the mouse or one finger; two fingers come nearer; a button brings back."""
    tab.send("Emulation.setTouchEmulationEnabled", enabled=True, maxTouchPoints=2)
    opened(tab, tmp_path, text_of(BALL))
    home = stands_at(tab, 0.5)
    x, y = tab.middle("#view")
    for kind, along in (("mousePressed", 0), ("mouseMoved", 60), ("mouseReleased", 60)):
        tab.mouse(kind, x + along, y)
    turned = drawn_anew(tab)
    assert changed(home, turned) > 0.001
    for kind, points in (("Start", [(x, y)]), ("Move", [(x - 70, y + 30)]), ("End", [])):
        tab.touch(f"touch{kind}", *points)
    other = drawn_anew(tab)
    assert changed(turned, other) > 0.001
    far = tab.value("camera.far")
    tab.touch("touchStart", (x - 30, y), (x + 30, y))
    for reach in (50, 70, 90):
        tab.touch("touchMove", (x - reach, y), (x + reach, y))
    tab.touch("touchEnd")
    assert tab.value("camera.far") < far / 2
    tab.send("Input.dispatchMouseEvent", type="mouseWheel", x=x, y=y, deltaX=0, deltaY=300)
    tab.wait(f"camera.far > {far / 3 * 1.2}")
    tab.value("document.getElementById('home').click()")
    assert changed(home, drawn_anew(tab)) < 1e-4
    tab.send("Emulation.setTouchEmulationEnabled", enabled=False)
    assert not complaints(tab)


@pytest.mark.slow
def test_a_notebook_shows_it(tab: browser.Tab, tmp_path: Path) -> None:
    """In the frame of a notebook's cell, which may run scripts and nothing else."""
    file = tmp_path / "cell.html"
    shown = PageView(text_of(BALL))._repr_html_()
    file.write_text(f"<!doctype html><body>{shown}</body>", "utf-8")
    tab.events.clear()
    tab.send("Page.navigate", url=f"file://{file}")
    tab.wait("document.querySelector('iframe')")
    for _ in range(200):
        pixels = tab.pixels()
        if (np.abs(pixels[120:500, 20:800] - 255) > 20).any(axis=-1).mean() > 0.05:
            break
    else:
        pytest.fail("nothing is drawn in the frame")
    assert not complaints(tab)


@pytest.mark.slow
def test_what_is_recorded_has_no_sliders(tab: browser.Tab, tmp_path: Path) -> None:
    system = vo.load("demchenko")
    everything = (*system.coordinates, *system.velocities)
    long = np.linspace(0, 3000, 1500)
    page = Page(vo.integrate(system, times=long, outputs=everything, method="closed-form"))
    opened(tab, tmp_path, page.text)
    assert tab.value("document.querySelectorAll('.slider').length") == 0
    assert "longer than a page integrates" in tab.value(
        "document.getElementById('source').innerText"
    )
    assert changed(stands_at(tab, 0.0), stands_at(tab, 0.4)) > 0.001
    assert not complaints(tab)
