"""A log of whatever recorder as one thing: its topics, and the wanted numbers of each.

Two kinds: files of messages (`MessageLog`: MCAP, bags of ROS 1 and 2), which are read block by
block, and recordings whose tables are read as a whole (`TableLog`: ArduPilot, PX4, tables in time).
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass, field, replace
from io import StringIO
from pathlib import Path
from typing import Any

import numpy.typing as npt

from pipeline.errors import InputError, Place, Problem, reason
from pipeline.ingest.data_files import data_of
from pipeline.ingest.mcap_chunk import ChunkBlock
from pipeline.ingest.mcap_records import Directory
from pipeline.ingest.message_definitions import Path as FieldPath
from pipeline.ingest.pool_run_extract import Request, Sink, TopicData, extract
from pipeline.ingest.pool_run_plan import TopicFound
from pipeline.ingest.pool_run_topics import topics_of
from pipeline.records.pool_schema import PoolChannel
from pipeline.types import IntArray
from pipeline.vehicle.run_notes import BAG_FILE


@dataclass
class LogFacts:
    """What is known of a log as a file; `recorder` names the map of its `usual` channels."""

    place: Place
    size: int
    read_bytes: int
    complete: bool = True
    writer: str = ""
    metadata: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)
    recorder: str = ""
    usual: tuple[PoolChannel, ...] = ()


class MessageLog:
    """A file of messages in whatever container; subclasses fill `directory` and yield `blocks`."""

    def __init__(self, path: Path, shown_as: str) -> None:
        """Begin with nothing known of it."""
        self.path, self.place = path, Place(shown_as)
        self.directory = Directory()
        self.size = 0
        self.read_bytes = 0
        """How far the last pass got."""
        self._faults: dict[str, Problem] = {}
        self._cut_at: int | None = None
        """The byte behind which nothing is whole, of a log that has no end."""
        self._codecs: dict[int, Any] = {}

    def blocks(self, wanted: frozenset[int]) -> Iterator[ChunkBlock]:
        """Yield the messages of some channels in the order of the file."""
        raise NotImplementedError

    @property
    def problems(self) -> list[Problem]:
        """What was found wrong while it was read."""
        return list(self._faults.values())

    def add_fault(self, what: str) -> None:
        """Say what is wrong with the file; each once, however often it is read."""
        self._faults.setdefault(what, self.place.warning(what))

    def cut(self, at: int, how: str = "") -> None:
        """Say that records are whole up to byte `at`, and `how` the log ends, if in a way."""
        if self._cut_at is not None:
            return  # said by an earlier pass
        self._cut_at = at
        share = 100.0 * at / self.size if self.size else 0.0
        self._faults["cut"] = self.place.warning(
            f"the log ends {how}at byte {self.size} without its closing record: the recorder was "
            "stopped hard, or the copy is not complete. Whole records were read up to byte "
            f"{at} ({share:.0f} %).",
            "a file that ends with 89 4D 43 41 50 30 0D 0A.",
            "Copy it again; if it is no longer elsewhere, mcap recover FILE makes an index.",
        )

    def topics(self) -> list[TopicFound]:
        """Find its topics with one message each."""
        self._codecs, found = topics_of(self)
        return found

    def extract(self, requests: Mapping[str, Request]) -> dict[str, TopicData]:
        """Take the wanted numbers out of it."""
        return extract(self, self._codecs, requests)

    def facts(self) -> LogFacts:
        """Say what is known of it by now."""
        return LogFacts(
            self.place,
            self.size,
            self.read_bytes,
            self.directory.complete,
            self.directory.library,
            dict(self.directory.metadata),
            self.problems,
        )


@dataclass(frozen=True)
class TopicTable:
    """All messages of one topic: `log_time_ns` (k,) and a column (k,) or (k, m) for each field.

    A field may be a part, ``acc.x``; `texts` are names of elements.
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


#: The topic of a table in time, which has fields and no message.
TABLE = "table"


