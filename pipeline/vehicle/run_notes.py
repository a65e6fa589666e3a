"""Read ``<run>.yaml``: what a person wrote of the pool run beside it."""

from pathlib import Path, PurePath

from pipeline.errors import InputError, Place
from pipeline.records.pool_run import RunNotes
from pipeline.vehicle.load import validated
from pipeline.vehicle.yaml_text import parse

__all__ = ["BAG_FILE", "NOTES_SUFFIXES", "notes_file", "read_run_notes", "run_of"]

NOTES_SUFFIXES = (".yaml", ".yml")
_MAX_BYTES = 100_000
#: What ros2 bag writes last into the folder of a bag: the folder is one run, known by this file.
BAG_FILE = "metadata.yaml"


def run_of(log: PurePath) -> str:
    """Return what a run is called: as its file without the ending, or as the folder of its bag.

    >>> run_of(PurePath("pool/dive.mcap")), run_of(PurePath("pool/bag.2/metadata.yaml"))
    ('dive', 'bag.2')
    """
    return log.parent.name if log.name == BAG_FILE else log.stem


def notes_file(log: Path) -> Path | None:
    """Return the notes of a log: the file beside it with its name, ``.yaml`` or ``.yml``."""
    # the notes of a bag lie beside its folder
    folder = log.parent.parent if log.name == BAG_FILE else log.parent
    for suffix in NOTES_SUFFIXES:
        path = folder / f"{run_of(log)}{suffix}"
        if path.is_file():
            return path
    return None


def read_run_notes(path: Path, shown_as: str) -> RunNotes:
    """Read and check the notes of a run, `shown_as` in messages; an empty file gives empty ones.

    Raises
    ------
    InputError
        If the file cannot be read, is too large, is not YAML, or has a key or a value that is not
        in docs/pool_runs.md. All faults are named in one message, each with its line.
    """
    place = Place(shown_as)
    try:
        with path.open("rb") as stream:
            data = stream.read(_MAX_BYTES + 1)
    except OSError as error:
        raise InputError.at(
            place,
            f"the notes cannot be read: {error.strerror or error}.",
            remedy="Check the permissions of the file.",
        ) from None
    if len(data) > _MAX_BYTES:
        raise InputError.at(
            place,
            f"the notes are larger than {_MAX_BYTES // 1000} kB.",
            expected="a few lines on ballast, water, tether, who and what.",
            remedy="Keep measured data and pictures in files of their own.",
        )
    said = [line for line in data.splitlines() if line.strip() and not line.startswith(b"#")]
    if not said:
        return RunNotes(file=shown_as)
    notes = validated(RunNotes, parse(data, shown_as), shown_as)
    return notes.model_copy(update={"file": shown_as})
