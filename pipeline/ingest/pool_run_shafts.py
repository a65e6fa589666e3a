"""What shaft speeds say of commands and of their own unit: suspicions, told and nothing else."""

from collections.abc import Iterator

import numpy as np

from pipeline.errors import Problem
from pipeline.ingest.pool_run_down import CHECK_UNIT
from pipeline.ingest.pool_run_resample import TABLE_HZ, thrusters_of
from pipeline.records.run_arrays import PoolRun
from pipeline.records.run_table import RunTable
from pipeline.types import BoolArray, FloatArray, IntArray
from pipeline.vehicle.schema import Vehicle

#: Twice as fast as those of the fastest thrusters. [m/s]
_FASTEST_TIP_MPS = 40.0
#: No screw pushes beyond its pitch, up to 1.6 diameters; share of the largest command; [m/s]
_MOST_ADVANCE, _HARD, _UNDER_WAY_MPS, _LEAST_ROWS = 1.8, 0.5, 0.3, 100
#: Of what command and shaft speed reach: a speed that follows its command changes by about as much.
_LEAST_SLOPE = 0.5
#: Correlations of a shaft's speed with its own command and with another's that say whose it is.
_LEAST_FOLLOWED, _FOLLOWED = 0.5, 0.95
#: Share of the fastest shaft's speed below which another's is noise about zero.
_NOISE = 0.05


def tips_too_fast(run: PoolRun, vehicle: Vehicle) -> Iterator[Problem]:
    """Say where the tips of a propeller would be faster than any under water."""
    across_m = {one.name: vehicle.propellers[one.propeller].diameter_m for one in vehicle.thrusters}
    for name, channel in run.channels.items():
        if channel.quantity != "shaft_speed":
            continue
        kept = channel.values[channel.timely()]
        wide = np.array([across_m.get(one.split(".", 1)[-1], 0.0) for one in channel.columns])
        tips = np.nan_to_num(np.abs(kept)) * wide * np.pi / 60.0
        fast = float(np.quantile(tips.max(axis=1), 0.9)) if kept.size else 0.0
        if fast > _FASTEST_TIP_MPS:
            yield run.place.warning(
                f"{name} ({channel.topic}) would move the tips of propellers at {fast:.3g} m/s, "
                "more than is possible under water: it is in another unit, or that of the motor's "
                "field (times the pole pairs).",
                remedy=CHECK_UNIT,
            )


def shafts_too_slow(run: PoolRun, table: RunTable, vehicle: Vehicle) -> Iterator[Problem]:
    """Say where a vehicle goes further in a turn than its propellers, driven hard, can screw."""
    names = set(thrusters_of(run, "shaft_speed")) & set(table.thrusters)
    if not names or not {"velocity", "command"} <= set(table.values):
        return
    command = np.nan_to_num(table.values["command"])
    low: dict[str, float] = {}
    for one in (one for one in vehicle.thrusters if one.name in names):
        at = table.thrusters.index(one.name)
        along = table.values["velocity"] @ np.array(one.direction) * np.sign(command[:, at])
        turns = np.abs(table.values["shaft_speed"][:, at]) / 60.0
        driven = np.abs(command[:, at]) > _HARD * np.abs(command).max()
        hard = driven & (turns > 0.0) & (along > _UNDER_WAY_MPS)
        width = vehicle.propellers[one.propeller].diameter_m
        advance = np.median(along[hard] / (turns[hard] * width)) if hard.sum() > _LEAST_ROWS else 0
        if advance > _MOST_ADVANCE:
            low[one.name] = float(advance)
    if low:
        yield run.place.warning(
            f"the shaft speed of {', '.join(low)} is too low: driven hard the vehicle goes "
            f"{max(low.values()):.2g} diameters of the propeller a turn, more than any screws. It, "
            "or the velocity, is in another unit.",
            remedy=CHECK_UNIT,
        )


def shafts_against_commands(run: PoolRun, table: RunTable) -> Iterator[Problem]:
    """Say where a shaft turns against its command, or does what another's command says."""
    shafts = thrusters_of(run, "shaft_speed")
    names = [one for one in thrusters_of(run, "command") if one in {*shafts} & {*table.thrusters}]
    if not names:
        return
    columns = [table.thrusters.index(name) for name in names]
    code = table.values["command"][:, columns]
    speed = table.values["shaft_speed"][:, columns]
    # a thruster that never leaves its dead zone turns as it likes
    effort = np.nanmax(np.abs(code), axis=0, initial=0.0)
    both = [i for i in range(len(columns)) if effort[i] > 0.25 * effort.max()]
    both = [i for i in both if not _idle(i, np.abs(code), np.abs(speed))]
    for i in both:
        rows = np.isfinite(code).all(axis=1) & np.isfinite(speed[:, i])
        what = _contradiction(code[rows, i], speed[rows, i])
        follows = _followed(code[rows], speed[rows, i])
        best = max(both, key=lambda j: follows[j])
        if not what and follows[i] < _LEAST_FOLLOWED and follows[best] > _FOLLOWED:
            what = f"it does not follow it (correlation {follows[i]:.2f})"
        if not what:
            continue
        better = [
            names[j]
            for j in both
            if j != i
            and not _contradiction(code[rows, j], speed[rows, i])
            and code[rows, j].std() > 0
            and follows[j] >= min(follows[best], _FOLLOWED)
        ]
        hint = f" It follows the command of {' or '.join(better)}." if len(better) == 1 else ""
        yield run.place.warning(
            f"the shaft speed of {names[i]} contradicts its command: {what}.{hint}",
            remedy="Check the order of the elements and the signs of both channels in "
            "vehicle.yaml.",
        )


