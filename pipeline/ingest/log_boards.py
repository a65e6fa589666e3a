"""Logs of boards: ArduPilot (``*.BIN``, ``*.tlog``; pymavlink) and PX4 (``*.ulg``; pyulog)."""

import os
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from pipeline.ingest.log_source import LogFacts, TableLog, TopicTable, read_recording
from pipeline.ingest.mcap_records import LATEST_NS
from pipeline.types import IntArray

#: GPS time began on 6 January 1980 and has been ahead of UTC by this much since 2017. [s]
_GPS_EPOCH_S, _LEAP_S = 315_964_800, 18
_WEEK_S = 604_800
#: Functions of outputs that drive motors 1 to 12 -> number of the motor.
_MOTORS = {**{33 + k: 1 + k for k in range(8)}, **{82 + k: 9 + k for k in range(4)}}


def read_bin(path: Path, shown_as: str) -> TableLog:
    """Read a data-flash log, its numbers gathered at once; raises `InputError`."""
    return read_recording(path, shown_as, "ardupilot_bin", "ArduPilot", _tables_of_bin)


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


def _tables_of_bin(path: Path, facts: LogFacts) -> dict[str, TopicTable]:
    from pymavlink import DFReader

    with _no_stderr():
        reader = DFReader.DFReader_binary(str(path))
    with closing(reader):
        return _tables_of(reader, facts)


def _tables_of(reader: Any, facts: LogFacts) -> dict[str, TopicTable]:  # noqa: ANN401  of pymavlink
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
    parameters = raw.get("PARM", {})
    told: list[tuple[int, str, float]] = []
    if {"Name", "Value"} <= set(parameters):
        seconds = parameters["TimeUS"].astype(np.int64) * 1000 + base_ns
        names = [bytes(one).rstrip(b"\0").decode("ascii", "replace") for one in parameters["Name"]]
        told = list(zip(seconds.tolist(), names, parameters["Value"].tolist(), strict=True))
    tables: dict[str, TopicTable] = {}
    for name, columns in raw.items():
        time_ns = columns["TimeUS"].astype(np.int64) * 1000 + base_ns
        numbers = {key: one for key, one in columns.items() if one.dtype.kind in "iuf"}
        if name == "RCOU":
            outputs = dict(numbers)
            for more in (raw.get("RCO2", {}), raw.get("RCO3", {})):  # outputs 15 and on
                outputs |= {key: one for key, one in more.items() if one.size == time_ns.size}
            numbers["motors"] = _motors(outputs, time_ns, told, "C{}", facts)
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


def _motors(
    columns: Mapping[str, npt.NDArray[Any]],
    time_ns: IntArray,
    parameters: Iterable[tuple[int, str, float]],
    name: str,
    facts: LogFacts,
) -> npt.NDArray[Any]:
    """Put the outputs of motors 1, 2, ... side by side (k, motors).

    Parameters SERVOn_FUNCTION, (time, name, value), say which these are: the first value of one
    from the start on, a later one from its time on. Without any all outputs are taken in their
    order, which is said. An output that was not logged has no numbers.
    """
    wired: dict[int, list[tuple[int, int]]] = {}
    for at_ns, parameter, value in parameters:
        if match := re.fullmatch(r"SERVO(\d+)_FUNCTION", parameter):
            drives = wired.setdefault(int(match[1]), [])
            if not drives or drives[-1][1] != int(value):
                drives.append((at_ns if drives else 0, int(value)))
    motors = sorted({_MOTORS[one] for by in wired.values() for _, one in by if one in _MOTORS})
    if not motors:
        matches = [re.fullmatch(name.format(r"(\d+)"), column) for column in columns]
        every = sorted(int(match[1]) for match in matches if match is not None)
        if not every:
            return np.zeros((0, 0))
        what = (
            f"no parameter SERVOn_FUNCTION says which output drives which motor: the "
            f"outputs from {every[0]} on are taken for the thrusters in their order."
        )
        remedy = "Log the parameters, or state the outputs under pool: channels in vehicle.yaml."
        facts.problems.append(facts.place.note(what, remedy=remedy))
        return np.stack([columns[name.format(one)] for one in every], axis=1)
    found = np.full((time_ns.size, len(motors)), np.nan)
    for output, drives in wired.items():
        column = columns.get(name.format(output), np.full(time_ns.size, np.nan))
        for begin_ns, function in drives:
            if function in _MOTORS:
                later = [at_ns for at_ns, _ in drives if at_ns > begin_ns]
                rows = (time_ns >= begin_ns) & (time_ns < min(later, default=LATEST_NS))
                found[rows, motors.index(_MOTORS[function])] = column[rows]
    if changes := {output: drives[1][0] for output, drives in wired.items() if len(drives) > 1}:
        changed = ", ".join(f"SERVO{output}_FUNCTION" for output in changes)
        after_s = (min(changes.values()) - int(time_ns[0])) / 1e9
        what = (
            f"{changed} change in the log, first {after_s:.1f} s after the first command: outputs "
            "are those of the motors at their time."
        )
        facts.problems.append(facts.place.warning(what))
    return found


