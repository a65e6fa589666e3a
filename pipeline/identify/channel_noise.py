"""The channels of a run that a fit can use, with the noise that the vehicle file states."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pipeline.records.run_table import RunTable
from pipeline.vehicle.sensor_schema import Sensors


@dataclass(frozen=True)
class ChannelNoise:
    """One channel: noise as the vehicle file states it, and where the sensor sits.

    `white`, `wander`, `bias` are standard deviations in the channel's unit: of each reading, of a
    slow first-order error with correlation time `wander_s`, and of an offset constant over a run.
    """

    quantity: str
    unit: str
    white: float
    wander: float = 0.0
    wander_s: float = 1.0
    bias: float = 0.0
    rate_hz: float = 10.0
    place_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    stated: bool = True

    def of_reading(self, *, offset: bool) -> float:
        """Return the standard deviation of one reading that the vehicle file states, in its unit.

        The `offset` does not count where it was estimated and taken off the readings.
        """
        slow = np.hypot(self.white, self.wander)
        return float(np.hypot(slow, self.bias) if offset else slow)


#: Quantity -> unit, and what stands for a noise that the vehicle file leaves out.
_UNIT_AND_FLOOR = {
    "angular_velocity": ("rad/s", 2e-4),
    "specific_force": ("m/s^2", 5e-3),
    "attitude": ("rad", 5e-4),
    "velocity": ("m/s", 2e-3),
    "depth": ("m", 2e-3),
    "position": ("m", 5e-3),
}
_OF_THRUSTERS = ("command", "shaft_speed")
#: What a fit can use of a run.
QUANTITIES = tuple(_UNIT_AND_FLOOR)


def channel_noise(sensors: Sensors, runs: Sequence[RunTable]) -> tuple[ChannelNoise, ...]:
    """List the channels that at least one run has, with their noise.

    A sensor that the vehicle file leaves out is taken at the origin with the least noise that is
    credible; the fit then finds what it really is from the residuals.
    """
    imu, dvl, depth, fix = sensors.imu, sensors.dvl, sensors.depth, sensors.position
    stated: dict[str, ChannelNoise] = {}

    def state(quantity: str, white: float, rate_hz: float, **more: Any) -> None:  # noqa: ANN401 - as fields
        unit, _ = _UNIT_AND_FLOOR[quantity]
        stated[quantity] = ChannelNoise(quantity, unit, white, rate_hz=rate_hz, **more)

    if imu is not None:
        rate, place = imu.rate_hz, imu.position_m
        noise, bias = imu.rate_noise_radps, imu.rate_bias_radps
        state("angular_velocity", noise, rate, bias=bias, place_m=place)
        noise, bias = imu.force_noise_mps2, imu.force_bias_mps2
        state("specific_force", noise, rate, bias=bias, place_m=place)
        wander, wander_s = imu.attitude_wander_rad, imu.attitude_wander_s
        state("attitude", imu.attitude_noise_rad, rate, wander=wander, wander_s=wander_s)
    if dvl is not None:
        state("velocity", dvl.noise_mps, dvl.rate_hz, place_m=dvl.position_m)
    if depth is not None:
        state("depth", depth.noise_m, depth.rate_hz, bias=depth.bias_m, place_m=depth.position_m)
    if fix is not None:
        state("position", fix.noise_m, fix.rate_hz)
    found = []
    for quantity, (unit, floor) in _UNIT_AND_FLOOR.items():
        if not any(was_measured(run, quantity) for run in runs):
            continue
        channel = stated.get(quantity, ChannelNoise(quantity, unit, 0.0))
        found.append(
            channel if channel.white > 0.0 else replace(channel, white=floor, stated=False)
        )
    return tuple(found)


def was_measured(run: RunTable, quantity: str) -> bool:
    """Whether a run holds a quantity, valid at some time with all of its components.

    Of what each thruster has one is enough.
    """
    if quantity not in run.values:
        return False
    there = np.isfinite(run.values[quantity])
    some = there.any(axis=1) if quantity in _OF_THRUSTERS else there.all(axis=1)
    return bool((run.valid[quantity] & some).any())
