"""Simulate a manoeuvre or the commands of a log, and write what the sensors would have logged."""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from pipeline import __version__
from pipeline.actions.run_summary import (
    RunSummary,
    TetherSummary,
    latch_doubts,
    summarise,
    summarise_tether,
)
from pipeline.actions.simulation_request import (
    SimulationRequest,
    allocator_of,
    check_request,
    parse_events,
    parse_winch,
    replay,
    start_time_ns,
)
from pipeline.effects.library import module_names, parse_effect
from pipeline.effects.specification import EffectSpec
from pipeline.errors import CannotComputeError
from pipeline.export.attachment_topics import topic_of_latch, topics_of_tether
from pipeline.export.log_topics import Topic
from pipeline.export.mcap_log import SIMULATED_PREFIX, write_run_log
from pipeline.export.overlay import write_overlay
from pipeline.ingest.mcap_file import RecordedFile
from pipeline.ingest.run_commands import RunCommands, read_run_commands
from pipeline.inputs.simulated_vehicle import SimulatedVehicle, load_simulated
from pipeline.provenance import code_digest, file_digest
from pipeline.simulate.context import model_of
from pipeline.simulate.effects_on import effects_on
from pipeline.simulate.events import LatchLoad, PayloadEvent, PayloadSchedule, latch_loads
from pipeline.simulate.fly import CONTROL_PERIOD_S, fly, usual_step_s
from pipeline.simulate.manoeuvre_reach import why_not_flown
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.run import Mover, Trajectory, run
from pipeline.simulate.run_conditions import RunSetup, run_setup
from pipeline.simulate.sensors import Log, measure
from pipeline.simulate.tethered_mover import TetheredMover, nominal_mover
from pipeline.types import FloatArray
from pipeline.vehicle.sensor_schema import Sensors

__all__ = ["SimulationRequest", "SimulationResult", "replay", "simulate_to_file"]


#: What is told of a latch.
_LATCH = ("module", "largest_n", "closing_n", "largest_share")


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
    tether: TetherSummary | None
    latches: tuple[LatchLoad, ...]
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
            "tether": None if self.tether is None else asdict(self.tether),
            "latches": [{key: getattr(own, key) for key in _LATCH} for own in self.latches],
            "warnings": list(self.warnings),
        }


@dataclass(frozen=True)
class _Case:
    """A run that is about to be simulated."""

    request: SimulationRequest
    one: SimulatedVehicle
    specs: tuple[EffectSpec, ...]
    true: FloatArray
    schedule: PayloadSchedule
    tethered: TetheredMover | None
    step_s: float
    commands: RunCommands | None
    setup: RunSetup

    @property
    def mover(self) -> Mover:
        """What moves the vehicle."""
        return run if self.tethered is None else self.tethered


@dataclass(frozen=True)
class _Flight:
    """A run before it is measured and written."""

    trajectory: Trajectory
    flown: str
    start_ns: int
    notes: tuple[str, ...] = ()


def simulate_to_file(request: SimulationRequest) -> SimulationResult:
    """Simulate and write the log.

    The effects change the true vehicle; autopilot and allocator believe the vehicle file. A tether
    of the nominal model moves with the vehicle. The same request with the same vehicle file gives
    the same bytes.
    """
    check_request(request)
    case = _case(request)
    one, schedule, tethered = case.one, case.schedule, case.tethered
    if request.log is None or case.commands is None:
        flight = _flown(case)
    else:
        flight = _replayed(case, request.log, case.commands)
    trajectory = flight.trajectory
    warnings = [*one.notes, *flight.notes]
    end_s = float(trajectory.time_s[-1])
    warnings += [_not_done(event, end_s) for event in schedule.due(math.inf)]
    warnings += [
        f"the winch's order at {order.time_s:g} s lies beyond the run."
        for order in ([] if tethered is None else tethered.orders)
        if order.time_s >= end_s
    ]
    sensors = one.vehicle.sensors
    if sensors is None:
        warnings.append(
            f"{one.name} has no sensors: section; the log holds the commands and the true motion."
        )
        sensors = Sensors()
    log = measure(trajectory, one.packed, sensors, vector=case.true, seed=request.seed)
    summary = summarise(trajectory, log, one.packed, case.true)
    loads = latch_loads(
        trajectory, one.packed, case.setup.model, schedule.outcomes, vector=case.true
    )
    _write(case, flight, log, loads)
    return SimulationResult(
        path=request.to,
        vehicle=one.name,
        flown=flight.flown,
        effects=tuple(sorted(str(spec) for spec in case.specs)),
        events=(*(_said(one.event) for one in schedule.outcomes), *_orders(tethered)),
        seed=request.seed,
        summary=summary,
        tether=None if tethered is None else summarise_tether(tethered.log()),
        latches=tuple(load for load in loads if load.time_s.size),
        warnings=(*warnings, *latch_doubts(loads), *summary.doubts),
    )


