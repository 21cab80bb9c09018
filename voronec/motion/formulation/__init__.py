"""Formulations: in which variables a motion is integrated, one file each."""
