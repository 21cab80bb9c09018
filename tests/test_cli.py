"""The command line as a user calls it."""

from __future__ import annotations

import csv
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import Call, refused

import voronec as vo

pytestmark = pytest.mark.slow

# -- the whole ---------------------------------------------------------------------------------


@pytest.mark.parametrize("words", ["--help", "list", "show sleigh", "check sleigh"])
def test_what_is_known_loads_nothing_heavy(tmp_path: Path, words: str) -> None:
    code = (
        "import sys\nfrom voronec.cli import main\n"
        f"try:\n    main({words.split()})\n"
        "except SystemExit:\n    pass\n"
        "print(*{'sympy', 'numpy', 'symengine', 'flint', 'matplotlib'} & set(sys.modules))\n"
    )

    def last() -> str:
        done = subprocess.run(
            [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True
        )
        return done.stdout.splitlines()[-1]

    last()  # what it finds out is kept
    assert last() == ""


@pytest.mark.parametrize(
    "words", ["list", "show sleigh", "derive sleigh", "run sleigh", "new sled", "cite sleigh"]
)
def test_every_command_speaks_json(call: Call, words: str) -> None:
    answer = call(*words.split(), "--json")
    assert answer.status == 0
    assert answer.err == ""
    assert json.loads(answer.out)


def test_without_a_command_there_are_three_things_to_try(call: Call) -> None:
    told = call()
    assert told.status == 0 and told.out.startswith("Three things to try:")
    tried = re.findall(r"^  voronec (\w+) (\S+)", told.out, re.MULTILINE)
    assert [command for command, _ in tried] == ["derive", "view", "new"]
    for command, name in tried:
        assert call(command, name).status == 0
    assert "usage: voronec" in call("--help").out


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
@pytest.mark.parametrize(
    ("line", "offered"),
    [
        ("voronec der", ["derive"]),
        ("voronec derive sleigh-o", ["sleigh-on-turntable"]),
        ("voronec run sleigh --method hey", ["heyoka"]),
        ("voronec run sleigh --ani", ["--animate"]),
        ("voronec show my-", ["my-car.toml", "my-folder/"]),
    ],
)
def test_a_shell_offers_commands_options_systems_and_files(
    tmp_path: Path, shell: str, line: str, offered: list[str]
) -> None:
    (tmp_path / "my-car.toml").touch()
    (tmp_path / "my-notes.txt").touch()
    (tmp_path / "my-folder").mkdir()
    asked = {
        "_ARGCOMPLETE": "1", "_ARGCOMPLETE_SHELL": shell, "_ARGCOMPLETE_SUPPRESS_SPACE": "1",
        "_ARGCOMPLETE_STDOUT_FILENAME": str(tmp_path / "offered"), "COMP_LINE": line,
        "COMP_POINT": str(len(line)), "IFS": "\n",
    }  # fmt: skip
    words = [sys.executable, "-m", "voronec"]
    subprocess.run(words, cwd=tmp_path, env=os.environ | asked, check=False)
    found = re.split(r"[\n\v\x0b]", (tmp_path / "offered").read_text())
    assert [re.split(r"[\t:]", word)[0].strip() for word in found if word] == offered


@pytest.mark.parametrize("words", ["", "--help", "list --names", "derive sleigh", "derive none"])
def test_nothing_is_coloured(words: str) -> None:
    """Neither on a terminal nor elsewhere; what replaces a line of progress stays on terminals."""
    done = subprocess.run(
        [sys.executable, "-m", "voronec", *words.split()], capture_output=True, text=True,
        check=False, env=os.environ | {"NO_COLOR": "1"},
    )  # fmt: skip
    assert "\x1b" not in done.stdout + done.stderr


@pytest.mark.parametrize(
    "words", ["frobnicate", "derive", "derive sleigh --frob", "derive sleigh --c --latex",
              "run sleigh --method euler", "list sleigh"]
)  # fmt: skip
def test_a_wrong_command_line_is_refused_in_one_line(call: Call, words: str) -> None:
    assert "--help" in refused(call(*words.split()))


def test_stopped_by_hand_it_ends_quietly(call: Call) -> None:
    Path("slow.py").write_text("raise KeyboardInterrupt\n")
    answer = call("derive", "slow.py")
    assert (answer.status, answer.out, answer.err) == (130, "", "voronec: stopped\n")


def test_a_reader_that_leaves_early_is_no_error() -> None:
    read, write = os.pipe()
    os.close(read)
    buffered = {k: v for k, v in os.environ.items() if k != "PYTHONUNBUFFERED"}
    done = subprocess.run(
        [sys.executable, "-m", "voronec", "show", "sleigh"],
        stdout=write, stderr=subprocess.PIPE, env=buffered, check=False,
    )  # fmt: skip
    os.close(write)
    assert (done.returncode, done.stderr) == (0, b"")


# -- list, show, cite --------------------------------------------------------------------------


def test_list_tells_names_titles_and_claims(call: Call) -> None:
    lines = call("list").out.splitlines()
    (sleigh,) = (line for line in lines if line.startswith("sleigh "))
    assert re.fullmatch(r"sleigh +Chaplygin sleigh +\d+ claims, \d+ relations", sleigh)
    assert [line.split()[0] for line in lines] == vo.names()
    assert call("list", "--names").out.split() == vo.names()


def test_show_tells_the_whole_declaration(call: Call) -> None:
    out = call("show", "sleigh").out
    for word in ("Chaplygin sleigh", "v = xdot*cos(phi) + ydot*sin(phi)", "constraint 1", "energy",
                 "positive", "v = -1", "Chaplygin1911"):  # fmt: skip
        assert word in out
    data = json.loads(call("show", "sleigh", "--json").out)
    assert data["base"] == ["x", "phi"]
    assert data["parameters"][2]["value"] == "3/10"


def test_a_sketch_is_written_into_new_folders(call: Call) -> None:
    assert call("show", "sleigh", "--out", "new/deep/sleigh.svg").status == 0
    assert "<svg" in Path("new/deep/sleigh.svg").read_text()
    Path("taken.py").write_text("mine")
    assert "cannot be written" in call("show", "sleigh", "--out", "taken.py/sleigh.svg").err


def test_show_names_dynamicsymbols_as_it_names_symbols(call: Call) -> None:
    Path("moving.py").write_text(
        "import sympy as sp\nimport voronec as vo\n"
        "from sympy.physics.mechanics import dynamicsymbols\n"
        "x = dynamicsymbols('x')\n"
        "SYSTEM = vo.System(name='moving', fibration=vo.Fibration(base=(x,)),\n"
        "                   lagrangian=vo.velocity(x)**2/2 - x**2/2)\n"
    )
    out = call("show", "moving.py").out
    assert "xdot^2/2" in out
    assert "x(t)" not in out
    assert "xddot = -x" in call("derive", "moving.py").out


def test_cite_prints_bibtex_in_the_order_of_the_system(call: Call) -> None:
    out = call("cite", "sleigh").out
    assert out.startswith("@article{Chaplygin1911,")
    assert out.index("Chaplygin1911") < out.index("Caratheodory1933")
    entries = json.loads(call("cite", "sleigh", "--json").out)
    assert [e["key"] for e in entries] == list(vo.load("sleigh").references)


@pytest.mark.parametrize("name", ["sleigh", "demchenko", "bicycle"])
def test_references_of_a_system_have_their_entries(call: Call, name: str) -> None:
    answer = call("cite", name)
    assert answer.status == 0
    assert answer.out.count("\n@") == len(vo.load(name).references) - 1


# -- derive ------------------------------------------------------------------------------------


def test_derive_tells_kind_growth_equations_and_curvature(call: Call) -> None:
    lines = call("derive", "sleigh").out.splitlines()
    for line in (
        "kind                     chaplygin",
        "growth vector            (2, 3) of 3",
        "integrable combinations  none of 1",
        "  xdot   = v*cos(phi)",
        "  vdot             = a*w^2",
        "  (J + m*a^2)*wdot = -m*a*v*w",
        "  A^y[x, phi] = 1/cos(phi)^2",
    ):
        assert line in lines


@pytest.mark.parametrize(
    ("bound", "told"),
    [
        (
            "Y*sp.cos(p) - X*sp.sin(p), Z - X",
            [
                "integrable combinations  1 of 2",
                "combination              -xdot + zdot = 0",
                "held constant            -x + z",
            ],
        ),
        (
            "Y*(1 + x**2) - X*sp.exp(x**2), Z - X",
            [
                "integrable combinations  2 of 2",
                "combination              -xdot + zdot = 0",
                "combination              -xdot*exp(x^2) + ydot*(x^2 + 1) = 0, "
                "no function found in closed form",
                "held constant            -x + z",
            ],
        ),
    ],
)
def test_combinations_that_integrate_are_told(call: Call, bound: str, told: list[str]) -> None:
    Path("one.py").write_text(
        f"{PREAMBLE}    fibration=F((x, p), (y, z)), lagrangian=free, parameters=(m,), "
        f"constraints=({bound}),\n)\n"
    )
    lines = call("derive", "one.py").out.splitlines()
    start = lines.index(told[0])
    assert lines[start : start + len(told)] == told
    data = json.loads(call("derive", "one.py", "--json").out)
    kept = [line.split("  ")[-1].strip() for line in told if line.startswith("held")]
    assert [e.replace("**", "^") for e in data["held_constant"]] == kept


def test_derive_emits_source(call: Call) -> None:
    assert "\\begin{aligned}" in call("derive", "sleigh", "--latex").out
    assert "void rhs(" in call("derive", "sleigh", "--c").out
    python = call("derive", "sleigh", "--python").out
    compile(python, "emitted", "exec")
    assert json.loads(call("derive", "sleigh", "--c", "--json").out)["c"].count("rhs(") == 1


def test_derive_as_json_is_what_the_equations_hold(call: Call) -> None:
    data = json.loads(call("derive", "vertical-disc", "--json").out)
    assert data["kind"] == "chaplygin"
    assert data["mass"] == [["B + R**2*m", "0"], ["0", "C"]]


def test_equations_too_wide_for_the_terminal_go_on_in_further_lines(
    call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    lines = call("derive", "robot-with-two-trailers").out.splitlines()
    begin = lines.index("motion of the coordinates")
    rows = lines[begin : lines.index("curvature")]
    assert all(len(row) <= 60 for row in rows)
    assert any(row.startswith("      ") for row in rows)


def test_equations_that_would_fill_a_screen_have_names_for_what_is_repeated(call: Call) -> None:
    lines = call("derive", "rattleback").out.splitlines()
    equations = lines[: lines.index("curvature")]
    names = equations[equations.index("where") :]
    assert any("*cos(psi)^2" in line for line in names)
    assert all(len(line) <= 100 for line in equations)


# -- run ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
def test_run_writes_the_motion_and_tells_the_drift(call: Call, method: str) -> None:
    if method == "heyoka":
        pytest.importorskip("heyoka")
    answer = call("run", "sleigh", "--method", method, "--times", "0:5:11", "--out", "made")
    assert (answer.status, answer.err) == (0, "")
    (drift,) = (line for line in answer.out.splitlines() if line.startswith("drift of  energy"))
    assert float(drift.split()[-1]) < 1e-10
    assert sorted(p.name for p in Path("made").iterdir()) == [
        "path.svg",
        "plot.svg",
        "trajectory.csv",
    ]
    with open("made/trajectory.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["t", "x", "y", "phi", "v", "w"]
    assert [float(r["t"]) for r in rows] == [i / 2 for i in range(11)]
    assert "<svg" in Path("made/plot.svg").read_text()


def test_run_tells_the_notes(call: Call) -> None:
    words = ("run", "sleigh", "--times", "0:1:3", "--outputs", "log(v-100)")
    note = "the output 'log(v - 100)' has no finite value at 3 of 3 instants, first at t = 0"
    assert f"note: {note}" in call(*words).out.splitlines()
    assert json.loads(call(*words, "--json").out)["notes"] == [note]


def test_run_twice_writes_the_same_and_keeps_what_else_is_there(call: Call) -> None:
    call("run", "sleigh")
    first = {p.name: p.read_bytes() for p in Path("sleigh-run").iterdir()}
    Path("sleigh-run/notes.txt").write_text("mine")
    call("run", "sleigh")
    second = {p.name: p.read_bytes() for p in Path("sleigh-run").iterdir()}
    assert second == first | {"notes.txt": b"mine"}


def test_run_takes_parameters_initial_values_and_scenes(call: Call) -> None:
    words = ("--set", "R=1/2", "--set", "phidot=0.25", "--json", "--times", "2")
    data = json.loads(call("run", "vertical-disc", "--scene", "straight", *words).out)
    assert data["parameters"]["R"] == 0.5
    assert data["times"] == [0, 2]
    with open("vertical-disc-run/trajectory.csv", newline="") as file:
        last = list(csv.DictReader(file))[-1]
    assert float(last["phi"]) == pytest.approx(0.5)
    assert float(last["theta"]) == pytest.approx(2)


def test_a_system_without_scenes_runs_where_times_are_given(call: Call) -> None:
    call("new", "sled")
    text = Path("sled.py").read_text()
    Path("sled.py").write_text(text[: text.index("    # Motions to look at")] + ")\n")
    assert "give --times" in refused(call("run", "sled.py", "--set", "w=1"))
    assert call("run", "sled.py", "--set", "w=1", "--times", "5").out.startswith("sled: t from 0")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("--set mm=2", "'mm'; did you mean 'm'"),
        ("--set m", "give NAME=VALUE"),
        ("--set m=two", "'two' is not a number"),
        ("--set m=__import__('os')", "is not a number"),
        ("--set m=-1", "'m' = -1 must be positive"),
        ("--set m=nan", "'nan' is not a number"),
        ("--scene lost", "'lost'"),
        ("--times 0:1:1", "from 2 to"),
        ("--times 0:1:many", "'many' is not a number of instants"),
        ("--times 0:1:99999999999", "from 2 to"),
        ("--times a:b", "'a' is not a number"),
        ("--times 1:1", "the same"),
        ("--times=-1e308:1e308:3", "no double holds"),
        ("--times 1:2:3:4", "START"),
        ("--tol 0", "--tol 0"),
        ("--tol 2", "--tol 2"),
        ("--tol 1e-400", "--tol: '1e-400' is too small for a double; give a larger one"),
    ],
)
def test_run_refuses_what_makes_no_sense(call: Call, words: str, told: str) -> None:
    assert told in refused(call("run", "sleigh", *words.split()))


def test_run_never_writes_over_a_file(call: Call) -> None:
    Path("taken.py").write_text("mine")
    assert "'taken.py' is a file" in refused(call("run", "sleigh", "--out", "taken.py"))
    assert Path("taken.py").read_text() == "mine"
    assert "cannot be written" in refused(call("run", "sleigh", "--out", "taken.py/inner"))


def test_a_drawing_may_be_traces_on_spheres_by_their_names(call: Call) -> None:
    call("new", "sled")
    text = Path("sled.py").read_text()
    assert "drawing" not in text
    Path("sled.py").write_text(text.replace("title=", 'drawing={"ball": ("phi", "y")}, title='))
    assert call("run", "sled.py").status == 0
    assert "<svg" in Path("sled-run/drawing.svg").read_text()


def test_a_drawing_that_fails_leaves_nothing_behind(call: Call) -> None:
    call("new", "sled")
    text = Path("sled.py").read_text().replace("title=", "drawing=lambda t: 1 / 0, title=")
    Path("sled.py").write_text(text)
    assert "the drawing of system 'sled' failed: sled.py, line" in refused(call("run", "sled.py"))


# -- new ---------------------------------------------------------------------------------------


def test_new_writes_a_file_that_derives_and_runs(call: Call) -> None:
    assert call("new", "my-sled").status == 0
    assert "wdot = 0" in call("derive", "my_sled.py").out
    assert "drift of  energy" in call("run", "my_sled.py").out
    assert Path("my-sled-run/trajectory.csv").is_file()


def test_new_never_writes_over_a_file(call: Call) -> None:
    Path("sled.py").write_text("mine")
    assert "'sled.py' exists" in refused(call("new", "sled"))
    assert Path("sled.py").read_text() == "mine"


def test_new_refuses_a_name_of_the_catalogue(call: Call) -> None:
    assert "there is a system 'sleigh' already" in refused(call("new", "sleigh"))
    assert not Path("sleigh.py").exists()


@pytest.mark.parametrize("name", ["My", "1st", "a_b", "../a", "a--b", "a-", "", "a b", "ä"])
def test_new_refuses_names_that_no_system_may_have(call: Call, name: str) -> None:
    assert "is no name for a system" in refused(call("new", name))


# -- bad input ---------------------------------------------------------------------------------

PREAMBLE = """\
import sympy as sp
import voronec as vo

x, y, z, p, m, q = sp.symbols("x y z p m q")
X, Y, Z, P = map(vo.velocity, (x, y, z, p))
F = vo.Fibration
plane = m * (X**2 + Y**2 + P**2) / 2
free = plane + m * Z**2 / 2

SYSTEM = vo.System(
    name="bad",
"""
BAD = {
    "not affine": ("fibration=F((x, p), (y,)), lagrangian=plane, parameters=(m,), "
                   "constraints=(X**2 - Y*P,)", "constraint 1 (.*) is not affine"),
    "dependent": ("fibration=F((x, p), (y, z)), lagrangian=free, parameters=(m,), "
                  "constraints=(Y - X, 2*X - 2*Y)", "constraint 2 follows from the others"),
    "contradictory": ("fibration=F((x, p), (y, z)), lagrangian=free, parameters=(m,), "
                      "constraints=(Y - X, Y - X - 1)", "contradict each other"),
    "not transverse": ("fibration=F((x, y), (p,)), lagrangian=plane, parameters=(m,), "
                       "constraints=(X*sp.sin(p) - Y*sp.cos(p),)",
                       r"undetermined: p\); a split that works: base=\(y, p\), fibre=\(x\)|"
                       r"undetermined: p\); a split that works: base=\(x, p\), fibre=\(y\)"),
    "unknown symbol": ("fibration=F((x,)), lagrangian=m*X**2/2, parameters=(m,), "
                       "forces={q: 1}", "for 'q', which is neither a coordinate nor a velocity"),
    "repeated symbol": ("fibration=F((x, p), (x,)), lagrangian=m*X**2/2, parameters=(m,)",
                        "coordinate 'x' is listed twice"),
    "name used twice": ("fibration=F((x,)), lagrangian=m*X**2/2, parameters=(m, x)",
                        "'x' is used twice"),
    "singular mass": ("fibration=F((x, p)), lagrangian=m*X**2/2, parameters=(m,)",
                      "the mass matrix is singular"),
    "stray symbol": ("fibration=F((x,)), lagrangian=m*X**2/2 - q*x, parameters=(m,)",
                     "the Lagrangian contains 'q'"),
    "stray symbol in a constraint": (
        "fibration=F((x, p), (y,)), lagrangian=plane, parameters=(m,), "
        "constraints=(Y - q*X,)", "constraint 1 contains 'q'"),
    "too few constraints": ("fibration=F((x, p), (y,)), lagrangian=plane, "
                            "parameters=(m,)", "1 fibre coordinates but only 0"),
    "no such argument": ("fibraton=F((x,)), lagrangian=m*X**2/2", "TypeError.*'fibraton'"),
    "not a parameter": ("fibration=F((x,)), lagrangian=X**2/2, parameters=(2,)", "'2'"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_bad_definitions_are_refused_in_one_line(call: Call, case: str) -> None:
    text, told = BAD[case]
    Path("bad.py").write_text(f"{PREAMBLE}    {text},\n)\n")
    for command in ("derive", "run"):
        line = refused(call(command, "bad.py"))
        assert re.search(told, line), line


def test_a_file_that_does_not_parse_is_told_with_its_line(call: Call) -> None:
    Path("bad.py").write_text("x = 1\nSYSTEM = (\n")
    assert "bad.py, line 2" in refused(call("derive", "bad.py"))
    assert "there is no file 'none.py'" in refused(call("derive", "none.py"))


def test_an_unknown_system_is_answered_with_the_nearest(call: Call) -> None:
    for command in ("show", "derive", "run", "cite"):
        assert "did you mean 'sleigh'" in refused(call(command, "slegh"))


def test_a_file_called_without_its_ending_is_recognised(call: Call) -> None:
    call("new", "sled")
    for command in ("derive", "check", "graph"):
        assert "'sled.py'" in refused(call(command, "sled"))


@pytest.mark.parametrize("command", ["derive", "cite", "check", "graph", "regenerate"])
def test_a_file_of_another_ending_is_never_run(call: Call, command: str) -> None:
    Path("folder").mkdir()
    for name in ("folder/tau.csv", "t.tml"):
        Path(name).write_text("raise KeyboardInterrupt\n")
        if (command, name) != ("regenerate", "t.tml"):  # a name of a paper
            answer = call(command, name)
            assert (answer.status, answer.out) == (2, "")
            assert f"'{name}' defines no system: a file must end in .py or .toml" in answer.err
        with pytest.raises(vo.DefinitionError, match="a file must end"):
            vo.load(Path(name))
    assert "there is no file 'folder/none'" in call(command, "folder/none").err
    near = "'disc.tml'; did you mean 'disc.toml' or 'disc.py'?"
    assert call(command, "disc.tml").err.count(near) == 1
    with pytest.raises(vo.DefinitionError):  # longer than a name of a file may be
        vo.load(Path("x+" * 200))


def test_an_unknown_command_method_or_option_is_answered_with_the_nearest(call: Call) -> None:
    assert "there is no 'runn'; did you mean 'run'; see" in refused(call("runn"))
    told = refused(call("run", "sleigh", "--method", "heioka"))
    assert "--method: there is no 'heioka'; did you mean 'heyoka'" in told
    told = refused(call("run", "sleigh", "--tims=0:10"))
    assert "voronec run: there is no option '--tims'; did you mean '--times'" in told
    assert "'--jsn'; did you mean '--json'" in refused(call("list", "--jsn"))
    assert "'more' is one argument too many" in refused(call("list", "more"))
    told = refused(call("search", "integrals", "sleigh", "--degree", "two"))
    assert "--degree: 'two' is not a whole number; see" in told
    assert "'.' is a folder; give the file" in refused(call("derive", "."))
