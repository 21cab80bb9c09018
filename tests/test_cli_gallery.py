"""``voronec gallery``: its table, its pictures, its refusals, and what Ctrl-C leaves."""

from __future__ import annotations

import base64
import io
import json
import re
from pathlib import Path
from typing import Any

import pytest
from command_line import Call, refused
from PIL import Image

from voronec.closed.classes import search as finding

pytestmark = pytest.mark.slow


def test_rows_say_figure_class_on_both_spheres_and_start(call: Call) -> None:
    answer = call("gallery", "demchenko", "--only", "D1")
    head, ball, sphere, _ = answer.out.splitlines()
    assert answer.status == 0 and answer.err == ""
    assert head.split()[:3] == ["sphere", "figure", "class"]
    assert ball.split()[:6] == ["on", "the", "ball", "8", "D1", "D1"]
    assert sphere.startswith("on the sphere") and "u = acos(" in sphere


def test_json_and_pictures_of_every_motion(call: Call) -> None:
    answer = call("gallery", "demchenko", "--only", "E1", "--json", "--out", "found")
    told = json.loads(answer.out)
    assert answer.status == 0 and told["system"] == "demchenko"
    rows = [(m["trace"], m["class"], m["figure"]) for m in told["motions"]]
    assert rows == [("on the ball", "E1", 11), ("on the sphere", "E1", 11)]
    assert all(m["traces"][m["trace"]]["class"] == m["class"] for m in told["motions"])
    names = {Path(f).name for f in told["files"]}
    assert names == {p.name for p in Path("found").iterdir()}
    assert names >= {"on-the-ball.svg", "on-the-sphere.svg", "on-the-sphere-E1.svg"}


def test_one_picture_by_its_suffix_and_a_system_without_a_paper(call: Call) -> None:
    answer = call("gallery", "zhukovsky-ball", "--only", "A", "--out", "all.png")
    assert answer.status == 0 and "wrote all.png" in answer.out and "figure" not in answer.out
    assert Path("all.png").read_bytes().startswith(b"\x89PNG")


def test_a_class_that_does_not_exist_is_a_line_with_the_reason(call: Call) -> None:
    answer = call("gallery", "demchenko", "--only", "A,D3", "--set", "k=0")
    assert answer.status == 0
    assert "class D3 on the ball does not exist: it needs a phi with 2 roots" in answer.out
    none = call("gallery", "demchenko", "--only", "D3", "--set", "k=0")
    assert none.status == 1 and len(none.out.splitlines()) == 2


def test_without_a_name_pages_of_a_dozen_motions(
    call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown = (("sleigh", "default", "skates"), ("demchenko", "inner", "balls"))
    monkeypatch.setattr("voronec.motion.viewer.gallery.MOTIONS", shown)
    answer = call("gallery", "--json")
    files = [Path(f) for f in json.loads(answer.out)["files"]]
    pages = ["sleigh-default.html", "demchenko-inner.html"]
    assert files == [Path("gallery", name) for name in ("index.html", *pages)]
    listed = files[0].read_text()
    cards = re.findall(
        r'class="card (\w+)" href="(.*?)">.*?base64,(.*?)"><b>(.*?)</b><span>(.+?)</span>', listed
    )
    assert [(kind, page) for kind, page, *_ in cards] == [("kind0", pages[0]), ("kind1", pages[1])]
    assert len({title for *_, title, _ in cards}) == 2 and cards[1][3].endswith(", inner")
    assert '<label for="kind1">balls</label>' in listed
    assert "#kind1:checked ~ main .card:not(.kind1)" in listed
    with Image.open(io.BytesIO(base64.b64decode(cards[0][2]))) as poster:
        assert (poster.format, poster.n_frames) == ("WEBP", 10)
    assert "<canvas" in files[1].read_text()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--only", "A"), "are for one system"),
        (("demchenko", "--only", "A,F"), "there is no class 'F'"),
        (("demchenko", "--out", "x.gif"), "a picture ends in .svg, .png or .pdf"),
        (("demchenko", "--set", "u=1"), "set parameters only"),
        (("demchenko", "--set", "R2=-1"), "parameter 'R2' = -1 must be positive"),
        (("demchenko", "--set", "R1=0"), "on the ball has no value with R1 = 0"),
    ],
)
def test_refusals(call: Call, arguments: tuple[str, ...], words: str) -> None:
    assert words in refused(call("gallery", *arguments))


def test_ctrl_c_keeps_what_is_done(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    find, done = finding.find, []

    def stopping(*given: Any) -> Any:
        if done:
            raise KeyboardInterrupt
        done.append(given)
        return find(*given)

    monkeypatch.setattr(finding, "find", stopping)
    answer = call("gallery", "demchenko", "--only", "D2,E2", "--out", "found")
    assert answer.status == 130 and "stopped, 1 of 4 motions done" in answer.err
    assert answer.out.splitlines()[1].split()[:5] == ["on", "the", "ball", "9", "D2"]
    assert Path("found/on-the-ball-D2.svg").exists()
