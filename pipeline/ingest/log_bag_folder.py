"""Bags of ROS 2 as their recorder leaves them: a folder of ``metadata.yaml`` and one or more parts.

The parts, ``.db3`` or ``.mcap``, perhaps compressed each as a whole (``.db3.zstd``), are read one
after the other as they are read alone; together they are one log.
"""

import shutil
import weakref
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path, PurePath
from tempfile import mkdtemp
from typing import Any

from pipeline.errors import InputError, Place, Problem
from pipeline.ingest.log_bag import Ros2Database
from pipeline.ingest.mcap_chunk import ChunkBlock
from pipeline.ingest.mcap_directory import Directory
from pipeline.ingest.mcap_file import McapFile
from pipeline.ingest.mcap_records import MAX_RATIO, MAX_UNPACKED_BYTES

#: Numbers of channels of one part and of the next are so far apart.
_STRIDE = 1 << 20
_MAX_BYTES = 4_000_000
_PIECE = 1 << 20
_REMEDY = (
    "ros2 bag reindex FOLDER writes it again; or take the parts out, which are logs by themselves."
)


class BagFolder:
    """A bag on disk: its topics, and its messages part by part."""

    def __init__(self, path: Path, shown_as: str) -> None:
        """Open the parts that the ``metadata.yaml`` at `path` names.

        Raises `InputError` if it cannot be read, or no part of it can.
        """
        self.place = Place(shown_as)
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
        self.read_bytes = 0
        """How far the last pass got, over all parts."""

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
            what = error.problem.what if isinstance(error, InputError) else f"{error.strerror}."
            problem = Problem(
                "warning",
                self.place,
                f"the part {path.name} of the bag is left out: {what}",
                "every part that metadata.yaml names.",
                "Copy it from the vehicle again.",
            )
            self._said.append(problem)
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
        """Unpack a part that is compressed as a whole."""
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
            raise OSError(0, f"it cannot be unpacked ({error})") from None
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
        found = YAML(typ="safe").load(text)["rosbag2_bagfile_information"]
    except (YAMLError, KeyError, TypeError, RecursionError, ValueError) as error:
        raise ValueError(" ".join(str(error).split())[:150]) from None
    if not isinstance(found, dict):
        raise ValueError("it says nothing of a bag")  # noqa: TRY004 - of a file, not of a caller
    return found


def _parts_named(path: Path, place: Place) -> list[str]:
    try:
        names = _information(path).get("relative_file_paths")
    except (ValueError, OSError) as error:
        raise InputError.at(
            place,
            f"the metadata of the bag cannot be read ({error}).",
            expected="what ros2 bag writes: rosbag2_bagfile_information.",
            remedy=_REMEDY,
        ) from None
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names) or not names:
        raise InputError.at(
            place,
            "the metadata of the bag names no parts (relative_file_paths).",
            expected="the names of its .db3 or .mcap files.",
            remedy=_REMEDY,
        )
    return list(dict.fromkeys(names))


def start_of_bag(path: Path) -> int:
    """Return the time of the first message [ns since 1970] as the metadata has it; 0 for none."""
    try:
        return int(_information(path)["starting_time"]["nanoseconds_since_epoch"])
    except (ValueError, OSError, KeyError, TypeError):
        return 0
