"""What the page of a trial day is made of, and how its tables differ from those before."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from pipeline.records.day_diagnosis import DayDiagnosis
from pipeline.records.gains import PooledGain
from pipeline.records.glance import Glance
from pipeline.records.trial import DayTables, PageReceipt, SpeedChange, TrialDay
from pipeline.vehicle.schema import Vehicle

#: Codes that differ by less than this leave the firmware's output as it is.
ALIKE_CODES = 0.05


@dataclass(frozen=True)
class DayResults:
    """One day: its fit, those of the days before in order of time, its runs, the tables.

    `links` gives the address of each run's page, relative to this one.
    """

    vehicle: Vehicle
    day: str
    trial: TrialDay
    earlier: Mapping[str, TrialDay] = field(default_factory=dict)
    runs: tuple[PageReceipt, ...] = ()
    links: Mapping[str, str] = field(default_factory=dict)
    compared: tuple[PooledGain, ...] = ()
    """The day's gains against those of the last sound day before."""
    tables: DayTables | None = None
    tables_before: DayTables | None = None
    glance: Glance | None = None
    diagnosis: DayDiagnosis | None = None
    provenance: dict[str, str] = field(default_factory=dict)


def table_changes(before: DayTables, now: DayTables) -> tuple[SpeedChange, ...]:
    """Compare the codes of two days, speed by speed, over the thrusts that both reach.

    Parameters
    ----------
    before, now : DayTables
        Of two days.
    """
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
