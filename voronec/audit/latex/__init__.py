"""From the LaTeX of a display to trees: words, lines and lists, formulas."""
