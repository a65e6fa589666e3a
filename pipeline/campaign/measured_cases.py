"""Cases of the measured blind check: which run, which healthy runs, which effect, and how large.

A case is drawn from the seed and its number alone. The vehicles take turns and so do their runs,
each left out in turn. A run that is too short to be diagnosed by itself has others beside it, with
the same effect put into all of them; healthy runs are never among those.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.campaign.measured_subjects import MeasuredSubject
from pipeline.effects.effect import Effect
from pipeline.effects.library import candidates
from pipeline.effects.specification import EffectSpec
from pipeline.errors import CannotComputeError
from pipeline.measured.floors import (
    CHANNELS,
    HealthyScatter,
    channel_floors,
    healthy_scatter,
    signature,
)
from pipeline.measured.inject import READINGS, commanded_without_effect, injected
from pipeline.records.run_table import RunTable
from pipeline.types import FloatArray

#: Kinds of cases, in turn: a thruster, another effect, as it is, a thruster that is commanded and
#: does nothing (a thruster again where none stood still).
KINDS = ("thruster", "effect", "effect", "none", "thruster", "effect", "effect", "dead")
#: Runs are put together until they last so long, and at most so many healthy runs are given. [s]
ENOUGH_S, MOST_HEALTHY = 35.0, 8
#: A weak thruster gives so much, and the sizes of other effects that are drawn. [1], [floors]
WEAK = 0.6
SIZES = (1.5, 3.0, 3.0, 5.0, 8.0)
#: Largest command of a thruster that does nothing, over its range. [1]
DEAD_COMMAND = 0.4
#: An effect must move a channel by so much to be worth a case, and so much of it must stand in the
#: log. Effects are drawn again otherwise, so often. [floors], [1]
LEAST_SIZE, LEAST_SHARE, MOST_DRAWS = 0.5, 0.75, 12
#: Effects that are not drawn: of readings, and what is no effect of a measured vehicle's own runs.
_NOT_DRAWN = READINGS | {"thruster_degraded", "wall_effect", "shaft_inertia", "payload", "tether"}
#: Largest sizes of some effects; [s], [m/s], [N].
_ENDS = {"thruster_lag": 0.5, "current": 0.3, "residual_buoyancy": 30.0}
#: How far beyond the end of what is plausible an effect may be taken that knows no such end. [1]
_BEYOND = 2.5
_WITHOUT_END = frozenset({"added_mass", "linear_damping", "quadratic_damping"})


@dataclass(frozen=True)
class MeasuredCase:
    """What is diagnosed, and what was done to it.

    `runs` have the effect in them, `healthy` are as they were. `sizes` are floors by channel,
    `share` the part of the effect that stands in the logs.
    """

    number: int
    subject: MeasuredSubject
    kind: str
    runs: tuple[RunTable, ...]
    healthy: tuple[RunTable, ...]
    spec: EffectSpec | None
    sizes: dict[str, float]
    wanted: float
    share: float

    @property
    def size(self) -> float:
        """Floors that the effect moves the channel by that it moves most."""
        return max(self.sizes.values(), default=0.0)


def measured_case(number: int, seed: int, subjects: Sequence[MeasuredSubject]) -> MeasuredCase:
    """Draw a case and put its effect into its runs.

    Raises `CannotComputeError` when no effect that was drawn shows in these runs.
    """
    generator = np.random.default_rng([seed, number])
    subject = subjects[number % len(subjects)]
    turn = number // len(subjects)
    kind = KINDS[turn % len(KINDS)]
    runs, healthy = _divided(subject, turn % len(subject.runs), generator)
    if kind == "none":
        return MeasuredCase(number, subject, kind, runs, healthy, None, {}, 0.0, 1.0)
    scatter = healthy_scatter(subject.packed, healthy, subject.vehicle.sensors)
    if kind == "dead":
        found = _dead(number, subject, runs, healthy, generator)
        if found is not None:
            return found
    refused = ""
    for draw in range(2 * MOST_DRAWS):
        try:
            # where no thruster shows enough, another effect takes its turn
            kind = "effect" if draw >= MOST_DRAWS else kind
            spec, wanted = _drawn(kind, subject, runs, scatter, generator)
            case = _put(number, subject, kind, runs, healthy, spec, wanted, scatter)
        except CannotComputeError as error:
            refused = str(error)
            continue
        if case.size >= LEAST_SIZE and case.share >= LEAST_SHARE:
            return case
        refused = f"{spec.id}: {case.size:.2f} floors, {case.share:.0%} of it in the log"
    raise CannotComputeError(f"no effect shows in {runs[0].name}; the last: {refused}")


def _divided(
    subject: MeasuredSubject, left_out: int, generator: np.random.Generator
) -> tuple[tuple[RunTable, ...], tuple[RunTable, ...]]:
    """Choose the runs to be diagnosed, the one left out first, and healthy ones."""
    rest = [int(k) for k in generator.permutation(len(subject.runs)) if k != left_out]
    chosen = [left_out]
    while sum(_seconds(subject.runs[k]) for k in chosen) < ENOUGH_S and len(rest) > 2:
        chosen.append(rest.pop())
    return tuple(subject.runs[k] for k in chosen), tuple(
        subject.runs[k] for k in sorted(rest[:MOST_HEALTHY])
    )


def _seconds(run: RunTable) -> float:
    return float(run.time_s[-1] - run.time_s[0])


def _dead(
    number: int,
    subject: MeasuredSubject,
    runs: tuple[RunTable, ...],
    healthy: tuple[RunTable, ...],
    generator: np.random.Generator,
) -> MeasuredCase | None:
    """Command a thruster that stood still in all runs; None where there is none."""
    names = subject.packed.thruster_names
    for name in (names[k] for k in generator.permutation(len(names))):
        draw = int(generator.integers(1 << 30))
        try:
            told = tuple(
                commanded_without_effect(subject.packed, run, name, DEAD_COMMAND, draw)
                for run in runs
            )
        except CannotComputeError:
            continue
        spec = EffectSpec("thruster_degraded", {"thrust_fraction": 0.0}, name)
        return MeasuredCase(number, subject, "dead", told, healthy, spec, {}, 0.0, 1.0)
    return None


def _drawn(
    kind: str,
    subject: MeasuredSubject,
    runs: Sequence[RunTable],
    scatter: HealthyScatter,
    generator: np.random.Generator,
) -> tuple[EffectSpec, float]:
    """Draw an effect and, but for a weak thruster, make it as large as is wanted."""
    names = subject.packed.thruster_names
    target = names[int(generator.integers(len(names)))]
    if kind != "effect":
        return EffectSpec("thruster_degraded", {"thrust_fraction": WEAK}, target), 0.0
    library = candidates(subject.packed.context)
    ids = sorted(set(library) - _NOT_DRAWN)
    effect = library[ids[int(generator.integers(len(ids)))]]
    parameter = effect.parameters[int(generator.integers(len(effect.parameters)))]
    if effect.id == "voltage_sag":
        parameter = effect.parameters[0]
    ends = [end for end in parameter.plausible if end != parameter.neutral]
    end = float(ends[int(generator.integers(len(ends)))])
    most = _ENDS.get(effect.id, abs(end - parameter.neutral))
    end = parameter.neutral + np.sign(end - parameter.neutral) * min(
        most, abs(end - parameter.neutral)
    )
    wanted = float(SIZES[int(generator.integers(len(SIZES)))])
    share = _share_of(effect, parameter.name, target, end, runs, scatter, wanted)
    return _spec(effect, parameter.name, target, parameter.neutral, end, share), wanted


def _spec(  # noqa: PLR0917 - an effect on its way from neutral to an end
    effect: Effect, name: str, target: str, neutral: float, end: float, share: float
) -> EffectSpec:
    value = float(f"{neutral + share * (end - neutral):.4g}")
    return EffectSpec(effect.id, {name: value}, target if effect.scope == "thruster" else None)


def _share_of(  # noqa: PLR0917 - one caller
    effect: Effect,
    name: str,
    target: str,
    end: float,
    runs: Sequence[RunTable],
    scatter: HealthyScatter,
    wanted: float,
) -> float:
    """Share of the way from neutral to `end` at which a channel moves by so many floors."""
    neutral = effect.neutral_values()[name]
    unit = next(one.unit for one in effect.parameters if one.name == name)
    growing = unit != "1" or (effect.id in _WITHOUT_END and end > neutral)
    most = _BEYOND if growing and effect.id not in _ENDS else 1.0
    share = 0.5
    floors = None
    for _ in range(4):
        specs = [_spec(effect, name, target, neutral, end, share)]
        floors = channel_floors(scatter, specs) if floors is None else floors
        size = max(_sizes(scatter, runs, specs, floors).values(), default=0.0)
        if size <= 0.0:
            raise CannotComputeError(f"{effect.id} shows in none of these runs")
        if abs(size - wanted) < 0.1 * wanted:
            break
        share = float(np.clip(share * wanted / size, 0.02, most))
    return share


def _sizes(
    scatter: HealthyScatter,
    runs: Sequence[RunTable],
    specs: Sequence[EffectSpec],
    floors: FloatArray,
) -> dict[str, float]:
    """Floors by channel over all runs together; a run that the effect is not in counts as still."""
    squares, count = np.zeros(6), 0
    for run in runs:
        try:
            own = signature(scatter, run, specs)
        except CannotComputeError:
            count += run.time_s.size // 10
            continue
        squares, count = squares + np.square(own).sum(axis=0), count + len(own)
    size = np.sqrt(squares / max(count, 1)) / floors
    return {
        channel: float(one) for channel, one in zip(CHANNELS, size, strict=True) if np.isfinite(one)
    }


def _put(  # noqa: PLR0917 - one caller
    number: int,
    subject: MeasuredSubject,
    kind: str,
    runs: tuple[RunTable, ...],
    healthy: tuple[RunTable, ...],
    spec: EffectSpec,
    wanted: float,
    scatter: HealthyScatter,
) -> MeasuredCase:
    sensors = subject.vehicle.sensors
    made, shares = [], []
    for run in runs:
        try:
            put = injected(subject.packed, run, [spec], sensors)
        except CannotComputeError:
            if run is runs[0]:
                raise
            made.append(run)  # the effect would do nothing here
            continue
        made.append(put.run)
        shares.append(put.share)
    sizes = _sizes(scatter, runs, [spec], channel_floors(scatter, [spec]))
    return MeasuredCase(
        number, subject, kind, tuple(made), healthy, spec, sizes, wanted, min(shares)
    )
