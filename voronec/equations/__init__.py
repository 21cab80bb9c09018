"""From a Lagrangian and constraints to equations of motion, their programs and their referee."""
