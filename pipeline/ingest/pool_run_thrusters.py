"""Whether the vehicle turns as the commands and the vehicle file say: swapped thrusters show."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.ingest.pool_run_down import down_in_body, turning
from pipeline.ingest.pool_run_meant import rearranged
from pipeline.ingest.pool_run_resample import on_rows, thrusters_of
from pipeline.records.run_arrays import PoolRun
from pipeline.types import BoolArray, FloatArray
from pipeline.vehicle.schema import Vehicle

_TABLE_HZ = 20.0
#: The explained share of the angular acceleration must be at least this to speak of thrusters.
_LEAST_EXPLAINED = 0.15
#: Without an attitude the righting by gravity is left in it; a wrong order may seem to explain it.
_LEAST_WITHOUT_ATTITUDE = 0.6
#: A swap is suspected where it leaves at most this share of what the stated order leaves, in the
#: whole run and in each half of it.
_MOST_LEFT = 0.75
_MOST_LEFT_OF_HALF = 0.9
#: An axis runs against its moments at such a correlation, and such a one in each half of the run.
_AGAINST, _AGAINST_IN_HALF = -0.7, -0.6
_FLIPS = {"roll": (-1.0, 1.0, 1.0), "pitch": (1.0, -1.0, 1.0), "yaw": (1.0, 1.0, -1.0)}


@dataclass(frozen=True)
class _Moments:
    """Angular accelerations (n, 3), thrust shapes (n, thrusters), other causes of turning.

    `others` (n, 3, j) has for each axis its rate, the products of the rates, and, where the
    attitude is known, the direction of gravity, which rights a vehicle.
    """

    acceleration: FloatArray
    effort: FloatArray
    others: FloatArray
    names: tuple[str, ...]

    def part(self, rows: slice) -> "_Moments":
        """Return some of the rows."""
        return _Moments(self.acceleration[rows], self.effort[rows], self.others[rows], self.names)


def thrusters_against_rates(run: PoolRun, vehicle: Vehicle, place: Place) -> Iterator[Problem]:
    """Compare angular accelerations with the moments that the vehicle file promises.

    For each axis: acceleration = gain x moment of the commands + drag x rate + products of rates +
    righting by gravity + constant, with the moment arms of the vehicle file. If exchanging two
    thrusters, or turning one round, explains the accelerations plainly better, in the whole run and
    in both halves of it, that is told.
    """
    moments = _moments_of(run)
    stated = {thruster.name: thruster for thruster in vehicle.thrusters}
    if moments is None or len(moments.names) < 2 or not set(moments.names) <= set(stated):
        return
    arms = np.array(
        [np.cross(stated[name].position_m, stated[name].direction) for name in moments.names]
    )
    whole = _axes_of(moments)
    total = sum(axis.power / axis.rows for axis in whole)
    sign_is_known = "attitude" in run.channels
    candidates = _rearranged(arms, moments.names, sign_is_known=sign_is_known)
    left = {name: _rest(whole, changed) for name, changed in candidates.items()}
    if not left or total <= 0:
        return
    best = min(left, key=lambda name: left[name])
    as_stated = _rest(whole, arms)
    least = _LEAST_EXPLAINED if sign_is_known else _LEAST_WITHOUT_ATTITUDE
    plainly = left[best] < _MOST_LEFT * as_stated and left[best] < (1 - least) * total
    if not plainly or not _in_both_halves(moments, arms, candidates[best]):
        yield from _against_moments(moments, whole, arms, place)
        return
    equal = [name for name in left if left[name] < 1.05 * left[best] and name != best]
    others = f" (or {'; or '.join(equal[:3])})" if equal else ""
    yield place.warning(
        f"the rates suggest that {best} against the vehicle file{others}: the moments as "
        f"stated explain {100 * (1 - as_stated / total):.0f} % of the angular acceleration "
        f"that drag and gravity leave, so changed {100 * (1 - left[best] / total):.0f} %.",
        "",
        "Check the order of the thrusters in the log, their positions and directions, and the "
        "sign of the rates.",
    )


def _against_moments(
    moments: _Moments, whole: Sequence["_Axis"], arms: FloatArray, place: Place
) -> Iterator[Problem]:
    """Say about which axes the vehicle turns against the moments of all its commands.

    One thruster that is reversed does not do that; a rate with the wrong sign, or axes that point
    the other way, do.
    """
    half = len(moments.effort) // 2
    halves = [_axes_of(moments.part(rows)) for rows in (slice(0, half), slice(half, None))]

    for number, name in enumerate(_FLIPS):
        arm = arms[:, number]
        correlation = whole[number].correlation(arm)
        if correlation > _AGAINST or any(
            part[number].correlation(arm) > _AGAINST_IN_HALF for part in halves
        ):
            continue
        what = (
            f"the {name} rate runs against the {name} moment of the commands (correlation "
            f"{correlation:.2f}): its sign or its axes, or those of the thrusters, are others."
        )
        remedy = "Check body_axes and sign of the rates, and directions of the thrusters."
        yield place.warning(what, remedy=remedy)


def _in_both_halves(moments: _Moments, stated: FloatArray, changed: FloatArray) -> bool:
    """Whether changed moment arms are better in the first and in the second half of the run."""
    half = len(moments.effort) // 2
    for rows in (slice(0, half), slice(half, None)):
        axes = _axes_of(moments.part(rows))
        if _rest(axes, changed) > _MOST_LEFT_OF_HALF * _rest(axes, stated):
            return False
    return True


def _rearranged(
    arms: FloatArray, names: Sequence[str], *, sign_is_known: bool
) -> dict[str, FloatArray]:
    """Moment arms with two thrusters exchanged or one turned round; those that change anything.

    Where no attitude tells the sign of a rate, one of the rates or all of them may be turned, too.
    """
    found: dict[str, FloatArray] = {}
    if not sign_is_known:
        found = {f"the {name} rate is reversed": arms * flip for name, flip in _FLIPS.items()}
        found["the rates are all reversed"] = -arms
    return found | dict(rearranged(arms, names))


def _moments_of(run: PoolRun) -> _Moments | None:
    names = thrusters_of(run, "command")
    known = [name for name in ("angular_velocity", "attitude") if name in run.channels]
    if not names or not known:
        return None
    table = on_rows(run, _TABLE_HZ, "command", *known)
    names = tuple(name for name in table.thrusters if name in names)
    if not names:
        return None  # the log commands thrusters that the vehicle file does not have
    codes = table.values["command"][:, [table.thrusters.index(name) for name in names]]
    rate = table.values.get("angular_velocity")
    if rate is None:
        rate = turning(table.values["attitude"], _TABLE_HZ)
    rows = np.all([table.valid[name] for name in table.values], axis=0)
    if rows.sum() < 200:
        return None
    largest = np.abs(codes[rows]).max()
    if largest == 0:
        return None
    smooth = _smoothed(rate, rows)
    acceleration = np.gradient(smooth, 1.0 / _TABLE_HZ, axis=0)
    effort = codes / largest
    # between a linear and a quadratic characteristic; thrust lags by about the smoothing
    effort = _smoothed(effort * np.sqrt(np.abs(effort)), rows)
    p, q, r = smooth.T
    others = [smooth[:, :, None], np.stack([[q * r, p * r, p * q]] * 3).transpose(2, 0, 1)]
    if "attitude" in known:
        gravity = _smoothed(down_in_body(table.values["attitude"]), rows)
        others.append(np.repeat(gravity[:, None, :], 3, axis=1))
    mixed = np.concatenate(others, axis=2)
    inner = (
        np.isfinite(acceleration).all(axis=1)
        & np.isfinite(effort).all(axis=1)
        & np.isfinite(mixed).all(axis=(1, 2))
    )
    if inner.sum() < 200:
        return None
    return _Moments(acceleration[inner], effort[inner], mixed[inner], names)


def _smoothed(values: FloatArray, rows: BoolArray) -> FloatArray:
    """Mean over five rows (0.25 s); not a number where one of them is missing."""
    kernel = np.full(5, 0.2)
    filled = np.where(rows[:, None], values, np.nan)
    return np.stack([np.convolve(column, kernel, mode="same") for column in filled.T], axis=1)


@dataclass(frozen=True)
class _Axis:
    """Normal equations of one axis, all but the commands taken out: y'y, E'y, E'E of n rows."""

    power: float
    against_effort: FloatArray
    effort: FloatArray
    rows: int

    def correlation(self, arm: FloatArray) -> float:
        """Correlation of the angular acceleration with the moment of the commands."""
        power = float(arm @ self.effort @ arm)
        if power <= 1e-9 * self.rows or self.power <= 0.0:
            return 0.0
        return float(arm @ self.against_effort) / float(np.sqrt(power * self.power))


