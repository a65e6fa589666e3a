"""Open a log by its format."""

from pathlib import Path

from pipeline.ingest.log_source import LogSource, MessageLog
from pipeline.ingest.mcap_file import McapFile


def open_log(path: Path, shown_as: str) -> LogSource:
    """Open a log.

    Raises
    ------
    InputError
        If it cannot be opened, or is not what its name says.
    """
    return MessageLog(McapFile(path, shown_as))