def _followed(code: FloatArray, speed: FloatArray) -> list[float]:
    """Correlation of a shaft's speed (k,) with each command (k, n), both over a second.

    Of their sizes where that is more: a tachometer may not know the direction.
    """
    if len(speed) <= TABLE_HZ:
        return [0.0] * code.shape[1]
    found = []
    for one in code.T:
        pairs = [
            (_over_a_second(x), _over_a_second(y))
            for x, y in ((one, speed), (np.abs(one), np.abs(speed)))
        ]
        found.append(
            max(float(np.corrcoef(x, y)[0, 1]) if x.std() and y.std() else 0.0 for x, y in pairs)
        )
    return found


def _idle(i: int, code: FloatArray, speed: FloatArray) -> bool:
    """Tell whether a shaft reads noise about zero, at commands at which no other turns either."""
    fast = np.quantile(np.nan_to_num(speed), 0.95, axis=0)
    if fast[i] > _NOISE * fast.max():
        return False
    effort = np.nan_to_num(code[:, i]).max()
    others = np.delete(speed, i, axis=1)[np.abs(np.delete(code, i, axis=1) / effort - 0.9) < 0.2]
    turning = others[np.isfinite(others)]
    return bool(turning.size == 0 or np.median(turning) <= _NOISE * fast.max())


def _contradiction(code: FloatArray, speed: FloatArray) -> str:
    """Say how shaft speeds contradict commands; nothing where they agree or say little.

    A shaft takes up to a second to follow, and one command that is held says nothing of how its
    size follows: that is told by an interval, which short or steady runs leave wide.
    """
    largest = float(np.abs(code).max()) if code.size else 0.0
    driven = np.abs(code) > 0.3 * largest
    held = _held(np.sign(code) * driven)
    if code.size < 50 or held.sum() < 20:
        return ""
    fast = float(np.quantile(np.abs(speed), 0.95))
    if fast < 1.0:
        return "it stands still while it is commanded"
    turning = held & (np.abs(speed) > 0.1 * fast)
    if turning.sum() >= 20:
        against = float((np.sign(speed[turning]) != np.sign(code[turning])).mean())
        # a tachometer may not know the direction; noise about zero has both signs
        forward = float((speed[turning] > 0).mean())
        one_sided = forward < 0.01 or forward > 0.99
        if one_sided and (code[driven] < 0).any() and against < 0.9:
            against = 0.0
        if against > 0.3:
            return f"in {100 * against:.0f} % of the time it turns the other way"
    still = float((np.abs(speed[held]) < 0.05 * fast).mean())
    if still > 0.3:
        return f"in {100 * still:.0f} % of the time it stands still while it is commanded"
    effort, size = _over_a_second(np.abs(code) / largest), _over_a_second(np.abs(speed) / fast)
    if effort.std() > 0.05 and size.std() > 0:
        agreement = float(np.corrcoef(effort, size)[0, 1])
        if agreement < 0.3 and _highest_slope(effort, size) < _LEAST_SLOPE:
            return f"its size does not follow that of the command (correlation {agreement:.2f})"
    return ""


def _held(way: FloatArray) -> BoolArray:
    """Tell in which rows a thruster has been driven one way for a second."""
    rows = np.arange(way.size)
    changes = np.where(np.diff(way, prepend=way[:1]) != 0.0, rows, 0)
    since: IntArray = rows - np.maximum.accumulate(changes)
    return np.asarray((way != 0.0) & (since >= TABLE_HZ))


def _over_a_second(values: FloatArray) -> FloatArray:
    """Mean over a second, in which a shaft follows its command."""
    return np.convolve(values, np.full(round(TABLE_HZ), 1.0 / TABLE_HZ), mode="valid")


def _highest_slope(effort: FloatArray, size: FloatArray) -> float:
    """Upper end of a 95 % interval of the slope of `size` over `effort`.

    Neighbouring rows say the same: n (1 - a b) / (1 + a b) of n rows count, with the correlations
    a and b of one row with the next (Bartlett 1935).
    """
    x, y = effort - effort.mean(), size - size.mean()
    slope = float(x @ y / (x @ x))
    rest = y - slope * x
    alike = float(np.prod([one[1:] @ one[:-1] / max(one @ one, 1e-12) for one in (x, rest)]))
    freedom = x.size * (1.0 - alike) / (1.0 + alike) - 2.0
    if freedom <= 1.0:
        return np.inf
    return slope + 2.0 * float(np.sqrt(rest @ rest / (x @ x) / freedom))
