"""The time of a table: numbers of a unit, seconds and nanoseconds, clock times, or dates."""

import re
import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from pipeline.errors import InputError, Place, Problem
from pipeline.ingest.log_times import counted_on
from pipeline.ingest.unit_text import UnitTextError, factor, quantities_of
from pipeline.records.pool_schema import CLOCK_UNITS_NS
from pipeline.types import BoolArray, IntArray

#: Name and unit of a column.
Head = tuple[str, str]
_TIME = re.compile(
    r"((log|rec|unix|epoch|elapsed|gps|run|время)[_ ]?)?(time|timestamp|stamp|t|elapsed|время)"
    r"([_ ]?(utc|boot|elapsed))?(_?(?P<unit>ns|us|ms|s|sec|min|h))?"
)
#: The whole seconds and the nanoseconds of a stamp in two columns.
_SECONDS, _REST = re.compile(r"(.*?)secs?(onds)?"), re.compile(r"(.*?)n(ano)?secs?(onds)?")
_DATE = ("date", "day", "дата", "datum")
#: Numbers without a unit that are times since 1970 are at least this many of it.
_SINCE_1970 = (("ns", 1e17), ("us", 1e14), ("ms", 1e11), ("s", 1e8))
#: What one may be worth otherwise [ns], days as spreadsheets count them among them; the usual step
#: between rows [s], and by how many powers of ten nearer to it another unit than seconds must be.
WORTH_NS = {**CLOCK_UNITS_NS, "min": 60 * 10**9, "h": 3600 * 10**9, "days": 86_400 * 10**9}
_USUAL_STEP_S, _NEARER = 0.05, 1.0
_SECOND_NS = 10**9
#: Rows of one whole second, at least, that were written in the course of it.
_ROWS_OF_SECOND = 3.0


def time_column(heads: Sequence[Head]) -> int | None:
    """Return the column that has the time: one with a unit of time, else one that is called so.

    Last come columns whose name is a unit.

    >>> time_column([("t", "degC"), ("t", ""), ("time", "")]), time_column([("time", "K")])
    (2, None)
    >>> time_column([("h", "m"), ("millis", "")]), time_column([("sec", ""), ("nsec", "")])
    (1, 0)
    """
    named = []
    for index, (name, unit) in enumerate(heads):
        match = _TIME.fullmatch(name)
        if match is not None and (not unit or _worth_ns(unit) or not quantities_of(unit)):
            named.append((not (unit or match["unit"]), name == "t", index))
    for index, (name, unit) in enumerate(heads):
        is_stamp = _nanoseconds(heads, index) is not None
        if is_stamp or (not unit and len(name) > 1 and name != "min" and _worth_ns(name)):
            named.append((True, True, index + len(heads)))
    return min(named)[2] % len(heads) if named else None


def _nanoseconds(heads: Sequence[Head], index: int) -> int | None:
    """Return the column that has the nanoseconds to the seconds of another."""
    of = _SECONDS.fullmatch(heads[index][0])
    return next(
        (
            at
            for at, (name, _) in enumerate(heads)
            if of is not None and (rest := _REST.fullmatch(name)) and rest[1] == of[1]
        ),
        None,
    )


def _worth_ns(unit: str) -> int:
    """Return what one of a unit of time is worth [ns], 0 where it is none.

    >>> _worth_ns("min"), _worth_ns("msec"), _worth_ns("degC")
    (60000000000, 1000000, 0)
    """
    if unit in WORTH_NS:
        return WORTH_NS[unit]
    try:
        return round(1e9 * factor(unit, "time"))
    except UnitTextError:
        return 0


