"""Chaplygin's balls on a plane and on a sphere: the displays as printed, and their checks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from voronec.audit import Check, Display, Range, Sentence, Study, Verdict

DEFINITION = Check("definition", study="outer")
EVERYWHERE = Check(study="outer", also=("inner", "plane"))
GYROSCOPE = Check(
    study="outer with gyroscope", also=("inner with gyroscope", "plane with gyroscope")
)
MARKEEV = Check(study="plane with gyroscope")
RUBBER = Check(study="rubber", also=("rubber inside", "rubber on a plane"))


def studies() -> dict[str, Study]:
    """The dictionaries: outer rolling, the two configurations with a minus sign, the plane."""
    from ..dictionary.chaplygin_balls import CONFIGURATIONS, KAPPA, R1, R2, SIGNED, Ball
    from ..dictionary.rubber_balls import Rubber

    found = {}
    for name, kappa in (("", None), (" with gyroscope", KAPPA)):
        found["outer" + name] = Ball.on_sphere(R1, kappa).study({r"\pm": 1})
        found["inner" + name] = Ball.on_sphere(-R1, kappa).study({r"\pm": -1})
        found["plane" + name] = Ball.on_plane(kappa).study()
        found["spheres" + name] = Ball.on_sphere(SIGNED, kappa).study(ranges=CONFIGURATIONS)
    found["double shell"] = Ball.on_sphere(-R2 / 2).with_weighted()
    found["rubber"] = Rubber.on_sphere(R1).study()
    found["rubber inside"] = Rubber.on_sphere(-R1).study()
    found["rubber on a plane"] = Rubber.on_plane().study()
    return found


def integrals(*names: str) -> Callable[[Study, Range], Verdict]:
    """Decide whether these are integrals."""
    return lambda study, where: study.context.constants(names, where)


def measure(study: Study, where: Range) -> Verdict:
    """Decide whether the density is that of an invariant measure."""
    return study.context.measure(where)


def double_shell(study: Study, where: Range) -> Verdict:
    """Decide whether epsilon is -1, and the fourth integral is one."""
    from ..dictionary.verdicts import all_equal, worst

    turning = all_equal([(study.context.epsilon, -1)])
    return worst([turning, study.context.constants([r"\tilde F_4"], where)])


def momentum(_: Study, __: Range) -> Verdict:
    """Decide what G is."""
    from ..dictionary.chaplygin_balls import momentum_is_about_contact

    return momentum_is_about_contact()


def flattened(_: Study, __: Range) -> Verdict:
    """Decide the limit of a sphere that becomes a plane."""
    from ..dictionary.chaplygin_balls import R1, Ball
    from ..dictionary.gyroscopic_balls import on_the_plane

    return on_the_plane(Ball.on_sphere(R1), Ball.on_plane())


def gyroscope(_: Study, __: Range) -> Verdict:
    """Decide what a gyroscope adds."""
    from ..dictionary.gyroscopic_balls import rotor_is_kappa

    return rotor_is_kappa()


def demchenko(_: Study, __: Range) -> Verdict:
    """Decide whether Demchenko's ball is the special case."""
    from .. import SYSTEM
    from ..dictionary.gyroscopic_balls import is_demchenkos

    return is_demchenkos(SYSTEM)


def veselova(study: Study, _: Range) -> Verdict:
    """Decide whether the equations are those of Veselov and Veselova."""
    from ..dictionary.rubber_balls import is_veselovas

    return is_veselovas(study.context)


def integral(name: str, check: Check) -> Check:
    """Print that it does not change along the motion, rather than what it is."""
    return replace(check, derived=lambda study, where: study.context.still(name))


def listed(check: Check, *names: str) -> tuple[Check, ...]:
    """A check for each of several integrals."""
    return tuple(integral(name, check) for name in names)


DISPLAYS = (
    Display(
        r"""\begin{equation}\label{Epsilon}
\epsilon=\frac{R_1}{R_1\pm R_2},
\end{equation}""",
        (Check(study="outer", also=("inner",)),),
    ),
    Display(
        r"""\begin{equation}
\dot{\mathbf G}={\mathbf G}\times\omega,
\qquad \dot{\gamma}=\epsilon
\gamma\times\omega, \label{Chap}\end{equation}""",
        (EVERYWHERE,),
    ),
    Display(
        r"""\begin{equation}
\mu(\gamma)=\sqrt{(\gamma-D\mathbf I^{-1}\gamma,\gamma)}, \label{mu-ch}
\end{equation}""",
        (EVERYWHERE,),
    ),
    Display(
        r"""\begin{equation}
F_1=(\gamma,\gamma)=1, \quad F_2=\frac12({\mathbf
G},\omega), \quad F_3=({\mathbf G},{\mathbf G}).
 \label{cl:int}
\end{equation}""",
        listed(EVERYWHERE, "F_1", "F_2", "F_3"),
    ),
    Display(
        r"""\[
\tilde F_4=(I_2+I_3-I_1+D)\mathbf
G_1\gamma_1+(I_3+I_1-I_2+D)\mathbf
G_2\gamma_2+(I_1+I_2-I_3+D)\mathbf G_3\gamma_3.
\]""",
        listed(Check(study="double shell"), r"\tilde F_4"),
    ),
    Display(
        r"""\begin{equation}\label{e3a}
\dot{\mathbf G}=\mathbf G\times \omega+\lambda \gamma, \qquad
\dot{\gamma}=\epsilon \gamma\times\omega, \qquad (\omega,\gamma)=0,
\end{equation}""",
        (RUBBER,),
    ),
    Display(
        r"""\begin{equation}
\dot{\mathbf G}=({\mathbf G}+\kappa)\times\omega,
\qquad \dot{\gamma}=\epsilon
\gamma\times\omega. \label{Chap*}\end{equation}""",
        (GYROSCOPE,),
    ),
    Display(
        r"""\begin{equation}
F_1=(\gamma,\gamma)=1, \quad F_2=\frac12({\mathbf
G},\omega), \quad F_3=({\mathbf G}+\kappa,{\mathbf G}+\kappa), \quad F_4=({\mathbf
G}+\kappa,\gamma)
 \label{cl:int*}
\end{equation}""",
        (*listed(GYROSCOPE, "F_1", "F_2", "F_3"), integral("F_4", MARKEEV)),
    ),
)

