"""What motions do in the long run: periodic orbits with their multipliers, Lyapunov exponents."""
