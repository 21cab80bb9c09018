"""A kind of claim, a method of integration, a printer: each is added by one record in one place."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp
from command_line import Call, refused

import voronec as vo
from voronec.equations.printers import PRINTERS, Printer
from voronec.motion.methods import METHODS, Method
from voronec.motion.steppers import Integrator, Problem
from voronec.motion.steppers.scipy_stepper import dop853

pytestmark = pytest.mark.slow

FILE = """
import sympy as sp
import voronec as vo
from voronec.proof.decision import all_zero

s, k, m = sp.symbols("s k m")


def steady(motions, functions):
    field = motions.field_for(functions)
    rates = field.derivatives([field.read_with_momenta(f) for f in functions])
    return all_zero([("", rate) for rate in rates], field.hypotheses)


v = vo.velocity(s)
SYSTEM = vo.System(
    name="mine",
    fibration=vo.Fibration(base=(s,), fibre=()),
    lagrangian=m * v**2 / 2 - k * s**2 / 2,
    parameters=(vo.Parameter(m, 1), vo.Parameter(k, 1)),
    integrals={"energy": m * v**2 + k * s**2},
    assertions={
        "energy": vo.Assertion("steady", (m * v**2 + k * s**2,), steady),
        "speed": ASSERTED,
    },
    cases={"free": vo.Case({k: 0}, assertions={"speed": vo.Assertion("steady", (v,), steady)})},
)
"""
WRONG = 'vo.Assertion("steady", (v,), steady)'
RIGHT = f'vo.Corrected(vo.Assertion("steady", (k, m), steady), {WRONG}, "Nobody1900")'


@pytest.fixture(autouse=True)
def own_store(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))


def test_a_kind_of_claim_is_one_record(call: Call) -> None:
    Path("mine.py").write_text(FILE.replace("ASSERTED", WRONG))
    answer = call("check", "mine.py", "--json", "--jobs", "1")
    (system,) = json.loads(answer.out)["systems"]
    found = {(f["kind"], f["name"]): f["status"] for f in system["findings"]}
    assert answer.status == 1 and "steady 'speed' is refuted" in answer.err
    assert found["steady", "energy"] == found["integral", "energy"] == "proved"
    assert found["steady", "speed"] == "refuted"
    assert found["steady", "free: speed"] == "proved"
    assert "steady" in call("show", "mine.py").out and "steady" in call("derive", "mine.py").out


def test_it_may_be_corrected(call: Call) -> None:
    Path("mine.py").write_text(FILE.replace("ASSERTED", RIGHT))
    answer = call("check", "mine.py", "--jobs", "1")
    assert answer.status == 0 and "refuted as printed in Nobody1900" in answer.out
    (claim,) = (
        c for c in json.loads(call("show", "mine.py", "--json").out)["claims"] if "printed" in c
    )
    assert claim["statement"] == "k, m" and claim["kind"] == "steady"


def proved(motions: Any, expressions: Any) -> Any:
    return vo.prove_equal(expressions[0], expressions[0])


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda x: vo.Assertion("integral", (x,), proved), "none of"),
        (lambda x: vo.Assertion("two words", (x,), proved), "a word of letters"),
        (lambda x: vo.Assertion("own", (x,), "proved"), "give a function"),
        (lambda x: x, r"write Assertion\(kind, expressions, decide\)"),
        (lambda x: vo.Assertion("own", (sp.Symbol("nope"),), proved), "nope"),
    ],
)
def test_wrong_assertions_are_refused(make: Any, says: str) -> None:
    x = sp.Symbol("x")
    with pytest.raises(vo.DefinitionError, match=says):
        vo.System(
            name="one",
            fibration=vo.Fibration(base=(x,), fibre=()),
            lagrangian=vo.velocity(x) ** 2,
            assertions={"a": make(x)},
        )


def test_what_decides_returns_a_verdict() -> None:
    x = sp.Symbol("x")
    system = vo.System(
        name="one",
        fibration=vo.Fibration(base=(x,), fibre=()),
        lagrangian=vo.velocity(x) ** 2,
        assertions={"a": vo.Assertion("own", (x,), lambda motions, expressions: True)},
    )
    (claim,) = vo.check_claims(system)
    assert claim.verdict.refuted and "return a Verdict" in claim.verdict.method


def test_a_method_is_one_line(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []

    def make(problem: Problem) -> Integrator:
        asked.append(problem.tol)
        return dop853(problem)

    assert "there are: auto, c, " in refused(call("run", "sleigh", "--method", "mine"))
    monkeypatch.setitem(METHODS, "mine", Method(make, finest=1e-9))
    sleigh = vo.load("sleigh")
    grid = np.linspace(0, 1, 5)
    found = vo.integrate(sleigh, times=grid, method="mine", tol=1e-12)
    assert found.cost.method == "mine" and asked == [1e-9]
    same = vo.integrate(sleigh, times=grid, method="scipy", tol=1e-9)
    assert np.array_equal(found["x"], same["x"])
    assert call("run", "sleigh", "--method", "mine", "--times", "1").status == 0
    assert "mine" in call("run", "--help").out
    with pytest.raises(vo.DefinitionError, match="closed-form, mine"):
        vo.integrate(sleigh, times=grid, method="nobody's")


def test_a_printer_is_one_line(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    assert call("derive", "sleigh", "--words").status == 2
    printer = Printer(
        "the equations in words", lambda eqs: f"{eqs.system.name}, of {eqs.kind} kind"
    )
    monkeypatch.setitem(PRINTERS, "words", printer)
    assert call("derive", "sleigh", "--words").out == "sleigh, of chaplygin kind\n"
    assert json.loads(call("derive", "sleigh", "--words", "--json").out).keys() == {"words"}
    assert "the equations in words" in call("derive", "--help").out
