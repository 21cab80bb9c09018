"""Papers audited as their files stand: what is read, what is accused, and what is not."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

import voronec as vo
from voronec.errors import DefinitionError

HERE = Path(__file__).parent
NOTES = HERE.parent / "docs" / "notes"
SYSTEMS = {"ball": "chaplygin-ball", "suslov": "suslov", "veselova": "veselova"}
SLEIGH = """name = "sleigh-note"
lagrangian = "m*((xdot - a*sin(phi)*phidot)^2 + (ydot + a*cos(phi)*phidot)^2)/2 + J*phidot^2/2"
constraints = ["ydot*cos(phi) = xdot*sin(phi)"]
fibre = ["y"]
[coordinates]
x = "edge"
y = "edge"
phi = "heading"
[velocities]
v = "xdot*cos(phi) + ydot*sin(phi)"
omega = "phidot"
[parameters]
m = { value = 1, positive = true }
J = { value = 1, positive = true }
a = { value = 1, positive = true }
"""


def accused(found):
    """Lines in which something is refuted."""
    return {int(r.label.split("line ")[1].split(",")[0]) for r in found.errata}


def planted(path, marks="planted"):
    """Lines that end in a comment which says so."""
    lines = path.read_text("utf-8").splitlines()
    return {number for number, line in enumerate(lines, 1) if re.search(rf"% ({marks})", line)}


def system_of(path):
    own = path.with_suffix(".toml")
    return vo.load(str(own) if own.is_file() else SYSTEMS[path.stem])


PAPERS = [*sorted(NOTES.glob("*.tex")), *sorted((HERE / "papers").glob("*.tex"))]


@pytest.mark.slow
@pytest.mark.parametrize("path", PAPERS, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_the_errors_of_a_paper_are_found_and_nothing_else_is_accused(path):
    found = vo.audit_paper(path, system_of(path))
    assert accused(found) == planted(path)
    assert 2 <= len(planted(path, "planted|missed")) <= 3
    assert all(record.decisive.witness for record in found.errata)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "least"), [("other_fields", 90), ("true_of_the_sleigh", 50)])
def test_formulas_of_other_fields_problems_and_units_are_never_accused(tmp_path, name, least):
    system = tmp_path / "sleigh.toml"
    system.write_text(SLEIGH, "utf-8")
    found = vo.audit_paper(HERE / "papers" / "aside" / f"{name}.tex", vo.load(str(system)))
    assert len(found.records) > least
    assert not found.errata


def audit(tmp_path, text, **more):
    """The verdicts on a text about the sleigh, by what is printed."""
    (tmp_path / "sleigh.toml").write_text(SLEIGH, "utf-8")
    (tmp_path / "paper.tex").write_text(text, "utf-8")
    return vo.audit_paper(tmp_path / "paper.tex", vo.load(str(tmp_path / "sleigh.toml")), **more)


def verdicts(found):
    return [record.verdict for record in found.records]


MASS = r"\begin{pmatrix}m&0\\ 0&J+ma^2\end{pmatrix}"
DOTS = r"\begin{pmatrix}\dot v\\ \dot\omega\end{pmatrix}"
RIGHT = r"ma\omega^2, *mav\omega"
TRUE = r"Here $\dot v=a\omega^2$ and $\dot x=v\cos\phi$. "


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "verdict"),
    [
        (r"The rate is $\dot v=2a\omega^2$.", "misprint"),
        (r"If $a=0$, then $\dot v=0$.", "proved"),
        (r"The rate is $\dot v=0$ for $a=0$.", "proved"),
        (r"Near the steady motion $\dot v=0$.", "not read"),
        (r"We take $\omega=0$.", "definition"),
        (r"Let $x=0$ at first.", "definition"),
        (r"The wheel has $J=ma^2$.", "definition"),
        (r"The disc obeys $\dot\xi=a\omega^2$.", "unknown letters"),
        (r"The integral is $mv^2+(J+ma^2)\omega^2=2h$.", "proved"),
        (r"The integral is $mv^2+(J+ma)\omega^2=2h$.", "misprint"),
        (r"The kinetic energy is $T=\frac12mv^2+\frac12(J+ma)\omega^2$.", "misprint"),
        (r"The period is $T=\frac12mv^2$.", "definition"),
        (r"The momentum $\Pi=mv$ is used.", "definition"),
        (r"The ratio is $\dot v/\omega=a\omega$.", "proved"),
        (r"Let $k$ be the ratio $J/m$. Then $(k+a^2)\dot\omega=-av\omega$.", "definition"),
        (r"We denote by $P$ the quantity $J+ma^2$. One has $P\dot\omega=mav\omega$.", "definition"),
        (r"One has $(J+ma^2)\dot\omega=-\mu v\omega$, where $\mu=ma$.", "definition"),
        (
            r"Then $mv^2+(J+ma^2)\omega^2-2C=0$ and $\frac m2v^2-C=-\frac12(J+ma^2)\omega^2$.",
            "proved",
        ),
        (r"Then $mv^2+(J+ma^2)\omega^2-2C=0$ and $\frac m2v^2-C=-(J+ma^2)\omega^2$.", "not read"),
        (r"Then $mv^2+(J+ma)\omega^2-2C=0$.", "unknown letters"),
        (
            r"With $q=(x,y,\phi)\in\mathbb R^2\times S^1$ "
            r"it is $\dot q=(v\cos\phi,v\sin\phi,\omega)$.",
            "proved",
        ),
        (r"The space is $q\in Q=S^1\times\mathbb R^2$.", "unknown letters"),
        (r"At rest one has $\dot v=0$.", "proved"),
        (r"In the special case $a=0$ one has $\dot v=0$.", "proved"),
        (r"In the limit $m\to\infty$ one has $\dot\omega=-v\omega/a$.", "proved"),
        (r"In the limit $m\to\infty$ one has $\dot\omega=v\omega/a$.", "not read"),
        (r"Put $I:=J+ma^2$. Later $I=J$.", "convention"),
        (r"We choose $J=ma^2$. Then $\dot\omega=-\frac{v\omega}{2a}$.", "not read"),
        (r"\section{A} Let $a=0$. \section{B} Then $\dot v=0$.", "not read"),
        (r"\section{A} If $a=0$, it is plain. \section{B} Here $\dot v=0$.", "misprint"),
        (r"If $a=0$, it is plain. The speed has $\dot v=0$.", "not read"),
        (r"If $a=0$, it is plain. In general $\dot v=0$.", "misprint"),
        (r"Let $a=0$. The speed has $\dot v=\omega^2$.", "misprint"),
        (r"The rate $\dot v=0$ vanishes unless $a=0$.", "definition"),
        (r"Except when $a=0$ the rate is $\dot v=0$.", "not read"),
        (r"Unlike the case $a=0$, here $\dot v=0$.", "not read"),
        (r"We take $\omega=0$. The speed has $\dot v=0$.", "not read"),
        (r"In steady rolling $\omega=0$. The speed has $\dot v=0$.", "misprint"),
        (r"The rate is $\dot v=a\omega^{*2}$.", "not read"),
        (r"One has $K\dot\omega=-mav\omega$, where $K$ is the quantity $J+ma^2$.", "definition"),
        (r"The momentum is $p=mv=2m\dot x/\cos\phi$.", "misprint"),
        (r"We set $p:=mv^2+(J+ma^2)\omega^2=const$.", "proved"),
        (r"The ratio is $\kappa=J/m=\frac27$.", "definition"),
        (r"With $T^*=\frac m2v^2$ we have $\dot T^{*}=mav\omega^2$.", "proved"),
        (r"A prime denotes differentiation with respect to the time: $v'=a\omega^2$.", "proved"),
        (r"Derivatives by the time are marked with primes: $\phi''=2\omega$.", "misprint"),
        (
            r"Primes denote derivatives with respect to the time $\tau$: $v'=2a\omega^2$.",
            "definition",
        ),
        (r"With $q=(x,y,\phi)^T$ and $\dot q=0$.", "definition"),
        (
            r"The reaction $\lambda$ in $M\ddot q=\lambda A$ has $M=\operatorname{diag}(m,m)$, "
            r"$q=(x-a\cos\phi,y-a\sin\phi)^T$, $A=(1,0)^T$.",
            "definition",
        ),
        (
            r"The curvature is $A_{ij}^{(\nu)}=\frac{\partial a_{\nu i}}{\partial q_j}"
            r"-\frac{\partial a_{\nu j}}{\partial q_i}$.",
            "definition",
        ),
        (r"One has $\{v,\omega\}=\frac{a}{}$.", "not read"),
        (r"Without the constraint $\dot v=0$.", "not read"),
        (r"One substitutes the variable $v=\omega+\phi$.", "not read"),
        (rf"${MASS}({DOTS})=({RIGHT})^T$.".replace("*", "-"), "proved"),
        (rf"${MASS}({DOTS})=({RIGHT})^T$.".replace("*", ""), "misprint"),
        (
            r"$\left[\begin{array}{c}\dot x\\\hline \dot y\end{array}\right]="
            r"\begin{bmatrix}v\cos\phi\\[2pt] v\cos\phi\end{bmatrix}$.",
            "misprint",
        ),
        (
            r"With $q=(x,y,\phi)$, $u=(v,\omega)^\top$ and $S(q)=\begin{pmatrix}"
            r"\cos\phi&0\\ \sin\phi&0\\ 0&1\end{pmatrix}$ one has $\dot q=S(q)u$.",
            "proved",
        ),
        (
            r"The energy is $T=\frac12\begin{pmatrix}v&\omega\end{pmatrix}"
            r"\begin{pmatrix}m&0\\0&J+ma^2\end{pmatrix}\begin{pmatrix}v\\ \omega\end{pmatrix}$.",
            "proved",
        ),
        (r"With $M=\begin{pmatrix}m&a\\ 0&J\end{pmatrix}$ one has $\det M=mJ$.", "not read"),
        (
            r"With $\mathbf M=\begin{pmatrix}m&a\\ 0&J\end{pmatrix}$ one has $\det\mathbf M=mJ$.",
            "proved",
        ),
        (r"The minor is $\begin{vmatrix}m&a\\ 0&J\end{vmatrix}=mJ$.", "proved"),
        (r"Also $\begin{pmatrix}m&a\\ 0\end{pmatrix}=\dot v$.", "not read"),
        (r"$$|v|=\begin{cases}v,&v\ge0,\\ -v,&v<0.\end{cases}$$", "proved"),
        (
            r"$|v|=\left\{\begin{array}{ll}v & \mbox{if $v>0$,}\\ -v & \text{otherwise}"
            r"\end{array}\right.$",
            "proved",
        ),
        (r"$\dot v=\begin{cases}a\omega^2&v>0\\ 2a\omega^2&\text{else}\end{cases}$.", "not read"),
        (r"Let $s=\begin{cases}1&v>0\\-1&v\le0\end{cases}$. Then $sv=|v|$.", "proved"),
        (r"$$\begin{cases}\dot v=a\omega^2&v>0\\ \dot v=2a\omega^2&v<0\end{cases}$$", "definition"),
        (r"The curvature is $A_{x\phi}^{(y)}=\frac1{\cos^2\phi}$.", "proved"),
        (r"Its curvature is $A_{12}^{(1)}=-\frac1{\cos^2\phi}$.", "proved"),
        (r"Its curvature is $A_{12}^{(1)}=\frac2{\cos^2\phi}$.", "definition"),
        (
            r"Ehresmann: $A_{12}^{(1)}=\frac1{\cos^2\phi}$, $A^{(1)}_{21}=\frac1{\cos^2\phi}$.",
            "definition",
        ),
    ],
)
def test_what_is_printed_has_its_verdict(tmp_path, text, verdict):
    assert verdicts(audit(tmp_path, TRUE + text))[-1 if "for" not in text else 2] == verdict


@pytest.mark.slow
def test_a_model_in_matrices_is_proved_and_an_error_in_it_is_found(tmp_path):
    text = (HERE / "papers" / "aside" / "in_matrices.tex").read_text("utf-8")
    found = verdicts(audit(tmp_path, text))
    assert found.count("definition") == 8
    assert found.count("proved") == len(found) - 8 == 6
    found = audit(tmp_path, text.replace(r"\\ ma\omega", r"\\ -ma\omega"))
    (wrong,) = found.errata
    assert wrong.printed.startswith(r"\mathbf C(")
    assert verdicts(found).count("convention") == 2  # all formulas with C fail


@pytest.mark.slow
def test_a_vector_equation_gives_multipliers_and_is_compared(tmp_path):
    rows = [r"\dot\phi^2\cos\phi\\ \ddot y", r"\dot\phi^2\sin\phi\\ \ddot y"]
    text = (
        r"Here $\dot x=v\cos\phi$, $\dot y=v\sin\phi$. With the reaction $\lambda$ "
        r"\[ m\begin{pmatrix}\ddot x-a\ddot\phi\sin\phi-a%s"
        r"+a\ddot\phi\cos\phi-a\dot\phi^2\sin\phi\end{pmatrix}"
        r"-\begin{pmatrix}\sin\phi\\-\cos\phi\end{pmatrix}\lambda=0. \]"
    )
    found = [verdicts(audit(tmp_path, text % row))[-1] for row in rows]
    assert found == ["proved", "misprint"]


def test_a_definition_is_accused_where_all_fails_that_uses_it(tmp_path):
    text = (
        r"We have $\dot v=a\omega^2$, $\dot x=v\cos\phi$, $\dot y=v\sin\phi$. Set $I=J+ma$. "
        r"Then \[ I\dot\omega=-mav\omega, \qquad 2T=mv^2+I\omega^2 \] is the energy."
    )
    found = audit(tmp_path, text)
    assert verdicts(found)[3:] == ["misprint", "convention", "convention"]


def test_macros_files_and_systems_keep_their_places(tmp_path):
    (tmp_path / "more.tex").write_text("\n$\\rate v=a\\W^2$ % $wrong=1$\n", "utf-8")
    found = audit(
        tmp_path,
        "\\newcommand{\\rate}[1]{\\dot{#1}}\n\\def\\W{\\omega}\n\\def\\pair(#1,#2){#1=#2}\n"
        "\\DeclareMathOperator{\\const}{const}\n\\section{One}\n\\input{more}\n"
        "\\[ \\left\\{\\begin{array}{rcl} \\rate x&=&v\\cos\\phi,\\\\\n  \\rate y&=&v\\sin\\phi "
        "\\end{array}\\right. \\eqno(7)\\]\n"
        "  $$ \\boxed{{m v^2+(J+ma^2)\\W^2 \\over 2}=\\const} $$ so $\\pair(\\W,\\rate\\phi)$.",
    )
    assert verdicts(found) == ["proved"] * 5
    labels = [record.label for record in found.records]
    assert labels[0] == "line 2, column 2"
    assert labels[2] == "(7), line 8, column 3"
    assert labels[3].startswith("line 9")


@pytest.mark.slow
def test_letters_are_asked_for_and_given_in_a_table(tmp_path, call):
    text = r"With $\Omega$ one has $\dot v=a\Omega^2$ and $(J+ma^2)\dot\Omega=-mav\Omega$."
    found = audit(tmp_path, text)
    assert found.letters == {r"\Omega": ["line 1", "line 1"]}
    assert verdicts(audit(tmp_path, text, dictionary={r"\Omega": "omega"})) == ["proved"] * 2
    table = tmp_path / "letters.toml"
    call("audit", "paper.tex", "sleigh.toml", "--dictionary", str(table))
    written = table.read_text("utf-8")
    assert '"\\\\Omega" = ""  # in 2' in written
    table.write_text(written.replace('""', '"phidot"'), "utf-8")
    assert verdicts(audit(tmp_path, text, dictionary=table)) == ["proved"] * 2


def test_a_drafted_system_can_be_derived(tmp_path, call):
    drafted = call("audit", str(NOTES / "sleigh_on_slope.tex"))
    assert drafted.status == 0
    (tmp_path / "draft.toml").write_text(drafted.out, "utf-8")
    equations = vo.derive(vo.load(str(tmp_path / "draft.toml")))
    assert equations.kind == "chaplygin"
    assert len(equations.velocities) == 2


@pytest.mark.parametrize(
    ("name", "held"), [("hoop", "M*a**2*thetadot**2/2"), ("snakeboard", "J*psidot**2/2")]
)
def test_a_draft_reads_primes_stars_and_functions_by_name(call, name, held):
    assert held in call("audit", str(HERE / "papers" / f"{name}.tex")).out


@pytest.mark.slow
def test_the_command_tells_right_from_wrong(tmp_path, call):
    paper, system = str(NOTES / "disc.tex"), str(NOTES / "disc.toml")
    done = call("audit", paper, system, "--format", "md", "--out", "page")
    assert done.status == 1
    assert "## Wrong: 3" in done.out
    assert "read $\\dot T=-mgr\\dot\\theta\\cos\\theta$" in done.out
    assert (tmp_path / "page" / "report.html").is_file()
    data = json.loads(call("audit", paper, system, "--json").out)
    assert data["counts"]["misprint"] == 3


SPEEDS = r"Here $$\dot v=a\omega^2,\eqno(9)$$ $\dot x=v\cos\phi$, $\dot y=v\sin\phi$. "


@pytest.mark.slow
@pytest.mark.parametrize(
    ("sentence", "verdict"),
    [
        (r"The quantity $mv^2+(J+ma^2)\omega^2$ is a first integral of the motion.", "proved"),
        (r"The quantity $mv^2+(J+ma)\omega^2$ is a first integral.", "misprint"),
        (r"Hence the quantities $v^2+\omega^2$ and $J\omega^2$ are constant.", "misprint"),
        (r"Hence the speed $v$ is constant.", "unaudited"),
        (r"In the case where $v^2+\omega^2$ is constant all is plain.", "unaudited"),
        (r"It moves so that $v^2+\omega^2$ is constant.", "unaudited"),
        (r"The path for which $v^2+\omega^2$ is constant.", "unaudited"),
        (r"The energy \[ E=\tfrac12mv^2+\tfrac12(J+ma^2)\omega^2 \] is conserved.", "proved"),
        (r"For $a=0$ the velocities $v$ and $\omega$ are constant.", "proved"),
        (r"On a smooth plane $v$ is constant, and $\omega$ does not vanish.", "unaudited"),
        (r"It is not true that $v$ is constant.", "unaudited"),
        (r"We keep to motions on which $v$ is constant.", "unaudited"),
        (r"The controller holds the sleigh so that $v$ is constant.", "unaudited"),
        (r"The rate of the speed $\dot v$ equals $a\omega^2$.", "proved"),
        (r"The rate of the speed $\dot v$ equals $2a\omega^2$.", "misprint"),
        (r"In the limit $a\to0$ the rate $\dot v$ tends to $0$.", "proved"),
        (r"In the limit $J\to0$ the rate $\dot v$ tends to $0$.", "unaudited"),
        (r"The rate of the speed $\dot v$ coincides with (9).", "proved"),
        (r"The system has two degrees of freedom.", "proved"),
        (r"The system has three degrees of freedom.", "proved"),
        (r"The system has six degrees of freedom.", "unaudited"),
        (r"The energy $v^2+\omega^2$ equals $4$.", "unaudited"),
        (r"The rate $\dot v$ becomes $2a\omega^2$.", "unaudited"),
        (r"It was wrongly said that $mv^2+(J+ma^2)\omega^2$ is constant.", "unaudited"),
        (r"The quantity $v^2+\omega^2$ is conserved by the scheme.", "unaudited"),
        (r"The constraint is nonholonomic.", "proved"),
        (r"The constraint is not integrable.", "proved"),
        (r"The system is nonholonomic.", "proved"),
        (r"Hence the system is not holonomic.", "proved"),
        (r"The system is holonomic.", "unaudited"),
        (r"The plane is touched; this constraint is holonomic.", "unaudited"),
        (r"All constraints are nonholonomic.", "proved"),
        (r"None of the constraints is integrable.", "proved"),
        (r"Both constraints are holonomic.", "unaudited"),
        (r"In the limit $J\to\infty$ the rate $\dot\omega$ tends to $0$.", "proved"),
        (r"In the limit $J\to\infty$ the rate $\dot\omega$ tends to $\omega$.", "unaudited"),
        (r"The system is integrable by quadratures.", "unaudited"),
        (r"The system is not integrable.", "unaudited"),
        (r"The sleigh is the simplest of all problems.", "unaudited"),
    ],
)
def test_a_sentence_is_judged_by_an_exact_pattern_or_listed(tmp_path, sentence, verdict):
    found = audit(tmp_path, SPEEDS + sentence)
    said = [record for record in found.audit.records if record.decisive.says]
    assert {record.verdict for record in said[1:]} == {verdict}
    assert all(sentence.split("$")[0].split("\\")[0] in record.printed for record in said[1:])


def test_a_system_is_integrable_where_it_claims_a_theorem_that_is_proved(tmp_path):
    (tmp_path / "paper.tex").write_text(r"$\dot x=v\cos\phi$. The system is integrable.", "utf-8")
    found = vo.audit_paper(tmp_path / "paper.tex", vo.load("sleigh"))
    assert found.audit.records[-1].verdict == "proved"
    assert "Euler and Jacobi" in found.audit.records[-1].decisive.method


@pytest.mark.slow
@pytest.mark.parametrize(("root", "verdict"), [(r"\sqrt", "proved"), ("", "unaudited")])
def test_a_density_is_proved_in_the_variables_of_the_system(tmp_path, root, verdict):
    text = rf"""Put $\rho={root}{{1-mR^2(\gamma_1^2/(I_1+mR^2)+\gamma_2^2/(I_2+mR^2)
    +\gamma_3^2/(I_3+mR^2))}}$. There is an invariant measure of these equations with the
    density $\rho$."""
    (tmp_path / "ball.tex").write_text(text, "utf-8")
    found = vo.audit_paper(tmp_path / "ball.tex", vo.load("chaplygin-ball"))
    assert found.audit.records[-1].verdict == verdict


@pytest.mark.slow
def test_a_paper_of_the_catalogue_is_audited_by_its_name(call):
    done = call("audit", "chaplygin-ball", "--json")
    assert done.status == 0
    assert json.loads(done.out) == json.loads(call("regenerate", "chaplygin-ball", "--json").out)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("no formula at all", "holds no formula"),
        ("$v=a$ \\input{missing}", "line 1, column 7: there is no file 'missing.tex'"),
        ("\\def\\x{\\x}$\\x=1$", "without end"),
        ("$v=\\frac{a}{b$ \\newcommand{\\x", "'}' is missing"),
    ],
)
def test_a_file_that_is_no_paper_is_refused_in_one_line(tmp_path, text, said):
    with pytest.raises(DefinitionError, match=said.replace("\\", "\\\\").replace("(", r"\(")):
        audit(tmp_path, text)


def test_a_letter_that_the_paper_does_not_have_is_refused(tmp_path):
    with pytest.raises(DefinitionError, match="is no letter of the paper"):
        audit(tmp_path, TRUE, dictionary={r"\chi": 1})
