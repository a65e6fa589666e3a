"""The mooring test less the calculation at rest, code by code."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.records.fit_values import speed_index, static_std, static_thrust
from pipeline.records.fits import DriveFit, StaticCharacteristic
from pipeline.records.intervals import NORMAL_95, static_factor
from pipeline.records.measurements import MooringPoint


@dataclass(frozen=True)
class CodeGap:
    """Mooring test and calculation at one signed code; thrusts are magnitudes."""

    code: float
    points: int
    measured_n: float
    calculated_n: float
    half_width_n: float
    """95 %, of the calculation and of the mean of the mooring points together."""

    @property
    def gap_n(self) -> float:
        """Measured less calculated, positive where the mooring test gives more."""
        return self.measured_n - self.calculated_n


def code_gaps(
    points: Sequence[MooringPoint], static: StaticCharacteristic, drive: DriveFit | None = None
) -> tuple[CodeGap, ...]:
    """Mean of the mooring points at each signed code, less the calculation at rest."""
    row = speed_index(static.speed_mps, 0.0)
    if row is None:
        return ()
    used = {p.code for p in points if p.code != 0}
    by_code = {own: np.array([p.thrust_n for p in points if p.code == own]) for own in sorted(used)}
    # of the points about their code's mean, pooled
    squares = sum(float(np.sum((own - np.mean(own)) ** 2)) for own in by_code.values())
    freedom = sum(len(own) - 1 for own in by_code.values())
    scatter = float(np.sqrt(squares / freedom)) if freedom > 0 else 0.0
    gaps = []
    for value, measured in by_code.items():
        calculated = float(static_thrust(static, row, abs(value)))
        if not calculated > 0 or abs(value) > static.code[-1]:
            continue
        thrust = float(np.sign(value)) * measured
        half = np.hypot(
            static_factor(static, drive) * float(static_std(static, row, value)),
            NORMAL_95 * scatter / np.sqrt(len(thrust)),
        )
        gaps.append(CodeGap(value, len(thrust), float(np.mean(thrust)), calculated, float(half)))
    return tuple(gaps)
