"""Where runs differ from sound ones, and how far that shrinks where no size was taken from."""

from collections.abc import Sequence
from dataclasses import fields, replace

import numpy as np

from pipeline.diagnose.case import Case
from pipeline.diagnose.regression.decide import Said
from pipeline.diagnose.regression.grid import CHANNELS, GridRun
from pipeline.diagnose.regression.known import Reference
from pipeline.effects.effect import AXES
from pipeline.physics.window_sums import sums_over
from pipeline.records.diagnosis import (
    ChannelGap,
    Gap,
    GapFigures,
    Leftover,
    Series,
    Shrink,
    ShrinkFigures,
    TimeShare,
    Where,
)
from pipeline.types import FloatArray, IntArray
from pipeline.vehicle.sensor_schema import Sensors

#: Errors are told of the change within this. Blocks in which a change is looked at in time. [s]
AHEAD_S, BLOCK_S = 1.0, 10.0
#: Error over that of sound runs from which on a channel carries the gap.
_CARRIES = 1.2
#: Gap from which on there is something to close, in floors.
_LEAST_GAP = 1.1


def _sums(values: FloatArray, period_s: float) -> FloatArray:
    """Add one-step remainders (k, c) up over `AHEAD_S`."""
    count = max(round(AHEAD_S / period_s), 1)
    first = np.arange(len(values) - count + 1)
    return sums_over(values, first, first + count)


def _rms(values: Sequence[FloatArray]) -> FloatArray:
    every = np.concatenate(list(values))
    return np.sqrt(np.mean(np.square(every), axis=0)) if len(every) else np.zeros(every.shape[1])


def _floors(known: Reference) -> FloatArray:
    """Rms error (c,) of sound runs that took no part."""
    period = known.best.response.period_s
    return np.maximum(_rms([_sums(one, period) for one in known.best.response.remainders]), 1e-9)


def _left(known: Reference, run: GridRun) -> FloatArray:
    none = np.zeros(len(known.directions))
    return _sums(known.best.response.after(run, none)[1], known.best.response.period_s)


def _unit(channel: str) -> str:
    return "m/s" if channel in CHANNELS[:3] else "rad/s"


def _noise_of(sensors: Sensors | None, channel: str) -> float:
    """Noise of a difference of two readings, as the file states it."""
    own = None if sensors is None else sensors.dvl if channel in CHANNELS[:3] else sensors.imu
    if own is None:
        return 0.0
    noise = getattr(own, "noise_mps", None) if channel in CHANNELS[:3] else None
    noise = getattr(own, "rate_noise_radps", 0.0) if noise is None else noise
    return float(np.sqrt(2.0) * noise)


def gap_of(case: Case, known: Reference, runs: Sequence[GridRun]) -> Gap:
    """Compare the errors of the asked runs, a second ahead, with those of sound runs left out."""
    floors = _floors(known)
    errors = [_left(known, run) for run in runs]
    rms = _rms(errors)
    channels = {}
    for c, name in enumerate(known.best.response.channels):
        figures = GapFigures(
            rmse=float(rms[c]),
            sensor_floor=_noise_of(case.vehicle.sensors, name),
            healthy_floor=float(floors[c]),
            ratio=float(rms[c] / floors[c]),
        )
        channels[name] = ChannelGap(
            **figures.model_dump(), unit=_unit(name), horizons={f"{AHEAD_S:g}": figures}
        )
    carrying = tuple(name for name, one in channels.items() if one.ratio > _CARRIES)
    times: list[tuple[float, TimeShare]] = []
    total = sum(float(np.square(one / floors).sum()) for one in errors)
    for run, one in zip(runs, errors, strict=True):
        length = max(round(BLOCK_S / run.period_s), 1)
        for begin in range(0, len(one), length):
            part = float(np.square(one[begin : begin + length] / floors).sum())
            end = min(begin + length, len(run.time_s) - 1)
            share = part / total if total > 0.0 else 0.0
            stretch = TimeShare(
                run=run.name,
                from_s=float(run.time_s[begin]),
                to_s=float(run.time_s[end]),
                share=share,
            )
            times.append((share, stretch))
    times.sort(key=lambda row: -row[0])
    where = Where(
        channels=carrying, regimes=(), times=tuple(one for _, one in times[:3]) if carrying else ()
    )
    return Gap(channels=channels, where=where)


