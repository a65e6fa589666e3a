"""The channels of a run that a fit can use, with the noise that the vehicle file states."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

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


#: What stands for a noise that the vehicle file leaves at zero, and for a sensor it leaves out.
_FLOORS = {
    "angular_velocity": 2e-4,
    "specific_force": 5e-3,
    "attitude": 5e-4,
    "velocity": 2e-3,
    "depth": 2e-3,
    "position": 5e-3,
}
_UNITS = {
    "angular_velocity": "rad/s",
    "specific_force": "m/s^2",
    "attitude": "rad",
    "velocity": "m/s",
    "depth": "m",
    "position": "m",
}


_OF_THRUSTERS = ("command", "shaft_speed")
#: What a fit can use of a run.
QUANTITIES = tuple(_FLOORS)


def channel_noise(sensors: Sensors, runs: Sequence[RunTable]) -> tuple[ChannelNoise, ...]:
    """List the channels that at least one run has, with their noise.

    A sensor that the vehicle file leaves out is taken at the origin with the least noise that is
    credible; the fit then finds what it really is from the residuals.
    """
    imu, dvl = sensors.imu, sensors.dvl
    stated: dict[str, ChannelNoise] = {}
    if imu is not None:
        rate, place = imu.rate_hz, imu.position_m
        for quantity, white, bias in (
            ("angular_velocity", imu.rate_noise_radps, imu.rate_bias_radps),
            ("specific_force", imu.force_noise_mps2, imu.force_bias_mps2),
        ):
            stated[quantity] = ChannelNoise(
                quantity, _UNITS[quantity], white, bias=bias, rate_hz=rate, place_m=place
            )
        stated["attitude"] = ChannelNoise(
            "attitude",
            "rad",
            imu.attitude_noise_rad,
            imu.attitude_wander_rad,
            imu.attitude_wander_s,
            rate_hz=rate,
        )
    if dvl is not None:
        stated["velocity"] = ChannelNoise(
            "velocity", "m/s", dvl.noise_mps, rate_hz=dvl.rate_hz, place_m=dvl.position_m
        )
    if sensors.depth is not None:
        depth = sensors.depth
        stated["depth"] = ChannelNoise(
            "depth",
            "m",
            depth.noise_m,
            bias=depth.bias_m,
            rate_hz=depth.rate_hz,
            place_m=depth.position_m,
        )
    if sensors.position is not None:
        stated["position"] = ChannelNoise(
            "position", "m", sensors.position.noise_m, rate_hz=sensors.position.rate_hz
        )
    found = []
    for quantity, floor in _FLOORS.items():
        if not any(was_measured(run, quantity) for run in runs):
            continue
        channel = stated.get(quantity, ChannelNoise(quantity, _UNITS[quantity], 0.0, stated=False))
        if channel.white <= 0.0:
            channel = replace(channel, white=floor, stated=False)
        found.append(channel)
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