class TableLog:
    """A recording whose tables are in memory."""

    def __init__(self, tables: Mapping[str, TopicTable], facts: LogFacts) -> None:
        """Take tables by topic."""
        self._tables = tables
        self._facts = facts

    def topics(self) -> list[TopicFound]:
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
        ]

    def extract(self, requests: Mapping[str, Request]) -> dict[str, TopicData]:
        """Take the wanted numbers out of it."""
        found = {}
        for topic, request in requests.items():
            table = self._tables[topic]
            sink = Sink(request, table.log_time_ns.size)
            rows = sink.room(table.log_time_ns)
            sink.fill(rows, slice(None), table.log_time_ns.size, table.column)
            if request.names is not None:
                rows["names"][:] = sink.name_list(table.texts.get(str(request.names[0]), ()))
            found[topic] = sink.finish()
        return found

    def facts(self) -> LogFacts:
        """Say what is known of it."""
        return replace(self._facts)


def read_recording(
    path: Path,
    shown_as: str,
    usual: str,
    of: str,
    tables_of: Callable[[Path, LogFacts], Mapping[str, TopicTable]],
) -> TableLog:
    """Read a recording by its library; whatever that makes of damaged bytes is an `InputError`.

    `usual` is its map in ``recorders.toml``, `of` whose log it is; `tables_of` gives its tables.
    """
    place = Place(shown_as)
    is_px4 = of == "PX4"
    expected = "a data-flash log (*.BIN) or a telemetry log (*.tlog)."
    if is_px4:
        expected = "a ULog file (*.ulg)."
    size, facts = 0, LogFacts(place, 0, 0, writer=of)
    facts.recorder = f"the usual map of {'PX4' if is_px4 else 'ArduSub'}"
    facts.usual = tuple(PoolChannel.model_validate(one) for one in data_of("recorders")[usual])
    try:
        size = facts.size = facts.read_bytes = path.stat().st_size
        with redirect_stdout(StringIO()):
            tables = tables_of(path, facts) if size else {}
    except Exception as error:  # noqa: BLE001 - whatever damaged bytes make of it
        said = reason(error)
        if isinstance(error, ImportError):
            said = f"{'pyulog' if is_px4 else 'pymavlink'} is not installed"
        raise InputError.at(
            place,
            f"the log of {of} cannot be read ({said}).",
            expected=expected,
            remedy="Copy it from the vehicle again.",
        ) from None
    if not size:
        raise InputError.at(place, "the file is empty.", remedy="Copy the log again.")
    if not tables:
        raise InputError.at(
            place,
            f"no message of {of} is in the file.",
            expected=expected,
            remedy="Check that it is such a log, and that the recorder ran.",
        )
    return TableLog(tables, facts)


LogSource = MessageLog | TableLog


def open_log(path: Path, shown_as: str) -> LogSource:
    """Open a log by the ending of its name, MCAP for any that is not known; raises `InputError`."""
    match BAG_FILE if path.name == BAG_FILE else path.suffix.lower():
        case ".bag" | ".db3" as ending:
            from pipeline.ingest.log_bag import Ros1Bag, Ros2Database

            return (Ros1Bag if ending == ".bag" else Ros2Database)(path, shown_as)
        case ".bin" | ".tlog" as ending:
            from pipeline.ingest.log_boards import read_bin, read_tlog

            return (read_bin if ending == ".bin" else read_tlog)(path, shown_as)
        case ".ulg":
            from pipeline.ingest.log_boards import read_ulg

            return read_ulg(path, shown_as)
        case ".csv" | ".tsv" | ".parquet":
            from pipeline.ingest.log_table import read_table

            return read_table(path, shown_as)
        case name if name == BAG_FILE:
            from pipeline.ingest.log_bag import BagFolder

            return BagFolder(path, shown_as)
        case _:
            from pipeline.ingest.mcap_file import McapFile

            return McapFile(path, shown_as)
