r"""How far a healthy thruster's mooring test may be from the model: one covariance a channel.

.. math:: C = \sigma^2 / m + \sigma_s^2 f f^T + \sigma_0^2 11^T + \sigma_d^2 f' f'^T
              + R \circ a a^T + \kappa^2 R \circ \Delta \Delta^T

scatter of m readings, scale of the sensor, its zero, the edge of the dead zone, smooth shape error
(a: standard error of the model and repeatability between tests, R: Matern 3/2 along the code, the
signs apart), and, where an effect moves the prediction by Delta, the share kappa by which the
effect's own law is wrong. The scale, zero and edge are nuisances integrated out exactly
(Rasmussen and Williams 2006, section 2.7).
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pipeline.diagnose.bench.effects import free_share
from pipeline.diagnose.bench.model import ThrusterAtRest
from pipeline.diagnose.bench.table import BenchTable
from pipeline.types import FloatArray

#: Standard deviation of a sensor's scale: a load cell and its lever 2 %, a tachometer 1 % and the
#: spread of motors, a current probe 4 %, a voltmeter and its leads 1.5 %.
SCALE = {"thrust": 0.02, "shaft_speed": 0.015, "current": 0.04, "voltage": 0.015}
#: Shape error of the other channels, share of the reading.
_SHAPE = {"shaft_speed": 0.015, "current": 0.05, "voltage": 0.007}
#: Share of its own change by which an effect's law is wrong. Of `voltage_sag` more: the thrust of
#: a measured thruster at six supply voltages departs from its law by 5 to 40 % of the change.
LAW_ERROR, SAG_LAW_ERROR = 0.08, 0.15
#: Length over which shape errors keep together, share of the largest code.
LENGTH = 0.25
#: Resolution of an instrument, share of its largest reading.
_READING = 0.001
#: Kinks of a drive's map: readings at neighbouring codes are no independent witnesses.
_KINKS, _NEAR = 0.002, 0.06
#: Edge of the dead zone, share of the largest code: one code in 127.
_EDGE = 0.008
#: `unknown`: a departure of any smooth shape, share of the thrust and of the largest thrust.
UNKNOWN_SHARE = (0.25, 0.03)


@dataclass(frozen=True)
class Stack:
    """All channels of a table one after the other: slices into a vector of readings."""

    channels: tuple[str, ...]
    slices: dict[str, slice]
    measured: FloatArray

    @classmethod
    def of(cls, table: BenchTable) -> "Stack":
        """Stack a table."""
        n = table.code.size
        where = {name: slice(i * n, (i + 1) * n) for i, name in enumerate(table.channels)}
        return cls(table.channels, where, np.concatenate([table.mean[c] for c in table.channels]))

    def join(self, by_channel: dict[str, FloatArray]) -> FloatArray:
        """Stack a prediction."""
        return np.concatenate([by_channel[name] for name in self.channels])


def smooth(code: FloatArray, code_max: float, *, length: float = LENGTH) -> FloatArray:
    """Correlation (n, n) along the code: Matern 3/2, none between the signs.

    >>> smooth(np.array([-100.0, 100.0]), 127.0).tolist()
    [[1.0, 0.0], [0.0, 1.0]]
    """
    apart = np.sqrt(3.0) * np.abs(code[:, None] - code[None, :]) / (length * code_max)
    same = np.sign(code)[:, None] == np.sign(code)[None, :]
    return np.asarray(np.where(same, (1.0 + apart) * np.exp(-apart), 0.0))


def healthy(model: ThrusterAtRest, table: BenchTable) -> dict[str, FloatArray]:
    """Covariance (n, n) of each channel when nothing is wrong."""
    code = table.code
    shape = smooth(code, model.code_max)
    near = smooth(code, model.code_max, length=_NEAR)
    grown = np.zeros(code.size)
    found: dict[str, FloatArray] = {}
    for channel in table.channels:
        reference = model.channels[channel]
        value = reference.at(code)
        covariance = np.diag(table.scatter[channel] ** 2 / table.count)
        covariance += np.diag(np.full(code.size, (_READING * np.abs(reference.value).max()) ** 2))
        covariance += SCALE[channel] ** 2 * np.outer(value, value)
        if channel == "thrust":
            step = 0.005 * model.code_max
            slope = (reference.at(code + step) - reference.at(code - step)) / (2.0 * step)
            edge = _EDGE * model.code_max * slope * np.sign(code)
            covariance += table.offset_n**2 + np.outer(edge, edge)
            grown = 0.25 * model.thrust_max_n + 0.75 * np.abs(value)
            amplitude = np.hypot(model.repeatability * grown, reference.std_at(code))
        else:
            amplitude = _SHAPE[channel] * np.abs(value)
            amplitude = np.hypot(amplitude, 0.003 * float(np.abs(reference.value).max()))
        covariance += shape * np.outer(amplitude, amplitude)
        kinks = _KINKS * (grown if channel == "thrust" else np.abs(value))
        covariance += near * np.outer(kinks, kinks)
        found[channel] = covariance
    return found


def law_share(values: Mapping[tuple[str, str], float]) -> float:
    """Return the share of its change by which the law of the effects at work is wrong."""
    return SAG_LAW_ERROR if any(effect == "voltage_sag" for effect, _ in values) else LAW_ERROR


def law_error(
    model: ThrusterAtRest,
    table: BenchTable,
    values: Mapping[tuple[str, str], float],
    before: dict[str, FloatArray],
    after: dict[str, FloatArray],
    *,
    departure: dict[str, FloatArray],
) -> dict[str, FloatArray]:
    """Covariance that an effect brings with it, by channel; `departure` as of `departures`."""
    # Without end smooth: a law is wrong in its exponents, and must not take up the scatter.
    apart = (table.code[:, None] - table.code[None, :]) / (2.0 * LENGTH * model.code_max)
    shape = np.exp(-0.5 * apart**2) * (smooth(table.code, model.code_max) > 0.0)
    found: dict[str, FloatArray] = {}
    for channel in table.channels:
        moved, seen = after[channel] - before[channel], departure[channel]
        # not more than is seen, and the same way: overshooting is no excuse for being off
        moved = law_share(values) * np.clip(moved * np.sign(seen), 0.0, np.abs(seen))
        found[channel] = shape * np.outer(moved, moved)
        free = free_share(values, channel, table.code)
        if free.any():
            followed = free * before[channel]
            found[channel] = found[channel] + np.outer(followed, followed)
    return found


def departures(table: BenchTable, before: dict[str, FloatArray]) -> dict[str, FloatArray]:
    """Measured departure by channel, smoothed over five codes of a sign."""
    found: dict[str, FloatArray] = {}
    for channel in table.channels:
        size = np.zeros(table.code.size)
        for sign in (-1.0, 1.0):
            side = np.flatnonzero(np.sign(table.code) == sign)
            gap = table.mean[channel][side] - before[channel][side]
            for i in range(side.size):
                near = gap[max(0, i - 2) : i + 3]
                size[side[i]] = float(np.mean(near))
        found[channel] = size
    return found


def anything(model: ThrusterAtRest, table: BenchTable) -> dict[str, FloatArray]:
    """Covariance of `unknown`: a smooth departure of any shape in every channel."""
    shape = smooth(table.code, model.code_max)
    found: dict[str, FloatArray] = {}
    for channel in table.channels:
        reference = model.channels[channel]
        if channel == "voltage":
            # a supply that is off has a name: it is never a departure of unknown cause
            found[channel] = np.zeros(shape.shape)
            continue
        share, floor = UNKNOWN_SHARE
        size = share * np.abs(reference.at(table.code))
        size = size + floor * float(np.abs(reference.value).max())
        # half of it goes along both signs alike: another propeller, another unit
        found[channel] = 0.5 * shape * np.outer(size, size)
        other = size * np.sign(table.code)
        both = smooth(np.abs(table.code), model.code_max, length=2.0 * LENGTH)
        found[channel] += 0.5 * both * np.outer(other, other)
    return found
