"""The audit of a paper: its formulas read from LaTeX and compared with what the engine derives."""
