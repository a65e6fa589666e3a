"""How large a fault is: the gap that it opens, and the size at which it opens the wanted one.

The commands of a flown run are given to two simulations in windows of ten seconds that start from
the true motion. With and without the fault gives its trace; a healthy vehicle and the stated one,
with the noise of the instruments, give the floor. Per channel the gap ratio is

    sqrt(floor^2 + trace^2) / floor          (root mean squares over all windows)

and that of a case is the largest over the channels.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from pipeline.blind.flying import (
    CaseWorld,
    Fault,
    FlownCase,
    Patient,
    VehicleLost,
    children,
    fault_of,
    fly_all,
    fly_one,
    stage_of,
)
from pipeline.blind.subject import BlindSubject
from pipeline.blind.truth.craft import Craft
from pipeline.blind.truth.flight import TruthFlight, fly_craft
from pipeline.blind.truth.kernel_flight import CONTROL_S, SAMPLE, SAMPLES, Belief
from pipeline.blind.truth.manoeuvres import SETS
from pipeline.blind.truth.sensors import Weather, drawn, dvl_velocity
from pipeline.errors import CannotComputeError
from pipeline.types import FloatArray
from pipeline.vehicle.sensor_schema import Sensors

#: Flown by the search, which takes two runs and cuts them short. [s]
SEARCH_S = 80.0
#: Gap that a fault must open at some size, and how many are drawn at most: on another axis, at
#: another thruster, the other way round.
_SHOWS, _DRAWS = 1.5, 4
#: Steps of the search, and the logarithm of the ratio at which it is content.
_STEPS, _CLOSE = 6, 0.12
CHANNELS = ("u", "v", "w", "p", "q", "r", "phi", "theta", "psi", "z", "x", "y")
#: Commands in a window.
WINDOW = 100


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


def readings_of(flight: TruthFlight, craft: Craft, sensors: Sensors) -> FloatArray:
    """Return what the channels show of a motion without noise (k, 12), five times a second."""
    rows = slice(0, None, 10)
    time_s = flight.time_s[rows]
    out = np.zeros((len(time_s), 12))
    if sensors.dvl is not None:
        shown = np.maximum(time_s - craft.dvl.delay_s, 0.0)
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


def misses(  # noqa: PLR0917 - a flight of one craft, by another
    flown: Craft,
    model: Craft,
    belief: Belief,
    flight: TruthFlight,
    sensors: Sensors,
    outside: FloatArray | None = None,
) -> list[FloatArray]:
    """Difference of what a flown craft shows and what a model of it does, by window (k, 12).

    `belief` is that of the autopilot, `outside` are forces on the model.
    """
    # the delay of a DVL needs what was before the window: read from the whole flight
    whole = readings_of(flight, flown, sensors)
    out = []
    for k, window in enumerate(windows_of(model, belief, flight, outside)):
        seen = readings_of(window, model, sensors)
        begin = k * WINDOW * SAMPLES // 10
        out.append(difference(whole[begin : begin + len(seen)], seen))
    return out


def floors_of(
    stated: Craft,
    healthy: Sequence[tuple[Craft, TruthFlight]],
    belief: Belief,
    sensors: Sensors,
) -> FloatArray:
    """Floors by channel (12,) from flights of healthy vehicles, predicted with the stated one.

    Not a number where the channel is not measured.
    """
    squares = [
        off**2
        for craft, flight in healthy
        for off in misses(craft, stated, belief, flight, sensors)
    ]
    if not squares:
        raise CannotComputeError("no healthy flight is long enough for a window of ten seconds")
    return np.asarray(np.sqrt(np.concatenate(squares).mean(axis=0) + sensor_floor(sensors) ** 2))


def ratios(trace: FloatArray, floors: FloatArray) -> dict[str, float]:
    """Gap ratio by channel, of those that are measured."""
    size = np.sqrt((trace**2).mean(axis=(0, 1)))
    return {
        name: float(np.hypot(floors[k], size[k]) / floors[k])
        for k, name in enumerate(CHANNELS)
        if np.isfinite(floors[k])
    }


def gap_ratio(by_channel: Mapping[str, float]) -> float:
    """Return the gap ratio of the case: that of its worst channel."""
    return max(by_channel.values())


def fault_that_shows(
    what: str,
    stage: CaseWorld,
    well: Craft,
    *,
    wanted: float,
    floors: FloatArray,
    kinds: Sequence[str],
    durations_s: tuple[float, ...],
    seeds: np.random.SeedSequence,
    rng: np.random.Generator,
) -> tuple[Fault, float]:
    """Draw a fault and its size, anew where on these runs it cannot be seen at any size.

    Some cannot however they are drawn; then the one that shows most is returned. `what` is an
    effect of the library, or trouble; the others are as of `size_for`.
    """
    drawn_so_far: list[tuple[float, Fault, float]] = []
    for _ in range(_DRAWS):
        fault = fault_of(what, stage, durations_s, rng)
        size, ratio = size_for(
            stage, well, fault, wanted=wanted, floors=floors, kinds=kinds, seeds=seeds, rng=rng
        )
        drawn_so_far.append((ratio, fault, size))
        if ratio >= _SHOWS:
            break
    _, fault, size = max(drawn_so_far, key=lambda one: one[0])
    return fault, size


def size_for(
    stage: CaseWorld,
    well: Craft,
    fault: Fault,
    *,
    wanted: float,
    floors: FloatArray,
    kinds: Sequence[str],
    seeds: np.random.SeedSequence,
    rng: np.random.Generator,
) -> tuple[float, float]:
    """Return the size whose gap ratio comes nearest to the wanted one, and that ratio.

    `well` is the vehicle without the fault, `wanted` the gap over its healthy floor on these
    manoeuvres; of the first four of the case's `kinds` of runs `rng` chooses two that are flown.
    """
    picked = [kinds[k] for k in sorted(rng.choice(4, size=2, replace=False))]
    target = float(np.sqrt(max(wanted, 1.01) ** 2 - 1.0))
    size, least = min(0.3, fault.most), 0.0
    best: tuple[float, float, float] | None = None
    for _step in range(_STEPS):
        try:
            patient = Patient(well, (fault,), (size,))
            flown = fly_all(stage, patient, picked, SEARCH_S, seeds)
            ratio = gap_ratio(ratios(trace_of_runs(stage, well, flown), floors))
        except (VehicleLost, CannotComputeError):
            fault = replace(fault, most=0.8 * size)
            size = 0.5 * (size + least) if least else 0.3 * size
            continue
        share = float(np.sqrt(max(ratio**2 - 1.0, 1e-6)))
        miss = abs(float(np.log(share / target)))
        if best is None or miss < best[1]:
            best = (size, miss, ratio)
        if share < target:
            least = max(least, size)
        if miss < _CLOSE or (share < target and size >= fault.most):
            break
        size = float(min(size * np.clip((target / share) ** 0.9, 0.05, 8.0), fault.most))
    return (size, 1.0) if best is None else (best[0], best[2])


def trace_of_runs(stage: CaseWorld, well: Craft, flown: Sequence[FlownCase]) -> FloatArray:
    """Trace of the faults over runs, each with the craft of that run (windows, k, 12).

    The healthy side keeps the background, which is in body axes; troubles push in NED.
    """
    parts: list[FloatArray] = []
    for one in flown:
        quiet = one.outside.copy()
        quiet[:, :3] = 0.0
        parts += misses(one.craft, well, stage.belief, one.flight, stage.sensors, quiet)
    return np.stack(parts)


@lru_cache(maxsize=64)
def healthy_floors(subject: BlindSubject, manoeuvres: str, missing: tuple[str, ...]) -> FloatArray:
    """Healthy floor of a vehicle on a set of manoeuvres, from six drawn vehicles."""
    stage = stage_of(subject, missing, Weather())
    model = subject.vehicle.model
    if model is None:
        raise CannotComputeError(f"{subject.name} has no model: section")
    flown: list[tuple[Craft, TruthFlight]] = []
    kinds = SETS[manoeuvres][0]
    for k in range(6):
        seeds = np.random.SeedSequence([7919, k])
        craft = drawn(stage.stated, model.uncertainty, np.random.default_rng(seeds))
        seed = children(seeds, 1)[0]
        try:
            one = fly_one(stage, Patient(craft), kinds[k % 4], run=0, duration_s=90.0, seed=seed)
        except VehicleLost:
            continue
        flown.append((craft, one.flight))
    return floors_of(stage.stated, flown, stage.belief, stage.sensors)
