"""Logs of PX4: ``*.ulg``, read by pyulog."""

import io
import re
from collections.abc import Mapping
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from pipeline.errors import Place
from pipeline.ingest.log_source import LogFacts, TableLog, TopicTable, unreadable, usual_channels

_ELEMENT = re.compile(r"(.*?)\[(\d+)\](.*)")
_MOST_ELEMENTS = 64


def read_ulg(path: Path, shown_as: str) -> TableLog:
    """Read a ULog file.

    Raises `InputError` if it is none, or cannot be read.
    """
    place = Place(shown_as)
    try:
        from pyulog import ULog

        # the library leaves a file open that it cannot read, and prints what it thinks
        with path.open("rb") as file, redirect_stdout(io.StringIO()):
            log = ULog(file)
        size = path.stat().st_size
    except Exception as error:  # noqa: BLE001 - whatever damaged bytes make of it
        raise unreadable(place, "PX4", error, "a ULog file (*.ulg).") from None
    base_ns = _base_ns(log)
    tables = {
        (one.name if one.multi_id == 0 else f"{one.name}[{one.multi_id}]"): TopicTable(
            one.data["timestamp"].astype(np.int64) * 1000 + base_ns,
            _columns(one.data),
            one.name,
        )
        for one in log.data_list
        if "timestamp" in one.data
    }
    facts = LogFacts(place, size, size, writer="PX4", recorder="the usual map of PX4")
    if log.file_corruption:
        facts.complete = False
        what = "the log is damaged: what could be read was read, and the rest left out."
        facts.problems.append(place.warning(what))
    facts.usual = usual_channels("px4")
    return TableLog(tables, facts)


def _base_ns(log: Any) -> int:  # noqa: ANN401  of pyulog
    """Return the time since 1970 at which the board was started [ns]; 0 where no GPS tells."""
    for one in log.data_list:
        utc = one.data.get("time_utc_usec")
        if (utc is not None and one.name.endswith("gps_position")) or utc is not None:
            known = np.flatnonzero(utc > 0)
            if known.size:
                first = known[0]
                return (int(utc[first]) - int(one.data["timestamp"][first])) * 1000
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
