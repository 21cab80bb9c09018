"""Control-affine form, and what brackets prove of it: textbook systems by their known answers."""

from __future__ import annotations

import random
from typing import Any

import pytest
import symengine as se
import sympy as sp

import voronec as vo
from voronec.algebra.jets import Expansion, Span
from voronec.errors import DefinitionError, EngineLimit

pytestmark = pytest.mark.slow

x, y, theta, phi, v, w, push, turn = sp.symbols("x y theta phi v w push turn")
m, J, K, L = sp.symbols("m J K L", positive=True)


def trailers(count: int, steered: bool = True) -> vo.System:
    """A car with its rear axle at (x, y), or a unicycle there, that pulls ``count`` trailers."""
    headings = sp.symbols(f"psi1:{count + 1}")
    dx, dy, dtheta, dphi = map(vo.velocity, (x, y, theta, phi))
    energy = (m * (dx**2 + dy**2) + J * dtheta**2) / 2
    constraints = [dx * sp.sin(theta) - dy * sp.cos(theta)]
    pace = dx, dy
    for psi in headings:
        turning = vo.velocity(psi)
        pace = pace[0] + turning * sp.sin(psi), pace[1] - turning * sp.cos(psi)
        energy += (pace[0] ** 2 + pace[1] ** 2) / 2
        constraints.append(pace[0] * sp.sin(psi) - pace[1] * sp.cos(psi))
    ahead = dx * sp.cos(theta) + dy * sp.sin(theta)
    parameters = vo.Parameter.each((m, J), (2, 3))
    if steered:
        front = dx - L * dtheta * sp.sin(theta), dy + L * dtheta * sp.cos(theta)
        constraints.append(front[0] * sp.sin(theta + phi) - front[1] * sp.cos(theta + phi))
        energy += K * dphi**2 / 2
        parameters += vo.Parameter.each((K, L), (1, 1))
        base, fibre, turned = (x, phi), (y, theta, *headings), dphi
    else:
        base, fibre, turned = (x, theta), (y, *headings), dtheta
    return vo.System(
        name="car" if steered else "unicycle",
        fibration=vo.Fibration(base, fibre),
        frame=vo.Frame.quasi({v: ahead, w: turned}),
        lagrangian=energy,
        constraints=tuple(constraints),
        parameters=parameters,
        forces={v: push, w: turn},
        inputs=(push, turn),
    )  # fmt: skip


def driven(name: str, *along: str) -> vo.System:
    """A system of the catalogue with inputs along some of its coordinates and velocities."""
    own = vo.load(name)
    names = {str(q): q for q in (*own.coordinates, *own.velocities)}
    inputs = sp.symbols(f"u1:{len(along) + 1}")
    return vo.System(
        name=f"driven-{name}", fibration=own.fibration, frame=own.frame,
        lagrangian=own.lagrangian, constraints=own.constraints, parameters=own.parameters,
        forces={names[q]: u for q, u in zip(along, inputs, strict=True)}, inputs=inputs,
    )  # fmt: skip


def snake(count: int) -> vo.System:
    """Links of length 2 in a row, each on a wheel in its middle, the first at (x, y)."""
    angles = sp.symbols(f"theta1:{count + 1}")
    dx, dy, *turns = map(vo.velocity, (x, y, *angles))
    pace, constraints = (dx, dy), []
    for k, (angle, turn) in enumerate(zip(angles, turns, strict=True)):
        if k:
            half = turns[k - 1] * sp.sin(angles[k - 1]), turns[k - 1] * sp.cos(angles[k - 1])
            pace = (
                pace[0] + half[0] + turn * sp.sin(angle),
                pace[1] - half[1] - turn * sp.cos(angle),
            )
        constraints.append(pace[0] * sp.sin(angle) - pace[1] * sp.cos(angle))
    return vo.System(
        name="snake", fibration=vo.Fibration((x, angles[0]), (y, *angles[1:])),
        frame=vo.Frame.quasi({v: dx * sp.cos(angles[0]) + dy * sp.sin(angles[0]), w: turns[0]}),
        lagrangian=(dx**2 + dy**2 + sum(e**2 for e in turns)) / 2, constraints=tuple(constraints),
    )  # fmt: skip


