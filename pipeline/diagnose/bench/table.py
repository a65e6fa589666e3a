"""A new mooring table as the bench diagnosis uses it: one line a code, and how far it scatters."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pipeline.diagnose.bench.model import ThrusterAtRest
from pipeline.errors import CannotComputeError
from pipeline.records.measurements import MooringPoint
from pipeline.types import BoolArray, FloatArray
from pipeline.vehicle.bench_schema import VOLTAGE_TOLERANCE

#: Codes of each sign that a diagnosis needs where the model gives thrust.
FEWEST_CODES = 5
#: Thrust that counts, of the largest of the model.
_CLEAR = 0.02
#: A table that reads this many times the model's thrust is of another thruster, or another unit.
_OTHER_THRUSTER = 3.0
#: The least scatter that is believed, of the largest reading.
_LEAST_SCATTER = 0.001
#: Codes of a sign from which their steps are small.
_CLOSE = 15
_FIELDS = {
    "thrust": "thrust_n",
    "shaft_speed": "shaft_speed_rpm",
    "current": "current_a",
    "voltage": "voltage_v",
}


@dataclass(frozen=True)
class BenchTable:
    """Readings averaged by code: `code` (n,) rising, `mean[channel]` (n,), `count` (n,).

    `scatter[channel]` (n,) is the standard deviation of one reading. `offset_n` is how well the
    zero of the force sensor is known. `partly` tells of channels that were read at some codes
    alone, and so take no part, at how many.
    """

    name: str
    code: FloatArray
    count: FloatArray
    mean: dict[str, FloatArray]
    scatter: dict[str, FloatArray]
    offset_n: float
    partly: Mapping[str, int] = field(default_factory=dict)

    @property
    def channels(self) -> tuple[str, ...]:
        """Channels that can be compared."""
        return tuple(self.mean)

    def part(self, chosen: BoolArray) -> "BenchTable":
        """Return the table at some of its codes."""
        mean = {channel: values[chosen] for channel, values in self.mean.items()}
        scatter = {channel: values[chosen] for channel, values in self.scatter.items()}
        return replace(
            self, code=self.code[chosen], count=self.count[chosen], mean=mean, scatter=scatter
        )


def bench_table(
    points: Sequence[MooringPoint],
    model: ThrusterAtRest,
    *,
    name: str,
    tare_drift_n: float | None = None,
    without: Sequence[str] = (),
) -> BenchTable:
    """Average the readings of a new table by code.

    Parameters
    ----------
    points : sequence of MooringPoint
        As read; marked ones are left out.
    model : ThrusterAtRest
        What they are to be compared with; a channel that it lacks is left out.
    name : str
        What messages call the table.
    tare_drift_n : float, optional
        Largest change of the reading at code 0. [N]
    without : sequence of str
        Channels to leave out.

    Raises
    ------
    CannotComputeError
        With too few codes, one sign only, several supply voltages, or the thrust of another
        thruster.
    """
    used = [p for p in points if not p.marks and p.code != 0.0]
    code = np.unique([p.code for p in used])
    of_code = [[p for p in used if p.code == c] for c in code]
    _check(code, of_code, model, name)
    mean: dict[str, FloatArray] = {}
    scatter: dict[str, FloatArray] = {}
    partly: dict[str, int] = {}
    for channel, reference in model.channels.items():
        readings = [
            [v for v in (getattr(p, _FIELDS[channel]) for p in row) if v is not None]
            for row in of_code
        ]
        read = sum(bool(row) for row in readings)
        if 0 < read < code.size:
            partly[channel] = read
        if read < code.size or channel in without:
            continue
        mean[channel] = np.array([float(np.mean(row)) for row in readings])
        own = np.array([len(row) for row in readings], float)
        scatter[channel] = _scatter(
            mean[channel] - reference.at(code), readings, own, code, reference.at(code)
        )
    largest = model.thrust_max_n
    offset = max(0.002 * largest, 0.5 * (tare_drift_n or 0.0))
    count = np.array([len(row) for row in of_code], float)
    return BenchTable(name, code, count, mean, scatter, offset, partly)


def _check(
    code: FloatArray, of_code: list[list[MooringPoint]], model: ThrusterAtRest, name: str
) -> None:
    expected = np.abs(model.channels["thrust"].at(code)) if code.size else np.zeros(0)
    live = code[expected > _CLEAR * model.thrust_max_n]
    counts = {"negative": int(np.sum(live < 0)), "positive": int(np.sum(live > 0))}
    missing = [sign for sign, number in counts.items() if not number]
    if len(missing) == 1 and max(counts.values()) >= FEWEST_CODES:
        raise CannotComputeError(
            f"{name}: no {missing[0]} code beyond the dead zone was measured, so a loss in one "
            "direction cannot be told from one in both. Measure codes of both signs."
        )
    if min(counts.values()) < FEWEST_CODES:
        raise CannotComputeError(
            f"{name}: {counts['positive']} positive and {counts['negative']} negative codes where "
            f"the model gives thrust; at least {FEWEST_CODES} of each sign are needed. Measure "
            f"more codes up to {model.code_max:g}, or check that the table is of {model.name} and "
            "its codes are the vehicle's."
        )
    measured = np.array([np.mean([p.thrust_n for p in row]) for row in of_code])
    clear = expected > 0.2 * model.thrust_max_n
    ratio = float(np.median(np.abs(measured[clear]) / expected[clear])) if clear.any() else 1.0
    same_sign = np.sum(np.sign(measured[clear]) == np.sign(code[clear])) if clear.any() else 1
    if ratio > _OTHER_THRUSTER:
        raise CannotComputeError(
            f"{name}: the thrust is {ratio:.1f} times that of {model.name} at the same codes. No "
            "effect of the library does that: the table is of another thruster, or its unit of "
            "force or its codes are not what was read; see `rig2sea check`."
        )
    if clear.any() and same_sign < 0.5 * clear.sum():
        raise CannotComputeError(
            f"{name}: the thrust points the other way than at the codes of {model.name}. Turn the "
            "sign of the thrust column round (columns: mooring: of vehicle.yaml)."
        )
    volts = [p.voltage_v for row in of_code for p in row if p.voltage_v is not None]
    if volts and np.ptp(_by_sheet(of_code)) > 2 * VOLTAGE_TOLERANCE * float(np.median(volts)):
        raise CannotComputeError(
            f"{name}: the sheets were taken at supply voltages from {min(volts):g} to "
            f"{max(volts):g} V; one diagnosis takes one of them. Give each as a file of its own."
        )


def _by_sheet(of_code: list[list[MooringPoint]]) -> FloatArray:
    """Median voltage of each sheet: a supply that sags under load is one voltage."""
    volts: dict[tuple[str, str | None], list[float]] = {}
    for row in of_code:
        for p in row:
            if p.voltage_v is not None:
                volts.setdefault((p.source.file, p.source.sheet), []).append(p.voltage_v)
    return np.array([np.median(values) for values in volts.values()])


def _scatter(
    residual: FloatArray,
    readings: list[list[float]],
    count: FloatArray,
    code: FloatArray,
    expected: FloatArray,
) -> FloatArray:
    """Scatter of one reading by code, from what no smooth cause can do: jumps from code to code.

    Robust second differences of the residual (Gasser, Sroka and Jennen-Steinmetz 1986), and the
    spread of readings at one code, a constant part and one in proportion to the reading; never the
    size of the residual itself, which would hide the effect that is looked for.
    """
    largest = float(np.abs(expected).max())
    least, most = _LEAST_SCATTER * largest, 0.03 * largest
    at, jumps = [np.zeros(0)], [np.zeros(0)]
    within = [i for i, row in enumerate(readings) if len(row) > 1]
    at.append(np.abs(expected[within]))
    jumps.append(np.array([np.std(readings[i], ddof=1) for i in within]))
    for sign in (-1, 1):
        side = sign * code > 0
        x, y, n = code[side], residual[side], count[side]
        # wide steps of code let a smooth cause jump too
        if x.size < _CLOSE:
            continue
        a = (x[2:] - x[1:-1]) / (x[2:] - x[:-2])
        size = np.sqrt(a**2 / n[:-2] + (1 - a) ** 2 / n[2:] + 1.0 / n[1:-1])
        jumps.append(np.abs(a * y[:-2] + (1 - a) * y[2:] - y[1:-1]) / size)
        at.append(np.abs(expected[side])[1:-1])
    level, jump = np.concatenate(at), np.concatenate(jumps)
    low = level < 0.3 * largest
    constant = float(np.clip(_spread(jump[low]), least, most))
    share = float(np.clip(_spread(jump[~low] / level[~low]), 0.0, 0.03))
    return np.asarray(np.hypot(constant, share * np.abs(expected)))


def _spread(sizes: FloatArray) -> float:
    """Return the standard deviation from the upper quartile, sound with wild readings."""
    return float(np.quantile(sizes, 0.75)) / 1.15 if sizes.size >= 4 else 0.0
