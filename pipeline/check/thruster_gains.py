"""Gains of the thrusters of the pool runs that a check read, and any gains as a table."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from pipeline.check.findings import GainsFinding, RunFinding
from pipeline.errors import CannotComputeError, InputError
from pipeline.plan import UsageError
from pipeline.records.gains import ThrusterGain, ThrusterGains
from pipeline.records.run_table import RunTable


def gains_of_checked(
    runs: Sequence[tuple[RunFinding, RunTable | None, Path | None]], raw: Path
) -> list[GainsFinding]:
    """Compute the gains of the runs of each vehicle file together.

    Of each run what was read, its channels on one time base, and the file of its vehicle.
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
    notes = (None if finding.record is None else finding.record.notes for finding, _ in rows)
    sound = [t for t, own in zip(tables, notes, strict=True) if own and own.healthy is True]
    try:
        one = load_simulated(str(file.parent), raw, Path())
        return GainsFinding(str(file), gains_of_runs(one, tables, sound))
    except (CannotComputeError, InputError, UsageError) as error:
        return GainsFinding(str(file), None, str(error).splitlines()[0])


def summary(found: GainsFinding) -> Mapping[str, object]:
    """Return what the JSON of a check says of the gains of a vehicle's runs."""
    gains = found.gains
    return {
        "vehicle_file": found.vehicle_file,
        "why_not": found.why_not,
        "gains": None if gains is None else gains.model_dump(mode="json"),
    }


_ALL = "all"


def gains_text(gains: ThrusterGains) -> list[str]:
    """Return a table of all runs, what is against a reference, and what was found."""
    if not gains.runs:
        why = "; ".join(f"{run}: {text}" for run, text in gains.why_no_run.items())
        return [f"Gains of the thrusters: not computed ({why})"] if why else []
    lines = ["Gains of the thrusters (1: as the vehicle file says; 95 % intervals):"]
    axes = list(dict.fromkeys(row.axis for row in gains.gains if row.axis != _ALL))
    shown = [_ALL, *(axis for axis in axes if _told(gains.gains, axis))]
    lines.append("  " + f"{'run, thruster':40}" + "".join(f"{axis:>22}" for axis in shown))
    for run in gains.runs:
        lines.append(f"  {run.run}")
        for name in run.thrust_std_n:
            own = {
                row.axis: row for row in gains.gains if row.run == run.run and row.thruster == name
            }
            cells = "".join(f"{_cell(own.get(axis)):>22}" for axis in shown)
            lines.append(f"    {name:38}{cells}{_against(own.get(_ALL))}")
    lines += [f"  {name}: not judged, {why}" for name, why in gains.not_judged.items()]
    lines += [f"  {run}: no gains, {why}" for run, why in gains.why_no_run.items()]
    if gains.findings:
        lines += [f"  found: {one.text}" for one in gains.findings]
    else:
        lines.append("  nothing out of the ordinary")
    return lines


def _told(rows: Sequence[ThrusterGain], axis: str) -> bool:
    return any(row.axis == axis and row.moves and row.judged for row in rows)


def _cell(row: ThrusterGain | None) -> str:
    if row is None or not row.moves or row.value is None or row.ci95 is None:
        return "-"
    if not row.judged:
        return "?"
    return f"{row.value:.2f} [{row.ci95[0]:.2f}, {row.ci95[1]:.2f}]"


def _against(row: ThrusterGain | None) -> str:
    known = None if row is None else row.reference
    if known is None or known.ratio is None or known.ratio_ci95 is None:
        return ""
    low, high = known.ratio_ci95
    return f"   {known.ratio:.2f} [{low:.2f}, {high:.2f}] of what it gave in {known.name}"
