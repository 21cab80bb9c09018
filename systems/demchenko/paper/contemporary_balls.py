"""Chaplygin's balls on a plane and on a sphere: the displays as printed, and their checks."""

from __future__ import annotations

from dataclasses import replace

from voronec.audit import Check, Study

from ..transcription import displays

DEFINITION = Check("definition", study="outer")
EVERYWHERE = Check(study="outer", also=("inner", "plane"))
GYROSCOPE = Check(
    study="outer with gyroscope", also=("inner with gyroscope", "plane with gyroscope")
)
MARKEEV = Check(study="plane with gyroscope")
RUBBER = Check(study="rubber", also=("rubber inside", "rubber on a plane"))
NO_TWIST = replace(RUBBER, constrains=1)


def studies() -> dict[str, Study]:
    """The dictionaries: outer rolling, the two configurations with a minus sign, the plane."""
    from ..dictionary.chaplygin_balls import CONFIGURATIONS, KAPPA, R1, R2, SIGNED_RADIUS, Ball
    from ..dictionary.rubber_balls import Rubber

    found = {}
    for name, kappa in (("", None), (" with gyroscope", KAPPA)):
        found["outer" + name] = Ball.on_sphere(R1, kappa).study({r"\pm": 1})
        found["inner" + name] = Ball.on_sphere(-R1, kappa).study({r"\pm": -1})
        found["plane" + name] = Ball.on_plane(kappa).study()
        found["spheres" + name] = Ball.on_sphere(SIGNED_RADIUS, kappa).study(ranges=CONFIGURATIONS)
    found["double shell"] = Ball.on_sphere(-R2 / 2).with_linear_integral()
    found["rubber"] = Rubber.on_sphere(R1).study()
    found["rubber inside"] = Rubber.on_sphere(-R1).study()
    found["rubber on a plane"] = Rubber.on_plane().study()
    return found


def integral(name: str, check: Check) -> Check:
    """Print that it does not change along the motion, rather than what it is."""
    return replace(check, derived=lambda study, where: study.context.still(name))


def integral_checks(check: Check, *names: str) -> tuple[Check, ...]:
    """A check for each of several integrals."""
    return tuple(integral(name, check) for name in names)


INTEGRAL_ROWS = integral_checks(EVERYWHERE, "F_1", "F_2", "F_3")
SHELL_INTEGRAL = integral_checks(Check(study="double shell"), r"\tilde F_4")
GYROSCOPE_INTEGRALS = (*integral_checks(GYROSCOPE, "F_1", "F_2", "F_3"), integral("F_4", MARKEEV))
MOMENT_MATRIX = (replace(DEFINITION, source="the moments of inertia that the Lagrangian has"),)
UNIT_MATRIX = (replace(DEFINITION, source="the unit matrix"),)
PLANE_INTEGRAL = integral_checks(Check(study="plane"), "F_4")

DISPLAYS = displays(__file__, globals())

INLINE = displays(__file__, globals(), "inline")
