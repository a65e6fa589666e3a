"""Compiled kernel: how the code of a thruster lags, by the closed form of a first-order lag.

The command is constant over a step, so the lag has a closed form; integrating it would tie the step
to the shortest lag. What lags is the code, or a power of its share beyond a dead zone. Where the
lag falls with the code it is that of half way between where a thruster is and where it goes to.
"""

from typing import Any, NamedTuple

import numpy as np

from pipeline.physics.parameters import MOST_THRUSTERS, offset
from pipeline.simulate.compiled import inlined, within

Array = Any

THRUSTER_COUNT = offset("thruster_count")
CODE_MAX = offset("code_max")
LAG = offset("lag")
DRIVE_DEAD = offset("drive_dead")
LAG_DEAD_SHARE = offset("lag_dead_share")
LAG_POWER = offset("lag_power")
LAG_FALL = offset("lag_fall")
ROTOR_INERTIA = offset("rotor_inertia")
#: Share of the largest code at which a lag is as stated, and the least at which it still rises: no
#: more than a step of a code, as thrusters of a large vehicle work at a hundredth of theirs.
STATED_AT, LEAST_SHARE = 0.5, 0.001


class Lags(NamedTuple):
    """Where the lagging thrusters are, and where they go to.

    `remaining` (3, 12): what is left of a distance at the start, the middle and the end of a step.
    Where it is not the code itself that lags: `now`, `aims` (12,), what lags at the start of the
    step and what it goes to, and `aimed` (12,), the codes that the aims belong to. `faster` (12,)
    is the stated lag over the one that there is, `step_s` (1,) the step.
    """

    remaining: Array
    now: Array
    aims: Array
    aimed: Array
    faster: Array
    step_s: Array


@within
def lags_at(p: Array, actuator: Array, dt: float) -> Lags:
    """Make the lags of a run of steps of dt that starts with `actuator` (12,)."""
    lags = Lags(
        remaining=np.ones((3, MOST_THRUSTERS)),
        now=np.zeros(MOST_THRUSTERS),
        aims=np.zeros(MOST_THRUSTERS),
        aimed=np.zeros(MOST_THRUSTERS),
        faster=np.ones(MOST_THRUSTERS),
        step_s=np.zeros(1),
    )
    set_step(p, dt, lags)
    begin_lags(p, actuator, lags)
    return lags


@inlined
def set_step(p: Array, dt: float, lags: Lags) -> None:
    """Work out what a first-order lag leaves of a difference in steps of dt."""
    lags.step_s[0] = dt
    for i in range(int(p[THRUSTER_COUNT])):
        set_remaining(p, i, lags)


@inlined
def set_remaining(p: Array, i: int, lags: Lags) -> None:
    """Work out what the lag of a thruster, as it is now, leaves of a difference."""
    tau = p[LAG + i]
    if tau > 0.0:
        half = np.exp(-0.5 * lags.step_s[0] * lags.faster[i] / tau)
        lags.remaining[1, i], lags.remaining[2, i] = half, half * half


@inlined
def lagging(code: float, dead: float, largest: float, power: float) -> float:
    """Return what of a code lags: a power of its share beyond `dead`, signed."""
    share = max(abs(code) - dead, 0.0) / (largest - dead)
    lags = share if power == 1.0 else share**power
    if code == 0.0:
        return 0.0
    return lags if code > 0.0 else -lags


@inlined
def code_lags(p: Array) -> bool:
    """Whether it is the code itself that lags."""
    return bool(p[LAG_DEAD_SHARE] == 0.0 and p[LAG_POWER] == 1.0 and p[LAG_FALL] == 0.0)


@inlined
def begin_lags(p: Array, actuator: Array, lags: Lags) -> None:
    """Set out from effective codes (12,)."""
    if code_lags(p):
        return
    for i in range(int(p[THRUSTER_COUNT])):
        dead = p[LAG_DEAD_SHARE] * p[DRIVE_DEAD + i]
        lags.now[i] = lagging(actuator[i], dead, p[CODE_MAX + i], p[LAG_POWER])
        lags.aims[i], lags.aimed[i] = 0.0, 0.0


