"""A force that sets in during a run: what the model lacks steps up at a time and stays.

The force from outside that a measured motion needs is, body axes about the origin,

    tau_out(t) = M nu' - F(nu, R) - tau(c, V) - tau_known

in means over half a second. A step at t_0 is an event where it explains most of what varies in it,
and more than motion and commands explain: a wrong drag, trim or thruster would go with those. Its
time is that of the largest likelihood. Blocks count for as many as are independent, by the lag-1
correlation of what is left (Bayley and Hammersley 1946).
"""

from dataclasses import dataclass

import numpy as np

from pipeline.measured.demand import demanded, known_wrench, settled
from pipeline.measured.inject import thrust_wrench
from pipeline.measured.motion import measured_motion
from pipeline.records.run_table import RunTable, down_axis
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray
from pipeline.vehicle.sensor_schema import Sensors

#: Length of a block, what is left out at both ends of a run, and on either side of a step. [s]
_BLOCK_S, _ENDS_S, _SIDE_S = 0.5, 2.0, 5.0
#: A step explains at least this share of what varies, and is so much likelier than that motion and
#: commands explain it [nats]. Of 40 measured and simulated runs without an event, in which it does
#: not, the nearest is at -48.
_LEAST_SHARE, _LEAST_NATS = 0.5, 10.0
#: Times this much less likely than the best may be it as well: 95 % of a likelihood ratio. [nats]
_AS_LIKELY = 1.92
#: Combinations of what goes with the motion that are smaller than this are nothing. [1]
_LEAST_SINGULAR = 1e-6


@dataclass(frozen=True)
class OutsideForce:
    """Force (k, a) that a run needs beside its model, in blocks, along measured axes [N, N m].

    `begin_s` (k,) are the times of their first rows; `axes` (a,) count from surge on. `explained`
    (k, a, f) goes with motion and commands.
    """

    begin_s: FloatArray
    force: FloatArray
    explained: FloatArray
    axes: tuple[int, ...]


@dataclass(frozen=True)
class ForceStep:
    """A step of the outside force (6,) at a time of the run [s], with 95 % interval.

    `nats` is by how much it is likelier than all that goes with motion and commands.
    """

    at_s: float
    between_s: tuple[float, float]
    force: FloatArray
    std: FloatArray
    nats: float


def outside_force(packed: PackedVehicle, run: RunTable, sensors: Sensors | None) -> OutsideForce:
    """Return the force that a run needs beside its model.

    Raises
    ------
    CannotComputeError
        Without rates of turn or attitude.
    """
    motion = measured_motion(run, sensors)
    pushed = thrust_wrench(packed, run, motion)
    force = demanded(packed, settled(packed.vector), motion) - pushed
    force -= known_wrench(packed, run, motion)
    period = run.period_s
    rows, first = max(round(_BLOCK_S / period), 1), round(_ENDS_S / period)
    count = max((run.time_s.size - 2 * first) // rows, 0)
    own, axes = slice(first, first + count * rows), np.flatnonzero(motion.measured)

    def blocks(values: FloatArray) -> FloatArray:
        return np.asarray(values[own].reshape(count, rows, *values.shape[1:]).mean(axis=1))

    nu, level = motion.nu, np.repeat(down_axis(motion.state[:, 3:7])[:, None, :2], 6, axis=1)
    goes_with = np.stack([np.ones_like(nu), nu, nu * np.abs(nu), pushed, np.abs(pushed)], axis=2)
    explained = blocks(np.concatenate([goes_with, level], axis=2))
    return OutsideForce(
        run.time_s[own][::rows],
        blocks(force)[:, axes],
        explained[:, axes],
        tuple(int(axis) for axis in axes),
    )


def force_step(seen: OutsideForce) -> ForceStep | None:
    """Find the step of a run; None where there is none."""
    side = round(_SIDE_S / _BLOCK_S)
    places = np.arange(side, seen.begin_s.size - side + 1)
    if places.size == 0:
        return None
    every = [_without_step(seen.force, int(place)) for place in places]
    best = int(np.argmax([log_likelihood(left) for left in every]))
    counted = independent(every[best])
    likelihood = np.array([log_likelihood(left, counted) for left in every])
    best = int(np.argmax(likelihood))
    left, place = every[best], int(places[best])
    noise = np.maximum(left.std(axis=0), 1e-9)
    varies = (seen.force - seen.force.mean(axis=0)) / noise
    nats = float(likelihood[best]) - log_likelihood(_without_explained(seen), counted)
    share = 1.0 - left.size / float(np.sum(varies**2))
    if share < _LEAST_SHARE or nats < _LEAST_NATS:
        return None
    before, after = seen.force[:place].mean(axis=0), seen.force[place:].mean(axis=0)
    apart = len(left) / place + len(left) / (len(left) - place)
    std = noise * np.sqrt(apart / independent(left))
    likely = places[likelihood >= likelihood[best] - _AS_LIKELY]
    step, spread = np.zeros(6), np.zeros(6)
    step[list(seen.axes)], spread[list(seen.axes)] = after - before, std
    # between two blocks, either of which may hold it
    first, last = seen.begin_s[likely[0]] - _BLOCK_S, seen.begin_s[likely[-1]] + _BLOCK_S
    return ForceStep(float(seen.begin_s[place]), (float(first), float(last)), step, spread, nats)


def log_likelihood(left: FloatArray, counted: FloatArray | None = None) -> float:
    """Log likelihood of what is left of forces (k, a), the noise of each axis unknown.

    `counted` (a,) are the blocks that count; all otherwise.
    """
    size = np.maximum(np.mean(left**2, axis=0), 1e-12)
    return float(-0.5 * np.sum((len(left) if counted is None else counted) * np.log(size)))


def independent(left: FloatArray) -> FloatArray:
    """Count (a,) of independent blocks that blocks (k, a) are worth by their lag-1 correlation."""
    size = np.maximum(np.sum(left**2, axis=0), 1e-12)
    lag = np.clip(np.sum(left[1:] * left[:-1], axis=0) / size, 0.0, 0.95)
    return np.asarray(len(left) * (1.0 - lag) / (1.0 + lag))


def _without_step(force: FloatArray, place: int) -> FloatArray:
    """Take out the means before and after a row."""
    parts = (force[:place], force[place:])
    return np.concatenate([part - part.mean(axis=0) for part in parts])


def _without_explained(seen: OutsideForce) -> FloatArray:
    """Take out what goes with motion and commands."""
    found = np.empty_like(seen.force)
    for a in range(len(seen.axes)):
        explained = seen.explained[:, a]
        explained = explained / np.maximum(np.abs(explained).max(axis=0), 1e-9)
        best = np.linalg.lstsq(explained, seen.force[:, a], rcond=_LEAST_SINGULAR)[0]
        found[:, a] = seen.force[:, a] - explained @ best
    return found
