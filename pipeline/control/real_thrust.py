"""What a thruster really gives for a code under way: the static family T(N, V) of the record."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.records.fits import StaticCharacteristic, ThrustFamily
from pipeline.types import ArrayLike, BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class RealThruster:
    """Bilinear T(N, V) over the grid of a record, symmetric in sign unless `reverse_n` is given.

    `speed_mps` (v,), `code` (c,), `thrust_n`, `reverse_n` (v, c), where dead nodes hold the live
    ones' straight continuation below zero, so that the edge of the dead zone lies where that
    crosses zero and not at the next node. The result is never negative along the code.

    Against the motion the row at rest holds: the mooring branch, the project's model.
    """

    speed_mps: FloatArray
    code: FloatArray
    thrust_n: FloatArray
    reverse_n: FloatArray | None = None

    @classmethod
    def from_family(cls, family: ThrustFamily) -> Self:
        """Take both signs of what is known best; up to the speed that both have."""
        ahead, astern = family.positive, family.negative
        rows = min(len(ahead.speed_mps), len(astern.speed_mps))
        code = np.array(ahead.code)
        both = [
            np.array([_continued(code, t, t > 0.0) for t in np.array(side.thrust_n)[:rows]])
            for side in (ahead, astern)
        ]
        return cls(np.array(ahead.speed_mps[:rows]), code, *both)

    @classmethod
    def from_record(cls, static: StaticCharacteristic) -> Self:
        """Take the family out of the record.

        Raises
        ------
        CannotComputeError
            If no working point has thrust.
        """
        code = np.array(static.code)
        thrust = np.array(static.thrust_n)
        live = (np.array(static.status) != "dead") & (thrust > 0.0)
        if not live.any():
            raise CannotComputeError(
                "The static family has no point with thrust: the wrench of the thrusters cannot "
                "be computed."
            )
        rows = [_continued(code, t, alive) for t, alive in zip(thrust, live, strict=True)]
        return cls(np.array(static.speed_mps), code, np.array(rows))

    def thrust_max_n(self, speed_mps: float) -> float:
        """Thrust at the largest code and a speed along the thrust. [N]."""
        return float(self.thrust(self.code[-1], abs(speed_mps)))

    def thrust(self, code: ArrayLike, speed_mps: ArrayLike) -> FloatArray:
        """Thrust for signed codes; speed along the thruster's positive direction.

        Codes and speeds beyond the grid are held at its edge. [N]
        """
        codes, speed = np.broadcast_arrays(np.asarray(code, float), np.asarray(speed_mps, float))
        along = np.maximum(np.sign(codes) * speed, 0.0)
        row, row_share = _place(along, self.speed_mps)
        column, column_share = _place(np.abs(codes), self.code)
        t = np.stack([self.thrust_n, self.thrust_n if self.reverse_n is None else self.reverse_n])
        side = (codes < 0.0).astype(np.int64)
        next_row = np.minimum(row + 1, len(self.speed_mps) - 1)
        next_column = np.minimum(column + 1, len(self.code) - 1)
        low = (1 - column_share) * t[side, row, column] + column_share * t[side, row, next_column]
        high = (1 - column_share) * t[side, next_row, column] + column_share * t[
            side, next_row, next_column
        ]
        size = (1 - row_share) * low + row_share * high
        # below the first code of the grid nothing is known: no thrust at code 0 at least
        size = np.where(codes == 0.0, 0.0, np.maximum(size, 0.0))
        return np.asarray(np.sign(codes) * size + 0.0)


def _continued(code: FloatArray, thrust: FloatArray, live: BoolArray) -> FloatArray:
    """Continue the two first live nodes of a row straight into its dead zone."""
    where = np.flatnonzero(live)
    if where.size < 2:  # at most one point with thrust: no slope to continue
        return np.where(live, thrust, 0.0)
    first, second = where[0], where[1]
    slope = (thrust[second] - thrust[first]) / (code[second] - code[first])
    below = thrust[first] + slope * (code - code[first])
    return np.asarray(np.where(code < code[first], np.minimum(below, 0.0), thrust))


def _place(x: FloatArray, knots: FloatArray) -> tuple[IntArray, FloatArray]:
    """Index of the cell below x and the share of the way to the next knot, clamped."""
    if len(knots) == 1:
        return np.zeros(x.shape, dtype=np.int64), np.zeros(x.shape)
    place = np.searchsorted(knots, x, side="right").astype(np.int64)
    index: IntArray = np.clip(place - 1, 0, len(knots) - 2)
    share = (x - knots[index]) / (knots[index + 1] - knots[index])
    return index, np.clip(share, 0.0, 1.0)
