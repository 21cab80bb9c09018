"""What is installed: wheel and editable, the plugin of somebody else, one bibliography."""

from __future__ import annotations

import doctest
import json
import re
import runpy
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import tomllib
from collections.abc import Iterable
from importlib import metadata
from itertools import chain
from pathlib import Path

import pytest
from tool_modules import tool

import voronec as vo
from voronec.cli import main

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[1]
PLUGIN = ROOT / "tests" / "plugin_package"
SHIPPED = (
    "pyproject.toml", "setup.py", "README.md", "LICENSE", "MANIFEST.in", "CITATION.cff",
    "CHANGELOG.md", "voronec", "systems", "docs", "tests", "tools",
)  # fmt: skip


def copied(folder: Path) -> Path:
    """The sources in another place, for a build leaves traces beside them."""
    skip = shutil.ignore_patterns("__pycache__", "*.egg-info")
    for name in SHIPPED:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, folder / name, ignore=skip)
        else:
            shutil.copy(source, folder)
    return folder


def pip(*words: str | Path) -> None:
    command = [sys.executable, "-m", "pip", "-q", "--disable-pip-version-check", *map(str, words)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def environment(folder: Path) -> Path:
    """A virtual environment that sees the libraries of this one, but not its voronec."""
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder], check=True)
    (site,) = folder.glob("lib/python*/site-packages")
    # A path listed in a .pth file is searched, but .pth files in it (an editable voronec) are not
    # read; a voronec installed there as a wheel comes later on the path than the one under test.
    libraries = {sysconfig.get_path("purelib"), sysconfig.get_path("platlib")}
    (site / "libraries.pth").write_text("\n".join(sorted(libraries)) + "\n")
    return folder


def install(home: Path, *what: str | Path) -> None:
    options = ("install", "--no-deps", "--no-index", "--no-build-isolation")
    pip("--python", home / "bin" / "python", *options, *what)


def voronec(home: Path, *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [home / "bin" / "voronec", *words], cwd=home, capture_output=True, text=True, check=False
    )


