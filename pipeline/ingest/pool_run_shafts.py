"""What shaft speeds say of commands and of their own unit: suspicions, told and nothing else."""

from collections.abc import Iterator

import numpy as np

from pipeline.errors import Problem
from pipeline.ingest.pool_run_resample import thrusters_of
from pipeline.ingest.pool_run_score import SECOND, mean_over
from pipeline.ingest.pool_run_sizes import CHECK_UNIT
from pipeline.records.run_arrays import PoolRun
from pipeline.records.run_table import RunTable
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle

#: Twice as fast as those of the fastest thrusters. [m/s]
_FASTEST_TIP_MPS = 40.0
#: No screw pushes beyond its pitch, up to 1.6 diameters; share of the largest command; [m/s]
_MOST_ADVANCE, _HARD, _UNDER_WAY_MPS, _LEAST_ROWS = 1.8, 0.5, 0.3, 100
#: Correlations of a shaft's speed with its own command, also where another's is surely followed;
#: less of the largest command, as an autopilot trims it, does not tell whether a speed follows.
_NOT_FOLLOWED, _LEAST_FOLLOWED, _FOLLOWED, _LEAST_SWING = 0.3, 0.5, 0.95, 0.1
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
    """Say where a shaft turns, over a second, against its command, or by another's command."""
    shafts = thrusters_of(run, "shaft_speed")
    names = [one for one in thrusters_of(run, "command") if one in {*shafts} & {*table.thrusters}]
    if not names:
        return
    columns = [table.thrusters.index(name) for name in names]
    code, speed = (table.values[one][:, columns] for one in ("command", "shaft_speed"))
    largest = np.nanmax(np.abs(code), initial=0.0)
    slow = mean_over(code, SECOND)
    both = [at for at in range(len(names)) if slow[:, at].std() > _LEAST_SWING * largest]
    for at in (one for one in both if not _idle(one, np.abs(code), np.abs(speed))):
        rows = np.isfinite(code).all(axis=1) & np.isfinite(speed[:, at])
        follows = _followed(slow[rows], mean_over(speed[:, [at]], SECOND)[rows, 0])
        best = max(both, key=lambda one: follows[one])
        if follows[at] > (_LEAST_FOLLOWED if follows[best] > _FOLLOWED else _NOT_FOLLOWED):
            continue
        what = f"it does not follow it (correlation {follows[at]:.2f})"
        if follows[at] < -_LEAST_FOLLOWED:
            what = f"it turns the other way (correlation {follows[at]:.2f})"
        hint = ""
        if follows[best] > _FOLLOWED:
            hint = f" It follows the command of {names[best]}."
        yield run.place.warning(
            f"the shaft speed of {names[at]} contradicts its command: {what}.{hint}",
            remedy="Check the order of the elements and the signs of both channels in "
            "vehicle.yaml.",
        )


def _followed(code: FloatArray, speed: FloatArray) -> list[float]:
    """Correlation of a shaft's speed (k,) with each command (k, n).

    A tachometer may not know the direction: one that reads one way alone has sizes.
    """
    moving = speed[np.abs(speed) > _NOISE * np.abs(speed).max(initial=0.0)]
    if (moving > 0.0).all() or (moving < 0.0).all():
        code = np.where((code > 0.0).any(axis=0) & (code < 0.0).any(axis=0), np.abs(code), code)
    return [
        float(np.corrcoef(one, speed)[0, 1]) if one.std() and speed.std() else 0.0 for one in code.T
    ]


def _idle(at: int, code: FloatArray, speed: FloatArray) -> bool:
    """Tell whether a shaft reads noise about zero, at commands at which no other turns either."""
    fast = np.quantile(np.nan_to_num(speed), 0.95, axis=0)
    if fast[at] > _NOISE * fast.max():
        return False
    effort = np.nan_to_num(code[:, at]).max()
    others = np.delete(speed, at, axis=1)[np.abs(np.delete(code, at, axis=1) / effort - 0.9) < 0.2]
    turning = others[np.isfinite(others)]
    return bool(turning.size == 0 or np.median(turning) <= _NOISE * fast.max())
