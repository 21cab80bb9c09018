"""The right-hand side of a program as a function of CasADi's."""

from __future__ import annotations

from typing import Any

from voronec.equations.program.dialect import execute
from voronec.equations.program.python import casadi_source
from voronec.equations.program.straight import Program
from voronec.errors import DefinitionError

__all__ = ["casadi_function"]


def casadi_function(program: Program) -> Any:
    """``casadi.Function`` of ``t``, ``state``, ``parameters`` and ``inputs``, columns, with the
    result ``derivative``; empty columns stand where a system has no parameters or inputs."""
    try:
        import casadi
    except ImportError:
        raise DefinitionError(
            "CasADi is not installed; install it with: pip install 'voronec[control]'"
        ) from None
    namespace = execute(casadi_source(program), "program for CasADi", {})
    groups = {"state": program.state, "parameters": program.parameters, "inputs": program.inputs}
    given = {name: casadi.SX.sym(name, len(group)) for name, group in groups.items()}
    taken = list(given.values()) if program.inputs else list(given.values())[:-1]
    time = casadi.SX.sym("t")
    derivative = casadi.SX(namespace["rhs"](time, *taken))
    return casadi.Function(
        "rhs", [time, *given.values()], [derivative], ["t", *given], ["derivative"]
    )
