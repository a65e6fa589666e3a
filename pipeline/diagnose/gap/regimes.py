"""Which regimes and times carry the gap, and what the leftover force goes with."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Protocol

import numpy as np

from pipeline.physics.parameters import read
from pipeline.records.diagnosis import RegimeGap, RegimeShare, TimeShare
from pipeline.records.run_table import RunTable
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import BoolArray, FloatArray

#: A regime is named when its share of the gap is that many times its share of the time, and large;
#: or, less marked, where the gap goes with the regressor throughout: by more than chance would have
#: it one time in twenty (the rank correlation of n windows that have nothing to do with it varies
#: by 1 / sqrt(n - 1): Kendall and Gibbons, "Rank Correlation Methods", 1990, ch. 4).
_MARKED, _LEAST_SHARE = 1.3, 0.4
_BY_CHANCE, _LESS_MARKED = 1.96, 1.1
#: Parts of each regressor's readings, by quantiles: low, middle and high.
PARTS = 3
#: Fewer readings than this say nothing of a regime.
_FEWEST = 8


@dataclass(frozen=True)
class Regressor:
    """A quantity by window (windows,); not a number where it was not measured."""

    name: str
    unit: str
    values: FloatArray


class Stretch(Protocol):
    """A piece of a run: which, from when on and how long, and its commands (m, n)."""

    @property
    def run(self) -> int:
        """Number of the run."""
        ...

    @property
    def begin_s(self) -> float:
        """Where it begins, on the clock of the run."""
        ...

    @property
    def duration_s(self) -> float:
        """How long it is."""
        ...

    @property
    def command(self) -> FloatArray:
        """Codes (m, n)."""
        ...


def regressors(
    packed: PackedVehicle, windows: Sequence[Stretch], runs: Sequence[RunTable]
) -> list[Regressor]:
    """Means over each window of what a force may depend on."""
    count = len(packed.thruster_names)
    largest = read(packed.vector, "code_max")[:count]

    def mean(quantity: str, made: Callable[[FloatArray], FloatArray]) -> FloatArray:
        """Mean over each window of what is made of the rows (k, c) of a quantity."""
        found = np.full(len(windows), np.nan)
        for number, window in enumerate(windows):
            run = runs[window.run]
            if quantity not in run.values:
                continue
            end_s = window.begin_s + window.duration_s
            inside = (run.time_s >= window.begin_s) & (run.time_s < end_s) & run.valid[quantity]
            values = made(run.values[quantity][inside])
            values = values[np.isfinite(values)]
            if values.size:
                found[number] = values.mean()
        return found

    level = np.array([float(np.mean(np.abs(w.command) / largest)) for w in windows])
    sign = np.array([float(np.mean(np.sign(w.command))) for w in windows])
    every = [
        Regressor("speed_mps", "m/s", mean("velocity", lambda nu: np.linalg.norm(nu, axis=1))),
        Regressor("surge_mps", "m/s", mean("velocity", lambda nu: nu[:, 0])),
        Regressor(
            "turn_rate_radps", "rad/s", mean("angular_velocity", lambda pqr: np.abs(pqr[:, 2]))
        ),
        Regressor("depth_m", "m", mean("depth", lambda depth: depth[:, 0])),
        Regressor("command_level", "1", level),
        Regressor("command_sign", "1", sign),
        Regressor("voltage_v", "V", mean("voltage", lambda supply: supply[:, 0])),
        Regressor("wall_distance_m", "m", mean("position", _wall_distance(packed))),
        Regressor("time_s", "s", np.array([w.begin_s + w.duration_s / 2 for w in windows])),
    ]
    return [
        one
        for one in every
        if np.isfinite(one.values).sum() >= 4 and np.ptp(one.values[np.isfinite(one.values)]) > 1e-9
    ]


def _wall_distance(packed: PackedVehicle) -> Callable[[FloatArray], FloatArray]:
    """Return what makes distances from the nearest wall (k,) of places (k, 3)."""
    count = int(read(packed.vector, "wall_count"))
    points = read(packed.vector, "wall_point")[:count]
    normals = read(packed.vector, "wall_normal")[:count]

    def nearest(place: FloatArray) -> FloatArray:
        away = np.einsum("kij,ij->ki", place[:, None, :] - points, normals)
        return np.asarray(away.min(axis=1)) if count else np.zeros(0)

    return nearest


def regime_shares(
    every: Sequence[Regressor],
    carried: FloatArray,
    goes_with: Mapping[str, float] = MappingProxyType({}),
) -> tuple[RegimeShare, ...]:
    """Ranges of the regressors in which more of the gap lies than of the time.

    First the regressor with which the gap of a window goes most closely.

    Parameters
    ----------
    every : sequence of Regressor
        Over the windows.
    carried : ndarray, shape (windows,)
        Part of the gap in each window; not negative.
    goes_with : mapping
        Regressors to be named whatever their shares, with their correlations: a force that grows
        through zero goes with the time, and its size does not.
    """
    whole = float(carried.sum())
    if whole <= 0.0:
        return ()
    found = []
    for one in every:
        known = np.isfinite(one.values)
        goes_with_it = _BY_CHANCE / np.sqrt(known.sum() - 1)
        edges = np.quantile(one.values[known], [0.0, 1 / 3, 2 / 3, 1.0])
        correlation = rank_correlation(carried[known], one.values[known])
        told = goes_with.get(one.name)
        if told is not None:
            # a force along the axis or against it: the gap grows with its size
            correlation = float(np.copysign(told, correlation))
        for low, high in ((0, 1), (1, 2), (2, 3), (0, 2), (1, 3)):
            inside = known & (one.values >= edges[low]) & (one.values <= edges[high])
            share = float(carried[inside].sum()) / whole
            time = float(inside.sum()) / len(carried)
            marked = share >= _LEAST_SHARE and share >= _MARKED * time
            less_marked = abs(correlation) >= goes_with_it and share >= _LESS_MARKED * time
            if marked or less_marked or told is not None:
                found.append(
                    RegimeShare(
                        regressor=one.name,
                        unit=one.unit,
                        range=(float(edges[low]), float(edges[high])),
                        share=share,
                        share_of_time=time,
                        correlation=correlation,
                    )
                )
    best: dict[str, RegimeShare] = {}
    for row in found:
        known_row = best.get(row.regressor)
        if known_row is None or row.share / row.share_of_time > (
            known_row.share / known_row.share_of_time
        ):
            best[row.regressor] = row
    return tuple(sorted(best.values(), key=lambda row: -abs(row.correlation or 0.0)))


def rank_correlation(first: FloatArray, second: FloatArray) -> float:
    """Spearman's correlation of two series (k,), ties at their mean; 0 where one does not vary."""
    if np.ptp(first) == 0.0 or np.ptp(second) == 0.0:
        return 0.0
    return float(np.corrcoef(_ranks(first), _ranks(second))[0, 1])