def planes(slopes: list[sp.Expr]) -> vo.System:
    """z_i' = slope_i y' over the plane of x and y."""
    heights = sp.symbols(f"z1:{len(slopes) + 1}")
    return vo.System(
        name="planes", fibration=vo.Fibration((x, y), heights),
        lagrangian=sum(vo.velocity(q) ** 2 for q in (x, y, *heights)),
        constraints=tuple(
            vo.velocity(z) - e * vo.velocity(y) for z, e in zip(heights, slopes, strict=True)
        ),
    )  # fmt: skip


def generic(count: int) -> list[sp.Expr]:
    """Polynomials in x and all coordinates that have nothing in common."""
    source, names = random.Random(7), [x, y, *sp.symbols(f"z1:{count + 1}")]
    return [
        sum(source.randint(1, 9) * x**k * sp.prod(source.choices(names, k=2)) for k in (1, 2, 3, 4))
        for _ in range(count)
    ]


GROWTH = {
    "ten trailers": (lambda: trailers(10, False), tuple(range(2, 14))),
    "snake of 14 links": (
        lambda: snake(14),
        (2, 3, 5, 6, 8, 9, 11, 12, 14, 15, 16),
    ),
    "Heisenberg": (lambda: planes([x]), (2, 3)),
    "Engel": (lambda: planes([x, x**2]), (2, 3, 4)),
    "Goursat": (lambda: planes([x, *sp.symbols("z1:7")]), tuple(range(2, 10))),
    # brackets of two fields without relations: 2, 1, 2, 3, 6 more in each step [Witt1937]
    "free to the fifth step": (lambda: planes(generic(12)), (2, 3, 5, 8, 14)),
    "unicycle": (lambda: trailers(0, False), (2, 3)),
    "unicycle, a trailer": (lambda: trailers(1, False), (2, 3, 4)),
    "car": (lambda: trailers(0), (2, 3, 4)),
    "car, a trailer": (lambda: trailers(1), (2, 3, 4, 5)),
    "car, two trailers": (lambda: trailers(2), (2, 3, 4, 5, 6)),
    "car, three trailers": (lambda: trailers(3), (2, 3, 4, 5, 6, 7)),
    "snakeboard": (lambda: vo.load("snakeboard"), (3, 4, 5)),
    "roller racer": (lambda: vo.load("roller-racer"), (2, 3, 4)),
    "rolling ball": (lambda: vo.load("homogeneous-ball"), (3, 5)),
    "rolling ball without spin": (lambda: vo.load("rubber-ball-on-plane"), (2, 3, 5)),
    "upright disc": (lambda: vo.load("vertical-disc"), (2, 3, 4)),
    "disc that leans": (lambda: vo.load("falling-disc"), (3, 4, 5)),
    # its wheels turn with it, l phi' = R (right' - left'): one direction is closed
    "two-wheeled carriage": (lambda: vo.load("two-wheeled-carriage"), (2, 3, 4)),
}
"""[MurrayLiSastry1994], [Laumond1993], [OstrowskiLewisMurrayBurdick1994]."""


@pytest.mark.parametrize("name", GROWTH)
def test_growth_vectors_of_textbooks(name: str) -> None:
    make, growth = GROWTH[name]
    assert vo.derive(make()).growth == growth


def test_the_form_is_that_of_the_equations() -> None:
    """f + g u against accelerations in balls, from another form of the equations."""
    eqs = vo.derive(trailers(1))
    form = eqs.control
    assert form.drift.shape == (7, 1) and form.fields.shape == (7, 2)
    source = random.Random(2)
    point = {s: sp.Rational(source.randint(1, 9), 10) for s in form.state}
    point |= {p.symbol: p.value for p in eqs.system.parameters}
    given = {push: sp.Rational(3, 7), turn: -2}
    rates = form.drift + form.fields * sp.Matrix([given[u] for u in form.inputs])
    at = dict(zip(form.state, rates.xreplace(point), strict=True))
    truth = eqs.acceleration(point | given)
    for q, rate in zip(eqs.coordinates, eqs.rates, strict=True):
        found = sum(rate.diff(s) * e for s, e in at.items()).xreplace(point)
        assert abs(sp.N(found - truth[q], 20)) < 1e-15


def test_the_form_of_the_sleigh_is_short() -> None:
    form = vo.derive(driven("sleigh", "v", "w")).control
    own = {str(s): s for s in form.drift.free_symbols | form.fields.free_symbols}
    by_hand = sp.Matrix([1 / own["m"], 1 / (own["J"] + own["a"] ** 2 * own["m"])])
    assert vo.prove_equal(form.fields[3, 0], by_hand[0]).proved
    assert vo.prove_equal(form.fields[4, 1], by_hand[1]).proved
    assert form.fields[:3, :] == sp.zeros(3, 2) and form.underactuation == 0
    assert len(str(vo.derive(driven("robot-with-two-trailers", "v", "w")).control.drift)) < 1500