def times_of(
    columns: Sequence[Any], heads: Sequence[Head], index: int, place: Place
) -> tuple[IntArray, IntArray, list[Problem]]:
    """Return the times [ns] of the rows that have one, which these are, and what was assumed.

    `columns` are those of pandas, numbers where they hold any. Raises `InputError` where the times
    are none that are known, or cannot tell the rows apart.
    """
    column, (name, unit) = columns[index], heads[index]
    if column.dtype.kind == "m":
        column, unit = column.dt.total_seconds(), "s"
    if column.dtype.kind not in "iuf":
        date = next((columns[at] for at, (one, _) in enumerate(heads) if one in _DATE), None)
        return _of_texts(column, date, name, place)
    rows = np.flatnonzero(np.isfinite(column.to_numpy()))
    values = column.to_numpy()[rows]
    rest = _nanoseconds(heads, index)
    match = _TIME.fullmatch(name)
    own_name = name if match is None and _worth_ns(name) else ""
    stated = unit or (match["unit"] if match is not None else None) or own_name
    stated = "s" if rest is not None else stated
    said: list[Problem] = []
    if not stated:
        stated = _unit_by_numbers(values.astype(float))
        if stated != "s" and not _since_1970(values):
            step = float(np.median(np.diff(np.sort(values.astype(float)))))
            what = (
                f'the times in column "{name}" have no unit: a step of {step:.3g} is taken for '
                f"{stated}, as rows in seconds would be {step:.3g} s apart."
            )
            remedy = "State the unit in the head of the column: time [s]."
            said.append(place.warning(what, remedy=remedy))
    worth = _worth_ns(stated)
    if not worth:
        raise InputError.at(
            place,
            f'"{stated}" of column "{name}" is no unit of time.',
            expected="s, ms, us, ns, min or h.",
            remedy="Correct the head of the column: time [s].",
        )
    _check_bits(values, name, worth, place)
    whole = values.astype(np.int64) if values.dtype.kind in "iu" else np.floor(values)
    time_ns = whole.astype(np.int64) * worth
    if rest is not None:
        time_ns += np.nan_to_num(columns[rest].to_numpy()[rows].astype(float)).astype(np.int64)
    elif values.dtype.kind == "f":
        time_ns += np.rint((values - whole) * worth).astype(np.int64)
    counted, how = counted_on(time_ns, worth)
    if how:
        what = f'the times in column "{name}" begin anew {how}: they were counted on.'
        said.append(place.warning(what))
    return _spread(counted, name, place, said), rows, said


def _check_bits(values: npt.NDArray[Any], name: str, worth: int, place: Place) -> None:
    """Refuse numbers that are too short for the time that passes from row to row."""
    if values.dtype.itemsize > 4 or values.dtype.kind != "f" or values.size < 2:
        return
    grain_s = float(np.spacing(values.max())) * worth / _SECOND_NS
    if grain_s > float(np.ptp(values)) * worth / _SECOND_NS / values.size:
        raise InputError.at(
            place,
            f'the times in column "{name}" are numbers of 32 bits, {grain_s:.3g} s apart: they '
            "cannot tell the rows apart.",
            expected="times that tell rows apart.",
            remedy="Export them as numbers of 64 bits, or from the start of the run.",
        )


def _of_texts(
    column: Any,  # noqa: ANN401  of pandas
    date: Any,  # noqa: ANN401
    name: str,
    place: Place,
) -> tuple[IntArray, IntArray, list[Problem]]:
    """Read clock times (10:00:00.25), with a column of dates or without, and dates."""
    import pandas as pd

    texts = column.astype("string").str.strip().str.replace(",", ".", regex=False)
    parts = texts.str.fullmatch(r"(\d+:)?\d+:\d+(\.\d*)?").fillna(value=False)
    said: list[Problem] = []
    clock_ns = np.zeros(len(texts), np.int64)
    sound: BoolArray = np.ones(len(texts), np.bool_)
    days = texts
    if parts.mean() >= 0.5:
        sound = parts.to_numpy(dtype=bool)
        split = texts.where(parts).str.split(":", expand=True).apply(pd.to_numeric)
        seconds = split.to_numpy(dtype=float) @ np.array((3600.0, 60.0, 1.0)[-split.shape[1] :])
        clock_ns[sound] = np.rint(seconds[sound] * _SECOND_NS)
        clock_ns[sound], _ = counted_on(clock_ns[sound], _SECOND_NS)
        if date is None:
            rows = np.flatnonzero(sound)
            return _spread(clock_ns[rows], name, place, said), rows, said
        days = date.astype("string").str.strip()
    dates = _dates(days, name, place, said)
    sound &= dates.notna().to_numpy()
    if sound.mean() < 0.5:
        raise InputError.at(
            place,
            f'the times in column "{name}" are neither numbers nor dates of ISO 8601.',
            remedy="Write them as seconds, or as 2026-05-04T10:00:00.25Z.",
        )
    rows = np.flatnonzero(sound)
    at = dates.dt.tz_localize(None).to_numpy().astype("datetime64[ns]").astype(np.int64)
    if date is not None and parts.mean() >= 0.5:
        at = at[rows[0]] + clock_ns  # the clock goes on after midnight
    return _spread(at[rows], name, place, said), rows, said


