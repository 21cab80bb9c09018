"""Kinematics for definitions: rotations, surfaces, rolling contact, bodies.

SymPy expressions in and out; nothing here knows about equations of motion.  Vectors are three
expressions along right-handed orthonormal axes, matrices 3 x 3, unless it is said; angles are in
radians, all else is in units of the user's that fit together.  What is given otherwise raises
``DefinitionError``.  Names load on first use.
"""

from importlib import import_module as _import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from voronec.declaration.derivatives import derivative
    from voronec.kinematics.balanced_balls import BalancedBall, BallMotion, SymmetricBallMotion
    from voronec.kinematics.balls import RollingBall, contact_momentum
    from voronec.kinematics.bodies import (
        axial_rotor,
        kinetic_energy,
        point_velocity,
        uniform_field_energy,
    )
    from voronec.kinematics.bodies_in_rn import BodyInRn
    from voronec.kinematics.carried_contact import CarriedContact
    from voronec.kinematics.convex import ConvexBody
    from voronec.kinematics.ellipsoids import RollingEllipsoid
    from voronec.kinematics.forms import SurfaceForms
    from voronec.kinematics.groups import (
        BodyVelocity,
        skew,
        skew_entries,
        wedge_square,
    )
    from voronec.kinematics.meanings import (
        contact_meanings,
        euler_meanings,
        moving_meanings,
        place_meanings,
        sleigh_meanings,
        vector_meanings,
    )
    from voronec.kinematics.moving_sphere import BallOnMovingSphere
    from voronec.kinematics.neumann_charts import turned_poles, turned_sphere
    from voronec.kinematics.polar_chart import cartesian_chart
    from voronec.kinematics.revolution import BodyOfRevolution, TorusOnEllipsoid
    from voronec.kinematics.rolling import RollingContact
    from voronec.kinematics.rotations import Rotation
    from voronec.kinematics.rubber import RubberMotion
    from voronec.kinematics.sketches import (
        ball_sketch,
        disc_sketch,
        particle_sketch,
        pinned_sketch,
        rolling_sketch,
        sleigh_shapes,
        sleigh_sketch,
    )
    from voronec.kinematics.sleighs import Sleigh
    from voronec.kinematics.surfaces import Surface
    from voronec.kinematics.vectors import cross, dot, matrix_product

__all__ = [
    "BalancedBall",
    "BallMotion",
    "BallOnMovingSphere",
    "BodyInRn",
    "BodyOfRevolution",
    "BodyVelocity",
    "CarriedContact",
    "ConvexBody",
    "RollingBall",
    "RollingContact",
    "RollingEllipsoid",
    "Rotation",
    "RubberMotion",
    "Sleigh",
    "Surface",
    "SurfaceForms",
    "SymmetricBallMotion",
    "TorusOnEllipsoid",
    "axial_rotor",
    "ball_sketch",
    "cartesian_chart",
    "contact_meanings",
    "contact_momentum",
    "cross",
    "derivative",
    "disc_sketch",
    "dot",
    "euler_meanings",
    "kinetic_energy",
    "matrix_product",
    "moving_meanings",
    "particle_sketch",
    "pinned_sketch",
    "place_meanings",
    "point_velocity",
    "rolling_sketch",
    "skew",
    "skew_entries",
    "sleigh_meanings",
    "sleigh_shapes",
    "sleigh_sketch",
    "turned_poles",
    "turned_sphere",
    "uniform_field_energy",
    "vector_meanings",
    "wedge_square",
]

_HOME = {
    ".declaration.derivatives": "derivative",
    "balanced_balls": "BalancedBall BallMotion SymmetricBallMotion",
    "balls": "RollingBall contact_momentum",
    "bodies": "axial_rotor kinetic_energy point_velocity uniform_field_energy",
    "bodies_in_rn": "BodyInRn",
    "carried_contact": "CarriedContact",
    "convex": "ConvexBody",
    "ellipsoids": "RollingEllipsoid",
    "forms": "SurfaceForms",
    "groups": "BodyVelocity skew skew_entries wedge_square",
    "meanings": "contact_meanings euler_meanings moving_meanings place_meanings sleigh_meanings "
    "vector_meanings",
    "moving_sphere": "BallOnMovingSphere",
    "neumann_charts": "turned_poles turned_sphere",
    "polar_chart": "cartesian_chart",
    "revolution": "BodyOfRevolution TorusOnEllipsoid",
    "rolling": "RollingContact",
    "rotations": "Rotation",
    "rubber": "RubberMotion",
    "sketches": "ball_sketch disc_sketch particle_sketch pinned_sketch "
    "rolling_sketch sleigh_shapes sleigh_sketch",
    "sleighs": "Sleigh",
    "surfaces": "Surface",
    "vectors": "cross dot matrix_product",
}
"""Modules, and the names in them."""


def __getattr__(name: str) -> Any:
    for module, names in _HOME.items():
        if name in names.split():
            return getattr(_import_module(f".{module}", __name__), name)
    raise AttributeError(f"module 'voronec.kinematics' has no attribute '{name}'")


def __dir__() -> list[str]:
    return sorted(__all__)
