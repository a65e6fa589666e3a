"""Tables in time: a run as ``*.csv`` (``.tsv``, ``.txt``) or ``*.parquet``, a row a reading.

The first line names the columns, with their units in brackets or at the end of the name. One has
the time: seconds (or another unit) since the start or since 1970, or dates of ISO 8601.
"""

import functools
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from pipeline.errors import InputError, Place, Problem
from pipeline.ingest.data_files import data_of
from pipeline.ingest.log_source import TABLE, LogFacts, TableLog, TopicTable
from pipeline.ingest.log_times import counted_on
from pipeline.ingest.message_fields import LETTERS
from pipeline.ingest.unit_text import UnitTextError, factor, is_same_unit, quantities_of
from pipeline.records.pool_schema import CLOCK_UNITS_NS, UNITS, PoolChannel
from pipeline.types import IntArray

_HEAD = re.compile(r"\s*(?P<name>.*?)\s*[\[(](?P<unit>[^\])]*)[\])]\s*")
_TIME = re.compile(
    r"((log|rec|unix|epoch|elapsed|gps|run|время)[_ ]?)?(time|timestamp|stamp|t|elapsed|время)"
    r"([_ ]?(utc|boot|elapsed))?(_?(?P<unit>ns|us|ms|s|sec|min|h))?"
)
#: Numbers without a unit that are times since 1970 are at least this many of it.
_SINCE_1970 = (("ns", 1e17), ("us", 1e14), ("ms", 1e11), ("s", 1e8))
#: What one may be worth otherwise [ns], days as spreadsheets count them among them; the usual step
#: between rows [s], and by how many powers of ten nearer to it another unit than seconds must be.
_WORTH_NS = {**CLOCK_UNITS_NS, "min": 60 * 10**9, "h": 3600 * 10**9, "days": 86_400 * 10**9}
#: Rows of which more go back in time are sorted; fewer are a clock that was set.
_MOST_BACK = 0.1
_USUAL_STEP_S, _NEARER = 0.05, 1.0
_KNOWN = ("%", *dict.fromkeys(one for units in UNITS.values() for one in units), *_WORTH_NS)
_NO_UNIT = ("", "-", "nan", "<NA>", "None", "quat")
_BYTES_OF_HEAD = 65_536


def read_table(path: Path, shown_as: str) -> TableLog:
    """Read a table in time.

    Raises `InputError` if it cannot be read, or no column has the time.
    """
    place = Place(shown_as)
    frame = _frame(path, place)
    heads = [_split(str(name)) for name in frame.columns]
    under = _units_under(frame)
    if under:
        frame = frame.iloc[1:]
        heads = [(name, unit or own) for (name, unit), own in zip(heads, under, strict=True)]
    index = _time_column(heads)
    if index is None:
        named = ", ".join(name for name, _ in heads[:12])
        raise InputError.at(
            place,
            f"no column of the table has the time, among {named}.",
            expected='a column "time" or "t", its unit in brackets: time [s].',
            remedy="Name it, or move the file out of pool/ if it is no run.",
        )
    time_ns, rows, said = _times(frame.iloc[:, index], *heads[index], place)
    if (np.diff(time_ns) < 0).mean() > _MOST_BACK:
        order = np.argsort(time_ns, kind="stable")
        time_ns, rows = time_ns[order], rows[order]
        said.append(place.warning("the rows are not in the order of time: they were sorted."))
    columns: dict[str, npt.NDArray[Any]] = {}
    units: dict[str, str] = {}
    for number, (name, unit) in enumerate(heads):
        values = _numbers(frame.iloc[:, number]).to_numpy()
        if number != index and values.dtype.kind in "iufb":
            field = _field(name)
            columns.setdefault(field, values[rows].astype(float))
            units.setdefault(field, unit)
    size = path.stat().st_size
    facts = LogFacts(place, size, size, writer="a table", recorder="names of columns")
    facts.problems += said
    facts.usual = tuple(_usual(units, facts))
    return TableLog({TABLE: TopicTable(time_ns, columns)}, facts)


def first_time_ns(path: Path) -> int:
    """Return the time of the first row [ns since 1970]; 0 where there is none."""
    try:
        frame = _frame(path, Place(path.name), rows=3)
        heads = [_split(str(name)) for name in frame.columns]
        index = _time_column(heads)
        if index is None:
            return 0
        return int(_times(frame.iloc[:, index], *heads[index], Place(path.name))[0][0])
    except (InputError, OSError, IndexError, ValueError):
        return 0


def _time_column(heads: Sequence[tuple[str, str]]) -> int | None:
    """Return the column that has the time: one with a unit of time, else one that is called so.

    >>> _time_column([("t", "degC"), ("t", ""), ("time", "")]), _time_column([("time", "K")])
    (2, None)
    """
    named = []
    for index, (name, unit) in enumerate(heads):
        match = _TIME.fullmatch(name)
        if match is not None and (not unit or _worth_ns(unit) or not quantities_of(unit)):
            has_unit = bool(unit or match["unit"])
            named.append((not has_unit, name == "t", index))
    return min(named)[2] if named else None


