"""Kinematics for definitions: rotations, surfaces, rolling contact, bodies.

SymPy expressions in and out; nothing here knows about equations of motion.  Vectors are three
expressions along right-handed orthonormal axes, matrices 3 x 3, unless it is said; angles are in
radians, all else is in units of the user's that fit together.  What is given otherwise raises
``DefinitionError``.  Names load on first use.
"""

from typing import TYPE_CHECKING

from voronec.algebra.lazy_names import load_on_use

if TYPE_CHECKING:
    from voronec.declaration.derivatives import derivative as derivative
    from voronec.kinematics.balanced_balls import BalancedBall as BalancedBall
    from voronec.kinematics.balanced_balls import BallMotion as BallMotion
    from voronec.kinematics.balanced_balls import SymmetricBallMotion as SymmetricBallMotion
    from voronec.kinematics.ball_on_revolution import BallOnRevolution as BallOnRevolution
    from voronec.kinematics.balls import RollingBall as RollingBall
    from voronec.kinematics.balls import contact_momentum as contact_momentum
    from voronec.kinematics.bodies import axial_rotor as axial_rotor
    from voronec.kinematics.bodies import kinetic_energy as kinetic_energy
    from voronec.kinematics.bodies import point_velocity as point_velocity
    from voronec.kinematics.bodies import uniform_field_energy as uniform_field_energy
    from voronec.kinematics.bodies_in_rn import BodyInRn as BodyInRn
    from voronec.kinematics.body_on_plane import BodyOnPlane as BodyOnPlane
    from voronec.kinematics.carried_contact import CarriedContact as CarriedContact
    from voronec.kinematics.convex import ConvexBody as ConvexBody
    from voronec.kinematics.ellipsoids import RollingEllipsoid as RollingEllipsoid
    from voronec.kinematics.forms import SurfaceForms as SurfaceForms
    from voronec.kinematics.groups import BodyVelocity as BodyVelocity
    from voronec.kinematics.groups import skew as skew
    from voronec.kinematics.groups import skew_entries as skew_entries
    from voronec.kinematics.groups import wedge_square as wedge_square
    from voronec.kinematics.meanings import contact_meanings as contact_meanings
    from voronec.kinematics.meanings import euler_meanings as euler_meanings
    from voronec.kinematics.meanings import moving_meanings as moving_meanings
    from voronec.kinematics.meanings import place_meanings as place_meanings
    from voronec.kinematics.meanings import sleigh_meanings as sleigh_meanings
    from voronec.kinematics.meanings import vector_meanings as vector_meanings
    from voronec.kinematics.moving_sphere import BallOnMovingSphere as BallOnMovingSphere
    from voronec.kinematics.neumann_charts import turned_poles as turned_poles
    from voronec.kinematics.neumann_charts import turned_sphere as turned_sphere
    from voronec.kinematics.polar_chart import cartesian_chart as cartesian_chart
    from voronec.kinematics.revolution import BodyOfRevolution as BodyOfRevolution
    from voronec.kinematics.revolution import TorusOnEllipsoid as TorusOnEllipsoid
    from voronec.kinematics.rolling import RollingContact as RollingContact
    from voronec.kinematics.rotations import Rotation as Rotation
    from voronec.kinematics.rubber import RubberMotion as RubberMotion
    from voronec.kinematics.sketches import ball_sketch as ball_sketch
    from voronec.kinematics.sketches import disc_sketch as disc_sketch
    from voronec.kinematics.sketches import particle_sketch as particle_sketch
    from voronec.kinematics.sketches import pinned_sketch as pinned_sketch
    from voronec.kinematics.sketches import rolling_sketch as rolling_sketch
    from voronec.kinematics.sketches import sleigh_shapes as sleigh_shapes
    from voronec.kinematics.sketches import sleigh_sketch as sleigh_sketch
    from voronec.kinematics.sleighs import Sleigh as Sleigh
    from voronec.kinematics.surfaces import Surface as Surface
    from voronec.kinematics.vectors import cross as cross
    from voronec.kinematics.vectors import dot as dot
    from voronec.kinematics.vectors import matrix_product as matrix_product

__all__, __getattr__, __dir__ = load_on_use(
    __name__,
    {
        "voronec.declaration.derivatives": "derivative",
        "balanced_balls": "BalancedBall BallMotion SymmetricBallMotion",
        "ball_on_revolution": "BallOnRevolution",
        "balls": "RollingBall contact_momentum",
        "bodies": "axial_rotor kinetic_energy point_velocity uniform_field_energy",
        "bodies_in_rn": "BodyInRn",
        "body_on_plane": "BodyOnPlane",
        "carried_contact": "CarriedContact",
        "convex": "ConvexBody",
        "ellipsoids": "RollingEllipsoid",
        "forms": "SurfaceForms",
        "groups": "BodyVelocity skew skew_entries wedge_square",
        "meanings": "contact_meanings euler_meanings moving_meanings place_meanings "
        "sleigh_meanings vector_meanings",
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
    },
)
