"""Which files are logs of pool runs, by their names: recorders write ``.mcap`` or ``.MCAP``."""

from collections.abc import Iterable
from pathlib import Path

from pipeline.errors import Place, Problem

LOG_SUFFIX = ".mcap"


def is_log_name(name: str) -> bool:
    """Tell a log by its name.

    >>> is_log_name("dive.mcap"), is_log_name("DIVE.MCAP"), is_log_name("dive.yaml")
    (True, True, False)
    """
    return Path(name).suffix.lower() == LOG_SUFFIX


def logs_of(folder: Path) -> list[Path]:
    """Return the logs in a folder, sorted; none where there is no such folder."""
    found = folder.iterdir() if folder.is_dir() else ()
    return sorted(path for path in found if is_log_name(path.name) and path.is_file())


def log_beside(notes: Path, files: Iterable[Path] | None = None) -> Path | None:
    """Return the log that a file of notes belongs to: of the same name, in the same folder.

    `files` is what lies in the folder, where the caller has looked already.
    """
    there = logs_of(notes.parent) if files is None else files
    fits = (path for path in there if is_log_name(path.name) and path.stem == notes.stem)
    return next(fits, None)


def not_a_log(shown: str) -> Problem:
    """Return the warning for a raw file among the runs that is none by its name."""
    return Problem(
        "warning",
        Place(shown),
        "is no MCAP log by its name, so it was not read.",
        expected="pool runs as *.mcap, each with an optional <run>.yaml of notes.",
        remedy="Convert it to MCAP, or move it out of pool/.",
    )


def unprintable_log(shown: str) -> Problem:
    """Return the error for a log that a page could not name."""
    return Problem(
        "error",
        Place(shown),
        "the file's name holds a character that cannot be printed.",
        remedy="Rename the file. The others were read.",
    )