def _case(request: SimulationRequest) -> _Case:
    """Read vehicle and log, and check effects, events and orders against them.

    What the notes of a log say of its run is simulated, and what the user asks for on top.
    """
    orders, events = parse_winch(request), parse_events(request)
    one = load_simulated(request.vehicle, request.raw, request.out)
    packed = one.packed
    specs = tuple(parse_effect(text, packed.thruster_names) for text in request.effects)
    commands, written, late_s = None, None, 0.0
    if request.log is not None:
        commands = read_run_commands(request.log, one.vehicle, request.raw)
        written, late_s = commands.written, commands.log_start_s
    setup = run_setup(one.vehicle, model_of(one.vehicle), written)
    setup.checked(packed.vector)
    setup = setup.later(late_s)
    schedule = PayloadSchedule(
        packed,
        setup.model,
        [*setup.events, *events],
        effects_on(packed, specs),
        carried=setup.carried,
        carried_from_s=[from_s for from_s, _ in setup.ballast],
    )
    true = schedule.vector()
    return _Case(
        request=request,
        one=one,
        specs=specs,
        true=true,
        schedule=schedule,
        tethered=nominal_mover(setup.model, [*setup.orders, *orders]),
        step_s=usual_step_s(packed, true) if request.step_s is None else request.step_s,
        commands=commands,
        setup=setup,
    )


def _flown(case: _Case) -> _Flight:
    """Fly the manoeuvre."""
    request, packed = case.request, case.one.packed
    manoeuvre = MANOEUVRES[str(request.manoeuvre)]
    impossible = why_not_flown(packed, manoeuvre.name, manoeuvre.axes)
    if impossible:
        raise CannotComputeError(f"{case.one.name}: {impossible}\nNothing was written.")
    duration = manoeuvre.duration_s if request.duration_s is None else request.duration_s
    trajectory = fly(
        packed,
        manoeuvre.plan(packed, request.amplitude, duration),
        vector=case.true,
        allocator=allocator_of(case.one, request.allocator, request.out),
        step_s=case.step_s,
        change=case.schedule.change if case.schedule.events else None,
        mover=case.mover,
    )
    return _Flight(trajectory, manoeuvre.name, start_time_ns(request))


def _replayed(case: _Case, path: Path, commands: RunCommands) -> _Flight:
    """Simulate the commands of the log."""
    trajectory, notes = replay(
        case.one, commands, case.true, case.step_s, case.schedule, mover=case.mover
    )
    said = (*commands.notes, *case.setup.notes, *notes)
    return _Flight(trajectory, f"commands of {path.name}", commands.start_time_ns, said)


def _metadata(case: _Case, flight: _Flight) -> dict[str, str]:
    """Return what made the run."""
    request, time_s = case.request, flight.trajectory.time_s
    return {
        "flown": flight.flown,
        "amplitude": repr(request.amplitude),
        "duration_s": repr(float(time_s[-1] - time_s[0])),
        "effects": "; ".join(sorted(str(spec) for spec in case.specs)),
        "events": "; ".join(_said(event) for event in case.schedule.events),
        "winch": "; ".join(_orders(case.tethered)),
        "seed": str(request.seed),
        "allocator": request.allocator if request.log is None else "",
        "step_s": repr(case.step_s),
        "vehicle_file_sha256": case.one.file_digest,
        "code": code_digest(__name__, *module_names()),
        "rig2sea_version": __version__,
    }


def _write(case: _Case, flight: _Flight, log: Log, loads: Sequence[LatchLoad]) -> None:
    """Write the log; of a replay everything under /sim, beside what was measured."""
    request, one = case.request, case.one
    write = (
        partial(write_run_log, request.to, log)
        if request.log is None
        else partial(write_overlay, request.to, RecordedFile(request.log, str(request.log)), log)
    )
    write(
        vehicle_name=one.name,
        density_kgpm3=one.vehicle.water.density_kgpm3,
        gravity_mps2=one.vehicle.water.gravity_mps2,
        start_time_ns=flight.start_ns,
        truth=flight.trajectory,
        more=_attached_topics(case.tethered, loads),
        metadata=_metadata(case, flight),
    )


def _attached_topics(tethered: TetheredMover | None, loads: Sequence[LatchLoad]) -> list[Topic]:
    topics = [
        topic_of_latch(load.module, load.time_s, load.wrench, SIMULATED_PREFIX)
        for load in loads
        if load.time_s.size
    ]
    if tethered is not None:
        topics += topics_of_tether(
            tethered.log(), SIMULATED_PREFIX, winch=tethered.winch is not None
        )
    return topics


def _said(event: PayloadEvent) -> str:
    return f"{event.action} {event.module} at {event.time_s:g} s"


def _not_done(event: PayloadEvent, end_s: float) -> str:
    if event.time_s >= end_s - 1e-9:
        return f"{_said(event)} lies beyond the run."
    return (
        f"{_said(event)} did not happen: it waits for the next command, they come every "
        f"{CONTROL_PERIOD_S:g} s, and the run ends first. State it earlier, or fly longer."
    )


def _orders(tethered: TetheredMover | None) -> list[str]:
    """Say what the winch was told."""
    return [
        f"winch {'braked' if order.speed_mps == 0 else f'at {order.speed_mps:g} m/s'} from "
        f"{order.time_s:g} s on"
        for order in ([] if tethered is None else tethered.orders)
    ]
