"""Bags of ROS, read as MCAP is: ``*.bag`` (ROS 1, by rosbags), ``*.db3`` (ROS 2), their folders.

Their messages become the same blocks of bytes, and nothing is converted. The folder of a bag of ROS
2 has a ``metadata.yaml`` and parts, ``.db3`` or ``.mcap``, perhaps compressed each as a whole
(``.db3.zstd``); together they are one log.
"""

import shutil
import sqlite3
import weakref
from collections.abc import Iterator, Mapping
from contextlib import closing
from dataclasses import replace
from pathlib import Path, PurePath
from tempfile import mkdtemp
from typing import Any
from urllib.parse import quote

import numpy as np

from pipeline.errors import InputError, Place, Problem, reason
from pipeline.ingest.log_source import MessageLog
from pipeline.ingest.mcap_chunk import ChunkBlock, Messages
from pipeline.ingest.mcap_file import McapFile
from pipeline.ingest.mcap_records import (
    MAX_RATIO,
    MAX_UNPACKED_BYTES,
    ChannelRecord,
    Directory,
    SchemaRecord,
)

#: Messages are put together to blocks of about this size.
_BLOCK_BYTES = 4 * 1024 * 1024
_Row = tuple[int, int, bytes]
#: Numbers of channels of one part and of the next are so far apart.
_STRIDE = 1 << 20
_MAX_BYTES = 4_000_000
_PIECE = 1 << 20
_REMEDY = (
    "ros2 bag reindex FOLDER writes it again; or take the parts out, which are logs by themselves."
)


class BagFile(MessageLog):
    """A bag on disk: its topics, and its messages in the order of the file."""

    _REMEDY = ""

    def __init__(self, path: Path, shown_as: str) -> None:
        """Read what it holds; raises `InputError` if it is no such bag, or was not closed."""
        super().__init__(path, shown_as)
        self.directory.complete = True
        self.size = self.read_bytes = path.stat().st_size if path.is_file() else 0
        self._read_topics()

    def _read_topics(self) -> None:
        raise NotImplementedError

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
        language = "ros1msg" if wire == "ros1" else "ros2msg"
        self.directory.schemas[number] = SchemaRecord(
            id=number, name=kind, encoding=language, data=definition.encode()
        )
        self.directory.channels[number] = ChannelRecord(
            id=number, schema_id=number, topic=topic, message_encoding=wire, metadata={}
        )

    def _unreadable(self, error: BaseException) -> InputError:
        return InputError.at(
            self.place,
            f"the bag cannot be read: {reason(error)}.",
            expected="a bag that its recorder closed.",
            remedy=self._REMEDY,
        )

    def _damaged(self, error: Exception) -> None:
        self.add_fault(f"the bag is damaged: {reason(error)}; what follows was left out.")


def _block(rows: list[_Row]) -> ChunkBlock:
    number, time, data = zip(*rows, strict=True)
    size, channel = np.array([len(one) for one in data], np.int64), np.array(number)
    every = np.stack([np.array(time, np.int64), np.cumsum(size) - size, size])
    messages = {int(one): Messages(*every[:, channel == one]) for one in np.unique(channel)}
    return ChunkBlock(np.frombuffer(b"".join(data), np.uint8), messages)


class Ros1Bag(BagFile):
    """A bag of ROS 1."""

    _REMEDY = "rosbag reindex, or rosbag fix, mends a bag that was not closed."

    def _read_topics(self) -> None:
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
        except UnicodeDecodeError:
            raise self._unreadable(ValueError("it does not begin with #ROSBAG")) from None
        except (ReaderError, OSError, ValueError, KeyError, AssertionError) as error:
            raise self._unreadable(error) from None
        return closing(reader)

    def _rows(self, wanted: frozenset[int]) -> Iterator[_Row]:
        with self._reader() as reader:
            chosen = [one for one in reader.connections if one.id in wanted]
            try:
                # without connections all would come
                for connection, time_ns, data in reader.messages(chosen) if chosen else ():
                    yield connection.id, time_ns, data
            except Exception as error:  # noqa: BLE001 - whatever compressed bytes make of it
                self._damaged(error)


def read_only(path: Path) -> sqlite3.Connection:
    """Open a database without a journal or a lock beside a raw file."""
    return sqlite3.connect(f"file:{quote(str(path))}?mode=ro&immutable=1", uri=True)


class Ros2Database(BagFile):
    """A bag of ROS 2 in SQLite; it is opened for reading alone, and nothing is left beside it."""

    _REMEDY = "ros2 bag reindex, or sqlite3 FILE .recover, mends a bag that was not closed."

    def _read_topics(self) -> None:
        self.directory.library = "ros2 bag"
        beside = self.path.with_name(f"{self.path.name}-wal")
        if beside.is_file() and beside.stat().st_size:
            self.add_fault(
                f"the bag was not closed: messages in {beside.name} are not in it yet; copy both "
                f'elsewhere and run sqlite3 {self.path.name} "PRAGMA wal_checkpoint" there.'
            )
        try:
            with closing(read_only(self.path)) as database:
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
            raise self._unreadable(error) from None

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
            with closing(read_only(self.path)) as database:
                for number, time_ns, data in database.execute(
                    "SELECT topic_id, timestamp, data FROM messages "  # noqa: S608 - whole numbers
                    f"WHERE topic_id IN ({listed}) ORDER BY id"
                ):
                    yield int(number), int(time_ns), bytes(data)
        except (sqlite3.Error, TypeError, ValueError) as error:
            self._damaged(error)


