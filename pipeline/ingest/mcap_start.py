"""When a log begins, on which day, and whether it was closed: from a few bytes, no message."""

import contextlib
import re
from datetime import UTC, date, datetime, timedelta
from pathlib import Path

from pipeline.ingest.mcap_records import CHUNK, MAGIC, MESSAGE, RECORD_HEAD

#: Records that may stand before the first message: schemas, channels, metadata, attachments.
_MOST_RECORDS = 100_000
_SECOND_NS = 1_000_000_000
#: Year, month, day in a file's name: 2026-05-04, 2026_05_04, 2026.05.04, 20260504.
_DATE = re.compile(r"(?<!\d)(\d{4})[-_.]?(\d\d)[-_.]?(\d\d)(?!\d)")
#: A log of an earlier year has the time of a clock that nobody set.
_CLOCK_SET = 2000
#: Time zones that are in use.
_FARTHEST_WEST, _FARTHEST_EAST = timedelta(hours=-12), timedelta(hours=14)


def log_start_ns(path: Path) -> int | None:
    """Return the log time of the first message or chunk, None when there is none to be found.

    Parameters
    ----------
    path : Path
        An MCAP file, perhaps cut off or something else altogether.

    Returns
    -------
    int or None
        Since 1970. [ns]
    """
    try:
        with path.open("rb") as file:
            if file.read(len(MAGIC)) != MAGIC:
                return None
            for _ in range(_MOST_RECORDS):
                head = file.read(RECORD_HEAD.size)
                if len(head) < RECORD_HEAD.size:
                    return None
                opcode, length = RECORD_HEAD.unpack(head)
                if opcode in {CHUNK, MESSAGE}:
                    # a chunk begins with the time of its first message, a message with channel
                    # (2), sequence (4) and log time
                    skip = 6 if opcode == MESSAGE else 0
                    content = file.read(skip + 8)
                    whole = len(content) == skip + 8
                    return int.from_bytes(content[skip:], "little") if whole else None
                if length > 1 << 40:
                    return None
                file.seek(length, 1)
    except OSError:
        return None
    return None


def is_closed(path: Path) -> bool:
    """Tell whether the file ends as a log does that its writer closed."""
    try:
        with path.open("rb") as file:
            if file.seek(0, 2) < 2 * len(MAGIC):
                return False
            file.seek(-len(MAGIC), 2)
            return file.read() == MAGIC
    except OSError:
        return False


def day_of(path: Path) -> str:
    """Return the trial day of a log: what its name says if its time agrees, otherwise the UTC day.

    Times in a log are UTC, and a working day far east or west of Greenwich lies on two days of it.
    Who names a log, or the recorder that does, writes the local date: it counts where some time
    zone has that date when the log begins, or where the recorder's clock was not set. ``undated``
    without a time.
    """
    return _day(log_start_ns(path), path.stem)


def _day(start_ns: int | None, name: str) -> str:
    """Return the day of a log that begins then.

    >>> _day(1_700_000_000_000_000_000, "run-1"), _day(None, "2023-11-15")
    ('2023-11-14', 'undated')
    >>> _day(1_700_000_000_000_000_000, "rosbag2_2023_11_15-08_13_20")
    '2023-11-15'
    """
    if start_ns is None:
        return "undated"
    start = datetime.fromtimestamp(start_ns // _SECOND_NS, UTC)
    local = {(start + offset).date() for offset in (_FARTHEST_WEST, timedelta(0), _FARTHEST_EAST)}
    for found in _DATE.finditer(name):
        with contextlib.suppress(ValueError):  # of digits that are no date
            named = date(*(int(part) for part in found.groups()))
            if named in local or start.year < _CLOCK_SET:
                return named.isoformat()
    return start.date().isoformat()
