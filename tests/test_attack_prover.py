"""The machine that attacks the prover notices a prover that lies; its truth is its own."""

from dataclasses import replace
from random import Random
from types import SimpleNamespace

import mpmath
import pytest
import sympy as sp
from tool_modules import TOOLS, tool

import voronec
from voronec import Verdict
from voronec.algebra.verdicts import Witness

pytestmark = pytest.mark.slow

x = sp.Symbol("x")


@pytest.fixture(scope="module")
def attack():
    return tool("prover.run")


def asked(attack, count, kind="identities", seed=3):
    return [attack.ask(seed, index, kind)[1].partition(":")[0] for index in range(count)]


def test_an_honest_prover_is_not_accused(attack, capsys, monkeypatch):
    monkeypatch.setattr(
        "sys.argv", "attack_prover.py --seed 3 --count 12 --jobs 1 --kind identities".split()
    )
    assert attack.main() == 0
    printed = capsys.readouterr().out
    assert "seed 3, 12 statements" in printed and "0 wrong" in printed
    assert any(family in printed for family in attack.KINDS["identities"][1])


def test_a_prover_that_proves_everything_is_noticed(attack, monkeypatch):
    monkeypatch.setattr(voronec, "prove_equal", lambda a, b: Verdict("proved", "so it is"))
    found = asked(attack, 30)
    assert "wrong false proved" in found and "wrong true refuted" not in found


def test_a_prover_that_refutes_everything_is_noticed(attack, monkeypatch):
    nowhere = Witness({}, "0", "1")
    lie = Verdict("refuted", "ball arithmetic", nowhere)
    monkeypatch.setattr(voronec, "prove_equal", lambda a, b: lie)
    found = asked(attack, 30)
    assert "wrong true refuted" in found and "wrong witness" in found


def test_one_sign_that_is_lost_in_roots_is_noticed(attack, monkeypatch):
    """sqrt(u^2) taken for u: an error of one rule of the prover."""
    honest = voronec.prove_equal

    def careless(a, b):
        bare = [e.replace(lambda n: n.is_Pow and n.exp == sp.S.Half and n.base.is_Pow,
                          lambda n: n.base.base ** (n.base.exp / 2)) for e in (a, b)]  # fmt: skip
        bare = [e.replace(sp.Abs, lambda u: u) for e in bare]
        return honest(*bare)

    monkeypatch.setattr(voronec, "prove_equal", careless)
    assert any(word.startswith("wrong") for word in asked(attack, 60))


def test_a_claim_that_is_false_and_proved_is_noticed(attack, monkeypatch):
    claims = attack.claims
    proved = SimpleNamespace(verdict=Verdict("proved", "so it is"))
    monkeypatch.setattr(claims, "check_claims", lambda _: [proved])
    assert "wrong false proved" in [
        attack.outcome_of(made)[1].partition(":")[0]
        for made in (claims.cuts(Random(n), True, n % 2 == 0) for n in range(6))
        if made is not None
    ]


def test_truth_is_told_by_mpmath_alone(attack):
    truth = tool("prover.truth")
    source = (TOOLS / "prover" / "truth.py").read_text(encoding="utf-8")
    assert "voronec" not in source
    with mpmath.workdps(40):
        assert truth.difference_at(sp.sqrt(x**2), x, {x: sp.Integer(-2)}) is True
        assert truth.difference_at(sp.sqrt(x**2), x, {x: sp.Integer(2)}) is False


def test_a_statement_without_an_answer_is_told(attack, monkeypatch):
    def never(a, b):
        while True:
            pass

    monkeypatch.setattr(voronec, "prove_equal", never)
    _, outcome, text = attack.ask(3, 0, "identities", limit=3)
    assert outcome.startswith("no answer") and text


def test_a_statement_that_sympy_never_makes_is_none_of_the_prover(attack, monkeypatch):
    def never(*_):
        while True:
            pass

    monkeypatch.setattr(attack, "MAKE_LIMIT", 0.2)
    monkeypatch.setitem(attack.KINDS, "identities", (never, ("roots",)))
    assert attack.ask(3, 0, "identities") == ("none", "not made: within 0.2 s", "")


def test_the_truth_of_relations_is_told_by_the_multipliers():
    """A mirrored sleigh is one; with a clock twice as fast, or not mirrored in one place, it is
    none."""
    relations = tool("prover.relations")
    (entry,) = (e for e in relations.entries()[0] if e.name == "sleigh-on-turntable")
    found = {r.label: r for r in entry.load_relations()[0]}
    mirrored = found["sleigh on a turntable mirrored"]
    system = voronec.load(mirrored.source)

    def holds(**changes):
        pair = relations.Pair(replace(mirrored, **changes), system, system)
        return relations.holds(pair, Random(1))

    assert holds() is True
    assert holds(clock=2) is False
    assert holds(state={**mirrored.state, "phi": sp.Symbol("phi")}) is False
    limit = next(r for r in found.values() if r.limit is not None)
    target = voronec.load(limit.target)
    of_order = {
        n: relations.holds(
            relations.Pair(replace(limit, limit=replace(limit.limit, order=n)), system, target),
            Random(1),
        )
        for n in (1, 4)
    }
    assert of_order == {1: True, 4: False}
