"""Logs of ArduPilot: ``*.BIN`` (data flash) and ``*.tlog`` (MAVLink), read by pymavlink."""

import io
import os
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, redirect_stdout
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from pipeline.errors import InputError, Place
from pipeline.ingest.log_source import LogFacts, TableLog, TopicTable, unreadable, usual_channels
from pipeline.ingest.mcap_records import LATEST_NS
from pipeline.types import IntArray

#: GPS time began on 6 January 1980 and has been ahead of UTC by this much since 2017. [s]
_GPS_EPOCH_S, _LEAP_S = 315_964_800, 18
_WEEK_S = 604_800
#: Functions of outputs that drive motors 1 to 12 -> number of the motor.
_MOTORS = {**{33 + k: 1 + k for k in range(8)}, **{82 + k: 9 + k for k in range(4)}}


def read_bin(path: Path, shown_as: str) -> TableLog:
    """Read a data-flash log: offsets of the messages by pymavlink, their numbers gathered at once.

    Raises `InputError` if it is no such log, or holds no messages.
    """
    place = Place(shown_as)
    size = _size(path, place)
    try:
        from pymavlink import DFReader

        with redirect_stdout(io.StringIO()), _no_stderr():
            reader = DFReader.DFReader_binary(str(path))
        with closing(reader):
            tables = _tables_of_bin(reader)
    except Exception as error:  # noqa: BLE001 - whatever damaged bytes make of it
        raise _unreadable(place, error) from None
    facts = LogFacts(place, size, size, writer="ArduPilot", recorder="the usual map of ArduSub")
    facts.usual = usual_channels("ardupilot_bin")
    return TableLog(tables, facts)


@contextmanager
def _no_stderr() -> Iterator[None]:
    """Drop what the compiled indexer writes to the standard error of the process."""
    sys.stderr.flush()
    kept = os.dup(2)
    try:
        with Path(os.devnull).open("wb") as nowhere:
            os.dup2(nowhere.fileno(), 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)


def _tables_of_bin(reader: Any) -> dict[str, TopicTable]:  # noqa: ANN401  of pymavlink
    data = np.frombuffer(reader.data_map, np.uint8)
    raw: dict[str, dict[str, npt.NDArray[Any]]] = {}
    instances: dict[str, str] = {}
    for number, form in reader.formats.items():
        offsets = np.array(reader.offsets[number], np.int64)
        if offsets.size and "TimeUS" in form.columns:
            raw[form.name] = _columns(data, offsets, form)
            # before 2020 no log says which field counts the instances
            usual = [one for one in ("I", "Instance") if one in form.columns]
            usual += ["C"] if re.match("[XN]K", form.name) and "C" in form.columns else []
            if form.instance_field is not None or usual:
                instances[form.name] = form.instance_field or usual[0]
    base_ns = _gps_base_ns(raw.get("GPS"))
    motors = _motor_outputs(raw.get("PARM"))
    tables: dict[str, TopicTable] = {}
    for name, columns in raw.items():
        time_ns = columns["TimeUS"].astype(np.int64) * 1000 + base_ns
        numbers = {key: one for key, one in columns.items() if one.dtype.kind in "iuf"}
        if name == "RCOU":
            numbers["motors"] = _side_by_side(numbers, motors or _outputs(numbers, "C"), "C{}")
        field = instances.get(name)
        if field is None or field not in numbers:
            tables[name] = TopicTable(time_ns, numbers, name)
            continue
        for one in np.unique(numbers[field]):
            rows = numbers[field] == one
            part = {key: column[rows] for key, column in numbers.items()}
            tables[f"{name}[{int(one)}]"] = TopicTable(time_ns[rows], part, name)
    return tables


def _columns(
    data: npt.NDArray[np.uint8],
    offsets: IntArray,
    form: Any,  # noqa: ANN401  of pymavlink
) -> dict[str, npt.NDArray[Any]]:
    """Gather the fields of all messages of one format; scaled as its format says."""
    codes = re.findall(r"(\d*)([a-zA-Z])", form.msg_struct.lstrip("<"))
    kinds = [f"S{count}" if code == "s" else f"<{_NUMPY[code]}" for count, code in codes]
    kind = np.dtype(list(zip(form.columns, kinds, strict=True)))
    if kind.itemsize + 3 > form.len:
        raise ValueError(f"{form.name} states {form.len} bytes for {kind.itemsize + 3}")
    offsets = offsets[offsets + form.len <= data.size]
    at = np.ndarray((max(data.size - kind.itemsize + 1, 0),), kind, buffer=data, strides=(1,))
    rows = at[offsets + 3]
    found: dict[str, npt.NDArray[Any]] = {}
    for name, factor in zip(form.columns, form.msg_mults, strict=True):
        column = rows[name]
        is_scaled = factor not in (None, 1.0) and column.dtype.kind in "iuf"
        found[name] = column * factor if is_scaled else np.ascontiguousarray(column)
    return found


_NUMPY = {"b": "i1", "B": "u1", "h": "i2", "H": "u2", "i": "i4", "I": "u4", "q": "i8", "Q": "u8",
          "f": "f4", "d": "f8", "c": "i1"}  # fmt: skip


