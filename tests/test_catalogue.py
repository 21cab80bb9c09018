"""Systems are found without running anybody's code, by one door for us and for others."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
import sympy as sp
from plugins import install, register

import voronec as vo
from voronec.algebra.symbols import plain_name, velocity
from voronec.declaration import catalogue
from voronec.declaration.catalogue import members
from voronec.testing import names_are_fine

ROOT = Path(__file__).parents[1]
PLUGIN = Path(__file__).parent / "plugin_package"


@pytest.fixture
def plugin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The plugin as it is found when installed: importable, with its entry points."""
    install(tmp_path, "voronec-plugin", PLUGIN / "pyproject.toml")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.syspath_prepend(str(PLUGIN))
    yield tmp_path
    for name in [n for n in sys.modules if n.startswith("voronec_plugin")]:
        del sys.modules[name]


def test_every_module_of_the_folder_is_a_system_under_its_own_name() -> None:
    stems = {p.stem if p.suffix else p.name for p in (ROOT / "systems").iterdir()}
    expected = {s.replace("_", "-") for s in stems if not s.startswith(("_", "."))}
    assert set(vo.names()) >= expected
    for name in expected:
        assert vo.load(name).name == name


def test_names_are_listed_without_loading_sympy_or_a_system() -> None:
    code = (
        "import sys, voronec; names = voronec.names(); assert 'sleigh' in names;"
        "heavy = {'sympy', 'numpy', 'voronec.systems'} & set(sys.modules);"
        "assert not heavy, heavy"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=Path(sys.prefix))


def test_papers_are_found_beside_their_systems() -> None:
    assert catalogue.papers() == ["chaplygin-ball", "demchenko"]
    assert catalogue.load_paper("demchenko").name == "demchenko"
    with pytest.raises(vo.DefinitionError, match=r"no paper 'demchenk'.*'demchenko'"):
        catalogue.load_paper("demchenk")


@pytest.mark.parametrize(
    ("wrong", "nearest"), [("slegh", "sleigh"), ("Sleigh", "sleigh"), ("disc", "vertical-disc")]
)
def test_an_unknown_name_is_answered_with_the_nearest(wrong: str, nearest: str) -> None:
    with pytest.raises(vo.DefinitionError, match=f"no system '{wrong}'.*'{nearest}'"):
        vo.load(wrong)


def test_a_name_near_nothing_is_answered_with_all_names() -> None:
    with pytest.raises(vo.DefinitionError, match=r"there are: .*sleigh"):
        vo.load("zzzzzz")


@pytest.mark.usefixtures("plugin")
def test_a_plugin_is_listed_without_being_imported() -> None:
    listed = {name for name in vo.names() if "plugin" in name or "shared" in name}
    assert listed == {"plugin-hoop", "plugin-broken", "plugin-sled", "plugin-lost"}
    assert not [name for name in sys.modules if name.startswith("voronec_plugin")]


@pytest.mark.usefixtures("plugin")
def test_a_plugin_loads_from_a_folder_and_by_its_object() -> None:
    assert vo.load("plugin-hoop").title == "A hoop on a line"
    assert vo.load("plugin-sled").title == "A sled on a straight track"


@pytest.mark.usefixtures("plugin")
def test_a_broken_plugin_says_where_it_broke() -> None:
    with pytest.raises(
        vo.DefinitionError, match=r"plugin_broken\.py, line 3: RuntimeError: this module fails"
    ):
        vo.load("plugin-broken")
    with pytest.raises(vo.DefinitionError, match=r"'voronec_plugin\.nowhere'.*is not found"):
        vo.load("plugin-lost")


