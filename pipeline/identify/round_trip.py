"""Thrust to code and back: how much each inverse form loses, and whether it is monotone."""

import numpy as np

from pipeline.control.inverse import thrust_grid
from pipeline.identify.speed_inverse import cubic_code
from pipeline.identify.thrust_family import Family
from pipeline.physics.propeller import polynomial
from pipeline.physics.thrust_grid import code_from_thrust
from pipeline.records.fits import Check, FirmwareCharacteristic, RoundTrip, SpeedInverse
from pipeline.types import FloatArray
from pipeline.vehicle.bench_schema import Published

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
