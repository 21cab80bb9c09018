"""Exact algebra: the door between SymPy and symengine, normal forms in flint, verdicts."""
