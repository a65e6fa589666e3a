"""What a stage of the bench left of a vehicle, for commands that start from it."""

from pathlib import Path
from typing import TypeVar

from pipeline.plan import processed_file
from pipeline.provenance import read_envelope
from pipeline.records.base import Record

R = TypeVar("R", bound=Record)


def result_of(
    name: str, out: Path, stage: str, kind: type[R]
) -> tuple[R | None, dict[str, str], str]:
    """Return the record of a stage, the digests of what it was made from, and why there is none.

    `name` is the vehicle, or a type of thruster as `typed_name` has it; `out` the folder that holds
    ``processed/``.

    Raises
    ------
    InputError
        When the file is broken, edited or something else.
    """
    path = out / processed_file(name, stage)
    if not path.is_file():
        return None, {}, f"{path} does not exist."
    envelope = read_envelope(path, stage, kind)
    return envelope.record, dict(envelope.inputs), envelope.why_not or ""
