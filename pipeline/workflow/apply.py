"""``rig2sea apply``: what was found into vehicle.yaml, after showing what changes."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.actions.found_changes import (
    diagnosed_changes,
    identified_changes,
    ranked_specs,
    source_of,
)
from pipeline.bundled.vehicles import bundled_vehicles
from pipeline.control.allocation import beyond_dead_zone
from pipeline.control.inverse import Inverse, firmware_grid
from pipeline.control.paper_allocator import Corrections, corrections_of, inflow_of_velocity
from pipeline.errors import CannotComputeError, InputError, Place
from pipeline.inputs.simulated_vehicle import load_inverses, load_simulated
from pipeline.inputs.vehicle_changes import (
    changes_of,
    digest_of,
    next_number,
    now_utc,
    undo_last,
    write_change,
)
from pipeline.inputs.vehicle_place import find_vehicle
from pipeline.plan import UsageError, seen_from
from pipeline.provenance import file_digest, read_envelope
from pipeline.records.base import AppliedChange, FileChange
from pipeline.records.day_findings import DayDiagnosis, DayFinding, RunDiagnosis
from pipeline.records.diagnosis import DiagnosisRecord, RankedEffect
from pipeline.records.identification import Identification, VehicleIdentification
from pipeline.records.trial import TrialDay
from pipeline.types import FloatArray
from pipeline.vehicle.change_list import text_with, value_at
from pipeline.vehicle.frames import in_sname
from pipeline.vehicle.load import load_checked, validated
from pipeline.vehicle.schema import Vehicle
from pipeline.vehicle.yaml_text import parse

#: Thrusts of the table of codes, as shares of the largest of their sign at rest.
_SHARES = (-1.0, -0.8, -0.6, -0.4, -0.2, 0.2, 0.4, 0.6, 0.8, 1.0)


@dataclass(frozen=True)
class Codes:
    """Codes of a thruster at a speed of the vehicle along it, for ten thrusts, before and after."""

    thruster: str
    speed_mps: float
    thrust_n: tuple[float, ...]
    old: tuple[int, ...]
    new: tuple[int, ...]


@dataclass(frozen=True)
class FoundChanges:
    """A result, and what it changes.

    `gap` is what was held out: name of a measure -> before, after.
    """

    source: Path
    reason: str
    runs: tuple[str, ...]
    changes: tuple[FileChange, ...]
    gap: Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class ChangeProposal:
    """What applying a result would do; nothing is written yet."""

    vehicle: str
    file: Path
    found: FoundChanges
    text: str
    codes: tuple[Codes, ...]
    why_no_codes: str
    unchanged: tuple[str, ...]
    """Thrusters whose codes stay."""


def propose(vehicle: str, source: str, raw: Path, out: Path) -> ChangeProposal:
    """Work out what a result changes in a vehicle's file.

    `vehicle` is a name under the raw folder, or a path; `source` is "diagnosis" or "identification"
    (the last one of the vehicle), a file or a folder with one, a trial day, or a pool run.
    """
    name, file = _own_file(vehicle, raw, out)
    found = _found(name, file, source, raw, out)
    if not found.changes:
        raise CannotComputeError(f"{found.source} changes nothing in {file}.")
    before = load_checked(file, Vehicle, expected="a vehicle file.", remedy="")
    _refuse_others(before, file, found)
    text = text_with(file.read_text(encoding="utf-8"), found.changes, found.reason)
    shown_as = f"{file} with what was found"
    after = validated(Vehicle, parse(text.encode(), shown_as), shown_as)
    try:
        inverses = load_inverses(before, name, out)
        grids = {of_type: firmware_grid(inverse) for of_type, inverse in inverses.items()}
        codes, why = _codes(in_sname(before), in_sname(after), grids), ""
    except CannotComputeError as error:
        codes, why = (), str(error)
    changed = {one.thruster for one in codes}
    rest = tuple(one.name for one in before.thrusters if one.name not in changed)
    return ChangeProposal(name, file, found, text, codes, why, rest)


def _own_file(vehicle: str, raw: Path, out: Path) -> tuple[str, Path]:
    name, file = find_vehicle(vehicle, raw, out)
    if vehicle in bundled_vehicles() and not (raw / vehicle).exists():
        raise UsageError(
            f"{vehicle} is a bundled vehicle, whose file belongs to the program. Make one of your "
            f"own: rig2sea new NAME --like {vehicle}"
        )
    return name, file


def _found(name: str, file: Path, source: str, raw: Path, out: Path) -> FoundChanges:
    """Read a result of any of the three kinds."""
    path = _result_file(name, source, out)
    try:
        body = json.loads(path.read_bytes())
    except (OSError, ValueError) as error:
        raise InputError.at(
            Place(str(path)), "this is no result that can be read.", expected="a JSON file."
        ) from error
    body = body if isinstance(body, dict) else {}
    if "verdict" in body:
        diagnosis = DiagnosisRecord.model_validate_json(path.read_bytes())
        runs = diagnosis.verdict.runs or diagnosis.runs
        return FoundChanges(path, source_of(runs), runs, diagnosis.changes, _gap(diagnosis))
    if "whole_vehicle" in body:
        record = Identification.model_validate_json(path.read_bytes())
        runs = tuple(run.name for run in record.runs)
        gap = _quality(record.whole_vehicle)
        return FoundChanges(path, source_of(runs, "identification"), runs, record.changes, gap)
    kind = path.parent.name
    if body.get("inputs", {}).get(f"raw/{name}/{file.name}") != file_digest(file):
        raise CannotComputeError(
            f"{file} was changed after {path} was computed from it. Run `rig2sea run {name}` first."
        )
    vehicle = str(file.parent)
    if kind in {"day_diagnoses", "run_diagnoses"}:
        ranked, runs, gap = _of_day(path) if kind == "day_diagnoses" else _of_run(path)
        if ranked is None:
            raise CannotComputeError(
                f"The diagnosis of the day {path.stem} found no fault."
                if kind == "day_diagnoses"
                else f"The diagnosis of the run {path.stem} found no fault."
            )
        one = load_simulated(vehicle, raw, out)
        changes = diagnosed_changes(one, ranked, ranked_specs(ranked))
        return FoundChanges(path, source_of(runs), runs, changes, gap)
    day = read_envelope(path, "trial_day", TrialDay)
    fit = None if day.record is None else day.record.identification
    if day.record is None or fit is None or fit.why_no_file or not fit.converged:
        reason = "" if fit is None else fit.why_no_file
        raise CannotComputeError(f"The day {path.stem} has no values that stand. {reason}".rstrip())
    changes = identified_changes(load_simulated(vehicle, raw, out), fit)
    return FoundChanges(path, f"day {path.stem}", fit.runs, changes, _quality(fit))


#: A fault, the runs that show it, and the gap before and after it; without a fault None first.
_Fault = tuple[RankedEffect | None, tuple[str, ...], dict[str, tuple[float, float]]]


def _of_day(path: Path) -> _Fault:
    """Take the first fault of a trial day; the gap is of all runs together or of each."""
    day = read_envelope(path, "day_diagnosis", DayDiagnosis).record
    found = _fault(day)
    if day is None or found is None:
        return None, (), {}
    if found.by == "together":
        return found.ranked, found.runs, {} if day.together is None else _gap(day.together)
    gaps: dict[str, tuple[float, float]] = {}
    for run in found.runs:
        file = path.parent.parent / "run_diagnoses" / f"{run}.json"
        own = read_envelope(file, "run_diagnosis", RunDiagnosis).record if file.is_file() else None
        if own is not None and own.record is not None:
            gaps |= _gap(own.record, f"gap of {run}, in healthy floors")
    return found.ranked, found.runs, gaps


def _of_run(path: Path) -> _Fault:
    """Take the fault of a pool run."""
    run = read_envelope(path, "run_diagnosis", RunDiagnosis).record
    if run is None or run.record is None:
        return None, (), {}
    own, names = run.record, {*run.record.verdict.effects}
    ranked = () if names & {"none", "unknown"} else own.ranking
    found = next((one for one in ranked if {*one.effect.split("+")} == names), None)
    return found, own.runs, _gap(own)


def _gap(
    record: DiagnosisRecord, name: str = "gap, in healthy floors"
) -> dict[str, tuple[float, float]]:
    return {name: (record.shrink.before, record.shrink.after)}


def _fault(day: DayDiagnosis | None) -> DayFinding | None:
    """Return the first finding of a day that is a named effect."""
    named = (
        one
        for one in (() if day is None else day.findings)
        if one.ranked is not None and not {"none", "unknown"} & {*one.effects}
    )
    return next(named, None)


def _quality(found: VehicleIdentification | None) -> dict[str, tuple[float, float]]:
    return {
        f"{one.channel}, rms over {one.horizon_s:g} s [{one.unit}]": (
            one.rmse_vehicle_file,
            one.rmse_corrected_file,
        )
        for one in (found.quality if found is not None else ())
        if one.rmse_vehicle_file is not None and one.rmse_corrected_file is not None
    }


def _result_file(name: str, source: str, out: Path) -> Path:
    processed = out / "processed" / name
    places = [
        Path(source),
        *(Path(source) / f"{kind}.json" for kind in ("diagnosis", "identification")),
        processed / source / f"{source}.json",
        processed / "trial_days" / f"{source}.json",
        processed / "run_diagnoses" / f"{source}.json",
        out / "reports" / name / "diagnoses" / source / "diagnosis.json",
    ]
    diagnosed = processed / "day_diagnoses" / f"{source}.json"
    if not Path(source).exists() and diagnosed.is_file() and _of_day(diagnosed)[0] is not None:
        return diagnosed  # values identified on a day with a fault would spread it over all
    for path in places:
        if path.is_file():
            return path
    days = sorted(path.stem for path in (processed / "trial_days").glob("*.json"))
    there = f" Days: {', '.join(days)}." if days else ""
    raise UsageError(
        f'{name} has no result "{source}". Expected diagnosis, identification, a trial day, a pool '
        f"run, or the path of diagnosis.json or identification.json.{there}"
    )


def _refuse_others(before: Vehicle, file: Path, found: FoundChanges) -> None:
    """Refuse a result that started from other numbers than stand in the file now."""
    stated = before.model_dump()
    for one in found.changes:
        now = value_at(stated, one.path)
        if now == one.old or _alike(now, one.old):
            continue
        if _alike(now, one.value):
            raise CannotComputeError(
                f"{file}: {one.path} is {now} already, as {found.source} has it."
            )
        raise CannotComputeError(
            f"{file}: {one.path} is {now}, and {found.source} started from {one.old}. What was "
            "found is a change of that; repeat it with the file as it is now."
        )


def _alike(first: Any, second: Any) -> bool:  # noqa: ANN401 - values of a file
    numbers = isinstance(first, int | float) and isinstance(second, int | float)
    return numbers and abs(first - second) <= 1e-6 * max(abs(first), abs(second))


def _codes(before: Vehicle, after: Vehicle, grids: Mapping[str, Inverse]) -> tuple[Codes, ...]:
    """Codes for ten thrusts at every tabulated speed, of the thrusters whose codes change."""
    both = [
        (corrections_of(one), np.linalg.norm(inflow_of_velocity(one), axis=1))
        for one in (before, after)
    ]
    found = []
    for k, thruster in enumerate(before.thrusters):
        rows = []
        of_type = before.type_of(thruster) or ""
        grid = grids[of_type]
        at_rest = grid.limits(0.0)
        ends = np.where(np.array(_SHARES) < 0.0, at_rest.reverse_n, at_rest.forward_n)
        thrust = np.array(_SHARES) * ends
        for speed in before.of_type(of_type).tables.speed_mps:
            old, new = (
                _thruster_codes(grid, own, k, thrust, speed * float(share[k]))
                for own, share in both
            )
            rows.append(Codes(thruster.name, speed, tuple(thrust.round(2).tolist()), old, new))
        found += rows if any(one.old != one.new for one in rows) else []
    return tuple(found)


def _thruster_codes(
    grid: Inverse, own: Corrections, k: int, thrust_n: FloatArray, speed_mps: float
) -> tuple[int, ...]:
    gain = np.where(thrust_n < 0.0, own.gain[k, 1], own.gain[k, 0])
    asked = thrust_n / np.where(gain > 0.0, gain, 1.0)
    code = np.rint(grid.code(asked, np.full(asked.shape, speed_mps)))
    sent = beyond_dead_zone(code, own.lost_code[k], own.code_max[k])
    return tuple(np.rint(np.where(gain > 0.0, sent, 0.0)).astype(int).tolist())


def apply(proposal: ChangeProposal, out: Path) -> AppliedChange:
    """Write the file, keep the former one beside it, and add to the list of changes."""
    found, file = proposal.found, proposal.file
    number = next_number(changes_of(file))
    entry = AppliedChange(
        number=number,
        date_utc=now_utc(),
        reason=found.reason,
        source=seen_from(found.source, out),
        source_sha256=file_digest(found.source),
        runs=found.runs,
        before_sha256=file_digest(file),
        after_sha256=digest_of(proposal.text.encode()),
        former=f"{file.name}.{number}.before",
        changes=found.changes,
    )
    write_change(file, proposal.text, entry)
    return entry


def undo(vehicle: str, raw: Path, out: Path) -> tuple[Path, AppliedChange]:
    """Take back the last change of a vehicle's file that holds."""
    _, file = _own_file(vehicle, raw, out)
    return file, undo_last(file)
