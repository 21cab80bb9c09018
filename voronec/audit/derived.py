"""What the engine derived, as LaTeX in the names of the paper."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef

from voronec.algebra.normal import shorten
from voronec.audit.meaning import evaluate, names_constant, whole_name
from voronec.audit.nodes import Chain, Dot, Name, Node, Symbol_free, walk
from voronec.audit.study import Study
from voronec.errors import EngineLimit

__all__ = ["derived_latex", "print_latex"]
