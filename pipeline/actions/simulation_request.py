"""What a simulation was asked for, and whether it can be done."""

import difflib
import math
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal

import numpy as np

from pipeline.control.inverse import Inverse, firmware_grid
from pipeline.control.paper_allocator import (
    PaperAllocator,
    corrections_of,
    inflow_of_velocity,
    other_inverses,
    rest_inverse,
)
from pipeline.errors import CannotComputeError
from pipeline.export.mcap_log import DEFAULT_START_TIME_NS, is_of_others
from pipeline.ingest.run_commands import RunCommands
from pipeline.inputs.simulated_vehicle import SimulatedVehicle, load_inverses
from pipeline.plan import UsageError
from pipeline.records.fits import InverseCharacteristic
from pipeline.records.run_table import mean_held
from pipeline.simulate.events import Action, PayloadEvent, PayloadSchedule
from pipeline.simulate.fly import CONTROL_PERIOD_S, CodeAllocator, general_allocator, run_changing
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.run import Mover, Trajectory, initial_state, run
from pipeline.simulate.tethered_mover import WinchOrder
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle

#: A longer run is not simulated at a time. [s]
LONGEST_S = 3600.0

AllocatorName = Literal["general", "paper", "paper-mooring"]


def replay(
    one: SimulatedVehicle,
    log: RunCommands,
    true: FloatArray,
    step_s: float,
    schedule: PayloadSchedule | None = None,
    *,
    mover: Mover = run,
) -> tuple[Trajectory, list[str]]:
    """Simulate the commands of a log, each held until the next.

    Thrusters are matched by name; `true` is the parameter vector that is simulated. Returns the
    run, and sentences on what had to be assumed.

    Raises `CannotComputeError` when the log lacks a thruster of the vehicle, or the run is too
    long.
    """
    missing = [name for name in one.packed.thruster_names if name not in log.names]
    if missing:
        raise CannotComputeError(
            f"the log has no commands for {', '.join(missing)} of {one.name}; it has "
            f"{', '.join(log.names)}"
        )
    if log.end_s > LONGEST_S:
        raise CannotComputeError(
            f"the log is {log.end_s:.0f} s long; at most {LONGEST_S:.0f} s are simulated at a "
            "time.\nCut it, e.g. with mcap filter --start --end."
        )
    more = [name for name in log.names if name not in one.packed.thruster_names]
    notes = [f"the log also commands {', '.join(more)}: left out."] if more else []
    state = initial_state()
    if log.start is None:
        notes.append("the log does not say how the vehicle started: taken at rest at the origin.")
    else:
        state[:3], state[3:7] = log.start.position_ned_m, log.start.quaternion
        state[7:13] = log.start.nu
    steps = max(round(log.end_s / step_s), 1)
    columns = [log.names.index(name) for name in one.packed.thruster_names]
    codes = mean_held(
        log.time_s, log.codes[:, columns], np.asarray(step_s * np.arange(steps), float), step_s
    )
    low, high = one.packed.code_limits.T
    beyond = np.logical_or(codes < low, codes > high).any(axis=0).tolist()
    if any(beyond):
        names = [name for name, out in zip(one.packed.thruster_names, beyond, strict=True) if out]
        notes.append(
            f"codes beyond the drive's range, of {', '.join(names)}, are simulated at its limits."
        )
        codes = np.clip(codes, low, high)
    times = () if schedule is None else schedule.times_s
    if schedule is None or not times:
        return mover(one.packed, codes, dt_s=step_s, vector=true, start=state), notes
    changed = run_changing(
        one.packed, codes, schedule.change, times, dt_s=step_s, start=state, mover=mover
    )
    return changed, notes


def allocator_of(one: SimulatedVehicle, name: AllocatorName, out: Path) -> CodeAllocator:
    """Return an allocator that believes the vehicle file and its bench.

    ``general`` is for any arrangement; ``paper`` eq. (6) of Kostenko 2023 with N(T, V);
    ``paper-mooring`` the same with the mooring inverse N(T).

    Raises `CannotComputeError` for eq. (6) without the geometry, or without an inverse from the
    bench.
    """
    if name == "general":
        return general_allocator(one.packed)
    geometry = one.vehicle.allocator
    if geometry is None:
        raise CannotComputeError(
            f"{one.name} has no allocator: section, which --allocator {name} takes its geometry "
            "from.\nLeave the option out: the general allocator flies any arrangement."
        )
    records = load_inverses(one.vehicle, one.name, out)

    def form(record: InverseCharacteristic, vehicle: Vehicle) -> Inverse:
        return firmware_grid(record) if name == "paper" else rest_inverse(record, vehicle)

    return PaperAllocator(
        geometry,
        form(records[""], one.vehicle),
        one.packed.thruster_names,
        direction=inflow_of_velocity(one.vehicle),
        corrections=corrections_of(one.vehicle),
        others=other_inverses(one.vehicle, records, form),
    )


