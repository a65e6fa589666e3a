"""Logs of PX4: ``*.ulg``, read by pyulog."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from pipeline.ingest.log_source import LogFacts, TableLog, TopicTable, read_recording

_ELEMENT = re.compile(r"(.*?)\[(\d+)\](.*)")
_MOST_ELEMENTS = 64


def read_ulg(path: Path, shown_as: str) -> TableLog:
    """Read a ULog file; raises `InputError` if it is none, or cannot be read."""
    return read_recording(path, shown_as, "px4", "PX4", _tables)


def _tables(path: Path, facts: LogFacts) -> dict[str, TopicTable]:
    from pyulog import ULog

    with path.open("rb") as file:  # the library leaves a file open that it cannot read
        log = ULog(file)
    if log.file_corruption:
        facts.complete = False
        what = "the log is damaged: what could be read was read, and the rest left out."
        facts.problems.append(facts.place.warning(what))
    base_ns = _base_ns(log)
    return {
        (one.name if one.multi_id == 0 else f"{one.name}[{one.multi_id}]"): TopicTable(
            one.data["timestamp"].astype(np.int64) * 1000 + base_ns, _columns(one.data), one.name
        )
        for one in log.data_list
        if "timestamp" in one.data
    }


def _base_ns(log: Any) -> int:  # noqa: ANN401  of pyulog
    """Return the time since 1970 at which the board was started [ns]; 0 where no GPS tells."""
    for one in log.data_list:
        known = np.flatnonzero(one.data.get("time_utc_usec", np.zeros(0)) > 0)
        if known.size:
            utc, board = (one.data[name][known[0]] for name in ("time_utc_usec", "timestamp"))
            return (int(utc) - int(board)) * 1000
    return 0


def _columns(data: Mapping[str, npt.NDArray[Any]]) -> dict[str, npt.NDArray[Any]]:
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
