"""Arguments of the wrong kind are refused in one line that names them, by every public function."""

import inspect
import math
from contextlib import suppress
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from functools import cache

import mpmath
import numpy as np
import pytest
import symengine as se
import sympy as sp

import voronec as vo
from voronec.algebra.arguments import COUNT, REAL, accepts
from voronec.algebra.text import in_doubles
from voronec.equations.program.dialect import Dialect, code, text
from voronec.errors import DefinitionError, EngineLimit, IntegrationError, VoronecError

pytestmark = pytest.mark.slow

x, m, u = sp.symbols("x m u")
HUGE = sp.exp(sp.exp(sp.Integer(700000000)))


class Untold:
    def __str__(self):
        raise RuntimeError

    __repr__ = __str__


class Silent:
    """An object that pretends to have everything."""

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        return self


@cache
def motion(**options):
    return vo.integrate(system(), times=[0, 0.5, 1], dense=True, **options)


def system(**changes):
    own = {
        "name": "s",
        "fibration": vo.Fibration((x,)),
        "lagrangian": m * vo.velocity(x) ** 2 / 2 - x**2,
        "parameters": (vo.Parameter(m, 1),),
        "scenes": {"default": vo.Scene({x: 1}, (0, 1))},
    }
    return vo.System(**(own | changes))


DOORS = {
    "times": lambda: vo.Scene({}, 20.0),
    "times = 3.0 is no pair": lambda: vo.Scene({}, np.array(3.0)),
    "times = (0, 0)": lambda: vo.Scene({}, (0, 0)),
    "times = inf": lambda: vo.Scene({}, (0, math.inf)),
    "scene = 3": lambda: vo.integrate(system(), scene=3),
    "tol": lambda: vo.integrate(system(), tol=Decimal("0.1")),
    "tol = 1e-": lambda: vo.integrate(system(), tol="1e-"),
    "tol = oo": lambda: vo.integrate(system(), tol=sp.oo),
    "tol = x": lambda: vo.integrate(system(), tol=sp.Symbol("x")),
    "method": lambda: vo.integrate(system(), method=["heyoka"]),
    "progress": lambda: vo.integrate(system(), progress=1),
    "dense": lambda: vo.integrate(system(), dense=np.array([1, 2])),
    "events": lambda: vo.integrate(system(), events=3.5),
    "is not a real number": lambda: vo.integrate(system(), initial={"x": Untold()}),
    "that a double holds": lambda: vo.integrate(system(), initial={"x": 10**400}),
    "a double holds": lambda: vo.integrate(system(), parameters={"m": HUGE}),
    "beyond doubles": lambda: vo.integrate(system(), outputs=(x + HUGE,)),
    "start 'x'": lambda: vo.ensemble(system(), {"x": [[0], [1, 2]]}, times=[0, 1]),
    "crossings": lambda: vo.section(system(), "x", crossings=2.5),
    "is not a voronec.System": lambda: vo.multiplier_acceleration("sleigh", {}),
    "not a voronec.System": lambda: vo.check_claims(3),
    "not a voronec.Relation": lambda: vo.check_relation("a -> b"),
    "relation = [1]": lambda: vo.prove_inequality(x, [1]),
    "flow": lambda: vo.divergence(x, [x]),
    "the name of an invariant": lambda: vo.descend(system(), {None: x}),
    "matrix = 3": lambda: vo.kinematics.wedge_square(3),
    "body = 1": lambda: vo.kinematics.RollingContact(1, 2, x),
    "digits": lambda: vo.closed_form(vo.load("demchenko")).enclose(1, digits="many"),
    "the name '' (a parameter)": lambda: system(parameters=(m, sp.Symbol(""))),
    "is no word": lambda: system(parameters=(m, sp.Symbol("a\nimport os"))),
    "at most": lambda: system(parameters=(m, sp.Symbol("a" * 300))),
    "among its integrals": lambda: system(integrals={"a\nb": x}),
    "of kind MatrixSymbol": lambda: vo.kinematics.contact_momentum(
        (1, 2, 3), sp.MatrixSymbol("A", 2, 2), (1, 2, 3), (0, 0, 1)
    ),
    "the mass of a ball": lambda: vo.kinematics.RollingBall.on_plane(
        1, sp.MatrixSymbol("A", 2, 2), (1, 2, 3)
    ),
    "a relation: name": lambda: vo.Relation("a", "b", name=np.array([0.0, math.nan])),
    "a relation: source": lambda: vo.Relation(Untold(), "b"),
    "a square: a label": lambda: vo.Square((Untold(),), ("a -> b",)),
    "'x' = ": lambda: vo.derive(system()).acceleration({"x": Silent(), "xdot": 1}),
    "the point gives 'x'": lambda: vo.derive(system()).acceleration({"x": Untold(), "xdot": 1}),
    "'xdot' = ": lambda: vo.derive(system()).acceleration({"x": 0, "xdot": "9e999999999"}),
    "a whole number": lambda: vo.HardCase(
        "n", "sleigh", vo.Scene({x: 1}, outputs=(x,)), points="x"
    ),
}