def _dates(texts: Any, name: str, place: Place, said: list[Problem]) -> Any:  # noqa: ANN401  of pandas
    """Read dates: those of ISO 8601, or of the day before the month, or after it."""
    import pandas as pd

    found = pd.to_datetime(texts, utc=True, errors="coerce", format="ISO8601")
    if found.notna().mean() >= 0.5 or texts.isna().all():
        return found
    first = pd.to_numeric(texts.str.extract(r"^(\d+)", expand=False), errors="coerce")
    second = pd.to_numeric(texts.str.extract(r"^\d+\D(\d+)", expand=False), errors="coerce")
    has_points = bool(texts.str.contains(r"^\d+\.\d", regex=True).any())
    day_first = has_points or bool((first > 12).any())
    if not day_first and not (second > 12).any():
        what = f'the dates in column "{name}" are read as month/day, which they may not be.'
        said.append(place.warning(what, remedy="Write them as 2026-05-04T10:00:00.25Z."))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of a format that cannot be told
        return pd.to_datetime(texts, utc=True, errors="coerce", dayfirst=day_first)


def _spread(time_ns: IntArray, name: str, place: Place, said: list[Problem]) -> IntArray:
    """Spread rows over the second in which they were written, where times are whole seconds."""
    seconds, counts = np.unique(time_ns, return_counts=True)
    if seconds.size < 3 or (time_ns % _SECOND_NS).any() or np.median(counts) < _ROWS_OF_SECOND:
        return time_ns
    if (np.diff(time_ns) < 0).any():
        return time_ns
    said.append(
        place.warning(
            f'the times in column "{name}" are whole seconds, and rows are {np.median(counts):.0f} '
            "a second: they were spread evenly.",
            remedy="Record fractions of a second.",
        )
    )
    usual = np.maximum(counts, np.median(counts))
    # the recorder began within the first second, and ended within the last
    late = np.where(np.arange(counts.size) == 0, usual - counts, 0.0)
    within = np.arange(time_ns.size) - np.repeat(np.cumsum(counts) - counts - late, counts)
    after_s = within / np.repeat(usual, counts)
    return np.asarray(time_ns + np.rint(after_s * _SECOND_NS).astype(np.int64))


def _since_1970(values: npt.NDArray[Any]) -> str:
    """Return the unit of times since 1970 by their size, empty for others."""
    low, usual, high = np.quantile(values, [0.25, 0.5, 0.75]) if values.size else (0.0, 0.0, 0.0)
    if high - low > 0.1 * usual:
        return ""
    return next((one for one, least in _SINCE_1970 if least <= usual < 100.0 * least), "")


def _unit_by_numbers(values: npt.NDArray[Any]) -> str:
    """Tell the unit of times by their size, or by the step in which a recorder writes rows.

    >>> _unit_by_numbers(np.arange(9.0) * 20.0), _unit_by_numbers(np.arange(9.0))
    ('ms', 's')
    """
    steps = np.diff(np.sort(values))
    steps = steps[steps > 0.0]
    if (known := _since_1970(values)) or not steps.size:
        return known or "s"

    def off(unit: str) -> float:
        step_s = float(np.median(steps)) * WORTH_NS[unit] / 1e9
        return abs(float(np.log10(step_s / _USUAL_STEP_S)))

    best = min(WORTH_NS, key=off)
    return best if off(best) < off("s") - _NEARER else "s"