def read_tlog(path: Path, shown_as: str) -> TableLog:
    """Read a telemetry log of MAVLink, the messages of the vehicle; raises `InputError`."""
    return read_recording(path, shown_as, "ardupilot_tlog", "ArduPilot", _tables_of_tlog)


def _tables_of_tlog(path: Path, facts: LogFacts) -> dict[str, TopicTable]:
    facts.writer = "MAVLink"
    parts = _messages_of_tlog(path, facts)
    return {name: _table_of_tlog(name, *part, parts, facts) for name, part in parts.items()}


_Part = tuple[list[int], dict[str, list[Any]]]
#: Type of message, component that sent it, port of its outputs.
_Source = tuple[str, int, int]
#: What a HEARTBEAT says of a ground station, a camera, a companion computer: no autopilot.
_NO_AUTOPILOT, _GROUND_STATION, _SUBMARINE = 8, 6, 12


def _messages_of_tlog(path: Path, facts: LogFacts) -> dict[str, _Part]:
    """Return type -> log times [ns] and fields of all messages of the vehicle.

    Those of its other components, and of outputs beyond the first port, have their number behind.
    """
    from pymavlink import mavutil

    by_system: dict[int, dict[_Source, _Part]] = {}
    autopilots: dict[tuple[int, int], int] = {}
    with closing(mavutil.mavlogfile(str(path))) as log:
        while (message := log.recv_msg()) is not None:
            kind, system = message.get_type(), message.get_srcSystem()
            time_us = message._timestamp * 1e6  # noqa: SLF001 - its only name
            if kind == "BAD_DATA" or kind.startswith("UNKNOWN") or not time_us * 1e3 < LATEST_NS:
                continue
            component = message.get_srcComponent()
            if (
                kind == "HEARTBEAT"
                and message.autopilot != _NO_AUTOPILOT
                and message.type != _GROUND_STATION
            ):
                autopilots[system, component] = message.type
            source = (kind, component, getattr(message, "port", 0))
            times, fields = by_system.setdefault(system, {}).setdefault(source, ([], {}))
            times.append(round(time_us) * 1000)
            for name in message.fieldnames:
                fields.setdefault(name, []).append(getattr(message, name))
    if not by_system:
        return {}
    system, own = _autopilot(by_system, autopilots, facts)
    return {
        "".join([kind, f"[{component}]" * (component != own), f"[{port}]" * (port != 0)]): part
        for (kind, component, port), part in by_system[system].items()
    }


