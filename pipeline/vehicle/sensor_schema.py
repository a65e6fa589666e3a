"""The ``sensors:`` section of the vehicle file: what is measured, how often, how well."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Vector3 = tuple[float, float, float]


class Sensor(BaseModel):
    """A sensor: frozen, unknown keys refused. `delay_s` is the known age of a reading."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    rate_hz: Annotated[float, Field(gt=0, le=2000)]
    delay_s: NotNegative = 0.0
    source: str = ""


class Imu(Sensor):
    """Angular rate, specific force and attitude at `position_m` of the body."""

    position_m: Vector3 = (0.0, 0.0, 0.0)
    rate_noise_radps: NotNegative = 0.0
    rate_bias_radps: NotNegative = 0.0
    """Standard deviation of the constant bias of a run."""
    force_noise_mps2: NotNegative = 0.0
    force_bias_mps2: NotNegative = 0.0
    attitude_noise_rad: NotNegative = 0.0
    attitude_wander_rad: NotNegative = 0.0
    """Standard deviation of a slow error (first-order Gauss-Markov)."""
    attitude_wander_s: Positive = 10.0
    """Its correlation time."""


class Dvl(Sensor):
    """Velocity over ground in the sensor's axes, which are rotated and placed as stated."""

    position_m: Vector3 = (0.0, 0.0, 0.0)
    rotation_deg: Vector3 = (0.0, 0.0, 0.0)
    """Of the sensor in the body: by roll about x, then pitch about y, then yaw about z."""
    scale: Annotated[float, Field(ge=0.1, le=10)] = 1.0
    """What it reads over the true speed; readings are divided by it as logs are read."""
    noise_mps: NotNegative = 0.0
    water_track: bool = False


class Depth(Sensor):
    """Depth from pressure at `position_m`."""

    position_m: Vector3 = (0.0, 0.0, 0.0)
    noise_m: NotNegative = 0.0
    bias_m: NotNegative = 0.0


class Position(Sensor):
    """Position from an acoustic or optical system, NED."""

    noise_m: NotNegative = 0.0


class ShaftSpeed(Sensor):
    """Shaft speed of each thruster, where the thruster model has one."""

    noise_rpm: NotNegative = 0.0


class Voltage(Sensor):
    """Supply voltage at the thrusters and its nominal value."""

    nominal_v: Positive
    noise_v: NotNegative = 0.0


class Sensors(BaseModel):
    """The sensors on board; one that is missing is not simulated."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    command_rate_hz: Annotated[float, Field(gt=0, le=2000)] = 50.0
    """How often the commanded codes are logged."""
    imu: Imu | None = None
    dvl: Dvl | None = None
    depth: Depth | None = None
    position: Position | None = None
    shaft_speed: ShaftSpeed | None = None
    voltage: Voltage | None = None
