"""A new mooring table, read and judged against the vehicle's thruster model: diagnosis.json."""

from collections.abc import Sequence
from pathlib import Path

from pipeline.actions.diagnosis import RESULT_FILE, DiagnosisFiles, DiagnosisRequest
from pipeline.actions.diagnosis_page import write_page
from pipeline.diagnose.bench.engine import diagnose_bench
from pipeline.diagnose.bench.model import ThrusterAtRest, bench_model
from pipeline.diagnose.bench.table import BenchTable, bench_table
from pipeline.errors import CannotComputeError, InputError
from pipeline.ingest.bench_file import source_name
from pipeline.ingest.mooring import read_mooring_tables
from pipeline.inputs.vehicle_place import find_vehicle, result_of
from pipeline.plan import UsageError, seen_from
from pipeline.provenance import file_digest, write_record
from pipeline.records.fits import StaticCharacteristic
from pipeline.records.measurements import MooringRecord
from pipeline.stages.index_page import Question
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.schema import Vehicle


def diagnose_table_to_file(request: DiagnosisRequest) -> DiagnosisFiles:
    """Diagnose mooring tables, several as one test of one thruster, and write the answer.

    Without `to` the folder is ``processed/<vehicle>/bench_diagnosis``.
    """
    if request.healthy:
        raise UsageError(
            "--healthy takes pool runs; for mooring tables put a healthy one into mooring/ of the "
            f"vehicle and run `rig2sea run {request.vehicle}`."
        )
    name, file = find_vehicle(request.vehicle, request.raw, request.out)
    vehicle = load_vehicle(file)
    paths, held = (
        [_table(one, file.parent, name) for one in texts]
        for texts in (request.runs, request.holdout)
    )
    twice = {path for path in held if path in paths}
    if twice:
        raise UsageError(f"{min(twice)} is both diagnosed and held out.")
    model, notes = _model(vehicle, name, file, request.out)
    table, said = _read(paths, vehicle, model)
    holdout = None
    if held:
        holdout, more = _read(held, vehicle, model)
        said += more
        shared = [one for one in table.channels if one in holdout.channels]
        lacking = tuple(one for one in model.channels if one not in shared)
        if lacking:
            table, _ = _read(paths, vehicle, model, lacking)
            holdout, _ = _read(held, vehicle, model, lacking)
    record = diagnose_bench(model, table, holdout, notes=(*notes, *said))
    folder = request.to or request.out / "processed" / record.vehicle / "bench_diagnosis"
    result = folder / RESULT_FILE
    write_record(result, record)
    runs, others = (tuple(seen_from(one, request.out) for one in own) for own in (paths, held))
    page = write_page(record, Question(runs, others), request.out, request.to, (result,))
    return DiagnosisFiles(record, result, None, page)


def _table(text: str, folder: Path, vehicle: str) -> Path:
    named = [] if "/" in text or "\\" in text else [folder / "mooring" / text]
    for path in (Path(text), *named):
        if path.is_file():
            return path.resolve()
    raise UsageError(f"{vehicle} has no mooring table {text}, and there is no such file.")


def _model(
    vehicle: Vehicle, name: str, file: Path, out: Path
) -> tuple[ThrusterAtRest, tuple[str, ...]]:
    """Gather the thruster model from the results of the vehicle's bench data."""
    static, inputs, why = result_of(name, out, "static", StaticCharacteristic)
    mooring, more, why_too = result_of(name, out, "mooring", MooringRecord)
    if static is None and mooring is None:
        raise CannotComputeError(
            f"{name} has no thruster model to judge the table against: {why} {why_too}\n"
            f"Run `rig2sea run {name}` with its bench data first."
        )
    model = bench_model(vehicle, static, mooring)
    stated = (inputs or more).get(f"raw/{name}/{file.name}")
    if stated is None or stated == file_digest(file):
        return model, ()
    changed = (
        f"{file.name} was changed after the bench results were computed; `rig2sea run {name}` "
        "brings them up to date."
    )
    return model, (changed,)


def _read(
    paths: Sequence[Path], vehicle: Vehicle, model: ThrusterAtRest, without: tuple[str, ...] = ()
) -> tuple[BenchTable, list[str]]:
    record = read_mooring_tables(paths, vehicle, paths[0].parent)
    # What all tables together show does not count: at whatever supply they are is what the
    # diagnosis finds out, and of too few codes it speaks itself.
    all_tables = source_name(min(paths).parent, paths[0].parent)
    problems = [one for one in record.problems if one.place.file != all_tables]
    usable = [point for point in record.points if not point.marks]
    errors = [one for one in problems if one.severity == "error"]
    if errors:
        raise InputError(errors[0])
    if not usable:
        shown = ", ".join(path.name for path in paths)
        raise CannotComputeError(
            f"{shown}: no usable reading of thrust against code or pulse width was found; see "
            "what `rig2sea check` says of the file."
        )
    table = bench_table(
        record.points,
        model,
        name="+".join(path.stem for path in paths),
        tare_drift_n=record.tare_drift_n,
        without=without,
    )
    return table, [str(one) for one in problems if one.severity == "warning"]