def boom(*_):
    raise ValueError("two\nlines")


CALLED = {
    "ensemble": lambda f: vo.ensemble(
        vo.load("sleigh"), {"v": [1, 2]}, times=[0, 1], method="scipy", progress=f
    ),
    "section": lambda f: vo.section(
        vo.load("sleigh"), plane="x", crossings=1, until=1, method="scipy", progress=f
    ),
    "search_integrals": lambda f: vo.search_integrals(
        vo.load("sleigh"), degree=1, positions=1, progress=f
    ),
}


@pytest.mark.parametrize("progress", [len, boom, 3])
@pytest.mark.parametrize("door", CALLED)
def test_what_a_function_of_the_user_raises_is_told_as_its_own(door, progress):
    with pytest.raises(DefinitionError, match=f"{door}: .*progress") as caught:
        CALLED[door](progress if door != "search_integrals" or progress != len else boom)
    assert str(caught.value).isprintable()
    if progress is boom:
        assert isinstance(caught.value.__cause__, ValueError)


@pytest.mark.parametrize("word", DOORS)
def test_a_wrong_kind_is_refused_in_one_line(word):
    with pytest.raises(VoronecError) as caught:
        DOORS[word]()
    message = str(caught.value)
    assert word in message and message.isprintable() and isinstance(caught.value, DefinitionError)


@pytest.mark.parametrize(
    "times",
    [
        [0.0, np.complex128(1j), 1.0], 1j, [sp.I], [HUGE, 0.5], [HUGE, m], [Untold()], [Silent()],
        [0.0, math.nan], [0, [1, 2]], np.array([0, 1], dtype="datetime64[s]"), (i for i in (0, 1)),
    ],
)  # fmt: skip
def test_every_reader_of_times_refuses_what_is_no_time(times):
    own = system(inputs=(u,), forces={x: u})
    for read in (
        motion().at,
        motion(method="flint", tol=1e-25).at,
        lambda t: vo.integrate(system(), times=t),
        lambda t: vo.integrate(own, times=1, inputs={u: vo.Table(t, t)}),
    ):
        with pytest.raises(DefinitionError) as caught:
            read(times)
        assert str(caught.value).isprintable()


@pytest.mark.parametrize(
    "third", [mpmath.mpf(1) / 3, sp.Rational(1, 3), Fraction(1, 3), "1/3", np.float64(1 / 3)]
)
def test_a_time_of_every_kind_of_number_is_that_time(third):
    """x'' = -2 x from x = 1 at rest, with m = 1: x = cos(sqrt(2) t)."""
    assert motion().at(third)["x"][0] == pytest.approx(math.cos(math.sqrt(2) / 3), abs=1e-11)
    assert motion().at([third, 0.5]).t.dtype == float


