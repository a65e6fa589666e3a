"""Make one case: fly the true vehicle, read its instruments, write down what was done to it.

A case is made from its specification and one seed, so it can be made again alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from pipeline.blind.draws import Drawn
from pipeline.blind.flying import (
    CaseWorld,
    Fault,
    FlownCase,
    Patient,
    VehicleLost,
    fly_all,
    read_runs,
    stage_of,
)
from pipeline.blind.label import CaseLabel, TrueEffect
from pipeline.blind.outside import Trouble
from pipeline.blind.sizing import (
    CHANNELS,
    WINDOW,
    fault_that_shows,
    gap_ratio,
    healthy_floors,
    ratios,
    trace_of_runs,
)
from pipeline.blind.subject import BlindSubject, variant_for
from pipeline.blind.truth.craft import Craft
from pipeline.blind.truth.flight import TruthFlight
from pipeline.blind.truth.kernel_flight import SAMPLES
from pipeline.blind.truth.manoeuvres import SETS
from pipeline.blind.truth.sensors import Log, drawn, some_weather
from pipeline.errors import CannotComputeError
from pipeline.records.run_table import RunTable
from pipeline.types import FloatArray

REGIMES = ("speed", "command", "turning", "depth", "wall", "time")

#: How often a fault under which the vehicle is lost is made smaller, and by what factor.
_TRIES, _SMALLER = 6, 0.7


def regimes_of(
    trace: FloatArray, floors: FloatArray, flights: Sequence[TruthFlight], craft: Craft
) -> dict[str, float]:
    """Rank correlation (Spearman) of the gap in windows with each of `REGIMES` that varies.

    `trace` (windows, k, 12) is what the fault does, flight after flight; `craft` the stated
    vehicle: its walls and largest codes.
    """
    known = np.isfinite(floors)
    gap = np.sqrt((trace[:, :, known] ** 2 / floors[known] ** 2).mean(axis=(1, 2)))
    rows = [row for flight in flights for row in _rows(flight, craft)]
    table = np.array(rows)
    out = {}
    for k, name in enumerate(REGIMES):
        values = table[:, k]
        if np.isfinite(values).all() and np.ptp(values) > 1e-6 and np.ptp(gap) > 0.0:
            out[name] = float(np.corrcoef(_rank(values), _rank(gap))[0, 1])
    return out


def _rank(values: FloatArray) -> FloatArray:
    return np.argsort(np.argsort(values)).astype(float)


def _rows(flight: TruthFlight, craft: Craft) -> list[tuple[float, ...]]:
    """Speed, command level, turning, depth, distance to the wall, time of each window."""
    out: list[tuple[float, ...]] = []
    for first in range(0, len(flight.commands) - WINDOW + 1, WINDOW):
        motion = slice(first * SAMPLES, (first + WINDOW) * SAMPLES)
        ground, place = flight.ground[motion], flight.place[motion]
        level = np.abs(flight.commands[first : first + WINDOW]) / craft.code_max
        away = np.inf
        for wall in craft.walls:
            away = min(away, float(((place - wall[:3]) @ wall[3:]).mean()))
        out.append(
            (
                float(np.linalg.norm(ground[:, :3], axis=1).mean()),
                float(level.mean()),
                float(np.abs(ground[:, 5]).mean()),
                float(place[:, 2].mean()),
                away,
                float(first),
            )
        )
    return out


@dataclass(frozen=True)
class CaseSpec:
    """What a case is.

    `kind` is none, single, pair, outside or leave_one_out; `what` the effects (or the trouble);
    `severity` the wanted gap ratio; `manoeuvres` a name of `SETS`; `healthy` how many healthy runs
    there are; `missing` instruments that are not logged.
    """

    kind: str
    what: tuple[str, ...] = ()
    severity: float = 6.0
    manoeuvres: str = "trial"
    healthy: int = 3
    missing: tuple[str, ...] = ()
    duration_s: float = 180.0
    seed: int = 0


@dataclass(frozen=True)
class GeneratedCase:
    """A case in memory; `logs` has the readings of each run by name."""

    spec: CaseSpec
    subject: BlindSubject
    runs: tuple[RunTable, ...]
    holdout: tuple[RunTable, ...]
    healthy: tuple[RunTable, ...]
    label: CaseLabel
    logs: dict[str, Log] = field(repr=False)


def generate(subject: BlindSubject, spec: CaseSpec) -> GeneratedCase:
    """Make a case of a vehicle, or of a variant of it where the effect needs one."""
    for effect in spec.what:
        subject = variant_for(subject, effect)
    seeds = np.random.SeedSequence(spec.seed).spawn(5)
    rng = np.random.default_rng(seeds[0])
    stage = stage_of(subject, spec.missing, some_weather(rng))
    model = subject.vehicle.model
    if model is None:
        raise CannotComputeError(f"{subject.name} has no model: section")
    well = drawn(stage.stated, model.uncertainty, rng)
    floors = healthy_floors(subject, spec.manoeuvres, spec.missing)
    names, held = SETS[spec.manoeuvres]
    every = (*names, *held)
    durations = (spec.duration_s,) * len(every)
    sized = [
        fault_that_shows(
            what,
            stage,
            well,
            wanted=spec.severity,
            floors=floors,
            kinds=every,
            durations_s=durations,
            seeds=seeds[1],
            rng=rng,
        )
        for what in spec.what
    ]
    faults, sizes = tuple(fault for fault, _ in sized), tuple(size for _, size in sized)
    patient, flown = _flown(stage, Patient(well, faults, sizes), every, spec, seeds[2])
    runs, logs = read_runs(stage, flown, "run", seeds[3])
    healthy: list[RunTable] = []
    if spec.healthy:
        kinds = [every[k % len(every)] for k in range(spec.healthy)]
        _, sound = _flown(stage, Patient(well), kinds, spec, seeds[4])
        healthy, more = read_runs(stage, sound, "healthy", seeds[4])
        logs |= more
    count = len(names)
    label = _label(stage, patient, flown[:count], floors=floors, spec=spec, name=subject.name)
    return GeneratedCase(
        spec, subject, tuple(runs[:count]), tuple(runs[count:]), tuple(healthy), label, logs
    )


def _flown(
    stage: CaseWorld,
    patient: Patient,
    kinds: Sequence[str],
    spec: CaseSpec,
    seeds: np.random.SeedSequence,
) -> tuple[Patient, list[FlownCase]]:
    """Fly all runs; the faults are made smaller until the vehicle stays under control."""
    for _try in range(_TRIES):
        try:
            return patient, fly_all(stage, patient, kinds, spec.duration_s, seeds)
        except VehicleLost:
            smaller = tuple(_SMALLER * size for size in patient.sizes)
            patient = Patient(patient.well, patient.faults, smaller)
    what = ", ".join(spec.what) if patient.faults else "no fault"
    raise CannotComputeError(f"the vehicle cannot be flown with {what}, however small")


def _label(
    stage: CaseWorld,
    patient: Patient,
    flown: Sequence[FlownCase],
    *,
    floors: FloatArray,
    spec: CaseSpec,
    name: str,
) -> CaseLabel:
    floor = {
        channel: float(floors[k]) for k, channel in enumerate(CHANNELS) if np.isfinite(floors[k])
    }
    by_channel = dict.fromkeys(floor, 1.0)
    regimes: dict[str, float] = {}
    own: dict[str, float] = {}
    if patient.faults:
        trace = trace_of_runs(stage, patient.well, flown)
        by_channel = ratios(trace, floors)
        regimes = regimes_of(trace, floors, [one.flight for one in flown], stage.stated)
    if spec.kind == "pair":
        for k, what in enumerate(spec.what):
            trace = trace_of_runs(stage, patient.without(k), flown)
            own[what] = gap_ratio(ratios(trace, floors))
    troubles = [fault for fault in patient.faults if isinstance(fault, Trouble)]
    return CaseLabel(
        vehicle=name,
        kind=spec.kind,
        effects=_effects(patient.faults, patient.sizes),
        trouble=troubles[0].name if troubles else None,
        trouble_thruster=troubles[0].thruster if troubles else None,
        overlaps=tuple(effect for fault in troubles for effect in fault.overlaps),
        times_s={
            f"run_{run + 1}": spans
            for fault in troubles
            for run, spans in fault.times_s.items()
            if run < len(flown)
        },
        wanted_ratio=spec.severity if patient.faults else 1.0,
        gap_ratio=gap_ratio(by_channel),
        own_ratios=own,
        channel_ratios=by_channel,
        healthy_floor=floor,
        regimes=regimes,
        manoeuvres=spec.manoeuvres,
        healthy_runs=spec.healthy,
        missing=spec.missing,
        seed=spec.seed,
    )


def _effects(faults: Sequence[Fault], sizes: Sequence[float]) -> tuple[TrueEffect, ...]:
    return tuple(
        TrueEffect(
            effect=fault.effect,
            parameters=fault.at(size),
            thruster=fault.thruster,
            axes=fault.axes,
        )
        for fault, size in zip(faults, sizes, strict=True)
        if isinstance(fault, Drawn)
    )
