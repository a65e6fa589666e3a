"""The monotone firmware grid of N(T, V), each sign from its family, and how much it loses.

A round trip sends thrusts through an inverse form and back through the family that it is made from.
"""

import numpy as np

from pipeline.control.inverse import thrust_grid
from pipeline.errors import CannotComputeError
from pipeline.identify.cubic_inverse import cubic_code
from pipeline.identify.thrust_family import Family
from pipeline.physics.propeller import polynomial
from pipeline.physics.thrust_grid import code_from_thrust
from pipeline.records.fits import (
    Check,
    FirmwareBranch,
    FirmwareCharacteristic,
    RoundTrip,
    SpeedInverse,
    StaticCharacteristic,
)
from pipeline.records.measurements import MooringPoint
from pipeline.types import FloatArray
from pipeline.vehicle.bench_schema import Published
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

    `families` are those ahead and in reverse; `static` says where the calculation was tested and
    what a propeller drags that does not drive, `points` voltage and files of the mooring test.

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
        speed_mps=speeds.tolist(),
        thrust_max_n=largest,
        fraction=FRACTIONS.tolist(),
        code=rows,
        against_motion=AT_REST_ONLY if at_rest else AGAINST_MOTION,
        drag_n=() if at_rest else (drag_ns2pm2 * speeds**2).tolist(),
        basis=family.basis,
    )


TRIP_POINTS = 400
#: What the forms are held to [N], or for a large thruster the share of its largest thrust.
CUBIC_LIMIT_N, CUBIC_LIMIT_SHARE = 0.3, 0.007
FIRMWARE_LIMIT_N, FIRMWARE_LIMIT_SHARE = 0.1, 0.002


def round_trips(
    families: tuple[Family, Family],
    calculated: Family,
    table4: tuple[SpeedInverse, ...],
    firmware: FirmwareCharacteristic,
    published: Published | None,
) -> tuple[RoundTrip, ...]:
    """Send thrusts through N(T, V) and back through the family at every speed it was solved for.

    The curves of both signs judge the grid of the firmware, those that were calculated the cubics
    of Table 4, at their own speeds. The printed Tables 2 and 4 are sent through each other.
    """
    dead_n = firmware.thrust_dead_n
    grids = {"positive": thrust_grid(firmware.positive), "negative": thrust_grid(firmware.negative)}
    trips = []
    for speed, cubic in zip(calculated.speed_mps.tolist(), calculated.curves, strict=True):
        row = next((r for r in table4 if abs(r.speed_mps - speed) < 1e-9), None)
        wanted = np.linspace(dead_n, cubic.thrust_max_n, TRIP_POINTS)[1:]
        off, codes = [], []
        for sign, family in zip((1.0, -1.0), families, strict=True):
            curve = family.at(speed)
            if speed > family.speed_mps[-1] or curve.thrust_max_n <= dead_n:
                continue
            own = np.linspace(dead_n, curve.thrust_max_n, TRIP_POINTS)[1:]
            code = sign * code_from_thrust(sign * own, sign * speed, thrust_dead_n=dead_n, **grids)
            off.append(_largest(curve.thrust(code) - own))
            codes.append(_largest(np.minimum(np.round(code), curve.code[-1]) - curve.code_at(own)))
        trips.append(
            RoundTrip(
                speed_mps=speed,
                cubic_n=_largest(cubic.thrust(cubic_code(row, wanted)) - wanted) if row else None,
                firmware_n=max(off, default=0.0),
                firmware_rounded_codes=max(codes, default=0.0),
                published_n=_published_trip(published, speed, dead_n),
            )
        )
    return tuple(trips)


def _published_trip(published: Published | None, speed: float, dead_n: float) -> float | None:
    """Largest error of the printed Table 4 sent back through the printed Table 2."""
    if published is None or published.table2 is None or published.table4 is None:
        return None
    forward, inverse = published.table2, published.table4
    if speed not in forward.speed_mps or speed not in inverse.speed_mps:
        return None
    i, j = forward.speed_mps.index(speed), inverse.speed_mps.index(speed)
    wanted = np.linspace(dead_n, inverse.T_max_n[j], TRIP_POINTS)[1:]
    code = polynomial(wanted, [inverse.KN0[j], inverse.KN1[j], inverse.KN2[j], inverse.KN3[j]])
    back = polynomial(code, [forward.KF0[i], forward.KF1[i], forward.KF2[i]])
    return _largest(np.maximum(back, 0.0) - wanted)


def _largest(error: FloatArray) -> float:
    return float(np.max(np.abs(error)))


def trip_checks(
    trips: tuple[RoundTrip, ...], table4: tuple[SpeedInverse, ...], thrust_max_n: float
) -> tuple[Check, ...]:
    """Hold the round trips to their limits; `thrust_max_n` is the largest thrust of all [N]."""
    if not trips:
        return ()
    firmware = max(trip.firmware_n for trip in trips)
    rounded = max(trip.firmware_rounded_codes for trip in trips)
    cubic = max((trip.cubic_n for trip in trips if trip.cubic_n is not None), default=0.0)
    return (
        Check(
            name="round trip of the cubic",
            passed=not table4 or cubic <= max(CUBIC_LIMIT_N, CUBIC_LIMIT_SHARE * thrust_max_n),
            text=f"largest |T(N(T, V), V) - T| at the tabulated speeds {cubic:.3f} N",
        ),
        Check(
            name="round trip of the firmware form",
            passed=firmware <= max(FIRMWARE_LIMIT_N, FIRMWARE_LIMIT_SHARE * thrust_max_n),
            text=f"largest |T(N(T, V), V) - T| every 0.1 m/s {firmware:.3f} N before rounding, "
            f"{rounded:.2f} codes after it",
        ),
    )


def monotone_checks(firmware: FirmwareCharacteristic) -> tuple[Check, ...]:
    """Check N(T, V) for falls with thrust and with speed."""
    wanted = np.linspace(firmware.thrust_dead_n, max(firmware.positive.thrust_max_n), 200)[1:]
    speed = np.linspace(0.0, firmware.positive.speed_mps[-1], 81)
    grid = thrust_grid(firmware.positive)
    code = code_from_thrust(
        wanted[:, None],
        speed[None, :],
        positive=grid,
        negative=thrust_grid(firmware.negative),
        thrust_dead_n=firmware.thrust_dead_n,
    )
    return (
        Check(
            name="firmware form rises with thrust",
            passed=bool((np.diff(code, axis=0) >= -1e-9).all()),
            text="N(T, V) does not fall with T on a grid of 200 thrusts and 81 speeds",
        ),
        Check(
            name="firmware form rises with speed",
            passed=bool((np.diff(code, axis=1) >= -1e-9).all()),
            text="N(T, V) does not fall with V on the same grid",
        ),
    )
