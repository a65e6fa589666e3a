"""From what was taken out of a topic to a channel: time, delay, units, marks."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import astuple, dataclass, fields, replace

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.ingest.message_fields import impossible, is_body
from pipeline.ingest.pool_run_clocks import Timing, choose_time, share_clocks
from pipeline.ingest.pool_run_convert import Converted, WaterOfRun
from pipeline.ingest.pool_run_extract import TopicData
from pipeline.ingest.pool_run_health import (
    Rhythm,
    command_marks,
    rhythm_of,
    time_marks,
    value_marks,
)
from pipeline.ingest.pool_run_plan import Plan, TopicFound
from pipeline.ingest.quantities import QUANTITIES
from pipeline.records.pool_run import ChannelRead
from pipeline.records.run_arrays import WITHOUT_TIME, RunChannel
from pipeline.types import BoolArray, FloatArray
from pipeline.vehicle.schema import Vehicle

_LOG_METADATA = "rig2sea.log"


def timings_of(
    plans: Sequence[Plan],
    data: Mapping[str, TopicData],
    vehicle: Vehicle,
    place: Place,
    problems: list[Problem],
) -> dict[str, Timing]:
    """Choose the time of each topic."""
    stated = {plan.topic: plan.clock for plan in reversed(plans) if plan.clock}
    timings: dict[str, Timing] = {}
    for plan in plans:
        if plan.topic not in timings:
            taken, delay = data[plan.topic], _known_delay(plan, vehicle)
            wanted = stated.get(plan.topic)
            timings[plan.topic] = choose_time(taken.log_time_ns, taken.stamp_ns, wanted, delay)
    timings = share_clocks(timings, {topic: data[topic].stamp_ns for topic in timings})
    for topic, timing in timings.items():
        problems += [place.warning(f"{topic}: {text}") for text in timing.warnings]
        clock = timing.clock
        if clock.used != "log" and clock.offset_s:
            what = (
                f"{topic}: {clock.why}: {clock.offset_s:+.3f} s, drift {clock.drift_ppm:+.1f} ppm, "
                f"jitter of the log {1e3 * (clock.jitter_s or 0.0):.2f} ms."
            )
            problems.append(place.note(what))
    return timings


def _known_delay(plan: Plan, vehicle: Vehicle) -> float:
    """Return the age of a reading when it is logged, by the vehicle file, in seconds."""
    sensor = getattr(vehicle.sensors, QUANTITIES[plan.quantity].sensor, None)
    return float(sensor.delay_s) if sensor is not None else 0.0


def _delay(plan: Plan, timing: Timing, vehicle: Vehicle) -> tuple[float, str]:
    """Return what is still to be taken off the chosen time, and why."""
    if plan.stated.delay_s is not None:
        return plan.stated.delay_s, f"delay {plan.stated.delay_s:g} s as pool: channels states"
    known = _known_delay(plan, vehicle)
    if known and timing.clock.used == "log":
        return known, f"delay {known:g} s of the sensor, counted from the time of the log"
    if known and timing.clock.offset_s:
        return known, f"delay {known:g} s of the sensor: its clock was laid onto the log"
    if known:
        return 0.0, f"the stamp is taken as the time of measurement (delay {known:g} s is in it)"
    return 0.0, ""


@dataclass(frozen=True)
class Found:
    """All that is known of one channel."""

    plan: Plan
    converted: Converted
    taken: TopicData
    timing: Timing
    topic: TopicFound
    invalid: Sequence[BoolArray] = ()
    """Readings (k,) that each flag of the plan calls invalid."""


def parts_of(found: Found, name: str) -> list[tuple[str, Found]]:
    """Part a channel whose messages, or topic, speak of some thrusters: a channel for each."""
    said_of = found.converted.said_of
    if said_of is None and found.plan.is_part:
        said_of = np.ones(found.converted.values.shape, np.bool_)
    if said_of is None:
        return [(name, found)]
    parts = []
    for number, column in enumerate(found.converted.columns):
        rows = said_of[:, number]
        one, taken, timing = found.converted, found.taken, found.timing
        part = replace(
            found,
            converted=replace(
                one, columns=(column,), values=one.values[rows][:, [number]], said_of=None
            ),
            taken=replace(taken, log_time_ns=taken.log_time_ns[rows], broken=taken.broken[rows]),
            timing=replace(
                timing,
                time_ns=timing.time_ns[rows],
                marks={mark: there[rows] for mark, there in timing.marks.items()},
            ),
            invalid=[there[rows] for there in found.invalid],
        )
        parts.append((f"{name}.{column.split('.', 1)[1]}", part))
    return parts


def channel_of(found: Found, vehicle: Vehicle) -> RunChannel:
    """Make a channel: mark its readings, settle its delay."""
    plan, converted, taken, timing = found.plan, found.converted, found.taken, found.timing
    time_ns = timing.time_ns
    none = np.zeros(time_ns.size, np.bool_)
    # a wild stamp says nothing of the others
    timely = ~np.any([timing.marks.get(name, none) for name in WITHOUT_TIME], axis=0)
    rows: BoolArray | slice = slice(None) if timely.all() else timely  # a slice copies nothing
    rhythm = rhythm_of(time_ns[rows])
    holds = plan.quantity == "thruster_command"
    marks: dict[str, BoolArray] = dict(timing.marks)
    if taken.broken.any():
        marks["broken"] = taken.broken
    for name, mark in time_marks(time_ns[rows], converted.values[rows], rhythm).items():
        marks[name] = none.copy()
        marks[name][rows] = mark
    marks |= _value_marks(plan, converted, rhythm, vehicle)
    delay, said = _delay(plan, timing, vehicle)
    notes = [*plan.notes, *converted.notes, *([said] if said else [])]
    _mark(marks, "spike", impossible(converted.quantity, converted.values))
    if converted.quantity == "attitude":
        zero = ~converted.values.any(axis=1) & ~marks.get("dropout", none)
        _mark(marks, "not_a_number", zero)
        if zero.any():
            notes.append("an attitude of four zeros counts as not a number")
    for flag, invalid in zip(plan.flags, found.invalid, strict=True):
        _mark(marks, "not_a_number", invalid)
        if invalid.any() or flag.is_telling:
            count = int(invalid.sum())
            notes.append(f"readings that {flag.says} count, others as not a number: {count}")
    if plan.quantity == "velocity":
        notes += _out_of_the_mount(converted.values, found.topic, vehicle)
    axes = QUANTITIES[plan.quantity].axes.replace("body", plan.body_axes)
    read = ChannelRead(
        quantity=plan.quantity,
        topic=plan.topic,
        message_type=found.topic.message_type,
        encoding=found.topic.encoding,
        fields=plan.fields,
        unit=converted.unit,
        unit_from="values" if plan.unit is None else plan.unit_from,
        sign=plan.sign,
        axes=axes.replace("earth", plan.earth_axes),
        mapped_by=plan.mapped_by,
        notes=tuple(notes),
    )
    return RunChannel(
        converted.quantity,
        plan.topic,
        converted.columns,
        time_ns,
        taken.log_time_ns,
        converted.values,
        marks,
        timing.clock,
        read,
        delay,
        holds,
        rhythm.period_s,
        rhythm.is_regular,
    )


def _mark(marks: dict[str, BoolArray], name: str, rows: BoolArray) -> None:
    if rows.any():
        marks[name] = marks.get(name, np.zeros_like(rows)) | rows


def _out_of_the_mount(values: FloatArray, topic: TopicFound, vehicle: Vehicle) -> list[str]:
    """Turn velocities (k, 3) from the axes of the DVL into those of the body, in place.

    What it reads too much by the vehicle file is taken off.
    """
    sensor = None if vehicle.sensors is None else vehicle.sensors.dvl
    if sensor is None:
        return []
    scaled = []
    if sensor.scale != 1.0:
        values /= sensor.scale
        scaled = [f"divided by sensors: dvl: scale ({sensor.scale:g})"]
    if not any(sensor.rotation_deg):
        return scaled
    if topic.message_type.endswith("/Odometry") or is_body(topic.frame):
        said = "in body axes by its message: rotation_deg of the DVL is not applied"
        return [*scaled, said]
    from scipy.spatial.transform import Rotation

    mount = Rotation.from_euler("ZYX", np.radians(sensor.rotation_deg)[::-1])
    values[:] = values @ mount.as_matrix().T
    angles = ", ".join(f"{angle:g}" for angle in sensor.rotation_deg)
    return [*scaled, f"turned into body axes by sensors: dvl: rotation_deg ({angles})"]


def _value_marks(
    plan: Plan, converted: Converted, rhythm: Rhythm, vehicle: Vehicle
) -> dict[str, BoolArray]:
    if plan.quantity == "thruster_command":
        drives = {thruster.name: vehicle.drives[thruster.drive] for thruster in vehicle.thrusters}
        own = [drives.get(name.split(".", 1)[-1], vehicle.drive) for name in converted.columns]
        return command_marks(
            converted.values,
            np.array([drive.code_min for drive in own], float),
            np.array([drive.code_max for drive in own], float),
        )
    return value_marks(
        converted.values,
        rhythm.period_s,
        is_quaternion=converted.quantity == "attitude",
        jumps=converted.quantity == "shaft_speed",
        lowest=plan.stated.lowest,
        highest=plan.stated.highest,
    )


def water_of(vehicle: Vehicle, metadata: Mapping[str, Mapping[str, str]]) -> WaterOfRun:
    """Water with which a simulated log was written, if it can be true, or of the vehicle file."""
    stated = metadata.get(_LOG_METADATA, {})
    with suppress(KeyError, ValueError):
        water = WaterOfRun(*(float(stated[one.name]) for one in fields(WaterOfRun)))
        if all(0.0 < value < float("inf") for value in astuple(water)):
            return water
    return WaterOfRun(vehicle.water.density_kgpm3, vehicle.water.gravity_mps2)
