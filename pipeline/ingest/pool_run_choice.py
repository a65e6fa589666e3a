"""What channels say of each other and of the vehicle file, and which of several is taken by it.

The likeliest by names stands first. One that never changes, or stands still for long, gives way to
one that does not; so does one that the other channels contradict where another agrees with them.
What was decided so is told with its figures.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from pipeline.errors import CannotComputeError, Place, Problem
from pipeline.ingest.log_source import TABLE
from pipeline.ingest.pool_run_defaults import NOT_MEASURED
from pipeline.ingest.pool_run_health import is_noise_alone
from pipeline.ingest.pool_run_meant import meant_otherwise, over_the_earth, readings_of
from pipeline.ingest.pool_run_pairs import compared, late, pairs_of
from pipeline.ingest.pool_run_plan import TopicFound
from pipeline.ingest.pool_run_resample import on_one_base
from pipeline.ingest.pool_run_shafts import shafts_against_commands, shafts_too_slow, tips_too_fast
from pipeline.ingest.pool_run_sizes import (
    depth_against_pressure,
    depth_too_fast,
    doubtful_depths,
    down_apart,
    impossible_readings,
    sizes,
    supply,
)
from pipeline.ingest.pool_run_thrusters import moments_without_turning, thrusters_against_rates
from pipeline.ingest.quantities import PER_THRUSTER
from pipeline.records.pool_run import TopicRead
from pipeline.records.run_arrays import PoolRun, RunChannel
from pipeline.records.run_table import RunTable, stretches
from pipeline.vehicle.schema import Vehicle

#: A source that stands still for a larger share of the run is dead.
_MOST_STILL = 0.3
_FEW_READINGS = 10
#: What is not taken at all, as if its message did not have the field.
_NOTHING = "has no valid reading"
_NOISE, _OF_IMU = "is noise alone", ("attitude", "angular_velocity", "specific_force")
#: The order in which sources are compared: each with what was decided before it.
_ORDER = ("specific_force", "attitude", "angular_velocity", "depth", "position", "velocity")


#: What may be taken for a quantity: a channel by its name, or one for each of several thrusters.
ChannelSource = Mapping[str, RunChannel]


def consistency_problems(run: PoolRun, vehicle: Vehicle) -> Iterator[Problem]:
    """Compare channels with each other and with the vehicle file.

    Warns of units off by a factor, impossible readings, two opinions of where down is, shaft speeds
    that contradict commands, thrusters that seem to be swapped or reversed. It changes nothing.
    """
    yield from sizes(run)
    yield from tips_too_fast(run, vehicle)
    yield from impossible_readings(run)
    yield from supply(run, vehicle)
    yield from doubtful_depths(run, vehicle)
    try:  # what follows lays the readings on a common time base
        table = on_one_base(run)
        yield from contradictions(run, vehicle, table)
        yield from shafts_against_commands(run, table)
        yield from shafts_too_slow(run, table, vehicle)
        yield from moments_without_turning(run, table, vehicle)
        yield from thrusters_against_rates(run, table, vehicle)
    except CannotComputeError as error:
        yield run.place.warning(
            f"channels were not compared with each other: {error}.",
            remedy="Check the clock of the recorder; cut a log of many days into runs.",
        )


def contradictions(
    run: PoolRun, vehicle: Vehicle, table: RunTable, others: Sequence[RunChannel] = ()
) -> Iterator[Problem]:
    """Say where attitude, rates, specific force, velocity, depth and position contradict another.

    `others` are velocities beside that of the run. Raises `CannotComputeError` where the times of
    the run make no table.
    """
    yield from depth_too_fast(run, table)
    yield from down_apart(run, table)
    readings = readings_of(run, table)
    pairs = list(pairs_of(run, table, vehicle.water.gravity_mps2, readings))
    told = [problem for pair in pairs for problem in compared(run, pair)]
    yield from told
    if readings:
        said = [over_the_earth(run, table, readings, one) for one in others]
        if not any(said) and not any("{" in one.what for one in told):  # what would agree
            said = [meant_otherwise(run, table, readings, vehicle)]
        channel = run.channels.get("velocity") or run.channels["velocity_earth"]
        yield from (
            run.place.warning(
                f"the velocity ({channel.topic}) {one}",
                remedy="Check its axes, sign and unit under pool: channels in vehicle.yaml.",
            )
            for one in said
            if one
        )
    for pair in pairs:
        yield from late(run, pair)


def _first(source: ChannelSource) -> tuple[str, RunChannel]:
    return next(iter(source.items()))


def _is_taken(source: ChannelSource, channels: Mapping[str, RunChannel]) -> bool:
    name, channel = _first(source)
    return channels.get(name) is channel


def choose_sources(
    groups: Sequence[Sequence[ChannelSource]], run: PoolRun, vehicle: Vehicle, told: list[Problem]
) -> dict[str, RunChannel]:
    """Choose one source of each group, the likeliest first, and say what was chosen and why.

    `run` has the channels that are settled. Returns the channels that were taken, by name.
    """
    alive = [list(some) for group in groups if (some := _alive(group, run.place, told))]
    taken = {name: one for group in alive for name, one in group[0].items()}
    several = [
        group
        for quantity in _ORDER
        for group in alive
        if len(group) > 1 and _first(group[0])[1].quantity.removesuffix("_earth") == quantity
    ]
    for group in several:
        others = {name: one for name, one in taken.items() if name not in group[0]}
        best, why = _best(group, replace(run, channels={**run.channels, **others}), vehicle)
        if best is not group[0]:
            taken = {**others, **best}
            what = f"{_first(best)[0]} is taken from {_called(best)}, not {_called(group[0])}"
            told.append(run.place.warning(f"{what}: {why.rstrip('.')}."))
    for sources in groups:
        told += _also_fitting(sources, taken, run.place)
    return taken


def _called(one: ChannelSource) -> str:
    """Name a source by its topic; a column of a table by its name."""
    read = _first(one)[1].read
    return f'"{", ".join(read.fields)}"' if read.topic == TABLE else read.topic


def _alive(
    group: Sequence[ChannelSource], place: Place, told: list[Problem]
) -> list[ChannelSource]:
    """Leave the dead out, as long as something lives, and what has no reading at all."""
    died = [(one, _death(_first(one)[1])) for one in group]
    readable = [(one, why) for one, why in died if why != _NOTHING]
    alive = [one for one, why in readable if not why]
    if not alive:
        return [one for one, why in readable if why == _NOISE] or [one for one, _ in readable]
    first, why = readable[0]
    if why:
        (name, now), (_, before) = _first(alive[0]), _first(first)
        what = f"{name} is taken from {now.topic}: that of {before.topic} {why}."
        told.append(place.warning(what, remedy="Check the sensor."))
    return alive


def _death(channel: RunChannel) -> str:
    """Say in what way a source is dead; nothing for one that lives."""
    values = channel.values[channel.usable() & np.isfinite(channel.values).all(axis=1)]
    if not len(values):
        return "never is a number" if channel.quantity in PER_THRUSTER else _NOTHING
    if len(values) < _FEW_READINGS or channel.holds:
        return "" if not channel.holds or np.ptp(values, axis=0).any() else "never changes"
    still = (np.diff(values, axis=0) == 0.0).all(axis=1)
    if still.all():
        return "never changes"
    if channel.quantity in _OF_IMU and is_noise_alone(values, channel.period_s):
        return _NOISE
    longest = max((end - begin for begin, end in stretches(still)), default=0)
    share = longest / len(still)
    return f"stands still for {100 * share:.0f} % of the run" if share > _MOST_STILL else ""


def _best(
    group: Sequence[ChannelSource], run: PoolRun, vehicle: Vehicle
) -> tuple[ChannelSource, str]:
    """Return the first source with the fewest contradictions, and what the first is blamed for."""
    blamed = []
    channels = [_first(one)[1] for one in group]
    try:
        bodies = [one for one in channels if one.quantity == "velocity"]
        by_pressure = [one for one in channels if one.read.quantity == "pressure"]
        for source, channel in zip(group, channels, strict=True):
            with_it = replace(run, channels={**run.channels, **source})
            others = [other for other in bodies if other is not channel]
            found = [
                *doubtful_depths(with_it, vehicle),
                *contradictions(with_it, vehicle, on_one_base(with_it), others),
            ]
            own = depth_against_pressure(channel, by_pressure)
            blamed.append([*filter(None, [own]), *(problem.what for problem in found)])
    except CannotComputeError:
        return group[0], ""
    fewest = min(range(len(group)), key=lambda index: len(blamed[index]))
    return group[fewest], "; ".join(one.rstrip(".") for one in blamed[0])


def _also_fitting(
    group: Sequence[ChannelSource], taken: Mapping[str, RunChannel], place: Place
) -> Iterator[Problem]:
    chosen = next((one for one in group if _is_taken(one, taken)), None)
    others = [_called(one) for one in group if one is not chosen]
    if chosen is None or not others:
        return  # the channel itself says where it is from
    read = _first(chosen)[1].read
    yield place.note(
        f"{read.quantity} is taken from {read.topic} ({', '.join(read.fields)}, {read.mapped_by}). "
        f"Also fitting: {', '.join(dict.fromkeys(others))}."
    )


def topics_read(
    topics: Sequence[TopicFound],
    channels: Mapping[str, RunChannel],
    groups: Sequence[Sequence[ChannelSource]],
    vehicle: Vehicle,
) -> tuple[TopicRead, ...]:
    """Return all topics by name: what was taken from them, and else what else would have fitted."""
    used: dict[str, list[str]] = {}
    for name, channel in channels.items():
        used.setdefault(channel.topic, []).append(name)
    instead: dict[str, list[str]] = {}
    for group in groups:
        taken = next((_first(one)[1].topic for one in group if _is_taken(one, channels)), None)
        for one in (_first(source)[1] for source in group):
            if taken is None or one.topic != taken:
                said = f"{one.quantity} has no valid reading"
                if taken is not None:
                    said = f"{one.quantity} is taken from {taken}"
                instead.setdefault(one.topic, []).append(said)
    return tuple(
        TopicRead(
            topic=topic.name,
            message_type=topic.message_type,
            encoding=topic.encoding,
            messages=topic.messages,
            used_for=tuple(used.get(topic.name, ())),
            why_not="" if topic.name in used else _why_not(topic, instead, vehicle),
        )
        for topic in sorted(topics, key=lambda topic: topic.name)
    )


def _why_not(topic: TopicFound, instead: Mapping[str, list[str]], vehicle: Vehicle) -> str:
    known = (
        (topic.why_not, bool(topic.why_not)),
        ("it has no messages", not topic.messages),
        (", ".join(dict.fromkeys(instead.get(topic.name, ()))), topic.name in instead),
        ("the vehicle file says so (ignore_topics)", topic.name in vehicle.pool.ignore_topics),
        ("the vehicle file does not state it, and wants no defaults", not vehicle.pool.defaults),
        (
            "by its name it was wanted, simulated or put together from others, not measured",
            re.search(NOT_MEASURED, topic.name, re.IGNORECASE) is not None,
        ),
    )
    nothing = "no field of it is known to hold a quantity that is still wanted"
    return next((text for text, applies in known if applies), nothing)
