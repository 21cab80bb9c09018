"""Claims on the command line: a false one is shown, and the exit status tells."""

from __future__ import annotations

import json
import warnings
from itertools import groupby
from pathlib import Path

import pytest
from command_line import Call

from voronec.cli import main

pytestmark = pytest.mark.slow

SOURCE = """
import sympy as sp
from voronec import Fibration, Scene, System, velocity

x, y, phi = sp.symbols("x y phi")
m = sp.Symbol("m")
Dx, Dy, Dphi = map(velocity, (x, y, phi))
energy = (Dx**2 + Dy**2 + Dphi**2) / 2
SYSTEM = System(
    name="skate",
    fibration=Fibration(base=(x, phi), fibre=(y,)),
    lagrangian=energy,
    constraints=(Dy - Dx * sp.sin(phi),),
    integrals={"energy": energy, %s},
    invariants={"c": %s},
    scenes={"default": Scene(initial={Dx: 1, Dphi: 2}, times=(0.0, 1.0))},
)
"""


def write(folder: Path, integral: str, invariant: str) -> str:
    path = folder / "skate.py"
    path.write_text(SOURCE % (integral, invariant))
    return str(path)


def test_a_refuted_claim_is_shown_and_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write(tmp_path, '"place": x', "sp.cos(phi)")
    assert main(["derive", path]) == 1
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["integral", "energy", "proved"] in lines and ["integral", "place", "refuted"] in lines
    assert main(["derive", path, "--json"]) == 1
    claims = {c["name"]: c["verdict"] for c in json.loads(capsys.readouterr().out)["claims"]}
    assert claims["energy"] == "proved" and claims["place"] == "refuted"


def test_what_does_not_descend_hides_no_equations(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write(tmp_path, '"spin": Dphi', "sp.cos(y)")
    main(["derive", path])
    out = capsys.readouterr().out
    assert "equations of motion" in out and "descent to c: refuted" in out
    main(["derive", path, "--json"])
    data = json.loads(capsys.readouterr().out)
    assert data["mass"] and "not a function of the invariants" in data["descent"]["refused"]


def test_a_run_whose_integral_is_none_fails(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    path = write(tmp_path, '"place": 1 + x', "sp.cos(phi)")
    assert main(["run", path, "--method", "scipy"]) == 1
    told = capsys.readouterr().err
    assert "the integral 'place' drifts far beyond the tolerance" in told and "has no value" in told
    assert main(["run", write(tmp_path, '"spin": Dphi', "sp.cos(phi)"), "--method", "scipy"]) == 0


def test_warnings_are_one_line_without_code(monkeypatch: pytest.MonkeyPatch) -> None:
    """As of a damaged cache: two lines told the file and the line of the engine, too."""
    told: list[str] = []

    def execute(_: object) -> int:
        told.append(warnings.formatwarning("damaged", UserWarning, "packs.py", 64))  # type: ignore[arg-type]
        return 0

    monkeypatch.setattr("voronec.cli.listing.execute", execute)
    assert main(["list"]) == 0 and told == ["voronec: warning: damaged\n"]


def test_a_large_system_is_told_by_its_size(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["derive", "bicycle"]) == 0
    out = capsys.readouterr().out
    assert "too large for the exact normal form" in out and len(out) < 3000
    assert main(["derive", "bicycle", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["operations"] < 1500 and "def " in data["program"] and "mass" not in data


def test_derive_tells_on_a_terminal_what_it_is_at(
    call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    told: list[str] = []
    for module in ("derivation", "output"):
        monkeypatch.setattr(f"voronec.cli.{module}.progress", told.append)
    assert call("derive", "sleigh").status == 0
    stages = [stage for stage, _ in groupby(filter(None, told))]
    assert stages[:4] == [
        "sleigh: the equations of motion", "sleigh: kind, growth and curvature",
        "sleigh: integral energy", "sleigh: integral heading",
    ]  # fmt: skip
    assert "sleigh: case centre of mass over the blade" in told and told[-2:] == ["", ""]
    assert call("derive", "sleigh", "--json").status == 0
    assert told[-3:] == ["sleigh: the short form of the equations", "", ""]
