"""The straight-line program of a system, and its emitters.

``Program.of(form)`` shares common subexpressions and eliminates the mass matrix; the emitters write
it as Python, C, JavaScript, CasADi, JAX or mpmath source, as a compiled Python function, or as
heyoka expressions.  ``jacobian`` are its derivatives by state and inputs.
"""

from voronec.equations.program.c import c_source
from voronec.equations.program.jacobian import jacobian
from voronec.equations.program.javascript import javascript_source
from voronec.equations.program.low_rank import names_into, solve_mass
from voronec.equations.program.optimisation import HoistedProgram, hoist, shorten_program
from voronec.equations.program.python import (
    casadi_function,
    casadi_source,
    compile_program,
    jax_source,
    mpmath_source,
    python_source,
    scalar_source,
)
from voronec.equations.program.straight import Block, Program
from voronec.equations.program.taylor import taylor_extras, taylor_system
from voronec.equations.program.weight import operation_count

__all__ = [
    "Block",
    "HoistedProgram",
    "Program",
    "c_source",
    "casadi_function",
    "casadi_source",
    "compile_program",
    "hoist",
    "jacobian",
    "javascript_source",
    "jax_source",
    "mpmath_source",
    "names_into",
    "operation_count",
    "python_source",
    "scalar_source",
    "shorten_program",
    "solve_mass",
    "taylor_extras",
    "taylor_system",
]
