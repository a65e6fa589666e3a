"""``rig2sea validate``: bring a vehicle's flights up to date and read them."""

from dataclasses import dataclass
from pathlib import Path

from pipeline.bundled.vehicles import bundled_vehicle, bundled_vehicles
from pipeline.errors import CannotComputeError, InputError, Problem
from pipeline.plan import UsageError, choose, processed_file, report_file
from pipeline.provenance import file_digest, read_raw_envelope
from pipeline.records.validation import AllocatorValidation
from pipeline.workflow.one_result import one_result
from pipeline.workflow.run import RunRequest


@dataclass(frozen=True)
class Validated:
    """The result and where it lies."""

    vehicle: str
    record: AllocatorValidation
    file: Path
    page: Path | None
    """The vehicle's report, where it shows these flights."""
    refused: tuple[Problem, ...]
    """Errors of raw files that the tables had to do without."""


def validated(text: str, raw: Path, out: Path) -> Validated:
    """Run what is stale of what one vehicle's flights need, and return them.

    Parameters
    ----------
    text : str
        A name under the raw folder, a path to a folder with ``vehicle.yaml``, or a bundled name.
    raw, out : Path
        The raw folder, and the folder that gets ``processed/`` and ``reports/``.

    Raises
    ------
    UsageError
        When there is no such vehicle.
    InputError, CannotComputeError
        When it cannot be read, or there is nothing to fly; the text says why.
    """
    request = RunRequest((_place(text, raw, out),), raw, out)
    made = one_result(request, "validation", AllocatorValidation)
    name, record = made.vehicle, made.envelope.record
    if record is None:
        raise CannotComputeError(f"{name} cannot be flown. {made.envelope.why_not}")
    page = out / report_file(name) if _is_shown(name, out) else None
    return Validated(name, record, made.file, page, made.refused)


def _is_shown(name: str, out: Path) -> bool:
    """Whether the vehicle's page was made with these flights."""
    file = processed_file(name, "validation")
    try:
        body = read_raw_envelope(out / processed_file(name, "vehicle_page"), "vehicle_page")
        return bool(body["inputs"].get(file) == file_digest(out / file))
    except (InputError, KeyError, TypeError, AttributeError):
        return False


def _place(text: str, raw: Path, out: Path) -> str:
    """Return what a run takes for the vehicle: a bundled one by its folder."""
    try:
        choose((text,), raw, out)
    except UsageError:
        if text in bundled_vehicles():
            return str(bundled_vehicle(text))
        raise
    return text
