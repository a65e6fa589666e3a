"""The list of changes of a vehicle file: what `apply` wrote, when, why, and what was before.

Beside ``vehicle.yaml`` lie, for each change, ``vehicle.yaml.<number>.before``, the bytes of before,
and ``vehicle.yaml.<number>.json`` with the rest. No reader takes either for a vehicle.
"""

import hashlib
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

from pydantic import ValidationError

from pipeline.errors import CannotComputeError, InputError, Place
from pipeline.provenance import file_digest, unwritable, write_atomically, write_record
from pipeline.records.base import AppliedChange


def changes_of(file: Path) -> tuple[AppliedChange, ...]:
    """Read the list of changes of a vehicle file, in order; undone ones too."""
    found = []
    for path in file.parent.glob(f"{file.name}.*.json"):
        try:
            found.append(AppliedChange.model_validate_json(path.read_bytes()))
        except (OSError, ValidationError) as error:
            raise InputError.at(
                Place(str(path)),
                "this entry of the list of changes cannot be read.",
                expected="what `rig2sea apply` wrote.",
                remedy="Restore the file, or delete it; the vehicle file holds without it.",
            ) from error
    return tuple(sorted(found, key=lambda one: one.number))


def digest_of(data: bytes) -> str:
    """SHA-256 of bytes."""
    return hashlib.sha256(data).hexdigest()


def now_utc() -> str:
    """Date and time, to the second."""
    return datetime.now(UTC).strftime("%Y-%m-%d %H:%M:%S")


def write_change(file: Path, text: str, entry: AppliedChange) -> None:
    """Keep the bytes of before and the entry, then write the file: an entry may not lack them."""
    before = file.parent / entry.former
    try:
        before.write_bytes(file.read_bytes())
    except OSError as error:
        raise unwritable(before, error) from error
    _write_entry(file, entry)
    write_atomically(file, text)


def _write_entry(file: Path, entry: AppliedChange) -> None:
    write_record(file.parent / f"{file.name}.{entry.number}.json", entry)


def undo_last(file: Path) -> AppliedChange:
    """Give the vehicle file the bytes that it had before the last change that holds.

    Raises `CannotComputeError` when there is none, its former bytes are gone, or the file was
    edited since.
    """
    held = [one for one in changes_of(file) if not one.undone_utc]
    if not held:
        raise CannotComputeError(f"{file}: `rig2sea apply` has changed nothing that still holds.")
    last = held[-1]
    if file_digest(file) != last.after_sha256:
        raise CannotComputeError(
            f"{file} was edited after `rig2sea apply` wrote it on {last.date_utc} UTC, and that "
            f"would be lost. The file of before is {file.parent / last.former}."
        )
    before = file.parent / last.former
    if file_digest(before) != last.before_sha256:
        raise CannotComputeError(f"{before} is gone or was changed, so it cannot be put back.")
    undone = last.model_copy(update={"undone_utc": now_utc()})
    before.replace(file)
    _write_entry(file, undone)
    return undone


def next_number(entries: Sequence[AppliedChange]) -> int:
    """Return the number of the next entry, from 1."""
    return max((one.number for one in entries), default=0) + 1
