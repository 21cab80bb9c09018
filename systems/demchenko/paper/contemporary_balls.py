"""Chaplygin's balls on a plane and on a sphere: the displays as printed, and their checks."""

from __future__ import annotations

from dataclasses import replace

from voronec.audit import Check, Display, Study

DEFINITION = Check("definition", study="outer")
EVERYWHERE = Check(study="outer", also=("inner", "plane"))
GYROSCOPE = Check(
    study="outer with gyroscope", also=("inner with gyroscope", "plane with gyroscope")
)
MARKEEV = Check(study="plane with gyroscope")
RUBBER = Check(study="rubber", also=("rubber inside", "rubber on a plane"))
NO_TWIST = replace(RUBBER, constrains=1)


def studies() -> dict[str, Study]:
    """The dictionaries: outer rolling, the two configurations with a minus sign, the plane."""
    from ..dictionary.chaplygin_balls import CONFIGURATIONS, KAPPA, R1, R2, SIGNED_RADIUS, Ball
    from ..dictionary.rubber_balls import Rubber

    found = {}
    for name, kappa in (("", None), (" with gyroscope", KAPPA)):
        found["outer" + name] = Ball.on_sphere(R1, kappa).study({r"\pm": 1})
        found["inner" + name] = Ball.on_sphere(-R1, kappa).study({r"\pm": -1})
        found["plane" + name] = Ball.on_plane(kappa).study()
        found["spheres" + name] = Ball.on_sphere(SIGNED_RADIUS, kappa).study(ranges=CONFIGURATIONS)
    found["double shell"] = Ball.on_sphere(-R2 / 2).with_linear_integral()
    found["rubber"] = Rubber.on_sphere(R1).study()
    found["rubber inside"] = Rubber.on_sphere(-R1).study()
    found["rubber on a plane"] = Rubber.on_plane().study()
    return found


def integral(name: str, check: Check) -> Check:
    """Print that it does not change along the motion, rather than what it is."""
    return replace(check, derived=lambda study, where: study.context.still(name))


def integral_checks(check: Check, *names: str) -> tuple[Check, ...]:
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
        integral_checks(EVERYWHERE, "F_1", "F_2", "F_3"),
    ),
    Display(
        r"""\[
\tilde F_4=(I_2+I_3-I_1+D)\mathbf
G_1\gamma_1+(I_3+I_1-I_2+D)\mathbf
G_2\gamma_2+(I_1+I_2-I_3+D)\mathbf G_3\gamma_3.
\]""",
        integral_checks(Check(study="double shell"), r"\tilde F_4"),
    ),
    Display(
        r"""\begin{equation}\label{e3a}
\dot{\mathbf G}=\mathbf G\times \omega+\lambda \gamma, \qquad
\dot{\gamma}=\epsilon \gamma\times\omega, \qquad (\omega,\gamma)=0,
\end{equation}""",
        (RUBBER, RUBBER, NO_TWIST),
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
        (*integral_checks(GYROSCOPE, "F_1", "F_2", "F_3"), integral("F_4", MARKEEV)),
    ),
)

INLINE = (
    Display(
        r"$\mathbb I=\diag(I_1,I_2,I_3)$",
        (replace(DEFINITION, source="the moments of inertia that the Lagrangian has"),),
    ),
    Display(r"$D=\mathbf M R_2^2$", (DEFINITION,)),
    Display(
        r"""${\mathbf G}=\mathbb I \omega+ D\omega-D (\omega,\gamma)\gamma=\mathbf I\omega-D (\omega,\gamma)\gamma$""",
        (EVERYWHERE,),
    ),
    Display(r"$\mathbf I=\mathbb I+D\mathbb E$", (DEFINITION,)),
    Display(r"$\mathbb E=\diag(1,1,1)$", (replace(DEFINITION, source="the unit matrix"),)),
    Display(
        r"""$F_4=({\mathbf
G},\gamma)$""",
        integral_checks(Check(study="plane"), "F_4"),
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