def leftover_of(gap: Gap, runs: Sequence[GridRun], known: Reference) -> Leftover:
    """Tell which axis is off most, and whether all runs are alike."""
    axis = dict(zip(CHANNELS, AXES, strict=True))
    ratios = {axis[name]: one.ratio for name, one in gap.channels.items()}
    worst = max(ratios, key=lambda name: ratios[name])
    power = [float(np.square(_left(known, run) / _floors(known)).mean()) for run in runs]
    alike = len(power) < 2 or max(power) < 2.0 * min(power)
    course = "about alike all the time" if alike else f"most in {runs[int(np.argmax(power))].name}"
    return Leftover(
        axes=ratios, worst_axis=worst, time_course=course, depends_on=None, correlation=None
    )


def _halves(run: GridRun) -> tuple[GridRun, GridRun]:
    """Cut a run in the middle."""
    middle, rows = len(run.time_s) // 2, len(run.time_s)

    def part(which: slice) -> GridRun:
        own = {
            one.name: getattr(run, one.name)[which]
            for one in fields(run)
            if isinstance(getattr(run, one.name), np.ndarray)
            and len(getattr(run, one.name)) == rows
            and one.name != "heavier"
        }
        return replace(run, **own)

    return part(slice(0, middle)), part(slice(middle, rows))


def shrink_of(
    case: Case,
    known: Reference,
    said: Said,
    runs: Sequence[GridRun],
    held: Sequence[GridRun],
    *,
    named: bool,
) -> tuple[Shrink, tuple[Series, ...]]:
    """How far the error shrinks where the sizes were not taken from."""
    parts: list[tuple[GridRun, FloatArray]] = []
    none = np.zeros(len(known.directions))
    if held:
        size = _size_from(known, said, [runs[k] for k in said.first.runs]) if named else none
        parts = [(run, size) for run in held]
        told = "runs " + ", ".join(run.name for run in case.holdout)
    else:
        cut = [_halves(run) for run in runs]
        for side in (0, 1):
            carried = [cut[k][1 - side] for k in said.first.runs]
            size = _size_from(known, said, carried) if named else none
            parts += [
                (one[side], size if k in said.first.runs else none) for k, one in enumerate(cut)
            ]
        told = "each half of the runs, with the size from the other half"
    floors, period = _floors(known), known.best.response.period_s
    before, after, series = [], [], []
    for run, size in parts:
        rows, first, second = known.best.response.after(run, size)
        left, right = _sums(first, period), _sums(second, period)
        before.append(left)
        after.append(right)
        series += _series(run, rows[len(rows) - len(left) :], left, right)
    one, other = _rms(before), _rms(after)
    channels = {
        name: ShrinkFigures(
            before=float(one[c]),
            after=float(other[c]),
            noise_floor=float(floors[c]),
            gap_closed=_closed(float(one[c] / floors[c]), float(other[c] / floors[c])),
            ci95=None,
        )
        for c, name in enumerate(known.best.response.channels)
    }
    first_all = float(np.sqrt(np.mean((one / floors) ** 2)))
    second_all = float(np.sqrt(np.mean((other / floors) ** 2)))
    return Shrink(
        before=first_all,
        after=second_all,
        noise_floor=1.0,
        gap_closed=_closed(first_all, second_all),
        ci95=None,
        channels=channels,
        held_out=told,
    ), tuple(series)


def _closed(before: float, after: float) -> float | None:
    return (before - after) / (before - 1.0) if before > _LEAST_GAP else None


def _size_from(known: Reference, said: Said, runs: Sequence[GridRun]) -> FloatArray:
    """Size of each direction that is named, from some runs alone."""
    told = [one.tempered(known.best.ordinary.share) for one in known.best.told(runs)]
    own = list(said.first.which)
    found = np.zeros(len(known.directions))
    information = np.sum([one.information for one in told], axis=0)[np.ix_(own, own)]
    score = np.sum([one.score for one in told], axis=0)[own]
    found[own] = np.linalg.solve(information + np.eye(len(own)), score)
    return found


def _series(run: GridRun, rows: IntArray, before: FloatArray, after: FloatArray) -> list[Series]:
    return [
        Series(
            run=run.name,
            channel=name,
            unit=_unit(name),
            time_s=tuple(run.time_s[rows].tolist()),
            measured=tuple(run.velocity[rows, c].tolist()),
            before=tuple((run.velocity[rows, c] - before[:, c]).tolist()),
            after=tuple((run.velocity[rows, c] - after[:, c]).tolist()),
        )
        for c, name in enumerate(run.channels)
    ]
