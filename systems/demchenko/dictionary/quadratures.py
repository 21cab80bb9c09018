"""Dictionaries of the sections on the quadratures: the derived system on a level of its integrals.

The axial momentum, the energy and the momentum vector are proved to be constant along the derived
equations.  On a level of them n, s and tau^2 are functions of x = cos u, by linear elimination, and
so are the rates of v and of v1; what is a polynomial in x among them is found here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Motion, Range, Study, shorten

from .. import R1, R2, A, M, k, n, s, tau, theta, u, u1, v, v1

x = sp.Symbol("x")
C5, h, GAMMA = sp.symbols("C5 h Gamma")
INERTIA, RATIO, p, share = sp.symbols("I mu' p q")
ROOTS = dict(zip(("x^I", "x^{II}", "x^{III}", "x^{IV}"), sp.symbols("x1:5"), strict=True))
NUMBERED_LETTERS = frozenset("x")
HEADS = frozenset({"X", "F", r"\phi", r"\psi", r"\theta"})
PARAMETERS = {M: INERTIA / R2**2, R1: R2 / RATIO}

BALL = {A: 2 * INERTIA * share / (3 * (1 + share))}
"""A < 2I/3: no mass is farther than R2 from the centre.

For a body of mass m about its centre, 2 A + C is twice the integral of r^2 dm.  So ball and rotor
have 2 A1 + C1 + 2 A2 + C2 = 3 A + C2 < 2 M R2^2 = 2 I, with C1 = A1 + A2 = A and C2 > 0.
"""
HOLLOW = {A: INERTIA * (1 + 2 * share) / 2}
"""A > I/2: no mass of the shell is nearer than R2 to the centre.

