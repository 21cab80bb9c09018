"""Units of letters follow from a Lagrangian; what adds different ones is no correction."""

from __future__ import annotations

import pytest
import sympy as sp

import voronec as vo
from voronec.audit import Check, Display, Motion, Section, Study, Transcript
from voronec.audit.correction import Spare, correct
from voronec.audit.correction.units import Units
from voronec.audit.latex.reader import read
from voronec.audit.verify import omission

x, phi, y = sp.symbols("x phi y")
m, J, a, c, g = sp.symbols("m J a c g", positive=True)
f = sp.Function("f")


def system(lagrangian: sp.Expr, **options: object) -> vo.System:
    return vo.System(
        name="body on a line",
        fibration=vo.Fibration(base=(x, phi), fibre=(y,)),
        lagrangian=lagrangian,
        constraints=(vo.velocity(y) - a * sp.cos(phi) * vo.velocity(phi),),
        parameters=(m, J, a, c, g),
        **options,
    )


def energy() -> sp.Expr:
    dots = [vo.velocity(q) for q in (x, phi, y)]
    return m * (dots[0] ** 2 + dots[2] ** 2) / 2 + J * dots[1] ** 2 / 2 - m * g * x + c * f(x)


NAMES = {
    "m": m,
    "J": J,
    "a": a,
    "c": c,
    "g": g,
    "x": x,
    "t": vo.time,
    r"\varphi": phi,
    "v": vo.velocity(x),
    "w": vo.velocity(phi),
    "U": f(x),
    "z": sp.Symbol("z"),
}
STUDY = Study(NAMES, motion=Motion({x: vo.velocity(x)}), system=system(energy()))


@pytest.mark.parametrize(
    "latex",
    [
        "J+ma^2",
        r"\frac{ma}{J}+\frac{1}{a}",
        r"mv^2-2mgx+Jw^2\sin\varphi",
        r"c\frac{\partial U}{\partial x}=mg",
        r"\dot x=aw",
        r"\sqrt{J+ma^2}=a\sqrt{m}",
        "J+ma^2+0",
        "ax+z",  # of z nothing is known
        "z=m",
    ],
)
def test_balanced_or_silent(latex):
    assert not unbalanced(latex)


@pytest.mark.parametrize(
    "latex",
    [
        "J+ma",
        "J+1",
        r"mv+\frac{ma}{J}",
        r"\sin v",
        r"c\frac{\partial U}{\partial x}=c",
        "mv^2=const+mgx+w",
        "z(J+ma)",
        "J>m",
    ],
)
def test_unbalanced(latex):
    assert unbalanced(latex)


def test_the_limits_of_an_integral_have_the_unit_of_its_variable():
    assert not unbalanced(r"\int_0^t mv\,dt=mx")
    assert not unbalanced(r"\int_{t_1}^{t_2} mv\,dt=mx")
    assert unbalanced(r"\int_0^2 mv\,dt=mx")
    assert unbalanced(r"\int_0^x mv\,dt=mx")
    assert unbalanced(r"\int_0^t m\,dt=mx")


def test_the_limits_of_an_integral_principle_bear_no_letter_of_something_else():
    study = Study({"T": x, "t": vo.time, "U": f(x)})
    for limit, said in (("T_1", True), ("T'_1", True), ("t_1", False), ("t'_1", False)):
        chain = read(rf"\int_{{{limit}}}^{{t_2}} U\,dt=0", study.vocabulary)
        assert ("bears the letter" in omission(chain, study)) is said


def unbalanced(latex: str) -> bool:
    return Units.of(STUDY).is_unbalanced(read(latex, STUDY.vocabulary), STUDY)


def test_units_of_what_a_dictionary_adds():
    study = Study(NAMES, system=system(energy()), units={sp.Symbol("z"): m * a})
    units = Units.of(study)
    assert units.is_unbalanced(read("z+m", study.vocabulary), study)
    assert not units.is_unbalanced(read("z+ma", study.vocabulary), study)


def test_without_a_system_nothing_is_known():
    assert Units.of(Study(NAMES)) is None
    odd = system(energy() + sp.Abs(x) * m)
    assert Units.of(Study(NAMES, system=odd)) is None


def test_a_sum_of_two_integrals_is_no_correction():
    """Energy and momentum of a free particle are constant, and so is their sum."""
    energy = m * vo.velocity(x) ** 2 / 2
    free = vo.System("particle", vo.Fibration((x,), ()), energy, parameters=(m,))
    eqs = vo.derive(free)
    names = {"T": eqs.theta, "m": m, "x": x, "v": vo.velocity(x), "t": vo.time}
    study = Study(names, motion=Motion.of(eqs).solved(eqs), context=eqs)
    section = Section("s", (Display("$T+mx=const$"),), lambda _: {"only": study})
    (formula,) = Transcript(section).formulas()
    spare = Spare.of(Transcript(section), study)
    found = correct(formula, Check(), study, spare)
    assert found is None or "T" not in found.latex or "v" not in found.latex
    loose = Study(names, motion=study.motion)  # of which no system is known
    assert correct(formula, Check(), loose, spare) is not None
