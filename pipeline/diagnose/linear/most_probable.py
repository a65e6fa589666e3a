"""The model at the most probable motion: starts, forces and departures as the readings leave them.

Along the measured motion the model is led by a force that carries the noise of the sensors, and
what is linear there is off by the square of that noise: tens to a thousand nats, and other ones
each time. At the most probable motion nothing leads; from whatever point it is sought, the log
evidence there is the same to about a nat (Gauss-Newton steps; the evidence is Laplace's, MacKay,
"Information Theory, Inference, and Learning Algorithms", 2003, ch. 27).
"""

from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np

from pipeline.diagnose.linear.elimination import ForcePrior, Grams, grams, solve, with_readings
from pipeline.diagnose.linear.linear_model import (
    LinearModel,
    Point,
    Setting,
    motion_at,
    readings_from_zero,
    residual_of,
    vector_of,
)
from pipeline.diagnose.linear.tangent import linear_model
from pipeline.errors import CannotComputeError
from pipeline.types import FloatArray

#: Simulations with derivatives of somewhere near, on the way to the most probable motion.
_CHORDS = 2
#: A whitened reading this large is that of a simulation that ran away.
_LOST = 1e7
#: So is a window in which half of the whitened residuals are larger than this.
_ASTRAY = 10.0
#: Steps with derivatives of their own, at most, and the shares of a step that are tried.
_STEPS, _SHARES = 12, (1.0, 0.5, 0.25, 0.125)
#: Root mean square by which the residuals may differ from what the step foretold when it was the
#: last one.
_SETTLED = 0.1


def most_probable(normal: Grams, forces: ForcePrior, departures: FloatArray) -> Point:
    """Most probable starts, forces and shared unknowns at departures (g,), led by nothing."""
    best = solve(normal, forces, departures)
    # whoever asks so has no reference
    return Point(best.starts, best.forces, best.shared, departures)


def linear_near(setting: Setting, forces: ForcePrior, departures: FloatArray) -> LinearModel:
    """Linearise at the most probable motion of a vehicle at departures (g,).

    It is sought from the measured motion, along which `setting` leads. Where no velocity was
    measured the way there is long, and derivatives of its beginning lead astray: then each step has
    its own. Where nothing can follow the motion freely the model is linear along the measured one.

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
    freely = moving_freely(linear_model(setting, led, renew=()), forces, departures)
    if freely is not None and freely.lost == 0.0:
        return freely
    along = linear_model(setting, led)
    return along if freely is None or along.lost < freely.lost else freely


def moving_freely(
    model: LinearModel, forces: ForcePrior, departures: FloatArray
) -> LinearModel | None:
    """Linearise at the most probable motion at departures (g,), sought from a model near it.

    None where nothing can follow the readings without being led.
    """
    ways = (partial(moved_to, model, grams(model)), partial(_moved_step_by_step, model))
    best = None
    for way in ways:
        point = way(forces, departures)
        found = None if point is None else linear_model(model.setting, point)
        if found is None or _astray(found.setting, found.residual):
            continue
        if best is None or found.lost < best.lost:
            best = found
        if best.lost == 0.0:
            break
    return best


def _astray(setting: Setting, residual: FloatArray) -> bool:
    """Whether the motion of some window is far from all that was measured in it (rows,)."""
    bounds = setting.bench.stack.bounds
    return any(
        not float(np.median(np.abs(residual[a:b]))) <= _ASTRAY for a, b in pairwise(bounds) if b > a
    )


def _moved_step_by_step(
    model: LinearModel, forces: ForcePrior, departures: FloatArray
) -> Point | None:
    """Go to the most probable motion at departures (g,) with derivatives of each step.

    Gauss-Newton steps, each shortened until no window goes astray (Nocedal and Wright, "Numerical
    Optimization", 2006, ch. 10). None where that leads nowhere.
    """
    setting, begin = model.setting, replace(model.point, departures=departures)
    try:
        vector = vector_of(setting, departures)
    except CannotComputeError:
        return None
    for _ in range(_STEPS):
        end = most_probable(grams(model), forces, departures)
        for share in _SHARES:
            point = _between(begin, end, share)
            residual = residual_of(setting, point, vector, motion_at(setting, point, vector))
            if not _astray(setting, residual):
                break
        else:
            return None
        foretold = model.readings - readings_from_zero(model, point, np.zeros(residual.size))
        if point.pull == 0.0 and float(np.sqrt(np.mean((residual - foretold) ** 2))) < _SETTLED:
            return point
        begin, model = point, linear_model(setting, point, known=model, renew=())
    return begin if begin.pull == 0.0 else None


def _between(begin: Point, end: Point, share: float) -> Point:
    """Point at a share of the way from one to another at the same departures."""
    return Point(
        begin.starts + share * (end.starts - begin.starts),
        begin.forces + share * (end.forces - begin.forces),
        begin.shared + share * (end.shared - begin.shared),
        begin.departures,
        begin.pull + share * (end.pull - begin.pull),
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
    says = model.informative_rows
    if not (np.abs(readings[says]) < _LOST).all():
        return None
    return np.where(says, readings, 0.0)
