"""``voronec regenerate`` as a user calls it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from command_line import Call, refused
from signals import hears_ctrl_c

pytestmark = pytest.mark.slow

SHEET = """
import sympy
from voronec.audit import Display, Paper, Section, Study

def studies(_):
    x = sympy.Symbol("x")
    return {"only": Study({"x": x})}

LINES = (r"\\begin{equation}\\label{double} x+x=2x \\end{equation}", r"$$ x+x=3x $$")
PAPER = Paper("sheet", "A sheet", (Section("All", tuple(map(Display, LINES)), studies),))
"""


@pytest.fixture(autouse=True)
def own_cache(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path_factory.mktemp("cache")
    for name in ("XDG_CACHE_HOME", "LOCALAPPDATA", "HOME"):
        monkeypatch.setenv(name, str(folder))
    return folder


@pytest.fixture
def sheet(call: Call) -> str:
    Path("sheet.py").write_text(SHEET)
    return "sheet.py"


def test_a_file_is_a_paper(call: Call, sheet: str) -> None:
    answer = call("regenerate", sheet, "--json")
    assert answer.status == 0
    records = json.loads(answer.out)
    assert [r["verdict"] for r in records] == ["proved", "misprint"]
    fields = {"label", "section", "ordinal", "printed", "derived", "verdict", "correction"}
    assert fields | {"witness", "method"} <= set(records[0])
    assert [r["label"] for r in records] == ["double", None]


def test_a_label_selects_one_display(call: Call, sheet: str) -> None:
    (record,) = json.loads(call("regenerate", sheet, "--json", "--label", "double").out)
    assert record["label"] == "double"
    assert "did you mean 'double'?" in refused(call("regenerate", sheet, "--label", "duoble"))


def test_an_unknown_paper_is_answered_with_the_nearest(call: Call) -> None:
    assert "did you mean 'demchenko'?" in refused(call("regenerate", "demchenco"))
    assert "there is no file 'none.py'" in refused(call("regenerate", "none.py"))
    Path("empty.py").write_text("")
    assert "defines no PAPER" in refused(call("regenerate", "empty.py"))
    Path("empty.py").write_text("PAPER = 1")
    assert "is not a voronec.audit.Paper" in refused(call("regenerate", "empty.py"))


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ("raise ValueError('no')", "bad.py, line 4: ValueError: no"),
        ("return {}", "section 'All': 'studies' must return a dict"),
        ("return None", "section 'All': 'studies' must return a dict"),
        ("return {'only': 1}", "section 'All': the study 'only' is a int"),
    ],
)
def test_a_paper_whose_studies_fail_is_told_in_one_line(call: Call, body: str, told: str) -> None:
    lines = [
        "from voronec.audit import Display, Paper, Section",
        "",
        "def studies(_):",
        f"    {body}",
        "",
        "PAPER = Paper('bad', '', (Section('All', (Display('$x=x$'),), studies),))",
    ]
    Path("bad.py").write_text("\n".join(lines))
    assert told in refused(call("regenerate", "bad.py"))


def test_a_folder_that_cannot_be_written_is_refused_before_any_work(call: Call) -> None:
    Path("taken.py").write_text("mine")
    assert "'taken.py' is a file" in refused(call("regenerate", "demchenko", "--out", "taken.py"))


def test_the_report_has_three_files(call: Call) -> None:
    answer = call("regenerate", "chaplygin-ball", "--out", "report", "--json")
    assert answer.status == 0
    assert json.loads(answer.out) == json.loads(Path("report/report.json").read_text())
    assert "<html" in Path("report/report.html").read_text()
    assert Path("report/report.tex").is_file()


def test_a_second_audit_takes_its_verdicts_from_the_cache(
    call: Call, own_cache: Path, sheet: str
) -> None:
    first = call("regenerate", sheet, "--json").out
    kept = list(own_cache.rglob("*.json"))
    assert len(kept) == 2
    stamps = [f.stat().st_mtime_ns for f in kept]
    assert call("regenerate", sheet, "--json").out == first
    assert [f.stat().st_mtime_ns for f in kept] == stamps
    assert call("regenerate", sheet, "--json", "--fresh").status == 0


@pytest.mark.skipif(sys.platform == "win32", reason="sends a signal")
def test_an_interrupted_audit_leaves_what_is_finished(tmp_path: Path, own_cache: Path) -> None:
    environment = {**os.environ, "XDG_CACHE_HOME": str(own_cache), "HOME": str(own_cache)}
    command = [sys.executable, "-m", "voronec", "regenerate", "demchenko", "--out", "report"]
    work = subprocess.Popen(
        command, cwd=tmp_path, env=environment, stderr=subprocess.PIPE, stdout=subprocess.PIPE,
        preexec_fn=hears_ctrl_c,
    )  # fmt: skip
    while work.poll() is None and not list(own_cache.rglob("*.json")):
        time.sleep(0.02)
    work.send_signal(signal.SIGINT)
    out, err = work.communicate()
    assert work.returncode == 130
    assert b"Traceback" not in out + err
    assert list(own_cache.rglob("*.json"))
    assert not (tmp_path / "report").exists(), "nothing half-written"


def test_the_end_is_a_screenful(call: Call, sheet: str) -> None:
    answer = call("regenerate", sheet, "--out", "report")
    lines = answer.out.splitlines()
    assert answer.status == 0 and len(lines) < 25
    assert lines[0] == "A sheet" and "  All: 1 proved, 1 misprint" in lines
    place = lines.index("wrong in print")
    assert lines[place + 1].startswith("  display 2: ")
    assert any("open report/report.html" in line.replace("\\", "/") for line in lines)
    assert "erratum" not in answer.out and "--details" in answer.out


def test_details_are_printed_where_they_are_asked_for(call: Call, sheet: str) -> None:
    for words in (("--details",), ("--label", "double")):
        answer = call("regenerate", sheet, *words)
        assert "(double)" in answer.out and "wrong in print" not in answer.out
    assert "erratum 1: display 2" in call("regenerate", sheet, "--details").out
