"""Open a log by its format: one reader a format, all of one signature."""

from collections.abc import Callable, Mapping
from pathlib import Path

from pipeline.ingest.log_names import BAG_FILE
from pipeline.ingest.log_source import LogSource, MessageLog


def _mcap(path: Path, shown_as: str) -> LogSource:
    from pipeline.ingest.mcap_file import McapFile

    return MessageLog(McapFile(path, shown_as))


def _bag(path: Path, shown_as: str) -> LogSource:
    from pipeline.ingest.log_bag import Ros1Bag

    return MessageLog(Ros1Bag(path, shown_as))


def _db3(path: Path, shown_as: str) -> LogSource:
    from pipeline.ingest.log_bag import Ros2Database

    return MessageLog(Ros2Database(path, shown_as))


def _folder(path: Path, shown_as: str) -> LogSource:
    from pipeline.ingest.log_bag_folder import BagFolder

    return MessageLog(BagFolder(path, shown_as))


def _bin(path: Path, shown_as: str) -> LogSource:
    from pipeline.ingest.log_ardupilot import read_bin

    return read_bin(path, shown_as)


def _tlog(path: Path, shown_as: str) -> LogSource:
    from pipeline.ingest.log_ardupilot import read_tlog

    return read_tlog(path, shown_as)


def _ulg(path: Path, shown_as: str) -> LogSource:
    from pipeline.ingest.log_px4 import read_ulg

    return read_ulg(path, shown_as)


def _table(path: Path, shown_as: str) -> LogSource:
    from pipeline.ingest.log_table import read_table

    return read_table(path, shown_as)


#: Ending of a name -> how such a log is opened: the path, and its name in messages.
READERS: Mapping[str, Callable[[Path, str], LogSource]] = {
    ".bag": _bag,
    ".db3": _db3,
    ".bin": _bin,
    ".tlog": _tlog,
    ".ulg": _ulg,
    ".csv": _table,
    ".tsv": _table,
    ".parquet": _table,
}


def open_log(path: Path, shown_as: str) -> LogSource:
    """Open a log; the ending of its name tells the format, MCAP for any that is not known.

    Raises `InputError` if it cannot be opened, or is not what its name says.
    """
    if path.name == BAG_FILE:
        return _folder(path, shown_as)
    return READERS.get(path.suffix.lower(), _mcap)(path, shown_as)
