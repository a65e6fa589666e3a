"""What differs from vehicle to vehicle and from run to run: parameters, disturbances, noise.

The parameters are drawn from the uncertainty that the vehicle file states; what it does not state
is as the file says.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.blind.truth.craft import Craft
from pipeline.types import FloatArray
from pipeline.vehicle.model_schema import Uncertainty

#: Nothing is drawn further out than this many standard uncertainties.
FURTHEST = 2.5
#: Half of the variance of the thrust's error is common to all thrusters: one rig measured them.
COMMON_SHARE = 0.5
#: Standard deviation of the background force as a share of the largest thrust of one thruster,
#: its arm for the moment [m], and its correlation times [s].
DISTURBANCE_SHARE = 0.003
DISTURBANCE_ARM_M = 0.06
DISTURBANCE_S = (0.8, 6.0)


def _bounded(rng: np.random.Generator, size: int | tuple[int, ...] = 1) -> FloatArray:
    return np.asarray(np.clip(rng.standard_normal(size), -FURTHEST, FURTHEST))


def drawn(craft: Craft, known: Uncertainty, rng: np.random.Generator) -> Craft:
    """Return a healthy vehicle of this kind: every parameter off by a draw of its uncertainty."""
    n = len(craft.names)
    common, own = _bounded(rng), _bounded(rng, n)
    thrust = np.sqrt(COMMON_SHARE) * common + np.sqrt(1.0 - COMMON_SHARE) * own
    water = np.sqrt(np.maximum(1.0 + known.added_mass * _bounded(rng, 6), 0.2))
    linear = np.sqrt(np.maximum(1.0 + known.damping * _bounded(rng, 6), 0.2))
    quadratic = np.maximum(1.0 + known.damping * _bounded(rng, 6), 0.2)
    buoyancy = known.buoyancy_n * float(_bounded(rng)[0])
    return craft.changed(
        gain=craft.gain * np.maximum(1.0 + known.thrust * thrust, 0.1),
        added=craft.added * np.outer(water, water),
        linear=craft.linear * np.outer(linear, linear),
        quadratic=craft.quadratic * quadratic,
        buoyancy_n=craft.buoyancy_n + buoyancy,
        centre_g=craft.centre_g + known.centre_of_mass_m * _bounded(rng, 3),
    )


@dataclass(frozen=True)
class Weather:
    """How restless the water and how noisy the instruments are, as factors on the usual size."""

    disturbance: float = 1.0
    noise: float = 1.0


def some_weather(rng: np.random.Generator) -> Weather:
    """Draw a day: disturbances within a factor of two, sensors within 15 % of their statement."""
    return Weather(float(np.exp(rng.uniform(-0.7, 0.7))), float(rng.uniform(0.85, 1.15)))


def wander(
    rng: np.random.Generator, count: int, columns: int, tau_steps: float | FloatArray
) -> FloatArray:
    """First-order Gauss-Markov noise of unit variance (count, columns)."""
    from scipy.signal import lfilter

    keep = np.broadcast_to(np.exp(-1.0 / np.maximum(np.asarray(tau_steps, float), 1e-3)), columns)
    white = rng.standard_normal((count, columns))
    out = np.empty((count, columns))
    for k in range(columns):
        drive = white[:, k] * np.sqrt(1.0 - keep[k] ** 2)
        drive[:1] = white[:1, k]
        out[:, k] = lfilter([1.0], [1.0, -keep[k]], drive)
    return out


def background(
    craft: Craft, weather: Weather, count: int, step_s: float, rng: np.random.Generator
) -> FloatArray:
    """Force from outside at the commands' times (count, 9): NED force, body force and moment.

    Eddies shed by the hull and stirred by the thrusters: a fast and a slow part on every axis.
    """
    size = DISTURBANCE_SHARE * weather.disturbance * max(law.most_n[0] for law in craft.laws)
    out = np.zeros((count, 9))
    for tau_s in DISTURBANCE_S:
        out[:, 3:] += wander(rng, count, 6, tau_s / step_s) / np.sqrt(len(DISTURBANCE_S))
    out[:, 3:6] *= size
    # the moment's arm grows with the vehicle, its inertia with the arm
    arm = DISTURBANCE_ARM_M * float(np.clip((craft.mass_kg / 50.0) ** (1.0 / 3.0), 0.5, 2.0))
    arms = np.array([0.3 * arm, arm, arm])
    out[:, 6:] *= size * arms
    return out
