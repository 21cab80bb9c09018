"""A system as a TOML text, for those who do not program: every formula is text, and none is run.

    name = "skate"
    lagrangian = "m*(xdot^2 + ydot^2)/2 + J*phidot^2/2"
    constraints = ["xdot*sin(phi) = ydot*cos(phi)"]
    fibre = ["y"]

    [coordinates]
    x = "where the blade touches the plane"
    ...

The velocity of a coordinate ``x`` is ``xdot``, the time is ``t``.  ``docs/text-files.md`` has all
tables.  What is wrong is told with its line and column, and with what was expected there.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from inspect import Parameter as Argument
from inspect import signature
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

import sympy as sp

from voronec.algebra.symbols import plain_name, time, velocity
from voronec.algebra.text import CHARACTERS, FUNCTION_NAMES, exact_number, formula
from voronec.declaration.claims import Case, Equation, Measure
from voronec.declaration.geometry import Fibration, Frame
from voronec.declaration.scene import Parameter, Scene
from voronec.declaration.shapes import PLACEMENT, ROLES, Shape, turn_about
from voronec.declaration.sketch import LOOKS, Sketch
from voronec.declaration.system import System
from voronec.declaration.table_file import KINDS, read_table, require_table
from voronec.declaration.text_file import Item, read_toml
from voronec.errors import DefinitionError, did_you_mean, quote

CLAIMS = ("integrals", "equations", "measure", "multiplier", "integrable")
"""What a system and a case claim alike."""
FIELDS = (
    "name", "title", "description", "references", "coordinates", "fibre", "relations", "velocities",
    "parameters", "possible", "inputs", "definitions", "lagrangian", "constraints", "forces",
    "invariants", *CLAIMS, "essential", "cases", "undecided", "scenes", "shapes", "sketch",
)  # fmt: skip
NAME = re.compile(r"[^\W\d]\w*")
LABEL = re.compile(r"(?:[A-Za-z]\w*+|\d++(?:\.\d++)?|[\s(),.=+*/|:-])*+")
"""What may stand in a drawing: names, numbers, words."""
SHAPES = tuple(name for name, made in vars(Shape).items() if isinstance(made, classmethod))
STROKES = tuple(
    name
    for name, drawn in vars(Sketch).items()
    if name[0] != "_" and getattr(drawn, "__annotations__", {}).get("return") == "Sketch"
)
COORDINATES = 100
"""How many coordinates a text may declare: a chain of so many links is derived in a minute."""
FARTHEST = 1000.0
"""How far from its origin a drawing may reach, in its own units."""
OUTPUT = re.compile(r"[^\W\d]\w*(?: \w+)*")
"""Names, such as u1 or 'momentum squared'; any other output is a formula."""
RELATION = re.compile(r"<=|>=|<|>")
COMPARISON = re.compile(r"[<>=!:~]+")
"""What somebody may write between two formulas."""
BETWEEN = {"<": sp.Lt, ">": sp.Gt, "<=": sp.Le, ">=": sp.Ge}


class DrawnArgument(NamedTuple):
    """An argument of a method that draws: its name, its kind, whether it must be given, and whether
    it stands for any number of them."""

    name: str
    kind: str
    needed: bool
    many: bool = False


def read_system(path: str | Path) -> System:
    """The system that a TOML file declares; ``DefinitionError`` with line and column."""
    return _Text(read_toml(Path(path))).system()


@dataclass
class _Text:
    """The tables of one file, and the names that its formulas may hold."""

    root: Item
    names: dict[str, Any] = field(default_factory=lambda: {plain_name(time): time})
    roles: dict[str, str] = field(default_factory=lambda: {plain_name(time): "the time"})
    meanings: dict[str, str] = field(default_factory=dict)
    lengths: dict[str, int] = field(default_factory=dict)
    """Of definitions: how long they are where everything in them is written out."""

    def system(self) -> System:
        """The system that the text declares, names before the formulas that hold them."""
        # long because it is a list: one entry for each part of a text, in the order of need
        top = self.top = self.root.table(FIELDS)
        for key in ("name", "coordinates", "lagrangian"):
            if key not in top:
                said = "[coordinates]" if key == "coordinates" else f'{key} = "..."'
                self.root.wrong(f"'{key}' is missing; expected {said} in this file")
        declared = _present(top, name=Item.text, title=Item.text, description=Item.text)
        declared["fibration"] = self._fibration()
        parameters = self._each("parameters", self._parameter)
        declared["parameters"] = tuple(parameters.values())
        declared["inputs"] = tuple(self._each("inputs", self._input).values())
        velocities = self._velocities()
        self._each("definitions", self._definition)
        if velocities:
            quasi = {self.names[v]: self._formula(item) for v, item in velocities.items()}
            declared["frame"] = self._make(top["velocities"], Frame.quasi, quasi)
        declared["lagrangian"] = self._formula(top["lagrangian"])
        declared["fibration"] = replace(
            declared["fibration"], **self._several("relations", self._vanishing_expression)
        )
        declared |= self._several("constraints", self._vanishing_expression)
        declared["forces"] = self._forces()
        declared["possible"] = self._each("possible", self._condition)
        declared["invariants"] = self._each("invariants", self._read_value)
        self.names |= {name: sp.Symbol(name) for name in declared["invariants"]}
        declared |= self._claims(top)
        declared |= self._several("essential", self._one)
        declared["cases"] = self._each("cases", self._case)
        declared["undecided"] = self._each("undecided", Item.text)
        declared["scenes"] = self._each("scenes", self._scene)
        declared |= self._several("shapes", self._shape)
        declared |= _present(top, sketch=self._sketch)
        declared |= self._several("references", Item.text)
        try:
            return System(**declared, meanings=self.meanings)
        except DefinitionError as error:
            self._refuse(str(error).removeprefix(f"system '{declared['name']}': "))

    def _refuse(self, what: str) -> NoReturn:
        """Refuse the text at the entry that a message counts, else at a word that it quotes."""
        counted = re.match(r"(constraint|relation) (\d+)\b", what)
        if counted is not None:
            self.top[f"{counted[1]}s"].several()[int(counted[2]) - 1].wrong(what)
        self.root.wrong_somewhere(what)

    def _several(self, key: str, read: Callable[[Item], Any]) -> dict[str, tuple[Any, ...]]:
        """{key: the entries of a list at the top, read}; empty where there is none."""
        return _present(self.top, **{key: _all_by(read)})

    def _each(self, key: str, read: Callable[[Item], Any]) -> dict[str, Any]:
        """The entries of a table at the top, read; empty where there is none."""
        return {k: read(item) for k, item in self._table(key).items()}

    def _table(self, key: str) -> Mapping[str, Item]:
        """A table at the top; an empty one where there is none."""
        return self.top[key].table() if key in self.top else {}

    # -- names ---------------------------------------------------------------------------------

    def _new(self, item: Item, role: str) -> Any:
        """The symbol of a name that begins here, and is known from here on."""
        name = str(item.keys[-1])
        if not NAME.fullmatch(name) or name in (*FUNCTION_NAMES, "pi"):
            item.wrong_key(
                f"'{quote(name)}' cannot be {role}; expected a name of letters, digits and "
                "underscores, a letter first, that means nothing else, such as phi or x1"
            )
        if name in self.roles:
            item.wrong_key(
                f"the name '{name}' is used twice, for {self.roles[name]} and for {role}; "
                "rename one"
            )
        self.roles[name], self.names[name] = role, sp.Symbol(name)
        return self.names[name]

    def _fibration(self) -> Fibration:
        given = (item := self.top["coordinates"]).table()
        if len(given) > COORDINATES:
            item.wrong(f"{len(given)} are too many; {COORDINATES} are read, more in a Python file")
        for name, item in given.items():
            self._new(item, "a coordinate")
            self._mean(name, item)
        for name in given:
            dot = plain_name(velocity(self.names[name]))
            if dot in given:
                given[dot].wrong_key(f"'{dot}' is the velocity of '{name}'; rename the coordinate")
            self.roles[dot], self.names[dot] = f"the velocity of '{name}'", sp.Symbol(dot)
        fibre = self.top["fibre"].several() if "fibre" in self.top else []
        chosen = [self._among(item, given, "coordinate") for item in fibre]
        base = tuple(self.names[name] for name in given if name not in chosen)
        where = self.top.get("fibre", self.root)
        return self._make(where, Fibration, base, tuple(self.names[name] for name in chosen))

    def _among(self, item: Item, known: Iterable[str], kind: str) -> str:
        name = item.text()
        if name not in known:
            item.wrong(f"'{quote(name)}' is no {kind}{did_you_mean(name, known)}")
        return name

    def _mean(self, name: str, item: Item) -> None:
        """Words that are said of a name; none where the text is empty."""
        if item.text().strip():
            self.meanings[name] = " ".join(item.text().split())

    def _input(self, item: Item) -> Any:
        symbol = self._new(item, "an input")
        self._mean(plain_name(symbol), item)
        rate = velocity(symbol)
        self.roles[plain_name(rate)], self.names[plain_name(rate)] = "the rate of an input", rate
        return symbol

    def _velocities(self) -> dict[str, Item]:
        """The quasi-velocities, known from here on, with their formulas, still to be read."""
        velocities = {}
        for name, item in self._table("velocities").items():
            self._new(item, "a velocity")
            velocities[name] = self._formula_item(item)
        return velocities

    def _formula_item(self, item: Item) -> Item:
        """The formula of an entry: all of it, or what it ``is`` beside what it means."""
        if not isinstance(item.value, dict):
            return item
        inner = item.table(("is", "meaning"))
        if "meaning" in inner:
            self._mean(str(item.keys[-1]), inner["meaning"])
        if "is" not in inner:
            item.wrong('\'is\' is missing; expected { is = "a formula", meaning = "in words" }')
        return inner["is"]

    def _definition(self, item: Item) -> None:
        text, name = item.scalar(), str(item.keys[-1])
        length = sum(self.lengths.get(word, 0) for word in NAME.findall(text)) + len(text)
        if length > CHARACTERS:
            item.wrong(f"written out it has {length} characters; {CHARACTERS} are read at most")
        value = self._formula(item)
        self._new(item, "a definition")
        self.names[name], self.lengths[name] = value, length

    # -- formulas ------------------------------------------------------------------------------

    def _formula(self, item: Item, more: Mapping[str, Any] | None = None) -> Any:
        return self._read(item, item.scalar(), 0, {**self.names, **(more or {})})

    def _read(self, item: Item, text: str, start: int, names: Mapping[str, Any]) -> Any:
        """The formula that stands in an item from ``start`` on; its names are known."""
        try:
            read = formula(text, item.title, names)
        except DefinitionError as error:
            item.refuse(error, start)
        used = {m[0]: m.start() for m in reversed([*NAME.finditer(text)])}
        for name in sorted({str(s) for s in read.free_symbols} & used.keys() - names.keys()):
            near = did_you_mean(name, names)
            mend = "" if near.endswith("?") else "; a constant is declared under [parameters]"
            item.wrong(
                f"'{quote(name)}' is neither coordinate, velocity, parameter nor definition"
                f"{near}{mend}",
                start + used[name],
            )
        return read

    def _vanishing_expression(self, item: Item) -> Any:
        """An expression that vanishes: ``a = b``, or ``a == b``, stands for a - b."""
        text, names = item.scalar(), self.names
        signs = [*COMPARISON.finditer(text)]
        if not signs:
            return self._formula(item)
        first, last = signs[0], signs[-1]
        if last is not first or first[0] not in ("=", "=="):
            item.wrong(
                'one sign "=" stands between what is equal, as in "xdot = r*phidot"', last.start()
            )
        left, right = text[: first.start()], text[first.end() :]
        return self._read(item, left, 0, names) - self._read(item, right, first.end(), names)

    def _condition(self, item: Item) -> Any:
        """A relation between parameters, such as ``3*A < 2*m*R^2``."""
        sign = RELATION.search(item.scalar())
        if sign is None:
            item.wrong('expected a relation with <, <=, > or >=, such as "A < 2*m*R^2"')
        left, right = item.value[: sign.start()], item.value[sign.end() :]
        sides = (
            self._read(item, left, 0, self.names),
            self._read(item, right, sign.end(), self.names),
        )
        return BETWEEN[sign[0]](*sides)

    def _read_value(self, item: Item) -> Any:
        return self._formula(self._formula_item(item))

    def _one(self, item: Item) -> Any:
        return self.names[self._among(item, self.names, "name of this file")]

    def _make(self, item: Item, make: Callable[..., Any], *parts: Any, **named: Any) -> Any:
        """A part of the system; an error of it stands where the item does."""
        try:
            return make(*parts, **named)
        except DefinitionError as error:
            item.refuse(error)

    # -- tables --------------------------------------------------------------------------------

    def _parameter(self, item: Item) -> Parameter:
        symbol = self._new(item, "a parameter")
        if not isinstance(item.value, dict):
            return self._make(item, Parameter, symbol, item.scalar())
        inner = item.table(("value", "positive", "lower", "upper", "meaning"))
        said = _present(
            inner, value=Item.scalar, lower=Item.scalar, upper=Item.scalar, positive=Item.flag,
            meaning=Item.text,
        )  # fmt: skip
        return self._make(item, Parameter, symbol, **said)

    def _forces(self) -> dict[Any, Any]:
        """Forces may be linear in accelerations, ``xdotdot`` or, of a velocity v, ``vdot``, and may
        hold the second rates of inputs."""
        moving = {
            plain_name(velocity(s)): velocity(s)
            for name, s in self.names.items()
            if self.roles[name].startswith(("the velocity", "a velocity", "the rate"))
        }
        forces: dict[Any, Any] = {}
        for item in self._table("forces").values():
            forces[self._direction(item)] = self._formula(item, moving)
        return forces

    def _direction(self, item: Item) -> Any:
        """What a force acts along: a coordinate, a velocity, or a combination of velocities."""
        said = str(item.keys[-1])
        moving = ("a coordinate", "a velocity", "the velocity")
        if NAME.fullmatch(said):
            return self._known(item, *moving)
        known = {n: s for n, s in self.names.items() if n not in self.top["coordinates"].value}
        try:
            along = formula(said, "what a force acts along", known)
        except DefinitionError as error:
            item.wrong_key(str(error))
        velocities = {self.names[n] for n, r in self.roles.items() if r.startswith(moving)}
        rest = along.xreplace(dict.fromkeys(velocities, 0))
        slopes = [along.diff(v) for v in velocities]
        bent = any(slope.free_symbols & velocities for slope in slopes) or not any(slopes)
        if rest != 0 or bent or along.free_symbols - {*known.values()}:
            item.wrong_key(
                f"'{quote(said)}' is nothing that a force acts along; expected a coordinate, a "
                'velocity, or a combination of velocities in quotes, such as "xdot - ydot"'
            )
        return along

    def _claims(self, table: Mapping[str, Item]) -> dict[str, Any]:
        """What a system or a case claims."""
        return _present(
            table, integrals=_each_by(self._read_value), equations=_each_by(self._equation),
            measure=self._measure, multiplier=self._formula, integrable=Item.text,
        )  # fmt: skip

    def _equation(self, item: Item) -> Equation:
        inner = item.table(("function", "rate"))
        for part in ("function", "rate"):
            if part not in inner:
                item.wrong(f'\'{part}\' is missing; expected {{ function = "v", rate = "a*w^2" }}')
        read = [tuple(map(self._formula, inner[p].several())) for p in ("function", "rate")]
        return self._make(item, Equation, *read)

    def _measure(self, item: Item) -> Any:
        if not isinstance(item.value, dict):
            return self._formula(item)
        inner = item.table(("density", "variables"))
        if "density" not in inner:
            item.wrong('\'density\' is missing; expected { density = "1/w", variables = ["v"] }')
        variables = inner["variables"].several() if "variables" in inner else []
        density = self._formula(inner["density"])
        return self._make(item, Measure, density, tuple(map(self._one, variables)))

    def _case(self, item: Item) -> Case:
        inner = item.table(("parameters", "note", *CLAIMS))
        if "parameters" not in inner:
            item.wrong("'parameters' is missing; expected parameters = { a = 0 }")
        values = {
            self._known(i, "a parameter"): self._formula(i)
            for i in inner["parameters"].table().values()
        }
        note = inner["note"].text() if "note" in inner else ""
        meanings = dict(self.meanings)
        claims = self._claims(inner)
        self.meanings = meanings  # those of a case are told nowhere
        return self._make(item, Case, values, note=note, **claims)

    def _known(self, item: Item, *roles: str) -> Any:
        """The symbol that a key names, which is one of some roles."""
        name = str(item.keys[-1])
        among = [n for n, role in self.roles.items() if role.startswith(roles)]
        if name not in among:
            what = f"not {roles[0]}" if len(roles) == 1 else f"neither {roles[0]} nor {roles[1]}"
            item.wrong_key(f"'{quote(name)}' is {what}{did_you_mean(name, among)}")
        return self.names[name]

    def _scene(self, item: Item) -> Scene:
        inner = item.table(("initial", "times", "parameters", "outputs", "caption", "inputs"))
        said: dict[str, Any] = {"initial": {}}
        moving = ("a coordinate", "a velocity", "the velocity")
        for key, roles in (
            ("initial", moving),
            ("parameters", ("a parameter",)),
            ("inputs", ("an input",)),
        ):
            entries = inner[key].table().values() if key in inner else ()
            read = self._input_value if key == "inputs" else self._formula
            said[key] = {self._known(i, *roles): read(i) for i in entries}
        said |= _present(
            inner, times=_all_by(Item.scalar), outputs=_all_by(self._output), caption=Item.text
        )
        where = inner.get("times", item)
        return self._make(where, Scene, **said)

    def _input_value(self, item: Item) -> Any:
        """A formula; or a table, as its times, its values and how it goes on between them."""
        if not isinstance(item.value, dict):
            return self._formula(item)
        inner = item.table(("times", "values", "file", "kind"))
        kind = self._among(inner["kind"], KINDS, "kind") if "kind" in inner else "linear"
        if "file" in inner and not {"times", "values"} & inner.keys():
            where = inner["file"]
            path = Path(item.source.name).parent / where.text()
            columns = self._make(where, read_table, path, "a table")
        elif {"times", "values"} == inner.keys() - {"kind"}:
            where = inner["times"]
            parts = (inner[key].several() for key in ("times", "values"))
            columns = tuple([float(self._number(i)) for i in part] for part in parts)
        else:
            item.wrong('expected { times = [0, 1], values = [2, 0] } or { file = "u.csv" }')
        self._make(where, require_table, *columns, kind)
        return (*columns, kind)

    def _number(self, item: Item) -> Any:
        return self._make(item, exact_number, item.scalar(), item.title)

    # -- pictures ------------------------------------------------------------------------------

    def _shape(self, item: Item) -> Shape:
        """A body or a surface, by its ``kind`` and the arguments of ``Shape`` that this has."""
        table = item.table()
        local: dict[str, Any] = {}
        for one in table["coordinates"].several() if "coordinates" in table else ():
            local[one.text()] = sp.Symbol(one.text())

        def three(part: Item) -> Any:
            return tuple(self._formula(e, local) for e in self._long(part, 3))

        readers = {
            **dict.fromkeys(("axes", "lengths", "centre", "contact"), three),
            "position": lambda part: (three if isinstance(part.value, list) else plain)(part),
            "coordinates": lambda part: tuple(sp.Symbol(e.text()) for e in self._long(part, 2)),
            "ranges": lambda part: tuple(map(self._pair, self._long(part, 2))),
            "attitude": self._attitude,
            "role": lambda part: self._among(part, ROLES, "role"),
            "title": Item.text,
        }

        def plain(part: Item) -> Any:
            return self._formula(part, local)

        kinds = {name: getattr(Shape, name) for name in SHAPES}
        return self._call_method(item, "kind", kinds, lambda entry: readers.get(entry.name, plain))

    def _attitude(self, item: Item) -> Any:
        """A turn about the vertical, or several about axes of the body, each after the last."""
        if not isinstance(item.value, list):
            return self._formula(item)
        turned = sp.eye(3)
        for turn in item.several():
            inner = turn.table(("axis", "angle"))
            if len(inner) < 2:
                turn.wrong('expected { axis = "z", angle = "phi" }')
            axis = "xyz".index(self._among(inner["axis"], "xyz", "axis"))
            turned = turned * turn_about(axis, self._formula(inner["angle"]))
        return turned

    def _sketch(self, item: Item) -> Sketch:
        """A drawing, stroke by stroke: each says what is to ``draw``, and where."""
        inner = item.table(("view", "strokes"))
        sketch = Sketch(inner["view"].text() if "view" in inner else "")
        readers: dict[str, Callable[[Item], Any]] = {
            "Point": self._pair, "float": self._length, "Any": self._label,
            "str": lambda part: self._among(part, LOOKS, "look"),
        }  # fmt: skip
        for stroke in inner["strokes"].several() if "strokes" in inner else ():
            kinds = {name: getattr(sketch, name) for name in STROKES}
            sketch = self._call_method(stroke, "draw", kinds, lambda entry: readers[entry.kind])
        return sketch

    def _call_method(
        self,
        item: Item,
        key: str,
        kinds: Mapping[str, Callable[..., Any]],
        reader: Callable[[DrawnArgument], Callable[[Item], Any]],
    ) -> Any:
        """What the method that the entry ``key`` names makes of the other entries."""
        table = item.table()
        if key not in table:
            item.wrong(f"'{key}' is missing; expected one of {', '.join(kinds)}")
        kind = self._among(table[key], kinds, "kind" if key == "kind" else "thing to draw")
        entries = {entry.name: entry for entry in _entries(kinds[kind])}
        inner = item.table((key, *entries))
        missing = [name for name, e in entries.items() if e.needed and name not in inner]
        if missing:
            item.wrong(f"'{missing[0]}' is missing; '{kind}' needs it")
        several: list[Any] = []
        given: dict[str, Any] = {}
        for name, entry in entries.items():
            if name in inner and entry.many:
                several = [reader(entry)(one) for one in inner[name].several()]
            elif name in inner:
                given[name] = reader(entry)(inner[name])
        return self._make(item, kinds[kind], *several, **given)

    def _long(self, item: Item, count: int) -> list[Item]:
        """The entries of an array of so many."""
        if not isinstance(item.value, list) or len(item.value) != count:
            example = "[x, y, 0]" if count == 3 else "[0, 1]"
            item.wrong(f"expected {count} entries in brackets, such as {example}")
        return item.several()

    def _pair(self, item: Item) -> tuple[float, float]:
        first, second = map(self._length, self._long(item, 2))
        return first, second

    def _length(self, item: Item) -> float:
        number = float(self._number(item))
        if not abs(number) <= FARTHEST:
            item.wrong(f"'{quote(item.value)}' lies outside of the drawing; its unit is a body")
        return number

    def _label(self, item: Item) -> str:
        if not LABEL.fullmatch(item.text()):
            item.wrong(f"'{quote(item.value)}' is no label; expected names, numbers and words")
        return item.text()

    def _output(self, item: Item) -> Any:
        return item.text() if OUTPUT.fullmatch(item.scalar()) else self._formula(item)


def _present(table: Mapping[str, Item], **readers: Callable[[Item], Any]) -> dict[str, Any]:
    """The entries that a table has, read."""
    return {key: read(table[key]) for key, read in readers.items() if key in table}


def _all_by(read: Callable[[Item], Any]) -> Callable[[Item], Any]:
    return lambda item: tuple(map(read, item.several()))


def _each_by(read: Callable[[Item], Any]) -> Callable[[Item], Any]:
    return lambda item: {name: read(one) for name, one in item.table().items()}


def _entries(call: Callable[..., Any]) -> Iterator[DrawnArgument]:
    """The arguments of a method, as entries of a table."""
    for argument in signature(call).parameters.values():
        if argument.kind is Argument.VAR_KEYWORD:
            yield from (DrawnArgument(name, "", False) for name in PLACEMENT)
        else:
            many = argument.kind is Argument.VAR_POSITIONAL
            needed = many or argument.default is Argument.empty
            yield DrawnArgument(argument.name, str(argument.annotation), needed, many)
