"""When a log begins and whether its writer closed it, from a few bytes: no message is read."""

from datetime import UTC, datetime
from pathlib import Path

from pipeline.ingest.mcap_records import CHUNK, MAGIC, MESSAGE, RECORD_HEAD

#: Records that may stand before the first message: schemas, channels, metadata, attachments.
_MOST_RECORDS = 100_000
_DAY_NS = 86_400 * 1_000_000_000


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


def day_of(start_ns: int | None) -> str:
    """Return the UTC day of a time, ``undated`` where there is none.

    >>> day_of(1_700_000_000_000_000_000), day_of(None)
    ('2023-11-14', 'undated')
    """
    if start_ns is None:
        return "undated"
    return datetime.fromtimestamp(start_ns // _DAY_NS * 86_400, UTC).date().isoformat()