REACH = {
    "sleigh": (("sleigh", "v", "w"), "proved", "proved"),
    "disc driven and steered": (("vertical-disc", "theta", "phi"), "proved", "proved"),
    "robot, two trailers": (("robot-with-two-trailers", "v", "w"), "proved", "proved"),
    "sleigh turned only": (("sleigh", "w"), "proved", "refuted"),
    "roller racer": (("roller-racer", "phi"), "proved", "refuted"),
    "two-wheeled carriage": (("two-wheeled-carriage", "left", "right"), "refuted", "refuted"),
    "disc that leans": (("falling-disc", "s", "q"), "proved", "proved"),
    "disc that leans, driven only": (("falling-disc", "s"), "proved", "undecided"),
}


@pytest.mark.parametrize("name", REACH)
def test_what_can_be_reached(name: str) -> None:
    system, accessible, controllable = REACH[name]
    form = vo.derive(driven(*system)).control
    assert form.accessibility.verdict.status == accessible
    assert form.controllability().status == controllable


def test_a_car_is_controllable_from_rest_with_up_to_three_trailers() -> None:
    for count in range(4):
        form = vo.derive(trailers(count)).control
        assert form.underactuation == 0
        assert form.accessibility.growth[-1] == form.accessibility.dimension == 6 + count
        assert form.controllability().proved


def test_exceptions_name_where_inputs_have_no_effect() -> None:
    """A feedback that gives the velocities any rates is there only where inputs reach them."""
    u, push = sp.Symbol("u"), sp.Function("push")(vo.time)
    for force, exception in ((x * push, x), ((u - 1) * push, u - 1)):
        line = vo.System(
            name="line", fibration=vo.Fibration(base=(x,)), lagrangian=vo.velocity(x) ** 2 / 2,
            parameters=(u,), forces={x: force},
        )  # fmt: skip
        found = vo.derive(line).control.accessibility
        assert found.verdict.proved and found.exceptions == (exception,)


def test_exceptions_name_where_brackets_fail() -> None:
    """The sleigh with its mass at the blade: turning does not push it."""
    found = vo.derive(driven("sleigh", "w")).control.accessibility
    assert found.verdict.proved and any(str(f) == "a" for f in found.exceptions)
    found = vo.derive(driven("sleigh", "v", "w")).control.accessibility
    assert [str(f) for f in found.exceptions] == ["w"]  # for these brackets: at rest others help


def test_without_the_arm_the_sleigh_is_not_accessible() -> None:
    sleigh = driven("sleigh", "w")
    a = next(p for p in sleigh.parameters if p.name == "a")
    fixed = vo.System(
        name="balanced", fibration=sleigh.fibration, frame=sleigh.frame,
        lagrangian=sleigh.lagrangian.subs(a.symbol, 0), constraints=sleigh.constraints,
        parameters=tuple(p for p in sleigh.parameters if p is not a),
        forces=sleigh.forces, inputs=sleigh.inputs,
    )  # fmt: skip
    assert vo.derive(fixed).control.accessibility.verdict.refuted


def test_flat_outputs() -> None:
    """The middle of the last axle is flat [RouchonFliessLevineMartin1993]; that of the first, with
    trailers behind it, is not."""
    robot = vo.load("robot-with-two-trailers")
    names = {str(s): s for s in (*robot.coordinates, *(p.symbol for p in robot.parameters))}
    last = [
        names[q] - names["l1"] * f(names["theta1"]) - names["l2"] * f(names["theta2"])
        for q, f in (("x", sp.cos), ("y", sp.sin))
    ]
    form = vo.derive(driven("robot-with-two-trailers", "v", "w")).control
    found = form.flat(last)
    assert found.proved and "5 of their rates" in found.method
    assert form.flat([names["x"], names["y"]]).refuted  # the trailers are not seen
    assert vo.derive(trailers(0)).control.flat([x, y]).proved
    with pytest.raises(DefinitionError, match="1 flat outputs for 2 inputs"):
        form.flat([names["x"]])


