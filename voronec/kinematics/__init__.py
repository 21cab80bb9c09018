"""Kinematics for definitions: rotations, surfaces, rolling contact, bodies.

SymPy expressions in and out; nothing here knows about equations of motion.
"""

from voronec.kinematics.bodies import (
    axial_rotor,
    kinetic_energy,
    point_velocity,
    uniform_field_energy,
)
from voronec.kinematics.forms import SurfaceForms
from voronec.kinematics.rolling import RollingContact
from voronec.kinematics.rotations import Rotation
from voronec.kinematics.surfaces import Surface

__all__ = [
    "RollingContact",
    "Rotation",
    "Surface",
    "SurfaceForms",
    "axial_rotor",
    "kinetic_energy",
    "point_velocity",
    "uniform_field_energy",
]
