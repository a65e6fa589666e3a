"""A season of pool runs that looks finished: envelopes with true digests, nothing computed."""

import struct
from pathlib import Path

from pipeline.plan import VehicleFolder, processed_file
from pipeline.provenance import Envelope, code_digest, file_digest, write_envelope
from pipeline.records.base import Record
from pipeline.records.trial import DayTables, PageReceipt, RunLine, RunTrial, StoredRun, TrialDay
from pipeline.stage_table import module_of
from pipeline.workflow.known_files import KnownFiles
from pipeline.workflow.pool_plan import DAY_STAGES, RUN_STAGES, PoolPlan, plan_pool

MAGIC = b"\x89MCAP0\r\n"
FIRST_NS = 1_777_000_000_000_000_000
HOUR_NS = 3_600_000_000_000


def write_log(path: Path, start_ns: int, *, closed: bool = True) -> None:
    """Write what begins and ends as a log does: the head of a chunk, and the sign of the end."""
    path.parent.mkdir(parents=True, exist_ok=True)
    chunk = struct.pack("<BQQQ", 6, 16, start_ns, start_ns)
    path.write_bytes(MAGIC + chunk + (MAGIC if closed else b""))


def make_season(root: Path, vehicle: VehicleFolder, runs: int) -> None:
    """Write logs, two hours apart, beside a vehicle file and a bench that is there."""
    for number in range(runs):
        start_ns = FIRST_NS + 2 * number * HOUR_NS
        write_log(root / vehicle.folder / f"pool/run-{number:04d}.mcap", start_ns)
    for name in ("static", "propeller", "drive", "inverse"):
        path = root / processed_file(vehicle.name, name)
        if not path.exists():
            write_envelope(path, Envelope[Record](name, vehicle.name, {}, "c0", None, "not needed"))


def finish(root: Path, vehicle: VehicleFolder) -> PoolPlan:
    """Write the result of everything that is due, as a run would have done."""
    plan = plan_pool(vehicle, root, KnownFiles())
    for stage in (*RUN_STAGES, *DAY_STAGES):
        code = code_digest(module_of(stage))
        for item in plan.pending.get(stage, ()):
            _finish_one(root, vehicle, plan, stage, item, code)
    return plan


def _finish_one(  # noqa: PLR0917 - one caller
    root: Path, vehicle: VehicleFolder, plan: PoolPlan, stage: str, item: str, code: str
) -> None:
    first, *more = plan.outputs(stage, item)
    files: dict[str, str] = {}
    if stage == "pool_run":
        more = [first.replace(".json", ".npz")]
    for name in more:
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(f"{stage} {item}")
        files[name] = file_digest(root / name)
    inputs = {}
    for file in plan.inputs(stage, item, vehicle.vehicle_file):
        inside = file.removeprefix(f"{vehicle.folder}/")
        known = f"raw/{vehicle.name}/{inside}" if inside != file else file
        inputs[known] = file_digest(root / file)
    record = _record(vehicle.name, plan, stage, item, files)
    write_envelope(root / first, Envelope[Record](stage, vehicle.name, inputs, code, record))


def _record(vehicle: str, plan: PoolPlan, stage: str, item: str, files: dict[str, str]) -> Record:
    if stage == "pool_run":
        return StoredRun(
            vehicle=vehicle, file=f"{vehicle}/pool/{item}.mcap", start_time_ns=FIRST_NS,
            duration_s=10.0, complete=True, read_bytes=1, size_bytes=1, channels=(), topics=(),
            problems=(), run=item, day="2026-04-24", table_rate_hz=50.0, quantities=(),
            files=files,
        )  # fmt: skip
    if stage == "run_trial":
        return RunTrial(vehicle=vehicle, run=item, day="", start_time_ns=0, duration_s=1.0)
    if stage == "trial_day":
        return TrialDay(vehicle=vehicle, day=item, runs=plan.days[item], why_not="not asked for")
    if stage == "day_tables":
        return DayTables(vehicle=vehicle, day=item, why_not="there are none")
    kind = "run" if stage == "run_page" else "day"
    runs = plan.days.get(item, ())
    return PageReceipt(
        kind="run" if kind == "run" else "day", name=item, files=files, title=item, errors=0,
        warnings=0, line="10 s; no warnings",
        runs=tuple(
            RunLine(name=run, line="10 s", page=f"reports/{vehicle}/runs/{run}.html")
            for run in (runs if kind == "day" else ())
        ),
    )  # fmt: skip
