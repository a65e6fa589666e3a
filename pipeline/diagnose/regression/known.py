"""What runs are told against: the vehicle as its sound runs show it, or as its file has it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from pipeline.diagnose.case import Case
from pipeline.diagnose.coordinates import Coordinate
from pipeline.diagnose.regression.directions import directions_of, file_widths, stated_widths
from pipeline.diagnose.regression.file_step import Step, file_step
from pipeline.diagnose.regression.flights import FLIGHTS, flown
from pipeline.diagnose.regression.grid import GridRun, grid_periods, on_grids
from pipeline.diagnose.regression.held_out import (
    CLEARLY,
    FileModel,
    Method,
    decides,
    error_ahead,
    predictions,
)
from pipeline.diagnose.regression.offset import (
    Offset,
    offset_of,
    without_offset,
)
from pipeline.diagnose.regression.ordinary import (
    INEXACT_OF_FILE,
    Ordinary,
    ordinary_of,
    share_as_claimed,
)
from pipeline.diagnose.regression.response import Response
from pipeline.diagnose.regression.ridge import BENT, STIFF
from pipeline.diagnose.regression.signatures import stays
from pipeline.diagnose.regression.told import Told
from pipeline.effects.effect import AXES
from pipeline.errors import CannotComputeError
from pipeline.measured.completed import completed
from pipeline.records.reference import Prediction, Width
from pipeline.records.run_table import RunTable
from pipeline.types import FloatArray, IntArray
from pipeline.vehicle.sensor_schema import Sensors

#: Sound runs without which nothing is known of how much runs differ.
LEAST_SOUND = 3
#: Spacings of the grid that flights of the file are laid on.
_GRIDS = 2
_BY_FILE = "there are fewer than three sound runs to tell them against"
_OTHERWISE = "the sound runs were not measured as these were"


@dataclass(frozen=True)
class ToldRun:
    """A run, and what it says when it took no part.

    `left_out` is its place among the runs of the response, if it is one of them.
    """

    run: GridRun
    told: Told
    left_out: int | None = None


@dataclass(frozen=True)
class Learned:
    """What sound runs show on one grid, or flights of the file where there are too few.

    `offset` is what the response is off by in all of them alike; `ordinary` is what its directions
    differ by between runs; `usual` are the runs that show what a healthy vehicle leaves; `sound` is
    what each sound run says, predicted without it, without the offset; `error` is the mean
    logarithm of the errors, see `error_ahead`.
    """

    response: Response
    offset: Offset
    ordinary: Ordinary
    usual: tuple[ToldRun, ...]
    sound: tuple[Told, ...]
    error: float

    def told(self, runs: Sequence[GridRun]) -> list[Told]:
        """Return what runs that are weighed together say of the directions."""
        return [self.offset.removed(self.response.told(run), len(runs)) for run in runs]

    def told_runs(self, runs: Sequence[GridRun]) -> list[ToldRun]:
        """Return runs with what they say of the directions; see `told`."""
        return [ToldRun(run, one) for run, one in zip(runs, self.told(runs), strict=True)]

    def after(
        self, one: ToldRun, change: FloatArray | None = None
    ) -> tuple[IntArray, FloatArray, FloatArray]:
        """Predict the next velocities of a run that differs by what is ordinary.

        Parameters
        ----------
        one : ToldRun
            The run.
        change : ndarray, shape (d,), optional
            Size of each direction, beside what is ordinary.

        Returns
        -------
        tuple of ndarray
            Rows of the grid (k,); remainders (k, c) of the bare response, and with all of it.
        """
        return self.response.after(one.run, self.size(one, change), left_out=one.left_out)

    def size(self, one: ToldRun, change: FloatArray | None = None) -> FloatArray:
        """Return by what a run differs (d,): a change (d,), and most probably what is ordinary."""
        count = one.told.thrust.size
        own = np.zeros(count) if change is None else change[:count]
        few = replace(self.ordinary, width=self.ordinary.width[:count])
        return own + few.of(one.told, own)

    @property
    def by_file(self) -> bool:
        """Whether flights of the file stand in for sound runs."""
        return all(one.left_out is None for one in self.usual)

    @property
    def trusted(self) -> float:
        """Share of the information of a run that is left over all channels."""
        return float(np.exp(np.mean(np.log(self.offset.share * self.ordinary.share))))


@dataclass(frozen=True)
class Reference:
    """A vehicle as its sound runs show it, or its file; `why` tells why it is told against that.

    `grids` are what was learned on each grid, the one first that predicts best; `stated` is what
    directions differ by before these runs were seen; `table` says how well runs that were left out
    are predicted; `used` whether the response is better than the file.
    """

    directions: tuple[Coordinate, ...]
    grids: tuple[Learned, ...]
    stated: FloatArray
    table: tuple[Prediction, ...]
    used: bool
    why: str

    @property
    def best(self) -> Learned:
        """What was learned on the grid that predicts best."""
        return self.grids[0]

    @property
    def by_file(self) -> bool:
        """Whether it is the vehicle file that runs are told against."""
        return self.best.by_file

    @property
    def told_against(self) -> str:
        """What the runs are told against, and why."""
        if self.by_file:
            against = "vehicle file"
        elif self.used:
            against = "sound runs, not the vehicle file"
        else:
            against = "vehicle file, with what sound runs differ from it and each other by"
        return f"Told against the {against}: {self.why}"

    @property
    def force(self) -> dict[str, dict[str, float]]:
        """Acceleration of each velocity by a newton, or newton metre, along each axis."""
        response = self.best.response
        every = response.force.reshape(-1, 6, len(response.channels)).sum(axis=0)
        return {
            name: {axis: float(every[a, c] / response.period_s) for a, axis in enumerate(AXES)}
            for c, name in enumerate(response.channels)
        }

    @property
    def widths(self) -> tuple[Width, ...]:
        """What each direction differs by between sound runs, in the unit of its parameter."""
        return tuple(
            Width(
                name=one.name,
                unit=one.parameter.unit,
                stated=float(self.stated[k] * one.unit_size),
                learned=float(self.best.ordinary.width[k] * one.unit_size),
            )
            for k, one in enumerate(self.directions)
        )


def learned(case: Case, files: Mapping[Method, FileModel]) -> Reference:
    """Learn from the healthy runs of a case and predict each by the others.

    On each grid the ridge of squares and products, and how much is learned at all beside the file,
    is what predicts runs left out best. Where that is not clearly better than the file, its motion
    stays, and sound runs show what it is off by and how much they differ.

    Raises
    ------
    CannotComputeError
        For runs without rates of turn or attitude, or of different channels.
    """
    directions = directions_of(case.vehicle, case.packed, case.candidates)
    periods = grid_periods((*case.healthy, *case.runs))
    every = [
        on_grids(case.packed, run, case.vehicle.sensors, directions, periods)
        for run in case.healthy
    ]
    if len({run[0].channels for run in every}) > 1:
        raise CannotComputeError(
            "the sound runs have not the same channels: "
            + "; ".join(f"{run[0].name} {', '.join(run[0].channels)}" for run in every)
            + ". Name runs that measured the same velocities and rates."
        )
    stated = stated_widths(case.vehicle, directions)
    file = file_step(case.packed)
    tried = [_tried(runs, file) for runs in zip(*every, strict=True)]
    best = sorted((min(own, key=_worth) for own in tried), key=_error)
    table = predictions(best[0][1], files)
    used, why = decides(table)
    kept = best if used else sorted((own[-1] for own in tried), key=_error)
    grids = tuple(_learned(*one, directions, stated) for one in kept)
    return Reference(directions, grids, stated, table, used, why)


def _tried(runs: Sequence[GridRun], file: Step) -> list[tuple[float, Response]]:
    """Return responses with their errors; the last is hardly more than the file."""
    found = [Response(runs, bent, mean, file) for bent, mean in product(BENT, (stays, file))]
    found.append(Response(runs, BENT[-1], file, file, stiff=STIFF))
    return [(error_ahead(one), one) for one in found]


def _error(one: tuple[float, Response]) -> float:
    return one[0]


def _worth(one: tuple[float, Response]) -> float:
    # how it answers to a force that no sound run had the file alone knows
    return one[0] + (float(np.log(CLEARLY)) if one[1].by_file else 0.0)


def _learned(
    error: float, response: Response, directions: Sequence[Coordinate], stated: FloatArray
) -> Learned:
    sound = response.told_of_sound()
    share = ordinary_of(sound, directions, stated).share
    alone = without_offset(sound, share)
    ordinary = ordinary_of(alone, directions, stated)
    usual = tuple(
        ToldRun(run, one, k) for k, (run, one) in enumerate(zip(response.runs, alone, strict=True))
    )
    return Learned(response, offset_of(sound, share), ordinary, usual, tuple(alone), error)


def by_file(case: Case) -> Reference:
    """Take the vehicle of the file for what is known: it flies what was asked.

    Raises
    ------
    CannotComputeError
        For a run without rates of turn or attitude, or runs of different channels.
    """
    directions = directions_of(case.vehicle, case.packed, case.candidates)
    sensors = case.vehicle.sensors or Sensors()
    width = file_widths(case.packed, directions)
    random = np.random.default_rng(0)
    drawn = [(directions, width * random.standard_normal(width.size)) for _ in range(FLIGHTS)]
    flights = flown(case.packed, sensors, case.runs)
    others = flown(case.packed, sensors, case.runs, drawn)
    # the file is a model at any spacing; the finer ones lose least
    periods = grid_periods(case.runs)[:_GRIDS]

    def gridded(runs: Sequence[RunTable]) -> list[tuple[GridRun, ...]]:
        every = [
            on_grids(case.packed, one, case.vehicle.sensors, directions, periods) for one in runs
        ]
        return list(zip(*every, strict=True)) if every else [()] * len(periods)

    sound = [one for one in case.healthy if _velocities(one)]
    # runs that are weighed together differ from the file alike: each counts that as wider
    wide = width * np.sqrt(len(case.runs))
    file = file_step(case.packed)
    grids = tuple(
        _of_file(runs, more, known, file, wide)
        for runs, more, known in zip(gridded(flights), gridded(others), gridded(sound), strict=True)
    )
    return Reference(directions, grids, width, (), used=False, why=_BY_FILE)


def _of_file(
    runs: Sequence[GridRun],
    others: Sequence[GridRun],
    sound: Sequence[GridRun],
    file: Step,
    width: FloatArray,
) -> Learned:
    """Learn the noise from flights of the file, and what a healthy vehicle leaves from others."""
    response = Response(runs, BENT[-1], file, file, stiff=STIFF)
    told = response.told_of_sound()
    # flights hardly move along some directions: there their noise would pass for a large offset
    offset = offset_of(told, share_as_claimed(told, width), width)
    alone = without_offset(told, offset.share, width)
    ordinary = Ordinary(width, share_as_claimed(alone, width), INEXACT_OF_FILE)
    found = Learned(response, offset, ordinary, (), (), 0.0)
    usual = tuple(found.told_runs([one])[0] for one in others)
    # one that was measured otherwise says nothing of these channels
    alike = [one for one in sound if one.channels == response.channels]
    return replace(found, usual=usual, sound=tuple(found.told([one])[0] for one in alike))


def _velocities(run: RunTable) -> frozenset[str]:
    """Tell what a run shows of its velocities; nothing without rates of turn and attitude."""
    have = completed(run).values.keys()
    if not have >= {"angular_velocity", "attitude"}:
        return frozenset()
    linear = next((one for one in ("velocity", "depth") if one in have), "none")
    return frozenset({linear, "angular_velocity"})


def reference_of(case: Case) -> Reference:
    """Return what runs are told against: sound runs where there are enough, else the file."""
    if len(case.healthy) < LEAST_SOUND:
        return by_file(case)
    if len({_velocities(run) for run in (*case.healthy, *case.runs)}) > 1:
        return replace(by_file(case), why=_OTHERWISE)
    return learned(case, {"vehicle file": FileModel(case.packed)})
