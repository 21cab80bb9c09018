"""Chromium without a window, led through its DevTools protocol over a pipe."""

from __future__ import annotations

import base64
import fcntl
import io
import json
import os
import shutil
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

PROGRAM = shutil.which("chromium") or shutil.which("google-chrome")
OPTIONS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--use-gl=angle", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--window-size=1200,950", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--remote-debugging-pipe",
)  # fmt: skip
PATIENCE = 300.0
"""Seconds to wait for an answer, on a machine with other work."""


class Tab:
    """One page: commands, and the events that it reported, as (method, parameters)."""

    def __init__(self, reads: int, writes: int) -> None:
        self.reads, self.writes = reads, writes
        self.held, self.number, self.session = b"", 0, ""
        self.events: list[tuple[str, dict[str, Any]]] = []

    def send(self, method: str, **parameters: Any) -> dict[str, Any]:
        """The result of a command."""
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.writes, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._message()
            if answer.get("id") == self.number:
                assert "error" not in answer, (method, answer["error"])
                return answer["result"]
            self.events.append((answer["method"], answer.get("params", {})))

    def _message(self) -> dict[str, Any]:
        while b"\0" not in self.held:
            part = os.read(self.reads, 1 << 20)
            assert part, "the browser ended"
            self.held += part
        one, self.held = self.held.split(b"\0", 1)
        return json.loads(one)

    def open(self, file: Path, part: str = "") -> None:
        """Open a file, and wait until it is drawn."""
        self.send("Page.navigate", url=f"file://{file}{part}")
        self.wait("document.documentElement?.dataset.drawn > 0")

    def value(self, expression: str) -> Any:
        """What a script of the page gives."""
        found = self.send("Runtime.evaluate", expression=expression, returnByValue=True)
        assert "exceptionDetails" not in found, found
        return found["result"].get("value")

    def wait(self, condition: str) -> None:
        """Until a condition of the page holds."""
        until = time.monotonic() + PATIENCE
        while not self.value(f"Boolean({condition})"):
            assert time.monotonic() < until, f"{condition} does not come true"
            time.sleep(0.05)

    def pixels(self) -> np.ndarray:
        """What is seen: rows, columns, red, green and blue to 255."""
        from matplotlib.image import imread

        data = base64.b64decode(self.send("Page.captureScreenshot", format="png")["data"])
        return 255 * imread(io.BytesIO(data))[..., :3].astype(float)

    def key(self, key: str) -> None:
        """A key pressed and let go."""
        text = key if len(key) == 1 else ""
        self.send("Input.dispatchKeyEvent", type="keyDown", key=key, text=text)
        self.send("Input.dispatchKeyEvent", type="keyUp", key=key)

    def touch(self, kind: str, *points: tuple[float, float]) -> None:
        """Fingers on the page: ``touchStart``, ``touchMove``, ``touchEnd``."""
        there = [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(points)]
        self.send("Input.dispatchTouchEvent", type=kind, touchPoints=there)

    def mouse(self, kind: str, x: float, y: float) -> None:
        """The left button: ``mousePressed``, ``mouseMoved``, ``mouseReleased``."""
        self.send("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    def middle(self, selector: str) -> tuple[float, float]:
        """The middle of an element."""
        box = f"document.querySelector({json.dumps(selector)}).getBoundingClientRect()"
        x, y = self.value(
            f"(({{ x, y, width, height }}) => [x + width / 2, y + height / 2])({box})"
        )
        return x, y


@contextmanager
def tab(folder: Path) -> Iterator[Tab]:
    """A browser with one page, whose requests, errors and words are reported."""
    assert PROGRAM is not None
    (given, writes), (reads, taken) = os.pipe(), os.pipe()
    command = [PROGRAM, *OPTIONS, f"--user-data-dir={folder / 'profile'}", "about:blank"]

    def at_three_and_four() -> None:
        ends = [fcntl.fcntl(end, fcntl.F_DUPFD, 10) for end in (given, taken)]
        for place, end in enumerate(ends, 3):
            os.dup2(end, place)

    silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    running = subprocess.Popen(command, preexec_fn=at_three_and_four, close_fds=False, **silent)
    os.close(given)
    os.close(taken)
    page = Tab(reads, writes)
    try:
        targets = page.send("Target.getTargets")["targetInfos"]
        (own,) = (t["targetId"] for t in targets if t["type"] == "page")
        page.session = page.send("Target.attachToTarget", targetId=own, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            page.send(f"{domain}.enable")
        yield page
    finally:
        os.close(writes)
        os.close(reads)
        running.terminate()
        running.wait()
