"""How a velocity was meant: which reading of it follows best what moves the vehicle.

One score compares all readings: the share of the velocity that a reference leaves unexplained. A
reference is the rate of position in body axes, or the push of the thrusters, which a vehicle
follows with a lag; its third component is the rate of depth where there is one. Each axis has a
gain of its own, which is not negative. Readings are the velocity as it is, with other axes, over
the earth, turned about the vertical, speeds along the beams of a DVL, and thrusters that are
swapped or reversed.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from pipeline.ingest.pool_run_resample import into_body, on_rows, thrusters_of
from pipeline.records.run_arrays import PoolRun
from pipeline.records.run_table import RunTable
from pipeline.types import BoolArray, FloatArray
from pipeline.vehicle.schema import Vehicle

#: How a vehicle may lag behind the push. [s]
_LAGS_S = (0.5, 1.5, 4.0, 10.0)
#: Less way may be a drift or noise; fewer rows say nothing, more say no more. [m/s, -, -]
_UNDER_WAY_MPS, _FEWEST_ROWS, _ENOUGH_ROWS = 0.05, 120, 20_000
#: What is unexplained at least before another reading is looked for, one that has a free angle or
#: order, and one that has none: a third of a turn of 90 degrees leaves 0.25.
_LEAST_FITTED, _LEAST_FIXED = 0.25, 0.08
#: What another reading leaves of that at most, in the whole run and in each half of it.
_MOST_LEFT, _MOST_LEFT_OF_HALF = 0.4, 0.75
#: What the rate of position leaves at most of a velocity that is as it was read.
_AGREES = 0.1
#: Readings that leave so little more than the best are told beside it, up to so many.
_ALIKE, _MOST_TOLD = 0.03, 3
_TURNS_DEG = range(-165, 181, 15)
_PORT_AND_UP = np.diag([1.0, -1.0, -1.0])
#: Where three beams of a DVL look, clockwise from the bow: opposite, round, three in all. [deg]
_BEAMS_DEG = (
    (0, 180, 90),
    (0, 180, -90),
    (0, 90, 180),
    (0, -90, 180),
    (0, 120, 240),
    (0, 240, 120),
)
_SLANT = np.radians(25.0)


@dataclass(frozen=True)
class Reading:
    """A velocity (n, 3) in body axes as it may have been meant; how that is said or stated."""

    velocity: FloatArray
    how: str
    any_heading: bool = False
    """It is turned about the vertical by an angle that nobody knows."""


@dataclass(frozen=True)
class _Meaning:
    """A reading by its share that is left, in the whole run and in its halves (3,)."""

    left: FloatArray
    kind: str
    how: str
    fitted: bool


def meant_otherwise(
    run: PoolRun, table: RunTable, readings: Sequence[Reading], rows: BoolArray, vehicle: Vehicle
) -> str:
    """Say by which readings a velocity would plainly be better explained; nothing if by none.

    The first of `readings` is the velocity as it was read.
    """
    rate_hz = 1.0 / float(np.diff(table.time_s[:2])[0])
    own = readings[0].velocity
    rows = rows & (np.linalg.norm(own, axis=1) > _UNDER_WAY_MPS)
    if rows.sum() < _FEWEST_ROWS:
        return ""
    first = np.cumsum(rows) <= rows.sum() // 2
    parts = [_thinned(part) for part in (rows, rows & first, rows & ~first)]
    down = _rate(table.values["depth"], rate_hz)[:, 0] if "depth" in table.values else None
    if {"position", "attitude"} <= set(table.values):
        way = into_body(_rate(table.values["position"], rate_hz), table.values["attitude"])
        by_place = list(_meanings(readings, [way], parts))
        if said := _told(by_place, "the rate of position"):
            return said
        if by_place[0].left[0] < _AGREES:
            readings = readings[:1]  # a vehicle that turns may slip sideways
    commanded = thrusters_of(run, "command")
    if not commanded:
        return ""
    code = np.nan_to_num(on_rows(run, rate_hz, "command").values["command"])
    direction = {one.name: one.direction for one in vehicle.thrusters}
    arms = np.array([direction.get(name, (0.0, 0.0, 0.0)) for name in table.thrusters])
    largest = float(np.abs(code).max(initial=0.0))
    if not largest or not arms.any():
        return ""
    effort = code / largest
    # between a linear and a quadratic characteristic
    lagging = [_lagging(effort * np.sqrt(np.abs(effort)), rate_hz * lag_s) for lag_s in _LAGS_S]
    found = list(_meanings(readings, _pushes(lagging, arms, down), parts))
    changing = _left_of_changes(own, _pushes(lagging, arms, down), parts)
    for how, changed in rearranged(arms, table.thrusters):
        pushes = _pushes(lagging, changed, down)
        if (_left_of_changes(own, pushes, parts) > _MOST_LEFT_OF_HALF * changing).any():
            continue
        left = np.array([_left(own[part], _AS_IT_IS, pushes, part)[0] for part in parts])
        found.append(_Meaning(left, how, how, fitted=True))
    return _told(found, "the push of the thrusters")


def _told(found: Sequence[_Meaning], what: str) -> str:
    """Put the better readings into words, the best of each kind that is about as good."""
    as_read = found[0].left
    better = [
        one
        for one in found[1:]
        if as_read[0] > (_LEAST_FITTED if one.fitted else _LEAST_FIXED)
        and one.left[0] < _MOST_LEFT * as_read[0]
        and (one.left[1:] < _MOST_LEFT_OF_HALF * as_read[1:]).all()
    ]
    better.sort(key=lambda one: one.left[0])
    kinds = {one.kind: one for one in reversed(better) if one.left[0] < better[0].left[0] + _ALIKE}
    if not kinds:
        return ""
    listed = "; ".join(
        f"{100.0 * (1.0 - one.left[0]):.0f} % if {one.how}"
        for one in sorted(kinds.values(), key=lambda one: one.left[0])[:_MOST_TOLD]
    )
    share = f"{100.0 * (1.0 - as_read[0]):.0f} %"
    return f"contradicts the motion: {what} explains {share} of it as it was read; {listed}."


def _meanings(
    readings: Sequence[Reading], references: Sequence[FloatArray], parts: Sequence[BoolArray]
) -> Iterator[_Meaning]:
    """Score all readings that need no other order of thrusters; the first is as it was read."""
    for reading in readings:
        how = f"stated as {reading.how}"
        matrices = _ABOUT_DOWN if reading.any_heading else _AS_IT_IS
        each = np.array([_left(reading.velocity[one], matrices, references, one) for one in parts])
        left = each[:, each[0].argmin()]
        yield _Meaning(left, how, how, fitted=reading.any_heading)
    if len(readings) == 1:
        return
    turned = [_left(readings[0].velocity[part], _TURNED, references, part) for part in parts]
    for (kind, how), left in zip(_TURNED_HOW, np.transpose(turned), strict=True):
        yield _Meaning(left, kind, how, fitted=True)


def _left(
    velocity: FloatArray, matrices: FloatArray, references: Sequence[FloatArray], rows: BoolArray
) -> FloatArray:
    """Return the share of a velocity (n, 3) that references leave, by each matrix (c, 3, 3)."""
    total = np.einsum("cij,jk,cik->c", matrices, velocity.T @ velocity, matrices)
    gained = np.zeros((len(matrices), 3))
    for reference in references:
        moved = reference[rows]
        along = np.einsum("cij,ji->ci", matrices, velocity.T @ moved)
        power = (moved**2).sum(axis=0)
        known = power > 1e-4 * power.max()
        explained = np.maximum(along, 0.0) ** 2 / np.where(known, power, 1.0)
        gained = np.maximum(gained, np.where(known, explained, 0.0))
    return np.asarray(1.0 - gained.sum(axis=1) / total)


def _left_of_changes(
    velocity: FloatArray, references: Sequence[FloatArray], parts: Sequence[BoolArray]
) -> FloatArray:
    """Return what is left of a velocity less its mean: steady thrust does not tell thrusters."""
    left = []
    for rows in parts:
        moved = [one - one[rows].mean(axis=0) for one in references]
        changes = velocity[rows] - velocity[rows].mean(axis=0)
        left.append(_left(changes, _AS_IT_IS, moved, rows)[0])
    return np.array(left)


def _pushes(
    lagging: Sequence[FloatArray], arms: FloatArray, down: FloatArray | None
) -> list[FloatArray]:
    """Return the push by each lag; without a depth a vehicle may also rise or sink by itself."""
    pushes = [np.asarray(one @ arms) for one in lagging]
    if down is not None:
        return [np.column_stack([one[:, :2], down]) for one in pushes]
    by_itself = np.tile([0.0, 0.0, 1.0], (len(pushes[0]), 1))
    return [*pushes, by_itself, -by_itself]


def _lagging(values: FloatArray, lag_rows: float) -> FloatArray:
    from scipy.signal import lfilter

    share = 1.0 - np.exp(-1.0 / lag_rows)
    return np.asarray(lfilter([share], [1.0, share - 1.0], values, axis=0))


def _rate(values: FloatArray, rate_hz: float) -> FloatArray:
    """Return the rate over a second about each row; 0 where it is not known."""
    half = round(rate_hz / 2.0)
    rate = np.zeros_like(values)
    rate[half:-half] = np.nan_to_num(values[2 * half :] - values[: -2 * half])
    return rate * rate_hz / (2.0 * half)


def _thinned(rows: BoolArray) -> BoolArray:
    """Leave as many rows as are enough, evenly spaced."""
    kept = np.zeros_like(rows)
    there = np.flatnonzero(rows)
    kept[there[:: 1 + there.size // _ENOUGH_ROWS]] = True
    return kept


def rearranged(arms: FloatArray, names: Sequence[str]) -> Iterator[tuple[str, FloatArray]]:
    """Yield arms (thrusters, k) with two exchanged or one turned round; those that differ."""
    changes = []
    for i, j in combinations(range(len(arms)), 2):
        changes.append((f"{names[i]} and {names[j]} are swapped", arms.copy()))
        changes[-1][1][[i, j]] = arms[[j, i]]
    for i, name in enumerate(names):
        changes.append((f"{name} is reversed", arms.copy()))
        changes[-1][1][i] *= -1.0
    yield from ((how, changed) for how, changed in changes if np.abs(changed - arms).max() > 1e-3)


def _about_down(turn_deg: float) -> FloatArray:
    cos, sin = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


def _of_beams(azimuths_deg: Sequence[float]) -> FloatArray:
    """Return the matrix that makes a velocity of three speeds along beams."""
    angle = np.radians(azimuths_deg)
    across, along = np.sin(_SLANT), np.full(3, np.cos(_SLANT))
    return np.linalg.inv(np.stack([across * np.cos(angle), across * np.sin(angle), along], axis=1))


def _turned() -> Iterator[tuple[tuple[str, str], FloatArray]]:
    for turn in _TURNS_DEG:
        about = _about_down(turn)
        if turn:
            yield (
                ("turned", f"it is read turned by {turn} degrees (sensors: dvl: rotation_deg)"),
                about,
            )
            flipped = f"it is read with y to port and z up, turned by {turn} degrees"
            yield ("flipped", flipped), about @ _PORT_AND_UP
        for azimuths in _BEAMS_DEG:
            for sign in (1.0, -1.0):
                of_beams = "it is read as speeds along the beams of a DVL"
                yield ("beams", of_beams), sign * about @ _of_beams(azimuths)


_AS_IT_IS = np.eye(3)[None]
_ABOUT_DOWN = np.array([_about_down(turn) for turn in _TURNS_DEG])
_TURNED_HOW, _TURNED = (
    [how for how, _ in _turned()],
    np.array([matrix for _, matrix in _turned()]),
)
