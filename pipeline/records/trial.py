"""What is kept of a pool run and of a trial day: the run's table, its simulation, its fit."""

from typing import Literal

import numpy as np
from pydantic import Field

from pipeline.records.base import Glance, Record
from pipeline.records.gains import PooledGain, ThrusterGains
from pipeline.records.identification import IdentifiedParameter, VehicleIdentification
from pipeline.records.pool_run import PoolRunRecord

ManoeuvreName = Literal[
    "idle",
    "hover",
    "straight",
    "surge_steps",
    "surge_ramp",
    "coast_down",
    "zig_zag",
    "heading_steps",
    "spiral",
    "circle",
    "heave_steps",
    "pitch_steps",
    "roll_steps",
    "multisine",
    "chirp",
    "prbs",
    "free_decay",
    "mixed",
]

#: The model loses against the last value when its error is larger by this factor.
LOSES = 1.1
#: A larger log is not copied: the simulated channels then stand in a log of their own, which the
#: viewers open together with it.
LARGEST_OVERLAY_BYTES = 500_000_000
#: Errors below this many times the sensor's noise are the sensor's.
IN_THE_NOISE = 2.0


class ManoeuvreFound(Record):
    """A stretch of a run and what it was.

    `from_s`, `to_s` count from the start of the run's table.
    """

    name: ManoeuvreName
    from_s: float
    to_s: float
    sentence: str


class StoredRun(PoolRunRecord):
    """A log that was read: what `rig2sea check` says of it, and the file with its table."""

    run: str
    """Its name among the results; the log's name without its ending where that is a plain one."""
    day: str
    """UTC day of its first message, ``2026-05-04``."""
    table_rate_hz: float
    quantities: tuple[str, ...]
    notes_of_table: tuple[str, ...] = ()
    files: dict[str, str]
    """Path from the output folder -> SHA-256."""


class ChannelError(Record):
    """Measured less simulated in one channel, over the readings of the sensor, in `unit`.

    `sensor_noise` is the standard deviation that the vehicle file states for one reading (noise,
    slow error and offset together), None where it states none. `rmse_last_value` belongs to a
    forecast that holds the last reading before each window.
    """

    channel: str
    quantity: str
    unit: str
    readings: int
    sensor_noise: float | None
    rmse_windows: float
    mean_windows: float
    worst_windows: float
    worst_at_s: float
    rmse_last_value: float | None

    @property
    def over_noise(self) -> float | None:
        """Error over the windows in units of the sensor's noise."""
        return self.rmse_windows / self.sensor_noise if self.sensor_noise else None

    @property
    def loses(self) -> bool:
        """Whether holding the last reading forecasts the channel better than the model does.

        Not said of errors that are hardly more than the sensor's noise.
        """
        if self.rmse_last_value is None:
            return False
        over = self.over_noise
        in_noise = over is not None and over <= IN_THE_NOISE
        return not in_noise and self.rmse_windows > LOSES * self.rmse_last_value


class RunTrial(Record):
    """A pool run measured against the model; `why_not` says why nothing was simulated."""

    vehicle: str
    run: str
    day: str
    start_time_ns: int
    duration_s: float
    horizon_s: float | None = None
    lead_s: float | None = None
    windows: int = 0
    windows_left_out: int = 0
    without_commands_s: float = 0.0
    channels: tuple[ChannelError, ...] = ()
    manoeuvres: tuple[ManoeuvreFound, ...] = ()
    commands_at_limit: dict[str, float] = Field(default_factory=dict)
    """Thruster -> share of the time at the end of its range of codes."""
    why_not: str = ""
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    gains: ThrusterGains | None = None
    """Of this run alone, against the vehicle file."""
    why_no_gains: str = ""
    files: dict[str, str] = Field(default_factory=dict)


class RunUsed(Record):
    """A run, or the part of it, that the day's identification took."""

    run: str
    from_s: float
    to_s: float
    excitation: float
    """How much the commands change: root mean square over the axes, share of the range."""


class TrialDay(Record):
    """The runs of one day together."""

    vehicle: str
    day: str
    runs: tuple[str, ...]
    broken: tuple[str, ...] = ()
    """Runs whose log could not be read."""
    used: tuple[RunUsed, ...] = ()
    passed_over: tuple[str, ...] = ()
    """One sentence a run that the identification did without."""
    identification: VehicleIdentification | None = None
    why_not: str = ""
    notes: tuple[str, ...] = ()
    gains: ThrusterGains | None = None
    """Of all runs of the day, against the vehicle file and those that are called healthy."""
    sound_gains: tuple[PooledGain, ...] = ()
    """Over the day's runs that their notes call healthy: what later days are told against."""
    why_no_gains: str = ""

    @property
    def settled(self) -> bool:
        """Whether there is no fit whose values are not to be used."""
        return self.identification is None or self.identification.converged


class DayTables(Record):
    """The firmware tables in force on a trial day: codes over thrust and speed."""

    vehicle: str
    day: str
    speed_mps: tuple[float, ...] = ()
    thrust_n: tuple[float, ...] = ()
    code: tuple[tuple[float | None, ...], ...] = ()
    """For each speed a code for each thrust; None beyond what the tables reach."""
    tables_sha256: str = ""
    why_not: str = ""


class SpeedChange(Record):
    """How the codes of one speed differ between two trial days."""

    speed_mps: float
    largest_codes: float
    at_thrust_n: float
    mean_codes: float
    thrusts: int


class RunLine(Record):
    """A run as other pages name it: `page` is a path from the output folder."""

    name: str
    line: str
    page: str
    glance: Glance | None = None


class PageReceipt(Record):
    """A page of a run or a day, and what other pages say of it.

    The page of a run is completed once its day is diagnosed: `files` of a run has the page as it
    was written first, `page` is where readers find it.
    """

    kind: Literal["run", "day"]
    name: str
    files: dict[str, str]
    title: str
    errors: int
    warnings: int
    line: str
    """What there is to say of it in one line."""
    page: str = ""
    """Path from the output folder; the first of `files` where it is empty."""
    glance: Glance | None = None
    manoeuvres: tuple[str, ...] = ()
    """Of a run: what was flown, each once."""
    runs: tuple[RunLine, ...] = ()
    parameters: tuple[IdentifiedParameter, ...] = ()
    """Of a day: what its runs tell, for the trend on the vehicle's page."""
    gains: tuple[PooledGain, ...] = ()
    """Of a day: what its thrusters gave, for the table on the vehicle's page."""
    settled: bool = True
    """Of a day: false where its fit did not settle, so that its parameters are not to be used."""

    @property
    def address(self) -> str:
        """Path of the page from the output folder."""
        return self.page or next(iter(self.files))


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
