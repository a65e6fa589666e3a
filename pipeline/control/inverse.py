"""Thrust to control code: the mooring cubic (7), the speed cubic (8), the firmware grid.

One protocol for the allocator's two variants. Speed is that of the vehicle along the thruster's
positive direction; against the motion every form uses its values at rest.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np

from pipeline.control.allocation import ThrustLimits
from pipeline.errors import CannotComputeError
from pipeline.physics.thrust_grid import ThrustGrid, code_from_thrust, thrust_limits
from pipeline.records.fits import FirmwareBranch, InverseCharacteristic
from pipeline.types import ArrayLike, FloatArray
from pipeline.vehicle.schema import Vehicle

#: Thrusts among which the one at the most negative code is looked for.
_THRUSTS = 513


class Inverse(Protocol):
    """What the allocator needs to know of a thruster."""

    @property
    def name(self) -> str:
        """What it is, for the report."""

    def limits(self, speed_mps: float) -> ThrustLimits:
        """T_max for each sign at a speed of the vehicle. [N]."""

    def code(self, thrust_n: ArrayLike, speed_mps: ArrayLike) -> FloatArray:
        """Signed code for a wanted thrust, not rounded, clamped to the drive's range."""


def rounded(code: FloatArray) -> FloatArray:
    """Round to whole codes, halves away from zero as C's `lround` does.

    >>> rounded(np.array([-2.5, 0.4, 2.5])).tolist()
    [-3.0, 0.0, 3.0]
    """
    return np.sign(code) * np.floor(np.abs(code) + 0.5)


@dataclass(frozen=True)
class CodeRange:
    """Thrust up to which the code is zero [N], and the ends of the codes.

    Without `code_min` the range is symmetric; a mirrored branch of a table may go beyond it.
    """

    thrust_dead_n: float
    code_max: int
    code_min: int | None = None

    @classmethod
    def of(cls, vehicle: Vehicle) -> Self:
        """Return that of the tables of a vehicle."""
        return cls(vehicle.tables.thrust_dead_n, vehicle.drive.code_max, vehicle.drive.code_min)

    @property
    def lowest(self) -> int:
        """Most negative code."""
        return -self.code_max if self.code_min is None else self.code_min

    def held(self, code: FloatArray, thrust_n: FloatArray) -> FloatArray:
        """Codes within the range, 0 up to the dead thrust."""
        live = np.abs(thrust_n) > self.thrust_dead_n
        return np.where(live, np.clip(code, self.lowest, self.code_max), 0.0)

    def reverse_n(self, code: Callable[[FloatArray], FloatArray], largest_n: float) -> float:
        """Reverse thrust up to `largest_n` that the drive's most negative code still gives. [N].

        `code` gives the codes of thrusts of either sign. A cubic is not inverted: the thrust is
        looked for among evenly spaced ones, and a symmetric range cuts nothing.
        """
        if self.lowest <= -self.code_max:
            return largest_n
        reverse = np.linspace(0.0, largest_n, _THRUSTS)
        reverse = reverse[code(-reverse) > self.lowest]
        return float(reverse[-1]) if reverse.size else 0.0


@dataclass(frozen=True)
class MooringCubic:
    """Inverse (7), Table 3: a cubic in the signed thrust for each sign, the same at every speed.

    `positive` and `negative` shape (d + 1,), ascending; `thrust_max_n` from the mooring test.
    """

    positive: FloatArray
    negative: FloatArray
    thrust_max_n: ThrustLimits
    codes: CodeRange
    name: str = "mooring inverse (7), Table 3"

    def limits(self, speed_mps: float) -> ThrustLimits:  # noqa: ARG002 (fixed: the paper's point)
        """T_max of the mooring test, whatever the speed; less in reverse where codes end. [N]."""
        forward, reverse = self.thrust_max_n.forward_n, self.thrust_max_n.reverse_n
        reverse = self.codes.reverse_n(lambda thrust: self.code(thrust, 0.0), reverse)
        return ThrustLimits(forward, reverse)

    def code(self, thrust_n: ArrayLike, speed_mps: ArrayLike) -> FloatArray:
        """N(T) of eq. (7); the speed does not enter."""
        thrust, _ = np.broadcast_arrays(np.asarray(thrust_n, float), np.asarray(speed_mps, float))
        largest = self.thrust_max_n
        held = np.minimum(np.maximum(thrust, -largest.reverse_n), largest.forward_n)
        polyval = np.polynomial.polynomial.polyval
        code = np.where(held > 0.0, polyval(held, self.positive), polyval(held, self.negative))
        return self.codes.held(code, thrust)