def test_what_is_not_accessible_is_not_controllable() -> None:
    """x'' = u, y'' = x x': y' - x^2/2 stays."""
    dx, dy = vo.velocity(x), vo.velocity(y)
    system = vo.System(
        name="hidden-integral", fibration=vo.Fibration((x, y), ()), inputs=(push,),
        lagrangian=(dx**2 + dy**2) / 2, forces={x: push, y: x * dx},
    )  # fmt: skip
    control = vo.derive(system).control
    assert control.accessibility.verdict.refuted
    found = control.controllability()
    assert found.refuted and "3 dimensions of 4 on the whole domain" in found.method


def test_controllability_where_inputs_hold_the_system() -> None:
    """A pendulum at any angle that a torque holds; a torque on one that a force holds aside."""
    angle = sp.Symbol("angle")
    swing = vo.velocity(angle) ** 2 / 2 + sp.cos(angle)
    held = vo.System(
        name="held", fibration=vo.Fibration(angle), lagrangian=swing, forces={angle: turn},
        inputs=(turn,),
    )  # fmt: skip
    control = vo.derive(held).control
    at = {angle: sp.atan(sp.Rational(3, 4))}
    assert control.controllability({**at, turn: sp.Rational(3, 5)}).proved
    with pytest.raises(DefinitionError, match="no equilibrium with these inputs"):
        control.controllability(at)
    dx, dy = vo.velocity(x), vo.velocity(y)
    aside = vo.System(
        name="aside", fibration=vo.Fibration((x, y), ()), lagrangian=(dx**2 + dy**2) / 2,
        forces={x: push - 1, y: dx**2 * push}, inputs=(push,),
    )  # fmt: skip
    assert vo.derive(aside).control.controllability({push: 1}).refuted  # y'' is not negative


def test_what_turns_at_a_wall_is_not_said_of_the_whole_domain() -> None:
    """x'' = u, y'' = |x| + x: nothing reaches y where x < 0; y'' = sign(x): y changes with x."""

    def pushed(force: sp.Expr) -> vo.System:
        return vo.System(
            name="pushed", fibration=vo.Fibration((x, y), ()), inputs=(push,),
            lagrangian=(vo.velocity(x) ** 2 + vo.velocity(y) ** 2) / 2, forces={x: push, y: force},
        )  # fmt: skip

    for force in (sp.Abs(x) + x, sp.Max(x, 0)):
        found = vo.derive(pushed(force)).control.accessibility.verdict
        assert found.proved and found.method.endswith("so near it")
    found = vo.derive(pushed(sp.sign(x))).control.accessibility.verdict
    assert found.refuted and "off the switching surfaces where signs turn" in found.method
    for force in (x**3, sp.sqrt(1 + x**2), x / (1 + y)):
        found = vo.derive(pushed(force)).control.accessibility.verdict
        assert found.proved and "on an open dense set" in found.method


def test_a_point_lies_on_the_relations_between_coordinates() -> None:
    """A quaternion of another size, or zero where nothing is said, is refused."""
    q, torques = sp.symbols("q0:4"), sp.symbols("u1:4")
    omega = sp.symbols("omega1:4")
    a, b, c, d = q
    p, r, s, t = map(vo.velocity, q)
    turn = 2 * (a * r - b * p - c * t + d * s), 2 * (a * s - c * p - d * r + b * t)
    turn += (2 * (a * t - d * p - b * s + c * r),)
    unit = sum(e**2 for e in q) - 1
    system = vo.System(
        name="top", fibration=vo.Fibration(q, relations=(unit,)), inputs=torques,
        frame=vo.Frame.quasi(dict(zip(omega, turn, strict=True))),
        lagrangian=sum(n * e**2 for n, e in zip((2, 3, 5), turn, strict=True)) / 2,
        forces=dict(zip(omega, torques, strict=True)),
    )  # fmt: skip
    control = vo.derive(system).control
    assert control.controllability({a: 1}).proved
    points: tuple[dict[Any, Any], ...] = ({}, {a: 2})
    for point in points:
        with pytest.raises(DefinitionError, match="off the relation") as caught:
            control.controllability(point)
        assert "\n" not in str(caught.value)


