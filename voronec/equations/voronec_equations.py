"""From a system to its Voronec equations.

    d/dt dLc/dv^i - h_i(Lc) + (c_ij^k dLc/dv^k + B_ij^A p_A) v^j = E_i^b Q_b + a_i^A Q_A

How they are printed and exported; what they are made of stands in ``derived_equations``.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from itertools import chain
from textwrap import shorten
from typing import TYPE_CHECKING, Any

import sympy as sp

from voronec.algebra.columns import columns
from voronec.algebra.symbols import plain_name, velocity
from voronec.algebra.typeset import caret_text, latex_of, plain_text
from voronec.declaration.system import System, require_system
from voronec.equations.definition import read
from voronec.equations.derivation import Derivation
from voronec.equations.derived_equations import DerivedEquations
from voronec.equations.evaluation import check_added_mass, check_inertia
from voronec.equations.readable import (
    break_lines,
    equation_lines,
    readable,
    short_texts,
)
from voronec.equations.vector_field import solved_form
from voronec.errors import DefinitionError, EngineLimit

if TYPE_CHECKING:
    from voronec.equations.control import Control
    from voronec.equations.mechanics_form import MechanicsForm
    from voronec.equations.program import Program
    from voronec.equations.readable import ReadableEquations


def _latex(eqs: VoronecEquations, expr: sp.Expr) -> str:
    return latex_of(expr, eqs.coordinates, eqs.velocities)


WIDTH = 100
"""Characters in a line, unless told."""
LONGEST, SCREEN = 20_000, 60
"""Equations of more characters are not printed, nor programs of more lines in their place."""


def derivation_parts(
    eqs: VoronecEquations, width: int = WIDTH, growth: bool = True
) -> Iterator[list[str]]:
    """The motion of the coordinates and the equations of motion, line by line; then, each of which
    may take longer than these, the kind of system, how its distribution grows, and the curvature.

    Motion and equations are in the form for people, lines that are wider than ``width`` go on in
    further ones.  Of a system too large for the exact normal form, or to be printed, the program is
    shown, where that is short.
    """
    system = eqs.system
    form = readable(eqs) if eqs.is_short else None
    shown = form is not None and form.length <= LONGEST
    lines = [f"{system.name}: {system.title}" if system.title else system.name, ""]
    lines += _fact_lines(columns(_facts(eqs)), width)
    yield [*lines, "", *(form.lines(width) if form and shown else _too_large(eqs, form))]
    yield ["", _fact("kind", eqs.kind)]
    if growth:
        yield _fact_lines(_distribution_rows(eqs), width)
    if shown and eqs.has_coordinate_frame:
        yield ["", *_curvature_lines(eqs, width)]


def _too_large(eqs: VoronecEquations, form: ReadableEquations | None) -> list[str]:
    """What is told of equations that are not printed, and their program where it is short."""
    why = f"to print, {form.length} characters" if form else "for the exact normal form"
    told = f"too large {why}: a program of {eqs.operations} operations"
    program = (_program(eqs) or "").splitlines()
    if not 0 < len(program) <= SCREEN:
        return [f"{told}, printed by --python or --c"]
    return [f"{told}, in Python", "", *program]


def _distribution_rows(eqs: VoronecEquations) -> Iterator[str]:
    """How the distribution of the constraints grows, and what of them integrates."""
    distribution = eqs.distribution
    more = ", ... (cut off at its budget)" if distribution.cut else ""
    growth = "(" + ", ".join(map(str, distribution.growth)) + more + ")"
    timed = ", the time included" if distribution.timed else ""
    yield _fact("growth vector", f"{growth} of {distribution.dimension}{timed}")
    for label, text in _integrable_rows(eqs):
        yield _fact(label, text)


def _fact(label: str, text: str) -> str:
    return f"{label:23}  {text}"


def _fact_lines(rows: Iterable[str], width: int) -> list[str]:
    return [part for row in rows for part in break_lines(row, width)]


def _facts(eqs: VoronecEquations) -> list[list[str]]:
    relations = eqs.system.fibration.relations
    rows = [["relation, differentiated", f"{caret_text(e)} = 0"] for e in relations]
    frame = eqs.system.frame
    if frame is None or frame.is_group:
        return [*rows, ["velocities", _names(eqs)]]
    pairs = zip(frame.velocities, frame.expressions, strict=True)
    return [*rows, *(["quasi-velocity", f"{caret_text(v)} = {caret_text(e)}"] for v, e in pairs)]


def _integrable_rows(eqs: VoronecEquations) -> list[tuple[str, str]]:
    """How many combinations of the constraints integrate, these, and what they hold constant."""
    count, (forms, leaves) = len(eqs.system.constraints), _texts_of_integrals(eqs).values()
    if isinstance(forms, str):
        most = eqs.distribution.dimension - eqs.distribution.growth[-1]
        return [("integrable combinations", f"undecided, at most {most} of {count}")]
    rows = [("integrable combinations", f"{len(forms) or 'none'} of {count}")] if count else []
    for i, form in enumerate(forms):
        without = "" if i < len(leaves) else ", no function found in closed form"
        text = shorten(form.replace("**", "^"), 2 * WIDTH, placeholder=" ...")
        rows.append(("combination", f"{text} = 0{without}"))
    return rows + [("held constant", leaf.replace("**", "^")) for leaf in leaves]


def _texts_of_integrals(eqs: VoronecEquations) -> dict[str, Any]:
    """The combinations of the constraints that integrate and what they hold constant, as text."""
    texts: list[Any] = ["undecided", "undecided"]
    with suppress(EngineLimit):
        texts = [[*map(plain_text, part)] for part in (eqs.integrable, eqs.leaves)]
    return dict(zip(("integrable_combinations", "held_constant"), texts, strict=True))


def _names(eqs: VoronecEquations) -> str:
    return ", ".join(caret_text(v) for v in eqs.velocities)


def _curvature_lines(eqs: VoronecEquations, width: int) -> list[str]:
    """The components A_ij^(nu) and A_i^(nu) that do not vanish, by the names of coordinates."""
    base, fibres = eqs.definition.split
    size, components = range(len(base)), dict[str, Any]()
    for nu, fibre in enumerate(fibres):
        components |= {
            f"A^{fibre}[{base[i]}, {base[j]}]": eqs.curvature[nu, i, j]
            for i in size for j in size if i < j
        }  # fmt: skip
        components |= {f"A^{fibre}[{base[i]}]": eqs.curvature.time[nu, i] for i in size}
    rows, names = short_texts(eqs, {name: e for name, e in components.items() if e != 0})
    length = sum(len(text) for _, text in (*rows, *names))
    if length > LONGEST:
        return [f"curvature  too large to print, {length} characters: see eqs.curvature"]
    lines = ["curvature", *(equation_lines(rows, width) or ["  vanishes"])]
    return [*lines, "", "where", *equation_lines(names, width)] if names else lines


def _program(eqs: VoronecEquations) -> str | None:
    """Python source, where the system holds no unknown function."""
    try:
        return eqs.python()
    except DefinitionError:
        return None


def _coefficients(eqs: VoronecEquations, fibre: list[str], base: list[str]) -> dict[str, Any]:
    matrix, offset = eqs.coefficients
    return {
        name: {
            **{b: plain_text(matrix[nu, i]) for i, b in enumerate(base)},
            "1": plain_text(offset[nu]),
        }
        for nu, name in enumerate(fibre)
    }


def _curvature(eqs: VoronecEquations, fibre: list[str], base: list[str]) -> dict[str, Any]:
    a = eqs.curvature
    table: dict[str, Any] = {}
    for nu, name in enumerate(fibre):
        entries = {
            f"{p},{q}": plain_text(a[nu, i, j])
            for i, p in enumerate(base)
            for j, q in enumerate(base)
            if i < j
        }
        entries |= {f"{p},t": plain_text(a.time[nu, i]) for i, p in enumerate(base)}
        table[name] = {key: value for key, value in entries.items() if value != "0"}
    return table


@dataclass(frozen=True, repr=False)
class VoronecEquations(DerivedEquations):
    """The Voronec equations of a system, mass * vdot = force, with what they are made of.

    They print and export themselves; everything derived stands in ``DerivedEquations``.
    """

    def latex(self, names: bool = False) -> str:
        """The equations as a LaTeX ``aligned`` block: kinematic equations, then mass * vdot = force
        row by row.

        With ``names`` an ``align`` block of the form for people, the shortest of several that are
        proved equal, with what is named below ``where``; as ``show`` prints it.
        """
        if names:
            return readable(self).latex("align")
        lines = []
        for q, rate in zip(self.coordinates, self.rates, strict=True):
            if velocity(q) != rate:
                lines.append(f"{_latex(self, velocity(q))} &= {_latex(self, rate)}")
        dots = sp.Matrix([velocity(v) for v in self.velocities])
        for row, force in zip((self.mass * dots), self.force, strict=True):
            lines.append(f"{_latex(self, row)} &= {_latex(self, force)}")
        body = " \\\\\n  ".join(lines)
        return f"\\begin{{aligned}}\n  {body}\n\\end{{aligned}}"

    def show(self) -> None:
        """Print the equations, with the kind of the system and the curvature; in a notebook they
        are typeset."""
        shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
        if shell is not None and shell.has_trait("kernel"):
            import_module("IPython.display").display(self)
        else:
            for lines in derivation_parts(self):
                print("\n".join(lines), flush=True)

    def __repr__(self) -> str:
        return f"VoronecEquations({self.system.name!r}, velocities=({_names(self)}))"

    def _repr_latex_(self) -> str | None:
        """For notebooks; None, and then the short form is shown, where formulas are too long."""
        return (
            f"$\\displaystyle {readable(self).latex('aligned')}$" if self.in_normal_form else None
        )

    def __str__(self) -> str:
        """The equations in the form for people, as ``show`` prints them."""
        return "\n".join(chain.from_iterable(derivation_parts(self, growth=False)))

    def __reduce__(self) -> tuple[Any, ...]:
        """Sent elsewhere, the system goes alone: there its equations are derived again."""
        return derive, (self.system,)

    @cached_property
    def program(self) -> Program:
        """What is printed: the straight-line program of ``form``, or of the same solved for the
        rates of the velocities, whichever takes fewer operations."""
        from voronec.equations.program import Program, operation_count, shorten_program
        from voronec.equations.program.straight import with_choices

        form = with_choices(self.form, self.raw.form)
        forms = [form] if form is not self.form else [form, solved_form(self)]
        programs = [shorten_program(Program.of(f)) for f in forms if f is not None]
        return min(programs, key=lambda p: operation_count(p.derivative.expressions))

    def python(self, jacobian: bool = False) -> str:
        """Python source, on numpy, of the first-order right-hand side: d(state)/dt as a function of
        the time, ``state`` (coordinates, then velocities), parameters and, where there are any,
        inputs; with its ``jacobian`` by state and inputs where that is asked for.

        Raises ``DefinitionError`` where the equations hold an unknown function, ``EngineLimit``
        for a function that the language does not have.
        """
        from voronec.equations.program import python_source

        return python_source(self.program, jacobian)

    def c(self, jacobian: bool = False) -> str:
        """C99 source of the same, with the same errors."""
        from voronec.equations.program import c_source

        return c_source(self.program, jacobian)

    def javascript(self, jacobian: bool = False) -> str:
        """An ECMAScript module of the same, without dependencies, with the same errors."""
        from voronec.equations.program import javascript_source

        return javascript_source(self.program, jacobian)

    def casadi(self, jacobian: bool = False) -> str:
        """Python source of the same, on CasADi's expressions, with the same errors."""
        from voronec.equations.program import casadi_source

        return casadi_source(self.program, jacobian)

    def jax(self, jacobian: bool = False) -> str:
        """Python source of the same, on JAX in doubles, with the same errors; ``jit``, ``vmap`` and
        ``grad`` take its functions."""
        from voronec.equations.program import jax_source

        return jax_source(self.program, jacobian)

    def to_casadi(self) -> Any:
        """The right-hand side as a ``casadi.Function`` of ``t``, ``state`` (coordinates, then
        velocities), ``parameters`` and ``inputs``, columns all; its result is ``derivative``.

        CasADi differentiates it itself.  Raises ``DefinitionError`` where CasADi is not installed.
        """
        from voronec.equations.program import casadi_function

        return casadi_function(self.program)

    def to_mechanics(self) -> MechanicsForm:
        """The equations in the form of SymPy's ``KanesMethod``, for PyDy and what else takes it."""
        from voronec.equations.mechanics_form import MechanicsForm

        return MechanicsForm(self)

    @cached_property
    def control(self) -> Control:
        """The control-affine form x' = f + sum_i g_i u_i, and what can be reached with it.

        Raises ``DefinitionError`` where there are no inputs, or one enters nonlinearly.
        """
        from voronec.equations.control import control_form

        return control_form(self)

    def as_dict(self) -> dict[str, Any]:
        """Everything derived, as strings and numbers that JSON can hold.

        For a system beyond the exact normal form, the Python source of its program instead.
        """
        base, fibre = self.definition.split
        coordinates = [plain_name(q) for q in self.coordinates]
        data: dict[str, Any] = {
            "system": self.system.name,
            "base": base,
            "fibre": fibre,
            "velocities": [plain_name(v) for v in self.velocities],
            "parameters": [p.name for p in self.system.parameters],
            "kind": self.kind,
            "growth": list(self.distribution.growth),
            "growth_is_cut_off": self.distribution.cut,
            **_texts_of_integrals(self),
            "normal_form": self.in_normal_form,
        }
        if not self.in_normal_form:  # written out, a shared graph is endless
            return data | {"program": _program(self), "operations": self.operations}
        data |= {
            "rates": dict(zip(coordinates, map(plain_text, self.rates), strict=True)),
            "mass": [[plain_text(e) for e in self.mass.row(i)] for i in range(self.mass.rows)],
            "force": [plain_text(e) for e in self.force],
            "left": [plain_text(e) for e in self.left],
            "right": [plain_text(e) for e in self.right],
            "lagrangian_on_constraints": plain_text(self.theta),
            "momenta": dict(zip(fibre, map(plain_text, self.momenta), strict=True)),
        }
        if self.has_coordinate_frame:
            data["coefficients"] = _coefficients(self, fibre, base)
            data["curvature"] = _curvature(self, fibre, base)
        return data


def derive(system: System) -> VoronecEquations:
    """Derive the Voronec equations of a system.

    The constraints are solved and checked at once; equations, curvature and normal forms are made
    when they are asked for, and kept with the system.  Raises ``DefinitionError`` where the
    definition makes no sense.
    """
    require_system(system)
    # a system is a value that does not change, and so are its equations
    return system.memo.once("equations", lambda: _derive(system))


def _derive(system: System) -> VoronecEquations:
    definition = read(system)
    raw = Derivation(definition, False)
    exact = Derivation(definition, True, raw=raw)
    _ = raw.connection
    check_added_mass(raw)
    check_inertia(raw)
    return VoronecEquations(system, definition, raw, exact)