def _ranks(values: FloatArray) -> FloatArray:
    """Ranks from 1, ties at their mean; a second of imports less than those of `scipy.stats`."""
    _, place, counts = np.unique(values, return_inverse=True, return_counts=True)
    mean: FloatArray = np.cumsum(counts) - (counts - 1) / 2
    return mean[place]


def time_shares(
    windows: Sequence[Stretch], runs: Sequence[RunTable], carried: FloatArray
) -> tuple[TimeShare, ...]:
    """Stretches of the runs with a gap: windows that carry at least half the mean, joined."""
    whole = float(carried.sum())
    if whole <= 0.0:
        return ()
    found: list[TimeShare] = []
    for window, own in zip(windows, carried, strict=True):
        if own < 0.5 * whole / len(carried):
            continue
        begin, end = window.begin_s, window.begin_s + window.duration_s
        name, joined = runs[window.run].name, 0.0
        if found and found[-1].run == name and abs(found[-1].to_s - begin) < 1e-6:
            before = found.pop()
            begin, joined = before.from_s, before.share
        share = joined + float(own) / whole
        found.append(TimeShare(run=name, from_s=begin, to_s=end, share=share))
    return tuple(sorted(found, key=lambda row: (-row.share, row.run, row.from_s))[:8])


def regime_gaps(
    every: Sequence[Regressor], ratios_in: Callable[[BoolArray], dict[str, float]]
) -> tuple[RegimeGap, ...]:
    """Root mean square error over the healthy floor, by regime and channel.

    Parameters
    ----------
    every : sequence of Regressor
        Means over each window (windows,) of what a force may depend on.
    ratios_in : callable
        Ratio of every channel in some windows (windows,).

    Returns
    -------
    tuple of RegimeGap
        Low, middle and high third of each regressor; equal thirds are joined.
    """
    found = []
    for one in every:
        known = one.values[np.isfinite(one.values)]
        if not known.size:
            continue
        edges = np.unique(np.quantile(known, np.linspace(0.0, 1.0, PARTS + 1)))
        for number in range(len(edges) - 1):
            low, high = float(edges[number]), float(edges[number + 1])
            last = number == len(edges) - 2
            above = one.values <= high if last else one.values < high
            inside = (one.values >= low) & above
            ratios = ratios_in(inside)
            if ratios:
                share = float(np.mean(inside))
                found.append(
                    RegimeGap(
                        regressor=one.name,
                        unit=one.unit,
                        range=(low, high),
                        share_of_time=share,
                        ratios=ratios,
                    )
                )
    return tuple(found)