@pytest.mark.parametrize("third", [sp.Rational(1, 3), Fraction(1, 3), "1/3"])
def test_an_exact_time_keeps_its_digits_in_a_motion_of_many(third):
    with mpmath.workdps(50):
        found = motion(method="flint", tol=1e-30).at([third])["x"][0]
        assert abs(found - mpmath.cos(mpmath.sqrt(2) / 3)) < 1e-28


def test_a_number_of_single_precision_is_the_number_it_is():
    """0.1 in single precision is 13421773/2^27, and not the tenth that its text says."""
    equations = vo.derive(system())
    found = equations.acceleration({"x": np.float32(0.1), "xdot": 0}, 25)
    assert abs(found[x] + sp.Rational(13421773, 2**26)) < 1e-24


def test_messages_are_one_printable_line():
    assert str(EngineLimit("two\nlines\x1b[31m")) == r"two lines\x1b[31m"


def test_a_function_names_itself_and_its_argument():
    @accepts(count=COUNT, size=REAL)
    def grow(count: int, size: float = 1.0) -> float:
        return count * size

    assert grow(2, size=3.5) == 7 and grow(sp.Integer(2)) == 2.0
    for bad in (True, 2.0, "2", None, 2**70):
        with pytest.raises(DefinitionError, match=r"grow: count = .* is not a whole number"):
            grow(bad)
    with pytest.raises(TypeError):
        grow(1, 2, 3)


@pytest.mark.parametrize(
    ("make", "near"),
    [
        (lambda: system(constrains=()), "System.* 'constrains'; did you mean 'constraints'"),
        (lambda: vo.Scene(initail={}), "Scene.* 'initail'; did you mean 'initial'"),
        (lambda: vo.Relation.of(system(), "s", clok=2), "'clok'; did you mean 'clock'"),
        (lambda: vo.integrate(system(), params={}), "integrate.* did you mean 'parameters'"),
        (lambda: vo.linearise(vo.derive(system()), point={}), "'point'; there are: at, equations"),
        (lambda: vo.search_integrals(system(), degre=1), "'degre'; did you mean 'degree'"),
        (lambda: vo.check_catalogue(job=1), "'job'; did you mean 'jobs'"),
    ],
)
def test_a_misspelled_argument_is_answered_with_the_nearest(make, near):
    with pytest.raises(TypeError, match=near):
        make()


def test_a_class_that_refuses_other_arguments_says_what_it_takes():
    assert [*inspect.signature(vo.Scene).parameters][:2] == ["initial", "times"]
    assert replace(system(), title="one").title == "one"


def test_numbers_are_followed_in_doubles_without_being_written_out():
    expr = sp.sqrt(2) * sp.sin(3) + sp.Rational(1, 3) ** 5 - sp.atan2(1, -2)
    assert in_doubles(expr) == pytest.approx(float(expr), rel=1e-14)
    assert in_doubles(x + 1) is None and in_doubles(sp.gamma(3 + sp.pi)) is None
    deep = x
    for _ in range(200):  # a graph whose tree has 2^200 leaves
        deep = sp.Add(deep, sp.sin(deep, evaluate=False), evaluate=False)
    assert in_doubles(deep) is None
    for huge in (HUGE, x * HUGE, sp.Integer(10) ** 400, x + sp.Float("1e400")):
        with pytest.raises(OverflowError):
            in_doubles(huge)


def test_names_are_quoted_in_source_and_never_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run = "__import__('os').mkdir('run')"
    for name in (f'"""+{run}+"""', f"*/ {run} /*", f"a # {run}", "\\", f"');{run};('"):
        odd = sp.Symbol(name)
        own = system(
            lagrangian=m * vo.velocity(x) ** 2 / 2 - odd * x**2,
            parameters=(vo.Parameter(m, 1), vo.Parameter(odd, 2)),
            integrals={name: m * vo.velocity(x) ** 2 / 2 + odd * x**2},
        )
        eqs = vo.derive(own)
        space: dict[str, object] = {}
        exec(compile(eqs.python(), "generated", "exec"), space)
        assert eqs.c().count("/*") == eqs.c().count("*/")
        for method, tol in (("scipy", 1e-9), ("flint", 1e-20)):
            done = vo.integrate(own, times=[0, 1], outputs=(x, name), method=method, tol=tol)
            assert float(done["x"][-1]) == pytest.approx(math.cos(2), rel=1e-6)
    assert not any(tmp_path.iterdir())