Now 3 A + C2 > 2 I.  Since C <= 2 A for any body, A1 + A2 = C1 <= 2 A1, so that A2 <= A1, and
C2 <= 2 A2 <= A; so 4 A > 2 I.
"""


RANGES = (
    Range(
        "outer rolling",
        r"\mu'>0,\ 3A<2I",
        {RATIO: p, **BALL},
        (p, share, INERTIA),
        letters={"p": r"\mu'=p", "q": "3A=2qI/(1+q)"},
    ),
    Range(
        "inner rolling",
        r"-1<\mu'<0,\ 3A<2I",
        {RATIO: -p / (1 + p), **BALL},
        (p, share, INERTIA),
        source="Epsilon",
        letters={"p": r"\mu'=-p/(1+p)", "q": "3A=2qI/(1+q)"},
    ),
    Range(
        "shell rolling",
        r"\mu'<-1,\ 2A>I",
        {RATIO: -(1 + p), **HOLLOW},
        (p, share, INERTIA),
        source="Epsilon",
        letters={"p": r"\mu'=-1-p", "q": "2A=(1+2q)I"},
    ),
)


@dataclass(frozen=True)
class Level:
    """The motion on a level of the integrals, in the parameters I = M R2^2, A, mu' = R2/R1 and k.

    ``motion`` and ``declared`` are the derived motion and the integrals of the system.  The
    polynomials in x = cos u are properties.
    """

    motion: Motion
    declared: Mapping[str, Any]

    @classmethod
    def derive(cls) -> Level:
        """Derive the equations, and prove that the declared integrals are constant."""
        from .. import SYSTEM

        eqs = vo.derive(SYSTEM)
        motion = Motion.of(eqs).solved(eqs)
        motion = Motion(
            rates=_in_ratios(motion.rates),
            constrained=_in_ratios(motion.constrained),
            accelerations=_in_ratios(motion.accelerations),
        )
        level = cls(motion, _in_ratios(eqs.system.integrals))
        for name, value in level.declared.items():
            if not vo.prove_equal(level.rate(value), 0).proved:
                raise vo.DefinitionError(f"the integral '{name}' of the system is not constant")
        return level

    def rate(self, value: Any) -> Any:
        """The rate of change along the motion."""
        return self.motion.along(self.motion.derivative(value))

    # -- constants of the system ----------------------------------------------------------

    @property
    def P(self) -> Any:
        """The moment of inertia about the contact point, from the energy."""
        return sp.diff(self.declared["energy"], tau, 2)

    @property
    def mu(self) -> Any:
        """tau = -mu udot."""
        return sp.cancel(-1 / sp.diff(self.rate(u), tau))

    @property
    def pace(self) -> Any:
        """Units of the time in which (4.4.13) has no factor before it, in one unit of t."""
        return 2 * self.P * A / k

    # -- the integrals --------------------------------------------------------------------

    @property
    def integrals(self) -> dict[sp.Symbol, Any]:
        """The constants of the integrals, as they follow from the state."""
        (area,) = shorten([sum(self.declared[f"momentum {axis}"] ** 2 for axis in "xyz")])
        return {C5: self.declared["axial"], h: self.declared["energy"], GAMMA: sp.sqrt(area)}

    @cached_property
    def n(self) -> Any:
        """n, from the axial momentum."""
        return self._in_x(_root(self.integrals[C5] - C5, n))

    @cached_property
    def speed(self) -> Any:
        """s^2 + tau^2, from the energy."""
        square = sp.Symbol("square")
        energy = sp.expand(self.integrals[h] - h).subs(tau**2, square - s**2)
        return self._in_x(_root(energy, square).subs(n, self.n))

    @cached_property
    def reach(self) -> Any:
        """How far x is from x_0 where s = tau = 0: the energy gives A n there, n gives x."""
        square = sp.Symbol("square")
        energy = sp.expand(self.integrals[h] - h).subs({s: 0, tau: 0}).subs(n**2, square)
        return sp.sqrt(sp.cancel(A**2 * _root(energy, square))) / -sp.diff(A * self.n, x)

    @cached_property
    def slip(self) -> Any:
        """s sin u, from the length of the momentum, tau being eliminated."""
        product = sp.Symbol("product")
        area = sp.expand(self.integrals[GAMMA] ** 2 - GAMMA**2)
        area = sp.expand(area.subs(tau**2, self.speed - s**2)).subs(s, product / sp.sin(u))
        (equation,) = shorten([area.subs(n, self.n).subs(sp.cos(u), x)])
        return self._in_x(_root(equation, product))

    @cached_property
    def square(self) -> Any:
        """The square of the rate of x, which is that of tau sin u / mu."""
        return self._in_x(((1 - x**2) * self.speed - self.slip**2) / self.mu**2)

    def _in_x(self, value: Any) -> Any:
        return shorten([value.subs(sp.cos(u), x)])[0]

    # -- the quadratures ------------------------------------------------------------------

    @cached_property
    def phi(self) -> Any:
        """The polynomial with X = (1 - x^2) psi - phi^2: s sin u, as the integrals give it."""
        return self._in_x(self.pace * self.slip / self.mu)

    @cached_property
    def psi(self) -> Any:
        """The polynomial with X = (1 - x^2) psi - phi^2."""
        return self._in_x(self.pace**2 * self.speed / self.mu**2)

    @cached_property
    def X(self) -> Any:
        """The polynomial of (4.4.13), times its unit of time the square of the rate of x."""
        return self._in_x(self.pace**2 * self.square)

    @cached_property
    def upright(self) -> dict[Any, Any]:
        """Sine and cosine of theta, the cosine of u1, where the momentum is vertical."""
        from .. import contact, momentum

        vertical = (contact.fixed.frame * contact.turn).row(2).T
        unknown = sp.symbols("a b c")
        names = dict(zip((sp.sin(theta), sp.cos(theta), sp.cos(u1)), unknown, strict=True))
        pairs = zip(GAMMA * vertical, momentum.xreplace(PARAMETERS), strict=True)
        equations = [g - m for g, m in pairs]
        solution = sp.solve([e.xreplace(names) for e in equations], unknown, dict=True)[0]
        return {angle: solution[name] for angle, name in names.items()}

    @cached_property
    def theta(self) -> Any:
        """Gamma^2 sin^2 u1: the denominator of the rate of v1."""
        axial = self.upright[sp.cos(u1)].subs(n, self.n)
        return self._in_x(GAMMA**2 * (1 - axial**2))

    @cached_property
    def F(self) -> Any:
        """The numerator of the rate of v1, which is F / (pace theta)."""
        rate = sp.expand(self.rate(v1).xreplace(self.upright) * sp.sin(u1) ** 2)
        rate = sp.expand(rate.subs(tau**2, self.speed - s**2)).subs(s, self.slip / sp.sin(u))
        return self._in_x(self.pace * GAMMA**2 * rate)

    # -- the state ------------------------------------------------------------------------

    @cached_property
    def state(self) -> dict[Any, Any]:
        """s, tau, n and the angles on the sphere, in u; the root of X is pace dx/dt."""
        sine = {sp.sin(u1): sp.sqrt(self.theta) / GAMMA}
        root = self.mu * sp.sqrt(self.X) / self.pace
        level = {s: self.slip / sp.sin(u), tau: root / sp.sin(u), n: self.n}
        angles = {angle: e.xreplace(level).xreplace(sine) for angle, e in self.upright.items()}
        return {key: sp.sympify(e).subs(x, sp.cos(u)) for key, e in (level | angles | sine).items()}

    # -- dictionaries ---------------------------------------------------------------------

    @cached_property
    def quartic(self) -> sp.Poly:
        """X as a polynomial."""
        return sp.Poly(self.X, x)

    def names(self) -> dict[str, Any]:
        """What the paper's letters stand for; polynomials have x = cos u in them."""
        return {**self._names}

    @cached_property
    def _names(self) -> dict[str, Any]:
        centre = _root(self.n, x)
        minus_area, slope, minus_b0 = reversed(sp.Poly(self.phi, x).all_coeffs())
        angles = {"u": u, "v": v, r"\vartheta": theta, "u_1": u1, "v_1": v1}
        radii = {"R_1": PARAMETERS[R1], "R_2": R2, r"\mathbf{M}": PARAMETERS[M]}
        found = {"t": vo.time, **angles, "s": s, r"\tau": tau, "n": n, **radii, "A": A, "k": k}
        found |= {"C_5": C5, "h": h, r"\Gamma": GAMMA, "x": x, "x_0": centre}
        found |= {"P": self.P, "I": INERTIA, r"\mu": self.mu, r"\mu'": RATIO}
        found |= {"b_0": -minus_b0, "b_1": sp.cancel(slope / (2 * centre)), "b_2": self.pace * k}
        found |= {r"\bar\Gamma": -minus_area, "a_0": self.quartic.LC(), "h'": self.reach}
        found |= {"X": self.X, r"\phi": self.phi, r"\psi": self.psi}
        found |= {r"\theta": self.theta, "F": self.F}
        return {name: sp.sympify(value).subs(x, sp.cos(u)) for name, value in found.items()}

    def study(self, given: Mapping[Any, Any], note: str = "") -> Study:
        """A dictionary with some of its symbols given."""
        return Study(
            self.names(),
            motion=self.motion,
            numbered=frozenset("x"),
            functions=HEADS,
            narrow_functions=True,
            given=given,
            ranges=RANGES,
            scope=(RANGES[0].name,),
            context=self,
            note=note,
            source="the equations derived for the system 'demchenko', and its integrals, by linear "
            "elimination",
        )

    def studies(self) -> dict[str, Study]:
        """By what is given in terms of what.

        ``state``: the constants by the state; ``level``: the state by the constants; ``roots``:
        the polynomials by the roots of X; ``product``: those of the level, where a_0 is what makes
        the product of the linear factors X.  A chain of equalities is proved in both: between the
        forms of X by phi, psi and by the roots in the one, from X to phi and psi in the other.
        ``level free`` and ``letters``: nothing is given, and in the latter no equation holds.
        """
        kept = r"$C_5$, $h$ and $\Gamma$ are proved to be constant along the motion"
        root = r"the root of $X$ stands for $(b_2/k)\,dx/dt$, with its sign"
        return {
            "state": self.study(self.integrals, kept),
            "level": self.study(self.state, root),
            "roots": split_by_roots(),
            "product": self._by_factors(),
            "level free": self.study({}, "by the state"),
            "letters": self._letters(),
        }

    def _letters(self) -> Study:
        """Velocities and angular velocities are any: only u changes, as x does."""
        study = self.study({}, "for any motion")
        motion = Motion({q: vo.velocity(q) for q in (u, v, theta, u1, v1)})
        return replace(study, motion=motion, source="the calculus of the letters themselves")

    def _by_factors(self) -> Study:
        product = sp.prod(x - root for root in ROOTS.values())
        study = self.study({}, "for all values of the constants")
        own = {name: value.subs(sp.cos(u), x) for name, value in study.names.items()}
        own |= {"x": x, "a_0": own["X"] / product, **ROOTS}
        source = f"{study.source}; a_0 is what the linear factors of the roots leave of X"
        return replace(study, names=own, numbered=NUMBERED_LETTERS, source=source)


