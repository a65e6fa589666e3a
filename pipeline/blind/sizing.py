"""Find the size at which a fault opens the wanted gap, by flying it."""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from pipeline.blind.flying import (
    CaseWorld,
    Fault,
    FlownCase,
    Patient,
    VehicleLost,
    children,
    fault_of,
    fly_all,
    fly_one,
    stage_of,
)
from pipeline.blind.severity import Floors, floors_of, gap_ratio, ratios, trace_of
from pipeline.blind.subject import BlindSubject
from pipeline.blind.truth.craft import Craft
from pipeline.blind.truth.flight import TruthFlight
from pipeline.blind.truth.manoeuvres import SETS
from pipeline.blind.truth.sensors import Weather, drawn
from pipeline.errors import CannotComputeError
from pipeline.types import FloatArray

#: Flown by the search, which takes two runs and cuts them short. [s]
SEARCH_S = 80.0
#: Gap that a fault must open at some size, and how many are drawn at most: on another axis, at
#: another thruster, the other way round.
_SHOWS, _DRAWS = 1.5, 4
#: Steps of the search, and the logarithm of the ratio at which it is content.
_STEPS, _CLOSE = 6, 0.12


def fault_that_shows(
    what: str,
    stage: CaseWorld,
    well: Craft,
    *,
    wanted: float,
    floors: Floors,
    kinds: Sequence[str],
    durations_s: tuple[float, ...],
    seeds: np.random.SeedSequence,
    rng: np.random.Generator,
) -> tuple[Fault, float]:
    """Draw a fault and its size, anew where on these runs it cannot be seen at any size.

    Some cannot however they are drawn; then the one that shows most is returned. `what` is an
    effect of the library, or trouble; the others are as of `size_for`.
    """
    drawn_so_far: list[tuple[float, Fault, float]] = []
    for _ in range(_DRAWS):
        fault = fault_of(what, stage, durations_s, rng)
        size, ratio = size_for(
            stage, well, fault, wanted=wanted, floors=floors, kinds=kinds, seeds=seeds, rng=rng
        )
        drawn_so_far.append((ratio, fault, size))
        if ratio >= _SHOWS:
            break
    _, fault, size = max(drawn_so_far, key=lambda one: one[0])
    return fault, size


def size_for(
    stage: CaseWorld,
    well: Craft,
    fault: Fault,
    *,
    wanted: float,
    floors: Floors,
    kinds: Sequence[str],
    seeds: np.random.SeedSequence,
    rng: np.random.Generator,
) -> tuple[float, float]:
    """Return the size whose gap ratio comes nearest to the wanted one, and that ratio.

    `well` is the vehicle without the fault, `wanted` the gap over its healthy floor on these
    manoeuvres; of the first four of the case's `kinds` of runs `rng` chooses two that are flown.
    """
    picked = [kinds[k] for k in sorted(rng.choice(4, size=2, replace=False))]
    target = float(np.sqrt(max(wanted, 1.01) ** 2 - 1.0))
    size, least = min(0.3, fault.most), 0.0
    best: tuple[float, float, float] | None = None
    for _step in range(_STEPS):
        try:
            patient = Patient(well, (fault,), (size,))
            flown = fly_all(stage, patient, picked, SEARCH_S, seeds)
            ratio = gap_ratio(ratios(trace_of_runs(stage, well, flown), floors))
        except (VehicleLost, CannotComputeError):
            fault = replace(fault, most=0.8 * size)
            size = 0.5 * (size + least) if least else 0.3 * size
            continue
        share = float(np.sqrt(max(ratio**2 - 1.0, 1e-6)))
        miss = abs(float(np.log(share / target)))
        if best is None or miss < best[1]:
            best = (size, miss, ratio)
        if share < target:
            least = max(least, size)
        if miss < _CLOSE or (share < target and size >= fault.most):
            break
        size = float(min(size * np.clip((target / share) ** 0.9, 0.05, 8.0), fault.most))
    return (size, 1.0) if best is None else (best[0], best[2])


def trace_of_runs(stage: CaseWorld, well: Craft, flown: Sequence[FlownCase]) -> FloatArray:
    """Trace of the faults over runs, each with the craft of that run (windows, k, 12).

    The healthy side keeps the background, which is in body axes; troubles push in NED.
    """
    parts = []
    for one in flown:
        quiet = one.outside.copy()
        quiet[:, :3] = 0.0
        parts.append(trace_of(one.craft, well, stage.belief, [(one.flight, quiet)], stage.sensors))
    return np.concatenate(parts)


@lru_cache(maxsize=64)
def healthy_floors(subject: BlindSubject, manoeuvres: str, missing: tuple[str, ...]) -> Floors:
    """Healthy floor of a vehicle on a set of manoeuvres, from six drawn vehicles."""
    stage = stage_of(subject, missing, Weather())
    model = subject.vehicle.model
    if model is None:
        raise CannotComputeError(f"{subject.name} has no model: section")
    flown: list[tuple[Craft, TruthFlight]] = []
    kinds = SETS[manoeuvres][0]
    for k in range(6):
        seeds = np.random.SeedSequence([7919, k])
        craft = drawn(stage.stated, model.uncertainty, np.random.default_rng(seeds))
        seed = children(seeds, 1)[0]
        try:
            one = fly_one(stage, Patient(craft), kinds[k % 4], run=0, duration_s=90.0, seed=seed)
        except VehicleLost:
            continue
        flown.append((craft, one.flight))
    return floors_of(stage.stated, flown, stage.belief, stage.sensors)
