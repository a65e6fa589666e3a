"""Pool runs, their notes and the gains of their thrusters, as a check shows them."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from pipeline.check.findings import GainsFinding, NotesFinding, RunFinding
from pipeline.errors import CannotComputeError, InputError, Place, Problem
from pipeline.ingest.log_files import (
    bags_in,
    is_log_anywhere,
    is_log_name,
    log_among_bench_files,
    log_beside,
)
from pipeline.plan import POOL, RAW_KINDS, VEHICLE_FILE, UsageError, is_raw
from pipeline.records.gains import ThrusterGain, ThrusterGains
from pipeline.records.run_table import RunTable
from pipeline.vehicle.run_notes import BAG_FILE, NOTES_SUFFIXES, read_run_notes
from pipeline.vehicle.schema import Vehicle


def is_log(path: Path) -> bool:
    """Tell a pool run from other raw files: by its folder, or its suffix.

    A log in ``mooring/`` is one of thrust that was measured, for the bench's reader.
    """
    where = path.absolute().parent
    if path.name == BAG_FILE or where.name == POOL:
        return True
    return is_log_anywhere(path.name) and "mooring" not in {where.name, where.parent.name}


def is_notes(path: Path) -> bool:
    """Tell the notes of a run: they stand in the folder of the runs, or beside a log."""
    if path.suffix.lower() not in NOTES_SUFFIXES or path.name in {VEHICLE_FILE, BAG_FILE}:
        return False
    return path.absolute().parent.name == POOL or log_beside(path) is not None


def read_run(path: Path, vehicle: Vehicle, kind_from: str) -> tuple[RunFinding, RunTable | None]:
    """Read a log as the workflow would, its channels mapped by a vehicle.

    `kind_from` told that it is a pool run: "folder" or "suffix". Returns the one reason why it
    cannot be read, or its record and what is wrong with it; and its channels on one time base, None
    where they cannot be put onto one.
    """
    # of use with logs alone: a check of bench files is done before this is imported
    from pipeline.ingest.pool_run import read_pool_run, resample, summarize
    from pipeline.inputs.runs_to_identify import RATE_HZ

    misplaced = path.absolute().parent.name in RAW_KINDS
    lies = (log_among_bench_files(str(path)),) if misplaced else ()
    try:
        run = read_pool_run(path, vehicle, path.parent)
        record = summarize(run)
    except InputError as error:
        wrong = (*lies, _shown_at(path.parent, error.problem))
        return RunFinding(str(path), kind_from, None, wrong), None
    problems = (*lies, *(_shown_at(path.parent, problem) for problem in record.problems))
    try:
        table = resample(run, RATE_HZ, by_step=True)
    except CannotComputeError:
        table = None
    return RunFinding(str(path), kind_from, record, problems), table


def read_notes_alone(path: Path) -> NotesFinding:
    """Read notes that were asked for by name."""
    try:
        return NotesFinding(str(path), read_run_notes(path, str(path)))
    except InputError as error:
        return NotesFinding(str(path), None, (error.problem,))


def files_of_runs(folder: Path) -> list[Path]:
    """Return what a run looks at in a folder of runs: the logs, and what is no log by its name."""
    if not folder.is_dir():
        return []
    files = [
        path
        for path in folder.iterdir()
        if (is_log_name(path.name) or is_raw(path.name))
        and not path.name.startswith((".", "~$"))
        and path.is_file()
    ]
    return sorted([*files, *bags_in(folder)])


def strays(folder: Path) -> list[Problem]:
    """Warn of notes in a folder of runs that belong to no log."""
    if not folder.is_dir():
        return []
    return [
        Place(str(path)).warning(
            f"there is no run {path.stem} that these notes belong to.",
            remedy="Give the notes the name of their log.",
        )
        for path in sorted(folder.iterdir())
        if is_notes(path) and log_beside(path) is None
    ]


def repeated(runs: Sequence[RunFinding]) -> list[Problem]:
    """Say which logs hold the run of another, of which one counts."""
    from pipeline.ingest.same_run import repeated_runs

    records = {run.file: run.record for run in runs if run.record is not None}
    return [
        Place(copy).warning(
            f"this is the run of {first} again, or a part of it: the same readings. One of the two "
            "counts.",
            remedy="Move one of them out of pool/.",
        )
        for copy, first in repeated_runs(records).items()
    ]


def _shown_at(folder: Path, problem: Problem) -> Problem:
    """Show the file as the user named it; records name it from the raw folder on."""
    if not problem.place.file:
        return problem
    return problem.shown_as(str(folder / Path(problem.place.file).name))


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
