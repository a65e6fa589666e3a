"""Checks that stand between a mooring test and firmware: what fails here must be accepted first."""

from itertools import pairwise

import numpy as np

from pipeline.identify.cubic_inverse import mean_by_code
from pipeline.identify.smoothing import white_noise_std
from pipeline.records.fits import Check, PolynomialFit
from pipeline.records.measurements import MooringPoint
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle

#: A fall of this share of the largest thrust is more than a rig's scatter.
_FALL_SHARE = 0.03
_SCATTERS = 4.0
#: Neighbouring codes differ by less than this factor, above a twentieth of the largest thrust.
_JUMP = 8.0
_CLEAR_SHARE = 0.05
#: A reading at rest above this share of the largest thrust is no tare.
_NEUTRAL_SHARE = 0.15
_OUTLIER_SHARE = 0.1
#: Of the largest code; closer than that the cubic may be at fault.
_FAR_SHARE = 0.03
_FEWEST_POINTS = 10


def rising_points(
    points: tuple[MooringPoint, ...],
) -> tuple[tuple[MooringPoint, ...], tuple[Check, ...]]:
    """Leave out the codes beyond which thrust falls: an inverse has one code for a thrust.

    Returns the points up to the code of the largest thrust of each sign, and the check "thrust
    rises with the code", for a gate.
    """
    kept, texts = list(points), []
    for sign in (1, -1):
        code, thrust_n = mean_by_code(points, sign)
        at = _fold(thrust_n)
        if at is None:
            continue
        kept = [p for p in kept if sign * p.code <= code[at]]
        texts.append(
            f"beyond code {sign * code[at]:g} ({thrust_n[at]:.3g} N) thrust falls to "
            f"{thrust_n[at:].min():.3g} N; codes beyond it are in no table"
        )
    check = Check(
        name="thrust rises with the code",
        passed=not texts,
        text="; ".join(texts) or "no code gives less thrust than a smaller one",
        gate="thrust_rises",
    )
    return tuple(kept), (check,)


def gate_checks(
    points: tuple[MooringPoint, ...],
    fits: tuple[PolynomialFit | None, PolynomialFit | None],
    vehicle: Vehicle,
) -> tuple[Check, ...]:
    """Check what a table of thrust cannot be wrong in without a sign of it.

    `points` are the usable ones of one supply voltage, `fits` Table 3, positive and negative.
    """
    if not points:
        return ()
    return (
        _neighbours(points),
        _neutral(points),
        _outliers(fits),
        _signs(fits, reverses=vehicle.drive.code_min < 0),
    )


def _fold(thrust_n: FloatArray) -> int | None:
    """Return the position of the largest thrust where what follows falls by more than scatter."""
    if thrust_n.size < 4:
        return None
    at = int(np.argmax(thrust_n))
    fall = float(thrust_n[at] - thrust_n[at:].min())
    scatter = white_noise_std(thrust_n)
    return at if fall > max(_FALL_SHARE * thrust_n[at], _SCATTERS * scatter) else None


def _neighbours(points: tuple[MooringPoint, ...]) -> Check:
    texts = []
    for sign in (1, -1):
        code, thrust_n = mean_by_code(points, sign)
        if thrust_n.size < 3:
            continue
        # below it a first code beyond the dead zone may give much more than the last within it
        clear = _CLEAR_SHARE * thrust_n.max()
        texts += [
            f"{before:.3g} N at code {sign * code[at]:g} and {after:.3g} N at "
            f"{sign * code[at + 1]:g}"
            for at, (before, after) in enumerate(pairwise(thrust_n.tolist()))
            if before > clear and not before / _JUMP < after < before * _JUMP
        ]
    return Check(
        name="neighbouring codes give thrust of one size",
        passed=not texts,
        text="; ".join(texts[:3]) or f"no step by a factor of {_JUMP:g}",
        gate="neighbours",
    )


def _neutral(points: tuple[MooringPoint, ...]) -> Check:
    largest = max(abs(p.thrust_n) for p in points)
    tare = max(abs(p.tare_n) for p in points)
    return Check(
        name="rest gives no thrust",
        passed=tare <= _NEUTRAL_SHARE * largest,
        text=f"the reading at code 0 is {tare:.3g} N, the largest thrust {largest:.3g} N",
        gate="neutral",
    )


def _outliers(fits: tuple[PolynomialFit | None, ...]) -> Check:
    shares = [0.0]
    for fit in fits:
        if fit is None or len(fit.points) < _FEWEST_POINTS:
            continue
        far = _FAR_SHARE * max(abs(one.measured) for one in fit.points)
        off = sum(one.outlier and abs(one.measured - one.fitted) > far for one in fit.points)
        shares.append(off / len(fit.points))
    share = max(shares)
    return Check(
        name="outliers are few",
        passed=share <= _OUTLIER_SHARE,
        text=f"{100 * share:.0f} % of the points of a sign lie far off Table 3",
        gate="outliers",
    )


def _signs(fits: tuple[PolynomialFit | None, PolynomialFit | None], *, reverses: bool) -> Check:
    asked = [("positive", fits[0]), *([("negative", fits[1])] if reverses else [])]
    missing = [name for name, fit in asked if fit is None]
    both = len(missing) == len(asked)
    return Check(
        name="Table 3 could be fitted",
        passed=not both,
        text=f"no fit of {' and '.join(missing)} thrust" if missing else "each sign was fitted",
        gate="signs",
    )
