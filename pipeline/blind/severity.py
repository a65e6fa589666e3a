"""How large a fault is: the gap that it opens against the healthy floor.

The commands of a flown run are given to two simulations in windows of ten seconds that start from
the true motion. With and without the fault gives its trace; a healthy vehicle and the stated one,
with the noise of the instruments, give the floor. Per channel the gap ratio is

    sqrt(floor^2 + trace^2) / floor          (root mean squares over all windows)

and that of a case is the largest over the channels.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.blind.truth.craft import Craft
from pipeline.blind.truth.flight import TruthFlight, fly_craft
from pipeline.blind.truth.kernel_flight import CONTROL_S, SAMPLE, SAMPLES, Belief
from pipeline.blind.truth.sensors import dvl_velocity
from pipeline.errors import CannotComputeError
from pipeline.types import FloatArray
from pipeline.vehicle.sensor_schema import Sensors

CHANNELS = ("u", "v", "w", "p", "q", "r", "phi", "theta", "psi", "z", "x", "y")
#: Commands in a window.
WINDOW = 100


@dataclass(frozen=True)
class Floors:
    """Root mean squares by channel (12,): sensors alone, and a healthy vehicle with its sensors.

    Not a number where the channel is not measured.
    """

    sensor: FloatArray
    healthy: FloatArray


def sensor_floor(sensors: Sensors) -> FloatArray:
    """Deviation of the noise of each channel (12,); not a number where there is no sensor."""
    out = np.full(12, np.nan)
    if sensors.dvl is not None:
        out[0:3] = sensors.dvl.noise_mps
    if sensors.imu is not None:
        out[3:6] = sensors.imu.rate_noise_radps
        out[6:9] = np.hypot(sensors.imu.attitude_noise_rad, sensors.imu.attitude_wander_rad)
    if sensors.depth is not None:
        out[9] = sensors.depth.noise_m
    if sensors.position is not None:
        out[10:12] = sensors.position.noise_m
    return out


def windows_of(
    craft: Craft, belief: Belief, flight: TruthFlight, outside: FloatArray | None = None
) -> list[TruthFlight]:
    """Fly the commands of a flight in windows, each from the true motion at its start."""
    n = flight.count
    out = []
    for first in range(0, len(flight.commands) - WINDOW + 1, WINDOW):
        row = flight.samples[first * SAMPLES]
        pushes = None if outside is None else outside[first : first + WINDOW + 1]
        out.append(
            fly_craft(
                craft,
                belief,
                commands=flight.commands[first : first + WINDOW],
                outside=pushes,
                start=row[:SAMPLE],
                first_s=first * CONTROL_S,
                shafts=row[SAMPLE : SAMPLE + n],
                ramped=row[SAMPLE + 2 * n :],
            )
        )
    return out


def readings_of(
    flight: TruthFlight, craft: Craft, sensors: Sensors, late: bool = True
) -> FloatArray:
    """Return what the channels show of a motion without noise (k, 12), five times a second."""
    rows = slice(0, None, 10)
    time_s = flight.time_s[rows]
    out = np.zeros((len(time_s), 12))
    if sensors.dvl is not None:
        shown = np.maximum(time_s - (craft.dvl.delay_s if late else 0.0), 0.0)
        out[:, :3] = dvl_velocity(flight, shown, sensors.dvl, craft.dvl, craft.current)
    out[:, 3:6] = flight.ground[rows, 3:]
    turn = flight.turn[rows]
    out[:, 6] = np.arctan2(turn[:, 2, 1], turn[:, 2, 2])
    out[:, 7] = -np.arcsin(np.clip(turn[:, 2, 0], -1.0, 1.0))
    out[:, 8] = np.unwrap(np.arctan2(turn[:, 1, 0], turn[:, 0, 0]))
    out[:, 9] = flight.place[rows, 2]
    out[:, 10:] = flight.place[rows, :2]
    return out


def difference(one: FloatArray, other: FloatArray) -> FloatArray:
    """Difference of readings (k, 12), angles within half a turn."""
    out = one - other
    out[:, 6:9] = (out[:, 6:9] + np.pi) % (2.0 * np.pi) - np.pi
    return out


def trace_of(
    sick: Craft,
    well: Craft,
    belief: Belief,
    flights: Sequence[tuple[TruthFlight, FloatArray]],
    sensors: Sensors,
) -> FloatArray:
    """Difference that the fault makes, by window (windows, k, 12).

    `belief` is that of the autopilot; `flights` are runs of the sick vehicle, with the forces from
    outside on them.
    """
    out = []
    for flight, outside in flights:
        # the delay of a DVL needs what was before the window: read from the whole flight
        whole = readings_of(flight, sick, sensors)
        for k, healthy in enumerate(windows_of(well, belief, flight, outside)):
            seen = readings_of(healthy, well, sensors)
            begin = k * WINDOW * SAMPLES // 10
            out.append(difference(whole[begin : begin + len(seen)], seen))
    return np.stack(out)


def floors_of(
    stated: Craft,
    healthy: Sequence[tuple[Craft, TruthFlight]],
    belief: Belief,
    sensors: Sensors,
) -> Floors:
    """Floors from flights of healthy vehicles, predicted with the stated one."""
    noise = sensor_floor(sensors)
    squares = []
    for craft, flight in healthy:
        whole = readings_of(flight, craft, sensors)
        for k, window in enumerate(windows_of(stated, belief, flight)):
            seen = readings_of(window, stated, sensors)
            begin = k * WINDOW * SAMPLES // 10
            squares.append(difference(whole[begin : begin + len(seen)], seen) ** 2)
    if not squares:
        raise CannotComputeError("no healthy flight is long enough for a window of ten seconds")
    return Floors(noise, np.sqrt(np.concatenate(squares).mean(axis=0) + noise**2))


def ratios(trace: FloatArray, floors: Floors) -> dict[str, float]:
    """Gap ratio by channel, of those that are measured."""
    size = np.sqrt((trace**2).mean(axis=(0, 1)))
    return {
        name: float(np.hypot(floors.healthy[k], size[k]) / floors.healthy[k])
        for k, name in enumerate(CHANNELS)
        if np.isfinite(floors.healthy[k])
    }


def gap_ratio(by_channel: Mapping[str, float]) -> float:
    """Return the gap ratio of the case: that of its worst channel."""
    return max(by_channel.values())
