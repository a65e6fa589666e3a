"""Which files are logs of runs, when each begins and on which day, and whether it was closed.

All of it from names and a few bytes, no message.
"""

import contextlib
import re
from collections.abc import Callable, Iterable, Mapping
from contextlib import closing
from datetime import UTC, date, datetime, timedelta
from pathlib import Path, PurePath

from mcap.records import Statistics

from pipeline.errors import Place, Problem
from pipeline.ingest import mcap_records as mcap
from pipeline.vehicle.run_notes import BAG_FILE, run_of

#: Endings of logs that are nothing else: MCAP, bags of ROS 1 and 2, ArduPilot, PX4, tables.
LOG_SUFFIXES = (".mcap", ".bag", ".db3", ".bin", ".tlog", ".ulg", ".parquet")
#: And of tables, which are runs where they lie among runs, in ``pool/``.
TABLE_SUFFIXES = (".csv", ".tsv")
_POOL = "pool"


def is_log_name(name: str) -> bool:
    """Tell a log by its name, among the runs of a vehicle.

    >>> is_log_name("dive.mcap"), is_log_name("DIVE.BIN"), is_log_name("dive.csv")
    (True, True, True)
    >>> is_log_name("dive.yaml")
    False
    """
    is_log = PurePath(name).suffix.lower() in (*LOG_SUFFIXES, *TABLE_SUFFIXES)
    return is_log or PurePath(name).name == BAG_FILE


def bags_in(folder: Path) -> list[Path]:
    """Return the file of each bag in a folder, sorted; the bags are folders themselves."""
    return sorted(path for path in folder.glob(f"[!.]*/{BAG_FILE}") if path.is_file())


def parts_of(log: Path) -> list[Path]:
    """Return the files of a bag beside the one that it is known by; none for other logs."""
    if log.name != BAG_FILE:
        return []
    return sorted(path for path in log.parent.iterdir() if path.is_file() and path != log)


def is_log_anywhere(name: str) -> bool:
    """Tell a log by its name, wherever it lies: a table elsewhere is one of the bench.

    >>> is_log_anywhere("dive.mcap"), is_log_anywhere("dive.csv")
    (True, False)
    """
    return Path(name).suffix.lower() in LOG_SUFFIXES


def logs_of(folder: Path) -> list[Path]:
    """Return the logs in a folder, sorted; tables count in ``pool/`` alone."""
    if (folder / BAG_FILE).is_file() and folder.absolute().name != _POOL:
        return [folder / BAG_FILE]
    found = folder.iterdir() if folder.is_dir() else ()
    is_one = is_log_name if folder.absolute().name == _POOL else is_log_anywhere
    logs = (path for path in found if is_one(path.name) and path.name != BAG_FILE)
    return sorted([*(path for path in logs if path.is_file()), *bags_in(folder)])


def log_beside(notes: Path, files: Iterable[Path] | None = None) -> Path | None:
    """Return the log of the same name as a file of notes, among `files` or those beside it."""
    there = logs_of(notes.parent) if files is None else files
    fits = (path for path in there if is_log_name(path.name) and run_of(path) == notes.stem)
    return next(fits, None)


def not_a_log(shown: str) -> Problem:
    """Return the warning for a raw file among the runs that is none by its name."""
    return Place(shown).warning(
        "is no log by its name, so it was not read.",
        expected=f"pool runs as *{', *'.join((*LOG_SUFFIXES, *TABLE_SUFFIXES))}, or folders "
        f"of ros2 bag with their {BAG_FILE}; each with an optional <run>.yaml of notes.",
        remedy="Convert it to MCAP, or move it out of pool/.",
    )


def log_among_bench_files(shown: str) -> Problem:
    """Return the error for the log of a pool run where bench files lie; nothing reads it there."""
    return Place(shown).error(
        "this is the log of a pool run, by its name, and lies among bench files.",
        expected="workbooks and text tables here; pool runs in pool/.",
        remedy="Move it into the vehicle's pool/.",
    )


def unprintable_log(shown: str) -> Problem:
    """Return the error for a log that a page could not name."""
    return Place(shown).error(
        "the file's name holds a character that cannot be printed.",
        remedy="Rename the file. The others were read.",
    )


#: Records that may stand before the first message: schemas, channels, metadata, attachments.
_MOST_RECORDS = 100_000
_SECOND_NS = 1_000_000_000
#: Year, month, day in a file's name: 2026-05-04, 2026_05_04, 2026.05.04, 20260504.
_DATE = re.compile(r"(?<!\d)(\d{4})[-_.]?(\d\d)[-_.]?(\d\d)(?!\d)")
#: More messages in a second are times in another unit, of which these are what one is worth. [ns]
_MOST_HZ = 1e6
_FACTORS = (1_000, 1_000_000, 1_000_000_000)
#: Time zones that are in use.
_FARTHEST_WEST, _FARTHEST_EAST = timedelta(hours=-12), timedelta(hours=14)


def log_start_ns(path: Path) -> int | None:
    """Return the log time of the first message or chunk, None when there is none to be found.

    [ns since 1970]. A time before 2000 is of a clock that nobody had set: then the end of the first
    chunk, or what the summary says of the last message, may be of this century, and so may the time
    in the unit that its writer meant. The file may be cut off, or something else altogether.
    """
    ending = BAG_FILE if path.name == BAG_FILE else path.suffix.lower()
    if ending in _FIRST_TIME:
        try:
            return _FIRST_TIME[ending](path)
        except Exception:  # noqa: BLE001 - what is no log, or cannot be read, has no time
            return 0
    times = _first_times(path)
    if not times or times[0] >= mcap.SET_NS:
        return times[0] if times else None
    statistics = _statistics(path)
    if statistics is not None:
        times += [statistics.message_start_time, statistics.message_end_time]
        span_s = (statistics.message_end_time - statistics.message_start_time) / 1e9
        if statistics.message_count > _MOST_HZ * span_s > 0.0:
            times += [times[0] * factor for factor in _FACTORS]
    return next((time for time in times if mcap.SET_NS <= time < mcap.LATEST_NS), times[0])