def split_by_roots() -> Study:
    """X, phi and psi as they must be where X has given roots; psi is the quotient.

    The root signs are those of phi(1) and phi(-1), since X(1) = -phi(1)^2, X(-1) = -phi(-1)^2.
    """
    a0, f2, f1, f0 = sp.symbols("a0 f2 f1 f0")
    roots = tuple(ROOTS.values())
    product = sp.Poly(sp.prod(x - root for root in roots), x)
    ends = [sp.sqrt(-a0 * product.eval(end)) for end in (1, -1)]
    phi = f2 * x**2 + f1 * x + f0
    given = {f1: (ends[0] - ends[1]) / 2, f0: (ends[0] + ends[1]) / 2 - f2}
    X = sum(a0 * c * x**i for i, c in enumerate(reversed(product.all_coeffs())))
    names = {"x": x, "X": X, r"\phi": phi, r"\psi": (X + phi**2) / (1 - x**2), "a_0": a0}
    source = "the roots of X, and the values of phi at 1 and -1"
    return Study(
        {**names, **ROOTS}, numbered=NUMBERED_LETTERS, functions=HEADS, given=given, source=source
    )


@cache
def level() -> Level:
    """The level, derived once."""
    return Level.derive()


def _root(equation: Any, symbol: sp.Symbol) -> Any:
    """Where an expression that is linear in a symbol vanishes."""
    slope, rest = sp.Poly(equation, symbol).all_coeffs()
    return -rest / slope


def _in_ratios(values: Mapping[Any, Any]) -> dict[Any, Any]:
    """Values in the parameters I, A, mu' and k: the radius of the ball drops out."""
    shorter = shorten([sp.sympify(value).xreplace(PARAMETERS) for value in values.values()])
    return dict(zip(values, shorter, strict=True))
