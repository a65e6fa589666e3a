"""A log of whatever recorder as one thing: its topics, and the wanted numbers of each.

Two kinds: files of messages (`MessageLog`: MCAP, bags of ROS 1 and 2), which are read block by
block, and recordings whose tables are read as a whole (`TableLog`: ArduPilot, PX4, tables in time).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from pipeline.errors import Place, Problem
from pipeline.ingest.data_files import data_of
from pipeline.ingest.message_definitions import Path as FieldPath
from pipeline.ingest.message_fields import NO_STAMP, joined_ns, ticks_ns
from pipeline.ingest.pool_run_extract import MessageFile, Request, TopicData, extract
from pipeline.ingest.pool_run_plan import TopicFound
from pipeline.ingest.pool_run_topics import topics_of
from pipeline.records.pool_schema import PoolChannel
from pipeline.types import FloatArray, IntArray


@dataclass
class LogFacts:
    """What is known of a log as a file.

    `recorder` names the map of `usual`, channels that are usual for its recorder.
    """

    place: Place
    size: int
    read_bytes: int
    complete: bool = True
    writer: str = ""
    metadata: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)
    recorder: str = ""
    usual: tuple[PoolChannel, ...] = ()


def usual_channels(recorder: str) -> tuple[PoolChannel, ...]:
    """Return the channels that are usual for a recorder, the likeliest first."""
    return tuple(PoolChannel.model_validate(one) for one in data_of("recorders")[recorder])


class LogSource(Protocol):
    """A log that was opened."""

    def topics(self, prefix: str) -> list[TopicFound]:
        """Find its topics with one message each."""

    def extract(self, requests: Mapping[str, Request], *, fast: bool) -> dict[str, TopicData]:
        """Take the wanted numbers out of it."""

    def facts(self) -> LogFacts:
        """Say what is known of it by now."""


class _MessageFileOnDisk(MessageFile, Protocol):
    size: int
    read_bytes: int
    place: Place

    @property
    def problems(self) -> list[Problem]:
        """What was found wrong while it was read."""


class MessageLog:
    """A file of messages."""

    def __init__(self, file: _MessageFileOnDisk) -> None:
        """Take a file that was opened."""
        self._file = file
        self._codecs: dict[int, Any] = {}

    def topics(self, prefix: str) -> list[TopicFound]:
        """Find its topics with one message each."""
        self._codecs, found = topics_of(self._file, prefix)
        return found

    def extract(self, requests: Mapping[str, Request], *, fast: bool) -> dict[str, TopicData]:
        """Take the wanted numbers out of it."""
        return extract(self._file, self._codecs, requests, fast=fast)

    def facts(self) -> LogFacts:
        """Say what is known of it by now."""
        file, directory = self._file, self._file.directory
        return LogFacts(
            file.place,
            file.size,
            file.read_bytes,
            directory.complete,
            directory.library,
            dict(directory.metadata),
            file.problems,
        )


@dataclass(frozen=True)
class TopicTable:
    """All messages of one topic: `log_time_ns` (k,) and a column (k,) or (k, m) for each field.

    A field may name a part of a message, ``acc.x``; `texts` are lists of names for (k, m) columns.
    """

    log_time_ns: IntArray
    columns: Mapping[str, npt.NDArray[Any]]
    message_type: str = ""
    texts: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    def tree(self, row: int) -> dict[str, Any]:
        """Return one message as dictionaries, lists and numbers."""
        found: dict[str, Any] = {name: list(texts) for name, texts in self.texts.items()}
        for name, column in self.columns.items():
            here = found
            *above, last = name.split(".")
            for step in above:
                here = here.setdefault(step, {})
            here[last] = column[row].tolist()
        return found

    def column(self, path: FieldPath) -> npt.NDArray[Any] | None:
        """Return the numbers (k,) at a path, None where there are none."""
        names = [step for step in path if isinstance(step, str)]
        column = self.columns.get(".".join(names))
        if column is None:
            return None
        index = [step for step in path if isinstance(step, int)]
        if column.ndim == 1:
            return column if not index else None
        return column[:, index[0]] if len(index) == 1 and index[0] < column.shape[1] else None


class TableLog:
    """A recording whose tables are in memory."""

    def __init__(self, tables: Mapping[str, TopicTable], facts: LogFacts) -> None:
        """Take tables by topic."""
        self._tables = tables
        self._facts = facts

    def topics(self, prefix: str) -> list[TopicFound]:
        """Find its topics with one message each."""
        return [
            TopicFound(
                name,
                (number,),
                table.message_type,
                self._facts.writer,
                table.log_time_ns.size,
                table.tree(0) if table.log_time_ns.size else None,
            )
            for number, (name, table) in enumerate(self._tables.items())
            if name.startswith(prefix)
        ]

    def extract(self, requests: Mapping[str, Request], *, fast: bool) -> dict[str, TopicData]:
        """Take the wanted numbers out of it; there is one way."""
        del fast
        return {topic: _taken(self._tables[topic], one) for topic, one in requests.items()}

    def facts(self) -> LogFacts:
        """Say what is known of it."""
        return replace(self._facts)


def _taken(table: TopicTable, request: Request) -> TopicData:
    count = table.log_time_ns.size
    values: FloatArray = np.full((count, len(request.numbers)), np.nan)
    for number, path in enumerate(request.numbers):
        column = table.column(path)
        if column is not None:
            values[:, number] = column
    names: list[tuple[str, ...]] = []
    name_list = None
    if request.names is not None:
        names = [table.texts.get(str(request.names[0]), ())]
        name_list = np.zeros(count, np.int64)
    return TopicData(
        table.log_time_ns,
        values,
        _stamps(table, request),
        np.zeros(count, np.bool_),
        names,
        name_list,
    )


def _stamps(table: TopicTable, request: Request) -> IntArray | None:
    stamp = request.stamp
    if stamp is None:
        return None
    first = table.column(stamp.first)
    second = None if stamp.nanoseconds is None else table.column(stamp.nanoseconds)
    if first is None or (stamp.nanoseconds is not None and second is None):
        return np.full(table.log_time_ns.size, NO_STAMP)
    time_ns = ticks_ns(first, stamp.unit_ns)
    return time_ns if second is None else joined_ns(time_ns, ticks_ns(second, 1))
