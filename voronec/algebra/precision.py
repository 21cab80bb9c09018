"""Working precisions, in bits: five levels.

Balls are rigorous: too few bits leave a question open and never answer it wrongly, so a level is
what answers at once in nearly all cases.  What answers are printed with, what a user asks for, and
where a search with more and more bits gives up stand where they are used.  ``elliptic``, which
knows nothing of algebra, has a first try and bits for its doubles of its own.
"""

FIRST = 64
"""A first try, hardly dearer than doubles, whose 53 bits it must hold with some to lose."""
GENERIC = 192
"""Values at generic points, for ranks, pivots and signs: as many bits to lose in an elimination as
twice those of a double, and a double's to tell a number from zero with."""
SHARP = 256
"""Whole and rational numbers are read off values, which must be hit to a hundred bits and more."""
BRACKETS = 320
"""Brackets of brackets of fields, which lose bits at every level."""
PROOF = 512
"""A conjugate of nested roots is told from zero: such numbers may be near to each other."""
