"""What is called frozen holds nothing that its own methods fill in."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FILLS = set("add append clear discard extend insert pop popitem remove setdefault update".split())


def is_frozen(kind: ast.ClassDef) -> bool:
    calls = [d for d in kind.decorator_list if isinstance(d, ast.Call)]
    return any(word.arg == "frozen" for call in calls for word in call.keywords)


def targets(node: ast.AST) -> Iterator[ast.expr]:
    """What a statement assigns or deletes, one by one."""
    found: list[ast.expr] = []
    if isinstance(node, ast.Assign | ast.Delete):
        found = node.targets
    elif isinstance(node, ast.AugAssign):
        found = [node.target]
    for target in found:
        yield from target.elts if isinstance(target, ast.Tuple | ast.List) else [target]


def filled(node: ast.AST) -> Iterator[str]:
    """The attributes of ``self`` whose entries a statement or a call changes."""
    places = [t for t in targets(node) if isinstance(t, ast.Subscript)]
    inside: list[ast.expr] = [t.value for t in places]
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
        inside += [node.func.value] if node.func.attr in FILLS else []
    for place in inside:
        while isinstance(place, ast.Subscript):
            place = place.value
        if isinstance(place, ast.Attribute) and ast.unparse(place.value) == "self":
            yield place.attr


def offences(text: str) -> list[str]:
    """Frozen classes of a source with the fields that they fill in."""
    found = set()
    for kind in ast.walk(ast.parse(text)):
        if isinstance(kind, ast.ClassDef) and is_frozen(kind):
            fields = {ast.unparse(s.target) for s in kind.body if isinstance(s, ast.AnnAssign)}
            names = {name for node in ast.walk(kind) for name in filled(node)}
            found |= {f"{kind.name}.{name}" for name in names & fields}
    return sorted(found)


@pytest.mark.slow
@pytest.mark.parametrize("room", ["voronec", "systems", "tools"])
def test_no_frozen_value_has_a_cell_that_it_fills(room: str) -> None:
    found = {
        str(file.relative_to(ROOT)): names
        for file in sorted((ROOT / room).rglob("*.py"))
        if (names := offences(file.read_text(encoding="utf-8")))
    }
    assert not found


def test_such_cells_are_seen() -> None:
    body = "@dataclass(frozen=True)\nclass A:\n    x: dict\n    def f(self):\n        {}\n"
    for line in ("self.x[1] = 2", "self.x.update(y)", "self.x[0][1] += 2", "y, self.x[1] = 1, 2"):
        assert offences(body.format(line)) == ["A.x"]
    for line in ("y[1] = self.x[1]", "y.update(self.x)", "self.x.get(1)"):
        assert not offences(body.format(line))