INLINE = (
    Display(r"$\mathbb I=\diag(I_1,I_2,I_3)$", (Check("words"),)),
    Display(r"$D=\mathbf M R_2^2$", (DEFINITION,)),
    Display(
        r"""${\mathbf G}=\mathbb I \omega+ D\omega-D (\omega,\gamma)\gamma=\mathbf I\omega-D (\omega,\gamma)\gamma$""",
        (EVERYWHERE,),
    ),
    Display(r"$\mathbf I=\mathbb I+D\mathbb E$", (DEFINITION,)),
    Display(r"$\mathbb E=\diag(1,1,1)$", (Check("words"),)),
    Display(
        r"""$F_4=({\mathbf
G},\gamma)$""",
        listed(Check(study="plane"), "F_4"),
    ),
    Display(r"$\mathbf G=\mathbb I\omega+D\omega=\mathbf I\omega$", (RUBBER,)),
    Display(
        r"""$
\lambda=-(\mathbf G,\mathbf I^{-1}(\mathbf G\times \omega))/(\gamma,\mathbf
I^{-1}\gamma)
$""",
        (RUBBER,),
    ),
    Display(
        r"""$
\mu_\epsilon(\gamma)=(\mathbf I^{-1}\gamma,\gamma)^\frac{1}{2\epsilon}
$""",
        (RUBBER,),
    ),
)

CLAIMS = (
    Sentence(
        r"$\mathbf G$ is the angular momentum of the ball about the point of contact",
        momentum,
        "spheres",
    ),
    Sentence(
        r"as $R_1$ grows beyond all bounds, $\epsilon$ tends to 1, and the equations to those of "
        r"the ball on a plane, whose normal $\gamma$ is constant in space",
        flattened,
        "plane",
    ),
    Sentence(
        r"$\mu(\gamma)$ is the density of an invariant measure in the space of $\omega$ and "
        r"$\gamma$, where $(\gamma,\gamma)=1$",
        measure,
        "spheres",
        derived=lambda study: study.context.wider_density(),
    ),
    Sentence(
        r"$F_1$, $F_2$, $F_3$ are integrals of the ball without a gyroscope",
        integrals("F_1", "F_2", "F_3"),
        "spheres",
    ),
    Sentence(r"$F_4$ is an integral for $\epsilon=1$", integrals("F_4"), "plane"),
    Sentence(
        r"a shell of twice the radius, $R_2=2R_1$, has $\epsilon=-1$, and $\tilde F_4$ is an "
        r"integral there",
        double_shell,
        "double shell",
    ),
    Sentence(
        r"$\mu_\epsilon(\gamma)$ is the density of an invariant measure of the rubber ball, for "
        r"outer rolling",
        measure,
        "rubber",
    ),
    Sentence(
        r"$\mu_\epsilon(\gamma)$ is the density of an invariant measure of the rubber ball, for "
        r"inner rolling and for the shell",
        measure,
        "rubber inside",
    ),
    Sentence(
        r"for $\epsilon=1$ the equations of the rubber ball are those of Veselov and Veselova for "
        r"a rigid body",
        veselova,
        "rubber on a plane",
    ),
    Sentence(
        r"a gyroscope adds to $\mathbf G$ a constant vector $\kappa$ along its axis",
        gyroscope,
        "spheres with gyroscope",
    ),
    Sentence(
        r"the ball with a gyroscope on a plane has an invariant measure with the same density",
        measure,
        "plane with gyroscope",
    ),
    Sentence(
        r"$F_1$, $F_2$, $F_3$, $F_4$ are integrals of the ball with a gyroscope for $\epsilon=1$",
        integrals("F_1", "F_2", "F_3", "F_4"),
        "plane with gyroscope",
    ),
    Sentence(
        r"$F_1$, $F_2$, $F_3$ are integrals of the ball with a gyroscope for all $\epsilon$",
        integrals("F_1", "F_2", "F_3"),
        "spheres with gyroscope",
    ),
    Sentence(
        r"under Zhukovsky's condition, a symmetric ball with the gyroscope along its axis of "
        r"symmetry is the one of Demchenko",
        demchenko,
        "spheres with gyroscope",
    ),
)