def _worth_ns(unit: str) -> int:
    """Return what one of a unit of time is worth [ns], 0 where it is none.

    >>> _worth_ns("min"), _worth_ns("msec"), _worth_ns("degC")
    (60000000000, 1000000, 0)
    """
    if unit in _WORTH_NS:
        return _WORTH_NS[unit]
    try:
        return round(1e9 * factor(unit, "time"))
    except UnitTextError:
        return 0


def _frame(path: Path, place: Place, rows: int | None = None) -> Any:  # noqa: ANN401  of pandas
    import pandas as pd

    try:
        if path.suffix.lower() == ".parquet":
            frame = pd.read_parquet(path)
            if isinstance(frame.index, pd.RangeIndex):
                return frame
            frame.index.name = frame.index.name or "time"
            return frame.reset_index()
        with path.open("rb") as file:
            head = file.read(_BYTES_OF_HEAD).decode("utf-8-sig", errors="replace").splitlines()
        first = next((line for line in head if line.strip()), "")
        apart = max("\t;,", key=first.count)
        some = [line for line in head[1:50] if line.strip()]
        comma = apart != "," and any(re.search(r"\d,\d", line) for line in some)
        return pd.read_csv(
            path,
            sep=apart,
            decimal="," if comma else ".",
            encoding="utf-8-sig",
            skipinitialspace=True,
            low_memory=False,
            nrows=rows,
        )
    except ImportError:
        why = "pyarrow is not installed"
        remedy = 'pip install "rig2sea[parquet]"'
    except Exception as error:  # noqa: BLE001 - pandas has many
        why, remedy = " ".join(str(error).split())[:200], "Export it again as UTF-8."
    raise InputError.at(
        place, f"the table cannot be read ({why}).", expected="a table in time.", remedy=remedy
    )


def _numbers(column: Any) -> Any:  # noqa: ANN401  a column of pandas
    """Return a column of texts as numbers where most of them are, with point or comma."""
    import pandas as pd

    if column.dtype.kind in "iufb":
        return column
    plain = column.astype("string").str.strip().str.replace(",", ".", regex=False)
    plain = plain.replace({letter: str(worth) for letter, worth in LETTERS.items()})
    found = pd.to_numeric(plain, errors="coerce").astype(float)
    return found if found.notna().mean() > 0.5 else column


def _split(head: str) -> tuple[str, str]:
    """Split the head of a column into its name and its unit.

    >>> _split("Roll [deg]"), _split("time_ms"), _split("depth_m")
    (('roll', 'deg'), ('time_ms', ''), ('depth_m', ''))
    """
    match = _HEAD.fullmatch(head)
    name, unit = (match["name"], match["unit"].strip()) if match else (head.strip(), "")
    return name.strip().lower(), _as_known(unit)


@functools.cache
def _as_known(unit: str) -> str:
    """Return a unit as the quantities of a log have it, however it is written.

    >>> [_as_known(one) for one in ("м/с", "m/s²", "°/s", "dps", "Pa", "mA", "K")]
    ['m/s', 'm/s2', 'deg/s', 'deg/s', 'Pa', 'mA', 'K']
    """
    is_known = unit in _KNOWN or unit in _NO_UNIT
    return unit if is_known else next((one for one in _KNOWN if is_same_unit(unit, one)), unit)


def _units_under(frame: Any) -> list[str]:  # noqa: ANN401  of pandas
    """Return the units of a row of units under the names, nothing where the first row is none."""
    cells = [] if frame.empty else [str(one).strip(" []()") for one in frame.iloc[0]]
    units = ["" if one in _NO_UNIT else _as_known(one) for one in cells]
    known = {*_KNOWN} - {"1"}  # a reading
    return units if {*units} - {""} and {*units} <= {"", *known} else []


def _field(name: str) -> str:
    """Return a name that the ``field`` of a channel may have; dots part messages."""
    plain = re.sub(r"[^A-Za-z0-9_]+", "_", name).strip("_")
    return plain if plain[:1].isalpha() else f"c_{plain}"


