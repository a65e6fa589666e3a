"""Simulate a manoeuvre or the commands of a log, and write what the sensors would have logged."""

import difflib
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from pipeline import __version__
from pipeline.control.inverse import firmware_grid
from pipeline.control.paper_allocator import PaperAllocator
from pipeline.effects.discovery import module_names
from pipeline.effects.library import apply_effects, parse_effect
from pipeline.errors import CannotComputeError
from pipeline.export.mcap_log import DEFAULT_START_TIME_NS, write_run_log
from pipeline.ingest.command_log import CommandLog, read_command_log
from pipeline.plan import UsageError
from pipeline.provenance import code_digest, file_digest
from pipeline.simulate.context import model_of
from pipeline.simulate.events import Action, PayloadEvent, PayloadSchedule
from pipeline.simulate.fly import (
    CONTROL_PERIOD_S,
    Allocator,
    Change,
    fly,
    general_allocator,
    run_changing,
    usual_step_s,
)
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.run import Trajectory, initial_state, run
from pipeline.simulate.sensors import Log, measure
from pipeline.stages.run_summary import RunSummary, summarise
from pipeline.stages.simulated_vehicle import SimulatedVehicle, load_inverse, load_simulated
from pipeline.types import FloatArray
from pipeline.vehicle.sensor_schema import Sensors

LONGEST_S = 3600.0


@dataclass(frozen=True)
class SimulationRequest:
    """What the user asked for: a manoeuvre or a log, and everything that shapes the run.

    `attach`, `release` hold events of payload modules, ``MODULE@SECONDS``.
    """

    vehicle: str
    to: Path
    manoeuvre: str | None = None
    log: Path | None = None
    effects: tuple[str, ...] = ()
    attach: tuple[str, ...] = ()
    release: tuple[str, ...] = ()
    amplitude: float = 1.0
    duration_s: float | None = None
    seed: int = 0
    allocator: Literal["general", "paper"] = "general"
    step_s: float | None = None
    raw: Path = Path("raw")
    out: Path = Path()


@dataclass(frozen=True)
class SimulationResult:
    """What was simulated, and what is worth knowing of it."""

    path: Path
    vehicle: str
    flown: str
    effects: tuple[str, ...]
    events: tuple[str, ...]
    seed: int
    summary: RunSummary
    warnings: tuple[str, ...]

    def to_json(self) -> dict[str, Any]:
        """Return the plain values of ``--json``."""
        return {
            "schema": "rig2sea/simulate/1",
            "file": str(self.path),
            "sha256": file_digest(self.path),
            "vehicle": self.vehicle,
            "flown": self.flown,
            "effects": list(self.effects),
            "events": list(self.events),
            "seed": self.seed,
            **asdict(self.summary),
            "warnings": list(self.warnings),
        }


def simulate_to_file(request: SimulationRequest) -> SimulationResult:
    """Simulate and write the log.

    The effects change the true vehicle; autopilot and allocator believe the vehicle file. The same
    request with the same vehicle file gives the same bytes.

    Raises
    ------
    UsageError
        For a vehicle or manoeuvre that does not exist, or a number out of its range.
    InputError, CannotComputeError
        For files, effects and vehicles that cannot be used, and an output that cannot be written.
    """
    _check(request)
    if request.manoeuvre is not None and request.manoeuvre not in MANOEUVRES:
        raise UsageError(_unknown_manoeuvre(request.manoeuvre))
    one = load_simulated(request.vehicle, request.raw, request.out)
    names = one.packed.thruster_names
    specs = tuple(parse_effect(text, names) for text in request.effects)
    true = apply_effects(one.packed.vector, specs, one.packed.context)
    schedule = PayloadSchedule(
        one.packed,
        model_of(one.vehicle),
        parse_events(request),
        lambda vector: apply_effects(vector, specs, one.packed.context),
    )
    change = schedule.change if schedule.events else None
    step_s = usual_step_s(one.packed, true) if request.step_s is None else request.step_s
    warnings = list(one.notes)
    if request.log is not None:
        commands = read_command_log(request.log)
        trajectory, note = replay(one, commands, true, step_s, schedule)
        warnings += note
        flown, start_ns = f"commands of {request.log.name}", commands.start_time_ns
    else:
        trajectory = _flown(one, request, true, step_s, change)
        flown, start_ns = str(request.manoeuvre), DEFAULT_START_TIME_NS
    warnings += [f"{_said(event)} lies beyond the run." for event in schedule.due(math.inf)]
    sensors = one.vehicle.sensors
    if sensors is None:
        warnings.append(
            f"{one.name} has no sensors: section; the log holds the commands and the true motion."
        )
        sensors = Sensors()
    log = measure(trajectory, one.packed, sensors, vector=true, seed=request.seed)
    summary = summarise(trajectory, log, one.packed, true)
    metadata = {
        "flown": flown,
        "amplitude": repr(request.amplitude),
        "duration_s": repr(float(trajectory.time_s[-1] - trajectory.time_s[0])),
        "effects": "; ".join(sorted(str(spec) for spec in specs)),
        "events": "; ".join(_said(event) for event in schedule.events),
        "seed": str(request.seed),
        "allocator": request.allocator if request.log is None else "",
        "step_s": repr(step_s),
        "vehicle_file_sha256": one.file_digest,
        "code": code_digest(__name__, *module_names()),
        "rig2sea_version": __version__,
    }
    _write(request, one, log, trajectory=trajectory, metadata=metadata, start_ns=start_ns)
    return SimulationResult(
        path=request.to,
        vehicle=one.name,
        flown=flown,
        effects=tuple(sorted(str(spec) for spec in specs)),
        events=tuple(_said(outcome.event) for outcome in schedule.outcomes),
        seed=request.seed,
        summary=summary,
        warnings=(*warnings, *summary.doubts),
    )