def test_generated_source_gives_arrays_of_one_shape():
    rates: dict[str, object] = {}
    exec(vo.derive(system(lagrangian=m * vo.velocity(x) ** 2 / 2 - 3 * m * x)).python(), rates)
    state = np.array([[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]])
    slope, pull = rates["rhs"](0.0, state, [2.0])
    assert np.shape(pull) == np.shape(slope) == (3,) and (pull == -3).all()
    assert rates["rhs"](0.0, [0.0, 1.0], [2.0]) == [1.0, -3.0]


def test_source_that_python_cannot_compile_is_a_limit():
    assert eval(code("(" * 50 + "1" + ")" * 50, "<source>", "eval")) == 1
    for source in ("(" * 5000 + "1" + ")" * 5000, "-" * 300_000 + "1"):
        with pytest.raises(EngineLimit, match="too large"):
            code(source, "<source>", "eval")


def test_a_case_that_is_no_system_is_named_and_the_others_stand():
    own = system(
        integrals={"energy": m * vo.velocity(x) ** 2 / 2 + x**2},
        cases={"no mass": vo.Case({m: 0}, integrals={"place": x})},
    )
    found = {(c.kind, c.name): c.verdict for c in vo.check_claims(own)}
    assert found["integral", "energy"].proved
    assert found["case", "no mass"].refuted


def test_sums_of_thousands_of_terms_are_source_that_python_compiles():
    names = {se.Symbol(f"a{n}"): f"a{n}" for n in range(50_000)}
    total = se.Add(*[(-1) ** n * name for n, name in enumerate(names)])
    dialect = Dialect(str, lambda p, q: f"{p}/{q}", lambda b, e: f"({b})**{e}", "pi", {})
    values = {name: n**2 for n, name in enumerate(names.values())}
    written = code(text(total, dialect, names), "<source>", "eval")
    assert eval(written, values) == sum((-1) ** n * n**2 for n in range(50_000))


@pytest.mark.parametrize("times", [(1e308, -1e308), (-1e308, 1.7e308)])
def test_a_scene_whose_span_no_double_holds_is_refused(times):
    scene = vo.Scene({x: 1}, times)
    with pytest.raises(DefinitionError, match="a span that no double holds"):
        vo.integrate(system(), scene=scene)


@pytest.mark.filterwarnings("error")
def test_a_start_at_the_edge_of_doubles_is_answered_without_a_warning_of_numpy():
    pulled = system(lagrangian=m * vo.velocity(x) ** 2 / 2, forces={x: -x})
    for size in (1e308, -1e308):
        with suppress(IntegrationError):  # no step goes well there
            vo.integrate(pulled, times=[0, 1], initial={x: size}, method="scipy")


def test_a_parameter_that_is_positive_in_no_way_is_refused():
    with pytest.raises(DefinitionError, match="positive"):
        vo.Parameter(m, positive=np.array([None, 1], dtype=object))


def test_a_tolerance_may_be_any_real_number() -> None:
    """SymPy's numbers, fractions and text are the doubles that they are near to."""
    grid, start = [0, 1], {"x": 1}
    plain = vo.integrate(system(), times=grid, initial=start, tol=1e-10)
    for tol in (sp.Rational(1, 10**10), "1e-10", "1/10^10", Fraction(1, 10**10), sp.Float(1e-10)):
        found = vo.integrate(system(), times=grid, initial=start, tol=tol)
        assert found.cost.tolerance == 1e-10 and np.array_equal(found["x"], plain["x"])
    assert vo.ensemble(system(), {"x": [1]}, times=grid, tol="1e-10").finished.all()


