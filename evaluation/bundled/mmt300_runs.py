"""Pool runs of `mmt300`: simulated, with a truth that the vehicle file does not state.

The hull is not quite the one that ``vehicle.yaml`` states (`TRUTH`); the thrusters push as the
printed Table 2 says, linear between its speeds, not as the bench files give it. What the sensors
read is rounded to their counts, which also keeps the files small.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from evaluation.bundled.mmt300_truth import (
    CODE_MAX,
    DENSITY_KGPM3,
    DIAMETER_M,
    KT,
    TABLE2,
)
from pipeline.effects.library import apply_effects, parse_effect
from pipeline.records.fits import StaticCharacteristic
from pipeline.simulate.context import BenchModel
from pipeline.simulate.fly import fly
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.simulate.sensors import Channel, Log, measure
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle
from pipeline.vehicle.sensor_schema import Sensors

#: What the true vehicle is beyond the vehicle file, as `rig2sea simulate --effect` takes it.
TRUTH = (
    "added_mass:surge=1.35,sway=1.12,heave=1.12,pitch=1.2,yaw=1.2",
    "quadratic_damping:surge=1.12,sway=0.88,heave=0.88,pitch=1.15,yaw=1.15",
    "residual_buoyancy:force_n=-1.4",
)
#: What is wrong with the vehicle in the last run, on top.
DEGRADED = "thruster_degraded:thrust_fraction=0.7@upper"
_DAY_S = 86_400
_FIRST_DAY_S = 1_715_644_800  # 14 May 2024, 00:00 UTC
_SPEEDS_MPS = np.arange(26) / 10.0
#: Rates at which the runs were recorded, below those of the vehicle file. [Hz]
_RATES_HZ = {
    "imu": 25.0,
    "dvl": 5.0,
    "depth": 5.0,
    "position": 0.5,
    "shaft_speed": 5.0,
    "voltage": 1.0,
}
_COMMAND_HZ = 10.0
#: What one count of a sensor is worth: powers of two, so that a reading is a short number.
_COUNTS: Mapping[str, FloatArray] = {
    "command": np.array([1.0]),
    "imu": 2.0 ** -np.array([13, 13, 13, 9, 9, 9, 14, 14, 14, 14]),  # rad/s, m/s2, quaternion
    "dvl": 2.0 ** -np.array([9]),  # m/s
    "depth": 2.0 ** -np.array([8]),  # m
    "position": 2.0 ** -np.array([4]),  # m
    "shaft_speed": np.array([1.0]),  # rpm
    "voltage": 2.0 ** -np.array([6]),  # V
}


@dataclass(frozen=True)
class BundledRun:
    """One run: when, what was flown, and what was wrong with the vehicle."""

    name: str
    day: int
    clock: tuple[int, int]
    manoeuvre: str
    duration_s: float
    amplitude: float = 1.0
    seed: int = 0
    more: tuple[str, ...] = ()

    @property
    def start_time_ns(self) -> int:
        """Time zero of the run. [ns since 1970]."""
        hour, minute = self.clock
        return (_FIRST_DAY_S + self.day * _DAY_S + hour * 3600 + minute * 60) * 1_000_000_000


RUNS = (
    BundledRun("2024-05-14-zig-zag", 0, (9, 12), "zig_zag", 100.0, seed=11),
    BundledRun("2024-05-14-surge-steps", 0, (9, 31), "surge_steps", 90.0, seed=12),
    BundledRun("2024-05-14-heave-steps", 0, (9, 50), "heave_steps", 90.0, seed=13),
    BundledRun("2024-05-15-pitch-steps", 1, (10, 15), "pitch_steps", 90.0, seed=14),
    BundledRun("2024-05-15-straight", 1, (10, 40), "straight", 60.0, seed=15),
    BundledRun("2024-05-15-zig-zag", 1, (11, 5), "zig_zag", 100.0, seed=16, more=(DEGRADED,)),
)


def table2_characteristic() -> StaticCharacteristic:
    """Return T(N, V) of the printed Table 2, linear between its speeds, level beyond the last one.

    The shaft turns as Table 1 says for that thrust and speed.
    """
    printed = np.array([TABLE2[speed] for speed in sorted(TABLE2)])
    rows = np.stack([np.interp(_SPEEDS_MPS, sorted(TABLE2), column) for column in printed.T])
    code = np.arange(1, CODE_MAX + 1, dtype=float)
    constant, linear, quadratic = (row[:, None] for row in rows)
    thrust_n = np.maximum(constant + linear * code + quadratic * code**2, 0.0)
    inflow = (_SPEEDS_MPS / DIAMETER_M)[:, None]
    load = KT[2] * inflow**2 - thrust_n / (DENSITY_KGPM3 * DIAMETER_M**4)
    rps = (-KT[1] * inflow + np.sqrt((KT[1] * inflow) ** 2 - 4.0 * KT[0] * load)) / (2.0 * KT[0])
    zero = _rows(np.zeros_like(thrust_n))
    return StaticCharacteristic(
        speed_mps=tuple(_SPEEDS_MPS.tolist()),
        code=tuple(code.tolist()),
        thrust_n=_rows(thrust_n),
        thrust_std_n=zero,
        shaft_speed_rpm=_rows(60.0 * rps),
        torque_nm=zero,
        advance_ratio=zero,
        status=tuple(
            tuple("live" if thrust > 0 else "dead" for thrust in row) for row in thrust_n.tolist()
        ),
        table2=(),
        checks=(),
        explanations=(),
    )


def _rows(matrix: FloatArray) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(row) for row in matrix.tolist())


def true_vehicle(vehicle: Vehicle) -> PackedVehicle:
    """Return the vehicle as its file states it, with the thrusters of the truth."""
    return pack_vehicle(vehicle, BenchModel(table2_characteristic()))


def bundled_log(run: BundledRun, vehicle: Vehicle, packed: PackedVehicle) -> Log:
    """Fly a run and return what its sensors read, in whole counts.

    Parameters
    ----------
    run : BundledRun
        One of `RUNS`.
    vehicle : Vehicle
        ``raw/mmt300/vehicle.yaml``.
    packed : PackedVehicle
        From `true_vehicle`.

    Returns
    -------
    dict of Channel
        Readings at the rates of the recorder.
    """
    specs = tuple(parse_effect(text, packed.thruster_names) for text in (*TRUTH, *run.more))
    vector = apply_effects(packed.vector, specs, packed.context)
    plan = MANOEUVRES[run.manoeuvre].plan(packed, run.amplitude, run.duration_s)
    trajectory = fly(packed, plan, vector=vector)
    log = measure(trajectory, packed, _recorded(vehicle), vector=vector, seed=run.seed)
    return {name: _counted(channel, _COUNTS[name]) for name, channel in log.items()}


def _recorded(vehicle: Vehicle) -> Sensors:
    """Sensors of the vehicle at the rates of the recorder."""
    stated = vehicle.sensors or Sensors()
    slower = {
        name: getattr(stated, name).model_copy(update={"rate_hz": rate})
        for name, rate in _RATES_HZ.items()
        if getattr(stated, name) is not None
    }
    return stated.model_copy(update={"command_rate_hz": _COMMAND_HZ, **slower})


def _counted(channel: Channel, count: FloatArray) -> Channel:
    """Round readings to whole counts, without negative zeros, and times to microseconds."""
    return replace(
        channel,
        values=np.rint(channel.values / count) * count + 0.0,
        valid_s=np.round(channel.valid_s, 6),
        logged_s=np.round(channel.logged_s, 6),
    )