def _write(
    request: SimulationRequest,
    one: SimulatedVehicle,
    log: Log,
    *,
    trajectory: Trajectory,
    metadata: dict[str, str],
    start_ns: int,
) -> None:
    """Write the log; of a replay all but the commands goes under /sim, beside what was measured."""
    simulated = None
    if request.log is not None:
        simulated = {name: channel for name, channel in log.items() if name != "command"}
        log = {"command": log["command"]}
    write_run_log(
        request.to,
        log,
        vehicle_name=one.name,
        density_kgpm3=one.vehicle.water.density_kgpm3,
        gravity_mps2=one.vehicle.water.gravity_mps2,
        truth=trajectory,
        simulated=simulated,
        metadata=metadata,
        start_time_ns=start_ns,
    )


def _check(request: SimulationRequest) -> None:
    """Refuse numbers that mean nothing."""
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
    if request.seed < 0:
        raise UsageError(f"--seed {request.seed}: a whole number from 0 is expected.")


def _unknown_manoeuvre(name: str) -> str:
    near = difflib.get_close_matches(name.replace("-", "_"), MANOEUVRES, n=1, cutoff=0.5)
    hint = f' Did you mean "{near[0]}"?' if near else ""
    return f'there is no manoeuvre "{name}".{hint} There are {", ".join(MANOEUVRES)}.'


def parse_events(request: SimulationRequest) -> list[PayloadEvent]:
    """Read the events of payload modules, ``MODULE@SECONDS``.

    Raises
    ------
    UsageError
        For a text of another form.
    """
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


def _said(event: PayloadEvent) -> str:
    return f"{event.action} {event.module} at {event.time_s:g} s"


def _flown(
    one: SimulatedVehicle,
    request: SimulationRequest,
    true: FloatArray,
    step_s: float,
    change: Change | None,
) -> Trajectory:
    manoeuvre = MANOEUVRES[str(request.manoeuvre)]
    duration = manoeuvre.duration_s if request.duration_s is None else request.duration_s
    return fly(
        one.packed,
        manoeuvre.plan(one.packed, request.amplitude, duration),
        vector=true,
        allocator=_allocator(one, request),
        step_s=step_s,
        change=change,
    )


def _allocator(one: SimulatedVehicle, request: SimulationRequest) -> Allocator:
    if request.allocator == "general":
        return general_allocator(one.packed)
    geometry = one.vehicle.allocator
    if geometry is None:
        raise CannotComputeError(
            f"{one.name} has no allocator: section, which --allocator paper takes its geometry "
            "from.\nLeave the option out: the general allocator flies any arrangement."
        )
    inverse = firmware_grid(load_inverse(one.name, request.out))
    return PaperAllocator(geometry, inverse, one.packed.thruster_names)


def replay(
    one: SimulatedVehicle,
    log: CommandLog,
    true: FloatArray,
    step_s: float,
    schedule: PayloadSchedule | None = None,
) -> tuple[Trajectory, list[str]]:
    """Simulate the commands of a log, each held until the next.

    Parameters
    ----------
    one : SimulatedVehicle
        The vehicle.
    log : CommandLog
        What was commanded; thrusters are matched by name.
    true : ndarray
        Parameter vector that is simulated.
    step_s : float
        Integration step. [s]
    schedule : PayloadSchedule, optional
        Modules that come and go.

    Returns
    -------
    tuple
        The run, and sentences on what had to be assumed.

    Raises
    ------
    CannotComputeError
        When the log lacks a thruster of the vehicle, or the run is too long.
    """
    missing = [name for name in one.packed.thruster_names if name not in log.names]
    if missing:
        raise CannotComputeError(
            f"the log has no commands for {', '.join(missing)} of {one.name}; it has "
            f"{', '.join(log.names)}"
        )
    if log.time_s[-1] > LONGEST_S:
        raise CannotComputeError(
            f"the log is {log.time_s[-1]:.0f} s long; at most {LONGEST_S:.0f} s are simulated at "
            "a time"
        )
    notes = _ignored(log.names, one.packed.thruster_names)
    if log.start is None:
        notes.append("the log does not say how the vehicle started: taken at rest at the origin.")
        state = initial_state()
    else:
        state = initial_state()
        state[:3], state[3:7] = log.start.position_ned_m, log.start.quaternion
        state[7:13] = log.start.nu
    steps = max(round(float(log.time_s[-1]) / step_s), 1)
    at = np.searchsorted(log.time_s, step_s * np.arange(steps) + 1e-6, side="right") - 1
    columns = [log.names.index(name) for name in one.packed.thruster_names]
    codes = log.codes[np.clip(at, 0, None)][:, columns]
    if schedule is None or not schedule.events:
        return run(one.packed, codes, dt_s=step_s, vector=true, start=state), notes
    times = [event.time_s for event in schedule.events]
    changed = run_changing(one.packed, codes, schedule.change, times, dt_s=step_s, start=state)
    return changed, notes


def _ignored(names: Sequence[str], known: Sequence[str]) -> list[str]:
    more = [name for name in names if name not in known]
    return [f"the log also commands {', '.join(more)}: left out."] if more else []
