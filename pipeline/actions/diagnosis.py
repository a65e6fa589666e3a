"""Runs of a vehicle -> ``diagnosis.json``, its page, the corrected vehicle file, overlay logs."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path

from pipeline import __version__
from pipeline.actions.diagnosis_page import OVERLAY_END, write_page
from pipeline.actions.found_changes import diagnosed_changes, source_of, write_corrected
from pipeline.actions.simulation import simulate_to_file
from pipeline.actions.simulation_request import SimulationRequest
from pipeline.diagnose.case import Case
from pipeline.diagnose.engine import diagnose_fully
from pipeline.diagnose.tell.file_changes import left_to_say
from pipeline.effects.specification import EffectSpec
from pipeline.errors import CannotComputeError
from pipeline.ingest.workbook import TEXT_SUFFIXES, WORKBOOK_SUFFIXES
from pipeline.inputs.gains import sound_runs
from pipeline.inputs.runs_to_identify import find_logs, read_runs
from pipeline.inputs.simulated_vehicle import SimulatedVehicle, load_simulated
from pipeline.plan import UsageError, seen_from
from pipeline.provenance import write_record
from pipeline.records.diagnosis import DiagnosisRecord
from pipeline.report.diagnosis_page import glance_of
from pipeline.stages.index_page import Question
from pipeline.vehicle.change_list import text_with
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.run_notes import run_of

TABLE_SUFFIXES = WORKBOOK_SUFFIXES | TEXT_SUFFIXES
RESULT_FILE = "diagnosis.json"


@dataclass(frozen=True)
class DiagnosisRequest:
    """What the user asked for; `to` None: ``processed/<vehicle>/diagnosis``.

    Of mooring tables ``bench_diagnosis`` there.
    """

    vehicle: str
    runs: tuple[str, ...]
    holdout: tuple[str, ...] = ()
    healthy: tuple[str, ...] = ()
    to: Path | None = None
    raw: Path = Path("raw")
    out: Path = Path()


@dataclass(frozen=True)
class DiagnosisFiles:
    """The result and where it lies; `corrected` is None where nothing of the file changes."""

    record: DiagnosisRecord
    result: Path
    corrected: Path | None
    page: Path
    overlays: tuple[Path, ...] = ()
    """One log a run: everything that was recorded, and the simulation with the effect beside it."""
    without_overlay: tuple[str, ...] = ()
    """Logs of which none could be made, each with the reason."""


def are_tables(runs: Sequence[str]) -> bool:
    """Tell whether the runs are mooring tables.

    Examples
    --------
    >>> are_tables(["new.xlsx"]), are_tables(["new.tsv"]), are_tables(["surge-steps"])
    (True, True, False)
    """
    tables = [run for run in runs if Path(run).suffix.lower() in TABLE_SUFFIXES]
    if tables and len(tables) < len(runs):
        other = next(run for run in runs if run not in tables)
        raise UsageError(
            f"{tables[0]} is a mooring table and {other} is not: give tables or pool runs."
        )
    return bool(tables)


CORRECTED_FILE = "vehicle_corrected.yaml"
#: One sound run does not show how much runs differ.
_LEAST_SOUND = 2


def diagnose_to_files(
    request: DiagnosisRequest, tell: Callable[[str], None] = lambda _: None
) -> DiagnosisFiles:
    """Diagnose logs and write what was found; `tell` is told what is done now."""
    one = load_simulated(request.vehicle, request.raw, request.out)
    request, noted = _with_sound_runs(request, one)
    runs, holdout, healthy = (
        tuple(table for _, table in read_runs(texts, one, request.raw, tell))
        for texts in (request.runs, request.holdout, request.healthy)
    )
    # before anything is written: it may go to a folder that was named as one of runs
    question = _question(request, one)
    tell(f"weighing what explains the runs ({len(runs) + len(holdout)})")
    case = Case(one.name, one.vehicle, one.packed, runs, holdout, healthy)
    found = diagnose_fully(case)
    record, specs = found.record, found.specs
    every = [table.known for table in (*runs, *holdout, *healthy) if table.known is not None]
    noted += tuple(dict.fromkeys(note for known in every for note in known.notes))
    record = record.model_copy(update={"notes": (*record.notes, *noted)})
    top = next(iter(record.ranking), None)
    more = {
        "glance": glance_of(record),
        "vehicle_file_sha256": one.file_digest,
        "changes": diagnosed_changes(one, top, specs) if specs else (),
    }
    record = record.model_copy(update=more)
    folder = request.to or request.out / "processed" / one.name / "diagnosis"
    result = folder / RESULT_FILE
    write_record(result, record)
    text = _corrected(one, record, specs)
    corrected = write_corrected(folder / CORRECTED_FILE, one, text)
    if corrected is not None:
        load_vehicle(corrected)  # a file that no command would read is none
    overlays, without = _write_overlays(request, folder, one, specs, tell)
    files = [result, *([] if corrected is None else [corrected]), *overlays]
    page = write_page(record, question, request.out, request.to, files)
    return DiagnosisFiles(record, result, corrected, page, overlays, without)


def _question(request: DiagnosisRequest, one: SimulatedVehicle) -> Question:
    """Tell which logs the answer is of, by where they lie; no run may both speak and judge."""
    given = [find_logs(texts, one) for texts in (request.runs, request.holdout, request.healthy)]
    roles = (
        "to diagnose and to judge by",
        "to diagnose and as healthy",
        "to judge by and as healthy",
    )
    for (first, second), both in zip(combinations(given, 2), roles, strict=True):
        twice = set(first) & set(second)
        if twice:
            names = ", ".join(sorted(path.name for path in twice))
            raise CannotComputeError(f"{names}: given both {both}; a run can be one of these.")
    runs, holdout, healthy = (tuple(seen_from(o, request.out) for o in own) for own in given)
    return Question(runs, holdout, healthy)


def _with_sound_runs(
    request: DiagnosisRequest, one: SimulatedVehicle
) -> tuple[DiagnosisRequest, tuple[str, ...]]:
    """Take the vehicle's sound runs for healthy ones where none are named; say so.

    Not where one of them is asked of, nor where there is but one, which does not show how much runs
    differ.
    """
    if request.healthy:
        return request, ()
    sound, _ = sound_runs(one)
    asked = set(find_logs((*request.runs, *request.holdout), one))
    if len(sound) < _LEAST_SOUND or asked & set(sound):
        return request, ()
    names = ", ".join(f"{run_of(path)} ({why})" for path, why in sound.items())
    told = f"no healthy runs were named; these are known to be sound and were taken: {names}."
    return replace(request, healthy=tuple(str(path) for path in sound)), (told,)


def _write_overlays(
    request: DiagnosisRequest,
    folder: Path,
    one: SimulatedVehicle,
    specs: Sequence[EffectSpec],
    tell: Callable[[str], None],
) -> tuple[tuple[Path, ...], tuple[str, ...]]:
    """Simulate the held-out runs (all runs where none is) with the effects of the verdict.

    A free run of minutes may leave the finite numbers where the windows of the answer did not, and
    a log may be too long for one: such runs are named, each with the reason. No log of the
    question is taken away or written over, wherever it lies.
    """
    logs = find_logs(request.holdout or request.runs, one)
    given = find_logs((*request.runs, *request.holdout, *request.healthy), one)
    here = [path.name for path in given if path.parent == folder.resolve()]
    paths = [folder / name for name in _overlay_names(logs, here)]
    # what an earlier diagnosis left would pass for this one's
    for old in paths if request.to is not None else folder.glob(f"*{OVERLAY_END}"):
        if old.resolve() not in given:
            old.unlink(missing_ok=True)
    if not specs:
        return (), ()
    written, without = [], []
    for log, path in zip(logs, paths, strict=True):
        tell(f"simulating {log.name} with the effect")
        asked = SimulationRequest(
            str(one.file.parent),
            path,
            log=log,
            effects=tuple(str(spec) for spec in specs),
            raw=request.raw,
            out=request.out,
        )
        try:
            written.append(simulate_to_file(asked).path)
        except CannotComputeError as error:
            without.append(f"{log.name}: {error}")
    return tuple(written), tuple(without)


def _overlay_names(logs: Sequence[Path], taken: Sequence[str] = ()) -> list[str]:
    """Name the logs with the effect after their runs; runs of one name are counted.

    `taken` are names of files that stay. Names that differ in capitals alone count as one: to some
    disks they are.

    >>> _overlay_names([Path("mon/a.mcap"), Path("tue/A.mcap"), Path("a-2.mcap")])
    ['a_with_effect.mcap', 'A-2_with_effect.mcap', 'a-2-2_with_effect.mcap']
    """
    used = {name.lower() for name in taken}
    names = []
    for log in logs:
        name, number = f"{run_of(log)}{OVERLAY_END}", 1
        while name.lower() in used:
            number += 1
            name = f"{run_of(log)}-{number}{OVERLAY_END}"
        used.add(name.lower())
        names.append(name)
    return names


def _corrected(
    one: SimulatedVehicle, record: DiagnosisRecord, specs: tuple[EffectSpec, ...]
) -> str | None:
    """Text of the corrected vehicle file; None where the verdict changes nothing."""
    if not specs:
        return None
    changes = record.changes
    lines = [
        f"Corrected by rig2sea {__version__} diagnose from {', '.join(record.runs)}.",
        record.verdict.sentence,
        *(f"Changed {change.path}." for change in changes),
    ]
    rest = left_to_say(specs, {change.path: change.value for change in changes})
    if rest:
        lines.append("No key of this file can say: " + " ".join(rest))
    original = one.file.read_text(encoding="utf-8")
    return text_with(original, changes, source_of(record.runs), "\n".join(lines))
