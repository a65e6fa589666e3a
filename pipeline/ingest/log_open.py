"""Open a log by its format: one reader a format, imported where it is used."""

from pathlib import Path

from pipeline.ingest.log_names import BAG_FILE
from pipeline.ingest.log_source import LogSource, MessageLog


def open_log(path: Path, shown_as: str) -> LogSource:
    """Open a log; the ending of its name tells the format, MCAP for any that is not known.

    Raises `InputError` if it cannot be opened, or is not what its name says.
    """
    log: LogSource
    match BAG_FILE if path.name == BAG_FILE else path.suffix.lower():
        case ".bag" | ".db3" as ending:
            from pipeline.ingest.log_bag import Ros1Bag, Ros2Database

            log = MessageLog((Ros1Bag if ending == ".bag" else Ros2Database)(path, shown_as))
        case ".bin" | ".tlog" as ending:
            from pipeline.ingest.log_ardupilot import read_bin, read_tlog

            log = (read_bin if ending == ".bin" else read_tlog)(path, shown_as)
        case ".ulg":
            from pipeline.ingest.log_px4 import read_ulg

            log = read_ulg(path, shown_as)
        case ".csv" | ".tsv" | ".parquet":
            from pipeline.ingest.log_table import read_table

            log = read_table(path, shown_as)
        case name if name == BAG_FILE:
            from pipeline.ingest.log_bag_folder import BagFolder

            log = MessageLog(BagFolder(path, shown_as))
        case _:
            from pipeline.ingest.mcap_file import McapFile

            log = MessageLog(McapFile(path, shown_as))
    return log
