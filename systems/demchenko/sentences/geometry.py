"""Connections, curvature, reduction: what the text says beside its displays."""

from __future__ import annotations

import re

import sympy as sp

import voronec as vo
from voronec.audit import Quoted, Range, Reference, Study, one_of, tight
from voronec.audit.structure import mentions

from ..dictionary.general import BASE, FIBRE, TOTAL
from ..dictionary.geometry import CONSTRAINTS, POTENTIAL, Q, V, kinetic_energy
from ..dictionary.reductions import torus_measure, with_time
from ..transcription import sentences
from .claims import agreement, all_of, denial, equals


def linear_constraints(
    study: Study, _: Range, *, sort: str, degree: str, timed: bool
) -> vo.Verdict:
    """The distribution has a curvature; the constraints are linear and free of the time."""
    link = study.context.connection
    bend = [link.bracket(1, 2)[BASE + nu] for nu in range(FIBRE)]
    flat = equals(((x, 0) for x in bend), "the curvature")
    rest = dict.fromkeys(V, sp.Integer(0))
    homogeneous = equals(((c.xreplace(rest), 0) for c in CONSTRAINTS), "the constraints at rest")
    still = equals(((sp.diff(c, vo.time), 0) for c in CONSTRAINTS), "their derivatives by the time")
    return all_of(
        denial(one_of(sort, {"integrable": True, "nonintegrable": False}), flat),
        denial(one_of(degree, {"homogeneous": True, "nonhomogeneous": False}), homogeneous),
        denial(not timed, still),
    )


def across(study: Study, _: Range, *, how: str) -> vo.Verdict:
    """D and the fibres have independent directions."""
    names = study.names
    both = sp.Matrix.hstack(names[r"\mathcal D_q"], names[r"\mathcal V_q"])
    found = denial(False, vo.prove_equal(both.det(), 0))
    return denial(one_of(how, {"transverse": True, "tangent": False}), found)


def kernel(study: Study, _: Range, *, what: str) -> vo.Verdict:
    """D is what A sends to zero."""
    image = agreement(what, "kernel", "A sends D to zero; D is its")
    return all_of(image, study.context.kernel())


def mapping(study: Study, _: Range, *, sort: str) -> vo.Verdict:
    """A(aX + bY) = a A(X) + b A(Y), and A(X) is vertical."""
    link = study.context.connection
    a, b = sp.symbols("a b")
    x, y = (sp.Matrix([sp.Function(f"{w}{s}")(*Q) for s in range(TOTAL)]) for w in "XY")
    left, right = link.vertical(a * x + b * y), a * link.vertical(x) + b * link.vertical(y)
    found = all_of(
        equals(zip(left, right, strict=True), "A of a sum"),
        equals(((e, 0) for e in link.vertical(x)[:BASE]), "its components along the base"),
    )
    return denial(one_of(sort, {"linear": True, "nonlinear": False, "quadratic": False}), found)


def two_form(study: Study, _: Range, *, values: str, sort: str) -> vo.Verdict:
    """B(X, Y) is vertical, bilinear, and changes its sign with the order of X and Y."""
    link = study.context.connection
    x, y = (sp.symbols(f"{w}1:{TOTAL + 1}") for w in "XY")
    xy, yx = link.curvature(x, y), link.curvature(y, x)
    double = link.curvature([2 * e for e in x], y)
    along = {"vertical": xy[:BASE], "horizontal": xy[BASE:]}
    linear = equals(((a, 2 * b) for a, b in zip(double, xy, strict=True)), "B(2X, Y)")
    turned = equals(((a, -b) for a, b in zip(xy, yx, strict=True)), "B(Y, X)")
    return all_of(
        equals(((e, 0) for e in one_of(values, along)), "the other components"),
        linear,
        denial(one_of(sort, {"two-form": True, "symmetric form": False}), turned),
    )


def lagrangian(study: Study, _: Range, *, operation: str) -> vo.Verdict:
    """L by the two energies, in the equations of d'Alembert."""
    made = {
        "difference": kinetic_energy() - POTENTIAL,
        "sum": kinetic_energy() + POTENTIAL,
    }
    ours = study.context.eqs.system.lagrangian
    forces = zip(study.context.forces, (-sp.diff(POTENTIAL, q) for q in Q), strict=True)
    return all_of(
        equals([(one_of(operation, made), ours)], "L and the two energies"),
        equals(forces, "the forces of V"),
    )


def moving_constraints(
    study: Study, _: Range, *, degree: str, timed: str, constraints: Reference
) -> vo.Verdict:
    """A_ij and A_i are components of a curvature, time being a coordinate of the base."""
    (tree,) = constraints.trees(study)
    held = mentions(tree)
    offset = any(key.startswith("a_") and "," not in key for key in held)
    return all_of(
        agreement(
            offset, one_of(degree, {"nonhomogeneous": True, "homogeneous": False}), "an offset a_nu"
        ),
        agreement(
            "t" in held, one_of(timed, {"time dependent": True, "stationary": False}), "the time"
        ),
        lambda: with_time(),
    )


def reduces(study: Study, _: Range, *, system: Reference, manifold: str) -> vo.Verdict:
    """Mass, force and Lagrangian are free of the fibre: for translations."""
    (tree,) = system.trees(study)
    keys = mentions(tree)
    return all_of(
        agreement(one_of(manifold, {"base": "base", "total": "fibre"}), "base", "what is left"),
        agreement(any("L_c" in key for key in keys), True, f"whether ({system.label}) is in L_c"),
        lambda: study.context.invariance(),
    )


def principal(study: Study, _: Range, *, sort: str) -> vo.Verdict:
    """The connection does not change under the group, of two sorts."""
    lift = study.context.connection.lift
    fibre = study.context.connection.coordinates[-2:]
    if one_of(sort, {"principal": True, "flat": False}):
        return all_of(
            equals(
                ((sp.diff(e, s), 0) for e in lift[:2, :] for s in fibre), "base part of the lift"
            ),
            study.context.invariance(),
        )
    bracket = study.context.connection.bracket(1, 2)
    return equals(((e, 0) for e in bracket), "the curvature")


def tensor(study: Study, _: Range, *, slots: Quoted) -> vo.Verdict:
    """Whether JK is linear in each of two vectors; the tensor from which it comes takes three."""
    kind = tight(slots.latex).strip("$")
    if not re.fullmatch(r"\(\d,\d\)", kind):
        raise vo.DefinitionError(f"'{slots.latex}' is no kind of tensor, as (0,2) is")
    if kind == "(0,2)":
        return study.context.bilinear()
    return agreement(kind, "(0,3)", "the kind of tensor from which it comes")


def torus(study: Study, _: Range, *, sort: str, factor: str) -> vo.Verdict:
    """A flow with such rates keeps the measure with the density Phi: the last step alone."""
    one_of(sort, {"integrability": True})
    one_of(factor, {"original": True})
    return torus_measure(study)


TENSOR = r"\text{a tensor of three arguments:}\quad "


def latex_of_slots(study: Study) -> str:
    """What was derived instead."""
    return study.context.three_slots()


SENTENCES = sentences(__file__, globals())
