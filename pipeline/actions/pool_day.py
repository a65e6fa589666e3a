"""``rig2sea plan``: the next pool day of a vehicle, its page and logs, and what was flown of it."""

import csv
import io
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.export.mcap_log import write_run_log
from pipeline.identify.pool_plan import MARGIN, WANTED, ChosenRuns, PlanCandidate, plan_pool_day
from pipeline.ingest.log_files import log_start_ns, logs_of
from pipeline.inputs.simulated_vehicle import SimulatedVehicle, load_simulated
from pipeline.plan import POOL, report_file
from pipeline.provenance import write_atomically, write_record
from pipeline.records.pool_day import FlownOfPlan, PlannedRun, PoolDay, Promise
from pipeline.report.html import crumbs, placed, write_page
from pipeline.report.plain_words import manoeuvre_words
from pipeline.simulate.context import model_of
from pipeline.vehicle.run_notes import run_of

RESULT, PAGE = "plan.json", "plan.html"
_NORMAL_95 = 1.96


@dataclass(frozen=True)
class PoolDayFiles:
    """The plan, where it lies, and what became of the one before."""

    record: PoolDay
    result: Path
    page: Path
    flown: tuple[FlownOfPlan, ...]


def plan_day(
    vehicle: str,
    minutes: float,
    *,
    pool_m: tuple[float, float, float] | None,
    to: Path | None,
    raw: Path,
    out: Path,
    tell: Callable[[str], None],
) -> PoolDayFiles:
    """Plan a day, write its page, logs and codes, and hold the last plan against what was flown."""
    one = load_simulated(vehicle, raw, out)
    sensors = one.vehicle.sensors
    if sensors is None:
        raise CannotComputeError(
            f"{one.file} has no sensors: section, so nobody can say what a run would tell. State "
            "what measures."
        )
    lasts = one.vehicle.battery_minutes
    minutes = minutes if lasts is None else min(minutes, lasts)
    result = out / "processed" / one.name / RESULT
    flown = flown_of_plan(result, one)
    chosen = plan_pool_day(
        one.packed,
        sensors,
        model_of(one.vehicle).uncertainty,
        total_s=60.0 * minutes,
        room_m=pool_m,
        tell=tell,
    )
    folder = out / "reports" / one.name / "plan" if to is None else to
    record = _record(one, chosen, minutes, pool_m)
    for planned, run in zip(record.runs, chosen.runs, strict=True):
        write_atomically(folder / planned.codes, codes_csv(run))
        write_run_log(
            folder / planned.log,
            run.log,
            vehicle_name=one.name,
            density_kgpm3=one.vehicle.water.density_kgpm3,
            gravity_mps2=one.vehicle.water.gravity_mps2,
            truth=run.trajectory,
            metadata={"planned": planned.manoeuvre},
        )
    write_record(result, record)
    from pipeline.report.pool_day_page import pool_day_page

    page = folder / PAGE
    own = out / report_file(one.name)
    index, there = out / "reports/index.html", ((one.name, own),) if own.is_file() else ()
    text = pool_day_page(
        record,
        flown,
        [run.trajectory for run in chosen.runs],
        crumbs=crumbs(page, *there, index=index)[not index.is_file() :],
        assets=placed(out / "reports/assets" if to is None else to / "assets", page),
    )
    write_page(text, page)
    return PoolDayFiles(record, result, page, flown)


def flown_of_plan(file: Path, one: SimulatedVehicle) -> tuple[FlownOfPlan, ...]:
    """Hold a plan, if any, against the logs that are later: by manoeuvre, in their names."""
    try:
        last = PoolDay.model_validate_json(file.read_text(encoding="utf-8"))
        since_ns = file.stat().st_mtime_ns
    except (OSError, ValueError):
        return ()
    logs = [
        log
        for log in logs_of(one.file.parent / POOL)
        if max(log_start_ns(log) or 0, log.stat().st_mtime_ns) >= since_ns
    ]
    found = []
    for planned in last.runs:
        name = planned.manoeuvre.replace("_", "-")
        own = next((log for log in logs if name in run_of(log).replace("_", "-")), None)
        if own is not None:
            logs.remove(own)
        how = f"flown as {run_of(own)}." if own is not None else "not flown."
        text = f"{planned.number}. {manoeuvre_words(planned.manoeuvre)}: {how}"
        log, number = None if own is None else own.name, planned.number
        found.append(FlownOfPlan(number=number, manoeuvre=planned.manoeuvre, log=log, text=text))
    return tuple(found)


def _record(
    one: SimulatedVehicle, chosen: ChosenRuns, minutes: float, pool_m: tuple[float, ...] | None
) -> PoolDay:
    runs = []
    for number, (run, helps) in enumerate(zip(chosen.runs, chosen.helps, strict=True), start=1):
        stem = f"{number:02d}-{run.manoeuvre.replace('_', '-')}"
        runs.append(
            PlannedRun(
                number=number,
                manoeuvre=run.manoeuvre,
                amplitude=run.amplitude,
                duration_s=run.duration_s,
                room_m=(float(run.room_m[0]), float(run.room_m[1]), float(run.room_m[2])),
                what_for=tuple(chosen.parameters[k].name for k in helps),
                log=f"{stem}.mcap",
                codes=f"{stem}.csv",
            )
        )
    promises = []
    for parameter, after in zip(chosen.parameters, chosen.after, strict=True):
        share = min(MARGIN * float(after), 1.0)
        whole = _NORMAL_95 * parameter.prior_std
        promises.append(
            Promise(
                name=parameter.name,
                unit=parameter.unit,
                meaning=parameter.meaning,
                value=parameter.nominal,
                half_width_before=whole,
                half_width=share * whole,
                wanted=WANTED * whole,
                reached=share <= WANTED,
            )
        )
    return PoolDay(
        vehicle=one.name,
        vehicle_file_sha256=one.file_digest,
        minutes=minutes,
        pool_m=pool_m,
        runs=tuple(runs),
        promises=tuple(promises),
        total_s=sum(run.duration_s for run in chosen.runs),
        usual_s=chosen.usual_s,
        usual_mean_share=float(np.mean(chosen.usual)),
        mean_share=float(np.mean(chosen.after)),
        left_out=chosen.left_out,
        notes=(
            "The vehicle file states no battery_minutes, so charge is not counted."
            if one.vehicle.battery_minutes is None
            else f"One charge lasts {one.vehicle.battery_minutes:g} minutes: no plan is longer.",
            *(["No pool was given, so the room of the tracks is not counted."] * (pool_m is None)),
        ),
    )


def codes_csv(run: PlanCandidate) -> str:
    """Return the codes over time of a run, a row for each command [s, code]."""
    command = run.log["command"]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["time_s", *command.columns])
    changed = np.any(np.diff(command.values, axis=0, prepend=np.nan) != 0.0, axis=1)
    for time_s, codes in zip(command.valid_s[changed], command.values[changed], strict=True):
        writer.writerow([f"{time_s:.3f}", *(f"{code:g}" for code in codes)])
    return text.getvalue()