class BagFolder(MessageLog):
    """A bag on disk: its topics, and its messages part by part."""

    def __init__(self, path: Path, shown_as: str) -> None:
        """Open the parts that a ``metadata.yaml`` names; raises `InputError` if none is read."""
        super().__init__(path, shown_as)
        self.directory = Directory(complete=True, library="ros2 bag")
        self._said: list[Problem] = []
        self._unpacked = ""
        self._parts: list[Ros2Database | McapFile] = []
        names = _parts_named(path, self.place)
        for name in names:
            self._open(path.parent / PurePath(name).name)
        if not self._parts:
            raise InputError.at(
                self.place,
                f"no part of the bag can be read: {', '.join(one.what for one in self._said)}",
                expected="the .db3 or .mcap files that it names, beside it.",
                remedy="Copy the whole folder from the vehicle again.",
            )
        self.size = sum(part.size for part in self._parts)

    @property
    def problems(self) -> list[Problem]:
        """What was found wrong while it was read."""
        return [*self._said, *(one for part in self._parts for one in part.problems)]

    def blocks(self, wanted: frozenset[int]) -> Iterator[ChunkBlock]:
        """Yield the messages of some channels, part by part."""
        for number, part in enumerate(self._parts):
            first = number * _STRIDE
            own = frozenset(one - first for one in wanted if first <= one < first + _STRIDE)
            for block in part.blocks(own) if own else ():
                messages = {first + one: found for one, found in block.messages.items()}
                yield ChunkBlock(block.data, messages)
        self.read_bytes = sum(part.read_bytes for part in self._parts)

    def _open(self, path: Path) -> None:
        """Add a part; one that is missing or broken is told, and the others are read."""
        shown = f"{PurePath(self.place.file).parent}/{path.name}"
        try:
            inner = self._plain(path) if path.suffix in {".zstd", ".zst"} else path
            part = (Ros2Database if inner.suffix == ".db3" else McapFile)(inner, shown)
        except (InputError, OSError) as error:
            why = error.problem.what if isinstance(error, InputError) else f"{error.strerror}."
            what = f"the part {path.name} of the bag is left out: {why}"
            expected = "every part that metadata.yaml names."
            remedy = "Copy it from the vehicle again."
            self._said.append(self.place.warning(what, expected, remedy))
            self.directory.complete = False
            return
        first = len(self._parts) * _STRIDE
        self._parts.append(part)
        theirs, ours = part.directory, self.directory
        ours.complete &= theirs.complete
        ours.metadata |= theirs.metadata
        for number, schema in theirs.schemas.items():
            ours.schemas[first + number] = replace(schema, id=first + number)
        for number, channel in theirs.channels.items():
            ours.channels[first + number] = replace(
                channel, id=first + number, schema_id=first + channel.schema_id
            )
        ours.counts |= {first + number: count for number, count in theirs.counts.items()}

    def _plain(self, path: Path) -> Path:
        import zstandard

        if not self._unpacked:
            self._unpacked = mkdtemp(prefix="bag.")
            weakref.finalize(self, shutil.rmtree, self._unpacked, ignore_errors=True)
        target = Path(self._unpacked, path.stem)
        most = MAX_UNPACKED_BYTES + MAX_RATIO * path.stat().st_size
        try:
            with path.open("rb") as packed, target.open("wb") as plain:
                stream = zstandard.ZstdDecompressor(max_window_size=1 << 27).stream_reader(packed)
                while piece := stream.read(_PIECE):
                    plain.write(piece)
                    if plain.tell() > most:
                        raise OSError(0, "it unpacks to far more than its size")
        except zstandard.ZstdError as error:
            raise OSError(0, f"it cannot be unpacked ({reason(error)})") from None
        return target


def _information(path: Path) -> Mapping[str, Any]:
    """Return what ``metadata.yaml`` says; raises `ValueError` or `OSError`."""
    from ruamel.yaml import YAML
    from ruamel.yaml.error import YAMLError

    with path.open("rb") as file:
        text = file.read(_MAX_BYTES + 1)
    if len(text) > _MAX_BYTES:
        raise ValueError("it is too long")
    try:
        return dict(YAML(typ="safe").load(text)["rosbag2_bagfile_information"])
    except (YAMLError, KeyError, TypeError, RecursionError, ValueError) as error:
        raise ValueError(reason(error, 150)) from None


def _parts_named(path: Path, place: Place) -> list[str]:
    what = "the metadata of the bag names no parts (relative_file_paths)."
    try:
        names = _information(path).get("relative_file_paths")
        if isinstance(names, list) and names and all(isinstance(name, str) for name in names):
            return list(dict.fromkeys(names))
    except (ValueError, OSError) as error:
        what = f"the metadata of the bag cannot be read ({error})."
    raise InputError.at(
        place,
        what,
        expected="what ros2 bag writes: rosbag2_bagfile_information with the names of its parts.",
        remedy=_REMEDY,
    )


def start_of_bag(path: Path) -> int:
    """Return the time of the first message [ns since 1970] as the metadata has it."""
    return int(_information(path)["starting_time"]["nanoseconds_since_epoch"])