@pytest.fixture(scope="module")
def sources(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return copied(tmp_path_factory.mktemp("sources"))


@pytest.fixture(scope="module")
def wheel_home(sources: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An environment with the wheel and the plugin."""
    made = tmp_path_factory.mktemp("wheels")
    plugin = shutil.copytree(PLUGIN, made / "plugin")
    pip("wheel", "--no-deps", "--no-index", "--no-build-isolation", "-w", made, sources, plugin)
    home = environment(made / "home")
    install(home, *made.glob("*.whl"))
    return home


@pytest.fixture(scope="module")
def editable_home(sources: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    home = environment(tmp_path_factory.mktemp("editable") / "home")
    install(home, "-e", sources)
    return home


def data_files(package: Path) -> set[Path]:
    """What stands beside the code, and is read by it: pages, styles, examples."""
    files = (p for p in package.rglob("*") if p.is_file() and p.suffix not in (".py", ".pyc"))
    return {p.relative_to(package) for p in files}


def own(names: Iterable[str]) -> set[str]:
    return {name for name in names if not name.startswith("plugin-")}


def test_the_wheel_brings_systems_bibliography_and_types(wheel_home: Path) -> None:
    assert own(voronec(wheel_home, "list", "--names").stdout.split()) == own(vo.names())
    assert "  vdot " in voronec(wheel_home, "derive", "sleigh").stdout
    assert voronec(wheel_home, "cite", "sleigh").stdout.startswith("@article{Chaplygin1911")
    (site,) = wheel_home.glob("lib/python*/site-packages")
    inside = {p.name for p in site.iterdir()}
    assert "voronec" in inside
    assert not {"systems", "docs", "tests", "tools"} & inside
    assert (site / "voronec" / "py.typed").is_file()
    assert (site / "voronec" / "systems" / "demchenko" / "paper" / "__init__.py").is_file()
    docs = {p.name for p in (site / "voronec" / "docs").iterdir()} - {"__pycache__"}
    assert docs == {"__init__.py", "references.bib"}
    references = {Path("accuracy", "hard", "references.json")}  # of benchmarks: none in wheels
    assert not references & data_files(site / "voronec")
    assert data_files(ROOT / "voronec") - references <= data_files(site / "voronec")


def test_a_plugin_package_is_found_like_our_own(wheel_home: Path) -> None:
    answer = voronec(wheel_home, "list", "--json")
    rows = {row["name"]: row for row in json.loads(answer.stdout)["systems"]}
    assert rows["plugin-hoop"]["distribution"] == "voronec-plugin"
    assert rows["plugin-sled"]["trouble"] == ""
    assert "phiddot" in voronec(wheel_home, "derive", "plugin-hoop").stdout
    assert "{On hoops}" in voronec(wheel_home, "cite", "plugin-hoop").stdout


def test_a_broken_plugin_is_a_warning_and_a_mark(wheel_home: Path) -> None:
    answer = voronec(wheel_home, "list")
    assert answer.returncode == 0
    marks = {line.split()[0]: line.split("  ")[-1] for line in answer.stdout.splitlines()}
    assert marks["plugin-broken"].strip() == "broken"
    assert marks["plugin-lost"].strip() == "broken"
    assert marks["plugin-sled"].strip() == "no claims, from voronec-plugin"
    warnings = answer.stderr.splitlines()
    assert len(warnings) == 2
    assert all(line.startswith("voronec: warning: system 'plugin-") for line in warnings)
    assert voronec(wheel_home, "show", "plugin-broken").returncode == 2


def test_an_editable_install_sees_a_new_file_at_once(editable_home: Path, sources: Path) -> None:
    assert own(voronec(editable_home, "list", "--names").stdout.split()) == own(vo.names())
    new = sources / "systems" / "new_sled.py"
    text = (PLUGIN / "voronec_plugin" / "single.py").read_text()
    new.write_text(text.replace("SLED", "SYSTEM").replace('"plugin-sled"', '"new-sled"'))
    try:
        assert "A sled on a straight track" in voronec(editable_home, "show", "new-sled").stdout
    finally:
        new.unlink()
    assert voronec(editable_home, "cite", "sleigh").stdout.startswith("@article{Chaplygin1911")


def test_the_source_distribution_holds_what_is_built_and_no_tests(
    sources: Path, tmp_path: Path
) -> None:
    build = "from setuptools import build_meta; build_meta.build_sdist(__import__('sys').argv[1])"
    command = [sys.executable, "-c", build, str(tmp_path)]
    subprocess.run(command, cwd=sources, check=True, capture_output=True)
    (archive,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(archive) as inside:
        names = {name.partition("/")[2] for name in inside.getnames()}
        about = inside.extractfile(f"{archive.name.removesuffix('.tar.gz')}/PKG-INFO")
        assert about is not None
        said = about.read().decode()
    assert {"LICENSE", "CITATION.cff", "CHANGELOG.md", "systems/sleigh.py"} <= names
    assert not {name for name in names if name.startswith(("tests", "tools", "docs/systems"))}
    assert "License-Expression: MIT" in said
    assert "License ::" not in said
    assert "Description-Content-Type: text/markdown" in said and "# Voronec" in said
    assert "how to ... (docs/how-to/index.md)" in said and not re.search(r"\]\((?!https?:)", said)


def test_links_of_the_readme_lead_to_the_address_of_the_project() -> None:
    absolute = runpy.run_path(str(ROOT / "setup.py"))["absolute"]
    text = "[a](docs/a.md#b) ![p](p.svg) [c](https://c.d/e) [LICENSE](LICENSE)"
    assert absolute(text, "") == "a (docs/a.md#b)  [c](https://c.d/e) LICENSE"
    assert absolute(text, "https://h.i/r/") == (
        "[a](https://h.i/r/blob/main/docs/a.md#b) ![p](https://h.i/r/raw/main/p.svg) "
        "[c](https://c.d/e) [LICENSE](https://h.i/r/blob/main/LICENSE)"
    )


def test_the_recipe_asks_for_what_the_project_asks_for() -> None:
    recipe = (ROOT / "conda" / "recipe.yaml").read_text()
    asked = dict(re.findall(r"^    - ([\w.-]+) >=([\d.]+)$", recipe, re.MULTILINE))
    called = {"matplotlib": "matplotlib-base", "symengine": "python-symengine"}
    called["heyoka"] = "heyoka.py"
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    for requirement in project["dependencies"]:
        name, bound = re.split(r"[>=;]+", requirement)[:2]
        assert asked[called.get(name, name)] == bound
    assert f'version: "{vo.__version__}"' in recipe
    assert asked["python"] == project["requires-python"].removeprefix(">=")


def test_the_lower_bounds_can_be_installed_exactly() -> None:
    bounds = tool("bounds")
    lowest, newest = map(bounds.requirements, bounds.ENDS)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert {*project["dependencies"], *project["optional-dependencies"]["test"]} <= {*newest}
    assert len(lowest) == len(newest)
    for pin, asked in zip(lowest, newest, strict=True):
        assert re.fullmatch(r"[\w-]+==[\d.]+(; .*)?", pin), "one lower bound, and nothing else"
        assert pin.replace("==", ">=", 1) == asked


CITATION = (
    "cff-version", "message", "type", "title", "version", "license", "authors", "abstract",
    "keywords", "date-released", "repository-code", "url", "doi", "identifiers", "references",
    "contact", "commit", "license-url", "preferred-citation", "repository", "repository-artifact",
)  # fmt: skip
"""The keys that version 1.2.0 of the Citation File Format knows."""


def test_the_citation_has_what_its_format_asks_for() -> None:
    text = (ROOT / "CITATION.cff").read_text()
    found = dict(re.findall(r"^([\w-]+):(.*)$", text, re.MULTILINE))
    assert found.keys() >= {"cff-version", "message", "title", "authors"}
    assert found.keys() <= {*CITATION}
    assert found["cff-version"].strip() == "1.2.0"
    assert found["type"].strip() in ("software", "dataset")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert found["license"].strip() == project["license"]
    assert re.findall(r'^  - name: "(.*)"$', text, re.MULTILINE) == [
        author["name"] for author in project["authors"]
    ]


def test_the_constraints_pin_every_requirement() -> None:
    pinned = dict(
        line.split("==")
        for line in (ROOT / "constraints.txt").read_text().splitlines()
        if not line.startswith("#")
    )
    names = {re.sub(r"[-_.]+", "-", name).lower() for name in pinned}
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = chain.from_iterable(project["optional-dependencies"].values())
    for requirement in chain(project["dependencies"], extras):
        name = re.split(r"[\[>=;]", requirement)[0]
        assert name == "voronec" or name in names


def test_the_version_is_one() -> None:
    citation = (ROOT / "CITATION.cff").read_text()
    assert metadata.version("voronec") == vo.__version__
    assert f"version: {vo.__version__}" in citation


def test_every_key_that_code_and_documents_cite_is_in_the_bibliography() -> None:
    bibliography = (ROOT / "docs" / "references.bib").read_text("utf-8")
    known = {*re.findall(r"^@\w+\{(\w+),", bibliography, re.MULTILINE)}
    cited = {}
    for folder in ("voronec", "systems", "docs", "tests", "tools"):
        for path in (ROOT / folder).rglob("*"):
            if path.suffix in (".py", ".md"):
                for key in re.findall(
                    r"\[([A-Z][A-Za-z]+\d{4}[a-z]?)[\],]", path.read_text("utf-8")
                ):
                    cited[key] = path
    assert not {key: path for key, path in cited.items() if key not in known}


# -- the README --------------------------------------------------------------------------------


def blocks(language: str) -> list[str]:
    text = (ROOT / "README.md").read_text("utf-8")
    return re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)


def test_the_examples_of_the_readme_say_what_they_print() -> None:
    example = "\n".join(blocks("python"))
    test = doctest.DocTestParser().get_doctest(example, {}, "README", "README.md", 0)
    runner = doctest.DocTestRunner()
    runner.run(test)
    assert test.examples
    assert runner.failures == 0


def test_the_command_of_the_readme_prints_what_it_shows(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    (command,) = blocks("console")
    (shown,) = blocks("text")
    main(command.removeprefix("$ voronec").split())
    assert capsys.readouterr().out == shown


def test_two_commands_set_up_and_continuous_integration_runs_the_second() -> None:
    first, second = (block.strip() for block in blocks("sh"))
    assert "voronec regenerate demchenko" in first
    assert "-m pytest" in second
    assert "\n" not in first + second
    assert "grep -m 1 -e '-m pytest' README.md" in (ROOT / ".ci" / "run").read_text()


def test_no_file_names_the_host_of_a_package_index() -> None:
    tracked = [ROOT / n for n in ("pyproject.toml", "constraints.txt", "README.md", ".ci/run")]
    for path in tracked:
        assert not re.search(r"index-url|find-links|pypi|https?://", path.read_text()), path
