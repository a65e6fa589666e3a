"""Half-width of a 95 % interval in standard errors, for those who hold only the records."""

import numpy as np

from pipeline.records.fits import (
    DriveFit,
    Interval,
    InverseCharacteristic,
    PolynomialFit,
    StaticCharacteristic,
    StaticRow,
)

#: 0.975 quantile of the standard normal distribution.
NORMAL_95 = 1.959963984540054
#: Sweeps for each term of the drive's surface below which its intervals are still too narrow.
SWEEPS_PER_TERM = 2


def student_95(degrees_of_freedom: int) -> float:
    """0.975 quantile of Student's t.

    >>> round(student_95(11), 3)
    2.201
    """
    # `scipy.stats` takes a second to import
    from scipy.special import stdtrit

    return float(stdtrit(degrees_of_freedom, 0.975))


def drive_degrees(drive: DriveFit) -> int:
    """Degrees of freedom of the drive's covariance: sweeps less one, or points less terms."""
    if drive.clustered:
        return drive.clusters - 1
    return drive.quality.points - len(drive.coefficients)


def drive_factor(drive: DriveFit) -> float:
    """Half-width of a 95 % interval of the drive's surface in standard errors."""
    return student_95(drive_degrees(drive))


def interval_factor(fit: PolynomialFit) -> float:
    """Half-width of the recorded 95 % intervals in standard errors.

    What is derived from a fit then has the factor (normal or Student) that the fit itself used.
    """
    for index, (low, high) in enumerate(fit.ci95):
        std = float(np.sqrt(max(fit.covariance[index][index], 0.0)))
        if std > 0:
            return (high - low) / (2 * std)
    return NORMAL_95


def static_factor(static: StaticCharacteristic, drive: DriveFit | None = None) -> float:
    """Half-width of the 95 % interval of the family's thrust in standard errors.

    Where Table 2 has no row, that of the drive, whose scatter it is; normal where that is unknown.
    """
    if static.table2:
        return interval_factor(static.table2[0].fit)
    return NORMAL_95 if drive is None else drive_factor(drive)


def largest_thrust_interval(row: StaticRow, inverse: InverseCharacteristic | None) -> Interval:
    """95 % interval of T_max: the bench's, widened by what the mooring test differs by."""
    low, high = row.thrust_max_ci95
    own = half = (high - low) / 2.0
    if inverse is not None and inverse.family is not None:
        for side in (inverse.family.positive, inverse.family.negative):
            for speed_mps, widths in zip(side.speed_mps, side.half95_n, strict=True):
                if abs(speed_mps - row.speed_mps) < 1e-9:
                    half = max(half, widths[-1])
    if half == own:
        return low, high
    return row.thrust_max_n - half, row.thrust_max_n + half
