r"""A formula sheet on Chaplygin's ball on a plane: equations, integrals, measure.

It has the shape of a paper, and is audited like one: the formulas below are LaTeX that is read and
compared with the equations which the engine derives from Euler angles and brings down to the
vertical gamma and the angular velocity omega.  ``docs/audit.md`` takes it as the example of a
paper in one file.
"""

from __future__ import annotations

import sympy as sp

import voronec as vo
from voronec.audit import Check, Display, Motion, Paper, Range, Section, Sentence, Study, Verdict

DEFINITION = Check("definition")


def studies(_: object) -> dict[str, Study]:
    """The reduced system: every letter of the sheet, in terms of gamma and omega."""
    ball = vo.descend(vo.load("chaplygin-ball"))
    gamma, omega = sp.Matrix(ball.invariants), sp.Matrix(ball.velocities)
    dots = [vo.velocity(w) for w in omega]
    known = {p.name: p.symbol for p in ball.system.parameters}
    moments = [known[f"I{i}"] for i in (1, 2, 3)]
    motion = Motion(
        rates={**dict(zip(gamma, ball.rates, strict=True)), **dict(zip(omega, dots, strict=True))},
        accelerations=dict(zip(dots, ball.mass.LUsolve(ball.force), strict=True)),
    )
    names = {
        "t": vo.time,
        "m": known["m"],
        "R": known["R"],
        r"\gamma": gamma,
        r"\omega": omega,
        r"\mathbf{G}": sp.Matrix(ball.momenta),
        r"\mathbf{I}": sp.diag(*moments),
    }
    names |= {f"I_{i}": moment for i, moment in enumerate(moments, start=1)}
    names |= {rf"\gamma_{i}": g for i, g in enumerate(gamma, start=1)}
    names |= {rf"\omega_{i}": w for i, w in enumerate(omega, start=1)}
    return {"reduced": Study(names, motion=motion, relations=ball.relations, context=ball)}


def invariant_measure(study: Study, _: Range) -> Verdict:
    """The divergence of density times field over the space (gamma, omega) vanishes."""
    ball, motion = study.context, study.motion
    gamma, omega = sp.Matrix(ball.invariants), sp.Matrix(ball.velocities)
    density = sp.sqrt(
        1 - sum(D(study) * g**2 / row for g, row in zip(gamma, rows(study), strict=True))
    )
    flow = {**motion.rates, **{w: motion.accelerations[vo.velocity(w)] for w in omega}}
    return vo.prove_equal(vo.divergence(density, flow), 0, study.relations)


def D(study: Study) -> sp.Expr:
    """m R^2."""
    return study.table["m"] * study.table["R"] ** 2


def rows(study: Study) -> list[sp.Expr]:
    """I_i + m R^2."""
    return [study.table[f"I_{i}"] + D(study) for i in (1, 2, 3)]


PAPER = Paper(
    name="chaplygin-ball",
    title="Chaplygin's ball on a plane: a formula sheet",
    authors="The developers of Voronec",
    references=("Chaplygin1903", "BorisovMamaev2002"),
    sections=(
        Section(
            title="Equations",
            complete=True,
            studies=studies,
            inline=(Display(r"$D=mR^2$", (DEFINITION,)),),
            displays=(
                Display(r"\[ \mathbf G=\mathbf I\omega+D\big(\omega-(\omega,\gamma)\gamma\big) \]"),
                Display(
                    r"""\begin{equation}\label{motion}
\dot{\mathbf G}=\mathbf G\times\omega, \qquad \dot\gamma=\gamma\times\omega
\end{equation}"""
                ),
            ),
        ),
        Section(
            title="Integrals and measure",
            complete=True,
            studies=studies,
            displays=(
                Display(
                    r"""\begin{equation}\label{integrals}
\begin{aligned}
& F_1=(\gamma,\gamma)=1, \quad F_2=\frac12(\mathbf G,\omega)=const, \\
& F_3=(\mathbf G,\mathbf G)=const, \quad F_4=(\mathbf G,\gamma)=const
\end{aligned}
\end{equation}""",
                    (DEFINITION,),
                ),
            ),
            sentences=(
                Sentence(
                    r"$\sqrt{1-\sum_i D\gamma_i^2/(I_i+D)}$ is the density of an invariant measure "
                    r"in the space of $\gamma$ and $\omega$",
                    invariant_measure,
                ),
            ),
        ),
    ),
)