@dataclass(frozen=True)
class SpeedCubic:
    """Inverse (8), Table 4: rows of K_N0..K_N3 by speed, mirrored for negative thrust.

    Between tabulated speeds the *codes* at equal T / T_max(V) are interpolated, not the
    coefficients at equal T: that would evaluate the faster row beyond its own T_max, where the
    cubic was never fitted, and the printed coefficients are not monotone in speed. The code rises
    with the thrust wherever both rows do.

    `speed_mps`, `thrust_max_n` shape (v,); `coefficients` shape (v, 4).
    """

    speed_mps: FloatArray
    thrust_max_n: FloatArray
    coefficients: FloatArray
    codes: CodeRange
    name: str = "speed-compensated cubic (8), Table 4"

    def _largest(self, speed_mps: ArrayLike) -> FloatArray:
        return np.asarray(np.interp(speed_mps, self.speed_mps, self.thrust_max_n))

    def limits(self, speed_mps: float) -> ThrustLimits:
        """+-T_max(V), linear between tabulated speeds; less in reverse where codes end. [N]."""
        largest = float(self._largest(abs(speed_mps)))
        reverse = self.codes.reverse_n(lambda thrust: self.code(thrust, -abs(speed_mps)), largest)
        return ThrustLimits(largest, reverse)

    def code(self, thrust_n: ArrayLike, speed_mps: ArrayLike) -> FloatArray:
        """N(T, V) of eq. (8)."""
        thrust, speed = np.broadcast_arrays(
            np.asarray(thrust_n, float), np.asarray(speed_mps, float)
        )
        along = np.clip(np.sign(thrust) * speed, 0.0, self.speed_mps[-1])
        fraction = np.minimum(np.abs(thrust) / self._largest(along), 1.0)
        rows = np.stack(
            [
                np.polynomial.polynomial.polyval(fraction * largest, row)
                for largest, row in zip(self.thrust_max_n, self.coefficients, strict=True)
            ]
        )
        upper = np.clip(np.searchsorted(self.speed_mps, along), 1, max(len(rows) - 1, 1))
        if len(rows) == 1:
            size = rows[0]
        else:
            low = self.speed_mps[upper - 1]
            share = (along - low) / (self.speed_mps[upper] - low)
            below = np.take_along_axis(rows, (upper - 1)[None], axis=0)[0]
            above = np.take_along_axis(rows, upper[None], axis=0)[0]
            size = (1.0 - share) * below + share * above
        return self.codes.held(np.sign(thrust) * np.maximum(size, 0.0), thrust)


@dataclass(frozen=True)
class FirmwareGrid:
    """The monotone grid that the firmware evaluates; the default with compensation.

    With `at_rest` the row at rest is used at every speed: a mooring inverse for a vehicle
    without mooring data.
    """

    positive: ThrustGrid
    negative: ThrustGrid
    codes: CodeRange
    at_rest: bool = False
    name: str = "speed-compensated firmware grid"

    def limits(self, speed_mps: float) -> ThrustLimits:
        """+-T_max(V), linear between the grid's speeds; in reverse T at `code_min`. [N]."""
        forward, reverse = thrust_limits(
            0.0 if self.at_rest else speed_mps,
            positive=self.positive,
            negative=self.negative,
            code_min=self.codes.lowest,
        )
        return ThrustLimits(float(forward), -float(reverse) + 0.0)

    def code(self, thrust_n: ArrayLike, speed_mps: ArrayLike) -> FloatArray:
        """N(T, V) of the grid."""
        speed = np.zeros_like(np.asarray(speed_mps, float)) if self.at_rest else speed_mps
        code = code_from_thrust(
            thrust_n,
            speed,
            positive=self.positive,
            negative=self.negative,
            thrust_dead_n=self.codes.thrust_dead_n,
        )
        return np.minimum(np.maximum(code, self.codes.lowest), self.codes.code_max)


def thrust_grid(branch: FirmwareBranch) -> ThrustGrid:
    """Arrays of one recorded branch of the firmware form."""
    return ThrustGrid(
        speed_mps=np.array(branch.speed_mps),
        thrust_max_n=np.array(branch.thrust_max_n),
        fraction=np.array(branch.fraction),
        code=np.array(branch.code),
        drag_n=np.array(branch.drag_n),
    )


def firmware_grid(record: InverseCharacteristic, *, at_rest: bool = False) -> FirmwareGrid:
    """Take the firmware form out of the record.

    Raises
    ------
    CannotComputeError
        If the record has none.
    """
    firmware = record.firmware
    if firmware is None:
        raise CannotComputeError(
            "There is no firmware form of N(T, V): " + " ".join(record.explanations)
        )
    codes = CodeRange(firmware.thrust_dead_n, firmware.code_max, firmware.code_min)
    grids = thrust_grid(firmware.positive), thrust_grid(firmware.negative)
    name = "firmware grid, row at rest at every speed" if at_rest else FirmwareGrid.name
    return FirmwareGrid(*grids, codes, at_rest, name)


def speed_cubic(record: InverseCharacteristic, codes: CodeRange) -> SpeedCubic:
    """Take Table 4 out of the record.

    Raises
    ------
    CannotComputeError
        If Table 4 is empty.
    """
    if not record.table4:
        raise CannotComputeError("There is no Table 4: " + " ".join(record.explanations))
    return SpeedCubic(
        speed_mps=np.array([row.speed_mps for row in record.table4]),
        thrust_max_n=np.array([row.thrust_max_n for row in record.table4]),
        coefficients=np.array([row.coefficients for row in record.table4]),
        codes=codes,
    )


def mooring_cubic(record: InverseCharacteristic, codes: CodeRange) -> MooringCubic | None:
    """Take Table 3 out of the record; None without any mooring data.

    A sign that was not measured is mirrored from the other: N(-T) = -N(T).
    """
    forward, reverse = record.table3_positive, record.table3_negative
    measured = [fit for fit in (forward, reverse) if fit is not None]
    if not measured:
        return None
    name = MooringCubic.name
    if len(measured) == 1:
        name += " (one sign measured, the other mirrored)"
    positive, negative = (np.array(fit.coefficients) for fit in (measured[0], measured[-1]))
    # c_i T^i turns into -c_i (-T)^i
    if forward is None:
        positive = -positive * (-1.0) ** np.arange(len(positive))
    if reverse is None:
        negative = -negative * (-1.0) ** np.arange(len(negative))
    ahead, astern = (
        max(abs(end) for end in fit.quality.valid_range) for fit in (measured[0], measured[-1])
    )
    return MooringCubic(positive, negative, ThrustLimits(ahead, astern), codes, name)
