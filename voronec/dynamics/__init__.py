"""What motions do in the long run: steady motions, their stability, periodic orbits, exponents."""