def test_bad_input_is_refused_in_one_line() -> None:
    def cart(force: Any, **changes: Any) -> vo.System:
        return vo.System(
            name="cart", fibration=vo.Fibration(x), lagrangian=vo.velocity(x) ** 2 / 2,
            forces={x: force}, inputs=(push,), **changes,
        )  # fmt: skip

    cases = {
        "enters nonlinearly": lambda: vo.derive(cart(push**2)).control,
        "has no inputs": lambda: vo.derive(vo.load("sleigh")).control,
        "the rate of the input": lambda: vo.derive(cart(vo.velocity(push))).control,
        "no equilibrium": lambda: vo.derive(cart(push - 1)).control.controllability(),
        "does not have": lambda: vo.derive(cart(push)).control.controllability({"z": 1}),
        "no value at the point": lambda: vo.derive(cart(push - 1 / x)).control.controllability(),
        "gives no value to 'm'": lambda: vo.derive(
            cart(push - m * x, parameters=(m,))
        ).control.controllability(),
    }
    for words, ask in cases.items():
        with pytest.raises(DefinitionError, match=words) as caught:
            ask()
        assert "\n" not in str(caught.value)
    a = se.Symbol("a")
    expansion = Expansion({a: se.pi / 4}, [a], 2)
    with pytest.raises(EngineLimit, match="no rational number"):
        expansion.of(se.cos(a))
    singular = vo.derive(cart(push / x)).control
    with pytest.raises(EngineLimit, match="singular at this point"):
        singular.controllability()


def test_expansions_are_those_of_sympy() -> None:
    a, b = se.symbols("a b")
    expr = se.sin(a + 2 * b) * se.exp(b) / (1 + a - b) ** 2 + se.sqrt(4 + a) + se.log(1 + b)
    expr += se.tan(a) * se.cosh(b) + se.cos(3 * a)
    h = sp.symbols("h")
    for values in ((0, 0), (sp.atan(sp.Rational(3, 4)), 0)):
        if values[0] != 0:
            expr = se.sin(a + b) * se.cos(2 * a) / (2 + se.cos(a - b))
        at = dict(zip((a, b), map(se.sympify, values), strict=True))
        parts = Expansion(at, [a, b], 4).of(expr)
        along = sp.sympify(expr).subs({"a": values[0] + 3 * h, "b": values[1] + 5 * h})
        truth = [along.diff(h, k).subs(h, 0) / sp.factorial(k) for k in range(5)]
        for part, value in zip(parts, truth, strict=True):
            found = part(3, 5, 0)
            assert abs(sp.N(value, 30) - sp.Rational(int(found.p), int(found.q))) < 1e-25


def test_expansions_at_numbers_are_those_of_sympy() -> None:
    """Sine and cosine of k/6 are rational in t = tan(1/12), the last letter."""
    a, b = se.symbols("a b")
    expr = se.sin(a + b) * se.cos(2 * a) / (2 + se.cos(a - b)) + 1 / (se.sin(a) + b) ** 2
    values = sp.Rational(1, 3), -sp.Rational(1, 2)
    parts = Expansion(dict(zip((a, b), map(se.sympify, values), strict=True)), [a, b], 3).of(expr)
    h, t = sp.symbols("h"), sp.tan(sp.Rational(1, 12)).n(60)
    along = sp.sympify(expr).subs({"a": values[0] + 3 * h, "b": values[1] + 5 * h})

    def at(poly: Any) -> sp.Expr:
        terms = poly.to_dict().items()
        return sum(sp.Rational(int(c.p), int(c.q)) * 3**i * 5**j * t**k for (i, j, k), c in terms)

    for k, part in enumerate(parts):
        truth = sp.N(along.diff(h, k).subs(h, 0) / sp.factorial(k), 40)
        assert abs(truth - at(part.above) / at(part.below)) < 1e-30
    still, moved = Expansion({a: se.Integer(0)}, [a], 1).of(se.sin(1) * (1 + a))
    half = sp.tan(sp.Rational(1, 2)).n(60)
    for part, power in ((still, (0, 1)), (moved, (1, 1))):
        assert part.above.to_dict() == {power: 2}
        below = sum(int(c) * half**i for (_, i), c in part.below.to_dict().items())
        assert abs(2 * half / below - sp.sin(1).n(60)) < 1e-30


