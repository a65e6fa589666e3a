"""Vehicles that nobody had seen: their numbers, and the vehicle files that an outsider would write.

Thrusters push a n|n| - b |n| V with the inflow V along them. In `inspector` and `triad` the drive
holds a shaft speed in proportion to the code, after a first-order lag; in `courier` it holds a
torque, and the shaft turns as fast as the water lets it.
"""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
GRAVITY, DENSITY = 9.81, 1025.0
AXES = ("surge", "sway", "heave", "roll", "pitch", "yaw")
NOMINAL_V = 24.0


@dataclass(frozen=True)
class Thruster:
    """One thruster: `gain`, `reverse` are factors on its thrust, `lost` codes that do nothing."""

    name: str
    place: tuple[float, float, float]
    direction: tuple[float, float, float]
    gain: float = 1.0
    reverse: float = 1.0
    lost: float = 0.0


@dataclass(frozen=True)
class Craft:
    """A vehicle as it is; change a number and it is no longer that of its file."""

    name: str
    thrusters: tuple[Thruster, ...]
    mass: float
    buoyancy: float
    inertia: Array
    added: Array
    linear: Array
    quadratic: Array
    below: float
    """Centre of mass below, and centre of buoyancy above the origin. [m]"""
    ahead_n: float
    astern_n: float
    free_speed: float
    """Inflow that takes all thrust away at full code. [m/s]"""
    lag: float
    torque_held: bool
    code_max: int
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Centre of mass beside where it should be. [m]"""
    current: tuple[float, float, float] = (0.0, 0.0, 0.0)
    supply: tuple[float, float] = (1.0, 1.0)
    """Supply over the nominal one at the start and at the end of a run."""
    voltage_logged: bool = False
    dvl_scale: float = 1.0
    dvl_place: tuple[float, float, float] = field(default=(0.0, 0.0, 0.12))

    def names(self) -> tuple[str, ...]:
        """Names of the thrusters."""
        return tuple(one.name for one in self.thrusters)


def _array(*values: float) -> Array:
    return np.array(values, float)


INSPECTOR = Craft(
    "inspector",
    (
        Thruster("port", (-0.15, -0.21, 0.03), (1.0, 0.0, 0.0)),
        Thruster("starboard", (-0.15, 0.21, 0.03), (1.0, 0.0, 0.0)),
        Thruster("lateral", (0.04, 0.0, 0.0), (0.0, 1.0, 0.0)),
        Thruster("lift", (0.02, 0.0, -0.05), (0.0, 0.0, 1.0)),
    ),
    mass=17.4,
    buoyancy=17.4 * GRAVITY + 1.0,
    inertia=_array(0.42, 0.61, 0.66),
    added=_array(6.5, 12.0, 15.0, 0.12, 0.22, 0.18),
    linear=_array(6.0, 10.0, 13.0, 0.4, 0.6, 0.5),
    quadratic=_array(45.0, 95.0, 120.0, 0.9, 1.3, 1.1),
    below=0.03,
    ahead_n=52.0,
    astern_n=38.0,
    free_speed=4.2,
    lag=0.09,
    torque_held=False,
    code_max=1000,
)
COURIER = Craft(
    "courier",
    (
        Thruster("stern", (-1.05, 0.0, 0.0), (1.0, 0.0, 0.0)),
        Thruster("bow_side", (0.72, 0.0, 0.0), (0.0, 1.0, 0.0)),
        Thruster("stern_side", (-0.68, 0.0, 0.0), (0.0, 1.0, 0.0)),
        Thruster("bow_down", (0.60, 0.0, 0.0), (0.0, 0.0, 1.0)),
        Thruster("stern_down", (-0.56, 0.0, 0.0), (0.0, 0.0, 1.0)),
    ),
    mass=58.0,
    buoyancy=58.0 * GRAVITY + 2.0,
    inertia=_array(0.9, 17.0, 17.2),
    added=_array(3.5, 52.0, 52.0, 0.05, 12.0, 12.0),
    linear=_array(4.0, 30.0, 30.0, 0.8, 18.0, 18.0),
    quadratic=_array(14.0, 190.0, 190.0, 1.5, 60.0, 60.0),
    below=0.035,
    ahead_n=70.0,
    astern_n=55.0,
    free_speed=5.5,
    lag=0.14,
    torque_held=True,
    code_max=127,
)
TRIAD = Craft(
    "triad",
    (
        Thruster("bow", (0.30, 0.0, 0.02), (0.0, 1.0, 0.0)),
        Thruster("left", (-0.15, -0.26, 0.02), (0.866025, -0.5, 0.0)),
        Thruster("right", (-0.15, 0.26, 0.02), (0.866025, 0.5, 0.0)),
        Thruster("up_bow", (0.24, 0.0, 0.0), (0.0, 0.0, -1.0)),
        Thruster("up_left", (-0.12, -0.21, 0.0), (0.0, 0.0, -1.0)),
        Thruster("up_right", (-0.12, 0.21, 0.0), (0.0, 0.0, -1.0)),
    ),
    mass=31.0,
    buoyancy=31.0 * GRAVITY,
    inertia=_array(1.1, 1.3, 1.6),
    added=_array(14.0, 19.0, 30.0, 0.5, 0.6, 0.7),
    linear=_array(11.0, 15.0, 24.0, 1.0, 1.2, 1.4),
    quadratic=_array(85.0, 120.0, 210.0, 2.2, 2.6, 2.4),
    below=0.02,
    ahead_n=60.0,
    astern_n=60.0,
    free_speed=3.6,
    lag=0.11,
    torque_held=False,
    code_max=255,
)
CRAFTS = (INSPECTOR, COURIER, TRIAD)
#: Standard uncertainties that the files state.
UNCERTAINTY = {"thrust": 0.03, "added_mass": 0.06, "damping": 0.08, "buoyancy_n": 0.6}
#: Noise of the sensors: rates [rad/s], specific force [m/s^2], attitude [rad], velocity [m/s],
#: depth [m], voltage [V].
NOISE = {
    "rate": 1.2e-3,
    "force": 0.02,
    "attitude": 1.5e-3,
    "dvl": 5e-3,
    "depth": 5e-3,
    "volt": 0.05,
}
WANDER_RAD, WANDER_S, RATE_BIAS, FORCE_BIAS, DEPTH_BIAS = 5e-3, 25.0, 6e-4, 0.03, 0.02


def as_built(craft: Craft, generator: np.random.Generator) -> Craft:
    """Draw a vehicle that differs from its file by what the file states to be unsure of."""

    def about(size: float, count: int) -> Array:
        return np.asarray(np.exp(size * generator.standard_normal(count)))

    thrust = float(about(UNCERTAINTY["thrust"], 1)[0])
    each = about(0.004, len(craft.thrusters))
    return replace(
        craft,
        thrusters=tuple(
            replace(one, gain=one.gain * thrust * float(g))
            for one, g in zip(craft.thrusters, each, strict=True)
        ),
        added=craft.added * about(UNCERTAINTY["added_mass"], 6),
        linear=craft.linear * about(UNCERTAINTY["damping"], 6),
        quadratic=craft.quadratic * about(UNCERTAINTY["damping"], 6),
        buoyancy=craft.buoyancy + UNCERTAINTY["buoyancy_n"] * float(generator.standard_normal()),
    )


def vehicle_file(craft: Craft) -> str:
    """Write the vehicle file by docs/formats.md."""
    rows = "\n".join(
        f"  - {{name: {one.name}, propeller: p, drive: d, position_m: {list(one.place)}, "
        f"direction: {list(one.direction)}}}"
        for one in craft.thrusters
    )
    volume = craft.buoyancy / (DENSITY * GRAVITY)
    body: dict[str, Any] = {
        "mass_kg": craft.mass,
        "centre_of_mass_m": [0.0, 0.0, craft.below],
        "inertia_kgm2": [*craft.inertia.tolist(), 0.0, 0.0, 0.0],
        "displaced_volume_m3": round(volume, 7),
        "centre_of_buoyancy_m": [0.0, 0.0, -craft.below],
    }
    rigid = "\n".join(f"    {key}: {value}" for key, value in body.items())
    exponent = 1.0 if craft.torque_held else 2.0
    unsure = "\n    ".join(f"{key}: {value}" for key, value in UNCERTAINTY.items())
    voltage = ""
    if craft.voltage_logged:
        voltage = f"\n  voltage: {{rate_hz: 2.0, nominal_v: {NOMINAL_V}, noise_v: {NOISE['volt']}}}"
    return f"""# Written by the evaluation's own generator, from docs/formats.md alone.
