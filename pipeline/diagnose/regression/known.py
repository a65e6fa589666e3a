"""The vehicle as its sound runs show it, where that predicts better than its file."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from pipeline.diagnose.case import Case
from pipeline.diagnose.linear.coordinates import Coordinate
from pipeline.diagnose.regression.directions import directions_of, stated_widths
from pipeline.diagnose.regression.file_step import Step, file_step
from pipeline.diagnose.regression.grid import GridRun, grid_periods, on_grids
from pipeline.diagnose.regression.held_out import (
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
from pipeline.diagnose.regression.ordinary import Ordinary, ordinary_of
from pipeline.diagnose.regression.response import BENT, STIFF, Response
from pipeline.diagnose.regression.signatures import stays
from pipeline.diagnose.regression.told import Told
from pipeline.effects.effect import AXES
from pipeline.errors import CannotComputeError
from pipeline.records.reference import Prediction, Width
from pipeline.types import FloatArray

#: Sound runs without which nothing is known of how much runs differ.
LEAST_SOUND = 3


@dataclass(frozen=True)
class Learned:
    """What sound runs show on one grid.

    `offset` is what the response is off by in all of them alike; `ordinary` is what its directions
    differ by between runs; `sound` is what each of them says, predicted from the others, without
    the offset; `error` is the mean logarithm of its errors, see `error_ahead`.
    """

    response: Response
    offset: Offset
    ordinary: Ordinary
    sound: tuple[Told, ...]
    error: float

    def told(self, runs: Sequence[GridRun]) -> list[Told]:
        """Return what runs that are weighed together say of the directions."""
        return [self.offset.removed(self.response.told(run), len(runs)) for run in runs]

    @property
    def trusted(self) -> float:
        """Share of the information of a run that is left over all channels."""
        return float(np.exp(np.mean(np.log(self.offset.share * self.ordinary.share))))


@dataclass(frozen=True)
class Reference:
    """A vehicle as its sound runs show it; `why` tells why it decides.

    `grids` are what was learned on each grid, the one first that predicts best; `stated` is what
    directions differ by before these runs were seen; `table` says how well runs that were left out
    are predicted.
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
    is what predicts runs left out best.

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
    grids = [_on_grid(runs, file, directions, stated) for runs in zip(*every, strict=True)]
    grids.sort(key=lambda one: one.error)
    table = predictions(grids[0].response, files)
    used, why = decides(table)
    return Reference(directions, tuple(grids), stated, table, used, why)


def _on_grid(
    runs: Sequence[GridRun], file: Step, directions: Sequence[Coordinate], stated: FloatArray
) -> Learned:
    tried = [Response(runs, bent, mean, file) for bent, mean in product(BENT, (stays, file))]
    tried.append(Response(runs, BENT[-1], file, file, stiff=STIFF))
    errors = [error_ahead(one) for one in tried]
    best = int(np.argmin(errors))
    sound = tried[best].told_of_sound()
    share = ordinary_of(sound, directions, stated).share
    alone = without_offset(sound, share)
    ordinary = ordinary_of(alone, directions, stated)
    return Learned(tried[best], offset_of(sound, share), ordinary, tuple(alone), errors[best])


def reference_of(case: Case) -> tuple[Reference | None, str]:
    """Learn from the healthy runs of a case, and say why it decides; None where it does not."""
    try:
        found = learned(case, {"vehicle file": FileModel(case.packed)})
    except CannotComputeError as error:
        return None, str(error)
    return found if found.used else None, found.why