def test_a_tower_of_exponentials_is_no_finite_number() -> None:
    """SymPy would work out all of its digits before it says how large it is."""
    tower = sp.exp(sp.exp(sp.Integer(700_000_000)))
    with pytest.raises(vo.DefinitionError, match=r"is not a (finite real )?number"):
        vo.integrate(vo.load("sleigh"), tol=tower)


def _nested(innermost: sp.Expr) -> sp.Expr:
    """3000 sines of sines."""
    expr = innermost
    for _ in range(3000):
        expr = sp.sin(expr, evaluate=False)
    return expr


LINE = vo.Fibration(base=sp.Symbol("x"))
SPEED = vo.velocity(sp.Symbol("x"))
FREE = vo.System("free", LINE, SPEED**2 / 2)
DEEP = _nested(sp.Symbol("x"))


@pytest.mark.parametrize(
    "read",
    [
        lambda: vo.System("deep", LINE, SPEED**2 / 2, forces={sp.Symbol("x"): DEEP}),
        lambda: vo.System("deep", LINE, DEEP),
        lambda: vo.System("deep", LINE, SPEED**2 / 2, constraints=(DEEP,)),
        lambda: vo.System("deep", vo.Fibration(sp.Symbol("x"), relations=(DEEP,)), SPEED**2 / 2),
        lambda: vo.integrate(FREE, initial={"x": 1}, times=[0, 1], outputs=(DEEP,)),
        lambda: vo.integrate(FREE, initial={"x": 1}, times=[0, 1], events=(vo.Event(DEEP),)),
        lambda: vo.integrate(FREE, times=[0, 1], initial={"x": DEEP}),
        lambda: vo.section(FREE, DEEP, initial={"x": 1}),
        lambda: vo.prove_equal(DEEP, 0),
    ],
)
def test_what_is_nested_too_deeply_is_refused_in_one_line(read) -> None:
    with pytest.raises(DefinitionError, match="nested too deeply") as caught:
        read()
    assert "\n" not in str(caught.value)


LONG = 10**5000  # Python does not print it


class Unread(Untold):
    def __float__(self):
        raise RuntimeError


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: vo.linearise(vo.derive(system()), at=5), "at = 5 is not a mapping"),
        (lambda: vo.linearise(vo.derive(system()), at=[1]), "at = .* is not a mapping"),
        (lambda: vo.check_catalogue(5), "names = 5 is not a tuple"),
        (lambda: vo.check_catalogue([1]), "a name = 1 is not a text"),
        (lambda: vo.check_catalogue(""), "there is no system ''"),
        (lambda: vo.check_catalogue("sleigh", jobs=0), "jobs = 0 is not a number of processes"),
        (lambda: vo.Table([0, 1], [0, 1], kind=["held"]), r"of kind '\['held'\]'; kinds are"),
        (lambda: vo.Table([0, 1], [0, 1], kind=LONG), "kinds are"),
        (lambda: system(essential=None), "essential = None is not a tuple"),
        (lambda: vo.integrate(system(), initial={x: LONG}), "'x'"),
        (lambda: vo.integrate(system(), initial={x: Unread()}), "an object of kind Unread"),
        (lambda: vo.section(system(), LONG, crossings=1), "the plane holds a number beyond"),
        (lambda: vo.search_integrals(system(), degree=LONG), "lower a degree"),
    ],
)
def test_what_no_door_can_read_is_refused_in_one_line(call, told) -> None:
    with pytest.raises(VoronecError, match=told) as caught:
        call()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("given", [5, None, "sleigh", system()])
def test_what_is_linearised_are_equations(given: object) -> None:
    with pytest.raises(vo.DefinitionError, match=r"not the equations that voronec\.derive gives"):
        vo.linearise(given)
