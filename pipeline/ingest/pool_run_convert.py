"""Readings in the units and axes of the records: SNAME body, NED earth, codes, depth."""

from dataclasses import dataclass

import numpy as np

from pipeline.ingest.command_units import GuessedUnit, doubt_of_codes, guess_units
from pipeline.ingest.pool_run_extract import TopicData
from pipeline.ingest.pool_run_plan import Plan
from pipeline.ingest.quantities import QUANTITIES
from pipeline.ingest.thruster_names import thrusters_named
from pipeline.records.pool_schema import UNITS
from pipeline.records.run_table import quaternion_product
from pipeline.types import BoolArray, FloatArray, IntArray
from pipeline.vehicle.schema import Vehicle

#: Rows: forward, right, down of a vector in the source's axes.
BODY = {
    "frd": np.eye(3),
    "flu": np.diag([1.0, -1.0, -1.0]),
    "fur": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]),
}
#: Rows: north, east, down of a vector in the source's axes.
EARTH = {
    "ned": np.eye(3),
    "enu": np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]),
    "nwu": np.diag([1.0, -1.0, -1.0]),
}
_CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])
#: Standard atmosphere; the share of it that a sensor never reads which reads from a vacuum.
ATMOSPHERE_PA, _THIN_AIR = 101325.0, 0.8
#: Where more of the angles cannot be the unit is wrong, or the order.
_MOST_NONE = 0.5
#: A pitch is counted from 0 to a turn where it is so near to seven eighths of it. [half turns]
_OF_A_TURN = 0.251


@dataclass(frozen=True)
class WaterOfRun:
    """What turns pressure into depth, and where the numbers are from."""

    density_kgpm3: float
    gravity_mps2: float
    atmospheric_pressure_pa: float | None = None


@dataclass(frozen=True)
class Converted:
    """Readings of a quantity of the records, with what was assumed on the way."""

    quantity: str
    columns: tuple[str, ...]
    values: FloatArray
    unit: str
    notes: tuple[str, ...] = ()
    said_of: BoolArray | None = None
    """Which messages (k, n) say something of which thruster, where some are silent of some."""
    doubt: str = ""
    """What was assumed and may be wrong."""
    unclear: str = ""
    """Why nobody can tell what the readings mean; then there are none."""


def convert(
    plan: Plan,
    raw: FloatArray,
    vehicle: Vehicle,
    water: WaterOfRun,
    taken: TopicData | None = None,
    *,
    guessed: GuessedUnit | None = None,
) -> Converted:
    """Convert numbers (k, m) of messages; `raw` is changed in place where that saves memory.

    What was `taken` has the names of the elements where the messages have them; `guessed` is the
    unit of commands that state none: where it is not given, these readings alone tell it.
    """
    from scipy.spatial.transform import Rotation

    facts = QUANTITIES[plan.quantity]
    if facts.each:
        return _by_thruster(plan, raw, vehicle, taken, guessed)
    notes: list[str] = []
    unit = plan.unit or next(iter(UNITS[plan.quantity]))
    if plan.quantity == "attitude_euler" and plan.unit is None:
        largest = np.nanmax(np.abs(raw), axis=0, initial=0.0)
        if (largest > np.array([np.pi, np.pi / 2.0, 2.0 * np.pi]) + 0.01).any():
            unit, notes = "deg", ["angles are taken for deg: they go beyond what radians can be"]
    scale = UNITS[plan.quantity][unit] * np.array(plan.sign, float)
    if (scale != 1.0).any():
        raw *= scale
    if plan.quantity == "attitude_quaternion":
        raw = _attitude(plan, raw)
    elif plan.quantity == "attitude_euler":
        raw[:, 1] -= 2.0 * np.pi * (np.abs(raw[:, 1] / np.pi - 1.75) < _OF_A_TURN)
        none = np.abs(raw[:, 1]) > np.pi / 2.0 + 0.01  # no pitch, but a number for none
        raw[none & (none.mean() < _MOST_NONE)] = np.nan
        turn = Rotation.from_euler("ZYX", raw[:, ::-1])
        raw = _attitude(plan, np.asarray(turn.as_quat()), order="xyzw")
    elif plan.quantity == "pressure":
        notes += _into_depth(plan, raw, water)
    elif facts.axes == "body":
        _turn(raw, BODY[plan.body_axes])
    elif facts.axes == "earth":
        _turn(raw, EARTH[plan.earth_axes])
    return Converted(facts.channel or plan.quantity, facts.columns, raw, unit, tuple(notes))


def _turn(vectors: FloatArray, axes: FloatArray) -> None:
    """Turn vectors in place; axes are a signed permutation, so no rounding comes in."""
    source = np.abs(axes).argmax(axis=1)
    if (source == np.arange(3)).all():
        signs = axes.diagonal()
        if (signs != 1.0).any():
            vectors *= signs
        return
    vectors[:] = vectors[:, source] * axes.sum(axis=1)


def _attitude(plan: Plan, raw: FloatArray, order: str | None = None) -> FloatArray:
    """Quaternion w, x, y, z of the body to NED: E q B^-1, E and B the turns of the axes.

    In the source the quaternion turns its body axes into its earth axes.
    """
    if (order or plan.order) == "xyzw":
        raw[:] = raw[:, [3, 0, 1, 2]]
    if plan.body_axes != "frd":
        raw[:] = quaternion_product(raw, _as_quaternion(BODY[plan.body_axes]) * _CONJUGATE)
    if plan.earth_axes != "ned":
        raw[:] = quaternion_product(_as_quaternion(EARTH[plan.earth_axes]), raw)
    return raw


def _as_quaternion(axes: FloatArray) -> FloatArray:
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_matrix(axes).as_quat()[[3, 0, 1, 2]])