@dataclass(frozen=True)
class SimulationRequest:
    """What the user asked for: a manoeuvre or a log, and everything that shapes the run.

    `attach`, `release` hold events of payload modules, ``MODULE@SECONDS``; `winch` orders of the
    tether's winch, ``SPEED@SECONDS``. `start` is the time of day at which the log begins, ISO 8601.
    """

    vehicle: str
    to: Path
    manoeuvre: str | None = None
    log: Path | None = None
    effects: tuple[str, ...] = ()
    attach: tuple[str, ...] = ()
    release: tuple[str, ...] = ()
    winch: tuple[str, ...] = ()
    amplitude: float = 1.0
    duration_s: float | None = None
    seed: int = 0
    allocator: AllocatorName = "general"
    step_s: float | None = None
    start: str | None = None
    raw: Path = Path("raw")
    out: Path = Path()


def check_request(request: SimulationRequest) -> None:
    """Refuse numbers and names that mean nothing, and a file that is no log or would be lost."""
    if request.to.suffix.lower() != ".mcap":
        raise UsageError(f"--to {request.to}: the name of a log is expected, *.mcap.")
    if not (math.isfinite(request.amplitude) and 0.0 < request.amplitude <= 10.0):
        raise UsageError(
            f"--amplitude {request.amplitude:g}: a number above 0, at most 10, is expected; 1 is "
            "the usual size."
        )
    duration = request.duration_s
    if duration is not None and not CONTROL_PERIOD_S <= duration <= LONGEST_S:
        raise UsageError(
            f"--duration {duration:g}: seconds from {CONTROL_PERIOD_S:g} to {LONGEST_S:g} are "
            "expected."
        )
    step = CONTROL_PERIOD_S if request.step_s is None else request.step_s
    parts = CONTROL_PERIOD_S / step if math.isfinite(step) and step > 0.0 else 0.0
    if parts < 1.0 - 1e-9 or abs(parts - round(parts)) > 1e-6 * parts or parts > 1e4:
        raise UsageError(
            f"--step {step:g}: a whole number of steps must fill the {CONTROL_PERIOD_S:g} s "
            "between two commands, e.g. 0.01, 0.02, 0.05, 0.1."
        )
    start_time_ns(request)
    if request.seed < 0:
        raise UsageError(f"--seed {request.seed}: a whole number from 0 is expected.")
    name = request.manoeuvre
    if name is not None and name not in MANOEUVRES:
        near = difflib.get_close_matches(name.replace("-", "_"), MANOEUVRES, n=1, cutoff=0.5)
        hint = f' Did you mean "{near[0]}"?' if near else ""
        there = ", ".join(MANOEUVRES)
        raise UsageError(f'there is no manoeuvre "{name}".{hint} There are {there}.')
    if request.log is not None:
        _check_replay(request, request.log)
    if is_of_others(request.to):
        raise UsageError(
            f"--to {request.to}: this file is there, was not written by rig2sea and would be "
            "replaced: a measured log? Name another file, or delete that one."
        )


def start_time_ns(request: SimulationRequest) -> int:
    """Return when the log of a manoeuvre begins [ns since 1970]; without a zone it is UTC."""
    if request.start is None:
        return DEFAULT_START_TIME_NS
    try:
        start = datetime.fromisoformat(request.start)
    except ValueError:
        start = None
    if start is None or not 1970 < start.year < 2200:
        raise UsageError(
            f'--start "{request.start}": a date and time is expected, e.g. 2024-05-14T09:30.'
        )
    if start.tzinfo is None:
        start = start.replace(tzinfo=UTC)
    return round(start.timestamp() * 1e6) * 1000


def _check_replay(request: SimulationRequest, log: Path) -> None:
    """Refuse what the commands of a log leave no room for, and a log that would be lost."""
    if request.to.exists() and log.exists() and request.to.samefile(log):
        raise UsageError(
            f"--to {request.to}: this is the log of --run, and would be replaced. Name another "
            "file."
        )
    for option, given in (
        ("--duration", request.duration_s is not None),
        ("--amplitude", request.amplitude != SimulationRequest.amplitude),
        ("--start", request.start is not None),
        ("--allocator", request.allocator != SimulationRequest.allocator),
    ):
        if given:
            raise UsageError(
                f"{option} shapes a manoeuvre. The commands of a log are simulated as they were "
                "given, from the first to the last: leave it out, or give --manoeuvre NAME."
            )


def parse_events(request: SimulationRequest) -> list[PayloadEvent]:
    """Read the events of payload modules, ``MODULE@SECONDS``."""
    events = []
    wanted: list[tuple[Action, str]] = [("attach", text) for text in request.attach]
    wanted += [("release", text) for text in request.release]
    for action, text in wanted:
        module, _, time = text.rpartition("@")
        try:
            events.append(PayloadEvent(float(time), action, module.strip()))
        except ValueError:
            raise UsageError(
                f'--{action} "{text}": MODULE@SECONDS is expected, e.g. module_1@30.'
            ) from None
    return events


def parse_winch(request: SimulationRequest) -> list[WinchOrder]:
    """Read the orders of the winch, ``SPEED@SECONDS``."""
    orders = []
    for text in request.winch:
        speed, _, time = text.rpartition("@")
        try:
            orders.append(WinchOrder(float(time), float(speed)))
        except ValueError:
            raise UsageError(
                f'--winch "{text}": SPEED@SECONDS is expected, metres a second, positive pays '
                "out, e.g. 0.2@30."
            ) from None
    return orders
