"""The monotone firmware grid of N(T, V), from the static family or from the mooring test alone."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.mooring_inverse import mooring_curve
from pipeline.identify.thrust_curve import ThrustCurve, curve_from_family
from pipeline.records.fits import FirmwareBranch, FirmwareCharacteristic, StaticCharacteristic
from pipeline.records.measurements import MooringPoint
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle

#: Knots of T / T_max, closer where the calculated curves bend most.
FRACTIONS = np.linspace(0.0, 1.0, 33) ** 1.5
_HALF = 0.5 * np.linspace(0.0, 1.0, 17) ** 1.5
#: The same for measured curves, which bend at both ends.
MEASURED_FRACTIONS = np.concatenate([_HALF, 1.0 - _HALF[-2::-1]])
#: Every how many rows of the family (0.1 m/s each) the grid has one.
SPEED_STRIDE = 2
AGAINST_MOTION = (
    "Thrust against the motion is taken from the row at rest: nothing was measured there. The "
    "open-water curves continued to J < 0 bound it from the other side."
)
AT_REST_ONLY = (
    "The row at rest holds at every speed, along the motion and against it: nothing was measured "
    "under way."
)


@dataclass(frozen=True)
class Family:
    """Curves T(N) of the static family by speed; speeds without thrust are left out."""

    speed_mps: FloatArray
    curves: tuple[ThrustCurve, ...]

    def at(self, speed_mps: float) -> ThrustCurve:
        """Return the curve of the nearest speed."""
        return self.curves[int(np.argmin(np.abs(self.speed_mps - speed_mps)))]


def family_curves(static: StaticCharacteristic, thrust_dead_n: float) -> Family | None:
    """Curves of every speed of the family up to the first whose T_max is within the dead thrust.

    Parameters
    ----------
    static : StaticCharacteristic
        The family on its grid.
    thrust_dead_n : float
        Thrust that counts as none. [N]
    """
    code = np.array(static.code)
    speeds, curves = [], []
    for speed, row, status in zip(static.speed_mps, static.thrust_n, static.status, strict=True):
        met = np.array([s != "no_working_point" for s in status])
        curve = curve_from_family(code[met], np.array(row)[met]) if met[-1] else None
        if curve is None or curve.thrust_max_n <= thrust_dead_n:
            break
        speeds.append(speed)
        curves.append(curve)
    return Family(np.array(speeds), tuple(curves)) if speeds else None


def grid_from_family(family: Family, vehicle: Vehicle) -> FirmwareCharacteristic:
    """Tabulate |N| over speed and T / T_max; the negative sign mirrors the positive one.

    Parameters
    ----------
    family : Family
        Curves by speed.
    vehicle : Vehicle
        Range of codes and dead thrust.
    """
    last = len(family.speed_mps) - 1
    picked = sorted({*range(0, last + 1, SPEED_STRIDE), last})
    speeds = family.speed_mps[picked]
    curves = [family.curves[index] for index in picked]
    return _characteristic(
        _branch(1, speeds, curves, FRACTIONS, AGAINST_MOTION),
        _branch(-1, speeds, curves, FRACTIONS, AGAINST_MOTION),
        vehicle,
    )


def grid_from_mooring(points: tuple[MooringPoint, ...], vehicle: Vehicle) -> FirmwareCharacteristic:
    """Tabulate |N| at rest, each sign from its own measured points.

    Parameters
    ----------
    points : tuple of MooringPoint
        Points of one supply voltage, of every sign that the drive takes.
    vehicle : Vehicle
        Range of codes and dead thrust.

    Raises
    ------
    CannotComputeError
        If a sign has too few codes, or no code gives more than the dead thrust.
    """
    rest = np.zeros(1)
    forward = mooring_curve(points, 1)
    # a drive that takes no negative code has none to measure, and is never sent one
    reverse = mooring_curve(points, -1) if vehicle.drive.code_min < 0 else forward
    strongest = max((forward, reverse), key=lambda curve: curve.thrust_max_n)
    dead_n = vehicle.tables.thrust_dead_n
    if strongest.thrust_max_n <= dead_n:
        raise CannotComputeError(
            within_dead_thrust(strongest.code[-1], strongest.thrust_max_n, dead_n)
        )
    return _characteristic(
        _branch(1, rest, [forward], MEASURED_FRACTIONS, AT_REST_ONLY),
        _branch(-1, rest, [reverse], MEASURED_FRACTIONS, AT_REST_ONLY),
        vehicle,
    )


def within_dead_thrust(code: float, thrust_n: float, dead_n: float) -> str:
    """Say that the most thrust that a code gives at rest counts as none."""
    return (
        f"at rest code {code:g} gives {thrust_n:.3g} N, which is within the dead thrust of "
        f"{dead_n:g} N (tables.thrust_dead_n)"
    )


def _characteristic(
    positive: FirmwareBranch, negative: FirmwareBranch, vehicle: Vehicle
) -> FirmwareCharacteristic:
    return FirmwareCharacteristic(
        thrust_dead_n=vehicle.tables.thrust_dead_n,
        code_min=vehicle.drive.code_min,
        code_max=vehicle.drive.code_max,
        positive=positive,
        negative=negative,
    )


def _branch(
    sign: Literal[1, -1],
    speed_mps: FloatArray,
    curves: list[ThrustCurve],
    fraction: FloatArray,
    against_motion: str,
) -> FirmwareBranch:
    return FirmwareBranch(
        sign=sign,
        speed_mps=tuple(speed_mps.tolist()),
        thrust_max_n=tuple(curve.thrust_max_n for curve in curves),
        fraction=tuple(fraction.tolist()),
        code=tuple(
            tuple(curve.code_at(fraction * curve.thrust_max_n).tolist()) for curve in curves
        ),
        against_motion=against_motion,
    )
