"""The integrators behind one shape: a problem and a grid of times in, a run out."""

from voronec.motion.steppers.c_stepper import c_loop, growth_source
from voronec.motion.steppers.dop853_source import DOP853, FIRST_GROWTH
from voronec.motion.steppers.event_states import make_with_event_states, with_parts
from voronec.motion.steppers.feedback import MEND, ControllerFailure, Feedback
from voronec.motion.steppers.held_steps import Leap, held_integrator
from voronec.motion.steppers.heyoka_stepper import (
    COMPACT,
    LONG,
    heyoka,
    parameter_count,
    taylor,
    taylor_leap,
    unit_parameters,
)
from voronec.motion.steppers.integer_taylor import digits
from voronec.motion.steppers.kept_code import kept_library
from voronec.motion.steppers.numba_stepper import (
    compiled_dop853,
    compiled_loop,
    dop853_leap,
)
from voronec.motion.steppers.run import (
    COLLAPSE,
    DISTANT,
    FAR,
    INFINITE,
    WINDOW,
    Integrator,
    Problem,
    Run,
    Signal,
    Signals,
    StallDetector,
    Suspect,
    Termination,
    Ticker,
    constants_along,
    crossing_arrays,
    exact_mpf,
    in_kind,
    in_parts,
    restart,
    until,
    values_along,
)
from voronec.motion.steppers.samples import (
    NODES,
    WIDTH,
    OwnedSamples,
    Rates,
    StepSamples,
    by_owner,
    series_samples,
    spread,
)
from voronec.motion.steppers.scipy_stepper import (
    TRIAL,
    dop853,
    estimated_steps,
    lsoda,
)
from voronec.motion.steppers.series_reach import (
    MANY,
    PARTS,
    STRIDE,
    Field,
    LongSteps,
    blind_lanes,
    field_of,
    long_steps,
    reach_of_series,
    uneven_steps,
)
from voronec.motion.steppers.units import (
    CHUNK,
    SHORT,
    TurnCount,
    balance,
    natural_units,
    units_of_many,
)
from voronec.motion.steppers.wide_batch import Place, WideBatch

__all__ = [
    "CHUNK", "COLLAPSE", "COMPACT", "DISTANT", "DOP853", "FAR", "FIRST_GROWTH", "INFINITE", "LONG",
    "MANY", "MEND", "NODES", "PARTS", "SHORT", "STRIDE", "TRIAL", "WIDTH", "WINDOW",
    "ControllerFailure", "Feedback", "Field", "Integrator", "Leap",
    "LongSteps", "OwnedSamples", "Place", "Problem", "Rates", "Run",
    "Signal", "Signals", "StallDetector", "StepSamples",
    "Suspect", "Termination", "Ticker", "TurnCount", "WideBatch", "balance", "blind_lanes",
    "by_owner", "c_loop", "compiled_dop853", "compiled_loop", "constants_along", "crossing_arrays",
    "digits", "dop853", "dop853_leap",
    "estimated_steps", "exact_mpf", "field_of", "growth_source", "held_integrator", "heyoka",
    "in_kind", "in_parts", "kept_library", "long_steps", "lsoda", "make_with_event_states",
    "natural_units",
    "parameter_count", "reach_of_series", "restart", "series_samples",
    "spread", "taylor", "taylor_leap", "uneven_steps", "unit_parameters", "units_of_many", "until",
    "values_along", "with_parts",
]  # fmt: skip
