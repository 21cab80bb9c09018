"""``voronec check``: what is true passes; what is false or broken is told in one line."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from command_line import Call, refused
from plugins import register
from signals import hears_ctrl_c

from voronec.cli.check import shorten_square
from voronec.declaration import source_digest as sources
from voronec.declaration.whole_files import Store
from voronec.declaration.worker_processes import Worker
from voronec.proof.check import Inventory, check_catalogue
from voronec.proof.check.catalogue_check import Examiner
from voronec.proof.check.report import Finding, Report, Result
from voronec.proof.check.unit import units_of

pytestmark = pytest.mark.slow

SLED = """
import sympy as sp
from voronec import Fibration, Limit, Relation, Scene, Square, System, velocity

s, m = sp.symbols("s m")
SYSTEM = System(
    name="{name}",
    fibration=Fibration(base=(s,)),
    lagrangian=m * velocity(s) ** 2 / 2,
    parameters=(m,),
    integrals={{"speed": {integral}}},
)
"""


def sled(name: str, integral: str = "velocity(s)", more: str = "") -> str:
    return SLED.format(name=name, integral=integral) + more


BAD = {
    "zz_fails": "x = 1\nraise RuntimeError('no')\n",
    "zz_false": sled("zz-false", "s"),
    "zz_target": sled("zz-target", more='RELATIONS = (Relation("zz-target", "zz-god"),)\n'),
    "zz_unmapped": sled("zz-unmapped", more='RELATIONS = (Relation("zz-unmapped", "zz-good"),)\n'),
    "zz_variable": sled(
        "zz-variable",
        more='RELATIONS = (Relation("zz-variable", "zz-good", parameters={m: m, "q": 1}),)\n',
    ),
    "zz_kind": sled("zz-kind", more='RELATIONS = ("zz-good",)\n'),
    "zz_untupled": sled("zz-untupled", more='RELATIONS = Relation("zz-untupled", "zz-good")\n'),
    "zz_label": sled(
        "zz-label",
        more='RELATIONS = (Relation("zz-label", "zz-good", parameters={m: m}),) * 2\n',
    ),
    "zz_square": sled("zz-square", more='SQUARES = (Square(first=("nope",), second=()),)\n'),
    "zz_name": sled("zz-good"),
    "zz_good": sled("zz-good"),
}
SAYS = {
    "zz-fails": r"zz_fails\.py, line 2: RuntimeError: no",
    "zz-false": r"integral 'speed' is refuted \(.*zz_false\.py\)",
    "zz-target": r"zz_target\.py\).*there is no system 'zz-god'; did you mean 'zz-good'",
    "zz-unmapped": r"zz_unmapped\.py\).*leaves the parameter 'm' of 'zz-good' unmapped",
    "zz-variable": r"zz_variable\.py\).*'q', which 'zz-good' does not have",
    "zz-kind": r"zz_kind\.py: entry 1 of RELATIONS is a str",
    "zz-untupled": r"zz_untupled\.py: RELATIONS is a Relation, not a tuple",
    "zz-label": r"zz_label\.py\): the label is taken in .*zz_label\.py",
    "zz-square": r"zz_square\.py\): there is no relation 'nope'",
    "zz-name": r"zz_name\.py calls itself 'zz-good'; write name='zz-name'",
}


@pytest.fixture(autouse=True)
def own_store(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path_factory.mktemp("cache")
    monkeypatch.setenv("XDG_CACHE_HOME", str(folder))
    return folder


@pytest.fixture
def bad(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A distribution in which all is wrong but one system."""
    site = tmp_path / "site"
    folder = site / "zz_plugin"
    folder.mkdir(parents=True)
    (folder / "__init__.py").write_text("")
    for name, text in BAD.items():
        (folder / f"{name}.py").write_text(text)
    register(site, "zz-plugin", "zz = zz_plugin")
    monkeypatch.syspath_prepend(str(site))
    yield site
    for name in [n for n in sys.modules if n.startswith("zz_plugin")]:
        del sys.modules[name]


# -- what is wrong ----------------------------------------------------------------------------


