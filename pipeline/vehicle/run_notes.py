"""Read ``<run>.yaml``: what a person wrote of the pool run beside it."""

from pathlib import Path

from pipeline.errors import InputError, Place
from pipeline.records.run_notes import RunNotes
from pipeline.vehicle.load import validated
from pipeline.vehicle.yaml_text import parse

__all__ = ["NOTES_SUFFIXES", "notes_file", "read_run_notes"]

NOTES_SUFFIXES = (".yaml", ".yml")
_MAX_BYTES = 100_000


def notes_file(log: Path) -> Path | None:
    """Return the notes of a log: the file beside it with its name, ``.yaml`` or ``.yml``."""
    for suffix in NOTES_SUFFIXES:
        path = log.with_suffix(suffix)
        if path.is_file():
            return path
    return None


def read_run_notes(path: Path, shown_as: str) -> RunNotes:
    """Read and check the notes of a run.

    Parameters
    ----------
    path : Path
        The file.
    shown_as : str
        Its name in messages.

    Returns
    -------
    RunNotes
        The notes; an empty file gives empty ones.

    Raises
    ------
    InputError
        If the file cannot be read, is too large, is not YAML, or has a key or a value that is not
        in docs/formats_pool.md. All faults are named in one message, each with its line.
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
