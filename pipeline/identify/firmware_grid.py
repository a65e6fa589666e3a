"""The monotone firmware grid of N(T, V), each sign from its family."""

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.thrust_family import Family
from pipeline.records.fits import FirmwareBranch, FirmwareCharacteristic, StaticCharacteristic
from pipeline.records.measurements import MooringPoint
from pipeline.vehicle.schema import Vehicle

_HALF = 0.5 * np.linspace(0.0, 1.0, 17) ** 1.5
#: Knots of T / T_max, closer where curves bend: calculated ones below, measured ones at both ends.
FRACTIONS = np.concatenate([_HALF, 1.0 - _HALF[-2::-1]])
#: Every how many rows of the family (0.1 m/s each) the grid has one; of rows further apart all.
SPEED_STRIDE, FASTER_FROM_MPS = 2, 0.15
#: The row that ends the grid: its thrust, and its least distance from the row before.
NO_THRUST_N, NO_THRUST_MPS = 0.02, 0.05
AGAINST_MOTION = (
    "Thrust against the motion is taken from the row at rest, or where that is more is the drag of "
    "the freely turning propeller: nothing was measured there. The open-water curves continued to "
    "J < 0 bound it from the other side."
)
AT_REST_ONLY = (
    "The row at rest holds at every speed, along the motion and against it: nothing was measured "
    "under way."
)


def firmware_grid(
    families: tuple[Family, Family],
    vehicle: Vehicle,
    static: StaticCharacteristic | None,
    points: tuple[MooringPoint, ...] = (),
) -> FirmwareCharacteristic:
    """Tabulate |N| over speed and T / T_max, each sign from its own family.

    Parameters
    ----------
    families : tuple of Family
        Ahead and in reverse.
    vehicle : Vehicle
        Range of codes and dead thrust.
    static : StaticCharacteristic or None
        Where the calculation was tested, and the drag of a propeller that does not drive.
    points : tuple of MooringPoint
        What was measured at rest, for the voltage and the names of the files.

    Raises
    ------
    CannotComputeError
        If no code gives more than the dead thrust.
    """
    dead_n = vehicle.tables.thrust_dead_n
    strongest = max((one.curves[0] for one in families), key=lambda curve: curve.thrust_max_n)
    if strongest.thrust_max_n <= dead_n:
        raise CannotComputeError(
            within_dead_thrust(strongest.code[-1], strongest.thrust_max_n, dead_n)
        )
    drag = 0.0 if static is None else static.free_drag_ns2pm2
    tested = 0.0
    if static is not None:
        rows = [
            v for v, row in zip(static.speed_mps, static.status, strict=True) if row[-1] == "live"
        ]
        tested = max(rows, default=0.0) if static.faster is None else static.faster.tested_mps
    tested = max(tested, *(one.tested_mps for one in families))
    positive, negative = (_branch(one, drag) for one in families)
    return FirmwareCharacteristic(
        thrust_dead_n=dead_n,
        code_min=vehicle.drive.code_min,
        code_max=vehicle.drive.code_max,
        positive=positive,
        negative=negative,
        tested_mps=min(tested, positive.speed_mps[-1]),
        supply_voltage_v=_voltage(vehicle, points),
        sources=tuple(
            sorted({p.source.file for p in points} | set(() if static is None else static.sources))
        ),
    )


def _voltage(vehicle: Vehicle, points: tuple[MooringPoint, ...]) -> float | None:
    """Supply voltage of the tables, None where nothing tells it. [V]."""
    if vehicle.tables.supply_voltage_v is not None:
        return vehicle.tables.supply_voltage_v
    known = [p.voltage_v for p in points if p.voltage_v is not None]
    return round(float(np.median(known)), 3) if known else None


def within_dead_thrust(code: float, thrust_n: float, dead_n: float) -> str:
    """Say that the most thrust that a code gives at rest counts as none."""
    return (
        f"at rest code {code:g} gives {thrust_n:.3g} N, which is within the dead thrust of "
        f"{dead_n:g} N (tables.thrust_dead_n)"
    )


def _branch(family: Family, drag_ns2pm2: float) -> FirmwareBranch:
    """Tabulate one sign; a last row, of next to no thrust, ends what the balance gives."""
    last = len(family.speed_mps) - 1
    at_rest = last == 0
    table = np.flatnonzero(np.diff(family.speed_mps, append=np.inf) < FASTER_FROM_MPS)
    picked = sorted({*table[::SPEED_STRIDE].tolist(), *range(table.size, last + 1), 0, last})
    speeds, curves = family.speed_mps[picked], [family.curves[index] for index in picked]
    largest = [curve.thrust_max_n for curve in curves]
    rows = [curve.code_at(FRACTIONS * curve.thrust_max_n).tolist() for curve in curves]
    if not at_rest:
        slope = (largest[-2] - largest[-1]) / (speeds[-1] - speeds[-2])
        if slope > 0.0:
            end = speeds[-1] + max((largest[-1] - NO_THRUST_N) / slope, NO_THRUST_MPS)
            speeds, largest = np.append(speeds, end), [*largest, NO_THRUST_N]
            rows.append(rows[-1])
    return FirmwareBranch(
        sign=family.sign,
        speed_mps=tuple(speeds.tolist()),
        thrust_max_n=tuple(largest),
        fraction=tuple(FRACTIONS.tolist()),
        code=tuple(tuple(row) for row in rows),
        against_motion=AT_REST_ONLY if at_rest else AGAINST_MOTION,
        drag_n=() if at_rest else tuple((drag_ns2pm2 * speeds**2).tolist()),
        basis=family.basis,
    )