def test_a_plugin_cannot_hide_a_system_of_ours(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    register(tmp_path, "aaa-plugin", "sleigh = voronec_plugin.single:SLED")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.syspath_prepend(str(PLUGIN))
    assert vo.load("sleigh").title == "Chaplygin sleigh"
    (warning,) = catalogue.entries()[1]
    assert "'sleigh' of 'aaa-plugin' is hidden" in warning


def test_an_entry_point_that_names_no_folder_is_marked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    register(tmp_path, "odd-plugin", "odd = json.decoder")
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(vo.DefinitionError, match=r"'odd'.*is not a folder of modules"):
        vo.load("odd")


def test_a_file_is_loaded_with_its_neighbours(tmp_path: Path) -> None:
    (tmp_path / "neighbour_of_mine.py").write_text("MASS = 3\n")
    sled = (PLUGIN / "voronec_plugin" / "single.py").read_text()
    text = sled.replace("SLED =", "from neighbour_of_mine import MASS\nSYSTEM =")
    (tmp_path / "mine.py").write_text(text)
    before = list(sys.path)
    assert catalogue.load_file(tmp_path / "mine.py").name == "plugin-sled"
    assert sys.path == before


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x = 1\ny = (\n", r"file\.py, line 2: '\(' was never closed"),
        ("x = 1\nx.y\n", r"file\.py, line 2: AttributeError: 'int' object has no attribute 'y'"),
        ("def f():\n    1 / 0\n\nf()\n", r"file\.py, line 2: ZeroDivisionError"),
        ("import sympy\n\nsympy.diff(1, 2)\n", r"file\.py, line 3: ValueError"),
        ("raise SystemExit(3)\n", r"file\.py, line 1: SystemExit: 3"),
        ("x = 1\n", r"file\.py defines no SYSTEM"),
        ("SYSTEM = 'sleigh'\n", r"file\.py defines SYSTEM as a str"),
        ("x = 1\0\n", r"file\.py"),
        ("# coding: klingon\n", r"file\.py"),
    ],
)
def test_a_file_that_fails_is_told_with_its_line(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "file.py"
    path.write_text(text)
    with pytest.raises(vo.DefinitionError, match=message) as caught:
        catalogue.load_file(path)
    assert "\n" not in str(caught.value)


def test_a_file_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    with pytest.raises(vo.DefinitionError, match="there is no file"):
        catalogue.load_file(tmp_path / "none.py")
    with pytest.raises(vo.DefinitionError, match="is a folder"):
        catalogue.load_file(tmp_path)
    (tmp_path / "latin.py").write_bytes(b"x = '\xe9'\n")
    with pytest.raises(vo.DefinitionError, match=r"latin\.py"):
        catalogue.load_file(tmp_path / "latin.py")


def test_every_coordinate_velocity_and_integral_is_said_in_words() -> None:
    for name in vo.names():
        for full in (name, *(f"{name}@{member}" for member in members(name))):
            system = vo.load(full)
            frame = system.frame.ambient if system.frame is not None else ()
            dots = {plain_name(velocity(q)) for q in system.coordinates}
            named = {plain_name(q) for q in (*system.coordinates, *frame)} - dots
            silent = (named | {*system.integrals} - {"energy"}) - {*system.meanings}
            assert not silent, f"{full}: {sorted(silent)}"
            assert len({*system.meanings.values()}) > 1, full


def test_meanings_are_words() -> None:
    x = sp.Symbol("x")
    with pytest.raises(vo.DefinitionError, match="the meaning of 'x' is ''; give words"):
        vo.System(name="a", fibration=vo.Fibration(x), lagrangian=x, meanings={x: ""})


def test_conformance_asks_what_meanings_are_of(tmp_path: Path) -> None:
    file = tmp_path / "point.py"
    file.write_text(
        "import sympy as sp\nimport voronec as vo\nx = sp.Symbol('x')\n"
        "SYSTEM = vo.System(name='point', title='Point', fibration=vo.Fibration(x),\n"
        "    lagrangian=vo.velocity(x)**2, scenes={'default': vo.Scene({x: 1})},\n"
        "    meanings={'y': 'nothing'})\n"
    )
    with pytest.raises(AssertionError, match="meanings explain 'y', which is no coordinate"):
        names_are_fine(str(file))