def _autopilot(
    by_system: Mapping[int, Mapping[_Source, _Part]],
    autopilots: Mapping[tuple[int, int], int],
    facts: LogFacts,
) -> tuple[int, int]:
    """Return system and component of the vehicle: of several a submarine, or who says most."""
    said = {one: sum(len(part[0]) for part in by_system[one].values()) for one in by_system}
    known = autopilots or {(max(by_system, key=lambda one: said[one]), 1): _SUBMARINE}
    best = max(known, key=lambda one: (known[one] == _SUBMARINE, said[one[0]], -one[1]))
    others = sorted({system for system, _ in known} - {best[0]})
    if others:
        what = (
            f"the log has messages of vehicles {', '.join(map(str, others))} too: those of system "
            f"{best[0]} are taken, as a {'submarine' if known[best] == _SUBMARINE else 'vehicle'} "
            f"with {said[best[0]]} messages."
        )
        facts.problems.append(facts.place.warning(what))
    return best


def _table_of_tlog(
    kind: str,
    times: list[int],
    fields: Mapping[str, list[Any]],
    parts: Mapping[str, _Part],
    facts: LogFacts,
) -> TopicTable:
    columns: dict[str, npt.NDArray[Any]] = {}
    for name, values in fields.items():
        if len(values) == len(times) and isinstance(values[0], int | float | list):
            with suppress(ValueError):
                column = np.array(values)
                if column.dtype.kind in "iuf":
                    columns[name] = column
    if kind == "SERVO_OUTPUT_RAW":
        seconds, own = parts.get("PARAM_VALUE", ([], {}))
        told = zip(
            seconds, map(str, own.get("param_id", ())), own.get("param_value", ()), strict=False
        )
        columns["motors"] = _motors(columns, np.array(times, np.int64), told, "servo{}_raw", facts)
    return TopicTable(np.array(times, np.int64), columns, kind.split("[", maxsplit=1)[0])


_ELEMENT = re.compile(r"(.*?)\[(\d+)\](.*)")
_MOST_ELEMENTS = 64


def read_ulg(path: Path, shown_as: str) -> TableLog:
    """Read a ULog file; raises `InputError` if it is none, or cannot be read."""
    return read_recording(path, shown_as, "px4", "PX4", _tables_of_ulg)


def _tables_of_ulg(path: Path, facts: LogFacts) -> dict[str, TopicTable]:
    from pyulog import ULog

    with path.open("rb") as file:  # the library leaves a file open that it cannot read
        log = ULog(file)
    if log.file_corruption:
        facts.complete = False
        what = "the log is damaged: what could be read was read, and the rest left out."
        facts.problems.append(facts.place.warning(what))
    base_ns = _base_of_ulg_ns(log)
    return {
        (one.name if one.multi_id == 0 else f"{one.name}[{one.multi_id}]"): TopicTable(
            one.data["timestamp"].astype(np.int64) * 1000 + base_ns,
            _side_by_side(one.data),
            one.name,
        )
        for one in log.data_list
        if "timestamp" in one.data
    }


def _base_of_ulg_ns(log: Any) -> int:  # noqa: ANN401  of pyulog
    """Return the time since 1970 at which the board was started [ns]; 0 where no GPS tells."""
    for one in log.data_list:
        known = np.flatnonzero(one.data.get("time_utc_usec", np.zeros(0)) > 0)
        if known.size:
            utc, board = (one.data[name][known[0]] for name in ("time_utc_usec", "timestamp"))
            return (int(utc) - int(board)) * 1000
    return 0


def _side_by_side(data: Mapping[str, npt.NDArray[Any]]) -> dict[str, npt.NDArray[Any]]:
    """Put elements side by side: ``q[0]`` ... become ``q``, ``esc[0].rpm`` ... ``esc.rpm``."""
    found: dict[str, npt.NDArray[Any]] = {}
    arrays: dict[str, dict[int, npt.NDArray[Any]]] = {}
    for name, column in data.items():
        match = _ELEMENT.fullmatch(name)
        if match is None:
            found[name] = column
        elif "[" not in match[3] and int(match[2]) < _MOST_ELEMENTS:
            arrays.setdefault(match[1] + match[3], {})[int(match[2])] = column
    for name, columns in arrays.items():
        if sorted(columns) == list(range(len(columns))):
            found[name] = np.stack([columns[index] for index in range(len(columns))], axis=1)
    return found