def test_controllability_at_regular_points() -> None:
    """At angles that are numbers, and where angles stand in differences alone."""
    third = sp.Rational(1, 3)
    car = vo.derive(trailers(1)).control
    for angle in (third, sp.pi / 2):
        aside = {"theta": angle, "psi1": angle}
        assert car.controllability(aside).proved
        assert car.controllability({**aside, "phi": third}).proved
    swing = vo.velocity(theta) ** 2 / 2 + sp.cos(theta)
    held = vo.System(
        name="held", fibration=vo.Fibration(theta), lagrangian=swing, forces={theta: turn},
        inputs=(turn,),
    )  # fmt: skip
    pendulum = vo.derive(held).control
    assert pendulum.controllability({theta: third, turn: sp.sin(third)}).proved
    with pytest.raises(DefinitionError, match="no equilibrium"):
        pendulum.controllability({theta: third, turn: third})


@pytest.mark.parametrize("name", ["unicycle, a trailer", "snake", "planes", "in time"])
def test_growth_by_brackets_in_sympy(name: str) -> None:
    """Brackets that SymPy makes of the rates of the coordinates, at a rational point."""
    rising = vo.System(
        name="rising", fibration=vo.Fibration((x,), (y,)), lagrangian=vo.velocity(x) ** 2 / 2,
        constraints=(vo.velocity(y) - vo.time * vo.velocity(x),),
    )  # fmt: skip
    systems = {
        "unicycle, a trailer": trailers(1, False), "snake": snake(2), "in time": rising,
        "planes": planes(generic(2)),
    }  # fmt: skip
    eqs = vo.derive(systems[name])
    names = (*eqs.coordinates, vo.time)
    fields = [sp.Matrix([*(rate.diff(u) for rate in eqs.rates), 0]) for u in eqs.velocities]
    if name == "in time":
        rest = dict.fromkeys(eqs.velocities, 0)
        fields.append(sp.Matrix([*(rate.subs(rest) for rate in eqs.rates), 1]))
    source, span, tops, found = random.Random(3), list(fields), list(fields), []
    at = {q: sp.Rational(source.randint(1, 9), 10) for q in names}
    while found[-1:] != [eqs.distribution.dimension]:
        numbers = sp.Matrix.hstack(*span).subs(at).evalf(60)
        found.append(numbers.rank(iszerofunc=lambda e: abs(e) < 1e-40))
        tops = [b.jacobian(names) * a - a.jacobian(names) * b for a in fields for b in tops]
        span += tops
    assert eqs.growth == tuple(found)


def test_brackets_of_jets_obey_jacobi() -> None:
    a, b, c = se.symbols("a b c")
    fields = [(b * c, se.sin(a), 1 + a * b), (se.exp(b), c, a), (a**2, se.cos(c), b / (1 + c))]
    expansion = Expansion(dict.fromkeys((a, b, c), se.Integer(0)), [a, b, c], 5)
    f, g, h = (expansion.field([se.sympify(e) for e in field]) for field in fields)
    total: dict[Any, Any] = {}
    for p, q, r in ((f, g, h), (g, h, f), (h, f, g)):
        for key, value in p.bracket(q.bracket(r)).coefficients.items():
            total[key] = total.get(key, 0) + value
    assert total and all(value == 0 for value in total.values())


def test_a_span_knows_what_lies_in_it() -> None:
    span = Span()
    import flint

    rows = [{0: flint.fmpq(1), 1: flint.fmpq(2)}, {1: flint.fmpq(1), 2: flint.fmpq(1)}]
    assert all(span.add(row) for row in rows) and len(span) == 2
    assert not span.remainder({0: flint.fmpq(1), 2: flint.fmpq(-2)})
    assert span.remainder({2: flint.fmpq(1)})


def test_a_bad_bracket_obstructs() -> None:
    """z'' = x'^2 only grows: no state with less z is reached, though the brackets span everything;
    where z'' = x' y' both signs can be had."""
    z, u1, u2 = sp.symbols("z u1 u2")
    dx, dy, dz = map(vo.velocity, (x, y, z))

    def pushed(force: sp.Expr) -> vo.System:
        return vo.System(
            name="pushed", fibration=vo.Fibration((x, y, z)), inputs=(u1, u2),
            lagrangian=(dx**2 + dy**2 + dz**2) / 2, forces={x: u1, y: u2, z: force},
        )  # fmt: skip

    one_way = vo.derive(pushed(dx**2)).control
    assert one_way.accessibility.verdict.proved
    found = one_way.controllability()
    assert found.undecided and "Sussmann's condition fails" in found.method
    assert vo.derive(pushed(dx * dy)).control.controllability().proved


