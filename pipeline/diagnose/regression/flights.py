"""The vehicle file flies what was asked: stand-ins for sound runs where there are none.

The commands of the asked runs are simulated and measured with the noise that the file states, with
an outside force as large as a healthy vehicle has beside its model: wash and gusts, and what
changes slowly. How large it is nobody states, so it differs from flight to flight. Some flights are
of the file as it is, from which noise and the errors of the method are learned; some are of
vehicles drawn from its stated uncertainties, which tell what a healthy vehicle may leave.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from pipeline.diagnose.coordinates import Coordinate, specs_at
from pipeline.effects.library import apply_effects
from pipeline.identify.channel_noise import ChannelNoise, channel_noise
from pipeline.records.run_table import RunTable
from pipeline.simulate.fly import usual_step_s
from pipeline.simulate.log_table import table_of_log
from pipeline.simulate.pack import PackedVehicle, mass_of
from pipeline.simulate.run import initial_state
from pipeline.simulate.run import run as simulate
from pipeline.simulate.sensors import measure
from pipeline.types import FloatArray
from pipeline.vehicle.sensor_schema import Depth, Dvl, Imu, Position, Sensor, Sensors

#: Outside force of a healthy vehicle, a share of a thruster's largest thrust, and its size over
#: that, one flight after the other.
_FORCE_SHARE, _FORCE_SIZES = 0.005, (0.5, 1.0, 2.0, 4.0, 1.0, 2.0)
#: Time constants of the outside force; half of the variance each. [s]
_FAST_S, _SLOW_S = 0.8, 10.0
FLIGHTS = len(_FORCE_SIZES)
#: Sensors of the vehicle file, by what they measure.
_SENSORS = {
    "dvl": "velocity",
    "depth": "depth",
    "position": "position",
    "shaft_speed": "shaft_speed",
    "voltage": "voltage",
}


def flown(
    packed: PackedVehicle,
    sensors: Sensors,
    runs: Sequence[RunTable],
    drawn: Sequence[tuple[Sequence[Coordinate], FloatArray]] = (),
) -> tuple[RunTable, ...]:
    """Fly the commands of runs, one after the other, as often as forces are tried.

    Parameters
    ----------
    packed : PackedVehicle
        The vehicle of the file.
    sensors : Sensors
        Those of the file; what no run measured is left out.
    runs : sequence of RunTable
        The runs that are asked.
    drawn : sequence of (directions, departures), optional
        What each flight's vehicle differs by; the file as it is otherwise.
    """
    have = set[str]().union(*(run.values for run in runs))
    own = _as_measured(sensors, runs, have)
    found = []
    for k in range(FLIGHTS):
        differs = drawn[k] if drawn else ((), np.zeros(0))
        table = _flight(packed, own, runs[k % len(runs)], k, differs)
        values = {name: one for name, one in table.values.items() if name in have}
        found.append(replace(table, values=values))
    return tuple(found)


def _as_measured(sensors: Sensors, runs: Sequence[RunTable], have: set[str]) -> Sensors:
    """Take the stated sensors of what was measured; one that is not stated reads as the runs do."""
    every: dict[str, Sensor | None] = {}
    noise = {one.quantity: one for one in channel_noise(sensors, runs)}
    rates_hz = {
        quantity: 1.0 / min(run.pause_s(quantity) for run in runs if quantity in run.values)
        for quantity in have
    }
    for name, quantity in _SENSORS.items():
        every[name] = getattr(sensors, name) if quantity in have else None
    if "velocity" in have and every["dvl"] is None:
        every["dvl"] = Dvl(rate_hz=rates_hz["velocity"], noise_mps=noise["velocity"].white)
    if "depth" in have and every["depth"] is None:
        every["depth"] = Depth(rate_hz=rates_hz["depth"], noise_m=noise["depth"].white)
    if "position" in have and every["position"] is None:
        every["position"] = Position(rate_hz=rates_hz["position"], noise_m=noise["position"].white)
    every["imu"] = sensors.imu
    if sensors.imu is None:
        turning = "angular_velocity" if "angular_velocity" in have else "attitude"
        every["imu"] = Imu(
            rate_hz=rates_hz.get(turning, 10.0),
            rate_noise_radps=_white(noise, "angular_velocity"),
            force_noise_mps2=_white(noise, "specific_force"),
            attitude_noise_rad=_white(noise, "attitude"),
        )
    return sensors.model_copy(update=every)


def _white(noise: Mapping[str, ChannelNoise], quantity: str) -> float:
    return noise[quantity].white if quantity in noise else 0.0


def _flight(
    packed: PackedVehicle,
    sensors: Sensors,
    run: RunTable,
    number: int,
    drawn: tuple[Sequence[Coordinate], FloatArray],
) -> RunTable:
    directions, departures = drawn
    # the noise of a drawn vehicle is another one than that of the file
    random = np.random.default_rng([number, int(bool(len(directions)))])
    vector = apply_effects(packed.vector, specs_at(directions, departures), packed.context)
    codes = np.nan_to_num(np.array(run.values["command"], float))
    steps = max(int(np.ceil(run.period_s / min(usual_step_s(packed, vector), run.period_s))), 1)
    step_s = run.period_s / steps
    force = _outside(len(codes) * steps, step_s, random)
    trajectory = simulate(
        packed,
        np.repeat(codes, steps, axis=0),
        dt_s=step_s,
        vector=vector,
        start=_start(run),
        external=_FORCE_SIZES[number] * usual_force(packed) * force,
    )
    log = measure(trajectory, packed, sensors, vector=vector, seed=int(random.integers(2**31)))
    return table_of_log(log, sensors, name=f"flight {number + 1}", period_s=run.period_s)


def _start(run: RunTable) -> FloatArray:
    """Begin at rest, where and as the run begins."""
    state = initial_state()
    for quantity, own in (("attitude", slice(3, 7)), ("position", slice(0, 3))):
        if quantity in run.values:
            state[own] = run.values[quantity][int(np.argmax(run.trusted(quantity)))]
    if "position" not in run.values and "depth" in run.values:
        state[2] = run.values["depth"][int(np.argmax(run.trusted("depth"))), 0]
    return state


def usual_force(packed: PackedVehicle) -> FloatArray:
    """Outside force and moment (6,) of a healthy vehicle: a share of one thruster's largest thrust.

    It acts as far from the centre as the vehicle's mass does: moments have its radii of gyration as
    levers, with the water that moves along. [N, N m]
    """
    largest = max(float(packed.thrust_tables[:, :, 0].max()), 1e-3)
    mass = np.diag(mass_of(packed.vector))
    lever_m = np.sqrt(mass[3:] / np.mean(mass[:3]))
    return np.asarray(_FORCE_SHARE * largest * np.concatenate([np.ones(3), lever_m]))


def _outside(count: int, step_s: float, random: np.random.Generator) -> FloatArray:
    """Two first-order Gauss-Markov processes (m, 6) that add up to unit variance."""
    from scipy.signal import lfilter

    found = np.zeros((count, 6))
    for time_s in (_FAST_S, _SLOW_S):
        kept = float(np.exp(-step_s / time_s))
        noise = np.sqrt(1.0 - kept**2) * random.standard_normal((count, 6))
        noise[0] /= np.sqrt(1.0 - kept**2)
        found += np.sqrt(0.5) * lfilter([1.0], [1.0, -kept], noise, axis=0)
    return found
