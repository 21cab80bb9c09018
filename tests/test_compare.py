"""Two derivations side by side, and every system against the derivation that is stored."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import sympy as sp
from command_line import Call, refused

import voronec as vo
from voronec.declaration import catalogue
from voronec.proof.comparison import (
    StoredDerivation,
    compare,
    random_point,
    read_derivation,
    read_expression,
)

pytestmark = pytest.mark.slow

STORED = Path(__file__).parent / "derivations"
OWN = [e.name for e in catalogue.entries()[0] if e.distribution == catalogue.OWN]


@cache
def derived(name: str) -> StoredDerivation:
    return StoredDerivation.of(vo.derive(vo.load(name)))


def changed(name: str, group: str, entry: str, text: str) -> StoredDerivation:
    """A stored derivation with another entry."""
    found = derived(name)
    groups = {**found.groups, group: {**found.groups[group], entry: text}}
    return replace(found, groups=groups, equations=None)


# -- every system --------------------------------------------------------------------------------


@pytest.mark.parametrize("name", OWN)
def test_every_system_is_derived_as_it_is_stored(name: str) -> None:
    """A rewriting that is proved equal passes, with a note."""
    file = STORED / f"{name}.json"
    assert file.exists(), f"store it: python tools/build.py derivations {name}"
    today = derived(name)
    if today.text() == file.read_text(encoding="utf-8"):
        return
    found = compare(read_derivation(file), today)
    told = [
        f"{r.group} {r.name}: {r.first} was, {r.second} is; {r.how}"
        for r in found.differences
        if r.group != "accelerations"  # no entries are stored of the bicycle, which is too large
    ]
    assert not told, "\n".join(told)
    for row in found.rewritten_rows:
        print(f"rewritten, proved equal: {row.group} {row.name}")


def test_what_is_stored_is_small_and_nothing_else() -> None:
    files = [f for f in STORED.iterdir() if f.suffix == ".json"]
    assert {f.stem for f in files} <= {*OWN}
    assert sum(f.stat().st_size for f in files) < 2_000_000


# -- comparison --------------------------------------------------------------------------------


def test_a_rewriting_is_proved_and_a_difference_is_shown_at_a_point() -> None:
    ours = derived("sleigh")
    same = compare(changed("sleigh", "mass", "w,w", "m*a*a + J*(sin(phi)**2 + cos(phi)**2)"), ours)
    assert same.equal
    assert [(r.group, r.name) for r in same.rewritten_rows] == [("mass", "w,w")]
    other = compare(changed("sleigh", "force", "v", "a*m*w**3"), ours)
    (row,) = other.differences
    assert (row.group, row.name, row.status) == ("force", "v", "refuted")
    assert " against " in row.how and "w = " in row.how


def test_an_entry_that_one_side_lacks_is_zero() -> None:
    (row,) = compare(changed("sleigh", "mass", "v,w", "a"), derived("sleigh")).differences
    assert (row.name, row.first, row.second, row.status) == ("v,w", "a", "0", "refuted")
    assert compare(changed("sleigh", "mass", "v,w", "a - a"), derived("sleigh")).equal


def test_the_relations_of_invariants_count() -> None:
    ball = derived("chaplygin-ball")
    text = ball.groups["reduced mass"]["omega1,omega1"]
    rewritten = f"{text} + gamma1**2 + gamma2**2 + gamma3**2 - 1"
    assert compare(
        changed("chaplygin-ball", "reduced mass", "omega1,omega1", rewritten), ball
    ).equal
    wrong = changed("chaplygin-ball", "reduced mass", "omega1,omega1", f"{text} + gamma1**2")
    assert not compare(wrong, ball).equal


def test_equations_without_exact_entries_are_compared_in_numbers() -> None:
    ours = replace(derived("sleigh"), groups={})
    found = compare(ours, ours)
    assert found.equal and not found.exact
    assert {r.group for r in found.rows} == {
        "facts", "acceleration at point 1", "acceleration at point 2",
    }  # fmt: skip
    m = sp.Symbol("m")
    sleigh = vo.load("sleigh")
    heavy = replace(sleigh, lagrangian=sleigh.lagrangian.xreplace({m: 2 * m}), **NO_CLAIMS)
    other = compare(ours, heavy)
    assert {r.name for r in other.differences if r.status == "refuted"} >= {"phi"}
    (row,) = compare(replace(ours, equations=None), ours).differences
    assert row.status == "undecided"


def test_a_group_that_is_too_long_is_not_stored(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = derived("demchenko")
    size = {k: sum(map(len, g.values())) for k, g in whole.groups.items()}
    monkeypatch.setattr("voronec.proof.comparison.LONGEST", size["mass"])
    stored = whole.compact()
    assert {*stored.groups} == {k for k, n in size.items() if n <= size["mass"]} < {*size}
    (row,) = compare(replace(stored, equations=None), whole).differences
    assert (row.group, row.status) == ("accelerations", "undecided")


def test_other_facts_are_differences() -> None:
    facts = {**derived("sleigh").facts, "kind": "voronec"}
    (row,) = compare(replace(derived("sleigh"), facts=facts), derived("sleigh")).differences
    assert (row.name, row.status, row.first, row.second) == (
        "kind", "different", "voronec", "chaplygin",
    )  # fmt: skip


def test_parameters_in_another_order_are_the_same_and_other_inputs_are_not() -> None:
    sleigh = vo.load("sleigh")
    assert len(sleigh.parameters) > 1
    turned = replace(sleigh, parameters=sleigh.parameters[::-1])
    found = compare(derived("sleigh"), turned)
    assert found.equal and "inputs" not in {r.name for r in found.rows}
    fewer = replace(derived("sleigh"), facts=derived("sleigh").facts | {"parameters": ["m"]})
    assert {r.name for r in compare(fewer, derived("sleigh")).differences} == {"parameters"}
    push, v = sp.Symbol("push"), sleigh.velocities[0]
    pushed = StoredDerivation.of(
        vo.derive(replace(sleigh, forces={v: push}, inputs=(push,), **NO_CLAIMS))
    )
    rows = {r.name: r for r in compare(derived("sleigh"), pushed).differences}
    assert (rows["inputs"].first, rows["inputs"].second) == ("", "push")
    kept = StoredDerivation.from_dict(json.loads(pushed.text()), "here")
    assert kept.facts["inputs"] == ["push"] and compare(kept, pushed).equal
    assert "inputs" not in derived("sleigh").as_dict()


def test_motions_of_two_systems_are_compared() -> None:
    assert max(compare(derived("sleigh"), derived("sleigh")).deviations.values()) == 0
    m = sp.Symbol("m")
    sleigh = vo.load("sleigh")
    heavy = replace(sleigh, lagrangian=sleigh.lagrangian.xreplace({m: 2 * m}), **NO_CLAIMS)
    found = compare(derived("sleigh"), StoredDerivation.of(vo.derive(heavy)))
    assert not found.equal and max(found.deviations.values()) > 1e-2
    other = compare(derived("sleigh"), derived("vertical-disc"))
    assert not other.deviations and other.remark == "the variables differ"
    assert {r.name for r in other.differences} >= {"base", "fibre"}


NO_CLAIMS = {
    "integrals": {}, "equations": {}, "measure": None, "multiplier": None, "cases": {},
    "essential": (), "integrable": "",
}  # fmt: skip


@pytest.mark.parametrize("name", ["sleigh", "chaplygin-ball", "demchenko", "bicycle"])
def test_what_is_stored_is_read_back(name: str) -> None:
    stored = derived(name).compact()
    data = json.loads(derived(name).text())
    assert StoredDerivation.from_dict(data, "here") == replace(stored, equations=None)


# -- texts -----------------------------------------------------------------------------------


x, y, word = sp.symbols("x y lambda")


@pytest.mark.parametrize(
    "expr",
    [
        x**2 / 3 - sp.sqrt(y) * sp.sin(x),
        -(x ** sp.Rational(-3, 2)),
        word + sp.pi * sp.atan2(y, x),
        sp.Function("f")(x).diff(x) * sp.Function("f")(x) + sp.Function("E")(x, y).diff(x, 2, y),
        sp.Symbol("E") + sp.Symbol("I1"),
        sp.exp(-x) * sp.Abs(y) + sp.log(1 + x),
    ],
)
def test_an_expression_comes_back_from_its_text(expr: sp.Expr) -> None:
    assert read_expression(str(expr)) == expr


@pytest.mark.parametrize(
    "text", ["", "x +", "x.y", "__import__('os')", "[x]", "x if y else x", "'x'", "f(x=1)", 3]
)
def test_what_is_no_expression_is_refused(text: object) -> None:
    with pytest.raises(vo.DefinitionError, match="expression"):
        read_expression(text)


# -- the command -----------------------------------------------------------------------------


def test_the_command_stores_and_compares(call: Call) -> None:
    assert "voronec compare old.json sleigh" in call("derive", "sleigh", "--store", "old.json").out
    answer = call("compare", "old.json", "sleigh")
    assert answer.status == 0 and answer.out.endswith("\nequal\n")
    call("new", "mine", "--toml")
    told = call("derive", "mine.toml", "--store", "mine.json").out
    assert told.endswith("voronec compare mine.json mine.toml\n")
    text = Path("old.json").read_text()
    Path("old.json").write_text(text.replace('"a*m*w**2"', '"2*a*m*w**2"'))
    answer = call("compare", "old.json", "sleigh")
    assert answer.status == 1 and answer.out.endswith("\ndifferent\n")
    assert "force v: refuted\n  sleigh: 2*a*m*w^2\n  sleigh: a*m*w^2\n" in answer.out
    data = json.loads(call("compare", "old.json", "sleigh", "--json").out)
    assert data["equal"] is False
    assert [r["name"] for r in data["rows"] if r["status"] == "refuted"] == ["v"]


def test_wrong_files_are_refused(call: Call) -> None:
    assert "no file 'none.json'" in refused(call("compare", "none.json", "sleigh"))
    for told in (("derive", "/dev/zero"), ("compare", "/dev/zero", "sleigh")):
        assert "'/dev/zero' is a device; name a" in refused(call(*told))
    assert "cannot be written" in refused(call("derive", "sleigh", "--store", "no/where.json"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "is not JSON"),
        ("[" * 100_000, "is not JSON"),
        ("[]", "holds no derivation"),
        ('{"format": 7}', "has the format 7"),
    ],
)
def test_a_file_that_holds_something_else_is_refused(
    tmp_path: Path, text: str, message: str
) -> None:
    file = tmp_path / "odd.json"
    file.write_text(text)
    with pytest.raises(vo.DefinitionError, match=message):
        read_derivation(file)


ODD: list[Any] = [
    None, 3, 1.5, True, "x", "(", "1/0", "",
    [], [1], [["x"]], ["sqrt(-1)"], {}, {"a": 1}, {"x": "y"},
]  # fmt: skip
"""What stands in the place of each part of a stored derivation."""


def parts_of(data: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """The paths to all parts of data of JSON, the whole first."""
    yield path
    keys = data if isinstance(data, dict) else range(len(data)) if isinstance(data, list) else ()
    for key in keys:
        yield from parts_of(data[key], (*path, key))


def test_damaged_files_are_compared_or_refused() -> None:
    """Every part is replaced by odd ones, and left out."""
    ours = derived("sleigh")
    text = ours.text()
    refused_parts, compared = set(), 0
    for path in parts_of(json.loads(text)):
        for odd in (*ODD, KeyError):
            data = json.loads(text)
            *outer, last = ("whole", *path)
            inner = whole = {"whole": data}
            for key in outer:
                inner = inner[key]
            if odd is KeyError:
                del inner[last]
            else:
                inner[last] = odd
            try:
                compare(StoredDerivation.from_dict(whole.get("whole"), "here"), ours)
                compared += 1
            except vo.DefinitionError:
                refused_parts.add(path)
    assert {(), ("system",), ("base", 0), ("groups", "mass", "v,v")} < refused_parts
    assert {("ideals",), ("groups",), ("positive",)} < refused_parts
    assert compared, "texts of expressions may be other ones"


def test_signs_that_are_declared_are_stored_with_a_derivation() -> None:
    """sqrt(m k^2) and k sqrt(m) are one rate where k is positive, in two files too."""
    x, m, k = sp.symbols("x m k")
    roots = (sp.sqrt(m * k**2), k * sp.sqrt(m))

    def kept(force: sp.Expr, positive: bool) -> StoredDerivation:
        system = vo.System(
            name="pulled",
            fibration=vo.Fibration((x,)),
            lagrangian=vo.velocity(x) ** 2 / 2,
            forces={x: force},
            parameters=tuple(vo.Parameter(s, 1, positive=positive) for s in (m, k)),
        )
        text = StoredDerivation.of(vo.derive(system)).text()
        return StoredDerivation.from_dict(json.loads(text), "here")

    known, unknown = ([kept(r, positive) for r in roots] for positive in (True, False))
    assert known[0].positive == ("m", "k") and compare(*known).equal
    assert not compare(*unknown).equal
    older = {k: v for k, v in unknown[0].as_dict().items() if k != "positive"}
    assert StoredDerivation.from_dict(older, "here").positive is None


def test_what_one_side_alone_declares_is_no_ground_for_equality() -> None:
    """|a| is a where a > 0, and the other system may have a < 0; so with x^n and |x|^n."""
    x, a, n = sp.symbols("x a n")

    def pulled(force: sp.Expr, **more: bool) -> vo.System:
        own = (vo.Parameter(a, 1, **more), vo.Parameter(n))
        kinetic = vo.velocity(x) ** 2 / 2
        return vo.System("pulled", vo.Fibration(x), kinetic, parameters=own, forces={x: force})

    sides = pulled(sp.Abs(a), positive=True), pulled(a)
    kept = [StoredDerivation.of(vo.derive(side)) for side in sides]
    again = [StoredDerivation.from_dict(json.loads(k.text()), "here") for k in kept]
    for pair in (sides, sides[::-1], again):
        (row,) = compare(*pair).differences
        assert (row.status, row.domain) == ("proved", "a > 0")
    older = {k: value for k, value in again[1].as_dict().items() if k != "positive"}
    assert compare(again[0], StoredDerivation.from_dict(older, "here")).equal
    (row,) = compare(pulled((x**2) ** (n / 2)), pulled(x**n)).differences
    assert (row.status, row.domain) == ("proved", "x > 0")


def test_numbers_at_points_are_not_called_equality() -> None:
    """A difference of 1e-30 is seen in entries, and not in accelerations of 30 digits."""
    x = sp.Symbol("x")
    sides = [
        vo.System("spring", vo.Fibration(x), (vo.velocity(x) ** 2 - k * x**2) / 2)
        for k in (1, 1 + sp.Rational(1, 10**30))
    ]
    assert compare(*sides).outcome == "different"
    kept = StoredDerivation.of(vo.derive(sides[0]))
    short = replace(kept, groups={k: g for k, g in kept.groups.items() if k != "force"})
    found = compare(short, sides[1])
    assert found.equal and not found.exact and found.outcome.startswith("equal by numbers")
    assert compare(sides[0], sides[0]).outcome == "equal"


def test_points_have_parameters_near_their_defaults_with_their_signs() -> None:
    x, m, k, free = sp.symbols("x m k free")
    energy = (m * vo.velocity(x) ** 2 - k * x**2) / 2 + free * x
    own = (vo.Parameter(m, 8), vo.Parameter(k, -3), vo.Parameter(free))
    system = vo.System("spring", vo.Fibration(x), energy, parameters=own)
    for seed in range(5):
        point = random_point(system, seed)
        assert all(1 < point[s] / base < 1.4 for s, base in ((m, 8), (k, -3), (free, 1)))


def test_motions_are_compared_from_what_the_scene_gives() -> None:
    """The second one had neither inputs of the scene nor, at a place where the velocities are no
    frame, a start."""
    x, y, phi, u = sp.symbols("x y phi u")
    dx, dy, turn = map(vo.velocity, (x, y, phi))
    start = {"phi": sp.pi / 2, "ydot": 1, "phidot": 1}
    blade = vo.System(
        name="blade", fibration=vo.Fibration((x, phi), (y,)), inputs=(u,), forces={phi: u},
        lagrangian=(dx**2 + dy**2 + turn**2) / 2,
        constraints=(dx * sp.sin(phi) - dy * sp.cos(phi),),
        scenes={"default": vo.Scene(start, (0, 1), inputs={u: "sin(t)"})},
    )  # fmt: skip
    found = compare(blade, blade)
    assert found.equal and not found.remark and max(found.deviations.values()) == 0
