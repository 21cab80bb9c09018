"""Installed as ``voronec.docs``, for the sake of the one bibliography in this folder."""
