"""Sound runs of a vehicle -> ``reference.json``: the vehicle as it was, against its file."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from pipeline.actions.identification import CORRECTED_FILE
from pipeline.actions.identification import RESULT_FILE as IDENTIFICATION_FILE
from pipeline.diagnose.case import Case
from pipeline.diagnose.regression.held_out import FileModel, Method
from pipeline.diagnose.regression.known import LEAST_SOUND, learned
from pipeline.errors import CannotComputeError, Rig2SeaError
from pipeline.inputs.gains import sound_runs
from pipeline.inputs.runs_to_identify import find_logs, read_runs
from pipeline.inputs.simulated_vehicle import SimulatedVehicle, load_packed, load_simulated
from pipeline.language import as_it_is
from pipeline.plan import POOL, processed_file
from pipeline.provenance import Envelope, code_digest, file_digest, write_envelope
from pipeline.records.identification import RunRead
from pipeline.records.reference import Prediction, ReferenceRecord, SoundRun, Width

#: Widths that are shown.
_SHOWN = 8

STAGE = "reference"
RESULT_FILE = f"{STAGE}.json"


def reference_text(record: ReferenceRecord) -> str:
    """Tell by how much sound runs differ, and whether the reference helps."""
    lines = [f"reference of {record.vehicle} from {len(record.runs)} sound runs:"]
    lines += [f"  {as_it_is(run.name)} ({run.because})" for run in record.runs]
    lines += ["", "by how much sound runs differ (standard deviation; before they were seen)"]
    moved = sorted(record.widths, key=lambda one: one.learned / one.stated, reverse=True)
    lines += [f"  {width_text(one)}" for one in moved[:_SHOWN]]
    lines += ["", "rms error of what was left out (each run in turn)"]
    lines += [f"  {row}" for row in prediction_rows(record.predictions)]
    verb = "is used by the diagnosis" if record.used else "is NOT used"
    lines += ["", f"The reference {verb}: {record.why}"]
    lines += [f"note: {note}" for note in record.notes]
    return "\n".join(lines)


def width_text(one: Width) -> str:
    """Write a width with what it was taken for before."""
    unit = "" if one.unit == "1" else f" {one.unit}"
    return f"{as_it_is(one.name)} {one.learned:.2g}{unit} ({one.stated:.2g}{unit})"


def prediction_rows(predictions: Sequence[Prediction]) -> list[str]:
    """Write a line for each quantity and time ahead, with all methods."""
    found: dict[tuple[str, float, str], list[str]] = {}
    for row in predictions:
        place = (row.quantity, row.ahead_s, row.unit)
        found.setdefault(place, []).append(f"{row.method} {row.rmse:.3g}")
    words = {"angular_velocity": "rates"}
    return [
        f"{words.get(quantity, quantity)}, {seconds:g} s ahead [{unit}]: {', '.join(texts)}"
        for (quantity, seconds, unit), texts in found.items()
    ]


@dataclass(frozen=True)
class ReferenceRequest:
    """What the user asked for; no `runs`: all that are known to be sound."""

    vehicle: str
    runs: tuple[str, ...] = ()
    to: Path | None = None
    raw: Path = Path("raw")
    out: Path = Path()


def make_reference(
    request: ReferenceRequest, tell: Callable[[str], None] = lambda _: None
) -> tuple[ReferenceRecord, Path]:
    """Learn a reference and write it; `tell` is told what is done now."""
    one = load_simulated(request.vehicle, request.raw, request.out)
    logs, refused = sound_runs(one)
    if request.runs:
        logs = dict.fromkeys(find_logs(request.runs, one), "named on the command line")
        refused = ()
    if len(logs) < LEAST_SOUND:
        raise CannotComputeError("\n".join([too_few(one, len(logs)), *refused]))
    read = read_runs([str(path) for path in logs], one, request.raw, tell)
    runs = tuple(_sound(run, one, logs) for run, _ in read)
    folder = request.out / "processed" / one.name
    identified, notes = _identified(folder / "identification", runs, one, request.out)
    case = Case(one.name, one.vehicle, one.packed, (), healthy=tuple(table for _, table in read))
    tell("predicting each run by the others")
    files: dict[Method, FileModel] = {"vehicle file": FileModel(case.packed)}
    if identified is not None:
        files["identified file"] = identified
    found = learned(case, files)
    record = ReferenceRecord(
        vehicle=one.name,
        vehicle_file_sha256=one.file_digest,
        runs=runs,
        used=found.used,
        why=found.why,
        period_s=found.best.response.period_s,
        noise_trusted=found.best.trusted,
        force=found.force,
        widths=found.widths,
        predictions=found.table,
        notes=(
            *refused,
            *notes,
            *dict.fromkeys(text for run, _ in read for text in run.warnings),
        ),
    )
    to = request.out / processed_file(one.name, STAGE)
    if request.to is not None:
        to = request.to / RESULT_FILE
    inputs = {f"raw/{one.name}/{one.file.name}": one.file_digest}
    inputs |= {run.file: run.sha256 for run in runs}
    if identified is not None:
        changed = folder / "identification" / CORRECTED_FILE
        inputs[f"processed/{one.name}/identification/{CORRECTED_FILE}"] = file_digest(changed)
    code = code_digest("pipeline.actions.reference")
    write_envelope(to, Envelope(STAGE, one.name, inputs, code, record))
    return record, to


def too_few(one: SimulatedVehicle, count: int) -> str:
    """Say that there are too few sound runs, and how a run is said to be sound."""
    there = f"{one.name} has {'one run that is' if count else 'no run that is'} known to be sound"
    return (
        f"{there}; a reference needs {LEAST_SOUND} or more, from which it is seen how much runs "
        f"differ.\nWrite `healthy: true` into the notes of each run on which the vehicle was well "
        f"({one.file.parent / POOL}/RUN.yaml), list the day under `accepted_days:` in "
        f"{one.file.name}, or name the runs."
    )


def _sound(run: RunRead, one: SimulatedVehicle, logs: Mapping[Path, str]) -> SoundRun:
    path, folder = Path(run.file), one.file.parent.resolve()
    inside = path.is_relative_to(folder)
    shown = f"raw/{one.name}/{path.relative_to(folder).as_posix()}" if inside else path.name
    return SoundRun(
        name=run.name, file=shown, sha256=run.sha256, seconds=run.seconds, because=logs[path]
    )


def _identified(
    folder: Path, runs: Sequence[SoundRun], one: SimulatedVehicle, out: Path
) -> tuple[FileModel | None, tuple[str, ...]]:
    """Read the vehicle as it was identified last; None, and why, where that cannot be compared."""
    file, result = folder / CORRECTED_FILE, folder / IDENTIFICATION_FILE
    if not file.is_file() or not result.is_file():
        return None, ()
    try:
        body = json.loads(result.read_text(encoding="utf-8"))
        fitted = {run["sha256"] for run in body["runs"]}
        packed = load_packed(file, one.name, out)
    except (OSError, ValueError, KeyError, TypeError, Rig2SeaError) as error:
        return None, (f"the identified file was not compared, it cannot be read: {error}",)
    own = frozenset(k for k, run in enumerate(runs) if run.sha256 in fitted)
    if len(own) == len(runs):
        told = (
            "the identified file was not compared: it was identified from these very runs, so no "
            "run is left of which it would be a prediction."
        )
        return None, (told,)
    return FileModel(packed, frozenset(range(len(runs))) - own), ()