def _gps_base_ns(gps: Mapping[str, npt.NDArray[Any]] | None) -> int:
    """Return the time since 1970 at which the board was started [ns]; 0 where no GPS tells."""
    if gps is None or not {"GWk", "GMS"} <= set(gps):
        return 0
    known = np.flatnonzero(gps["GWk"] > 1000)
    if not known.size:
        return 0
    week, time_ms = int(gps["GWk"][known[0]]), int(gps["GMS"][known[0]])
    seconds = _GPS_EPOCH_S - _LEAP_S + week * _WEEK_S
    return seconds * 10**9 + time_ms * 10**6 - int(gps["TimeUS"][known[0]]) * 1000


def _motor_outputs(parameters: Mapping[str, npt.NDArray[Any]] | None) -> list[int]:
    """Return the outputs of motors 1, 2, ... as SERVOn_FUNCTION has them; none where not told."""
    if parameters is None or not {"Name", "Value"} <= set(parameters):
        return []
    names = [bytes(name).rstrip(b"\0").decode("ascii", "replace") for name in parameters["Name"]]
    return _by_function(zip(names, parameters["Value"].tolist(), strict=True))


def _by_function(parameters: Any) -> list[int]:  # noqa: ANN401  pairs of name and value
    found: dict[int, int] = {}
    for name, value in parameters:
        match = re.fullmatch(r"SERVO(\d+)_FUNCTION", name)
        if match is not None and int(value) in _MOTORS:
            found[_MOTORS[int(value)]] = int(match[1])
    return [found[motor] for motor in sorted(found)]


def _outputs(columns: Mapping[str, npt.NDArray[Any]], begin: str, end: str = "") -> list[int]:
    matches = [re.fullmatch(rf"{begin}(\d+){end}", name) for name in columns]
    return sorted(int(match[1]) for match in matches if match is not None)


def _side_by_side(
    columns: Mapping[str, npt.NDArray[Any]], numbers: Sequence[int], name: str
) -> npt.NDArray[Any]:
    there = [columns[name.format(one)] for one in numbers if name.format(one) in columns]
    return np.stack(there, axis=1) if there else np.zeros((0, 0))


def read_tlog(path: Path, shown_as: str) -> TableLog:
    """Read a telemetry log of MAVLink: the messages of the vehicle, not of the ground station.

    Raises `InputError` if it holds no messages of a vehicle.
    """
    place = Place(shown_as)
    size = _size(path, place)
    try:
        with redirect_stdout(io.StringIO()):
            parts = _messages_of_tlog(path)
    except Exception as error:  # noqa: BLE001 - whatever damaged bytes make of it
        raise _unreadable(place, error) from None
    tables = {name: _table_of_tlog(name, *part, parts) for name, part in parts.items()}
    facts = LogFacts(place, size, size, writer="MAVLink", recorder="the usual map of ArduSub")
    facts.usual = usual_channels("ardupilot_tlog")
    return TableLog(tables, facts)


_Part = tuple[list[int], dict[str, list[Any]]]


def _messages_of_tlog(path: Path) -> dict[str, _Part]:
    """Return type -> log times [ns] and fields of all messages of the vehicle."""
    from pymavlink import mavutil

    log = mavutil.mavlogfile(str(path))
    by_system: dict[int, dict[str, _Part]] = {}
    vehicle: int | None = None
    try:
        while (message := log.recv_msg()) is not None:
            kind, system = message.get_type(), message.get_srcSystem()
            time_us = message._timestamp * 1e6  # noqa: SLF001 - its only name
            if kind == "BAD_DATA" or kind.startswith("UNKNOWN") or not time_us * 1e3 < LATEST_NS:
                continue
            if vehicle is None and kind == "HEARTBEAT" and message.type != _GROUND_STATION:
                vehicle = system
            times, fields = by_system.setdefault(system, {}).setdefault(kind, ([], {}))
            times.append(round(time_us) * 1000)
            for name in message.fieldnames:
                fields.setdefault(name, []).append(getattr(message, name))
    finally:
        log.close()
    if vehicle is None and by_system:
        vehicle = max(by_system, key=lambda one: sum(len(p[0]) for p in by_system[one].values()))
    return by_system.get(vehicle, {}) if vehicle is not None else {}


_GROUND_STATION = 6


def _table_of_tlog(
    kind: str, times: list[int], fields: Mapping[str, list[Any]], parts: Mapping[str, _Part]
) -> TopicTable:
    columns: dict[str, npt.NDArray[Any]] = {}
    for name, values in fields.items():
        if len(values) == len(times) and isinstance(values[0], int | float | list):
            try:
                column = np.array(values)
            except ValueError:
                continue
            if column.dtype.kind in "iuf":
                columns[name] = column
    if kind == "SERVO_OUTPUT_RAW":
        names = parts.get("PARAM_VALUE", ([], {}))[1]
        motors = _by_function(
            zip(map(str, names.get("param_id", ())), names.get("param_value", ()), strict=False)
        )
        outputs = motors or _outputs(columns, "servo", "_raw")
        columns["motors"] = _side_by_side(columns, outputs, "servo{}_raw")
    return TopicTable(np.array(times, np.int64), columns, kind)


def _size(path: Path, place: Place) -> int:
    try:
        with path.open("rb") as file:
            size = file.seek(0, 2)
    except OSError as error:
        raise _unreadable(place, error.strerror or error) from None
    if size == 0:
        raise InputError.at(place, "the file is empty.", remedy="Copy the log again.")
    return size


def _unreadable(place: Place, why: object) -> InputError:
    expected = "a data-flash log (*.BIN) or a telemetry log (*.tlog)."
    return unreadable(place, "ArduPilot", why, expected)
