"""What is true of motions, proved or refuted: claims, relations, and the check of everything."""
