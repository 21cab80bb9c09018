"""``voronec search KIND``: what it prints, its statuses, its refusals."""

from __future__ import annotations

import json

import pytest
import sympy as sp
from command_line import Call, refused

from voronec.algebra.text import formula
from voronec.proof import search

pytestmark = pytest.mark.slow


def test_what_is_found_is_printed_with_its_proof_and_the_statement(call: Call) -> None:
    answer = call("search", "integrals", "chaplygin-ball", "--again", "--degree", "1")
    assert answer.status == 0 and answer.err == ""
    lines = answer.out.splitlines()
    assert "  F1 = I1*gamma1*omega1 + I2*gamma2*omega2 + I3*gamma3*omega3" in lines
    assert "     proved" in lines
    assert lines[-1].startswith("Every first integral that is a polynomial of degree up to 1 in")


def test_nothing_is_an_answer(call: Call) -> None:
    answer = call("search", "integrals", "chaplygin-ball")
    assert answer.status == 0 and "  nothing new" in answer.out.splitlines()
    assert "vertical momentum" in answer.out


def test_every_option_reaches_the_search(call: Call) -> None:
    words = ["--at", "R2=-2*R1", "--with", "omega3=-(omega1*gamma1+omega2*gamma2)/gamma3"]
    words += ["--denominator", "mass", "--positions", "2", "--again", "--json"]
    answer = call("search", "integrals", "rubber-ball-on-sphere", *words)
    data = json.loads(answer.out)
    assert answer.status == 0 and data["complete"] and len(data["integrals"]) == 2
    assert data["at"] == {"R2": "-2*R1"} and set(data["letters"]) == {"omega3", "Delta"}
    short = call(
        "search", "integrals", "chaplygin-ball", "--momenta", "--positions", "0", "--again"
    )
    assert "F1 = p_omega1^2 + p_omega2^2 + p_omega3^2" in short.out


def test_a_declared_equation_gives_letters(call: Call) -> None:
    words = ("--with", "momentum", "--degree", "1", "--positions", "1", "--json")
    data = json.loads(call("search", "integrals", "borisov-fedorov-ball", *words).out)
    assert set(data["letters"]) == {"momentum1", "momentum2", "momentum3"}


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--at", "R"), "--at R: give PARAMETER=VALUE"),
        (("--at", "R=1+"), "--at R: '1+' is not a formula"),
        (("--at", "R=open(1)"), "is not a formula"),
        (("--with", "2r=gamma1"), "--with 2r=gamma1: give NAME=EXPRESSION"),
        (("--with", "momentun"), "declares no equation 'momentun'"),
        (("--denominator", "gamm1"), "no symbol 'gamm1'; did you mean 'gamma1'"),
        (("--degree", "-1"), "degree is -1; give a number from 0 upward"),
    ],
)
def test_a_wrong_word_is_refused_in_a_line(call: Call, words, message) -> None:
    assert message in refused(call("search", "integrals", "chaplygin-ball", *words))


def test_it_says_what_can_be_searched(call: Call) -> None:
    assert "KIND" in refused(call("search"))


def test_too_large_an_ansatz_is_a_limit(call: Call) -> None:
    answer = call("search", "integrals", "chaplygin-ball", "--limit", "3")
    assert answer.status == 1 and "more than the limit 3" in answer.err


def test_ctrl_c_keeps_what_was_found(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    steps = search.searches

    def stopped(*arguments, **options):
        for step in steps(*arguments, **options):
            yield step
            if step.integrals:
                raise KeyboardInterrupt

    monkeypatch.setattr(search, "searches", stopped)
    answer = call("search", "integrals", "chaplygin-ball", "--again")
    assert answer.status == 130 and "voronec: stopped" in answer.err
    assert "F1 = " in answer.out and "F2 = " not in answer.out
    assert answer.out.splitlines()[-1].startswith("The search was stopped")


def test_a_formula_holds_symbols_whatever_their_names() -> None:
    E, I1, gamma, x = sp.symbols("E I1 gamma x")
    assert formula("E*I1^2 - 0.1*sqrt(gamma)/x", "") == E * I1**2 - sp.sqrt(gamma) / x / 10
    assert formula("-exp(+x)*pi", "") == -sp.exp(x) * sp.pi


@pytest.mark.parametrize(
    ("words", "status", "shown"),
    [
        (("measures", "sleigh"), 0, "1/w is an invariant measure: proved where w != 0."),
        (("measures", "robot-with-two-trailers"), 1, "An invariant measure that is a product"),
        (("multipliers", "nonholonomic-particle"), 0, "reducing multiplier  1/sqrt(y^2 + 1)"),
        (("multipliers", "sleigh"), 0, "is proved not to exist, for generic parameters."),
        (("symmetries", "sleigh"), 0, "(-y) d/dx + (1) d/dphi + (x) d/dy  proved"),
        (
            ("gauge", "nonholonomic-particle"),
            0,
            "proved, momentum of a horizontal symmetry: (1/m) Y",
        ),
        (
            ("rational", "suslov", "--degree", "1"),
            0,
            "No further rational integral of degree at most 1",
        ),
        (("rational", "chaplygin-ball", "--degree", "2"), 1, "excess                        1"),
    ],
)
def test_each_kind_prints_what_is_proved_and_goes_into_json(
    call: Call, words: tuple[str, ...], status: int, shown: str
) -> None:
    answer = call("search", *words)
    assert answer.status == status and shown in answer.out and answer.err == ""
    data = json.loads(call("search", *words, "--json").out)
    assert data["system"] == words[1] and answer.out.splitlines()[-1] == data["statement"].replace(
        "**", "^"
    )


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("measures", "sleigh", "--factor", "q"), "has no symbol 'q'"),
        (("multipliers", "sleigh", "--at", "b=1"), "no parameter 'b'"),
        (("symmetries", "sliegh"), "sliegh"),
        (("gauge", "sleigh", "--integral", "v"), "'v' is no integral"),
        (("rational", "sleigh", "--degree", "0"), "degree is 0; give a number from 1 upward"),
        (("rational", "sleigh", "--at", "m=sqrt(2)"), "give it a rational number"),
    ],
)
def test_bad_input_of_each_kind_is_refused_in_a_line(
    call: Call, words: tuple[str, ...], message: str
) -> None:
    assert message in refused(call("search", *words))
