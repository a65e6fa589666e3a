"""Gains of the thrusters of the pool runs that a check read."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from pipeline.check.findings import GainsFinding, RunFinding
from pipeline.errors import CannotComputeError, InputError
from pipeline.plan import UsageError
from pipeline.records.run_table import RunTable


def gains_of_checked(
    runs: Sequence[tuple[RunFinding, RunTable | None, Path | None]], raw: Path
) -> list[GainsFinding]:
    """Compute the gains of the runs of each vehicle file together.

    Parameters
    ----------
    runs : sequence of (RunFinding, RunTable or None, Path or None)
        What was read of each run, its channels on one time base, and the file of its vehicle.
    raw : Path
        The raw folder.
    """
    groups: dict[Path, list[tuple[RunFinding, RunTable]]] = {}
    for finding, table, file in runs:
        if file is not None and table is not None:
            groups.setdefault(file, []).append((finding, table))
    return [_of_vehicle(file, rows, raw) for file, rows in groups.items()]


def _of_vehicle(file: Path, rows: Sequence[tuple[RunFinding, RunTable]], raw: Path) -> GainsFinding:
    # what the model needs is imported where it is needed: a check without runs starts at once
    from pipeline.inputs.gains import gains_of_runs
    from pipeline.inputs.simulated_vehicle import load_simulated

    tables = [table for _, table in rows]
    try:
        one = load_simulated(str(file.parent), raw, Path())
        return GainsFinding(str(file), gains_of_runs(one, tables, _sound(rows)))
    except (CannotComputeError, InputError, UsageError) as error:
        return GainsFinding(str(file), None, str(error).splitlines()[0])


def _sound(rows: Sequence[tuple[RunFinding, RunTable]]) -> list[RunTable]:
    """Return the runs that their notes call healthy."""
    return [
        table
        for finding, table in rows
        if finding.record is not None
        and finding.record.notes is not None
        and finding.record.notes.healthy is True
    ]


def summary(found: GainsFinding) -> Mapping[str, object]:
    """Return what the JSON of a check says of the gains of a vehicle's runs."""
    gains = found.gains
    return {
        "vehicle_file": found.vehicle_file,
        "why_not": found.why_not,
        "gains": None if gains is None else gains.model_dump(mode="json"),
    }
