"""Take the wanted numbers of the wanted topics out of a log, block by block.

Only these numbers and two times a message stay in memory, however large the log is.
"""

import functools
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from pipeline.ingest.mcap_chunk import Bytes, ChunkBlock, Messages, at_every_byte
from pipeline.ingest.mcap_gather import Layout, Layouts
from pipeline.ingest.message_definitions import BrokenMessageError, Path
from pipeline.ingest.message_fields import (
    NO_STAMP,
    Stamp,
    number_of_text,
    stamp_of,
    stamps_of,
)
from pipeline.ingest.pool_run_codec import Codec, unpacked, value_at
from pipeline.types import BoolArray, FloatArray, IntArray

if TYPE_CHECKING:
    from pipeline.ingest.log_source import MessageLog

_MOST_NAME_LISTS = 1000
#: A message of more bytes is not decoded by itself: no rig writes a vehicle's state like that.
_MAX_MESSAGE_BYTES = 16_000_000


@dataclass(frozen=True)
class Request:
    """What is wanted of a topic: numbers, the time, the names of an array's elements."""

    numbers: tuple[Path, ...]
    stamp: Stamp | None = None
    names: Path | None = None
    flags: frozenset[Path] = frozenset()
    """Which of the numbers may be words, too."""


@dataclass
class TopicData:
    """What was taken from a topic, in the order of the file.

    `values` (k, m), NaN where a message lacks a number; `names` are the lists of names met and
    `name_list` (k,) says which one a message has; `why_broken` is the first reason.
    """

    log_time_ns: IntArray
    values: FloatArray
    stamp_ns: IntArray | None
    broken: BoolArray
    names: list[tuple[str, ...]] = field(default_factory=list)
    name_list: IntArray | None = None
    why_broken: str = ""


def extract(
    log: "MessageLog", codecs: Mapping[int, Codec], requests: Mapping[str, Request]
) -> dict[str, TopicData]:
    """Read a log once, for what is wanted of each topic; `codecs` are by channel (id)."""
    channels = log.directory.channels
    expected = dict.fromkeys(requests, 0)
    for number, channel in channels.items():
        if channel.topic in expected:
            expected[channel.topic] += log.directory.counts.get(number, 0)
    sinks = {topic: Sink(request, expected[topic]) for topic, request in requests.items()}
    by_channel = {
        number: (sinks[channel.topic], _Reader(codecs[number]))
        for number, channel in channels.items()
        if channel.topic in requests and number in codecs
    }
    for block in log.blocks(frozenset(by_channel)):
        for number, messages in _in_order(block, by_channel):
            sink, reader = by_channel[number]
            reader.read(block.data, messages, sink)
    return {topic: sink.finish() for topic, sink in sinks.items()}


def _in_order(
    block: ChunkBlock, by_channel: Mapping[int, tuple["Sink", "_Reader"]]
) -> Sequence[tuple[int, Messages]]:
    """Channels of a block; those that share a topic are parted where they take turns."""
    wanted = [(number, part) for number, part in block.messages.items() if number in by_channel]
    if len({id(by_channel[number][0]) for number, _ in wanted}) == len(wanted):  # or none
        return wanted
    # several publishers of one topic: message by message in the order of the file
    number = np.repeat([name for name, _ in wanted], [part.start.size for _, part in wanted])
    parts = [np.stack([part.log_time_ns, part.start, part.size]) for _, part in wanted]
    order = np.argsort(np.concatenate([part.start for _, part in wanted]), kind="stable")
    number, every = number[order], np.concatenate(parts, axis=1)[:, order]
    rows = np.split(np.arange(number.size), np.flatnonzero(np.diff(number)) + 1)
    return [(int(number[some[0]]), Messages(*every[:, some])) for some in rows]


#: Messages for which there is room before any was read: a file may claim any number.
_MOST_EXPECTED = 5_000_000