def pushed(force: sp.Expr) -> vo.Control:
    place, push = sp.symbols("x u")
    block = vo.System(
        name="block", fibration=vo.Fibration(place), lagrangian=vo.velocity(place) ** 2 / 2,
        forces={place: force}, inputs=(push,),
    )  # fmt: skip
    return vo.derive(block).control


PLACE, PUSH = sp.symbols("x u")
SPEED = vo.velocity(PLACE)
REST = {PLACE: 0, SPEED: 0}


@pytest.mark.parametrize(
    "drift",
    [
        -sp.sign(SPEED),
        -2 * sp.sign(PLACE),
        -PLACE - sp.floor(SPEED),
        sp.Heaviside(PLACE),
        -PLACE * sp.sign(SPEED),
    ],
)
def test_small_inputs_do_not_overcome_a_jump(drift) -> None:
    """Friction holds the block against |u| < 1; only a large input undoes it."""
    with pytest.raises(vo.VoronecError):
        assert not pushed(PUSH + drift).controllability(REST).proved


@pytest.mark.parametrize("drift", [-SPEED * abs(SPEED), sp.Max(0, SPEED)])
def test_what_is_continuous_at_the_point_is_overcome(drift) -> None:
    assert pushed(PUSH + sp.nsimplify(drift)).controllability(REST).proved


@pytest.mark.parametrize(
    "force",
    [
        sp.Max(-1, sp.Min(1, PUSH)) - 1,
        sp.Max(PUSH - 1, 0) + sp.Min(PUSH + 1, 0),
        sp.Max(1, PUSH),
        PUSH + sp.Abs(PUSH),
    ],
)
def test_an_input_that_saturates_is_not_linear(force) -> None:
    with pytest.raises(vo.DefinitionError, match="enters nonlinearly"):
        pushed(force)


def test_constraints_that_are_linear_in_pieces_are_refused() -> None:
    y = sp.Symbol("y")
    rate = vo.velocity(y)
    system = vo.System(
        name="dead", fibration=vo.Fibration((PLACE,), (y,)),
        lagrangian=(SPEED**2 + rate**2) / 2,
        constraints=(rate - sp.Max(SPEED - 1, 0) - sp.Min(SPEED + 1, 0),),
    )  # fmt: skip
    with pytest.raises(vo.DefinitionError, match="affine"):
        vo.derive(system)


def test_inputs_that_constraints_take_up_move_nothing() -> None:
    y = sp.Symbol("y")
    rate = vo.velocity(y)
    held = vo.System(
        name="held", fibration=vo.Fibration((PLACE,), (y,)), lagrangian=(SPEED**2 + rate**2) / 2,
        constraints=(rate,), forces={y: PUSH}, inputs=(PUSH,),
    )  # fmt: skip
    found = vo.derive(held).control.accessibility
    assert found.verdict.refuted and found.growth == (0,)


def test_wheels_that_turn_as_the_heading_does_are_never_reached_apart() -> None:
    """A pendulum on two wheels: right - left is the heading times 2 b/R, which brackets of all of
    the state are too large to say."""
    names = "x phi theta y left right R b h g push pull"
    x, phi, theta, y, left, right, R, b, h, g, push, pull = sp.symbols(names)
    dx, dphi, dtheta, dy, dleft, dright = map(vo.velocity, (x, phi, theta, y, left, right))
    v, w, p = sp.symbols("v w p")
    ahead = dx * sp.cos(phi) + dy * sp.sin(phi)
    lean, side = h * sp.cos(theta) * dtheta + ahead, h * sp.sin(theta) * dphi
    energy = lean**2 + side**2 + (h * sp.sin(theta) * dtheta) ** 2 + dx**2 + dy**2 + dphi**2
    robot = vo.System(
        name="two-wheeled-pendulum",
        fibration=vo.Fibration(base=(x, phi, theta), fibre=(y, left, right)),
        frame=vo.Frame.quasi({v: ahead, w: dphi, p: dtheta}),
        lagrangian=energy / 2 + dleft**2 + dright**2 - g * h * sp.cos(theta),
        constraints=(
            dx * sp.sin(phi) - dy * sp.cos(phi),
            ahead - b * dphi - R * dleft,
            ahead + b * dphi - R * dright,
        ),
        parameters=(R, b, h, g),
        forces={left: push, right: pull, theta: -push - pull},
        inputs=(push, pull),
    )
    found = vo.derive(robot).control.accessibility
    assert (
        found.verdict.refuted and found.growth[-1] == 8 and "5 of their 6" in found.verdict.method
    )
