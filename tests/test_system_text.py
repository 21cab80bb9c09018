"""Systems as TOML texts: what they mean, and where they are wrong."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import sympy as sp
from command_line import Call

import voronec as vo
from voronec.cli.template import MECHANISMS
from voronec.declaration.text_file import read_toml

SKATE = MECHANISMS[0].toml.replace("@NAME@", "skate")
SLEIGH = '''
name = "sleigh"
lagrangian = """
m*((xdot - a*phidot*sin(phi))^2
 + (ydot + a*phidot*cos(phi))^2)/2 + J*phidot^2/2"""
constraints = 'xdot*sin(phi) - ydot*cos(phi)'
fibre = "y"
essential = ["v", "w"]
integrable = "Euler-Jacobi"
measure = { density = "1/w", variables = ["v", "w"] }

[coordinates]
x = "place of the blade"
phi = "heading"
y = ""

[velocities]
v = "xdot*cos(phi) + ydot*sin(phi)"
w = { is = "phidot", meaning = "rate of turning" }

[parameters]
m = { value = 1, positive = true, meaning = "mass" }
J = { value = 0.5, positive = true, lower = "1/100", meaning = "inertia" }
a = { value = "3/10" }

[definitions]
K = "J + m*a^2"

[integrals]
energy = "m*v^2/2 + K*w^2/2"
heading = { is = "a*phi - sqrt(K/m)*atan(v*sqrt(m/K)/w)", meaning = "the angle to come" }

[equations]
speed = { function = "v", rate = "a*w^2" }
both = { function = ["v", "w"], rate = ["a*w^2", "-m*a*v*w/K"] }

[possible]
"the blade is not beyond the body" = "m*a^2 < 100*J"

[cases."centre of mass over the blade"]
parameters = { a = 0 }
integrals = { speed = "v", "centre, x" = "x*w - v*sin(phi)" }
measure = "1"
integrable = "Euler-Jacobi"
note = "Circles."

[scenes.default]
initial = { v = -1, w = "1/20" }
times = [0, 20.0]
outputs = ["x", "v", "v^2 + w^2", "energy"]
'''


def written(folder: Path, text: str) -> Path:
    file = folder / "system.toml"
    file.write_text(text, "utf-8")
    return file


def wrong(folder: Path, text: str) -> str:
    """The message of a text that is refused, without the name of its file."""
    file = written(folder, text)
    with pytest.raises(vo.DefinitionError) as caught:
        vo.load(file)
    message = str(caught.value)
    assert message.startswith(f"{file}, line ")
    return message.removeprefix(f"{file}, ")


def test_a_text_declares_the_sleigh_of_the_catalogue(tmp_path: Path) -> None:
    mine, theirs = vo.load(written(tmp_path, SLEIGH)), vo.load("sleigh")
    assert mine.coordinates == theirs.coordinates
    assert sp.expand(mine.lagrangian - theirs.lagrangian) == 0
    assert mine.constraints == theirs.constraints
    assert mine.frame == theirs.frame
    assert [p.value for p in mine.parameters] == [p.value for p in theirs.parameters]
    assert mine.meanings == {
        "x": "place of the blade", "phi": "heading", "w": "rate of turning",
        "heading": "the angle to come",
    }  # fmt: skip
    assert mine.scenes["default"].initial == theirs.scenes["default"].initial
    found = {claim.name: claim.verdict for claim in vo.check_claims(vo.derive(mine))}
    assert len(found) == 11
    assert all(verdict.proved for verdict in found.values())
    assert vo.derive(mine).mass == vo.derive(theirs).mass


def test_the_system_of_the_documentation_is_the_skate(tmp_path: Path) -> None:
    page = (Path(__file__).parents[1] / "docs" / "text-files.md").read_text("utf-8")
    text, pictures = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    shown, skate = vo.load(written(tmp_path, text + pictures)), vo.load(written(tmp_path, SKATE))
    assert len(shown.shapes) == 1 and len(shown.sketch.strokes) == 5
    assert shown.lagrangian.equals(skate.lagrangian)
    assert shown.constraints == skate.constraints
    mistaken = wrong(tmp_path, text.replace("alpha)", "alpa)"))
    assert f"skate.toml, {mistaken}" in page


def test_a_double_sign_is_one(tmp_path: Path) -> None:
    double = vo.load(written(tmp_path, SKATE.replace("sin(phi) =", "sin(phi) ==", 1)))
    assert double.constraints == vo.load(written(tmp_path, SKATE)).constraints


def test_decimals_keep_their_digits(tmp_path: Path) -> None:
    long = "0." + "1" * 60
    system = vo.load(written(tmp_path, SKATE.replace("value = 9.81", f"value = {long}")))
    assert system.parameters[2].value == sp.Rational(long)


def test_forces_inputs_relations_and_accelerations(tmp_path: Path) -> None:
    text = """
    name = "pendulum"
    lagrangian = "m*(xdot^2 + zdot^2)/2 - m*g*z"
    relations = ["x^2 + z^2 = l^2"]
    [coordinates]
    x = "to the right"
    z = "upward"
    [parameters]
    m = 1
    g = 10
    l = { value = 1, positive = true }
    [velocities]
    w = "(x*zdot - z*xdot)/l^2"
    [inputs]
    u = "push"
    [forces]
    x = "u - t*xdot - m*xdotdot/2"
    [scenes.pushed]
    initial = { z = -1, x = 0 }
    inputs = { u = "sin(t)" }
    times = [0, 1]
    outputs = ["configuration"]
    """
    system = vo.load(written(tmp_path, text))
    x, u = sp.symbols("x u")
    assert system.inputs == (u,)
    push = u - vo.time * vo.velocity(x) - sp.Symbol("m") * vo.velocity(vo.velocity(x)) / 2
    assert system.forces[x] == push
    assert len(system.fibration.relations) == 1
    assert vo.integrate(system, "pushed")["x"][-1] > 0


@pytest.mark.parametrize(
    ("old", "new", "place", "message"),
    [
        ("9.81", "9.81.1", ".1, meaning", "not TOML: Unclosed inline table"),
        ("+ potential", "+ potental", "potental",
         "integrals.energy: 'potental' is neither coordinate, velocity, parameter nor definition; "
         "did you mean 'potential'?"),
        ("sin(phi) =", "sin(phi =", "= ydot",
         "constraints, entry 1: not a formula: the parenthesis of column 9 is not closed"),
        ("sin(phi) =", "sin(phi) !=", "!= ydot",
         'constraints, entry 1: one sign "=" stands between'),
        ("cos(phi)\"]", "cos(phi) = 0\"]", "= 0",
         'constraints, entry 1: one sign "=" stands between'),
        ("ydot*cos(phi)\"", "ydot**\"", "\"]",
         "constraints, entry 1: not a formula: a number, a name or '(' is expected"),
        ("J*phidot^2/2\"", "open(1)\"", "open",
         "definitions.kinetic: not a formula at 'open': there is no such function; there are: "),
        ('phi = "heading', 'pi = "heading', "pi = ", "'pi' cannot be a coordinate; expected a"),
        ("[definitions]\n", "[definitions]\nx = 1\n", "x = 1",
         "the name 'x' is used twice, for a coordinate and for a definition"),
        ('fibre = ["y"]', 'fibre = ["z"]', "\"z\"", "fibre, entry 1: 'z' is no coordinate; there "),
        ('fibre = ["y"]', 'fibre = ["y"]\nrelations = ["phidot = 1"]', '"phidot = 1',
         "relations, entry 1: relation 1 (phidot - 1 = 0) contains the velocity 'phidot'"),
        ("positive = true", "positive = 1", "1, meaning",
         "parameters.m.positive: '1' is a number; expected true or false"),
        ("value = 1", "value = -1", "{ value = -1",
         "parameters.m: parameter 'm' = -1 must be positive"),
        ("[0, 20]", "[0, 0]", "[0, 0]", "scenes.default.times: times = ('0', '0'): start and end"),
        ("[integrals]", "[integral]", "integral]", "'integral' means nothing here; did you mean"),
        ("{ w = 1", "{ u = 1", "u = 1", "'u' is neither a coordinate nor a velocity; there are"),
        ("lagrangian =", "Lagrangian =", "Lagrangian =", "'Lagrangian' means nothing here"),
        ("J = { value = 1", "J = { value = [1]", "[1]", "parameters.J.value: an array; expected a"),
        ('"phidot"\n', '"phidot + v*phi*w/xi"\n', "xi", "integrals.turning: 'xi' is neither"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_told_with_its_line_and_column(
    tmp_path: Path, old: str, new: str, place: str, message: str
) -> None:
    assert old in SKATE
    text = SKATE.replace(old, new, 1)
    found = re.fullmatch(r"line (\d+), column (\d+): (.*)", wrong(tmp_path, text))
    assert found is not None
    assert text.split("\n")[int(found[1]) - 1][int(found[2]) - 1 :].startswith(place)
    assert found[3].startswith(message)


def test_a_constant_that_is_not_declared_is_told_of_its_table(tmp_path: Path) -> None:
    told = wrong(tmp_path, SKATE.replace("+ potential", "+ Q", 1))
    assert "there are: " in told and told.endswith("; a constant is declared under [parameters]")


def test_places_are_those_of_the_letters(tmp_path: Path) -> None:
    """Every key and value of a text stands where its place says."""
    text = SLEIGH + '\n[a."b c".d]\nx.y = [1, {z = """q""", "w" = \'v\'}, # c ]\n 2.5]\n'
    text += '[[s]]\nu = 1\n[[ s ]]\nu = "two"\n[s.t]\nv = "three"\n[[s.w]]\nq = "four"\n'
    root = read_toml(written(tmp_path, text))
    counted = 0
    for keys, at in root.source.keys.items():
        assert text[at:].startswith((str(keys[-1]), f'"{keys[-1]}"')), keys
        counted += 1
    for keys, at in root.source.values.items():
        value = root.value
        for key in keys:
            value = value[key]
        if isinstance(value, str):
            assert value in text[at : at + len(value) + 4], keys
        counted += 1
    assert counted > 100


def test_nothing_is_run_and_nothing_explodes(tmp_path: Path) -> None:
    doubled = "\n".join(f'd{n + 1} = "d{n}*sin(d{n})"' for n in range(60))
    long = SKATE.replace("[definitions]\n", f'[definitions]\nd0 = "x + y"\n{doubled}\n')
    assert "written out it has" in wrong(tmp_path, long)
    assert "nested too deeply" in wrong(tmp_path, SKATE + "\na = " + "[" * 5000 + "]" * 5000)
    assert "too long" in wrong(tmp_path, "a = " + "1" * 5000)
    assert "the number is too" in wrong(tmp_path, SKATE.replace("9.81", "1e999999"))
    many = "[coordinates]\n" + "".join(f'q{i} = ""\n' for i in range(101))
    said = wrong(tmp_path, f'name = "many"\nlagrangian = "q0dot^2"\n{many}')
    assert "line 3, column 2: coordinates: 101 are too many; 100 are read" in said


@pytest.mark.slow
def test_every_command_takes_a_text(call: Call) -> None:
    assert call("new", "rolling-coin", "--toml").status == 0
    file = "rolling_coin.toml"
    assert "theta  angle by which the coin has rolled" in call("show", file).out
    assert "thetaddot = 0" in call("derive", file).out
    assert "integral rolling" in call("check", file, "--jobs", "1").out
    assert "drift of  energy" in call("run", file).out
    for words in (("explain", file), ("cite", file), ("compare", file, file)):
        assert call(*words).status == 0
    assert call("search", "integrals", file, "--degree", "1", "--positions", "0").status == 0
    for wrong_name in ("rolling_coin", "rolling_coin.tml"):
        assert "For the file, say 'rolling_coin.toml'" in call("show", wrong_name).err
    assert "no file 'none.toml'" in call("derive", "none.toml").err


@pytest.mark.parametrize("mechanism", MECHANISMS, ids=lambda m: m.title)
def test_both_files_of_a_mechanism_declare_the_same(tmp_path: Path, mechanism: object) -> None:
    made = []
    for text, name in ((mechanism.python, "made.py"), (mechanism.toml, "made.toml")):  # type: ignore[attr-defined]
        (tmp_path / name).write_text(text.replace("@NAME@", "made"))
        made.append(vo.load(str(tmp_path / name)))
    ours, theirs = made
    for part in ("lagrangian", "constraints", "frame", "parameters", "integrals", "meanings"):
        assert getattr(ours, part) == getattr(theirs, part), part
    assert {*ours.coordinates} == {*theirs.coordinates}
    assert ours.scenes["default"].initial == theirs.scenes["default"].initial


PUSHED = """
name = "pushed"
lagrangian = "xdot^2/2"
inputs = { u = "push" }
[coordinates]
x = "place"
[forces]
x = "u"
[scenes.default]
times = [0, 1]
inputs = { u = @ }
"""


@pytest.mark.parametrize(
    "table",
    [
        "\ufefft;u\r\n0;0,5\r\n1;2\r\n",
        "time,push\n0,1/2\n\n1,2\n",
        "0\t0.5\n1\t2",
    ],
)
def test_a_table_may_stand_in_a_file_beside_the_text(tmp_path: Path, table: str) -> None:
    (tmp_path / "u.csv").write_text(table, "utf-8")
    run = vo.integrate(vo.load(written(tmp_path, PUSHED.replace("@", '{ file = "u.csv" }'))))
    assert abs(run["x"][-1] - 0.5) < 1e-12  # 1/2 t^2/2 + 3/2 t^3/6
    assert abs(run["xdot"][-1] - 1.25) < 1e-12


def test_a_table_may_stand_in_the_scene(tmp_path: Path) -> None:
    table = '{ times = [0, "1/2"], values = [4, 0], kind = "held" }'
    run = vo.integrate(vo.load(written(tmp_path, PUSHED.replace("@", table))))
    assert abs(run["x"][-1] - 1.5) < 1e-12  # 4 t^2/2 up to 1/2, then at the speed 2


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("{ times = [0, 1] }", "line 11, column 16: scenes.default.inputs.u: expected { times ="),
        ('{ file = "no.csv" }', "scenes.default.inputs.u.file: a table: there is no file '"),
        ('{ file = "three.csv" }', "row 2 of '"),
        ('{ file = "u.csv", kind = "lineal" }', "did you mean 'linear'?"),
        (
            '{ times = [0, "x"], values = [1, 2] }',
            "column 30: scenes.default.inputs.u.times, entry 2: 'x'",
        ),
        (
            "{ times = [0, 2, 1], values = [1, 2, 3] }",
            "line 11, column 26: scenes.default.inputs.u.times: the times of a table must grow, "
            "but time 3 is 1, after 2",
        ),
        ("{ times = [0, 1], values = [1] }", "2 times and 1 values; give as many of each"),
        ('{ file = "back.csv" }', "line 11, column 25: scenes.default.inputs.u.file: the times"),
        ('{ file = "u.csv", kind = "cubic" }', "a cubic table needs at least 4 instants"),
    ],
)
def test_a_table_that_cannot_be_read_is_refused(tmp_path: Path, table: str, message: str) -> None:
    (tmp_path / "three.csv").write_text("t,u,v\n0,1,2\n", "utf-8")
    (tmp_path / "u.csv").write_text("0,1\n1,2\n", "utf-8")
    (tmp_path / "back.csv").write_text("0,1\n0,2\n", "utf-8")
    assert message in wrong(tmp_path, PUSHED.replace("@", table))


ROLLER = """
name = "roller"
lagrangian = "m*(xdot^2 + ydot^2)/2 + J*phidot^2/2"
constraints = "xdot*sin(phi) = ydot*cos(phi)"
fibre = "y"
[coordinates]
x = ""
phi = ""
y = ""
[velocities]
v = "xdot*cos(phi) + ydot*sin(phi)"
w = "phidot"
[parameters]
m = 1
J = 1
R = 1
[forces]
@
"""


@pytest.mark.parametrize(
    ("forces", "expected"),
    [
        ('v = "3*m"', ("3*m", "0")),
        ('w = "-w"\nv = "2"', ("2", "-w")),
        ('phidot = "5"', ("0", "5")),
        ('"v + R*w" = "7"', ("7", "7*R")),
        ('"xdot - phidot" = "7"', ("7*cos(phi)", "-7")),
    ],
)
def test_forces_act_along_velocities(
    tmp_path: Path, forces: str, expected: tuple[str, str]
) -> None:
    eqs = vo.derive(vo.load(written(tmp_path, ROLLER.replace("@", forces))))
    assert [str(e) for e in eqs.force] == [*expected]


@pytest.mark.parametrize(
    ("forces", "message"),
    [
        (
            'vv = "1"',
            "line 18, column 1: 'vv' is neither a coordinate nor a velocity; did you mean 'v'",
        ),
        ('"v + x" = "1"', "line 18, column 1: 'v + x' is nothing that a force acts along"),
        ('"v^2" = "1"', "line 18, column 1: 'v^2' is nothing that a force acts along"),
        ('"v - v" = "1"', "line 18, column 1: 'v - v' is nothing that a force acts along"),
        ('"v + q" = "1"', "is nothing that a force acts along; expected a coordinate"),
        ('"v*w" = "1"', "v*w"),
        ('"v +" = "1"', "line 18, column 1: "),
    ],
)
def test_what_no_force_acts_along_is_refused(tmp_path: Path, forces: str, message: str) -> None:
    assert message in wrong(tmp_path, ROLLER.replace("@", forces))


SHAPES = """
[[shapes]]
kind = "wheel"
radius = "R"
heading = "phi"
centre = ["x", "y", "R"]
[[shapes]]
kind = "box"
lengths = [1, 2, 3]
attitude = [{ axis = "z", angle = "phi" }, { axis = "x", angle = "pi/2" }]
[[shapes]]
kind = "surface"
coordinates = ["a", "b"]
position = ["a", "b", "R*a^2"]
ranges = [[-1, 1], [0, "2*pi"]]
role = "ground"
title = "hill"
[[shapes]]
kind = "surface"
coordinates = ["x", "y"]
position = "R*x*y"
[[shapes]]
kind = "blade"
length = "R"
attitude = "phi"
"""


def test_shapes_are_those_of_python(tmp_path: Path) -> None:
    system = vo.load(written(tmp_path, ROLLER.replace("@", "") + SHAPES))
    x, y, phi, R, a, b = sp.symbols("x y phi R a b")
    cos, sin = sp.cos(phi), sp.sin(phi)
    turned = sp.Matrix([[cos, 0, sin], [sin, 0, -cos], [0, 1, 0]])
    assert system.shapes == (
        vo.Shape.wheel(R, phi, centre=(x, y, R)),
        vo.Shape.box((1, 2, 3), attitude=turned),
        vo.Shape.surface(
            (a, b), (a, b, R * a**2), ((-1, 1), (0, float(2 * sp.pi))), role="ground", title="hill"
        ),
        vo.Shape.surface((x, y), (x, y, R * x * y)),
        vo.Shape.blade(R, attitude=phi),
    )


STROKES = """
[sketch]
view = "seen from above"
strokes = [
  { draw = "axes", x = "x", y = "y", size = 2 },
  { draw = "line", points = [[0, 0], [1, "sqrt(2)"]], look = "thin" },
  { draw = "area", points = [[0, 0], [1, 0], [1, 1]] },
  { draw = "ellipse", at = [1, 0], width = 1, height = 2 },
  { draw = "angle", at = [1, 0.8], radius = 0.6, start = 0, end = 30, label = "phi" },
  { draw = "distance", start = [0, 0], end = [1, 0], label = "R" },
]
"""


def test_a_sketch_is_that_of_python(tmp_path: Path) -> None:
    system = vo.load(written(tmp_path, ROLLER.replace("@", "") + STROKES))
    drawn = vo.Sketch("seen from above").axes("x", "y", size=2)
    drawn = drawn.line((0, 0), (1, 2**0.5), look="thin").area((0, 0), (1, 0), (1, 1))
    drawn = drawn.ellipse((1, 0), 1, 2).angle((1, 0.8), 0.6, 0, 30, "phi")
    assert system.sketch == drawn.distance((0, 0), (1, 0), "R")
    assert system.sketch.svg() == drawn.distance((0, 0), (1, 0), "R").svg()


def test_an_empty_sketch_is_an_empty_picture(tmp_path: Path) -> None:
    system = vo.load(written(tmp_path, ROLLER.replace("@", "") + "[sketch]\n"))
    assert system.sketch.svg().startswith("<svg")


@pytest.mark.parametrize(
    ("picture", "message"),
    [
        (
            '[[shapes]]\nkind = "bal"',
            "line 20, column 8: shapes.kind, entry 1: 'bal' is no kind; did",
        ),
        ("[[shapes]]\nradius = 1", "line 19, column 3: shapes, entry 1: 'kind' is missing"),
        ('[[shapes]]\nkind = "ball"', "shapes, entry 1: 'radius' is missing; 'ball' needs it"),
        (
            '[[shapes]]\nkind = "plane"\n[[shapes]]\nkind = "ball"\nradius = "Q"',
            "line 23, column 11: shapes.radius, entry 2: 'Q' is neither coordinate",
        ),
        ('[[shapes]]\nkind = "plane"\ncentre = [1, 2]', "expected 3 entries in brackets"),
        ('[[shapes]]\nkind = "plane"\nsize = 2', "line 21, column 1: 'size' means nothing"),
        ('[[shapes]]\nkind = "ball"\nradius = "x"', "contains 'x', which is neither"),
        ('[sketch]\nstrokes = [{ draw = "arow" }]', "did you mean 'arrow'"),
        ('[sketch]\nstrokes = [{ draw = "dot", at = [0, "x"] }]', "'x' is not a number"),
        ('[sketch]\nstrokes = [{ draw = "dot", at = [0, 1e9] }]', "lies outside of the drawing"),
        ('[sketch]\nstrokes = [{ draw = "text", at = [0, 1], label = "$x" }]', "is no label"),
        (
            f'[sketch]\nstrokes = [{{ draw = "text", at = [0, 1], label = "{"a" * 400}$" }}]',
            "is no label",  # at once: nothing is read twice
        ),
        (
            '[sketch]\nstrokes = [{ draw = "distance", start = [0, 1], end = [0, 1], label = "" }]',
            "to itself is not drawn",
        ),
    ],
)
def test_a_picture_that_cannot_be_drawn_is_refused_with_its_place(
    tmp_path: Path, picture: str, message: str
) -> None:
    assert message in wrong(tmp_path, ROLLER.replace("@", "") + picture)


@pytest.mark.parametrize("mechanism", MECHANISMS, ids=lambda m: m.title)
def test_a_new_text_draws_what_the_new_python_file_draws(tmp_path: Path, mechanism) -> None:
    for name in ("python", "toml"):
        file = tmp_path / f"new.{'py' if name == 'python' else name}"
        file.write_text(getattr(mechanism, name).replace("@NAME@", "new"), "utf-8")
    one, other = vo.load(tmp_path / "new.py"), vo.load(tmp_path / "new.toml")
    assert one.sketch == other.sketch and one.shapes == other.shapes and len(one.shapes) == 2


def test_a_force_may_hold_the_second_rate_of_an_input(tmp_path: Path) -> None:
    text = (
        'name = "carriage"\nlagrangian = "xdot^2/2"\ncoordinates = { x = "" }\n'
        'inputs = { u = "place of the base" }\nforces = { x = "-udotdot" }\n'
    )
    system = vo.load(written(tmp_path, text))
    run = vo.integrate(system, initial={"xdot": 1}, inputs={"u": "sin(t)"}, times=[0, 1])
    assert abs(run["x"][-1] - float(2 - sp.sin(1))) < 1e-12
