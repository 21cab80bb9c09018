"""Rolling of a body with a gyroscope: the displays as printed, and what they are compared with."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from voronec.audit import Check, Display, Section, Study, Transcript

from ..sentences.gyroscope import SENTENCES

ROTOR = Check(study="rotor")
DEFINITION = Check("definition", study="rotor")
MOMENTS = Check(study="gyrostat", also=("particles",))
TURN_SOURCE = "the kinematics R^T dR/dt of any rotation, and the forms of any surface"
COSINES = Check(study="turning", also=("motion",), source=TURN_SOURCE)


def studies(_: Transcript) -> dict[str, Study]:
    """The dictionaries of this section."""
    from ..dictionary.gyroscope import WithGyroscope
    from ..dictionary.moments import gyrostat, particles
    from ..dictionary.rotor import Rotor, TurningAxes

    return {
        **WithGyroscope.derive().studies(),
        "rotor": Rotor.arbitrary().study(),
        "turning": TurningAxes().study(),
        "gyrostat": gyrostat(),
        "particles": particles(r"\mathfrak v", r"\tilde{\mathbf G}^{(M)}"),
    }


def projection(position: int) -> Check:
    """A projection of the angular momentum of body and gyroscope about the contact point."""

    def value(study: Study, _: Mapping[str, int]) -> Any:
        return study.context.moment[position]

    return Check(study="rotor", value=value)


def motion(position: int) -> Check:
    """The derived balance of moments along u, v or n."""

    def derivation(study: Study, _: Mapping[str, int]) -> list[tuple[Any, Any]]:
        found: list[tuple[Any, Any]] = study.context.terms(position)
        return found

    return Check(
        study="balance",
        truth=lambda study, where: study.context.rows[position],
        derived=derivation,
    )


GYROSCOPE = Section(
    title="Rolling of a body with a gyroscope",
    complete=True,
    label="bodyGyr",
    studies=studies,
    inline=(
        Display(r"$\kappa =k\mathbf z$", (DEFINITION,)),
        Display(r"$k=\tilde C\tilde\omega$", (Check("definition"),)),
        Display(
            r"$\tilde{\mathbf G}^{(M)}=\mathbf G^{(M)}+\kappa$",
            (ROTOR,),
        ),
        Display(r"$\frac{d\alpha''}{dt}=\tau_1\gamma''-n_1\beta''$", (COSINES,)),
    ),
    sentences=SENTENCES,
    displays=(
        Display(
            r"""\begin{equation}\label{kinMod}
\tilde{\mathbf T}=\mathbf T+\frac12\tilde{C}\tilde{\omega}^2=\bar{\mathbf T}+\frac12\tilde{C}\tilde{\omega}^2,
\end{equation}""",
            (ROTOR,),
        ),
        Display(
            r"""\begin{equation}\label{eq:momentgyroscope*}
\dot{\tilde{\mathbf{G}}}^{(M)}+[\mathfrak v,\mathfrak M]=\mathbf{L}^{(M)},
\end{equation}""",
            (MOMENTS,),
        ),
        Display(
            r"""$$
\frac{\partial\bar{\mathbf T}}{\partial s}+k\alpha'',\quad \frac{\partial\bar{\mathbf T}}{\partial \tau}+k\beta'',\quad \frac{\partial\bar{\mathbf T}}{\partial n}+k\gamma'',
$$""",
            (projection(0), projection(1), projection(2)),
        ),
        Display(
            r"""$$
\begin{aligned}
\frac{d}{dt}\frac{\partial\Theta}{\partial s}+(\tau-\tau_1)\frac{\partial\Theta}{\partial n}-(n-n_1)\frac{\partial\Theta}{\partial \tau}+\mathfrak v_\mathbf v\frac{\partial\bar{\mathbf T}}{\partial\mathfrak m_\mathbf n}-\mathfrak v_\mathbf n\frac{\partial\bar{\mathbf T}}{\partial\mathfrak m_\mathbf v}&=\frac{\partial\bar{\dot{U}}}{\partial s}+k(n\beta''-\tau\gamma''),\\
\frac{d}{dt}\frac{\partial\Theta}{\partial \tau}+(n-n_1)\frac{\partial\Theta}{\partial n}-(s-s_1)\frac{\partial\Theta}{\partial n}+\mathfrak v_\mathbf n\frac{\partial\bar{\mathbf T}}{\partial\mathfrak m_\mathbf u}-\mathfrak v_\mathbf u\frac{\partial\bar{\mathbf T}}{\partial\mathfrak m_\mathbf n}&=\frac{\partial\bar{\dot{U}}}{\partial \tau}+k(s\gamma''-n\alpha''),\\
\frac{d}{dt}\frac{\partial\Theta}{\partial n}+(s-s_1)\frac{\partial\Theta}{\partial \tau}-(\tau-\tau_1)\frac{\partial\Theta}{\partial s}+\mathfrak v_\mathbf u\frac{\partial\bar{\mathbf T}}{\partial\mathfrak m_\mathbf v}-\mathfrak v_\mathbf v\frac{\partial\bar{\mathbf T}}{\partial\mathfrak m_\mathbf u}&=\frac{\partial\bar{\dot{U}}}{\partial n}+k(\tau\alpha''-s\beta''),
\end{aligned}
$$""",
            (motion(0), motion(1), motion(2)),
        ),
    ),
)
