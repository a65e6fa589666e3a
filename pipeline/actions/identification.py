"""Runs of a vehicle -> ``identification.json`` and a corrected vehicle file."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from pipeline import __version__
from pipeline.actions.found_changes import identified_changes, source_of, write_corrected
from pipeline.errors import CannotComputeError, InputError
from pipeline.identify.channel_noise import QUANTITIES
from pipeline.identify.smoothing import Method as Smoothing
from pipeline.identify.straight_line import AXES, straight_line
from pipeline.identify.vehicle_parameters import free_parameters
from pipeline.identify.whole_vehicle import identify_vehicle
from pipeline.inputs.gains import gains_of_runs
from pipeline.inputs.no_solution import with_reason
from pipeline.inputs.runs_to_identify import healthy_runs, read_runs
from pipeline.inputs.simulated_vehicle import SimulatedVehicle, load_simulated
from pipeline.language import as_it_is
from pipeline.plan import UsageError
from pipeline.provenance import write_atomically, write_record
from pipeline.records.base import FileChange
from pipeline.records.identification import (
    Identification,
    StraightLineIdentification,
    VehicleIdentification,
)
from pipeline.records.run_table import RunTable
from pipeline.simulate.context import model_of
from pipeline.vehicle.change_list import text_with
from pipeline.vehicle.load import validated
from pipeline.vehicle.schema import Vehicle
from pipeline.vehicle.sensor_schema import Sensors
from pipeline.vehicle.yaml_text import parse

Method = Literal["both", "whole-vehicle", "straight-line"]
RESULT_FILE, CORRECTED_FILE = "identification.json", "vehicle_identified.yaml"
_NO_SENSORS = (
    "the vehicle file has no sensors: section; noise is taken from the residuals and every sensor "
    "is taken to sit at the origin."
)


@dataclass(frozen=True)
class IdentificationRequest:
    """What the user asked for; `to` None: ``processed/<vehicle>/identification``."""

    vehicle: str
    runs: tuple[str, ...]
    holdout: tuple[str, ...] = ()
    method: Method = "both"
    smoother: Smoothing = "local_polynomial"
    without: tuple[str, ...] = ()
    only: tuple[str, ...] = ()
    window_s: float | None = None
    to: Path | None = None
    raw: Path = Path("raw")
    out: Path = Path()
    suggest: bool = True
    threads: int = 2


@dataclass(frozen=True)
class IdentificationFiles:
    """The result, where it lies, and the corrected vehicle file (None where there is nothing)."""

    record: Identification
    result: Path
    corrected: Path | None
    pictures: tuple[Path, ...] = ()
    """Acceleration against thrust along each axis with straight stretches."""


def identify_runs(
    request: IdentificationRequest, tell: Callable[[str], None] = lambda _: None
) -> IdentificationFiles:
    """Identify a vehicle from logs, and write what was found; `tell` is told what is done now."""
    begin = time.perf_counter()
    one = load_simulated(request.vehicle, request.raw, request.out)
    unknown = [name for name in request.without if name not in QUANTITIES]
    if unknown:
        known = ", ".join(as_it_is(quantity) for quantity in QUANTITIES)
        raise UsageError(f"--without {unknown[0]}: one of {known} is expected.")
    fitted, judged = (
        read_runs(texts, one, request.raw, tell, request.without)
        for texts in (request.runs, request.holdout)
    )
    both = {read.file for read, _ in fitted} & {read.file for read, _ in judged}
    if both:
        raise CannotComputeError(
            f"{', '.join(sorted(both))}: given both to fit and to judge the fit by; a hold-out run "
            "is one that is kept out of the fit."
        )
    tables = [table for _, table in fitted]
    if request.method != "straight-line":
        tell(f"fitting the vehicle to the runs ({len(tables)})")
    whole, why_not = _whole(request, one, tables, [table for _, table in judged])
    lines, no_lines = _lines(request, one, tables)
    if whole is None and not lines:
        reasons = dict.fromkeys(text for text in (why_not, *no_lines.values()) if text)
        raise CannotComputeError("nothing was identified.\n" + "\n".join(reasons))
    notes = list(one.notes)
    notes += [_NO_SENSORS] if one.vehicle.sensors is None else []
    folder = request.to or request.out / "processed" / one.name / "identification"
    text, changes, more = _corrected(one, whole, [table.name for table in tables], folder)
    record = Identification(
        vehicle=one.name,
        vehicle_file_sha256=one.file_digest,
        rig2sea_version=__version__,
        runs=tuple(read for read, _ in fitted),
        holdout=tuple(read for read, _ in judged),
        whole_vehicle=whole,
        why_no_whole_vehicle=why_not,
        straight_line=lines,
        why_no_straight_line=no_lines,
        warnings=(*notes, *more),
        gains=gains_of_runs(
            one, [*tables, *(table for _, table in judged)], healthy_runs([*fitted, *judged])
        ),
        changes=changes,
        elapsed_s=round(time.perf_counter() - begin, 2),
    )
    result = folder / RESULT_FILE
    write_record(result, record)
    pictures = tuple(_write_slope(folder, line) for line in lines)
    corrected = write_corrected(folder / CORRECTED_FILE, one, text)
    return IdentificationFiles(record, result, corrected, pictures)


def _write_slope(folder: Path, line: StraightLineIdentification) -> Path:
    from pipeline.report.sections.trials import slope_figure

    path = folder / f"slope-{line.axis}.svg"
    write_atomically(path, str(slope_figure(line)))
    return path


def _whole(
    request: IdentificationRequest,
    one: SimulatedVehicle,
    tables: Sequence[RunTable],
    judged: Sequence[RunTable],
) -> tuple[VehicleIdentification | None, str]:
    if request.method == "straight-line":
        return None, "not asked for (--method straight-line)"
    model = model_of(one.vehicle)
    try:
        with with_reason("the whole-vehicle fit"):
            found = identify_vehicle(
                one.packed,
                one.vehicle.sensors or Sensors(),
                tables,
                uncertainty=model.uncertainty,
                holdout=judged,
                only=_names(request, one),
                window_s=request.window_s,
                suggest=request.suggest,
                threads=request.threads,
            )
    except CannotComputeError as error:
        return None, str(error)
    return found, ""


def _names(request: IdentificationRequest, one: SimulatedVehicle) -> tuple[str, ...] | None:
    """Names of the parameters to free; an axis stands for all of its own."""
    if not request.only:
        return None
    every = [p.name for p in free_parameters(one.packed, model_of(one.vehicle).uncertainty)]
    found: list[str] = []
    for text in request.only:
        meant = [name for name in every if name == text or name.endswith(f"_{text}")]
        if not meant:
            raise UsageError(f"--only {text}: there are {', '.join(every)}.")
        found += meant
    return tuple(found)


def _lines(
    request: IdentificationRequest, one: SimulatedVehicle, tables: Sequence[RunTable]
) -> tuple[tuple[StraightLineIdentification, ...], dict[str, str]]:
    if request.method == "whole-vehicle":
        return (), dict.fromkeys(AXES, "not asked for (--method whole-vehicle)")
    found, why_not = [], {}
    for axis in AXES:
        try:
            with with_reason(f"the slope along {axis}"):
                line = straight_line(
                    one.packed,
                    one.vehicle.sensors or Sensors(),
                    tables,
                    axis=axis,
                    method=request.smoother,
                )
            found.append(line)
        except CannotComputeError as error:
            why_not[axis] = str(error)
    return tuple(found), why_not


def _corrected(
    one: SimulatedVehicle, whole: VehicleIdentification | None, runs: Sequence[str], folder: Path
) -> tuple[str | None, tuple[FileChange, ...], tuple[str, ...]]:
    """Text of the corrected vehicle file, what it changes, and what to say of it."""
    if whole is None:
        return None, (), ()
    if whole.why_no_file:
        return None, (), (f"No corrected vehicle file was written: {whole.why_no_file}.",)
    changes = identified_changes(one, whole)
    known = [p.name for p in whole.parameters if p.stands]
    left = [p.name for p in whole.parameters if not p.stands]
    lines = [
        f"Corrected by rig2sea {__version__} identify from {', '.join(runs)}.",
        f"Identified: {', '.join(known) or 'nothing'}.",
    ]
    if left:
        lines.append(
            f"Not determined by these runs, and left as the file had it: {', '.join(left)}."
        )
    lines += [f"Changed {change.path}." for change in changes]
    try:
        original = one.file.read_text(encoding="utf-8")
        text = text_with(original, changes, source_of(runs, "identification"), "\n".join(lines))
        # a file that no command would read is none
        shown_as = str(folder / CORRECTED_FILE)
        validated(Vehicle, parse(text.encode(), shown_as), shown_as)
    except (CannotComputeError, InputError) as error:
        return None, (), (f"No corrected vehicle file was written: {error}",)
    return text, changes, ()
