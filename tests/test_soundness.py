"""No run ends well that did not go well; what cannot be had is refused, what is done is kept."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import symengine as se
import sympy as sp

import voronec as vo
from voronec.flow import many as many_motions
from voronec.flow.attempts import first_success
from voronec.flow.steppers import taylor
from voronec.program import Block, Program, compiled, hoisted

x, u = sp.symbols("x u")
m, length, g = sp.symbols("m l g")
OSCILLATOR = vo.System(
    name="oscillator",
    fibration=vo.Fibration(base=(x,)),
    lagrangian=vo.velocity(x) ** 2 / 2 - x**2 / 2,
)
PENDULUM = vo.System(
    name="pendulum",
    fibration=vo.Fibration(base=(u,)),
    lagrangian=m * length**2 * vo.velocity(u) ** 2 / 2 + m * g * length * sp.cos(u),
    parameters=(m, length, g),
)


def test_one_number_is_the_end_of_the_span() -> None:
    traj = vo.integrate(OSCILLATOR, times=5.0, initial={x: 1})
    assert traj.t[0] == 0 and traj.t[-1] == 5 and len(traj) == 1001
    assert np.abs(traj["x"] - np.cos(traj.t)).max() < 1e-12
    assert vo.integrate(OSCILLATOR, times=-2, initial={x: 1}).t[-1] == -2
    with pytest.raises(vo.DefinitionError, match="end of a span"):
        vo.integrate(OSCILLATOR, times=0.0, initial={x: 1})


def test_names_of_one_block_mean_nothing_in_another() -> None:
    a, q, c = se.symbols("a q c0")
    program = Program(
        time=se.Symbol("t"), coordinates=(q,), velocities=(), parameters=(a,),
        derivative=Block(((c, -(a**2)),), (c * q,)),
        names=("root",), extras=Block(((c, q + a),), (se.sqrt(c),)),
    )  # fmt: skip
    raised = hoisted(program)
    values = raised.values([2.0])
    assert np.isfinite(values).all()
    assert compiled(raised.program)[1](0.0, [7.0], values)[0] == 3.0
    assert compiled(raised.program)[0](0.0, [7.0], values)[0] == -28.0


def test_a_parameter_that_leaves_no_inertia_is_refused() -> None:
    wanted: dict[str, Any] = {"times": [0, 1], "parameters": {m: 0, length: 1, g: 1}}
    for outputs in ((), ("u",)):
        with pytest.raises(vo.DefinitionError, match="for m = 0 the mass matrix is singular"):
            vo.integrate(PENDULUM, initial={u: 1}, outputs=outputs, **wanted)
    assert vo.integrate(
        PENDULUM, initial={u: 1}, **wanted | {"parameters": {m: 1, length: 1, g: 0}}
    )
    found = vo.ensemble(PENDULUM, {"u": 1.0}, {"m": [0.0, 1.0], "l": 1, "g": 1}, times=[0, 1])
    assert "m = 0" in str(found.errors[0]) and found.finished.tolist() == [False, True]


@pytest.mark.parametrize("method", ["heyoka", "scipy", "flint"])
def test_ctrl_c_between_distant_instants_keeps_where_the_run_stood(
    method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if method == "heyoka":
        pytest.importorskip("heyoka")
    monkeypatch.setattr(taylor, "CHUNK", 50)
    monkeypatch.setattr("voronec.flow.steppers.run.EVERY", 0.0)

    def stop(fraction: float) -> None:
        if fraction > 0.02:
            raise KeyboardInterrupt

    times = [0, 3000] if method != "flint" else [0, 300]
    traj = vo.integrate(OSCILLATOR, times=times, initial={x: 1}, method=method, progress=stop)
    assert traj.interrupted and len(traj) == 2 and 0 < traj.t[1] < times[1] / 2
    assert abs(float(traj["x"][1]) - np.cos(float(traj.t[1]))) < 1e-10


def test_ctrl_c_in_the_set_up_of_an_ensemble_ends_it(monkeypatch: pytest.MonkeyPatch) -> None:
    begin, calls = many_motions.start_of, []

    def stop(*args: Any) -> Any:
        calls.append(args)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return begin(*args)

    monkeypatch.setattr(many_motions, "start_of", stop)
    found = vo.ensemble(OSCILLATOR, {"x": [1.0, 2.0, 3.0, 4.0]}, times=[0, 1])
    assert found.interrupted and not found.finished.any() and not found.errors
    assert found["x"].shape == (4, 2) and np.isnan(found["x"]).all()


def test_auto_goes_on_with_another_method_where_its_choice_fails() -> None:
    pytest.importorskip("heyoka")
    disc = vo.derive(vo.load("falling-disc"))
    start = {"theta": 1.2, "p": 0.3, "q": 1e-6, "s": 1e-6}
    wanted: dict[str, Any] = {"initial": start, "times": [0, 1, 2, 3], "outputs": ("theta", "p")}
    with pytest.raises(vo.IntegrationError):
        vo.integrate(disc, method="scipy", **wanted)
    found = vo.integrate(disc, **wanted)
    assert found.cost.method == "heyoka" and "scipy" in found.cost.reason
    exact = vo.integrate(disc, method="flint", tol=1e-25, **wanted)
    for name in ("theta", "p"):
        assert np.abs(found[name] - exact[name].astype(float)).max() < 1e-6


def test_the_error_of_the_attempt_that_came_farthest_is_raised() -> None:
    errors = [vo.IntegrationError(str(t), t, np.zeros(1)) for t in (1.0, 5.0, 2.0)]

    def failing(error: vo.IntegrationError) -> Any:
        def way(_: Any) -> Any:
            raise error

        return way

    with pytest.raises(vo.IntegrationError, match=r"5\.0"):
        first_success([failing(e) for e in errors], 0.0)
