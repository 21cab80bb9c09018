"""Exact algebra: the bridge between SymPy and symengine, normal forms in flint, verdicts."""
