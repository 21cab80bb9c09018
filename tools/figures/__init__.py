"""What is measured: the engine, its integrators and the closed form, against others."""
