"""What is computed of a value is kept with it, and nowhere else."""

from __future__ import annotations

import ast
import copy
import gc
import pickle
import re
import weakref
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import pytest
import sympy as sp

import voronec as vo
from voronec.algebra.memo import Memo
from voronec.equations.motions import Motions

PACKAGE = Path(vo.__file__).parent


def particle() -> vo.System:
    x = sp.Symbol("x")
    dot = vo.velocity(x)
    return vo.System("particle", vo.Fibration(base=(x,), fibre=()), dot**2 / 2 - x**2 / 2)


def test_a_result_is_made_once_and_a_copy_begins_without() -> None:
    memo, made = Memo(), []
    assert [memo.once("a", lambda: made.append(1) or len(made)) for _ in range(3)] == [1, 1, 1]
    for other in (copy.deepcopy(memo), pickle.loads(pickle.dumps(memo))):
        assert other.once("a", lambda: 5) == 5


def test_equations_belong_to_one_system() -> None:
    system = particle()
    equations = vo.derive(system)
    assert vo.derive(system) is equations and Motions.of(system) is Motions.of(equations)
    other = replace(system, lagrangian=2 * system.lagrangian)
    assert other == replace(system, lagrangian=2 * system.lagrangian) != system
    assert vo.derive(other) is not equations


HEYOKA = pytest.param("heyoka", marks=pytest.mark.skipif(not find_spec("heyoka"), reason="absent"))


@pytest.mark.parametrize("method", ["scipy", HEYOKA])
def test_a_system_is_forgotten_with_all_that_was_computed_of_it(method: str) -> None:
    gc.freeze()  # what other tests left behind is not looked through
    system, event = particle(), vo.Event("x")
    vo.integrate(system, times=[0.0, 1.0], initial={"x": 1.0}, method=method, events=[event])
    alive = [weakref.ref(system), weakref.ref(vo.derive(system))]
    del system
    gc.collect()
    assert [there() for there in alive] == [None, None]


@pytest.mark.slow
def test_no_function_caches_by_arguments_that_are_known_by_their_identity() -> None:
    """Such a cache keeps all of them alive; what belongs to them goes into their memo."""
    trees = [ast.parse(p.read_text("utf-8")) for p in PACKAGE.rglob("*.py")]
    nodes = [node for tree in trees for node in ast.walk(tree)]
    lone = {
        node.name
        for node in nodes
        if isinstance(node, ast.ClassDef)
        and any("eq=False" in ast.unparse(d) for d in node.decorator_list)
    }
    found = {
        node.name: words
        for node in nodes
        if isinstance(node, ast.FunctionDef)
        and any(re.match("(lru_)?cache", ast.unparse(d)) for d in node.decorator_list)
        and (words := lone & {*re.findall(r"\w+", ast.unparse(node.args))})
    }
    assert "CompiledMotion" in lone and found == {}


def test_no_module_keeps_results_by_the_identity_of_values() -> None:
    """No table is read with ``id``, and no ``__dict__`` is written into."""
    wrong = re.compile(r"\[id\(|key = \(?id\(|__dict__\.setdefault|__dict__\[[^\]]*\] = ")
    found = {p.name: wrong.findall(p.read_text("utf-8")) for p in PACKAGE.rglob("*.py")}
    assert {name: places for name, places in found.items() if places} == {}
