"""The model at the most probable motion: starts, forces and departures as the readings leave them.

Along the measured motion the model is led by a force that carries the noise of the sensors, and
what is linear there is off by the square of that noise: tens to a thousand nats, and other ones
each time. At the most probable motion nothing leads; from whatever point it is sought, the log
evidence there is the same to about a nat (Gauss-Newton steps; the evidence is Laplace's, MacKay,
"Information Theory, Inference, and Learning Algorithms", 2003, ch. 27).
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from pipeline.diagnose.elimination import ForcePrior, Grams, grams, solve, with_readings
from pipeline.diagnose.linear_model import (
    LinearModel,
    Point,
    Setting,
    motion_at,
    readings_from_zero,
    residual_of,
    vector_of,
)
from pipeline.diagnose.tangent import linear_model
from pipeline.errors import CannotComputeError
from pipeline.types import FloatArray

#: Simulations with derivatives of somewhere near, on the way to the most probable motion.
_CHORDS = 2
#: A whitened reading this large is that of a simulation that ran away.
_LOST = 1e7
#: So is a window in which half of the whitened residuals are larger than this.
_ASTRAY = 10.0


def most_probable(normal: Grams, forces: ForcePrior, departures: FloatArray) -> Point:
    """Most probable starts, forces and shared unknowns at departures (g,), led by nothing."""
    best = solve(normal, forces, departures)
    return Point(best.starts, best.forces, best.shared, departures)


def linear_near(setting: Setting, forces: ForcePrior, departures: FloatArray) -> LinearModel:
    """Linearise at the most probable motion of a vehicle at departures (g,).

    It is sought from the measured motion, along which `setting` leads; where nothing can follow it
    freely, or the way to it leads astray, as it may where no velocity was measured, the model is
    linear along the measured motion itself.

    Parameters
    ----------
    setting : Setting
        Windows, led by a model near the departures.
    forces : ForcePrior
        What is believed of the outside forces.
    departures : ndarray, shape (g,)
        Where the vehicle is.
    """
    led = replace(setting.origin(), departures=departures)
    model = linear_model(setting, led, renew=())
    point = moved_to(model, grams(model), forces, departures)
    freely = None if point is None else linear_model(setting, point)
    if freely is not None and freely.lost == 0.0 and not _astray(freely):
        return freely
    along = linear_model(setting, led)
    if freely is None or _astray(freely) or along.lost < freely.lost:
        return along
    return freely


def _astray(model: LinearModel) -> bool:
    """Whether the motion of some window is far from all that was measured in it."""
    bounds = model.setting.bench.stack.bounds
    return any(
        float(np.median(np.abs(model.residual[a:b]))) > _ASTRAY
        for a, b in pairwise(bounds)
        if b > a
    )


def moved_to(
    model: LinearModel, normal: Grams, forces: ForcePrior, departures: FloatArray
) -> Point | None:
    """Most probable motion at departures (g,), with the derivatives of a model near it.

    None where a vehicle at these departures runs away there.
    """
    point = most_probable(normal, forces, departures)
    for _ in range(_CHORDS):
        readings = readings_there(model, point)
        if readings is None:
            return None
        normal = with_readings(normal, replace(model, readings=readings))
        point = most_probable(normal, forces, departures)
    return point


def readings_there(model: LinearModel, point: Point) -> FloatArray | None:
    """Compute the readings from zero (rows,) as they are seen at a point.

    One simulation: how the motion changes is taken from `model`. None where the simulation ran
    away, or no vehicle can have the departures.
    """
    setting = model.setting
    try:
        vector = vector_of(setting, point.departures)
    except CannotComputeError:
        return None
    motion = motion_at(setting, point, vector)
    readings = readings_from_zero(model, point, residual_of(setting, point, vector, motion))
    says = model.says
    if not (np.abs(readings[says]) < _LOST).all():
        return None
    return np.where(says, readings, 0.0)
