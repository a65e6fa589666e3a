"""Bags of ROS: ``*.bag`` (ROS 1, read by rosbags) and ``*.db3`` (ROS 2 in SQLite) as MCAP is read.

Their messages are what MCAP holds too, so they become the same blocks of bytes: numbers are
gathered from them at once, and nothing is converted.
"""

import sqlite3
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np

from pipeline.errors import InputError, Place, Problem
from pipeline.ingest.mcap_chunk import ChunkBlock, Messages
from pipeline.ingest.mcap_directory import Directory
from pipeline.ingest.mcap_faults import LogFaults
from pipeline.ingest.mcap_records import ChannelRecord, SchemaRecord

#: Messages are put together to blocks of about this size.
_BLOCK_BYTES = 4 * 1024 * 1024
_Row = tuple[int, int, bytes]


class BagFile:
    """A bag on disk: its topics, and its messages in the order of the file."""

    def __init__(self, path: Path, shown_as: str) -> None:
        """Read what it holds; subclasses fill `directory`."""
        self.path = path
        self.place = Place(shown_as)
        self.directory = Directory(complete=True)
        self.size = path.stat().st_size if path.is_file() else 0
        self.read_bytes = self.size
        self._faults = LogFaults(self.place)

    @property
    def problems(self) -> list[Problem]:
        """What was found wrong while it was read."""
        return self._faults.problems

    def blocks(self, wanted: frozenset[int]) -> Iterator[ChunkBlock]:
        """Yield the messages of some channels in the order of the file."""
        rows: list[_Row] = []
        size = 0
        for row in self._rows(wanted):
            rows.append(row)
            size += len(row[2])
            if size >= _BLOCK_BYTES:
                yield _block(rows)
                rows, size = [], 0
        if rows:
            yield _block(rows)

    def _rows(self, wanted: frozenset[int]) -> Iterator[_Row]:
        """Yield channel, log time [ns] and bytes of each message."""
        raise NotImplementedError

    def _add(self, number: int, topic: str, kind: str, definition: str, wire: str) -> None:
        """Add a topic that is not yet counted."""
        language = "ros1msg" if wire == "ros1" else "ros2msg"
        self.directory.schemas[number] = SchemaRecord(number, kind, language, definition.encode())
        self.directory.channels[number] = ChannelRecord(number, number, topic, wire, {})

    def _unreadable(self, why: object, remedy: str) -> InputError:
        return InputError.at(
            self.place,
            f"the bag cannot be read: {' '.join(str(why).split())[:200]}.",
            expected="a bag that its recorder closed.",
            remedy=remedy,
        )


def _block(rows: list[_Row]) -> ChunkBlock:
    size = np.array([len(data) for _, _, data in rows], np.int64)
    start = np.concatenate([[0], np.cumsum(size)[:-1]]).astype(np.int64)
    number = np.array([channel for channel, _, _ in rows])
    time = np.array([time for _, time, _ in rows], np.int64)
    messages: Mapping[int, Messages] = {
        int(one): Messages(time[number == one], start[number == one], size[number == one])
        for one in np.unique(number)
    }
    data = np.frombuffer(b"".join(data for _, _, data in rows), np.uint8)
    return ChunkBlock(data, messages)


class Ros1Bag(BagFile):
    """A bag of ROS 1."""

    _REMEDY = "rosbag reindex, or rosbag fix, mends a bag that was not closed."

    def __init__(self, path: Path, shown_as: str) -> None:
        """Read its index.

        Raises
        ------
        InputError
            If it is no bag, or has no index.
        """
        super().__init__(path, shown_as)
        self.directory.library = "rosbag"
        with self._reader() as reader:
            for connection in reader.connections:
                kind = connection.msgtype.replace("/msg/", "/")
                text = connection.msgdef.data
                self._add(connection.id, connection.topic, kind, text, "ros1")
                self.directory.counts[connection.id] = connection.msgcount

    def _reader(self) -> Any:  # noqa: ANN401  of rosbags
        from rosbags.rosbag1 import Reader, ReaderError

        reader = Reader(self.path)
        try:
            reader.open()
        except (ReaderError, OSError, ValueError, KeyError, AssertionError) as error:
            raise self._unreadable(error, self._REMEDY) from None
        return _Closing(reader)

    def _rows(self, wanted: frozenset[int]) -> Iterator[_Row]:
        with self._reader() as reader:
            chosen = [one for one in reader.connections if one.id in wanted]
            try:
                # without connections all would come
                for connection, time_ns, data in reader.messages(chosen) if chosen else ():
                    yield connection.id, time_ns, data
            except Exception as error:  # noqa: BLE001 - whatever compressed bytes make of it
                self._faults.add(f"the bag is damaged: {error}; what follows was left out.")


class _Closing:
    """Closes a reader that was opened."""

    def __init__(self, reader: Any) -> None:  # noqa: ANN401  of rosbags
        self._reader = reader

    def __enter__(self) -> Any:  # noqa: ANN401  of rosbags
        return self._reader

    def __exit__(self, *_: object) -> None:
        self._reader.close()


class Ros2Database(BagFile):
    """A bag of ROS 2 in SQLite; it is opened for reading alone, and nothing is left beside it."""

    _REMEDY = "ros2 bag reindex, or sqlite3 FILE .recover, mends a bag that was not closed."

    def __init__(self, path: Path, shown_as: str) -> None:
        """Read its topics.

        Raises
        ------
        InputError
            If it is no database, or not one of ros2 bag.
        """
        super().__init__(path, shown_as)
        self.directory.library = "ros2 bag"
        try:
            with _Closing(self._open()) as database:
                definitions = self._definitions(database)
                counts = dict(
                    database.execute("SELECT topic_id, COUNT(*) FROM messages GROUP BY topic_id")
                )
                for number, topic, kind, wire in database.execute(
                    "SELECT id, name, type, serialization_format FROM topics"
                ):
                    self._add(number, topic, kind, definitions.get(kind, ""), wire)
                    self.directory.counts[number] = counts.get(number, 0)
        except (sqlite3.Error, TypeError, ValueError) as error:
            raise self._unreadable(error, self._REMEDY) from None

    def _open(self) -> sqlite3.Connection:
        # immutable: no journal and no lock beside a raw file
        return sqlite3.connect(f"file:{quote(str(self.path))}?mode=ro&immutable=1", uri=True)

    @staticmethod
    def _definitions(database: sqlite3.Connection) -> dict[str, str]:
        """Return type -> definition, which ros2 bag writes since Iron; before, standard ones do."""
        tables = {name for (name,) in database.execute("SELECT name FROM sqlite_master")}
        if "message_definitions" not in tables:
            return {}
        return {
            kind: text
            for kind, encoding, text in database.execute(
                "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
            )
            if encoding == "ros2msg"
        }

    def _rows(self, wanted: frozenset[int]) -> Iterator[_Row]:
        listed = ",".join(str(number) for number in sorted(wanted))
        try:
            with _Closing(self._open()) as database:
                for number, time_ns, data in database.execute(
                    "SELECT topic_id, timestamp, data FROM messages "  # noqa: S608 - whole numbers
                    f"WHERE topic_id IN ({listed}) ORDER BY id"
                ):
                    yield int(number), int(time_ns), bytes(data)
        except (sqlite3.Error, TypeError, ValueError) as error:
            self._faults.add(f"the bag is damaged: {error}; what follows was left out.")