#: What was taken from messages, by name: time_ns (k,), values (k, m), broken (k,), and stamp_ns
#: (k,) and names (k,) where they are wanted.
_Columns = dict[str, np.ndarray[Any, Any]]


class Sink:
    """What was taken from a topic so far, in arrays that grow: parts would be in memory twice."""

    def __init__(self, request: Request, expected: int) -> None:
        """Begin with room for the messages that are expected."""
        self.request = request
        self._all, self._used = self._made(min(expected, _MOST_EXPECTED)), 0
        self.names: list[tuple[str, ...]] = []
        self.why_broken = ""

    def room(self, log_time_ns: IntArray) -> _Columns:
        """Make room for more messages and return it, to be filled."""
        begin, self._used = self._used, self._used + log_time_ns.size
        if self._used > self._all["time_ns"].size:
            grown = self._made(max(self._used, self._all["time_ns"].size * 3 // 2))
            for name, column in grown.items():
                column[:begin] = self._all[name][:begin]
            self._all = grown
        part = {name: column[begin : self._used] for name, column in self._all.items()}
        part["time_ns"][:] = log_time_ns
        return part

    def fill(
        self,
        rows: _Columns,
        where: IntArray | slice,
        count: int,
        column: Callable[[Path], npt.NDArray[Any] | None],
    ) -> None:
        """Fill some of the rows from numbers (k,) by their paths."""
        for number, path in enumerate(self.request.numbers):
            found = column(path)
            rows["values"][where, number] = np.nan if found is None else found
        if self.request.stamp is not None:
            rows["stamp_ns"][where] = stamps_of(column, self.request.stamp, count)

    def name_list(self, names: tuple[str, ...]) -> int:
        """Return the number of a list of names, -1 beyond the most that are kept."""
        if names not in self.names:
            if len(self.names) >= _MOST_NAME_LISTS:
                return -1
            self.names.append(names)
        return self.names.index(names)

    def break_off(self, rows: _Columns, row: int, why: str) -> None:
        """Mark a message that cannot be decoded."""
        nothing = {"values": np.nan, "broken": True, "stamp_ns": NO_STAMP, "names": -1}
        for name in rows.keys() & nothing.keys():
            rows[name][row] = nothing[name]
        self.why_broken = self.why_broken or why

    def finish(self) -> TopicData:
        """Return all that was taken."""
        rows = {name: column[: self._used] for name, column in self._all.items()}
        names, stamps = rows.get("names"), rows.get("stamp_ns")
        own = (rows["time_ns"], rows["values"], stamps, rows["broken"])
        return TopicData(*own, self.names, names, self.why_broken)

    def _made(self, count: int) -> _Columns:
        wanted = {"stamp_ns": self.request.stamp, "names": self.request.names}
        return {
            "time_ns": np.empty(count, np.int64),
            "values": np.empty((count, len(self.request.numbers))),
            "broken": np.zeros(count, np.bool_),
            **{name: np.empty(count, np.int64) for name, one in wanted.items() if one},
        }


class _Reader:
    """Reads the messages of one channel."""

    def __init__(self, codec: Codec) -> None:
        self._codec = codec
        self._layouts = None if codec.definition is None else Layouts(codec.definition)

    def read(self, buffer: Bytes, messages: Messages, sink: Sink) -> None:
        """Read the channel's messages of a block."""
        rows = sink.room(messages.log_time_ns)
        if self._layouts is None:
            self._read_each(buffer, messages, rows, sink)
            return
        if self._codec.packed:
            buffer, messages = _unpacked(buffer, messages)
        groups, faults = self._layouts.groups(buffer, messages.start, messages.size)
        for group, layout in groups:
            start = messages.start[group]

            def column(
                path: Path, layout: Layout = layout, start: IntArray = start
            ) -> npt.NDArray[Any] | None:
                if path in layout.texts:
                    begin, size = layout.texts[path]
                    texts = at_every_byte(buffer, np.dtype(f"S{max(size, 1)}"))[start + begin]
                    is_flag = path in sink.request.flags
                    return np.array([_of_word(one, is_flag=is_flag) for one in texts.tolist()])
                place = layout.place(path)
                if place is None:
                    return None
                return at_every_byte(buffer, place.kind)[start + place.offset]

            # of a block whose messages are all alike no index needs to be made
            where = slice(None) if group.size == messages.start.size else group
            sink.fill(rows, where, start.size, column)
            if sink.request.names is not None:
                rows["names"][where] = _gather_names(buffer, start, layout, sink)
        for row, why in sorted(faults.items()):
            sink.break_off(rows, row, why)

    def _read_each(self, buffer: Bytes, messages: Messages, rows: _Columns, sink: Sink) -> None:
        request = sink.request
        for row, (begin, size) in enumerate(
            zip(messages.start.tolist(), messages.size.tolist(), strict=True)
        ):
            tree, why = None, f"it has {size} bytes"
            if size <= _MAX_MESSAGE_BYTES:
                try:
                    tree = self._codec.decode(buffer[begin : begin + size].tobytes())
                except BrokenMessageError as error:
                    why = str(error)
            if tree is None:
                sink.break_off(rows, row, why)
                continue
            for column, path in enumerate(request.numbers):
                value = value_at(tree, path)
                rows["values"][row, column] = _number(value, is_flag=path in request.flags)
            if request.stamp is not None:
                rows["stamp_ns"][row] = stamp_of(tree, request.stamp)
            if request.names is not None:
                found = value_at(tree, request.names)
                texts = found if isinstance(found, list) else []
                rows["names"][row] = sink.name_list(tuple(str(text) for text in texts))


def _gather_names(buffer: Bytes, start: IntArray, layout: Layout, sink: Sink) -> IntArray:
    path = sink.request.names or ()
    parts: list[tuple[int, int]] = []
    while (*path, len(parts)) in layout.texts:
        parts.append(layout.texts[(*path, len(parts))])
    if not parts:
        return np.full(start.size, sink.name_list(()))
    begin, end = parts[0][0], sum(parts[-1])
    every = at_every_byte(buffer, np.dtype(f"S{max(end - begin, 1)}"))[start + begin]
    found, left = np.full(start.size, -1), np.arange(start.size)
    for _ in range(_MOST_NAME_LISTS):
        if not left.size:
            break
        first = every[left[0]]
        names = [bytes(first)[at - begin : at - begin + size] for at, size in parts]
        texts = (name.rstrip(b"\x00").decode("utf-8", errors="replace") for name in names)
        same = every[left] == first
        found[left[same]] = sink.name_list(tuple(texts))
        left = left[~same]
    return found


def _unpacked(buffer: Bytes, messages: Messages) -> tuple[Bytes, Messages]:
    """Unpack messages that are compressed one by one; one that is broken becomes empty."""
    parts = []
    for begin, size in zip(messages.start.tolist(), messages.size.tolist(), strict=True):
        parts.append(b"")
        with suppress(BrokenMessageError):
            parts[-1] = unpacked(buffer[begin : begin + size].tobytes())
    sizes = np.array([len(part) for part in parts], np.int64)
    whole = np.frombuffer(b"".join(parts), np.uint8)
    return whole, Messages(messages.log_time_ns, np.cumsum(sizes) - sizes, sizes)


@functools.lru_cache(maxsize=4096)
def _of_word(text: bytes, *, is_flag: bool) -> float:
    return _number(text.rstrip(b"\x00").decode("utf-8", errors="replace"), is_flag=is_flag)


def _number(value: object, *, is_flag: bool) -> float:
    if isinstance(value, str):  # JSON has no NaN, and protobuf's JSON writes it as text
        value = number_of_text(value, is_flag=is_flag)
    try:
        return float(value) if isinstance(value, bool | int | float) else float("nan")
    except OverflowError:
        return float("nan")