def _axes_of(moments: _Moments) -> list[_Axis]:
    """Condense the run, so that any number of arrangements costs next to nothing."""
    found = []
    for axis in range(3):
        others = moments.others[:, axis]
        others = others - others.mean(axis=0)
        scale = np.linalg.norm(others, axis=0)
        others = others[:, scale > 0] / scale[scale > 0]
        # what the others span, in orthonormal columns; those that say nothing new are dropped
        power, turn = np.linalg.eigh(others.T @ others)
        turn, power = turn[:, power > 1e-9], power[power > 1e-9]
        basis = others @ (turn / np.sqrt(power))
        y = moments.acceleration[:, axis] - moments.acceleration[:, axis].mean()
        effort = moments.effort - moments.effort.mean(axis=0)
        y = y - basis @ (basis.T @ y)
        effort = effort - basis @ (basis.T @ effort)
        found.append(_Axis(float(y @ y), effort.T @ y, effort.T @ effort, y.size))
    return found


def _rest(axes: Sequence[_Axis], arms: FloatArray) -> float:
    """Variance of the angular accelerations that these arms (thrusters, 3) leave, over all axes."""
    rest = 0.0
    for one, arm in zip(axes, arms.T, strict=True):
        power = float(arm @ one.effort @ arm)
        along = float(arm @ one.against_effort)
        # the gain is an inverse inertia: a negative one explains nothing
        gained = max(along, 0.0) ** 2 / power if power > 1e-9 * one.rows else 0.0
        rest += (one.power - gained) / one.rows
    return rest
