"""How far the thruster tables of one trial day are from those of another."""

import numpy as np

from pipeline.records.trial import DayTables, SpeedChange

#: Codes that differ by less than this leave the firmware's output as it is.
ALIKE_CODES = 0.05


def table_changes(before: DayTables, now: DayTables) -> tuple[SpeedChange, ...]:
    """Compare the codes of two days, speed by speed, over the thrusts that both reach."""
    found = []
    thrust = np.array(now.thrust_n)
    for speed, row in zip(now.speed_mps, now.code, strict=True):
        if speed not in before.speed_mps:
            continue
        old_row = before.code[before.speed_mps.index(speed)]
        old = np.array([np.nan if one is None else one for one in old_row], float)
        new = np.array([np.nan if one is None else one for one in row], float)
        if before.thrust_n != now.thrust_n:
            # NaN outside: interpolation next to it is NaN, too
            old = np.interp(thrust, np.array(before.thrust_n), old, left=np.nan, right=np.nan)
        gap = np.abs(new - old)
        both = np.isfinite(gap)
        if not both.any():
            continue
        worst = int(np.nanargmax(gap))
        found.append(
            SpeedChange(
                speed_mps=speed,
                largest_codes=float(gap[worst]),
                at_thrust_n=float(thrust[worst]),
                mean_codes=float(np.mean(gap[both])),
                thrusts=int(both.sum()),
            )
        )
    return tuple(found)
