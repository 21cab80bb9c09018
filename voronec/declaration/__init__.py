"""What is declared: systems, geometry, claims, charts, scenes, relations; the catalogue."""