name: {craft.name}
title: {craft.name}, a vehicle of the second generator
water: {{density_kgpm3: {DENSITY}, gravity_mps2: {GRAVITY}}}
propellers:
  p: {{diameter_m: 0.1}}
drives:
  d: {{code_min: {-craft.code_max}, code_max: {craft.code_max}}}
thrusters:
{rows}
tables: {{propeller: p, drive: d, speed_mps: [0.0], thrust_dead_n: 0.5}}
model:
  terms: {{thrust_falls_with_speed: true, coriolis: true}}
  rigid_body:
{rigid}
  added_mass:
    diagonal: {craft.added.tolist()}
  damping:
    linear: {craft.linear.tolist()}
    quadratic: {craft.quadratic.tolist()}
  thrusters:
    d:
      characteristic:
        kind: bollard
        thrust_max_n: {craft.ahead_n}
        thrust_min_n: {-craft.astern_n}
        dead_zone_code: 0
        exponent: {exponent}
        zero_thrust_speed_mps: {craft.free_speed}
      lag_s: {craft.lag}
  uncertainty:
    centre_of_mass_m: 0.001
    {unsure}
sensors:
  command_rate_hz: 10.0
  imu:
    rate_hz: 50.0
    rate_noise_radps: {NOISE["rate"]}
    rate_bias_radps: {RATE_BIAS}
    force_noise_mps2: {NOISE["force"]}
    force_bias_mps2: {FORCE_BIAS}
    attitude_noise_rad: {NOISE["attitude"]}
    attitude_wander_rad: {WANDER_RAD}
    attitude_wander_s: {WANDER_S}
  dvl:
    rate_hz: 5.0
    delay_s: 0.05
    position_m: {list(craft.dvl_place)}
    noise_mps: {NOISE["dvl"]}
  depth: {{rate_hz: 8.0, noise_m: {NOISE["depth"]}, bias_m: {DEPTH_BIAS}}}{voltage}
"""