def _times(
    column: Any,  # noqa: ANN401  of pandas
    name: str,
    unit: str,
    place: Place,
) -> tuple[IntArray, IntArray, list[Problem]]:
    """Return the times [ns] of the rows that have one, which these are, and what was assumed."""
    import pandas as pd

    if column.dtype.kind == "m":
        column, unit = column.dt.total_seconds(), "s"
    column = _numbers(column)
    if column.dtype.kind not in "iuf":
        dates = pd.to_datetime(column, utc=True, errors="coerce", format="ISO8601")
        sound = dates.notna().to_numpy()
        if sound.mean() < 0.5:
            raise InputError.at(
                place,
                f'the times in column "{name}" are neither numbers nor dates of ISO 8601.',
                remedy="Write them as seconds, or as 2026-05-04T10:00:00.25Z.",
            )
        at = dates[sound].dt.tz_localize(None).to_numpy().astype("datetime64[ns]")
        return at.astype(np.int64), np.flatnonzero(sound), []
    rows = np.flatnonzero(np.isfinite(column.to_numpy()))
    values = column.to_numpy()[rows]
    match = _TIME.fullmatch(name)
    stated = unit or (match["unit"] if match is not None else None) or ""
    said: list[Problem] = []
    if not stated:
        stated = _unit_by_numbers(values.astype(float))
        if stated != "s" and not _since_1970(values):
            step = float(np.median(np.diff(values.astype(float))))
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
    whole = values.astype(np.int64) if values.dtype.kind in "iu" else np.floor(values)
    time_ns = whole.astype(np.int64) * worth
    if values.dtype.kind == "f":
        time_ns += np.rint((values - whole) * worth).astype(np.int64)
    counted, how = counted_on(time_ns, worth)
    if how:
        what = f'the times in column "{name}" begin anew {how}: they were counted on.'
        said.append(place.warning(what))
    return counted, rows, said


def _since_1970(values: npt.NDArray[Any]) -> str:
    """Return the unit of times since 1970 by their size, empty for others."""
    largest = float(np.median(values)) if values.size else 0.0
    return next((one for one, least in _SINCE_1970 if largest >= least), "")


def _unit_by_numbers(values: npt.NDArray[Any]) -> str:
    """Tell the unit of times by their size, or by the step in which a recorder writes rows.

    >>> _unit_by_numbers(np.arange(9.0) * 20.0), _unit_by_numbers(np.arange(9.0))
    ('ms', 's')
    """
    steps = np.diff(values)
    steps = steps[steps > 0.0]
    if (known := _since_1970(values)) or not steps.size:
        return known or "s"

    def off(unit: str) -> float:
        step_s = float(np.median(steps)) * _WORTH_NS[unit] / 1e9
        return abs(float(np.log10(step_s / _USUAL_STEP_S)))

    best = min(_WORTH_NS, key=off)
    return best if off(best) < off("s") - _NEARER else "s"


def _usual(units: Mapping[str, str], facts: LogFacts) -> list[PoolChannel]:
    """Return the channels that the names of columns tell, and say whose unit is not known."""
    found = []
    for quantity, choices in data_of("topics")["columns"].items():
        for names in choices:
            fields = [field for name in names if (field := _with_unit(name, units)) is not None]
            if len(fields) == len(names):
                order = {"order": "wxyz"} if quantity == "attitude_quaternion" else {}
                found += _channel(quantity, fields, units, facts, **order)
                break
    for quantity, begins in data_of("topics")["columns_of_thrusters"].items():
        begin = "|".join(begins)  # the longer ones stand first
        columns: dict[str, tuple[str, str]] = {}
        for match in filter(None, (re.fullmatch(rf"({begin})_(.+)", field) for field in units)):
            first, _ = columns.setdefault(match[2], (match[0], begins[match[1]]))
            if first != match[0]:
                both = f'columns "{first}" and "{match[0]}"'
                what = f"{both} may both be {quantity}: the first is taken."
                facts.problems.append(facts.place.warning(what, remedy="Rename the other."))
        for thruster, (field, unit) in columns.items():
            own = {**units, field: units[field] or unit}
            found += _channel(quantity, [field], own, facts, thrusters=(thruster,))
    return found


def _with_unit(name: str, units: Mapping[str, str]) -> str | None:
    """Return the column of a name, which may have a unit at its end."""
    if name in units:
        return name
    return next(
        (field for field in units if re.fullmatch(rf"{name}_(deg|rad|mm|cm|m|v|a|mv)", field)), None
    )


def _channel(
    quantity: str,
    fields: Sequence[str],
    units: Mapping[str, str],
    facts: LogFacts,
    **more: Any,  # noqa: ANN401
) -> list[PoolChannel]:
    """Return a channel; none where its unit is not one of the quantity."""
    unit = units[fields[0]]
    end = fields[0].rsplit("_", 1)[-1]
    if not unit and end in {"deg", "rad", "mm", "cm", "mv"}:
        unit = {"mv": "mV"}.get(end, end)
    stated: dict[str, Any] = {"quantity": quantity, "topic": TABLE, "field": tuple(fields), **more}
    if len({units[field] for field in fields}) > 1:
        what = f"columns {', '.join(fields)} have different units; {quantity} was not read."
        facts.problems.append(facts.place.warning(what, remedy="Write them in one unit."))
        return []
    if unit:
        if unit not in UNITS[quantity]:
            what = f'"{unit}" of column "{fields[0]}" is no unit of {quantity}; it was not read.'
            known = f"one of {', '.join(UNITS[quantity])}."
            facts.problems.append(facts.place.note(what, known, "Correct the head of the column."))
            return []
        stated["unit"] = unit
    return [PoolChannel.model_validate(stated)]