def _into_depth(plan: Plan, raw: FloatArray, water: WaterOfRun) -> list[str]:
    """Make depths of pressures, in place; return what was assumed."""
    notes: list[str] = []
    surface = plan.stated.surface_pressure_pa
    if surface is None:
        surface = water.atmospheric_pressure_pa
    if surface is None:
        finite = raw[np.isfinite(raw)]
        low = float(np.quantile(finite, 0.1)) if finite.size else ATMOSPHERE_PA
        reads_from_surface = low < _THIN_AIR * ATMOSPHERE_PA
        surface = 0.0 if reads_from_surface else ATMOSPHERE_PA
        notes.append(
            f"the surface is taken to be at {surface:g} Pa; state surface_pressure_pa otherwise"
        )
    raw -= surface
    raw /= water.density_kgpm3 * water.gravity_mps2
    notes.append(
        f"depth = (pressure - {surface:g} Pa) / ({water.density_kgpm3:g} kg/m3 x "
        f"{water.gravity_mps2:g} m/s2)"
    )
    return notes


def _by_thruster(
    plan: Plan,
    raw: FloatArray,
    vehicle: Vehicle,
    taken: TopicData | None,
    guessed: GuessedUnit | None,
) -> Converted:
    notes: list[str] = []
    said_of: BoolArray | None = None
    thrusters = plan.thrusters
    if plan.names is not None and taken is not None and taken.name_list is not None:
        raw, thrusters, said_of, said = _sorted_by_name(raw, vehicle, taken.names, taken.name_list)
        notes += said
    sign = np.array(plan.sign, float)[: raw.shape[1]] if len(set(plan.sign)) > 1 else plan.sign[0]
    if plan.quantity != "thruster_command":
        unit = plan.unit or next(iter(UNITS[plan.quantity]))
        raw *= sign * UNITS[plan.quantity][unit]
        columns = tuple(f"{QUANTITIES[plan.quantity].each}{name}" for name in thrusters)
        return Converted(plan.quantity, columns, raw, unit, tuple(notes), said_of)
    pwm = vehicle.pool.pwm_range
    drives = {thruster.name: vehicle.drives[thruster.drive] for thruster in vehicle.thrusters}
    own = [drives.get(name, vehicle.drive) for name in thrusters]
    one_way = all(drive.code_min >= 0 for drive in own)
    alone = ("", "")
    guessed = guessed or guess_units({alone: raw}, pwm, {alone: plan.unit}, one_way=one_way)[alone]
    if plan.unit is None:
        notes.append(f"commands are taken for {guessed.unit}: {guessed.why}")
    unit, neutral = guessed.unit, guessed.neutral
    if plan.stated.neutral is not None:
        neutral, guessed = plan.stated.neutral, GuessedUnit(unit, "")
    doubt = guessed.doubt
    if unit == "code" and plan.unit_from != "message" and plan.mapped_by.startswith("default"):
        doubt = doubt_of_codes(raw, min((drive.code_max for drive in own), default=0))
    if guessed.unclear:
        return Converted(plan.quantity, (), raw, unit, unclear=guessed.unclear)
    full = {"ratio": 1.0 - neutral, "%": 100.0 - neutral}.get(unit)
    if unit == "us":
        raw[raw == 0.0] = np.nan  # no pulse is no command
        neutral, full = pwm.neutral_us, pwm.half_range_us
        if not {"neutral_us", "half_range_us"} <= pwm.model_fields_set:
            notes.append(f"pulses are taken for {neutral:g} +- {full:g} us; see pool: pwm_range")
    worth = [1.0 if full is None else drive.code_max / full for drive in own]
    raw -= neutral
    raw *= worth[: raw.shape[1]]
    raw *= sign
    columns = tuple(f"command.{name}" for name in thrusters)
    return Converted(plan.quantity, columns, raw, unit, tuple(notes), said_of, doubt)


def _sorted_by_name(
    raw: FloatArray, vehicle: Vehicle, names: list[tuple[str, ...]], used: IntArray
) -> tuple[FloatArray, tuple[str, ...], BoolArray | None, list[str]]:
    """Bring the elements of each message into the order of the vehicle's thrusters.

    `used` (k,) says which list of names a message has, -1 for none.
    """
    notes: list[str] = []
    stated = tuple(thruster.name for thruster in vehicle.thrusters)
    every = list(dict.fromkeys(text for texts in names for text in texts))
    called = thrusters_named(every, stated) if stated else {text: text for text in every}
    kept = tuple(name for name in stated or every if name in called.values())
    renamed = [f"{text} is {name}" for text, name in called.items() if text != name]
    if renamed:
        notes.append(f"elements by the thrusters in their names: {', '.join(renamed[:12])}")
    strange = sorted(text for text in every if text not in called)
    if strange:
        notes.append(f"elements named {', '.join(strange[:8])} belong to no thruster; left out")
    missing = [name for name in stated if name not in kept]
    if missing:
        notes.append(f"there is no element named {', '.join(missing[:8])}")
    lists = [tuple(called.get(text, "") for text in texts) for texts in names]
    if lists == [kept]:
        return raw[:, : len(kept)], kept, None, notes
    values = np.full((raw.shape[0], len(kept)), np.nan)
    # of a message that is broken nobody knows whom it spoke of
    said_of = np.repeat((used < 0)[:, None], len(kept), axis=1)
    for number, texts in enumerate(lists):
        rows = used == number
        for column, name in enumerate(kept):
            if name in texts and texts.index(name) < raw.shape[1]:
                values[rows, column] = raw[rows, texts.index(name)]
                said_of[rows, column] = True
    if len(lists) > 1:
        notes.append(f"the names of the elements change during the run ({len(lists)} lists)")
    return values, kept, None if said_of.all() else said_of, notes