def _of_bag_folder(path: Path) -> int:
    from pipeline.ingest.log_bag import start_of_bag

    return start_of_bag(path)


def _of_tlog(path: Path) -> int:
    with path.open("rb") as file:
        return int.from_bytes(file.read(8), "big") * 1000


def _of_bag(path: Path) -> int:
    from rosbags.rosbag1 import Reader

    with Reader(path) as reader:
        return int(reader.start_time)


def _of_db3(path: Path) -> int:
    from pipeline.ingest.log_bag import read_only

    with closing(read_only(path)) as database:
        return int(database.execute("SELECT MIN(timestamp) FROM messages").fetchone()[0] or 0)


def _of_table(path: Path) -> int:
    from pipeline.ingest.log_table import first_time_ns

    return first_time_ns(path)


#: Ending (or name) of a log that is no MCAP -> its first time [ns since 1970], 0 where it has none.
_FIRST_TIME: Mapping[str, Callable[[Path], int]] = {
    BAG_FILE: _of_bag_folder,
    ".tlog": _of_tlog,
    ".bag": _of_bag,
    ".db3": _of_db3,
    **dict.fromkeys((".csv", ".tsv", ".parquet"), _of_table),
    # a board counts from its start: its day stands in the name, if at all
    **dict.fromkeys((".bin", ".ulg"), lambda _: 0),
}


def _first_times(path: Path) -> list[int]:
    """Return the log time of the first message, or those of the first chunk's ends."""
    try:
        with path.open("rb") as file:
            if file.read(len(mcap.MAGIC)) != mcap.MAGIC:
                return []
            for _ in range(_MOST_RECORDS):
                head = file.read(mcap.RECORD_HEAD.size)
                if len(head) < mcap.RECORD_HEAD.size:
                    return []
                opcode, length = mcap.RECORD_HEAD.unpack(head)
                if opcode in {mcap.CHUNK, mcap.MESSAGE}:
                    # a chunk begins with its first and last time, a message with channel (2),
                    # sequence (4) and log time
                    skip, count = (6, 1) if opcode == mcap.MESSAGE else (0, 2)
                    content = file.read(skip + 8 * count)[skip:]
                    whole = range(len(content) // 8)
                    return [int.from_bytes(content[8 * i : 8 * i + 8], "little") for i in whole]
                if length > 1 << 40:
                    return []
                file.seek(length, 1)
    except OSError:
        return []
    return []


def _statistics(path: Path) -> Statistics | None:
    from mcap.reader import SeekingReader

    # nothing vouches for the bytes, and damage makes errors of any kind
    with contextlib.suppress(Exception), path.open("rb") as file:
        reader = SeekingReader(file, record_size_limit=mcap.MAX_CHUNK_BYTES)
        summary = reader.get_summary()
        return None if summary is None else summary.statistics
    return None


def is_closed(path: Path) -> bool:
    """Tell whether the file ends as a log does that its writer closed; of MCAP alone that shows."""
    if path.suffix.lower() in _FIRST_TIME or path.name in _FIRST_TIME:
        return True
    try:
        with path.open("rb") as file:
            if file.seek(0, 2) < 2 * len(mcap.MAGIC):
                return False
            file.seek(-len(mcap.MAGIC), 2)
            return file.read() == mcap.MAGIC
    except OSError:
        return False


def day_of(path: Path) -> str:
    """Return the trial day of a log: what its name says if its time agrees, otherwise the UTC day.

    Times in a log are UTC, and a working day far east or west of Greenwich lies on two days of it.
    Who names a log, or the recorder that does, writes the local date: it counts where some time
    zone has that date when the log begins, or where the recorder's clock was not set. ``undated``
    without a time that can be.
    """
    return _day(log_start_ns(path), run_of(path))


def _day(start_ns: int | None, name: str) -> str:
    """Return the day of a log that begins then.

    >>> _day(1_700_000_000_000_000_000, "run-1"), _day(None, "2023-11-15")
    ('2023-11-14', 'undated')
    >>> _day(1_700_000_000_000_000_000, "rosbag2_2023_11_15-08_13_20")
    '2023-11-15'
    """
    if start_ns is None:
        return "undated"
    is_set = mcap.SET_NS <= start_ns < mcap.LATEST_NS
    start = datetime.fromtimestamp(start_ns // _SECOND_NS if is_set else 0, UTC)
    local = {(start + offset).date() for offset in (_FARTHEST_WEST, timedelta(0), _FARTHEST_EAST)}
    for named in dates_in(name):
        if date.fromisoformat(named) in local or not is_set:
            return named
    return start.date().isoformat() if is_set else "undated"


def dates_in(name: str) -> list[str]:
    """Return the dates that a file's name holds.

    >>> dates_in("2026-05-04-run"), dates_in("20261341")
    (['2026-05-04'], [])
    """
    named = []
    for found in _DATE.finditer(name):
        with contextlib.suppress(ValueError):  # of digits that are no date
            named.append(date(*(int(part) for part in found.groups())).isoformat())
    return named
