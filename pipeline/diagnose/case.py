"""What is to be diagnosed, and the runs cut into windows ready for it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.diagnose.kinematics.dead_reckoning import mount_of
from pipeline.diagnose.kinematics.instruments import InstrumentErrors
from pipeline.diagnose.linear.characteristic import characteristic_profiles, curve_errors
from pipeline.diagnose.linear.coordinates import coordinates
from pipeline.diagnose.linear.follow import follow
from pipeline.diagnose.linear.linear_model import Setting
from pipeline.diagnose.linear.predictions import Bench, voltage_channel
from pipeline.diagnose.linear.workers import Workers
from pipeline.effects.effect import Effect
from pipeline.effects.library import candidates, unstated
from pipeline.effects.specification import EffectSpec
from pipeline.errors import CannotComputeError
from pipeline.identify.channel_noise import ChannelNoise, channel_noise, was_measured
from pipeline.identify.run_nuisance import run_nuisance
from pipeline.identify.window_outputs import stack_windows
from pipeline.identify.windows import Window, cut
from pipeline.physics.parameters import read
from pipeline.records.run_table import RunTable
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import BoolArray, FloatArray
from pipeline.vehicle.schema import Vehicle
from pipeline.vehicle.sensor_schema import Sensors

WINDOW_S = 6.0
#: Without velocity and position, speed shows only in what it leads to.
WINDOW_WITHOUT_VELOCITY_S = 12.0
#: Pieces of a window over each of which the outside force is constant.
PIECES = 12
#: Outside force of a healthy vehicle whose runs are not known: a share of a thruster's largest
#: thrust, on top of the uncertainties that the vehicle file states.
FORCE_SHARE = 0.005


@dataclass(frozen=True)
class Case:
    """A diagnosis to be made; tables at a period of 0.02 s or less.

    `effects` are the candidates, the whole library that fits the vehicle otherwise. `errors` are
    what is known to be wrong with the instruments on `runs` and `holdout`: `packed` has it, and
    `as_stated` is then the vehicle of the file.
    """

    name: str
    vehicle: Vehicle
    packed: PackedVehicle
    runs: tuple[RunTable, ...]
    holdout: tuple[RunTable, ...] = ()
    healthy: tuple[RunTable, ...] = ()
    effects: Mapping[str, Effect] | None = None
    errors: InstrumentErrors | None = None
    as_stated: PackedVehicle | None = None

    @property
    def stated(self) -> PackedVehicle:
        """The vehicle as its file states it."""
        return self.packed if self.as_stated is None else self.as_stated

    @property
    def known_specs(self) -> tuple[EffectSpec, ...]:
        """Errors of the instruments as they are switched on."""
        return () if self.errors is None else self.errors.specs

    @property
    def candidates(self) -> Mapping[str, Effect]:
        """Effects to be tried, by id."""
        return candidates(self.packed.context) if self.effects is None else self.effects


def channels_of(vehicle: Vehicle, runs: Sequence[RunTable]) -> tuple[ChannelNoise, ...]:
    """Channels that at least one run has, with the noise that the vehicle file states."""
    sensors = vehicle.sensors if vehicle.sensors is not None else Sensors()
    found = channel_noise(sensors, runs)
    voltage = sensors.voltage
    if voltage is not None and any(was_measured(run, "voltage") for run in runs):
        found += (voltage_channel(voltage.nominal_v, voltage.noise_v, voltage.rate_hz),)
    return found


def windows_of(
    packed: PackedVehicle, runs: Sequence[RunTable], channels: Sequence[ChannelNoise]
) -> list[Window]:
    """Cut runs into windows."""
    has_velocity_or_position = any(
        was_measured(run, q) for run in runs for q in ("velocity", "position")
    )
    return cut(
        packed, runs, channels, WINDOW_S if has_velocity_or_position else WINDOW_WITHOUT_VELOCITY_S
    )


def setting_of(
    case: Case,
    runs: Sequence[RunTable],
    channels: Sequence[ChannelNoise],
    *,
    force_unit: FloatArray | None = None,
    threads: int = 2,
    vector: FloatArray | None = None,
    taken: Callable[[Sequence[Window]], BoolArray] | None = None,
) -> Setting:
    """Cut runs into windows and set up all unknowns.

    Parameters
    ----------
    case : Case
        The vehicle and its candidates.
    runs : sequence of RunTable
        The runs.
    channels : sequence of ChannelNoise
        What to use of them.
    force_unit : ndarray, shape (6,), optional
        Outside force of a healthy vehicle; `usual_force` otherwise. [N, N m]
    threads : int
        Simulations side by side.
    vector : ndarray, optional
        Parameter vector of the model that follows the motion; the nominal one otherwise.
    taken : callable, optional
        Says of each window whether it is taken; all are otherwise.

    Raises
    ------
    CannotComputeError
        When nothing of the runs can be used.
    """
    packed, model = case.packed, case.vehicle.model
    if model is None:
        raise CannotComputeError(f"{case.name} has no model: section to compare the runs with")
    windows = windows_of(packed, runs, channels)
    if taken is not None:
        windows = [one for one, is_in in zip(windows, taken(windows), strict=True) if is_in]
    workers = Workers(threads)
    windows, pulls = follow(packed, runs, windows, channels, vector, workers=workers)
    stack = stack_windows(packed, windows, channels)
    sensors = case.vehicle.sensors if case.vehicle.sensors is not None else Sensors()
    bench = Bench(
        stack,
        tuple(np.nan_to_num(run.values["command"]) for run in runs),
        tuple(float(np.median(np.diff(run.time_s))) for run in runs),
        mount_of(sensors).turn,
        None if sensors.voltage is None else sensors.voltage.nominal_v,
        sensors.dvl is not None and sensors.dvl.water_track,
        PIECES,
        tuple(pulls),
        workers,
    )
    every = coordinates(packed, {**case.candidates, **unstated(packed.context)}, model.uncertainty)
    curves = curve_errors(case.vehicle, model.uncertainty.thrust)
    setting = Setting(
        bench,
        run_nuisance(stack, len(runs)),
        every,
        usual_force(packed) if force_unit is None else force_unit,
        np.zeros((len(stack.owner), 0)),
        np.ones(len(stack.owner)),
        characteristic_profiles(packed, stack.windows, bench.whole, curves),
        np.zeros(len(every)),
        curves,
    )
    return replace(setting, extra=_voltage_offsets(setting, len(runs)))


def led_by(
    setting: Setting,
    packed: PackedVehicle,
    runs: Sequence[RunTable],
    channels: Sequence[ChannelNoise],
    vector: FloatArray,
) -> Setting:
    """Let the model at a parameter vector follow the measured motion."""
    bench, stack = setting.bench, setting.bench.stack
    windows, pulls = follow(
        packed, runs, stack.windows, channels, vector, bench.pulls, bench.workers
    )
    stack = replace(stack, windows=tuple(windows))
    return replace(setting, bench=replace(bench, stack=stack, pulls=tuple(pulls)))


def thinned(chosen: BoolArray, most: int) -> BoolArray:
    """Keep at most so many of the chosen windows, two and two side by side, evenly spread."""
    places = np.flatnonzero(chosen)
    found = np.zeros(chosen.size, bool)
    if places.size <= most:
        found[places] = True
        return found
    twos = places.size // 2
    first = 2 * np.unique(np.linspace(0, twos - 1, most // 2).astype(int))
    found[places[np.concatenate([first, first + 1])]] = True
    return found


def usual_force(packed: PackedVehicle) -> FloatArray:
    """Outside force and moment (6,) of a healthy vehicle: a share of one thruster's largest thrust.

    Moments have the rms lever of the thrusters. [N, N m]
    """
    count = len(packed.thruster_names)
    vector = packed.vector
    place = read(vector, "thruster_position")[:count]
    largest = max(float(packed.thrust_tables[:, :, 0].max()), 1e-3)
    arm = np.sqrt(np.mean(place**2, axis=0)) if count else np.zeros(3)
    lever = np.array([np.hypot(arm[1], arm[2]), np.hypot(arm[0], arm[2]), np.hypot(arm[0], arm[1])])
    lever = np.maximum(lever, 0.3 * max(float(lever.max()), 1e-2))
    return np.asarray(FORCE_SHARE * largest * np.concatenate([np.ones(3), lever]))


def _voltage_offsets(setting: Setting, run_count: int) -> FloatArray:
    """One offset a run of the measured voltage, (rows, runs); none where it is not measured."""
    stack = setting.bench.stack
    numbers = [k for k, rows in enumerate(stack.rows) if rows.channel.quantity == "voltage"]
    if not numbers:
        return np.zeros((len(stack.owner), 0))
    channel = stack.rows[numbers[0]].channel
    run_of = np.array([window.run for window in stack.windows])[setting.shared.window]
    own = stack.owner == numbers[0]
    size = channel.bias / channel.white
    return np.where(own[:, None] & (run_of[:, None] == np.arange(run_count)), size, 0.0)
