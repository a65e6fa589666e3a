"""Which files are logs of pool runs, by their names; recorders write ``.mcap`` or ``.MCAP``."""

from collections.abc import Iterable
from pathlib import Path, PurePath

from pipeline.errors import Place, Problem
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