@inlined
def aim_lags(p: Array, codes: Array, lags: Lags) -> None:
    """Aim at the codes (12,) of a step: a power is taken where a code is new, and only there."""
    if code_lags(p):
        return
    for i in range(int(p[THRUSTER_COUNT])):
        if codes[i] != lags.aimed[i]:
            dead = p[LAG_DEAD_SHARE] * p[DRIVE_DEAD + i]
            lags.aims[i] = lagging(codes[i], dead, p[CODE_MAX + i], p[LAG_POWER])
            lags.aimed[i] = codes[i]
        if p[LAG_FALL] != 0.0:
            # by the way it is on at the start of the step, then by that in its middle
            for row in range(2):
                now = lags.aims[i] + (lags.now[i] - lags.aims[i]) * lags.remaining[row, i]
                lags.faster[i] = faster(p, now, lags.aims[i])
                set_remaining(p, i, lags)


@inlined
def faster(p: Array, now: float, aim: float) -> float:
    """Return the stated lag over that of half way between where it is and where it goes to.

    Half way is such that J dn/dt = Q - k n|n| is met, through zero as well.
    """
    gap, half = abs(now - aim), abs(aim)
    if gap > 1e-6:
        half = 0.5 * abs(now * abs(now) - aim * abs(aim)) / gap
    # of powers of powers the logarithm is taken once
    share = max(np.log(half) / p[LAG_POWER], np.log(LEAST_SHARE))
    return float(np.exp(p[LAG_FALL] * (share - np.log(STATED_AT))))


@inlined
def end_lags(p: Array, lags: Lags) -> None:
    """Go to the end of a step."""
    if code_lags(p):
        return
    for i in range(int(p[THRUSTER_COUNT])):
        aim = lags.aims[i]
        lags.now[i] = aim + (lags.now[i] - aim) * lags.remaining[2, i]


@inlined
def late_code(p: Array, i: int, row: int, lags: Lags) -> float:
    """Code of thruster i at the time of a row of `remaining`, where it is no code that lags.

    What lags is where a first-order lag leaves it, and the code is the one that belongs to that.
    A share of the dead zone beyond its bounds, where only a fit goes, moves codes in the dead zone
    or next to it, so the thrust has no kink there, as long as no code is on either side of zero.
    """
    dead, largest, power = p[LAG_DEAD_SHARE] * p[DRIVE_DEAD + i], p[CODE_MAX + i], p[LAG_POWER]
    value = lags.aims[i] + (lags.now[i] - lags.aims[i]) * lags.remaining[row, i]
    if value == 0.0:
        return 0.0
    share = abs(value) if power == 1.0 else np.exp(np.log(abs(value)) / power)
    size = dead + share * (largest - dead)
    return size if value > 0.0 else -size


@inlined
def lagged(
    p: Array, start: Array, codes: Array, row: int, lags: Lags, first: int, state: Array
) -> None:
    """Set the lagged codes of a state some time after the start of a step, exactly.

    They are its entries from `first` on; row `row` of `remaining` belongs to the time. The
    exponentials are taken once a run, not once a thruster and step.
    """
    of_code = code_lags(p)
    for i in range(int(p[THRUSTER_COUNT])):
        if p[ROTOR_INERTIA + i] > 0.0:
            continue
        if p[LAG + i] <= 0.0:
            state[first + i] = codes[i]
        elif row == 0:
            # the step begins: it is where it is
            state[first + i] = start[first + i]
        elif of_code:
            late = (start[first + i] - codes[i]) * lags.remaining[row, i]
            state[first + i] = codes[i] + late
        else:
            state[first + i] = late_code(p, i, row, lags)