@pytest.mark.usefixtures("bad")
def test_the_others_still_load_and_every_mistake_is_one_line_with_its_place(call: Call) -> None:
    answer = call("check", "zz-good", *SAYS, "--jobs", "1")
    assert answer.status == 1
    assert "proved" in next(line for line in answer.out.splitlines() if line.endswith(" zz-good"))
    lines = answer.err.splitlines()
    assert len(lines) == len(SAYS)
    for name, pattern in SAYS.items():
        own = [line for line in lines if name.replace("-", "_") + ".py" in line]
        assert len(own) == 1, (name, lines)
        assert re.search(pattern, own[0]), own[0]


@pytest.mark.usefixtures("bad")
def test_list_marks_what_is_wrong_at_sight(call: Call) -> None:
    answer = call("list")
    assert answer.status == 0
    marks = {line.split()[0]: line.split()[-1] for line in answer.out.splitlines()}
    broken = {name for name, mark in marks.items() if mark == "broken"}
    # A false claim and a bad map are seen when they are checked, not at sight.
    assert broken == {*SAYS} - {"zz-false", "zz-unmapped", "zz-variable"}
    assert len(answer.err.splitlines()) == len(broken)
    assert marks["sleigh"] != "broken" != marks["zz-good"]


def test_a_name_that_two_distributions_register_fails(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    register(tmp_path, "zz-other", "sleigh = zz_other:SYSTEM")
    (tmp_path / "zz_other.py").write_text(sled("sleigh"))
    monkeypatch.syspath_prepend(str(tmp_path))
    answer = call("check", "sleigh", "--jobs", "1")
    assert answer.status == 1
    (line,) = answer.err.splitlines()
    assert "zz_other.py" in line and "the name is that of the system in" in line


def test_a_file_is_checked_and_one_that_takes_a_name_fails(call: Call) -> None:
    Path("mine.py").write_text(sled("mine"))
    assert call("check", "mine.py").status == 0
    Path("mine.py").write_text(sled("mine", "s"))
    answer = call("check", "mine.py")
    assert answer.status == 1
    assert "integral 'speed' is refuted" in answer.err and "mine.py" in answer.err
    Path("taken.py").write_text(sled("bicycle"))
    assert "the name is that of the system in" in call("check", "taken.py", "--jobs", "1").err


def test_wrong_words_are_refused(call: Call) -> None:
    assert "did you mean 'sleigh'" in refused(call("check", "slegh"))
    assert "--jobs 0" in refused(call("check", "sleigh", "--jobs", "0"))
    assert "there is no file 'none.py'" in refused(call("check", "none.py"))


# -- what is right ----------------------------------------------------------------------------


def test_a_system_is_checked_with_what_touches_it(call: Call) -> None:
    answer = call("check", "vertical-disc", "--json")
    data = json.loads(answer.out)
    assert answer.status == 0 and data["passed"]
    assert [s["name"] for s in data["systems"]] == ["vertical-disc"]
    assert {f["status"] for f in data["systems"][0]["findings"]} == {"proved"}
    labels = {r["name"] for r in data["relations"]}
    assert labels == {
        r.label
        for r in Inventory.of().relations
        if "vertical-disc" in (r.source, r.target, r.owner)
    }
    assert all(r["notes"] and r["seconds"] >= 0 for r in data["relations"])
    assert data["count"]["proved"] > 10


def test_what_claims_nothing_is_told_so(call: Call) -> None:
    Path("mine.py").write_text(sled("mine").replace('{"speed": velocity(s)}', "{}"))
    answer = call("check", "mine.py")
    assert answer.status == 0
    assert "no claims" in answer.out


def test_an_admitted_doubt_that_is_out_of_date_fails(call: Call) -> None:
    listed = '    undecided={"speed": "why not"},\n)\n'
    Path("mine.py").write_text(sled("mine").rstrip()[:-1] + listed)
    answer = call("check", "mine.py")
    assert answer.status == 1
    assert "listed under undecided=; take it out" in answer.err


@pytest.mark.parametrize(
    ("status", "admitted", "fails"),
    [
        ("proved", "", False),
        ("refuted", "", True),
        ("refuted", "so", True),
        ("undecided", "", True),
        ("undecided", "so", False),
        ("numeric", "", True),
        ("numeric", "so", False),
        ("broken", "so", True),
        ("proved", "so", True),
    ],
)
def test_what_makes_a_check_fail(status: str, admitted: str, fails: bool) -> None:
    finding = Finding("integral", "x", status, admitted=admitted)
    report = Report((Result("system", "s", "file", (finding,)),), 0.0)
    assert finding.fails is fails
    assert report.passed is not fails


def test_chains_are_told_shortly() -> None:
    assert shorten_square("a -> b, b -> c = a -> d, d -> c") == "a -> b -> c = a -> d -> c"
    assert shorten_square("a -> b, upright = a -> d") == "a -> b, upright = a -> d"


# -- processes, and what is kept ---------------------------------------------------------------


def test_two_processes_find_what_one_finds() -> None:
    stock = Inventory.of()
    names = ["vertical-disc", "falling-disc"]

    def found(jobs: int) -> list[tuple[str, str, tuple[Finding, ...]]]:
        report = check_catalogue(names, stock, jobs)
        return [(r.kind, r.name, r.findings) for r in report.results]

    assert found(1) == found(2)


DIES = """
import multiprocessing, os, time
if multiprocessing.parent_process() is not None:
    {act}
"""


def test_a_process_that_dies_takes_only_its_unit_with_it(call: Call) -> None:
    Path("dies.py").write_text(DIES.format(act="os._exit(3)") + sled("dies"))
    answer = call("check", "dies.py", "vertical-disc", "--jobs", "2")
    assert answer.status == 1
    (line,) = answer.err.splitlines()
    assert "'dies' is broken" in line and "ended with status 3" in line
    assert "proved" in next(x for x in answer.out.splitlines() if x.endswith(" vertical-disc"))


def test_ctrl_c_keeps_what_is_finished(tmp_path: Path, own_store: Path) -> None:
    (tmp_path / "slow.py").write_text(DIES.format(act="time.sleep(300)") + sled("slow"))
    process = subprocess.Popen(
        [sys.executable, "-m", "voronec", "check", "slow.py", "vertical-disc", "--jobs", "2"],
        cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env={**os.environ, "HOME": str(own_store)}, start_new_session=True,
        preexec_fn=hears_ctrl_c,
    )  # fmt: skip
    while process.poll() is None and not list(own_store.rglob("result.json")):
        time.sleep(0.1)
    os.killpg(process.pid, signal.SIGINT)
    out, err = process.communicate()
    assert process.returncode == 130
    assert "Traceback" not in err and err.endswith("voronec: stopped\n")
    assert "stopped before the end" in out and "proved" in out


def test_ctrl_c_finds_no_process_that_still_starts(
    capfd: pytest.CaptureFixture[str],
) -> None:
    (unit,) = units_of(Inventory.of(), ["vertical-disc"])[:1]
    worker = Worker.start(Examiner())
    try:
        for _ in range(20):
            os.kill(worker.process.pid, signal.SIGINT)
            time.sleep(0.01)
        assert worker.ask(unit).status == "proved"
    finally:
        worker.end()
    assert capfd.readouterr().err == ""


def test_a_second_check_reuses_and_an_edit_does_not(tmp_path: Path) -> None:
    file, store = tmp_path / "mine.py", Store(tmp_path / "store")
    file.write_text(sled("mine"))

    def reused() -> bool:
        report = check_catalogue(["mine"], Inventory.of([str(file)]), 1, store)
        (result,) = report.results
        assert result.status == "proved"
        return result.reused

    assert [reused(), reused()] == [False, True]
    file.write_text(sled("mine") + "# edited\n")
    assert [reused(), reused()] == [False, True]
    for kept in store.folder.rglob("*.json"):
        kept.write_text('{"kind": 1}')
    with pytest.warns(UserWarning, match="is damaged; it is made anew") as told:
        assert [reused(), reused()] == [False, True]
    assert len(told) == 1


def test_what_was_broken_is_tried_again(tmp_path: Path) -> None:
    store = Store(tmp_path / "store")
    (tmp_path / "mine.py").write_text(sled("mine"))
    stock = Inventory.of([str(tmp_path / "mine.py")])
    (unit,) = units_of(stock, ["mine"])
    broken = Result("system", "mine", "", (Finding("system", "mine", "broken"),))
    store.save(unit.key({}), "result", broken.as_dict())
    (result,) = check_catalogue(["mine"], stock, 1, store).results
    assert result.status == "proved" and not result.reused


def test_a_correction_says_where_it_is_printed_wrongly(call: Call) -> None:
    wrong = 'Corrected(velocity(s), printed=s, source="Nobody1900")'
    Path("mine.py").write_text("from voronec import Corrected\n" + sled("mine", wrong))
    answer = call("check", "mine.py")
    assert answer.status == 0
    assert "integral speed  refuted as printed in Nobody1900" in answer.out


def test_another_engine_is_another_check(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file, store = tmp_path / "mine.py", Store(tmp_path / "store")
    file.write_text(sled("mine"))
    stock = Inventory.of([str(file)])
    check_catalogue(["mine"], stock, 1, store)
    monkeypatch.setattr(sources, "engine_digest", lambda modules: "another")
    assert not check_catalogue(["mine"], stock, 1, store).results[0].reused


def test_fresh_reuses_nothing(call: Call) -> None:
    Path("mine.py").write_text(sled("mine"))
    call("check", "mine.py")
    assert "known" in call("check", "mine.py").out
    assert "known" not in call("check", "mine.py", "--fresh").out


def test_only_so_many_results_are_kept(tmp_path: Path) -> None:
    store = Store(tmp_path / "few", capacity=2)
    for number in range(5):
        store.save(f"{number}" * 24, "result", number)
    assert len(list(store.folder.iterdir())) == 2
    assert store.load("4" * 24, "result") == 4


def test_the_members_of_a_file_are_checked_too(call: Call) -> None:
    more = "MEMBERS = {'good': lambda: made('family@good', 'v'), 'bad': lambda: 1 / 0}\n"
    text = sled("family") + (
        "from dataclasses import replace\n"
        "def made(name, _):\n"
        "    return replace(SYSTEM, name=name, lagrangian=2 * SYSTEM.lagrangian)\n"
    )
    Path("family.py").write_text(text + more)
    answer = call("check", "family.py", "--jobs", "1", "--fresh")
    assert answer.status == 1
    assert any(x.endswith(" family@good") and "proved" in x for x in answer.out.splitlines())
    assert "family@bad" in answer.err and "ZeroDivisionError" in answer.err
    Path("family.py").write_text(text + "MEMBERS = 3\n")
    Path("mine.py").write_text(sled("mine"))
    answer = call("check", "family.py", "mine.py", "--jobs", "1")
    assert answer.status == 1 and "MEMBERS is no mapping" in answer.err
    lines = answer.out.splitlines()
    assert any(x.startswith("  proved") and "mine" in x for x in lines)
    assert sum("broken" in x and x.rstrip().endswith("family") for x in lines) == 1


@pytest.mark.parametrize(
    "text", [b"# coding: latin-1\ns = '\xe9'\n", b"s = '\xe9'\n", b"print 1\n"]
)
def test_a_library_that_cannot_be_read_counts_by_its_bytes(tmp_path: Path, text: bytes) -> None:
    library, own = tmp_path / "library.py", tmp_path / "mine.py"
    library.write_bytes(text)
    own.write_text("import library\n")
    assert sources.closure([own]) == {own, library}
    before = sources.digest("", [own, library], "voronec.errors")
    library.write_bytes(text + b"# more\n")
    assert sources.digest("", [own, library], "voronec.errors") != before


def test_a_bad_case_is_a_finding_about_that_case(
    call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where the engine itself fails on it: everything else is checked."""
    import voronec.proof.claims as claims

    special = claims.case_of

    def failing(system: Any, case: Any) -> Any:
        if case.note == "fails":
            raise ZeroDivisionError("nobody thought of it")
        return special(system, case)

    monkeypatch.setattr(claims, "case_of", failing)
    cases = "{'heavy': vo.Case({m: 2}, integrals={'e': SYSTEM.lagrangian}), "
    cases += "'none': vo.Case({m: 0}, integrals={'e': SYSTEM.lagrangian}), "
    cases += "'lost': vo.Case({m: 3}, note='fails')}"
    text = sled("cased") + "from dataclasses import replace\nimport voronec as vo\n"
    text += f"SYSTEM = replace(SYSTEM, cases={cases})\n"
    Path("cased.py").write_text(text)
    answer = call("check", "cased.py", "--jobs", "1", "--fresh", "--json")
    (system,) = json.loads(answer.out)["systems"]
    found = {f["name"]: f for f in system["findings"]}
    assert found["lost"]["status"] == "broken" and "nobody thought" in found["lost"]["how"]
    assert found["none"]["status"] == "refuted"
    assert found["heavy: e"]["status"] == "proved"
    others = [f for n, f in found.items() if n not in ("lost", "none")]
    assert others and all(f["status"] == "proved" for f in others)


def test_a_family_is_checked_with_its_members() -> None:
    stock = Inventory.of()
    names = {u.name for u in units_of(stock, ["veselova-in-rn"]) if u.kind == "system"}
    assert names == {"veselova-in-rn", *stock.members_of("veselova-in-rn")} and len(names) > 1


def test_what_list_tells_is_kept_until_a_file_changes(
    call: Call, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    site = tmp_path / "titles"
    (site / "zy_plugin").mkdir(parents=True)
    (site / "zy_plugin/__init__.py").write_text("")
    file = site / "zy_plugin/zy_one.py"
    file.write_text(sled("zy-one").replace('name="zy-one"', 'name="zy-one", title="First"'))
    register(site, "zy-plugin", "zy = zy_plugin")
    monkeypatch.syspath_prepend(str(site))
    first = call("list")
    assert first.status == 0 and "First" in first.out
    known = set(sys.modules)
    assert call("list").out == first.out
    with monkeypatch.context() as inside:
        inside.setattr("voronec.declaration.catalogue.Entry.load", None)  # nothing is loaded
        assert call("list").out == first.out and set(sys.modules) == known
    del sys.modules["zy_plugin.zy_one"]
    file.write_text(file.read_text().replace("First", "Second"))
    assert "Second" in call("list").out


def test_what_is_known_is_told_without_loading_a_system(
    call: Call, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    site = tmp_path / "kept"
    (site / "zx_plugin").mkdir(parents=True)
    (site / "zx_plugin/__init__.py").write_text("")
    file = site / "zx_plugin/zx_one.py"
    relation = "Relation('zx-one', 'zx-one', parameters={m: m}, name='itself')"
    beside = f"RELATIONS = ({relation},)\n"
    file.write_text(
        sled("zx-one").replace('name="zx-one"', 'name="zx-one", title="First"') + beside
    )
    register(site, "zx-plugin", "zx = zx_plugin")
    monkeypatch.syspath_prepend(str(site))
    commands = [["check", "zx-one", "--jobs", "1"], ["show", "zx-one"], ["cite", "zx-one"]]
    commands += [["graph", "zx-one"], ["show", "zx-one", "--json"]]

    def told() -> list[tuple[int, str, str]]:
        answers = [call(*words) for words in commands]
        times = r"(known|\d+\.\d+ s)| +(?= )"  # the seconds, and the width of their column
        return [(a.status, re.sub(rf"{times} *", "", a.out), a.err) for a in answers]

    first = told()
    assert [status for status, *_ in first] == [0] * len(commands)
    assert "itself" in first[0][1] and "proved" in first[3][1] and "First" in first[4][1]
    known = set(sys.modules)
    with monkeypatch.context() as inside:
        inside.setattr("voronec.declaration.catalogue.Entry.load", None)
        inside.setattr("voronec.declaration.catalogue.Entry.load_relations", None)
        assert told() == first and set(sys.modules) == known
    del sys.modules["zx_plugin.zx_one"]
    file.write_text(file.read_text().replace("First", "Second"))
    assert "Second" in call("show", "zx-one").out
    assert "known" not in call("check", "zx-one", "--jobs", "1").out
